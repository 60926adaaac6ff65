//! `vellus groom grow`: grows fur on a mesh.

use crate::fiber_args::{FiberArgs, Overrides};
use crate::output;
use crate::render::{explain, warn};
use crate::say::say;
use anyhow::Result;
use std::path::PathBuf;
use vellus::Color;
use vellus_groom::{Group, read_groups};
use vellus_io::parse;
use vellus_open::{Grown, Growth, Skin};
use vellus_scene::Look;

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
    /// File to write, .usda or .usdc. The latter is smaller and faster.
    #[arg(short, long, default_value = "out/groom.usda", value_name = "FILE")]
    output: PathBuf,
    /// Mesh to grow on: its name, or the end of its path. Required if the file has several meshes. May be repeated.
    #[arg(long = "on", value_name = "MESH")]
    on: Vec<String>,
    /// Settings file (TOML) with groups of strands. Options on the command line override those of all groups.
    #[arg(long, value_name = "FILE")]
    settings: Option<PathBuf>,
    /// Seed of the random numbers.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = parse::whole::<u64>(0..=u64::MAX))]
    seed: u64,
    /// Colour of the skin: auto (that of the fur, darkened), a name, #rrggbb, or R,G,B [default: auto for .obj; USD
    /// meshes keep theirs].
    #[arg(long, value_name = "COLOR")]
    skin: Option<Skin>,
    /// Write only the strands, without the rest of the scene.
    #[arg(long)]
    strands_only: bool,
    /// End with an error if there is a warning about the mesh or an image. For farms and checks.
    #[arg(long)]
    strict: bool,
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
    output::check_extension(&args.output, &["usda", "usdc"])?;
    let options = args.fur.clone();
    let groups = match &args.settings {
        Some(path) => read_groups(path)?.into_iter().map(|group| options.clone().or(group)).collect(),
        None => vec![options],
    };
    let groups = groups.into_iter().map(|group| Ok((group.clone(), look(args, &group)?))).collect::<Result<_>>()?;
    let Args { seed, strands_only, skin, .. } = *args;
    let growth = Growth { groups, meshes: args.on.clone(), seed, skin, strands_only };
    // Before the mesh is read.
    growth.check()?;
    output::writable(&args.output)?;
    let mut warnings = Vec::new();
    let grown = growth.grow(&args.mesh, |warning| warnings.push(warning.clone()));
    warn(&warnings, args.strict)?;
    let grown = grown.map_err(explain)?;
    vellus_usd::write(&grown.scene, &args.output)?;
    let Grown { strands, segments, .. } = grown;
    let output = args.output.display();
    say!("{strands} strands, {segments} segments\nwrote {output}\nNext: vellus render {output}");
    Ok(())
}

/// The fibre of a group: from the command line, else from the settings file, else a brown one.
fn look(args: &Args, group: &Group) -> Result<Look> {
    let given = args.fiber.as_ref().or(group.fiber.as_ref());
    // Presets are grey, as the fits of the paper.
    let fiber = given.cloned().unwrap_or_else(|| "dog".into());
    let set = [group.settings_of_fiber(), args.overrides.set.clone()].concat();
    let fiber_args = FiberArgs { fiber: Some(fiber), overrides: Overrides { set } };
    let mut fiber = fiber_args.load()?;
    if given.is_none() && !fiber_args.source().sets_color() {
        fiber = fiber.with_color(Color::Reflectance([0.35, 0.16, 0.06]))?;
    }
    Ok(Look::constant(fiber_args.name(), fiber))
}
