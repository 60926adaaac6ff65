//! `vellus groom grow`: fur on a mesh.

use super::coat::{self, Ground, Group};
use crate::fiber_args::{FiberArgs, Overrides};
use crate::number::whole;
use crate::output;
use crate::render::load_usd;
use crate::say::{note, say};
use anyhow::{Context, Result, bail};
use glam::Vec3;
use std::path::{Path, PathBuf};
use vellus::{Color, Fiber};
use vellus_groom::{GrowSettings, Maps, Site, area, grow, read_obj};
use vellus_scene::{Look, Mesh, Parameter, Scene, Surface, Texture, Tint, Value};

/// The fibre where nothing says which: its medulla does not absorb, so that it takes on any colour.
const FIBER: &str = "dog";
/// Its colour then, as a reflectance; presets are grey, as the paper's fits are.
const COLOR: [f32; 3] = [0.35, 0.16, 0.06];

/// Grow fur on a mesh.
///
/// Without options: 100,000 strands with guard hairs among them, their length in proportion to
/// the mesh. What else is in the file of the mesh (lights, camera, other meshes, strands) stays.
///
/// A settings file has groups, each with the options' names (_ for -) and `fiber`:
///
///     [[group]]
///     name = "undercoat"
///     density = 400
///     length = 1.2
///     clump = 40
///
///     [[group]]
///     name = "guard"
///     density = 40
///     length = 2.5
///     width = 0.012
///     fiber = "raccoon"
///
/// Without --fiber the fur is that of a brown dog.
#[derive(clap::Args)]
#[command(verbatim_doc_comment, allow_negative_numbers = true)]
pub struct Args {
    /// Mesh: .usda, .usdc, .usdz or .obj.
    mesh: PathBuf,
    /// File to write, .usda.
    #[arg(short, long, default_value = "out/groom.usda", value_name = "FILE")]
    output: PathBuf,
    /// The mesh to grow on, by its name or the end of its path; needed where there are several. May be repeated.
    #[arg(long = "on", value_name = "MESH")]
    on: Vec<String>,
    /// Groups of strands, as TOML; options given beside it hold for all of them.
    #[arg(long, value_name = "FILE")]
    settings: Option<PathBuf>,
    /// Other seeds give other fur.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = whole::<u64>(0..=u64::MAX))]
    seed: u64,
    /// Write the strands alone, without what the file of the mesh has.
    #[arg(long)]
    strands_only: bool,
    /// A preset (see `vellus fiber list`), or a TOML or JSON file [default: a dog's, brown].
    #[arg(long, value_name = "NAME|FILE")]
    fiber: Option<PathBuf>,
    #[command(flatten)]
    overrides: Overrides,
    #[command(flatten, next_help_heading = "Fur")]
    group: Group,
}

/// Runs it.
pub fn run(args: &Args) -> Result<()> {
    output::check_extension(&args.output, &["usda"])?;
    let groups: Vec<Group> = match &args.settings {
        Some(path) => coat::read(path)?.into_iter().map(|group| args.group.clone().or(group)).collect(),
        None => vec![args.group.clone()],
    };
    // All that can be wrong without the mesh, before it is read. Of the area, only the number of strands depends.
    for group in &groups {
        fur(args, group)?;
        let area = group.density.filter(|density| *density > 0.0).map_or(1.0, |density| 1000.0 / f64::from(density));
        group.settings(&Ground { area, groups: groups.len(), up: Vec3::Y, seed: args.seed })?;
    }
    output::writable(&args.output)?;
    let mut scene = load(&args.mesh)?;
    let chosen = choose(&scene, &args.on)?;
    let mut skin = None;
    let z_up = scene.units.is_some_and(|units| units.z_up);
    let up = if z_up { Vec3::Z } else { Vec3::Y };
    let mut grown = Vec::new();
    for (i, group) in groups.iter().enumerate() {
        let plan = Plan::new(group)?;
        let meshes: Vec<&Mesh> = chosen.iter().map(|&m| &scene.meshes[m]).collect();
        if let (Some(image), Some(mesh)) = (plan.image, meshes.iter().find(|mesh| mesh.uv.is_none())) {
            bail!("{} has no uv, which {} is to be looked up at", mesh.name, image.display());
        }
        let density = |site: &Site| plan.density(site);
        let areas: Vec<f64> = meshes.iter().map(|mesh| area(mesh, &density)).collect::<Result<_, _>>()?;
        let seed = args.seed.wrapping_add((i as u64) << 32);
        let ground = Ground { area: areas.iter().sum(), groups: groups.len(), up, seed };
        let whole = group.settings(&ground)?;
        let mut look = fur(args, group)?;
        if let Some(path) = &group.color {
            let image = said(vellus_usd::load_texture(path)?);
            let dye = |&color: &[f32; 3]| dyed(&look.fiber, color);
            let dyes = Texture { pixels: image.pixels.iter().map(dye).collect::<Result<_, _>>()?, ..image.clone() };
            look.textured.push((Parameter::SigmaCa, Value { texture: scene.textures.len(), scale: [1.0; 3] }));
            scene.textures.push(dyes);
            skin.get_or_insert(image);
        }
        scene.looks.push(look);
        let mut planted = 0.0;
        for (k, &mesh) in chosen.iter().enumerate() {
            let mesh = &scene.meshes[mesh];
            // Shares that add up to the count.
            let upto = |area: f64| (area / ground.area * whole.count as f64).round() as usize;
            let count = upto(planted + areas[k]) - upto(planted);
            planted += areas[k];
            if count == 0 {
                continue;
            }
            let name = if chosen.len() > 1 { format!("{} {}", mesh.name, whole.name) } else { whole.name.clone() };
            let seed = whole.seed.wrapping_add((k as u64) << 40);
            let settings = GrowSettings { name, count, seed, ..whole.clone() };
            let comb = group.comb(up);
            let maps =
                Maps { density: &density, length: &|site| plan.length(site), comb: &|_| comb, ..Maps::default() };
            let mut strands = grow(mesh, &settings, &maps)?;
            strands.look = scene.looks.len() - 1;
            grown.push(strands);
        }
    }
    let [strands, segments] =
        [grown.iter().map(|s| s.len()).sum::<usize>(), grown.iter().map(|s| s.segments()).sum::<usize>()];
    if args.strands_only {
        let Scene { looks, textures, units, .. } = scene;
        scene = Scene { strands: grown, looks, textures, units, ..Scene::default() };
    } else {
        scene.strands.extend(grown);
        // An .obj file has no colours: its skin gets that of the fur.
        if let (true, Some(image), [surface]) = (is_obj(&args.mesh), skin, &mut scene.surfaces[..]) {
            surface.color = Tint { color: [0.5; 3], texture: Some(scene.textures.len()) };
            scene.textures.push(image);
        }
    }
    vellus_usd::write(&scene, &args.output)?;
    say!("{strands} strands, {segments} segments\nwrote {}", args.output.display());
    say!("Next: vellus render {} · vellus groom info {0}", args.output.display());
    Ok(())
}

fn is_obj(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj"))
}

fn load(path: &Path) -> Result<Scene> {
    if !is_obj(path) {
        // Strands without widths are not what is wanted of the file: they do not keep fur from growing.
        let mut scene = load_usd(path, &vellus_usd::Options { default_width: Some(0.0), ..Default::default() })?.scene;
        scene.strands.retain(|strands| {
            let has_width = strands.points.iter().any(|p| p.w > 0.0);
            if !has_width {
                note!("warning: {}: it has no widths, and is left out", strands.name);
            }
            has_width
        });
        return Ok(scene);
    }
    let bytes = vellus_io::read_at_most(path, vellus_groom::MAX_FILE_BYTES)
        .with_context(|| format!("cannot read {}", path.display()))?;
    let meshes = read_obj(&bytes, &path.display().to_string())?;
    Ok(Scene { meshes, surfaces: vec![Surface::diffuse("skin", [0.18; 3])], ..Scene::default() })
}

/// The fibre of a group: that of the command, or else of the settings file, or else a brown one.
fn fur(args: &Args, group: &Group) -> Result<Look> {
    let given = args.fiber.as_ref().or(group.fiber.as_ref());
    let fiber = given.cloned().unwrap_or_else(|| FIBER.into());
    let fiber_args = FiberArgs { fiber: Some(fiber), overrides: args.overrides.clone() };
    let mut fiber = fiber_args.load()?;
    if given.is_none() && !args.overrides.give_color() {
        fiber.sigma_ca = dyed(&fiber, COLOR)?;
    }
    Ok(Look::constant(fiber_args.name(), fiber))
}

/// The absorption that gives fur of this fibre a colour, roughly: light passes less cortex the wider the medulla is.
fn dyed(fiber: &Fiber, color: [f32; 3]) -> Result<[f32; 3], vellus::Error> {
    let held = color.map(|c| c.clamp(0.001, 0.999));
    let sigma = Color::Reflectance(held).absorption(fiber.beta_n)?;
    Ok(sigma.map(|sigma| (sigma / (1.0 - fiber.kappa)).min(1000.0)))
}

/// Indices of the meshes to grow on.
fn choose(scene: &Scene, wanted: &[String]) -> Result<Vec<usize>> {
    let names = || scene.meshes.iter().map(|mesh| mesh.name.as_str()).collect::<Vec<_>>().join(", ");
    if wanted.is_empty() {
        return match scene.meshes.len() {
            0 => bail!("there is no mesh to grow on"),
            1 => Ok(vec![0]),
            n => bail!("there are {n} meshes: say with --on which of {} to grow on", names()),
        };
    }
    let find = |name: &String| {
        let is_it = |mesh: &Mesh| mesh.name == *name || mesh.name.ends_with(&format!("/{name}"));
        let index = scene.meshes.iter().position(is_it);
        index.with_context(|| format!("there is no mesh '{name}' (there are: {})", names()))
    };
    let mut chosen: Vec<usize> = wanted.iter().map(find).collect::<Result<_>>()?;
    chosen.sort_unstable();
    chosen.dedup();
    Ok(chosen)
}

/// An image, after its warning was printed.
fn said((image, warning): (Texture, Option<vellus_usd::Warning>)) -> Texture {
    warning.iter().for_each(|warning| note!("warning: {warning}"));
    image
}

/// The maps of a group.
struct Plan<'a> {
    density: Option<Texture>,
    length: Option<Texture>,
    /// An image that is to be looked up at the uv, if there is any.
    image: Option<&'a Path>,
}

impl<'a> Plan<'a> {
    fn new(group: &'a Group) -> Result<Self> {
        let [density, length, color] = [&group.density_map, &group.length_map, &group.color].map(Option::as_deref);
        Ok(Plan {
            image: density.or(length).or(color),
            density: density.map(vellus_usd::load_map).transpose()?.map(said),
            length: length.map(vellus_usd::load_map).transpose()?.map(said),
        })
    }

    fn density(&self, site: &Site) -> f32 {
        let density = self.density.as_ref().map_or(1.0, |map| map.at(site.uv)[0]);
        if self.length(site) > 0.0 { density } else { 0.0 }
    }

    fn length(&self, site: &Site) -> f32 {
        self.length.as_ref().map_or(1.0, |map| map.at(site.uv)[0])
    }
}
