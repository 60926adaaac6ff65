//! The scenes in the folder of `--folder`.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// The most names that pages see.
const MAX_FILES: usize = 500;

/// Changes of a folder within this time may have the same date.
const SAME_DATE: Duration = Duration::from_secs(3);

/// A folder, and the names that were found in it.
pub struct Files {
    folder: PathBuf,
    names: Vec<String>,
    /// The date of the folder when it was read, the end of reading, and how long it took.
    read: Option<(SystemTime, Instant, Duration)>,
}

impl Files {
    pub fn new(folder: PathBuf) -> Self {
        Files { folder, names: Vec::new(), read: None }
    }

    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The names of the scenes, sorted. The folder is read again if it may have changed, but reading a folder of many
    /// files that changes all the time takes at most a twentieth of the time.
    pub fn names(&mut self) -> Vec<String> {
        let date = std::fs::metadata(&self.folder).and_then(|metadata| metadata.modified());
        let is_current = self.read.is_some_and(|(before, end, took)| {
            let is_old = before.elapsed().is_ok_and(|age| age > SAME_DATE + end.elapsed());
            let is_same = is_old && date.as_ref().is_ok_and(|date| *date == before);
            is_same || end.elapsed() < 20 * took
        });
        if !is_current {
            let start = Instant::now();
            self.names = list(&self.folder);
            self.read = date.ok().map(|date| (date, Instant::now(), start.elapsed()));
        }
        self.names.clone()
    }

    /// The path of a scene in the folder. `None` if there is none of this name.
    pub fn path(&self, name: &str) -> Option<PathBuf> {
        // A name with parts, or a link, could lead out of the folder.
        let is_plain = Path::new(name).file_name().is_some_and(|plain| plain == name);
        let path = self.folder.join(name);
        let is_file = || path.symlink_metadata().is_ok_and(|metadata| metadata.is_file());
        (is_plain && is_scene(name) && is_file()).then_some(path)
    }
}

fn is_scene(name: &str) -> bool {
    let extension = Path::new(name).extension().and_then(|extension| extension.to_str());
    extension.is_some_and(|e| {
        ["usda", "usdc", "usdz", "usd", "abc", "hair", "tfx", "data", "ply", "npy", "npz", "obj"].contains(&e)
    })
}

fn list(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let files = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_file()));
    let names = files.filter_map(|entry| entry.file_name().into_string().ok());
    let mut names: Vec<String> = names.filter(|name| is_scene(name)).collect();
    names.sort();
    names.truncate(MAX_FILES);
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As if reading had taken no time: then it may be read again at once.
    fn quick(files: &mut Files) {
        files.read.iter_mut().for_each(|(.., took)| *took = Duration::ZERO);
    }

    #[test]
    fn names_follow_the_folder_and_lead_nowhere_else() {
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("inner");
        std::fs::create_dir(&inner).unwrap();
        let mut files = Files::new(inner.clone());
        assert!(files.names().is_empty());
        quick(&mut files);
        for name in ["inner/b.usda", "inner/a.hair", "inner/c.txt", "out.usda"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        assert_eq!(files.names(), ["a.hair", "b.usda"]);
        assert_eq!(files.path("a.hair"), Some(inner.join("a.hair")));
        let mut refused = vec!["c.txt", "../out.usda", "no.usda", "./a.hair", "inner/../a.hair", "", "..", "a.hair/"];
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("../out.usda", inner.join("link.usda")).unwrap();
            refused.push("link.usda");
        }
        for name in refused {
            assert_eq!(files.path(name), None, "{name}");
        }
    }

    /// Many commands do not read the folder again and again.
    #[test]
    fn an_unchanged_folder_is_read_once() {
        let folder = tempfile::tempdir().unwrap();
        let mut files = Files::new(folder.path().to_owned());
        let long_ago = SystemTime::now() - Duration::from_secs(100);
        std::fs::File::open(folder.path()).unwrap().set_modified(long_ago).unwrap();
        files.names();
        quick(&mut files);
        // Only reading could find this file: the date of the folder is as before.
        std::fs::write(folder.path().join("a.usda"), "").unwrap();
        std::fs::File::open(folder.path()).unwrap().set_modified(long_ago).unwrap();
        assert!(files.names().is_empty());
        std::fs::write(folder.path().join("b.usda"), "").unwrap();
        assert_eq!(files.names().len(), 2);
        // A folder that changes all the time is read less often if that takes long.
        files.read.iter_mut().for_each(|(.., took)| *took = Duration::from_secs(100));
        std::fs::write(folder.path().join("c.usda"), "").unwrap();
        assert_eq!(files.names().len(), 2);
    }
}
