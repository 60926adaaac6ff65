//! The library in other shading languages.

use crate::library::Field;
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
        Language::Glsl => to_glsl(&module, &info, field).map_err(|e| failed(&e))?,
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

fn parsed(source: &str) -> Result<(naga::Module, ModuleInfo), ConvertError> {
    let module = naga::front::wgsl::parse_str(source).map_err(|e| ConvertError(e.emit_to_string(source)))?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .map_err(|e| ConvertError(e.emit_to_string(source)))?;
    Ok((module, info))
}

fn to_glsl(module: &naga::Module, info: &ModuleInfo, field: Field) -> Result<String, glsl::Error> {
    let version = glsl::Version::Desktop(430);
    let binding_map = (0..5u8).map(|k| (ResourceBinding { group: 0, binding: k.into() }, k)).collect();
    let options = glsl::Options { version, binding_map, ..Default::default() };
    let pipeline = glsl::PipelineOptions {
        shader_stage: ShaderStage::Compute,
        entry_point: field.entry().to_owned(),
        multiview: None,
    };
    let mut text = String::new();
    let policies = BoundsCheckPolicies::default();
    glsl::Writer::new(&mut text, module, info, &options, &pipeline, policies)?.write()?;
    Ok(text)
}

fn to_hlsl(module: &naga::Module, info: &ModuleInfo) -> Result<String, hlsl::Error> {
    let options =
        hlsl::Options { shader_model: hlsl::ShaderModel::V6_0, force_loop_bounding: false, ..Default::default() };
    let mut text = String::new();
    hlsl::Writer::new(&mut text, &options, &hlsl::PipelineOptions::default()).write(module, info, None)?;
    Ok(text)
}
