//! The library is valid WGSL, and naga converts it to the languages of other engines.

use std::process::Command;
use vellus_gpu::{FAR_FIELD, Field, Language, converted, shader_library};
use vellus_testing::program::Limited;
use vellus_testing::{need, succeeds};

#[test]
fn the_library_has_no_bindings_and_no_entry_points() {
    let source = format!(
        "{}{FAR_FIELD}
        fn vellus_far_row(row: u32) -> vec4<f32> {{ return vec4<f32>(); }}
        fn vellus_table(row: u32) -> vec4<f32> {{ return vec4<f32>(); }}
        fn vellus_row(row: u32) -> vec4<f32> {{ return vec4<f32>(); }}",
        shader_library()
    );
    let module = naga::front::wgsl::parse_str(&source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&source)));
    assert!(module.entry_points.is_empty());
    assert!(module.global_variables.is_empty());
    let names = module.functions.iter().filter_map(|(_, function)| function.name.as_deref());
    let names = names.chain(module.types.iter().filter_map(|(_, ty)| ty.name.as_deref()));
    let names: Vec<&str> = names.chain(module.constants.iter().filter_map(|(_, c)| c.name.as_deref())).collect();
    let foreign = names.iter().find(|name| !name.to_lowercase().starts_with("vellus_") && !name.starts_with("Vellus"));
    assert_eq!(foreign, None, "a name may be that of another part of the shader");
    assert!(names.len() > 80, "{}", names.len());
}

#[test]
fn every_language_has_the_functions() -> Result<(), vellus_gpu::ConvertError> {
    let functions = ["vellus_hit", "vellus_eval", "vellus_sample", "vellus_energy"];
    let far = ["vellus_far_hit", "vellus_far_eval", "vellus_far_sample", "vellus_energy"];
    for (field, functions) in [(Field::Near, functions), (Field::Far, far)] {
        for language in Language::ALL {
            let bytes = converted(language, field)?;
            println!("{field:?} {language:?}: {} bytes", bytes.len());
            if language == Language::SpirV {
                assert_eq!(bytes[..4], 0x0723_0203u32.to_le_bytes(), "the magic number of SPIR-V");
                continue;
            }
            let text = String::from_utf8_lossy(&bytes);
            // GLSL calls every entry point `main`.
            let entry = if language == Language::Glsl { "main" } else { field.entry() };
            for name in functions.into_iter().chain([entry]) {
                assert!(text.contains(&format!("{name}(")), "{field:?} {language:?} lacks {name}");
            }
        }
    }
    Ok(())
}

/// Other compilers accept the files: glslang and SPIRV-Tools, where they are installed.
#[test]
fn other_compilers_accept_the_files() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let compilers = [
        (Language::Glsl, "glslangValidator", ["-G", "-o", "/dev/null"].as_slice()),
        (Language::SpirV, "spirv-val", &["--target-env", "vulkan1.1"]),
    ];
    for (language, program, arguments) in compilers {
        if need("shader-compilers", succeeds(Command::new(program).arg("--version"))).is_none() {
            continue;
        }
        for field in [Field::Near, Field::Far] {
            let path = folder.path().join(format!("vellus.{}", language.extension()));
            std::fs::write(&path, converted(language, field)?)?;
            let output = Command::new(program).args(arguments).arg(&path).run()?;
            let text = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat();
            assert!(output.status.success(), "{program}: {text}");
        }
    }
    Ok(())
}
