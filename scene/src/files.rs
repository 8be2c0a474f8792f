//! Where the bytes of files come from.

use crate::SceneError;
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
}

fn resolved(path: &Path) -> PathBuf {
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

/// The files of one reading.
#[derive(Clone)]
pub(crate) struct Source(pub(crate) Arc<dyn Files>);

impl Default for Source {
    fn default() -> Self {
        Self(Arc::new(Disk))
    }
}

impl Source {
    pub(crate) fn read(&self, path: &Path) -> Result<Vec<u8>, SceneError> {
        self.0.read(path).map_err(|source| match source.kind() {
            ErrorKind::InvalidInput => SceneError::file(path, source.to_string()),
            _ => SceneError::Read { path: path.to_owned(), source },
        })
    }

    pub(crate) fn read_text(&self, path: &Path) -> Result<String, SceneError> {
        into_text(path, self.read(path)?)
    }

    pub(crate) fn exists(&self, path: &Path) -> bool {
        self.0.exists(path)
    }
}

fn into_text(path: &Path, bytes: Vec<u8>) -> Result<String, SceneError> {
    String::from_utf8(bytes).map_err(|e| {
        let line = e.as_bytes()[..e.utf8_error().valid_up_to()].iter().filter(|&&b| b == b'\n').count() + 1;
        SceneError::at_line(path, line, "not UTF-8 text")
    })
}
