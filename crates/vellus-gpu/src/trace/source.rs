//! The text of the path tracer: the files of `shaders/trace`, and what depends on the scene.

use crate::library::{FAR_FIELD, shader_library};
use std::fmt::Write;
use std::ops::Range;
use vellus_render::Mode;

/// The files of the path tracer, in the order in which they are joined.
const FILES: [&str; 8] = [
    include_str!("../../shaders/trace/scene.wgsl"),
    include_str!("../../shaders/trace/sampler.wgsl"),
    include_str!("../../shaders/trace/curves.wgsl"),
    include_str!("../../shaders/trace/intersect.wgsl"),
    include_str!("../../shaders/trace/surface.wgsl"),
    include_str!("../../shaders/trace/lights.wgsl"),
    include_str!("../../shaders/trace/path.wgsl"),
    include_str!("../../shaders/trace/kernels.wgsl"),
];

/// The entry points.
pub(super) const KERNELS: [&str; 5] = ["begin_paths", "trace_rays", "empty_lists", "shade_strands", "shade_others"];

/// The bindings before those of the arrays, and whether a shader writes to them.
pub(super) const FIXED: [bool; 6] = [true, true, true, true, false, false];

/// The bytes of a path that waits, without and with the shares of its lobes.
pub(super) const STATE_BYTES: [u64; 2] = [384, 624];

/// The functions that the path tracer calls at a hit of a fibre: with the near field, the far field, and both.
const NEAR: &str = include_str!("../../shaders/trace/near.wgsl");
const FAR: &str = include_str!("../../shaders/trace/far.wgsl");
const BOTH: &str = include_str!("../../shaders/trace/both.wgsl");

/// An array of rows of four numbers. If it is larger than a buffer may be, it is split into several buffers.
pub(super) struct Array {
    /// The function that reads a row.
    name: &'static str,
    kind: &'static str,
    /// The rows of a part are 2 to this power.
    bits: u32,
    parts: usize,
}

impl Array {
    /// `limit`: the most bytes of a buffer.
    pub fn new(name: &'static str, kind: &'static str, rows: usize, limit: u64) -> Self {
        // One part if it fits: the shader then needs no choice.
        let bits = (limit / 16).max(1).ilog2().min(31);
        let parts = if rows as u64 * 16 <= limit { 1 } else { rows.div_ceil(1 << bits) };
        Array { name, kind, bits, parts }
    }

    pub fn parts(&self) -> usize {
        self.parts
    }

    /// The rows of a part of an array with this number of rows.
    pub fn rows_of(&self, part: usize, rows: usize) -> Range<usize> {
        if self.parts == 1 { 0..rows } else { part << self.bits..((part + 1) << self.bits).min(rows) }
    }

    /// The bindings from `binding`, and the function that reads a row.
    fn declare(&self, binding: &mut u32) -> String {
        let Array { name, kind, bits, parts } = self;
        let mut text = String::new();
        for part in 0..*parts {
            let _ =
                writeln!(text, "@group(0) @binding({binding}) var<storage, read> {name}s_{part}: array<vec4<{kind}>>;");
            *binding += 1;
        }
        let _ = writeln!(text, "fn {name}(row: u32) -> vec4<{kind}> {{");
        if *parts > 1 {
            let mask = (1u64 << bits) - 1;
            let _ = writeln!(text, "    switch row >> {bits}u {{");
            for part in 1..*parts {
                let _ = writeln!(text, "        case {part}u: {{ return {name}s_{part}[row & {mask}u]; }}");
            }
            let _ = writeln!(text, "        default: {{}}\n    }}");
        }
        let _ = writeln!(text, "    return {name}s_0[row];\n}}");
        text
    }
}

/// The whole shader for a scene with these arrays. The bindings are the results, the paths that wait, lists of them and
/// their lengths, the samples to trace, the tables, and the arrays in their order. `far` is the array with the tables
/// of the far field, if every hit uses it instead of the near field.
///
/// `features` say what the scene has. They are constants, so that compilers leave out the code of what it lacks.
/// `stack` is the number of nodes that can wait.
pub(super) fn shader(
    arrays: &[Array],
    mode: Mode,
    far: Option<&Array>,
    features: &[(&str, bool)],
    stack: usize,
) -> String {
    let mut text = shader_library();
    text.push_str(
        "
@group(0) @binding(0) var<storage, read_write> samples: array<u32>;
@group(0) @binding(1) var<storage, read_write> states: array<State>;
@group(0) @binding(2) var<storage, read_write> lists: array<u32>;
// The lengths of the lists, and 1 after rays are traced.
@group(0) @binding(3) var<storage, read_write> counts: array<atomic<u32>, 4>;
@group(0) @binding(4) var<storage, read> work: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> tables: array<vec4<f32>>;
fn vellus_table(row: u32) -> vec4<f32> { return tables[row]; }
fn read_word(index: u32) -> u32 { return samples[index]; }
fn write_word(index: u32, value: u32) { samples[index] = value; }
",
    );
    let mut binding = FIXED.len() as u32;
    for array in arrays.iter().chain(far) {
        text.push_str(&array.declare(&mut binding));
    }
    // Mesa's drivers keep arrays of up to 256 bytes in registers, which are few: the stacks must be larger.
    let _ = writeln!(text, "const STACK = {}u;", stack.max(65));
    for (name, value) in vellus_render::packed::constants() {
        let _ = writeln!(text, "const {name} = {value};");
    }
    let _ = writeln!(text, "const MODE = {}u;\nconst HAS_TABLES = {};", mode as u32, far.is_some());
    for (name, value) in features {
        let _ = writeln!(text, "const {name} = {value};");
    }
    // An array has at least one element.
    let lobes = if features.contains(&("HAS_LOBES", true)) { 6 } else { 1 };
    let _ = writeln!(text, "const LOBES = {lobes}u;");
    let numbers: Vec<String> = sobol_directions().iter().map(|direction| format!("{direction}u")).collect();
    let _ = writeln!(text, "const SOBOL_DIRECTIONS = array<u32, 48>({});", numbers.join(", "));
    let field: &[&str] = match (far, mode) {
        (None, _) => &[NEAR],
        (Some(_), Mode::Far) => &[FAR_FIELD, FAR],
        (Some(_), _) => &[FAR_FIELD, BOTH],
    };
    for file in FILES.iter().chain(field) {
        text.push('\n');
        text.push_str(file);
    }
    text
}

/// The direction numbers of the dimensions 1 to 3 of the Sobol' sequence for indices of 16 bits, with the initial
/// numbers of Joe and Kuo 2008, Constructing Sobol Sequences with Better Two-Dimensional Projections.
fn sobol_directions() -> [u32; 48] {
    // The degree of the primitive polynomial, its inner coefficients, and the initial numbers.
    const POLYNOMIALS: [(usize, u32, [u32; 3]); 3] = [(1, 0, [1, 0, 0]), (2, 1, [1, 3, 0]), (3, 1, [1, 3, 1])];
    let mut all = [0; 48];
    for (directions, (degree, inner, initial)) in all.chunks_exact_mut(16).zip(POLYNOMIALS) {
        for k in 0..16 {
            directions[k] = if k < degree {
                initial[k] << (31 - k)
            } else {
                let mut direction = directions[k - degree] ^ (directions[k - degree] >> degree);
                for j in 1..degree {
                    if inner >> (degree - 1 - j) & 1 == 1 {
                        direction ^= directions[k - j];
                    }
                }
                direction
            };
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use vellus_render::packed::FEATURES;

    /// In each dimension, and in each pair of dimensions 0 and 1, the first 2ⁿ points are stratified.
    #[test]
    fn the_sequence_is_stratified() {
        let directions = sobol_directions();
        let point = |index: u32, dimension: usize| match dimension {
            0 => index.reverse_bits(),
            _ => {
                (0..16).filter(|bit| index >> bit & 1 == 1).fold(0, |x, bit| x ^ directions[16 * (dimension - 1) + bit])
            }
        };
        for dimension in 0..4 {
            let mut found: Vec<u32> = (0..256).map(|i| point(i, dimension) >> 24).collect();
            found.sort_unstable();
            assert!(found.into_iter().eq(0..256), "dimension {dimension}");
        }
        // The first two dimensions are a (0, m, 2)-net: every box of 2⁻ᵃ × 2⁻ᵇ with a + b = 8 has one point of 256.
        for a in 1..8 {
            let cells = (0..256).map(|i| (point(i, 0) >> (32 - a)) << (8 - a) | point(i, 1) >> (24 + a));
            let mut cells: Vec<u32> = cells.collect();
            cells.sort_unstable();
            assert!(cells.into_iter().eq(0..256), "{a}");
        }
    }

    /// The shaders are valid, and the states have the size that the tracer allocates. No GPU is needed for this.
    #[test]
    fn all_modes_are_valid_shaders() {
        let rows = |name, kind| Array::new(name, kind, 1, 1 << 20);
        let mut arrays: Vec<Array> =
            ["node_row", "chord_row", "triangle_row", "data_row"].map(|name| rows(name, "u32")).into();
        arrays.extend(["point_row", "vellus_row"].map(|name| rows(name, "f32")));
        let far = &rows("vellus_far_row", "f32");
        let all = [(Mode::Near, None, false), (Mode::MultiScale, None, true), (Mode::Far, None, true)];
        for (mode, far, all) in all.into_iter().chain([Mode::MultiScale, Mode::Far].map(|mode| (mode, Some(far), true)))
        {
            let text = shader(&arrays, mode, far, &FEATURES.map(|name| (name, all)), 9);
            let module = naga::front::wgsl::parse_str(&text).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&text)));
            let state = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some("State")).unwrap().0;
            let mut layouter = naga::proc::Layouter::default();
            layouter.update(module.to_ctx()).unwrap();
            assert_eq!(u64::from(layouter[state].to_stride()), STATE_BYTES[usize::from(all)]);
            let mut validator = naga::valid::Validator::new(Default::default(), Default::default());
            validator.validate(&module).unwrap_or_else(|e| panic!("{}", e.emit_to_string(&text)));
        }
    }

    #[test]
    fn large_arrays_are_split() {
        let array = Array::new("node_row", "u32", 1000, 4096);
        assert_eq!((array.parts(), array.rows_of(3, 1000)), (4, 768..1000));
        let mut binding = 3;
        let text = array.declare(&mut binding);
        assert!(
            text.contains("@binding(6) var<storage, read> node_rows_3") && text.contains("node_rows_3[row & 255u]")
        );
        assert_eq!(binding, 7);
        assert_eq!(Array::new("node_row", "u32", 1000, 16_000).parts(), 1);
    }
}
