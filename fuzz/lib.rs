//! Code that the fuzz targets share.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::{Mutex, OnceLock};
use vellus_usd::{Options, read};

/// Replaces libFuzzer's panic hook, which would end the program even if a reader catches the panic. An uncaught panic
/// still ends the program. The place of each panic is printed once.
pub fn init() {
    static PLACES: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    std::panic::set_hook(Box::new(|panic| {
        let place = panic.location().map(ToString::to_string).unwrap_or_default();
        if PLACES.lock().is_ok_and(|mut places| places.insert(place)) {
            eprintln!("panic: {panic}");
        }
    }));
}

/// A file with this name and these bytes, in memory if there is such a folder.
pub fn file(name: &str, bytes: &[u8]) -> PathBuf {
    static FOLDER: OnceLock<tempfile::TempDir> = OnceLock::new();
    let folder =
        FOLDER.get_or_init(|| tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir()).expect("a folder"));
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("a file");
    path
}

/// Reads a stage. Reading must end, and its result must be valid.
pub fn stage(name: &str, bytes: &[u8]) {
    let options = Options { default_width: Some(0.1), ..Options::default() };
    if let Ok(reading) = read(&file(name, bytes), &options) {
        assert_eq!(reading.scene.validate(), Ok(()));
    }
}
