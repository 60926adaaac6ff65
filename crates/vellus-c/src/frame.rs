//! The frame of a fibre at a hit: a renderer's directions and positions in the form that queries take.

use crate::memory::{place, reference};
use crate::query::{direction, read_direction};
use crate::status::{Failure, VellusStatus, guard};
use vellus::FiberFrame;
use vellus::glam::Vec3;

/// A fibre at a hit, in the renderer's space ("world"). All numbers are those of the curve beside the hit. The frame's
/// other two axes are across the fibre, and the same for the same tangent.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VellusFrame {
    /// A unit vector along the fibre, from root to tip: the x axis.
    pub tangent: [f32; 3],
    /// The point of the axis.
    pub center: [f32; 3],
    /// The radius, above 0, in the units of `center`. Files often have widths, which are twice as large.
    pub radius: f32,
}

fn finite(v: [f32; 3], name: &str) -> Result<Vec3, Failure> {
    let v = Vec3::from_array(v);
    let error = || Failure::range(format!("{name} = ({}, {}, {}) is not finite", v.x, v.y, v.z));
    v.is_finite().then_some(v).ok_or_else(error)
}

impl VellusFrame {
    fn checked(&self) -> Result<FiberFrame, Failure> {
        let VellusFrame { tangent, center, radius } = *self;
        if radius > 0.0 && radius.is_finite() {
            return Ok(FiberFrame::new(direction(tangent, "frame.tangent")?, finite(center, "frame.center")?, radius));
        }
        Err(Failure::range(format!("frame.radius = {radius} is not a finite number above 0")))
    }
}

/// Stores what `f` returns.
///
/// # Safety
/// Each pointer is null or valid: `frame` a frame, `out` writable.
#[inline(always)]
unsafe fn with<T>(
    frame: *const VellusFrame,
    out: *mut T,
    name: &str,
    f: impl FnOnce(FiberFrame) -> Result<T, Failure>,
) -> VellusStatus {
    guard(|| {
        // SAFETY: promised by the caller.
        let (frame, out) = unsafe { (reference(frame, "frame")?, place(out, name)?) };
        *out = f(frame.checked()?)?;
        Ok(())
    })
}

/// A position and ω_o.
///
/// # Safety
/// Each pointer is null or points to three numbers.
unsafe fn hit(position: *const f32, wo: *const f32) -> Result<(Vec3, Vec3), Failure> {
    // SAFETY: promised by the caller.
    let (position, wo) = unsafe { (reference(position.cast::<[f32; 3]>(), "position")?, read_direction(wo, "wo")?) };
    Ok((finite(*position, "position")?, wo))
}

/// A direction in the fibre's frame, as queries take it: from the unit vector `world` to `local` (3 numbers).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_frame_to_local(
    frame: *const VellusFrame,
    world: *const f32,
    local: *mut f32,
) -> VellusStatus {
    let out = local.cast::<[f32; 3]>();
    // SAFETY: the rules of the crate.
    unsafe { with(frame, out, "local", |frame| Ok(frame.to_local(read_direction(world, "world")?).to_array())) }
}

/// A direction in world space, such as a sampled one: from the unit vector `local` to `world` (3 numbers).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_frame_to_world(
    frame: *const VellusFrame,
    local: *const f32,
    world: *mut f32,
) -> VellusStatus {
    let out = world.cast::<[f32; 3]>();
    // SAFETY: the rules of the crate.
    unsafe { with(frame, out, "world", |frame| Ok(frame.to_world(read_direction(local, "local")?).to_array())) }
}

/// The component of the unit vector `world` across the fibre, with unit length, to `outward` (3 numbers). A ray in this
/// direction starts at center + 1.001 · radius · outward.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_frame_outward(
    frame: *const VellusFrame,
    world: *const f32,
    outward: *mut f32,
) -> VellusStatus {
    let out = outward.cast::<[f32; 3]>();
    // SAFETY: the rules of the crate.
    unsafe { with(frame, out, "outward", |frame| Ok(frame.outward(read_direction(world, "world")?).to_array())) }
}

/// The offset h in [−1, 1] of a hit on a round curve or a mesh of it, to `*h`. `position` is the hit on the surface,
/// and `wo` a unit vector to where the path came from, both in world space.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_frame_offset(
    frame: *const VellusFrame,
    position: *const f32,
    wo: *const f32,
    h: *mut f32,
) -> VellusStatus {
    // SAFETY: the rules of the crate.
    unsafe { with(frame, h, "h", |frame| hit(position, wo).map(|(position, wo)| frame.offset(position, wo))) }
}

/// As vellus_frame_offset(), for a hit on a flat curve that faces the camera, as wide as the fibre.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_frame_offset_flat(
    frame: *const VellusFrame,
    position: *const f32,
    wo: *const f32,
    h: *mut f32,
) -> VellusStatus {
    // SAFETY: the rules of the crate.
    unsafe { with(frame, h, "h", |frame| hit(position, wo).map(|(position, wo)| frame.offset_flat(position, wo))) }
}

/// The width of a pixel in fibre radii, at most 4, to `*width`: for vellus_window_cell(). `footprint` ≥ 0 is the
/// diameter of the pixel at the hit, in world units, perpendicular to the camera's axis.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn vellus_frame_pixel_width(
    frame: *const VellusFrame,
    footprint: f32,
    width: *mut f32,
) -> VellusStatus {
    let error = || Failure::range(format!("footprint = {footprint} is not a number of at least 0"));
    let width_of = |frame: FiberFrame| (footprint >= 0.0).then(|| frame.pixel_width(footprint)).ok_or_else(error);
    // SAFETY: the rules of the crate.
    unsafe { with(frame, width, "width", width_of) }
}
