use crate::event::tell;
use crate::{Event, Listener, RenderError};
use pictures::{ImageFileError, Output, checksum};
use std::fs;
use std::path::{Path, PathBuf};

/// Finds a result of an earlier run by its key in a folder; returns its file and the result. A file whose content does not match
/// the checksum in its name is reported and removed.
pub(crate) fn find<T>(
    folder: &Path,
    key: &str,
    ending: &str,
    read: impl Fn(Vec<u8>) -> Option<T>,
    listener: &mut Listener<'_>,
) -> Result<Option<(PathBuf, T)>, RenderError> {
    let (begin, end) = (format!("{key}."), format!(".{ending}"));
    let Ok(entries) = fs::read_dir(folder) else { return Ok(None) };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let Some(sum) = name.to_str().and_then(|n| n.strip_prefix(&begin)?.strip_suffix(&end)) else { continue };
        let path = entry.path();
        let Ok(bytes) = fs::read(&path) else { continue };
        match (checksum(&bytes) == sum).then_some(bytes).and_then(&read) {
            Some(found) => return Ok(Some((path, found))),
            None => {
                tell(listener, Event::Damaged { path: &path })?;
                let _ = fs::remove_file(path);
            }
        }
    }
    Ok(None)
}

/// Writes bytes into a folder. The file's name has the key and the bytes' checksum.
pub(crate) fn store(folder: &Path, key: &str, ending: &str, bytes: &[u8]) -> Result<PathBuf, ImageFileError> {
    let path = folder.join(format!("{key}.{}.{ending}", checksum(bytes)));
    let failed = |source| ImageFileError::Io { path: path.clone(), source };
    fs::create_dir_all(folder).map_err(failed)?;
    Output::create(&path)?.write(bytes)?;
    Ok(path)
}
