//! The C interface of Vellus: the model of the crate `vellus` for renderers in C, C++ and other languages.
//!
//! The functions are meant for C. They are in the header `include/vellus.h`, which cbindgen makes from this crate. The
//! book's page "C and C++" explains how to build, link and use the library.
//!
//! Every function checks its arguments, returns a [`VellusStatus`], and leaves a message for [`vellus_last_error`]. No
//! panic leaves a function.
//!
//! # Safety
//! A pointer must be null, or point to as many values as the function's documentation says. A null pointer gives
//! [`VellusStatus::Null`], except where it is allowed. Text ends with a zero byte. A handle comes from this library and
//! was not freed. Memory for results must not overlap memory that the same call reads.

#![allow(unsafe_code, reason = "every function takes pointers from C; each block says why it is sound")]
#![allow(clippy::missing_safety_doc, reason = "the rules are those of the crate, above, for all functions")]
#![warn(clippy::undocumented_unsafe_blocks)]

mod array;
mod fiber;
mod frame;
mod hit;
mod memory;
mod parameters;
mod query;
mod shader;
mod status;
mod window;

pub use array::{VellusQueries, VellusSamples, VellusValues, vellus_fiber_eval_array, vellus_fiber_sample_array};
pub use array::{vellus_hit_eval_array, vellus_hit_sample_array};
pub use array::{vellus_parameters_eval_array, vellus_parameters_sample_array};
pub use fiber::{VellusFiber, vellus_fiber_coat_color, vellus_fiber_free, vellus_fiber_from_json};
pub use fiber::{vellus_fiber_from_parameters, vellus_fiber_from_preset, vellus_fiber_json, vellus_fiber_parameters};
pub use frame::{VellusFrame, vellus_frame_offset, vellus_frame_offset_flat, vellus_frame_outward};
pub use frame::{vellus_frame_pixel_width, vellus_frame_to_local, vellus_frame_to_world};
pub use hit::{VellusHit, vellus_hit_energy, vellus_hit_eval, vellus_hit_eval_lobes, vellus_hit_eval_pdf};
pub use hit::{vellus_hit_free, vellus_hit_lobe_probabilities, vellus_hit_new, vellus_hit_pdf, vellus_hit_sample};
pub use memory::{VellusInput, VellusOutput, VellusOutputLobes};
pub use parameters::{VellusExit, VellusParameter, VellusParameters, vellus_parameter, vellus_parameter_count};
pub use parameters::{vellus_parameters_hair, vellus_parameters_nearest_reflectance, vellus_parameters_preset};
pub use parameters::{vellus_parameters_set, vellus_parameters_set_word, vellus_species_count, vellus_species_name};
pub use query::{VELLUS_LOBES, VellusLobe, VellusSample, vellus_fiber_energy, vellus_fiber_eval};
pub use query::{vellus_fiber_eval_lobes, vellus_fiber_eval_pdf, vellus_fiber_pdf, vellus_fiber_sample};
pub use shader::{vellus_shader_color, vellus_shader_far_table, vellus_shader_fiber, vellus_shader_tables};
pub use status::{VELLUS_ABI_VERSION, VellusStatus, vellus_abi_version, vellus_last_error, vellus_version};
pub use window::vellus_window_range;
pub use window::{VellusWindow, vellus_window_cell, vellus_window_far, vellus_window_near, vellus_window_pixel};
