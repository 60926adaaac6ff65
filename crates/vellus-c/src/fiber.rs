//! Fibres as handles.

use crate::memory::{place, reference, text};
use crate::parameters::VellusParameters;
use crate::status::{Failure, VellusStatus, guard};
use std::ffi::c_char;
use vellus::{Bcsdf, Fiber, FiberBuilder};

/// The longest text of a fibre in JSON: 1 MiB, as for files.
const MAX_JSON_BYTES: usize = 1 << 20;

/// A fibre, checked and prepared for queries. It never changes: any number of threads may use it at the same time.
pub struct VellusFiber {
    pub(crate) bcsdf: Bcsdf<'static>,
}

/// Prepares a fibre and passes it to the caller.
///
/// # Safety
/// `out` is null or valid for writes.
unsafe fn create(fiber: &Fiber, out: *mut *mut VellusFiber) -> Result<(), Failure> {
    // SAFETY: promised by the caller.
    let out = unsafe { place(out, "out") }?;
    *out = Box::into_raw(Box::new(VellusFiber { bcsdf: Bcsdf::new(fiber)? }));
    Ok(())
}

/// Makes a fibre from a preset: "red-fox" or "red-fox-published"; see vellus_parameters_preset(). The caller frees
/// `*out`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_fiber_from_preset(name: *const c_char, out: *mut *mut VellusFiber) -> VellusStatus {
    // SAFETY: the rules of the crate.
    guard(|| unsafe { create(&Fiber::named(text(name, "name")?)?, out) })
}

/// Makes a fibre from JSON, as the command `vellus fiber` reads and writes it: a map of parameters by name, angles in
/// degrees, and optionally "preset" and "exit". The text has at most 1 MiB. The caller frees `*out`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_fiber_from_json(json: *const c_char, out: *mut *mut VellusFiber) -> VellusStatus {
    guard(|| {
        // SAFETY: the rules of the crate.
        let json = unsafe { text(json, "json") }?;
        if json.len() > MAX_JSON_BYTES {
            return Err(Failure::text(format!("json has {} bytes, at most {MAX_JSON_BYTES} are allowed", json.len())));
        }
        let builder: FiberBuilder =
            serde_json::from_str(json).map_err(|error| Failure::text(format!("json: {error}")))?;
        // SAFETY: the rules of the crate.
        unsafe { create(&builder.build()?, out) }
    })
}

/// Makes a fibre from parameters. The caller frees `*out`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_fiber_from_parameters(
    parameters: *const VellusParameters,
    out: *mut *mut VellusFiber,
) -> VellusStatus {
    // SAFETY: the rules of the crate.
    guard(|| unsafe { create(&reference(parameters, "parameters")?.fiber()?, out) })
}

/// Frees a fibre. Null is allowed. No other thread may use the handle any more. Hits of the fibre stay valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_fiber_free(fiber: *mut VellusFiber) {
    if !fiber.is_null() {
        // SAFETY: the rules of the crate; `create` made it of a box.
        drop(unsafe { Box::from_raw(fiber) });
    }
}

/// The parameters of a fibre.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_fiber_parameters(
    fiber: *const VellusFiber,
    parameters: *mut VellusParameters,
) -> VellusStatus {
    guard(|| {
        // SAFETY: the rules of the crate.
        let (fiber, parameters) = unsafe { (reference(fiber, "fiber")?, place(parameters, "parameters")?) };
        *parameters = VellusParameters::new(fiber.bcsdf.fiber());
        Ok(())
    })
}

/// The colour of a dense coat of such fibres in white light, to `rgb` (3 numbers): a reflectance in [0, 1].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_fiber_coat_color(fiber: *const VellusFiber, rgb: *mut f32) -> VellusStatus {
    guard(|| {
        // SAFETY: the rules of the crate.
        let (fiber, rgb) = unsafe { (reference(fiber, "fiber")?, place(rgb.cast::<[f32; 3]>(), "rgb")?) };
        *rgb = fiber.bcsdf.fiber().coat_color()?;
        Ok(())
    })
}

/// Writes a fibre as JSON, with a zero byte at its end, to `json`, which has space for `capacity` bytes. `*length` gets
/// the number of bytes without the zero byte, also with VELLUS_STATUS_SPACE. To ask for it alone, pass 0 as
/// `capacity`; `json` may then be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_fiber_json(
    fiber: *const VellusFiber,
    json: *mut c_char,
    capacity: usize,
    length: *mut usize,
) -> VellusStatus {
    guard(|| {
        // SAFETY: the rules of the crate.
        let (fiber, length) = unsafe { (reference(fiber, "fiber")?, place(length, "length")?) };
        let text = serde_json::to_string(fiber.bcsdf.fiber())
            .map_err(|error| Failure::new(VellusStatus::Internal, error.to_string()))?;
        if json.is_null() && capacity > 0 {
            return Err(Failure::null("json"));
        }
        *length = text.len();
        if capacity <= text.len() {
            let message = format!("the text has {} bytes and a zero byte, but the capacity is {capacity}", text.len());
            return Err(Failure::new(VellusStatus::Space, message));
        }
        // SAFETY: `json` has space for `capacity` bytes, more than the text has.
        unsafe {
            json.cast::<u8>().copy_from_nonoverlapping(text.as_ptr(), text.len());
            json.add(text.len()).write(0);
        }
        Ok(())
    })
}
