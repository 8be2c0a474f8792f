use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Why a picture could not be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageFileError {
    /// The operating system refused.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Its reason.
        source: io::Error,
    },
    /// The file is not what it should be.
    #[error("{}: {message}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
    },
}

impl ImageFileError {
    pub(crate) fn io(path: &Path, source: io::Error) -> Self {
        Self::Io { path: path.to_owned(), source }
    }

    pub(crate) fn format(path: &Path, message: impl Into<String>) -> Self {
        Self::Format { path: path.to_owned(), message: message.into() }
    }
}

/// Temporary files that exist now.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes the temporary files of all [`Output`]s that are not finished yet: for handlers of Ctrl-C. Outputs that are
/// finished later fail.
pub fn remove_unfinished() {
    for path in unfinished().drain(..) {
        let _ = fs::remove_file(path);
    }
}

/// A file in the making: written under a temporary name in the same folder and renamed when it is complete, so that
/// nobody ever sees half of it. Dropped unfinished, it leaves nothing behind.
///
/// Created before the work starts, it tells at once that a path cannot be written.
#[derive(Debug)]
pub struct Output {
    path: PathBuf,
    temporary: PathBuf,
    file: Option<File>,
    stamp: Option<String>,
}

impl Output {
    /// Opens the temporary file for `path`.
    ///
    /// # Errors
    /// When the folder does not exist or cannot be written, or `path` is a folder.
    pub fn create(path: impl Into<PathBuf>) -> Result<Self, ImageFileError> {
        let path = path.into();
        let name = match path.file_name() {
            Some(name) if !path.is_dir() => name.to_string_lossy().into_owned(),
            _ => return Err(ImageFileError::format(&path, "is a folder")),
        };
        if path.metadata().is_ok_and(|m| m.permissions().readonly()) {
            return Err(ImageFileError::format(&path, "is write-protected"));
        }
        let temporary = path.with_file_name(format!(".{name}.{}.tmp", std::process::id()));
        // Registered first: an interruption between the two calls must not leave the file behind.
        unfinished().push(temporary.clone());
        match File::create(&temporary) {
            Ok(file) => Ok(Self { path, temporary, file: Some(file), stamp: None }),
            Err(source) => {
                unfinished().retain(|t| *t != temporary);
                Err(ImageFileError::io(&path, source))
            }
        }
    }

    /// The name that the file will have.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Lets the picture that is written here carry a line of ASCII text, or none, to be read by [`read_stamp`](crate::read_stamp).
    #[must_use]
    pub fn stamped(mut self, line: Option<&str>) -> Self {
        self.stamp = line.map(str::to_owned);
        self
    }

    pub(crate) fn stamp(&self) -> Option<&str> {
        self.stamp.as_deref()
    }

    /// Writes the content and gives the file its name, replacing a file that had it.
    ///
    /// # Errors
    /// Those of `write`, of the disk, and of the renaming; the old file, if any, is untouched then.
    pub fn finish(
        mut self,
        write: impl FnOnce(&mut BufWriter<File>) -> Result<(), ImageFileError>,
    ) -> Result<(), ImageFileError> {
        if let Some(file) = self.file.take() {
            let mut buffered = BufWriter::new(file);
            write(&mut buffered)?;
            buffered.flush().map_err(|e| ImageFileError::io(&self.path, e))?;
        }
        // Held over the renaming: a handler of Ctrl-C sees either the temporary file or the finished one.
        let mut list = unfinished();
        fs::rename(&self.temporary, &self.path).map_err(|e| ImageFileError::io(&self.path, e))?;
        list.retain(|t| *t != self.temporary);
        Ok(())
    }
}

impl Drop for Output {
    fn drop(&mut self) {
        let mut list = unfinished();
        if let Some(index) = list.iter().position(|t| *t == self.temporary) {
            list.swap_remove(index);
            let _ = fs::remove_file(&self.temporary);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unfinished_output_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        drop(Output::create(&path).unwrap());
        let failed = Output::create(&path).unwrap().finish(|_| Err(ImageFileError::format(&path, "no")));
        assert!(failed.is_err());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn finished_output_replaces() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        for text in ["one", "two"] {
            let output = Output::create(&path).unwrap();
            output.finish(|f| f.write_all(text.as_bytes()).map_err(|e| ImageFileError::io(&path, e))).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn folders_and_missing_folders_are_refused_at_once() {
        let folder = tempfile::tempdir().unwrap();
        assert!(Output::create(folder.path()).is_err());
        assert!(Output::create(folder.path().join("no/a.png")).is_err());
        assert!(Output::create("/").is_err());
    }
}
