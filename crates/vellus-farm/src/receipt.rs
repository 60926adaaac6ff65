//! Receipts: what identifies a result that is no film.

use crate::{Error, Plan, State, Task};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use vellus_io::Digest;

/// The largest receipt, in bytes.
const MAX_BYTES: u64 = 1 << 20;

/// What a finished task has written.
#[derive(Serialize, Deserialize)]
struct Receipt {
    /// [`Task::identity`].
    identity: String,
    /// The digest of each output.
    outputs: BTreeMap<String, String>,
}

fn path(plan: &Plan, task: &Task) -> PathBuf {
    plan.dir().join("receipts").join(format!("{}.json", task.name))
}

fn digest(path: &Path) -> std::io::Result<String> {
    Ok(Digest::of_reader(vellus_io::open_file(path)?)?.to_string())
}

/// Writes the receipt of a task whose outputs exist.
///
/// # Errors
/// [`Error::Read`] if an output is missing, [`Error::Write`].
pub fn write(plan: &Plan, task: &Task) -> Result<(), Error> {
    let mut outputs = BTreeMap::new();
    for output in &task.outputs {
        let file = plan.output(output);
        let digest = digest(&file).map_err(|source| Error::Read { path: file, source })?;
        outputs.insert(output.clone(), digest);
    }
    let receipt = Receipt { identity: task.identity.clone(), outputs };
    let path = path(plan, task);
    let written = serde_json::to_vec(&receipt).map_err(std::io::Error::other);
    let written = written.and_then(|bytes| vellus_io::write(&path, &bytes));
    written.map_err(|source| Error::Write { path, source })
}

/// The state of a task by its receipt, and why it is not finished.
pub fn state(plan: &Plan, task: &Task) -> (State, String) {
    let path = path(plan, task);
    let bytes = match vellus_io::read_at_most(&path, MAX_BYTES) {
        Ok(bytes) => bytes,
        // A link or a pipe.
        Err(error) if error.kind() == ErrorKind::InvalidInput => return (State::Damaged, error.to_string()),
        Err(_) => return (State::Missing, String::new()),
    };
    let Ok(receipt) = serde_json::from_slice::<Receipt>(&bytes) else {
        return (State::Damaged, format!("{} is no receipt", path.display()));
    };
    if receipt.identity != task.identity {
        return (State::Foreign, format!("{} is of other inputs", path.display()));
    }
    for output in &task.outputs {
        let file = plan.output(output);
        match digest(&file) {
            Ok(digest) if receipt.outputs.get(output) == Some(&digest) => {}
            Ok(_) => return (State::Damaged, format!("{} is not what was written", file.display())),
            Err(error) if error.kind() == ErrorKind::InvalidInput => return (State::Damaged, error.to_string()),
            Err(_) => return (State::Missing, String::new()),
        }
    }
    (State::Done, String::new())
}
