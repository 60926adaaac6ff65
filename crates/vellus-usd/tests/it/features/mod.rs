//! Tests of single schemas and attributes.

mod bindings;
mod cameras;
mod curves;
mod faults;
mod fibers;
mod images;
mod instances;
mod ledger;
mod lights;
mod links;
mod materialx;
mod meshes;
mod motion;
mod own_node;
mod primvars;
mod settings;
mod shading;
mod shapes;
mod skeletons;
mod splines;
mod stages;
mod subdivision;
mod surfaces;
mod syntax;
mod transforms;

use crate::common::read_text;
use vellus_scene::Scene;
use vellus_usd::{Options, Warning};

/// A curve of four points along x, one unit apart, from 0.
const FOUR: &str = "int[] curveVertexCounts = [4]
    point3f[] points = [(0,0,0), (1,0,0), (2,0,0), (3,0,0)]
    float[] widths = [0.2] (interpolation = \"constant\")";

/// Reads a stage of one layer with the default options.
fn scene(body: &str) -> (Scene, Vec<Warning>) {
    read_text(body, &Options::default()).unwrap()
}

/// All warnings, one a line.
fn said(warnings: &[Warning]) -> String {
    warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}
