//! Files on the disk as bytes and as text.

use crate::SceneError;
use std::path::Path;

/// The ending of a file's name, in small letters.
pub(crate) fn extension(path: &Path) -> String {
    path.extension().map_or_else(String::new, |e| e.to_string_lossy().to_ascii_lowercase())
}

/// The bytes of a regular file.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>, SceneError> {
    let fail = |source| SceneError::Read { path: path.to_owned(), source };
    // A device or a pipe may never end.
    if !std::fs::metadata(path).map_err(fail)?.is_file() {
        return Err(SceneError::file(path, "not a regular file"));
    }
    std::fs::read(path).map_err(fail)
}

pub(crate) fn read_text(path: &Path) -> Result<String, SceneError> {
    into_text(path, read(path)?)
}

fn into_text(path: &Path, bytes: Vec<u8>) -> Result<String, SceneError> {
    String::from_utf8(bytes).map_err(|e| {
        let line = e.as_bytes()[..e.utf8_error().valid_up_to()].iter().filter(|&&b| b == b'\n').count() + 1;
        SceneError::at_line(path, line, "not UTF-8 text")
    })
}
