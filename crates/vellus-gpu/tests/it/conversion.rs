//! The library is valid WGSL, and naga converts it to the languages of other engines.

use std::ffi::OsString;
use std::process::Command;
use vellus_gpu::{FAR_FIELD, Field, Language, converted, glsl_include, hlsl_include, shader_library};
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
    let functions = ["vellus_hit", "vellus_hit_colored", "vellus_eval", "vellus_sample", "vellus_energy"];
    let far = ["vellus_far_hit", "vellus_far_eval", "vellus_far_sample", "vellus_energy"];
    for (field, functions) in [(Field::Near, functions.as_slice()), (Field::Far, &far)] {
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
            for name in functions.iter().copied().chain([entry]) {
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

/// A kernel that calls the functions of the text to include. Accessors are before and after it.
fn kernel(include: &str, vector: &str, [head, main, answer]: [&str; 3], far: bool) -> String {
    let accessor =
        |name: &str| format!("{vector}4 {name}(uint row) {{ return {vector}4(0.0, 0.5, 0.5, float(row)); }}");
    let (hit, part, last) = if far {
        ("far_hit(hit, 0u, 0u, w);", "far_", accessor("vellus_far_row"))
    } else {
        ("hit_colored(hit, 0u, 66u, vellus_coat_pigment(66u, w), w, 0.5);", "", String::new())
    };
    let (table, row) = (accessor("vellus_table"), accessor("vellus_row"));
    format!(
        "{head}
        {table}
        {include}
        {row}
        {last}
        {main} {{
            {vector}3 w = {vector}3(0.0, 0.6, 0.8);
            VellusHit hit;
            vellus_{hit}
            {vector}4 value = vellus_{part}eval(hit, w);
            VellusSample drawn = vellus_{part}sample(hit, value);
            value = value + {vector}4(drawn.weight, drawn.pdf) + {vector}4(vellus_energy(hit).rgb[0], 0.0);
            {answer}
        }}"
    )
}

/// Compiles kernels of both fields with a compiler, if it is there. The first argument is the name of the file.
fn compile(found: Option<OsString>, arguments: &[&str], kernel: impl Fn(bool) -> String) -> std::io::Result<()> {
    let Some(program) = found else { return Ok(()) };
    let folder = tempfile::tempdir()?;
    for far in [false, true] {
        std::fs::write(folder.path().join(arguments[0]), kernel(far))?;
        let mut command = Command::new(&program);
        command.current_dir(folder.path()).args(arguments);
        let output = command.run()?;
        let text = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat();
        assert!(output.status.success(), "{command:?}: {text}");
    }
    Ok(())
}

#[test]
fn glslang_compiles_the_include() -> Result<(), Box<dyn std::error::Error>> {
    let include = glsl_include()?;
    let head = "#version 450
        layout(local_size_x = 1) in;
        layout(std430, binding = 0) buffer Answer { vec4 answer; };";
    let parts = [head, "void main()", "answer = value;"];
    let program = "glslangValidator";
    let found = need("shader-compilers", succeeds(Command::new(program).arg("--version")).map(|()| program.into()));
    compile(found, &["kernel.comp", "-V", "-o", "/dev/null"], |far| kernel(&include, "vec", parts, far))?;
    Ok(())
}

/// With Slang's compiler and with Microsoft's. glslang reads HLSL, too, but not `(float[7])0`, which naga writes.
#[test]
fn hlsl_compilers_compile_the_include() -> Result<(), Box<dyn std::error::Error>> {
    let include = hlsl_include()?;
    let main = "[numthreads(1, 1, 1)] void run()";
    let parts = ["RWByteAddressBuffer answer : register(u0);", main, "answer.Store4(0, asuint(value));"];
    let kernel = |far| kernel(&include, "float", parts, far);
    let slang =
        ["kernel.hlsl", "-lang", "slang", "-target", "hlsl", "-stage", "compute", "-entry", "run", "-o", "/dev/null"];
    compile(crate::ports::slangc(), &slang, kernel)?;
    let dxc = need("dxc", succeeds(Command::new("dxc").arg("--version")).map(|()| "dxc".into()));
    compile(dxc, &["kernel.hlsl", "-T", "cs_6_0", "-E", "run", "-Fo", "/dev/null"], kernel)?;
    Ok(())
}
