//! The library in other shading languages.

use crate::library::{FAR_FIELD, Field, reduced_library, shader_library};
use naga::back::{glsl, hlsl, msl, spv};
use naga::proc::BoundsCheckPolicies;
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{ResourceBinding, ShaderStage};

/// A shading language.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// GLSL 4.30, for OpenGL and, with other bindings, Vulkan.
    Glsl,
    /// HLSL, shader model 6.0, for DirectX 12 and Unreal Engine. It is also Slang.
    Hlsl,
    /// The Metal Shading Language 2.4.
    Msl,
    /// SPIR-V 1.3, for Vulkan.
    SpirV,
}

impl Language {
    /// All languages.
    pub const ALL: [Language; 4] = [Language::Glsl, Language::Hlsl, Language::Msl, Language::SpirV];

    /// The usual ending of a file's name.
    pub fn extension(self) -> &'static str {
        match self {
            Language::Glsl => "comp",
            Language::Hlsl => "hlsl",
            Language::Msl => "metal",
            Language::SpirV => "spv",
        }
    }
}

/// The compiler of shaders refused the text.
#[derive(Debug, thiserror::Error)]
#[error("the shader cannot be converted: {0}")]
pub struct ConvertError(String);

/// The library with the compute shader of a field ([`crate::QUERIES`], [`crate::FAR_QUERIES`]), in another language:
/// the bytes of a file.
///
/// The languages need an entry point and bindings, and those of the queries show how to call the library. Keep the
/// functions and replace the entry point. All loops of the library end, so the text does not count their steps.
///
/// # Errors
/// [`ConvertError`] with the message of naga.
pub fn converted(language: Language, field: Field) -> Result<Vec<u8>, ConvertError> {
    let source = field.shader();
    let (module, info) = parsed(&source)?;
    let failed = |e: &dyn std::error::Error| ConvertError(e.to_string());
    let text = match language {
        Language::Glsl => to_glsl(&module, &info, field.entry()).map_err(|e| failed(&e))?,
        Language::Hlsl => to_hlsl(&module, &info).map_err(|e| failed(&e))?,
        Language::Msl => {
            let options = msl::Options {
                lang_version: (2, 4),
                fake_missing_bindings: true,
                force_loop_bounding: false,
                ..Default::default()
            };
            msl::write_string(&module, &info, &options, &msl::PipelineOptions::default()).map_err(|e| failed(&e))?.0
        }
        Language::SpirV => {
            let options = spv::Options { lang_version: (1, 3), force_loop_bounding: false, ..Default::default() };
            let words = spv::write_vec(&module, &info, &options, None).map_err(|e| failed(&e))?;
            return Ok(words.into_iter().flat_map(u32::to_le_bytes).collect());
        }
    };
    Ok(text.into_bytes())
}

/// The functions of a text to include.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Functions {
    /// Those of both fields and of the reduced model.
    All,
    /// Those of the reduced model alone, which needs no buffers.
    Reduced,
}

/// The library in GLSL 4.30 for an engine's own shaders: functions without version, bindings and entry point. The files
/// are `vellus.glsl` and `vellus-reduced.glsl`.
///
/// All functions need `vec4 vellus_table(uint row)`, `vellus_row` and `vellus_far_row`, which the text declares. The
/// shader that includes it defines them, before or after; the last one only if it calls functions of the far field.
///
/// # Errors
/// [`ConvertError`] with the message of naga.
pub fn glsl_include(functions: Functions) -> Result<String, ConvertError> {
    let (module, info) = parsed(&closed(functions))?;
    let text = to_glsl(&module, &info, ENTRY).map_err(|e| ConvertError(e.to_string()))?;
    // What is outside of functions and structs: the version, its extensions, and the size of workgroups.
    let is_kept = |line: &&str| !line.starts_with('#') && !line.starts_with("layout(local_size");
    let lines: String = text.split_inclusive('\n').filter(is_kept).collect();
    opened(functions, &lines, "vec4", "void main(")
}

/// The same in HLSL, shader model 6.0, with `float4`: the files `vellus.hlsli` and `vellus-reduced.hlsli`.
///
/// # Errors
/// As [`glsl_include`].
pub fn hlsl_include(functions: Functions) -> Result<String, ConvertError> {
    let (module, info) = parsed(&closed(functions))?;
    let text = to_hlsl(&module, &info).map_err(|e| ConvertError(e.to_string()))?;
    opened(functions, &text, "float4", "[numthreads(")
}

/// The functions that a shader defines for the library, and what they read.
const ACCESSORS: [(&str, &str); 3] = [
    ("vellus_table", "of tables.bin"),
    ("vellus_row", "of the records of fibres, one after another"),
    ("vellus_far_row", "of the tables of far fields, only for the functions vellus_far_..."),
];

impl Functions {
    fn accessors(self) -> &'static [(&'static str, &'static str)] {
        if self == Functions::All { &ACCESSORS } else { &[] }
    }
}

/// The entry point of [`closed`].
const ENTRY: &str = "run";

/// The functions as a whole module, which naga needs: each accessor has a body, and there is an entry point.
fn closed(functions: Functions) -> String {
    let mut source = match functions {
        Functions::All => format!("{}\n{FAR_FIELD}\n", shader_library()),
        Functions::Reduced => reduced_library(),
    };
    for (name, _) in functions.accessors() {
        source += &format!("fn {name}(row: u32) -> vec4<f32> {{ return vec4<f32>(f32(row)); }}\n");
    }
    source + &format!("@compute @workgroup_size(1) fn {ENTRY}() {{ }}\n")
}

/// The text of a module without what [`closed`] added: declarations are in the place of the accessors. `vector`: the
/// type of a row. `entry`: how the entry point begins.
fn opened(functions: Functions, text: &str, vector: &str, entry: &str) -> Result<String, ConvertError> {
    let lacks = |what: &str| ConvertError(format!("naga's text has no {what}"));
    let mut text = text.split_once(entry).ok_or_else(|| lacks(entry))?.0.trim().to_owned();
    let mut needs = String::new();
    for (name, what) in functions.accessors() {
        needs += &format!("//   {vector} {name}(uint row): {what}\n");
        let begin = format!("{vector} {name}(");
        let start = text.find(&begin).ok_or_else(|| lacks(&begin))?;
        let length = text[start..].find("\n}").ok_or_else(|| lacks("end of an accessor"))? + "\n}".len();
        text.replace_range(start..start + length, &format!("{vector} {name}(uint row);"));
    }
    if !needs.is_empty() {
        let what = "Define these for it, before or after. Each returns a row of a buffer, four numbers:";
        needs = format!("//\n// {what}\n{needs}");
    }
    Ok(format!(
        "// The Vellus model of hair and fur, version {}. Licence: MIT or Apache-2.0.\n{needs}\
         #ifndef VELLUS_INCLUDED\n#define VELLUS_INCLUDED\n\n{text}\n\n#endif\n",
        env!("CARGO_PKG_VERSION")
    ))
}

fn parsed(source: &str) -> Result<(naga::Module, ModuleInfo), ConvertError> {
    let module = naga::front::wgsl::parse_str(source).map_err(|e| ConvertError(e.emit_to_string(source)))?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .map_err(|e| ConvertError(e.emit_to_string(source)))?;
    Ok((module, info))
}

fn to_glsl(module: &naga::Module, info: &ModuleInfo, entry: &str) -> Result<String, glsl::Error> {
    let version = glsl::Version::Desktop(430);
    let binding_map = (0..5u8).map(|k| (ResourceBinding { group: 0, binding: k.into() }, k)).collect();
    let options = glsl::Options { version, binding_map, ..Default::default() };
    let pipeline =
        glsl::PipelineOptions { shader_stage: ShaderStage::Compute, entry_point: entry.to_owned(), multiview: None };
    let mut text = String::new();
    let policies = BoundsCheckPolicies::default();
    glsl::Writer::new(&mut text, module, info, &options, &pipeline, policies)?.write()?;
    Ok(read_only(&text))
}

fn to_hlsl(module: &naga::Module, info: &ModuleInfo) -> Result<String, hlsl::Error> {
    let options =
        hlsl::Options { shader_model: hlsl::ShaderModel::V6_0, force_loop_bounding: false, ..Default::default() };
    let mut text = String::new();
    hlsl::Writer::new(&mut text, &options, &hlsl::PipelineOptions::default()).write(module, info, None)?;
    Ok(read_only(&text))
}

/// Hits that a function does not change become `in`. naga makes each `inout`, and glslang then copies the hit twice for
/// each call: Mesa's lavapipe compiles such a kernel for a minute instead of seconds.
fn read_only(text: &str) -> String {
    const CHANGED: &str = "inout VellusHit ";
    let (mut result, mut changing) = (String::new(), Vec::new());
    // Only functions end like this, and those that a function calls stand before it.
    for part in text.split_inclusive("\n}\n") {
        let Some((head, rest)) = part.split_once(CHANGED) else {
            result += part;
            continue;
        };
        let hit: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        let is_set =
            |line: &str| line.strip_prefix(&hit).is_some_and(|to| to.starts_with(['.', ' ']) && to.contains(" = "));
        let passes = |line: &str| changing.iter().any(|call| line.contains(&format!("{call}{hit}")));
        if rest.lines().map(str::trim_start).any(|line| is_set(line) || passes(line)) {
            changing.push(head.rsplit([' ', '\n']).next().unwrap_or(head).to_owned());
            result += part;
        } else {
            result += &format!("{head}in VellusHit {rest}");
        }
    }
    result
}
