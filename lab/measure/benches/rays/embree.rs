//! Intel Embree 4, loaded at run time, for comparison. `VELLUS_EMBREE` names its library, e.g. that of the Python
//! wheel `embreex`.
#![allow(unsafe_code, reason = "a C library")]

use libloading::{Library, Symbol};
use std::ffi::c_void;
use vellus_render::Ray;
use vellus_scene::{Basis, Strands};

type Handle = *mut c_void;

/// `RTCRayHit`, with room for fields of later versions.
#[repr(C, align(16))]
struct RayHit {
    origin: [f32; 3],
    near: f32,
    direction: [f32; 3],
    time: f32,
    far: f32,
    mask: u32,
    id: u32,
    flags: u32,
    normal: [f32; 3],
    u: f32,
    v: f32,
    primitive: u32,
    geometry: u32,
    instance: [u32; 8],
}

impl RayHit {
    fn new(ray: &Ray) -> Self {
        RayHit {
            origin: ray.origin.to_array(),
            near: 0.0,
            direction: ray.direction.to_array(),
            time: 0.0,
            far: f32::INFINITY,
            mask: u32::MAX,
            id: 0,
            flags: 0,
            normal: [0.0; 3],
            u: 0.0,
            v: 0.0,
            primitive: u32::MAX,
            geometry: u32::MAX,
            instance: [u32::MAX; 8],
        }
    }
}

/// Strands in an Embree scene.
pub struct Embree {
    /// The library is never unloaded, because Embree's threads continue to run.
    library: &'static Library,
    scene: Handle,
    /// Shared with Embree, which reads sixteen bytes past the end.
    _points: Vec<[f32; 4]>,
    _segments: Vec<u32>,
}

impl Embree {
    /// The error is the reason why the library cannot be used.
    pub fn new(strands: &Strands) -> Result<Self, String> {
        let path = std::env::var("VELLUS_EMBREE").unwrap_or_else(|_| "libembree4.so.4".to_owned());
        let mut points: Vec<[f32; 4]> = strands.points.iter().map(|p| p.to_array()).collect();
        points.push([0.0; 4]);
        let mut segments = Vec::new();
        for i in 0..strands.len() {
            let count = strands.basis.segments(strands.strand(i).len()).unwrap_or(0) as u32;
            segments.extend((0..count).map(|k| strands.starts[i] + k));
        }
        let kind: u32 = if strands.basis == Basis::Linear { 16 } else { 32 };
        let count = segments.len();
        // Padding after the end, as for the points.
        segments.push(0);
        // SAFETY: signatures are those of embree4/rtcore.h; the buffers outlive the scene and do not move.
        unsafe {
            let library = Library::new(&path).map_err(|e| format!("{path}: {e}"))?;
            let library: &'static Library = Box::leak(Box::new(library));
            type Share = unsafe extern "C" fn(Handle, u32, u32, u32, *const c_void, usize, usize, usize);
            let new_device: Symbol<unsafe extern "C" fn(*const i8) -> Handle> = library.get(b"rtcNewDevice").unwrap();
            let new_scene: Symbol<unsafe extern "C" fn(Handle) -> Handle> = library.get(b"rtcNewScene").unwrap();
            let new_geometry: Symbol<unsafe extern "C" fn(Handle, u32) -> Handle> =
                library.get(b"rtcNewGeometry").unwrap();
            let share: Symbol<Share> = library.get(b"rtcSetSharedGeometryBuffer").unwrap();
            let commit_geometry: Symbol<unsafe extern "C" fn(Handle)> = library.get(b"rtcCommitGeometry").unwrap();
            let attach: Symbol<unsafe extern "C" fn(Handle, Handle) -> u32> =
                library.get(b"rtcAttachGeometry").unwrap();
            let commit_scene: Symbol<unsafe extern "C" fn(Handle)> = library.get(b"rtcCommitScene").unwrap();
            let device = new_device(std::ptr::null());
            let scene = new_scene(device);
            let geometry = new_geometry(device, kind);
            const FLOAT4: u32 = 0x9004;
            const UINT: u32 = 0x5001;
            share(geometry, 1, 0, FLOAT4, points.as_ptr().cast(), 0, 16, strands.points.len());
            share(geometry, 0, 0, UINT, segments.as_ptr().cast(), 0, 4, count);
            commit_geometry(geometry);
            attach(scene, geometry);
            commit_scene(scene);
            Ok(Embree { library, scene, _points: points, _segments: segments })
        }
    }

    /// Computes the distance of the first hit of each ray.
    pub fn intersect(&self) -> impl Fn(&Ray) -> Option<f32> {
        // SAFETY: as above.
        let f: Symbol<unsafe extern "C" fn(Handle, *mut RayHit, *const c_void)> =
            unsafe { self.library.get(b"rtcIntersect1").unwrap() };
        move |ray| {
            let mut hit = RayHit::new(ray);
            // SAFETY: the scene lives as long as the process, the hit is at least as large as Embree's.
            unsafe { f(self.scene, &mut hit, std::ptr::null()) };
            (hit.geometry != u32::MAX).then_some(hit.far)
        }
    }

    /// Tests whether each ray hits anything.
    pub fn occluded(&self) -> impl Fn(&Ray) -> bool {
        // SAFETY: as above; an RTCRay is the first part of an RTCRayHit.
        let f: Symbol<unsafe extern "C" fn(Handle, *mut RayHit, *const c_void)> =
            unsafe { self.library.get(b"rtcOccluded1").unwrap() };
        move |ray| {
            let mut hit = RayHit::new(ray);
            // SAFETY: the scene lives as long as the process, the hit is at least as large as Embree's.
            unsafe { f(self.scene, &mut hit, std::ptr::null()) };
            hit.far < 0.0
        }
    }
}
