//! The library is valid WGSL, and naga converts it to the languages of other engines.

use std::ffi::OsString;
use std::process::Command;
use vellus_gpu::{
    ConvertError, FAR_FIELD, Field, Functions, Language, converted, glsl_include, hlsl_include, shader_library,
};
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

/// What a kernel calls.
const KERNELS: [&str; 3] = ["near", "far", "reduced"];

/// The text that a kernel includes.
fn functions(kernel: &str) -> Functions {
    if kernel == "reduced" { Functions::Reduced } else { Functions::All }
}

/// A kernel that calls the functions of the text to include. Accessors are before and after it.
fn kernel(kernel: &str, include: &str, vector: &str, [head, main, answer]: [&str; 3]) -> String {
    let accessor =
        |name: &str| format!("{vector}4 {name}(uint row) {{ return {vector}4(0.0, 0.5, 0.5, float(row)); }}");
    let [table, row, far] = ["vellus_table", "vellus_row", "vellus_far_row"].map(accessor);
    let sample = |part: &str, hit: &str| {
        format!(
            "VellusHit hit;
            vellus_{hit};
            value = vellus_{part}eval(hit, w);
            VellusSample drawn = vellus_{part}sample(hit, value);
            value = value + {vector}4(drawn.weight, drawn.pdf) + {vector}4(vellus_energy(hit).rgb[0], 0.0);"
        )
    };
    let (table, last, calls) = match kernel {
        "near" => (table, row, sample("", "hit_colored(hit, 0u, 66u, vellus_coat_pigment(66u, w), w, 0.5)")),
        "far" => (table, row + &far, sample("far_", "far_hit(hit, 0u, 0u, w)")),
        _ => (
            String::new(),
            String::new(),
            format!(
                "VellusFur fur;
                fur.eta = 1.5; fur.kappa = 0.5; fur.alpha = 0.0; fur.beta_m = 0.1; fur.beta_n = 0.1; fur.layers = 1.0;
                fur.sigma_ms = 1.0; fur.g = 0.5; fur.pigment.cortex = w; fur.pigment.medulla = w;
                VellusReduced hit;
                vellus_reduced_hit(hit, fur, w);
                value = {vector}4(vellus_reduced_eval(hit, w) + vellus_reduced_energy(hit), 0.0);"
            ),
        ),
    };
    format!(
        "{head}
        {table}
        {include}
        {last}
        {main} {{
            {vector}3 w = {vector}3(0.0, 0.6, 0.8);
            {vector}4 value;
            {calls}
            {answer}
        }}"
    )
}

/// Compiles all kernels with a compiler, if it is there. The first argument is the name of the file.
fn compile(
    found: Option<OsString>,
    arguments: &[&str],
    text: impl Fn(&str) -> Result<String, ConvertError>,
) -> Result<(), Box<dyn std::error::Error>> {
    let Some(program) = found else { return Ok(()) };
    let folder = tempfile::tempdir()?;
    for kernel in KERNELS {
        std::fs::write(folder.path().join(arguments[0]), text(kernel)?)?;
        let mut command = Command::new(&program);
        command.current_dir(folder.path()).args(arguments);
        let output = command.run()?;
        let text = [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat();
        assert!(output.status.success(), "{kernel}: {command:?}: {text}");
    }
    Ok(())
}

#[test]
fn glslang_compiles_the_include() -> Result<(), Box<dyn std::error::Error>> {
    let head = "#version 450
        layout(local_size_x = 1) in;
        layout(std430, binding = 0) buffer Answer { vec4 answer; };";
    let parts = [head, "void main()", "answer = value;"];
    let program = "glslangValidator";
    let found = need("shader-compilers", succeeds(Command::new(program).arg("--version")).map(|()| program.into()));
    let text = |name: &str| Ok(kernel(name, &glsl_include(functions(name))?, "vec", parts));
    compile(found, &["kernel.comp", "-V", "-o", "/dev/null"], text)
}

/// With Slang's compiler and with Microsoft's. glslang reads HLSL, too, but not `(float[7])0`, which naga writes.
#[test]
fn hlsl_compilers_compile_the_include() -> Result<(), Box<dyn std::error::Error>> {
    let main = "[numthreads(1, 1, 1)] void run()";
    let parts = ["RWByteAddressBuffer answer : register(u0);", main, "answer.Store4(0, asuint(value));"];
    let text = |name: &str| Ok(kernel(name, &hlsl_include(functions(name))?, "float", parts));
    let slang =
        ["kernel.hlsl", "-lang", "slang", "-target", "hlsl", "-stage", "compute", "-entry", "run", "-o", "/dev/null"];
    compile(crate::ports::slangc(), &slang, text)?;
    let dxc = need("dxc", succeeds(Command::new("dxc").arg("--version")).map(|()| "dxc".into()));
    compile(dxc, &["kernel.hlsl", "-T", "cs_6_0", "-E", "run", "-Fo", "/dev/null"], text)
}
