//! Writes attributes of strands that rendering does not use, as primvars.

use crate::write::encoder::Encoder;
use crate::write::value::{Array, Quoted, Row64};
use std::io;
use vellus_scene::{Custom, CustomValues, Per};

/// Whether a stage can have an attribute: its name is that of a primvar, and a type has rows of this length.
/// [`crate::write()`] leaves out others.
pub fn fits(custom: &Custom) -> bool {
    let is_word = |part: &str| {
        part.chars().all(|c| c.is_alphanumeric() || c == '_') && !part.starts_with(|c: char| c.is_ascii_digit())
    };
    let is_name = custom.name.split(':').all(|part| !part.is_empty() && is_word(part));
    is_name
        && match custom.values {
            CustomValues::F32(_) | CustomValues::F64(_) => (1..=4).contains(&custom.lanes),
            CustomValues::I32(_) | CustomValues::Text(_) => custom.lanes == 1,
        }
}

/// Writes an attribute in the prim of its strands, which is open. One that does not fit is left out.
pub(crate) fn custom(out: &mut dyn Encoder, custom: &Custom) -> io::Result<()> {
    if !fits(custom) {
        return Ok(());
    }
    let scope = Some(match custom.per {
        Per::Set => "constant",
        Per::Strand => "uniform",
        Per::Point => "vertex",
    });
    let mut write = |kind: &str, value: &dyn crate::write::value::Value| {
        out.attribute(&format!("{kind}[] primvars:{}", custom.name), value, scope)
    };
    match &custom.values {
        CustomValues::Text(texts) => write("string", &Array(texts.iter().map(|text| Quoted(text)))),
        CustomValues::I32(values) => write("int", &Array(values.iter().copied())),
        CustomValues::F32(values) => match custom.lanes {
            1 => write("float", &Array(values.iter().copied())),
            2 => write("float2", &Array(values.as_chunks::<2>().0.iter().copied())),
            3 => write("float3", &Array(values.as_chunks::<3>().0.iter().copied())),
            _ => write("float4", &Array(values.as_chunks::<4>().0.iter().copied())),
        },
        CustomValues::F64(values) => match custom.lanes {
            1 => write("double", &Array(values.iter().copied())),
            2 => write("double2", &Array(values.as_chunks::<2>().0.iter().map(|row| Row64(*row)))),
            3 => write("double3", &Array(values.as_chunks::<3>().0.iter().map(|row| Row64(*row)))),
            _ => write("double4", &Array(values.as_chunks::<4>().0.iter().map(|row| Row64(*row)))),
        },
    }
}
