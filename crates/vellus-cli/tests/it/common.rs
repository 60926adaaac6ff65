//! Runs the command and reads its output.

use exr::prelude::*;
use std::path::Path;
use std::process::{Command, Output, Stdio};
pub use vellus_testing::program::{LIMIT, Limited, Running, wait_until};

/// Where a program keeps what it rescued. The tests must not find what is in the user's folder.
pub const STATE: &str = if cfg!(windows) { "LOCALAPPDATA" } else { "XDG_STATE_HOME" };

/// The command, in a folder, without input.
pub fn command(folder: &Path, args: &[&str]) -> Command {
    piped(Command::new(env!("CARGO_BIN_EXE_vellus")), folder, args)
}

/// Runs a shell script in which `"$@"` is the command.
pub fn shell(folder: &Path, script: &str, args: &[&str]) -> Command {
    let mut command = Command::new("sh");
    command.args(["-c", script, "sh", env!("CARGO_BIN_EXE_vellus")]);
    piped(command, folder, args)
}

fn piped(mut command: Command, folder: &Path, args: &[&str]) -> Command {
    command.env(STATE, std::path::absolute(folder).unwrap().join("state"));
    command.current_dir(folder).args(args).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

pub fn vellus(folder: &Path, args: &[&str]) -> Output {
    command(folder, args).run().unwrap()
}

/// Runs a command that must succeed. Returns its standard error.
pub fn run(folder: &Path, args: &[&str]) -> String {
    let output = vellus(folder, args);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{args:?}: {errors}");
    errors
}

/// Runs a command that must fail with exit code 2 and a message that contains all of `parts`.
pub fn refused(folder: &Path, args: &[&str], parts: &[&str]) {
    refused_by(&vellus(folder, args), args, parts);
}

pub fn refused_by(output: &Output, args: &[&str], parts: &[&str]) {
    ended_by(output, 2, args, parts);
}

/// Checks an exit code, and that the message contains all of `parts`.
pub fn ended_by(output: &Output, code: i32, args: &[&str], parts: &[&str]) {
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{args:?}: {message}");
    for part in parts {
        assert!(message.contains(part), "{args:?}: '{part}' is not in: {message}");
    }
}

/// A .tfx file of strands with the same number of points.
pub fn tfx(strands: &[Vec<[f32; 3]>]) -> Vec<u8> {
    let numbers = strands.iter().flatten().flat_map(|[x, y, z]| [*x, *y, *z, 1.0]);
    vellus_testing::tfx(4.0, [strands.len(), strands[0].len()], numbers, false)
}

/// Names of an OpenEXR file's channels and their values, and its notes.
pub struct Picture {
    pub channels: Vec<(String, Vec<f32>)>,
    pub notes: Vec<(String, String)>,
}

impl Picture {
    pub fn read(path: &Path) -> Picture {
        let read = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer();
        let layer = read.all_attributes().from_file(path).unwrap().layer_data;
        let values = |samples: &FlatSamples| samples.values_as_f32().collect();
        let channels = layer.channel_data.list.iter().map(|c| (c.name.to_string(), values(&c.sample_data))).collect();
        let text = |value: &AttributeValue| match value {
            AttributeValue::Text(text) => String::from_utf8_lossy(text.as_slice()).into_owned(),
            other => format!("{other:?}"),
        };
        let notes = layer.attributes.other.iter().map(|(name, value)| (name.to_string(), text(value))).collect();
        Picture { channels, notes }
    }

    pub fn names(&self) -> Vec<&str> {
        self.channels.iter().map(|(name, _)| name.as_str()).collect()
    }

    pub fn note(&self, name: &str) -> &str {
        self.notes.iter().find(|(n, _)| n == name).map_or("", |(_, value)| value)
    }

    /// Whether all channels are bit-identical.
    pub fn same(&self, other: &Picture) -> bool {
        let bits = |p: &Picture| -> Vec<(String, Vec<u32>)> {
            p.channels.iter().map(|(n, v)| (n.clone(), v.iter().map(|x| x.to_bits()).collect())).collect()
        };
        bits(self) == bits(other)
    }
}
