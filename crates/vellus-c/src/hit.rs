//! Hits as handles: everything that depends on ω_o and the window, prepared once for many queries.

use crate::fiber::VellusFiber;
use crate::memory::{place, reference};
use crate::query::{VELLUS_LOBES, VellusSample, check_places, read_direction, read_uniform, store};
use crate::status::{Failure, VellusStatus, guard};
use crate::window::VellusWindow;
use vellus::{Lobes, OwnedHit};

/// A hit of a fibre, prepared for many queries. It never changes: any number of threads may use it at the same time. It
/// takes 1.9 KB, with a window wider than the near field 11 KB.
pub struct VellusHit {
    pub(crate) hit: OwnedHit,
}

/// Prepares a hit: `wo`, a unit vector (3 numbers), and the window. The caller frees `*out`. It may live longer than
/// the fibre's handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_hit_new(
    fiber: *const VellusFiber,
    wo: *const f32,
    window: VellusWindow,
    out: *mut *mut VellusHit,
) -> VellusStatus {
    guard(|| {
        // SAFETY: the rules of the crate.
        let (fiber, wo, out) = unsafe { (reference(fiber, "fiber")?, read_direction(wo, "wo")?, place(out, "out")?) };
        let hit = fiber.bcsdf.clone().into_hit(wo, window.checked()?);
        *out = Box::into_raw(Box::new(VellusHit { hit }));
        Ok(())
    })
}

/// Frees a hit. Null is allowed. No other thread may use the handle any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_hit_free(hit: *mut VellusHit) {
    if !hit.is_null() {
        // SAFETY: the rules of the crate; `vellus_hit_new` made it of a box.
        drop(unsafe { Box::from_raw(hit) });
    }
}

/// Stores what `f` returns.
///
/// # Safety
/// Each pointer is null or valid: `hit` a handle, `out` writable.
#[inline(always)]
unsafe fn query<T>(
    hit: *const VellusHit,
    out: *mut T,
    name: &str,
    f: impl FnOnce(&OwnedHit) -> Result<T, Failure>,
) -> VellusStatus {
    guard(|| {
        // SAFETY: promised by the caller.
        let (hit, out) = unsafe { (reference(hit, "hit")?, place(out, name)?) };
        *out = f(&hit.hit)?;
        Ok(())
    })
}

/// As vellus_fiber_eval().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_hit_eval(hit: *const VellusHit, wi: *const f32, rgb: *mut f32) -> VellusStatus {
    // SAFETY: the rules of the crate.
    unsafe { query(hit, rgb.cast::<[f32; 3]>(), "rgb", |hit| Ok(hit.eval(read_direction(wi, "wi")?).total())) }
}

/// As vellus_fiber_pdf().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_hit_pdf(hit: *const VellusHit, wi: *const f32, pdf: *mut f32) -> VellusStatus {
    // SAFETY: the rules of the crate.
    unsafe { query(hit, pdf, "pdf", |hit| Ok(hit.pdf(read_direction(wi, "wi")?))) }
}

/// As vellus_fiber_eval_pdf().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_hit_eval_pdf(
    hit: *const VellusHit,
    wi: *const f32,
    rgb: *mut f32,
    pdf: *mut f32,
) -> VellusStatus {
    guard(|| {
        // SAFETY: the rules of the crate.
        let (hit, wi) = unsafe { (reference(hit, "hit")?, read_direction(wi, "wi")?) };
        // SAFETY: the rules of the crate.
        unsafe { check_places(rgb, pdf) }?;
        let (lobes, density) = hit.hit.eval_pdf(wi);
        // SAFETY: both were checked.
        unsafe { store(&lobes, density, rgb, pdf) };
        Ok(())
    })
}

/// As vellus_fiber_eval_lobes().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_hit_eval_lobes(hit: *const VellusHit, wi: *const f32, lobes: *mut f32) -> VellusStatus {
    // SAFETY: the rules of the crate.
    unsafe { query(hit, lobes.cast::<Lobes>(), "lobes", |hit| Ok(hit.eval(read_direction(wi, "wi")?))) }
}

/// As vellus_fiber_energy().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_hit_energy(hit: *const VellusHit, lobes: *mut f32) -> VellusStatus {
    // SAFETY: the rules of the crate.
    unsafe { query(hit, lobes.cast::<Lobes>(), "lobes", |hit| Ok(hit.energy())) }
}

/// The probability with which sampling chooses each lobe, to `probabilities` (VELLUS_LOBES numbers).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_hit_lobe_probabilities(hit: *const VellusHit, probabilities: *mut f32) -> VellusStatus {
    let out = probabilities.cast::<[f32; VELLUS_LOBES]>();
    // SAFETY: the rules of the crate.
    unsafe { query(hit, out, "probabilities", |hit| Ok(hit.lobe_probabilities())) }
}

/// As vellus_fiber_sample().
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_hit_sample(
    hit: *const VellusHit,
    u: *const f32,
    sample: *mut VellusSample,
) -> VellusStatus {
    // SAFETY: the rules of the crate.
    unsafe { query(hit, sample, "sample", |hit| Ok(VellusSample::new(hit.sample(read_uniform(u)?)))) }
}
