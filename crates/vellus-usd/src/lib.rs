//! Reads and writes scenes of hair and fur as USD.
//!
//! [`read()`] turns a file (.usda, .usdc or .usdz) into a [`vellus_scene::Scene`]. [`write()`] stores a scene as
//! .usda or .usdc.
//!
//! ```
//! use vellus_usd::{Options, read, write};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//! # let (fox, copy) = (folder.path().join("fox.usda"), folder.path().join("copy.usda"));
//! # std::fs::write(&fox, "#usda 1.0\ndef BasisCurves \"c\" { uniform token type = \"linear\"
//! #     int[] curveVertexCounts = [2] point3f[] points = [(0,0,0), (1,0,0)] }")?;
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
//! - **BasisCurves**: linear, B-spline, Catmull–Rom and Bézier, nonperiodic, pinned or periodic; **HermiteCurves**
//!   and **NurbsCurves**.
//!   Widths (diameters) may have any interpolation. The uv of the roots come from the primvar that the shader names, or
//!   from `primvars:st`, `uv` or `surface_uv_coordinate` (Blender). `displayColor` colours curves without a material.
//! - **VellusFur**, the shader of a fibre: `info:id = "VellusFur"`, connected to `outputs:vellus:surface` or
//!   `outputs:surface` of the material. `inputs:preset` is a name of [`vellus::Fiber::named`]. Every
//!   [`vellus_scene::Parameter`] has an input named by its key. Angles are in degrees. An input may be connected to a
//!   UsdUVTexture, which is sampled at the uv of the root, or to a UsdPrimvarReader. `primvars:vellus:KEY` on curves,
//!   of any interpolation, overrides the shader. A constant input or a primvar
//!   outside its range ([`vellus_scene::Parameter::range`]) gives a warning and is clamped.
//!   Values of textures and values between points are clamped without a warning.
//! - Shaders of other programs for hair: `ND_chiang_hair_bsdf` (MaterialX), `arnold:standard_hair`, `kma_hair` and
//!   `kma_fur` (Karma), `PxrMarschnerHair` (RenderMan), and the colour of UsdPreviewSurface on curves. A warning
//!   reports what was mapped. [`Options::network_base`] gives the parameters that they lack. A layer may be a MaterialX
//!   document (.mtlx): its materials are children of `/MaterialX/Materials`.
//! - **Mesh** as polygons or as a subdivision surface: Catmull–Clark (the default of USD), Loop or bilinear, with
//!   creases, corners and holes. It is refined until its edges are short in the picture, then moved to the limit.
//! - **Sphere**, **Cube**, **Cylinder**, **Cone**, **Capsule** and **Plane**, as meshes; **Points** as spheres.
//! - **UsdPreviewSurface** (diffuseColor as a constant or a texture, emissiveColor, roughness, metallic, ior), and the
//!   same of standard_surface (MaterialX, Arnold) and OpenPBR. **Camera**, **DomeLight**, **DistantLight**,
//!   **RectLight**, **DiskLight**, **SphereLight** and **CylinderLight**. `vellus:lightGroup` names the group of a
//!   light; without it the group has the name of the prim.
//!   `vellus:groundHeight` and `vellus:groundRadius` project the image of a dome onto the ground
//!   ([`vellus_scene::Ground`]). A light is invisible to the camera if one of these is false or 0:
//!   `primvars:ri:attributes:visibility:camera` (RenderMan), `primvars:arnold:camera` (Arnold),
//!   `karma:light:renderlightgeo` (Karma), `visibleInPrimaryRay` (NVIDIA RTX). UsdLux has no such attribute.
//! - Materials that are bound directly or by collections. Collections list included and excluded prims, or have an
//!   expression of paths without predicates.
//! - Native instances and **PointInstancer**, which share their strands and meshes if [`Options::instances`] is true.
//! - **SkelRoot**, **Skeleton**, **SkelAnimation** and **BlendShape**: skinning of meshes, curves and shapes,
//!   linear or by dual quaternions, when the shutter opens and closes. As in OpenUSD, prims need the SkelBindingAPI for
//!   their binding.
//! - Composition, transforms, visibility, purpose, time samples, splines of text layers, velocities and accelerations.
//! - Textures as PNG, Radiance HDR and OpenEXR. They repeat unless wrapS and wrapT of UsdUVTexture are clamp, mirror or
//!   black.
//!
//! A [`Warning`] names everything else that would be visible, and every part that could not be read and was left out or
//! replaced ([`Fault`]). Only a file of which nothing can be shown, and what [`Options`] names, are errors. Lengths
//! stay in the unit of the scene, whatever `metersPerUnit` is.
//!
//! # Limits
//! A stage has at most 65,536 files with 16 GiB in total. It has at most 100,000 composed sites (prims and the
//! references they bring), and one more for each 32 bytes of its files, up to 262,144. Each prim of an instance that
//! repeats the content of another one counts as two. Classes form chains of at most 100, and so do references. A list
//! has at most 1000 arcs, text at most 500 nested brackets, and an expression 100. An image has at most 2²⁷ pixels.
//! Subdivision brings at most 2²¹ faces a mesh and 2²² a stage, beyond one level. All images and the tables of lights
//! have at most 2 GiB, and 64 bytes more for each byte of the image files. A MaterialX document has at most 2²⁰ XML
//! nodes, 64 levels, 256 attributes an element, and 64 nested definitions of nodes. A chain has at most 128
//! connections. A package (.usdz) stores its files without compression, as the format requires. Packages inside
//! packages are not read. Coordinates are within ±10⁹ scene units ([`vellus_scene::MAX_COORDINATE`]). Devices are not
//! read.
#![warn(clippy::print_stdout)]

mod color;
mod error;
mod guard;
mod image;
mod read;
mod stack;
mod stage;
mod subdivide;
mod warning;
mod write;

pub use error::Error;
pub use guard::quiet_caught_panics;
pub use image::{load_map, load_sky, load_texture};
pub use read::look::FALLBACK_LOOK;
pub use read::{Options, Reading, RenderSettings, Shot, read, read_material};
pub use warning::{Fault, Warning};
pub use write::custom::fits;
pub use write::{Format, write, write_to};
