//! The buffers of the shader library.

use crate::fiber::VellusFiber;
use crate::memory::{place, reference};
use crate::status::{Failure, VellusStatus, guard};
use vellus::{Bcsdf, Tables, packed};

/// Copies rows of four numbers to the caller.
///
/// # Safety
/// `rows` is null or valid for writes of `capacity` rows, and `count` is null or valid for writes.
unsafe fn copy(from: &[[f32; 4]], rows: *mut f32, capacity: usize, count: *mut usize) -> Result<(), Failure> {
    // SAFETY: promised by the caller.
    let count = unsafe { place(count, "count") }?;
    if rows.is_null() && capacity > 0 {
        return Err(Failure::null("rows"));
    }
    if !rows.is_aligned() {
        return Err(Failure::misaligned("rows", align_of::<f32>()));
    }
    *count = from.len();
    if capacity < from.len() {
        let message = format!("there are {} rows, but the capacity is {capacity}", from.len());
        return Err(Failure::new(VellusStatus::Space, message));
    }
    // SAFETY: `rows` is aligned and has space for `capacity` rows, at least as many as there are.
    unsafe { rows.copy_from_nonoverlapping(from.as_flattened().as_ptr(), from.as_flattened().len()) };
    Ok(())
}

/// The tables that all fibres share in shaders, to `rows`, which has space for `capacity` rows of 4 numbers: the buffer
/// that `vellus_table` reads. `*count` gets the number of rows, also with VELLUS_STATUS_SPACE. To get only that number,
/// pass 0 as `capacity`; `rows` may then be null. The shaders must be those of the same version, see vellus_version().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_shader_tables(rows: *mut f32, capacity: usize, count: *mut usize) -> VellusStatus {
    // SAFETY: the rules of the crate.
    guard(|| unsafe { copy(&packed::tables(Tables::shipped()).rows, rows, capacity, count) })
}

/// The record of a fibre in shaders: what the buffer that `vellus_row` reads has for it. Arguments as for
/// vellus_shader_tables(). All fibres have the same number of rows, and a buffer holds them one after another.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_shader_fiber(
    fiber: *const VellusFiber,
    rows: *mut f32,
    capacity: usize,
    count: *mut usize,
) -> VellusStatus {
    // SAFETY: the rules of the crate.
    guard(|| unsafe { copy(&packed::fiber(round(fiber)?), rows, capacity, count) })
}

/// What a fibre needs beside its record for other absorption at each hit, `vellus_hit_colored`: rows in the buffer of
/// the records, whose first one the shader gets. Arguments as for vellus_shader_tables().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_shader_color(
    fiber: *const VellusFiber,
    rows: *mut f32,
    capacity: usize,
    count: *mut usize,
) -> VellusStatus {
    // SAFETY: the rules of the crate.
    guard(|| unsafe { copy(&packed::color(round(fiber)?), rows, capacity, count) })
}

/// The far field of a fibre in shaders: a table that `vellus_far_row` reads. Arguments as for vellus_shader_tables().
/// Its size depends on the fibre: 18 MB at most. Each call makes the table again, also one that asks for the number of
/// rows.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_shader_far_table(
    fiber: *const VellusFiber,
    rows: *mut f32,
    capacity: usize,
    count: *mut usize,
) -> VellusStatus {
    // SAFETY: the rules of the crate.
    guard(|| unsafe { copy(&packed::far(round(fiber)?).rows, rows, capacity, count) })
}

/// A fibre whose scattering shaders have.
unsafe fn round<'f>(fiber: *const VellusFiber) -> Result<&'f Bcsdf<'static>, Failure> {
    // SAFETY: the rules of the crate.
    let bcsdf = &unsafe { reference(fiber, "fiber") }?.bcsdf;
    packed::supports(bcsdf.fiber())?;
    Ok(bcsdf)
}
