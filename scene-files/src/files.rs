//! Where the bytes of files come from.

use crate::budget::Budget;
use scene::SceneError;
use std::collections::BTreeMap;
use std::io::{Error, ErrorKind};
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// The files that a scene is read from: the disk, memory, an archive, files that were dropped onto a page.
///
/// A scene file or a model names other files: their paths are relative to the folder of the file that names them.
pub trait Files: Send + Sync {
    /// The bytes of a regular file.
    ///
    /// # Errors
    /// Why there is none, or why it cannot be read.
    fn read(&self, path: &Path) -> Result<Vec<u8>, Error>;

    /// Whether there is something of that name. Provided: whether it can be read.
    fn exists(&self, path: &Path) -> bool {
        self.read(path).is_ok()
    }

    /// The file that a name means to programs that do not tell capital letters from small ones: the name as it is, if there is such a
    /// file, else the first name in alphabetical order that differs by that alone. Provided: the name as it is.
    fn find(&self, path: &Path) -> Option<PathBuf> {
        self.exists(path).then(|| path.to_owned())
    }
}

/// The files of the operating system.
#[derive(Clone, Copy, Debug, Default)]
pub struct Disk;

impl Files for Disk {
    fn read(&self, path: &Path) -> Result<Vec<u8>, Error> {
        // A device or a pipe may never end.
        if !std::fs::metadata(path)?.is_file() {
            return Err(Error::new(ErrorKind::InvalidInput, NOT_REGULAR));
        }
        std::fs::read(path)
    }

    fn exists(&self, path: &Path) -> bool {
        path.exists()
    }

    fn find(&self, path: &Path) -> Option<PathBuf> {
        let mut found = PathBuf::new();
        for part in path.components() {
            let next = found.join(part);
            found = if next.exists() {
                next
            } else {
                let folder = if found.as_os_str().is_empty() { Path::new(".") } else { &found };
                let entries = std::fs::read_dir(folder).ok()?.flatten().map(|entry| entry.file_name());
                let wanted = lowered(part.as_os_str());
                found.join(entries.filter(|name| lowered(name) == wanted).min()?)
            };
        }
        Some(found)
    }
}

fn lowered(name: &std::ffi::OsStr) -> String {
    name.to_string_lossy().to_lowercase()
}

const NOT_REGULAR: &str = "not a regular file";

/// Files in memory, by path; `.` and `..` in the paths that are read are resolved.
impl Files for BTreeMap<PathBuf, Vec<u8>> {
    fn read(&self, path: &Path) -> Result<Vec<u8>, Error> {
        let bytes = self.get(path).or_else(|| self.get(&resolved(path)));
        bytes.cloned().ok_or_else(|| Error::from(ErrorKind::NotFound))
    }

    fn exists(&self, path: &Path) -> bool {
        self.contains_key(path) || self.contains_key(&resolved(path))
    }

    fn find(&self, path: &Path) -> Option<PathBuf> {
        if self.exists(path) {
            return Some(path.to_owned());
        }
        let wanted = lowered(resolved(path).as_os_str());
        self.keys().find(|known| lowered(known.as_os_str()) == wanted).cloned()
    }
}

pub(crate) fn resolved(path: &Path) -> PathBuf {
    let mut all = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if all.file_name().is_some() => {
                all.pop();
            }
            part => all.push(part),
        }
    }
    all
}

/// The ending of a file's name, in small letters.
pub(crate) fn extension(path: &Path) -> String {
    path.extension().map_or_else(String::new, |e| e.to_string_lossy().to_ascii_lowercase())
}

/// The files of one reading, and the memory that they may take.
#[derive(Clone)]
pub(crate) struct Source {
    files: Arc<dyn Files>,
    pub(crate) budget: Arc<Budget>,
}

impl Default for Source {
    fn default() -> Self {
        Self::new(Arc::new(Disk))
    }
}

impl Source {
    pub(crate) fn new(files: Arc<dyn Files>) -> Self {
        Self { files, budget: Arc::default() }
    }

    pub(crate) fn read(&self, path: &Path) -> Result<Vec<u8>, SceneError> {
        let bytes = self.files.read(path).map_err(|source| match source.kind() {
            ErrorKind::InvalidInput => SceneError::file(path, source.to_string()),
            _ => SceneError::Read { path: path.to_owned(), source },
        })?;
        self.budget.has_read(path, bytes.len());
        Ok(bytes)
    }

    pub(crate) fn read_text(&self, path: &Path) -> Result<String, SceneError> {
        into_text(path, self.read(path)?)
    }

    /// The file beside `path` that a name means: as it is; else with backslashes as separators, without quotes, or with other letters
    /// large and small.
    pub(crate) fn beside(&self, path: &Path, name: &str) -> Option<PathBuf> {
        let folder = path.with_file_name("");
        let plain = name.trim().trim_matches('"').replace('\\', "/");
        // An absolute path of another system joins the folder as it is.
        let found = |name: &str| (!name.is_empty()).then(|| self.files.find(&folder.join(name))).flatten();
        if self.files.exists(&folder.join(name)) && !name.is_empty() {
            return Some(folder.join(name));
        }
        found(&plain).map(|file| resolved(&file))
    }
}

fn into_text(path: &Path, bytes: Vec<u8>) -> Result<String, SceneError> {
    String::from_utf8(bytes).map_err(|e| {
        let line = e.as_bytes()[..e.utf8_error().valid_up_to()].iter().filter(|&&b| b == b'\n').count() + 1;
        SceneError::at_line(path, line, "not UTF-8 text")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_as_other_systems_write_them() {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::create_dir(folder.path().join("My Tex")).expect("a folder in it");
        std::fs::write(folder.path().join("My Tex/a b.PNG"), "x").expect("a file");
        std::fs::write(folder.path().join("b.png"), "y").expect("a file");
        std::fs::write(folder.path().join("B.png"), "z").expect("a file");
        let memory: BTreeMap<PathBuf, Vec<u8>> =
            [("My Tex/a b.PNG", "x"), ("b.png", "y"), ("B.png", "z")].map(|(p, t)| (p.into(), t.into())).into();
        let (disk, memory) = (Source::default(), Source::new(Arc::new(memory)));
        for (name, want) in [
            ("My Tex/a b.PNG", Some("x")),
            ("my tex\\A B.png", Some("x")),
            (".\\My Tex\\a b.PNG", Some("x")),
            ("\"b.png\"", Some("y")),
            ("B.PNG", Some("z")),
            ("b.PNG", Some("z")),
            ("c.png", None),
            ("", None),
        ] {
            for (files, path) in [(&disk, folder.path().join("m.obj")), (&memory, PathBuf::from("m.obj"))] {
                let found = files.beside(&path, name).map(|file| files.read(&file).expect("a file"));
                assert_eq!(found.as_deref(), want.map(str::as_bytes), "{name}");
            }
        }
    }
}
