//! One query of a fibre.

use crate::fiber::VellusFiber;
use crate::memory::{place, reference};
use crate::status::{Failure, VellusStatus, guard};
use crate::window::VellusWindow;
use vellus::glam::Vec3;
use vellus::{Hit, Lobes, Sample};

/// The number of lobes.
pub const VELLUS_LOBES: usize = 6;

/// The lobes, in the order of every array of lobes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VellusLobe {
    /// Reflected by the cuticle.
    R = 0,
    /// Transmitted straight through.
    Tt = 1,
    /// Reflected once inside.
    Trt = 2,
    /// Scattered by the medulla in its first pass.
    Tts = 3,
    /// Scattered by the medulla in its second pass.
    Trts = 4,
    /// All higher orders.
    Rest = 5,
}

/// A sampled direction.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VellusSample {
    /// The direction, a unit vector in the fibre's frame.
    pub wi: [f32; 3],
    /// Its density per solid angle, over all lobes. 0 if no direction was drawn: all other numbers are 0 then, and the
    /// path ends.
    pub pdf: f32,
    /// f·cos θᵢ over the density, RGB.
    pub weight: [f32; 3],
    /// The VellusLobe it was drawn from, or −1.
    pub lobe: i32,
}

impl VellusSample {
    #[inline]
    pub(crate) fn new(sample: Option<Sample>) -> Self {
        match sample {
            Some(Sample { wi, pdf, weight, lobe }) => {
                VellusSample { wi: wi.to_array(), pdf, weight, lobe: lobe as i32 }
            }
            None => VellusSample { wi: [0.0; 3], pdf: 0.0, weight: [0.0; 3], lobe: -1 },
        }
    }
}

/// A unit vector, as the model needs it: its squared length is within 1e-3 of 1.
#[inline]
pub(crate) fn direction(w: [f32; 3], name: &str) -> Result<Vec3, Failure> {
    let w = Vec3::from_array(w);
    if (w.length_squared() - 1.0).abs() < 1e-3 { Ok(w) } else { Err(not_a_direction(w, name)) }
}

#[cold]
fn not_a_direction(w: Vec3, name: &str) -> Failure {
    Failure::range(format!("{name} = ({}, {}, {}) is not a unit vector", w.x, w.y, w.z))
}

/// Uniform numbers, as the model needs them.
#[inline]
pub(crate) fn uniform(u: [f32; 5]) -> Result<[f32; 5], Failure> {
    if u.iter().all(|u| (0.0..1.0).contains(u)) { Ok(u) } else { Err(not_uniform(u)) }
}

#[cold]
fn not_uniform(u: [f32; 5]) -> Failure {
    let bad = u.into_iter().enumerate().find(|(_, u)| !(0.0..1.0).contains(u)).unwrap_or_default();
    Failure::range(format!("u[{}] = {} is not in [0, 1)", bad.0, bad.1))
}

/// # Safety
/// The pointer is null or points to three numbers.
#[inline]
pub(crate) unsafe fn read_direction(w: *const f32, name: &str) -> Result<Vec3, Failure> {
    // SAFETY: promised by the caller.
    direction(*unsafe { reference(w.cast::<[f32; 3]>(), name) }?, name)
}

/// # Safety
/// The pointer is null or points to five numbers.
#[inline]
pub(crate) unsafe fn read_uniform(u: *const f32) -> Result<[f32; 5], Failure> {
    // SAFETY: promised by the caller.
    uniform(*unsafe { reference(u.cast::<[f32; 5]>(), "u") }?)
}

/// Prepares a hit without allocating, and stores what `f` returns.
///
/// # Safety
/// Each pointer is null or valid: `fiber` a handle, `wo` three numbers, `out` writable.
#[inline(always)]
unsafe fn query<T>(
    fiber: *const VellusFiber,
    wo: *const f32,
    window: VellusWindow,
    out: *mut T,
    name: &str,
    f: impl FnOnce(&Hit<'_>) -> Result<T, Failure>,
) -> VellusStatus {
    guard(|| {
        // SAFETY: promised by the caller.
        let (fiber, wo, out) = unsafe { (reference(fiber, "fiber")?, read_direction(wo, "wo")?, place(out, name)?) };
        *out = fiber.bcsdf.with_hit(wo, window.checked()?, f)?;
        Ok(())
    })
}

/// f·cos θᵢ, the sum of all lobes, to `rgb` (3 numbers). `wo` and `wi` are unit vectors (3 numbers) in the fibre's
/// frame, x along the fibre from root to tip, both away from the fibre: `wo` to where the path came from, `wi` to the
/// light. The bits are those of Bcsdf::at(wo, window).eval(wi).total() in Rust.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_fiber_eval(
    fiber: *const VellusFiber,
    wo: *const f32,
    window: VellusWindow,
    wi: *const f32,
    rgb: *mut f32,
) -> VellusStatus {
    // SAFETY: the rules of the crate.
    unsafe {
        query(fiber, wo, window, rgb.cast::<[f32; 3]>(), "rgb", |hit| Ok(hit.eval(read_direction(wi, "wi")?).total()))
    }
}

/// The density per solid angle with which vellus_fiber_sample() draws `wi`, to `*pdf`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_fiber_pdf(
    fiber: *const VellusFiber,
    wo: *const f32,
    window: VellusWindow,
    wi: *const f32,
    pdf: *mut f32,
) -> VellusStatus {
    // SAFETY: the rules of the crate.
    unsafe { query(fiber, wo, window, pdf, "pdf", |hit| Ok(hit.pdf(read_direction(wi, "wi")?))) }
}

/// vellus_fiber_eval() and vellus_fiber_pdf() together, at little more than the cost of one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_fiber_eval_pdf(
    fiber: *const VellusFiber,
    wo: *const f32,
    window: VellusWindow,
    wi: *const f32,
    rgb: *mut f32,
    pdf: *mut f32,
) -> VellusStatus {
    guard(|| {
        // SAFETY: the rules of the crate.
        let (fiber, wo, wi) =
            unsafe { (reference(fiber, "fiber")?, read_direction(wo, "wo")?, read_direction(wi, "wi")?) };
        // SAFETY: the rules of the crate.
        unsafe { check_places(rgb, pdf) }?;
        let (lobes, density) = fiber.bcsdf.with_hit(wo, window.checked()?, |hit| hit.eval_pdf(wi));
        // SAFETY: both were checked.
        unsafe { store(&lobes, density, rgb, pdf) };
        Ok(())
    })
}

/// Checks the places of both results before one is written.
///
/// # Safety
/// Each pointer is null or writable.
#[inline]
pub(crate) unsafe fn check_places(rgb: *mut f32, pdf: *mut f32) -> Result<(), Failure> {
    // SAFETY: promised by the caller.
    unsafe {
        place(rgb.cast::<[f32; 3]>(), "rgb")?;
        place(pdf, "pdf")?;
    }
    Ok(())
}

/// Stores both results.
///
/// # Safety
/// [`check_places`] succeeded for these pointers.
#[inline]
pub(crate) unsafe fn store(lobes: &Lobes, density: f32, rgb: *mut f32, pdf: *mut f32) {
    // SAFETY: promised by the caller.
    unsafe {
        rgb.cast::<[f32; 3]>().write(lobes.total());
        pdf.write(density);
    }
}

/// f·cos θᵢ of each lobe, to `lobes` (VELLUS_LOBES × 3 numbers): RGB of R, then RGB of TT, and so on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_fiber_eval_lobes(
    fiber: *const VellusFiber,
    wo: *const f32,
    window: VellusWindow,
    wi: *const f32,
    lobes: *mut f32,
) -> VellusStatus {
    // SAFETY: the rules of the crate.
    unsafe { query(fiber, wo, window, lobes.cast::<Lobes>(), "lobes", |hit| Ok(hit.eval(read_direction(wi, "wi")?))) }
}

/// The share of the light that each lobe carries, to `lobes` (VELLUS_LOBES × 3 numbers): the integral of f·cos θᵢ.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_fiber_energy(
    fiber: *const VellusFiber,
    wo: *const f32,
    window: VellusWindow,
    lobes: *mut f32,
) -> VellusStatus {
    // SAFETY: the rules of the crate.
    unsafe { query(fiber, wo, window, lobes.cast::<Lobes>(), "lobes", |hit| Ok(hit.energy())) }
}

/// Draws a direction. `u`: five uniform numbers in [0, 1). The near field ignores the last.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_fiber_sample(
    fiber: *const VellusFiber,
    wo: *const f32,
    window: VellusWindow,
    u: *const f32,
    sample: *mut VellusSample,
) -> VellusStatus {
    // SAFETY: the rules of the crate.
    unsafe { query(fiber, wo, window, sample, "sample", |hit| Ok(VellusSample::new(hit.sample(read_uniform(u)?)))) }
}

/// The lobes lie side by side, as arrays of C do.
const _: () = assert!(size_of::<Lobes>() == 4 * 3 * VELLUS_LOBES && align_of::<Lobes>() == 4);
