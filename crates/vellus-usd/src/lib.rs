//! Scenes of hair and fur as USD: files (.usda, .usdc, .usdz) into a [`vellus_scene::Scene`] and back.
//!
//! ```
//! use vellus_usd::{Options, read, write};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//! # let (fox, copy) = (folder.path().join("fox.usda"), folder.path().join("copy.usda"));
//! # std::fs::write(&fox, "#usda 1.0\ndef BasisCurves \"c\" { uniform token type = \"linear\" int[] curveVertexCounts = [2]
//! #     point3f[] points = [(0,0,0), (1,0,0)] }")?;
//! let options = Options { default_width: Some(0.002), ..Options::default() };
//! let reading = read(&fox, &options)?;
//! for warning in &reading.warnings {
//!     eprintln!("{warning}");
//! }
//! write(&reading.scene, &copy)?;
//! # Ok(()) }
//! ```
//!
//! # What is read
//! - **BasisCurves**: linear, B-spline, Catmull–Rom and Bézier; nonperiodic and pinned; widths (diameters) of any interpolation;
//!   the uv of roots from `primvars:st`, `uv` or `surface_uv_coordinate` (Blender's).
//! - **VellusFur**, the shader of a fibre: `info:id = "VellusFur"`, connected to `outputs:vellus:surface` or `outputs:surface` of the
//!   material. `inputs:preset` names a [`vellus::Species`]; every [`vellus_scene::Parameter`] has an input of its key, angles
//!   in degrees. An input may be connected to a UsdUVTexture (looked up at the root's uv) or to a UsdPrimvarReader.
//!   `primvars:vellus:KEY` on curves, of any interpolation, goes before the shader.
//!   A constant input outside its range ([`vellus_scene::Parameter::range`]) is an error, a primvar outside it a
//!   warning: the nearest value in the range is taken. This also happens, without a warning, to what a texture gives
//!   and to values between points.
//! - **Mesh** as polygons, **UsdPreviewSurface** (diffuseColor, also by texture, emissiveColor, roughness, metallic, ior), **Camera**,
//!   **DomeLight**, **DistantLight**, **RectLight**, **DiskLight**, **SphereLight**, **CylinderLight**.
//!   `vellus:lightGroup` names a light's group, else its prim does; `vellus:groundHeight` and `vellus:groundRadius` lay
//!   a dome's image on the ground ([`vellus_scene::Ground`]).
//! - Materials bound directly or by collections (those of included and excluded prims; expressions are not evaluated).
//! - Composition, instances, transforms, visibility, purpose, samples in time, velocities and accelerations. Textures as PNG, Radiance HDR and OpenEXR;
//!   they repeat unless wrapS and wrapT of UsdUVTexture say clamp, mirror or black.
//!
//! All else that would be seen is named in a [`Warning`]. Lengths are in the scene's unit, whatever `metersPerUnit` says.
//!
//! # Limits
//! A stage has at most 65,536 files of 16 GiB together, and 262,144 composed sites (prims and the references they
//! bring). An image has at most 2²⁷ pixels. A package (.usdz) stores its files without compression, as the format
//! requires; packages in packages are not read. Coordinates are within ±10⁹ scene units
//! ([`vellus_scene::MAX_COORDINATE`]). Devices are not read.

mod error;
mod guard;
mod image;
mod read;
mod stage;
mod warning;
mod write;

pub use error::Error;
pub use guard::quiet_caught_panics;
pub use image::{load_map, load_texture};
pub use read::look::FALLBACK_LOOK;
pub use read::{Options, Reading, read};
pub use warning::Warning;
pub use write::write;
