//! The near and the far field of [`vellus`] as a library of WGSL functions, and batches of queries on a GPU.
//!
//! [`shader_library`] is the text. It has no bindings and no entry points, so that it fits into any shader. Its names
//! begin with `vellus_`, `Vellus` or `VELLUS_`. A shader that includes it defines two functions:
//!
//! ```wgsl
//! fn vellus_table(row: u32) -> vec4<f32> { return tables[row]; }
//! fn vellus_row(row: u32) -> vec4<f32> { return fibers[row]; }
//! ```
//!
//! `tables` is a buffer with [`shader_tables`]. `fibers` is a buffer with the rows of [`shader_fiber`] of each fibre,
//! one after another. Then, in the frame of the fibre:
//!
//! ```wgsl
//! var hit: VellusHit;
//! vellus_hit(&hit, fiber, wo, h);              // everything that depends on wo and the offset h
//! let value = vellus_eval(&hit, wi);           // xyz: f cos, RGB; w: the density of sampling
//! let drawn = vellus_sample(&hit, u);          // wi, pdf, weight, lobe from four uniform numbers
//! let energy = vellus_energy(&hit);            // the share of the light in each lobe
//! ```
//!
//! [`FAR_FIELD`] is a second text, for the far field. It reads a table of each fibre, which [`shader_far_table`] makes,
//! through one more function: `fn vellus_far_row(row: u32) -> vec4<f32>`.
//!
//! ```wgsl
//! vellus_far_hit(&hit, fiber, table, wo);      // table: the first row of the fibre's table
//! let value = vellus_far_eval(&hit, wi);
//! let drawn = vellus_far_sample(&hit, u);
//! ```
//!
//! A fibre whose colour varies over its hits has a second record, [`shader_color`], in the same buffer:
//! `vellus_hit_colored` takes absorption, and functions like `vellus_coat_pigment` make it of a colour.
//! [`reduced_library`] is a text for real time that needs no buffers. It errs by some per cent.
//!
//! The conventions are those of [`vellus`]: x runs along the fibre from root to tip, and all directions point away from
//! the fibre.
//!
//! Features:
//! - `device` (default) adds [`Device`] and [`Queries`], which run on Vulkan, Metal or DirectX 12.
//! - `trace` adds [`Tracer`], a path tracer for the scenes of vellus-render, and [`Choice`] of the device that renders.
//! - `convert` adds [`converted`], the library in GLSL, HLSL, MSL and SPIR-V, and texts to include, [`glsl_include`]
//!   and [`hlsl_include`]. The command `vellus shaders` writes all of them, and the buffers.
#![warn(clippy::print_stdout)]

#[cfg(feature = "trace")]
mod choice;
#[cfg(feature = "convert")]
mod convert;
#[cfg(feature = "device")]
mod device;
mod library;
#[cfg(feature = "device")]
mod queries;
#[cfg(feature = "trace")]
mod trace;

#[cfg(feature = "trace")]
pub use choice::{Choice, Renderer};
#[cfg(feature = "convert")]
pub use convert::{ConvertError, Functions, Language, converted, glsl_include, hlsl_include};
#[cfg(feature = "device")]
pub use device::{Device, DeviceError};
pub use library::{
    FAR_FIELD, FAR_QUERIES, Field, QUERIES, SHADERS, reduced_library, shader_color, shader_far_table, shader_fiber,
    shader_library, shader_tables, shader_tables_half,
};
#[cfg(feature = "device")]
pub use queries::{Answer, Queries, Query};
#[cfg(feature = "trace")]
pub use trace::{Tracer, tracer_shader};
