//! The text of the library, and its buffers.

use std::fmt::Write;
use vellus::packed::{self, COATS, COLOR_LAYOUT, COLOR_ROWS, FIBER_LAYOUT, FIBER_ROWS};
use vellus::parts::{ABSORPTIONS, EUMELANIN, MAX_SIN2, MOST_TURN, PHEOMELANIN, STATES, STEEP};
use vellus::{Bcsdf, Tables};

/// The files of the library, in the order in which they are joined.
pub const SHADERS: [(&str, &str); 10] = [
    ("special.wgsl", include_str!("../shaders/special.wgsl")),
    ("lookup.wgsl", include_str!("../shaders/lookup.wgsl")),
    ("model.wgsl", include_str!("../shaders/model.wgsl")),
    ("path.wgsl", include_str!("../shaders/path.wgsl")),
    ("lobes.wgsl", include_str!("../shaders/lobes.wgsl")),
    ("medulla.wgsl", include_str!("../shaders/medulla.wgsl")),
    ("color.wgsl", include_str!("../shaders/color.wgsl")),
    ("turn.wgsl", include_str!("../shaders/turn.wgsl")),
    ("draw.wgsl", include_str!("../shaders/draw.wgsl")),
    ("reduced.wgsl", include_str!("../shaders/reduced.wgsl")),
];

/// The part of the library for the far field. Append it to [`shader_library`] where it is used: it needs one more
/// function, `vellus_far_row`.
pub const FAR_FIELD: &str = include_str!("../shaders/far.wgsl");

/// The reduced model for real time by itself: a text in WGSL without bindings and entry points, which needs no tables,
/// no records and no functions. [`shader_library`] contains it.
pub fn reduced_library() -> String {
    let [(_, special), .., (_, reduced)] = SHADERS;
    format!("// The Vellus model of hair and fur, reduced. Licence: MIT or Apache-2.0.\n\n{special}\n{reduced}")
}

/// A shader of a compute pass that uses the library: one query per thread. It shows the bindings.
pub const QUERIES: &str = include_str!("../shaders/queries.wgsl");

/// The same in the far field, for the library with [`FAR_FIELD`].
pub const FAR_QUERIES: &str = include_str!("../shaders/far_queries.wgsl");

/// Which part of a fibre a query sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// One offset on the fibre: [`QUERIES`].
    Near,
    /// The whole width of the fibre: [`FAR_QUERIES`].
    Far,
}

impl Field {
    /// The library with the compute shader of this field.
    pub fn shader(self) -> String {
        match self {
            Field::Near => format!("{}\n{QUERIES}", shader_library()),
            Field::Far => format!("{}\n{FAR_FIELD}\n{FAR_QUERIES}", shader_library()),
        }
    }

    /// The name of the entry point.
    pub fn entry(self) -> &'static str {
        match self {
            Field::Near => "run_queries",
            Field::Far => "run_far_queries",
        }
    }
}

/// The library: a text in WGSL without bindings and entry points.
///
/// The constants at its beginning say where the parts of [`shader_tables`] are.
pub fn shader_library() -> String {
    let mut text = String::from("// The Vellus model of hair and fur. Licence: MIT or Apache-2.0.\n\n");
    let packed = packed::tables(Tables::shipped());
    let mut line = |name: &str, value: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "const VELLUS_{name} = {value};");
    };
    line("FIBER_ROWS", format!("{FIBER_ROWS}u"));
    line("COLOR_ROWS", format!("{COLOR_ROWS}u"));
    for layout in [&FIBER_LAYOUT[..], &COLOR_LAYOUT] {
        let mut start = 0;
        for (name, rows, what) in layout {
            line(name, format!("{start}u; // {rows}: {what}"));
            start += rows;
        }
    }
    for (name, count) in [("STATES", STATES), ("PATHS", ABSORPTIONS), ("COATS", COATS)] {
        line(name, format!("{count}u"));
    }
    line("MOST_SIN2", format!("{MAX_SIN2:?}"));
    line("MOST_TURN", format!("{MOST_TURN:?}"));
    line("STEEP", format!("vec2<f32>({:?}, {:?})", STEEP[0], STEEP[1]));
    for (name, [r, g, b]) in [("EUMELANIN", EUMELANIN), ("PHEOMELANIN", PHEOMELANIN)] {
        line(name, format!("vec3<f32>({r:?}, {g:?}, {b:?})"));
    }
    for (name, count) in packed.counts {
        line(&name, format!("{count}u"));
    }
    for (name, value) in packed.constants {
        line(&name, format!("{value:?}"));
    }
    for (_, part) in SHADERS {
        text.push('\n');
        text.push_str(part);
    }
    text
}

/// The tables, in rows of four numbers: the contents of the buffer that `vellus_table` reads. 1.8 MB.
pub fn shader_tables() -> Vec<[f32; 4]> {
    packed::tables(Tables::shipped()).rows
}

/// [`shader_tables`] in half precision (IEEE 754 binary16): 0.9 MB. A shader reads a row as two words, with
/// `unpack2x16float`.
pub fn shader_tables_half() -> Vec<[u16; 4]> {
    packed::tables(Tables::shipped()).half_precision()
}

/// One fibre, in rows of four numbers. The buffer that `vellus_row` reads holds these for each fibre, one after
/// another.
pub fn shader_fiber(bcsdf: &Bcsdf<'_>) -> [[f32; 4]; FIBER_ROWS] {
    packed::fiber(bcsdf)
}

/// What one fibre needs beside [`shader_fiber`] for other absorption at each hit, `vellus_hit_colored`, in rows of four
/// numbers. It lies in the same buffer, and the shader gets its first row. It takes about a hundred times as long to
/// make as [`Bcsdf::new`].
pub fn shader_color(bcsdf: &Bcsdf<'_>) -> [[f32; 4]; COLOR_ROWS] {
    packed::color(bcsdf)
}

/// The far field of one fibre, in rows of four numbers: a table that `vellus_far_row` reads (Yan17 Sec. 5).
///
/// Several tables may lie in one buffer. `vellus_far_hit` takes the first row of one. It errs by at most 1 % of the
/// largest value at nearly all inclinations. It takes 0.3 to 2.2 MB for a preset, and up to 18 MB where β_n is below
/// 3°.
pub fn shader_far_table(bcsdf: &Bcsdf<'_>) -> Vec<[f32; 4]> {
    packed::far(bcsdf).rows
}
