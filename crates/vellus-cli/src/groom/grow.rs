//! `vellus groom grow`: grows fur on a mesh.

use crate::fiber_args::{FiberArgs, Overrides};
use crate::number::whole;
use crate::output;
use crate::render::{explain, report};
use crate::say::{note, say};
use anyhow::Result;
use glam::Vec3;
use std::path::{Path, PathBuf};
use vellus_groom::{Coat, Ground, Group, absorption_of_color, plant, read_groups};
use vellus_open::{choose_meshes, open_coat, open_mesh};
use vellus_scene::{Look, Scene, Strands, Tint};

/// The default fibre. Its medulla does not absorb, so that it can have any colour.
const FIBER: &str = "dog";
/// The colour of the default fibre, as a reflectance. Presets are grey, as the fits of the paper.
const COLOR: [f32; 3] = [0.35, 0.16, 0.06];

/// Grow fur on a mesh.
///
/// Default: 100,000 strands of a brown dog's fur, with guard hairs. Their length is in
/// proportion to the mesh. Lights, camera, other meshes and strands of the file are kept.
///
/// A settings file has groups of strands, with the names of the options (_ for -) and `fiber`:
///
///     [[group]]
///     name = "undercoat"
///     density = 400
///     [[group]]
///     name = "guard"
///     fiber = "raccoon"
#[derive(clap::Args)]
#[command(verbatim_doc_comment, allow_negative_numbers = true)]
pub struct Args {
    /// Mesh: .usda, .usdc, .usdz or .obj.
    mesh: PathBuf,
    /// File to write, .usda.
    #[arg(short, long, default_value = "out/groom.usda", value_name = "FILE")]
    output: PathBuf,
    /// Mesh to grow on: its name, or the end of its path. Required if the file has several meshes. May be repeated.
    #[arg(long = "on", value_name = "MESH")]
    on: Vec<String>,
    /// Settings file (TOML) with groups of strands. Options on the command line override those of all groups.
    #[arg(long, value_name = "FILE")]
    settings: Option<PathBuf>,
    /// Seed of the random numbers.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = whole::<u64>(0..=u64::MAX))]
    seed: u64,
    /// Write only the strands, without the rest of the scene.
    #[arg(long)]
    strands_only: bool,
    /// A preset (see `vellus fiber list`), or a TOML or JSON file [default: a brown dog].
    #[arg(long, value_name = "NAME|FILE")]
    fiber: Option<PathBuf>,
    #[command(flatten)]
    overrides: Overrides,
    #[command(flatten, next_help_heading = "Fur")]
    fur: Group,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<()> {
    output::check_extension(&args.output, &["usda"])?;
    let options = args.fur.clone();
    let groups = match &args.settings {
        Some(path) => read_groups(path)?.into_iter().map(|group| options.clone().or(group)).collect(),
        None => vec![options],
    };
    // Check everything that does not need the mesh before reading it. The area matters only for the number of strands.
    for group in &groups {
        look(args, group)?;
        let area = group.density.filter(|density| *density > 0.0).map_or(1.0, |density| 1000.0 / f64::from(density));
        group.settings(&Ground { area, groups: groups.len(), up: Vec3::Y, seed: args.seed })?;
    }
    output::writable(&args.output)?;
    let mut scene = report(open_mesh(&args.mesh))?.scene;
    let chosen = choose_meshes(&scene, &args.on).map_err(explain)?;
    let coats: Vec<Coat> = groups.into_iter().map(|group| coat(args, group)).collect::<Result<_>>()?;
    let skin = coats.iter().find_map(|coat| coat.color.clone());
    let grown = plant(&mut scene, &chosen, coats, args.seed)?;
    let (strands, segments): (usize, usize) =
        (grown.iter().map(Strands::len).sum(), grown.iter().map(Strands::segments).sum());
    if args.strands_only {
        let Scene { looks, textures, units, .. } = scene;
        scene = Scene { strands: grown, looks, textures, units, ..Scene::default() };
    } else {
        scene.strands.extend(grown);
        // An .obj file has no colours: its skin gets the colour of the fur.
        if let (true, Some(image), [surface]) = (is_obj(&args.mesh), skin, &mut scene.surfaces[..]) {
            surface.color = Tint { color: [0.5; 3], texture: Some(scene.textures.len()) };
            scene.textures.push(image);
        }
    }
    vellus_usd::write(&scene, &args.output)?;
    let output = args.output.display();
    say!("{strands} strands, {segments} segments\nwrote {output}\nNext: vellus render {output}");
    Ok(())
}

/// A group with its fibre and images. Warnings are printed.
fn coat(args: &Args, group: Group) -> Result<Coat> {
    let look = look(args, &group)?;
    let (coat, warnings) = open_coat(group, look)?;
    warnings.iter().for_each(|warning| note!("warning: {warning}"));
    Ok(coat)
}

fn is_obj(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj"))
}

/// The fibre of a group: from the command line, else from the settings file, else a brown one.
fn look(args: &Args, group: &Group) -> Result<Look> {
    let given = args.fiber.as_ref().or(group.fiber.as_ref());
    let fiber = given.cloned().unwrap_or_else(|| FIBER.into());
    let fiber_args = FiberArgs { fiber: Some(fiber), overrides: args.overrides.clone() };
    let mut fiber = fiber_args.load()?;
    if given.is_none() && !args.overrides.give_color() {
        fiber.sigma_ca = absorption_of_color(&fiber, COLOR)?;
    }
    Ok(Look::constant(fiber_args.name(), fiber))
}
