//! Golden vectors: queries with the values of the double-precision oracle, in `vectors/` at the root of the repository.
//!
//! Tests of every language read the same files. `vectors/README.md` explains the columns.

use glam::Vec3;
use std::path::Path;
use vellus::{Fiber, Parameter, ScatterExit, Window};

/// The fibres and the queries.
pub struct Vectors {
    /// The fibres.
    pub fibers: Vec<Fiber>,
    /// The queries, in the order of their fibres.
    pub queries: Vec<Vector>,
}

/// A query and its value.
#[derive(Clone, Copy, Debug)]
pub struct Vector {
    /// The index of the fibre.
    pub fiber: usize,
    /// The window of offsets. Both ends are equal in the near field.
    pub window: [f32; 2],
    /// The direction to the camera.
    pub wo: Vec3,
    /// The direction to the light.
    pub wi: Vec3,
    /// f·cos θᵢ, RGB.
    pub value: [f32; 3],
    /// The largest error of a channel.
    pub tolerance: f32,
}

impl Vector {
    /// The window.
    pub fn window(&self) -> Window {
        let [low, high] = self.window;
        if low == high { Window::near(low) } else { Window::range(low, high) }
    }

    /// The largest error of a channel of `value`, divided by the tolerance.
    pub fn error(&self, value: [f32; 3]) -> f32 {
        let off = value.into_iter().zip(self.value).map(|(a, b)| (a - b).abs());
        // NaN is an error.
        off.fold(0.0, |most, off| if off <= most { most } else { off }) / self.tolerance
    }
}

/// The columns of the fibres: a name, the exit, then the stored parameters in the units of files. All are round,
/// and without air in the medulla.
pub fn fiber_columns() -> Vec<String> {
    let stored = Parameter::ALL
        .into_iter()
        .filter(|p| p.default_value().is_some() && p.varies())
        .filter(|p| !matches!(p, Parameter::MedullaPigment | Parameter::MedullaAir));
    let names = stored.flat_map(|p| (0..p.channels()).map(move |c| p.channel_name(c)));
    ["name", "exit"].map(str::to_owned).into_iter().chain(names).collect()
}

impl Vectors {
    /// Reads the files of the repository.
    ///
    /// # Panics
    /// If a file is missing or broken.
    pub fn read() -> Self {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vectors");
        let rows = |name: &str| -> Vec<Vec<String>> {
            let text = std::fs::read_to_string(folder.join(name)).expect("the golden vectors are in the repository");
            text.lines().skip(1).map(|line| line.split(',').map(str::to_owned).collect()).collect()
        };
        let number = |text: &String| -> f32 { text.parse().expect("a number") };
        let columns = fiber_columns();
        let fiber = |row: &Vec<String>| {
            let exit = ScatterExit::ALL.into_iter().find(|exit| exit.to_string() == row[1]).expect("an exit");
            let mut fiber = Fiber::hair().with_exit(exit);
            for (name, text) in columns.iter().zip(row).skip(2) {
                let (parameter, channel) = Parameter::parse(name).expect("a parameter");
                let mut value = parameter.get(&fiber).expect("a stored parameter");
                let x = parameter.unit().to_stored(number(text));
                match channel {
                    Some(channel) => value[channel] = x,
                    None => value = [x; 3],
                }
                parameter.set(&mut fiber, value).expect("a valid value");
            }
            fiber
        };
        let query = |row: &Vec<String>| {
            let x: Vec<f32> = row.iter().map(number).collect();
            Vector {
                fiber: x[0] as usize,
                window: [x[1], x[2]],
                wo: Vec3::from_slice(&x[3..6]),
                wi: Vec3::from_slice(&x[6..9]),
                value: [x[9], x[10], x[11]],
                tolerance: x[12],
            }
        };
        Vectors {
            fibers: rows("fibers.csv").iter().map(fiber).collect(),
            queries: rows("queries.csv").iter().map(query).collect(),
        }
    }
}
