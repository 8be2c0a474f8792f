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
    /// The file has the wrong format.
    #[error("{}: {message}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// The fault.
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

/// Temporary files that exist now; `None` once the program ends.
static UNFINISHED: Mutex<Option<Vec<PathBuf>>> = Mutex::new(Some(Vec::new()));

fn unfinished() -> MutexGuard<'static, Option<Vec<PathBuf>>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes the temporary files of all [`Output`]s that are not finished yet, for good: for handlers of Ctrl-C, before they end
/// the program. From then on, in all threads, no [`Output`] can be created or finished.
pub fn remove_unfinished() {
    for path in unfinished().take().into_iter().flatten() {
        let _ = fs::remove_file(path);
    }
}

/// Endings of the files that are written here.
const ENDINGS: [&str; 8] = ["png", "exr", "json", "csv", "md", "svg", "checkpoint", "glb"];

/// The folder that a file is in.
fn folder_of(path: &Path) -> PathBuf {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new(".")).to_owned()
}

/// Lets the folder know a new name for good, where folders can be synced.
fn sync_folder(path: &Path) {
    if cfg!(unix) {
        let _ = File::open(folder_of(path)).and_then(|folder| folder.sync_all());
    }
}

/// Removes temporary files that processes which are no more have left in the folder of `path`; once a folder.
fn sweep(path: &Path) {
    static SWEPT: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());
    let folder = folder_of(path);
    let mut swept = SWEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if swept.contains(&folder) {
        return;
    }
    for entry in fs::read_dir(&folder).into_iter().flatten().flatten() {
        if entry.file_name().to_str().and_then(owner).is_some_and(|id| !lives(id)) {
            let path = entry.path();
            // No process holds it, on this machine or another.
            if File::open(&path).is_ok_and(|file| file.try_lock().is_ok()) {
                let _ = fs::remove_file(path);
            }
        }
    }
    swept.push(folder);
}

/// Removes what killed processes have left in the folder of `path`, as [`Output::create`] does: for programs that work long before they
/// create their outputs.
pub fn sweep_unfinished(path: &Path) {
    sweep(path);
}

/// The most links that are followed from one to the next.
const LINKS: usize = 40;

/// The place that a name means: a link's target, whether or not it exists.
fn target(mut path: PathBuf) -> Result<PathBuf, ImageFileError> {
    for _ in 0..LINKS {
        match fs::read_link(&path) {
            // Relative to the link's folder.
            Ok(next) => path = folder_of(&path).join(next),
            Err(_) => return Ok(path),
        }
    }
    Err(ImageFileError::format(&path, "is a link without an end"))
}

/// The process that a temporary file is named after.
fn owner(name: &str) -> Option<u32> {
    let (name, id) = name.strip_prefix('.')?.strip_suffix(".tmp")?.rsplit_once('.')?;
    let (_, ending) = name.rsplit_once('.')?;
    ENDINGS.contains(&ending.to_ascii_lowercase().as_str()).then(|| id.parse().ok())?
}

/// Whether a process of this machine has that number, where the system shows this.
fn lives(id: u32) -> bool {
    id == std::process::id() || (cfg!(target_os = "linux") && Path::new("/proc").join(id.to_string()).exists())
}

/// An unfinished file: written under a temporary name in the same folder and renamed when it is complete, so that
/// no reader ever sees half of it. Dropped unfinished, it leaves nothing behind.
///
/// It is created before the work starts, so that a path that cannot be written is reported at once.
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
    /// A link is followed: the file that it names is replaced, and the link stays.
    ///
    /// # Errors
    /// When the folder does not exist or cannot be written, or `path` is a folder, a pipe or a device.
    pub fn create(path: impl Into<PathBuf>) -> Result<Self, ImageFileError> {
        let path = target(path.into())?;
        if path.metadata().is_ok_and(|found| !found.is_file() && !found.is_dir()) {
            return Err(ImageFileError::format(&path, "is a pipe or a device: expected the name of a file"));
        }
        let name = match path.file_name() {
            Some(name) if !path.is_dir() => name.to_string_lossy().into_owned(),
            _ => return Err(ImageFileError::format(&path, "is a folder")),
        };
        if path.metadata().is_ok_and(|m| m.permissions().readonly()) {
            return Err(ImageFileError::format(&path, "is write-protected"));
        }
        sweep(&path);
        let temporary = path.with_file_name(format!(".{name}.{}.tmp", std::process::id()));
        // Held over both: a handler of Ctrl-C, which is a thread of its own, sees the file on the list or prevents it.
        let mut list = unfinished();
        let created = match &mut *list {
            Some(list) => File::create(&temporary).inspect(|_| list.push(temporary.clone())),
            None => Err(io::ErrorKind::Interrupted.into()),
        };
        drop(list);
        let file = created.map_err(|source| ImageFileError::io(&path, source))?;
        // Tells other processes that the file is in use. Without file locks no process removes it.
        let _ = file.try_lock();
        Ok(Self { path, temporary, file: Some(file), stamp: None })
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
        self,
        write: impl FnOnce(&mut BufWriter<File>) -> Result<(), ImageFileError>,
    ) -> Result<(), ImageFileError> {
        self.finish_at(|file, _| write(file))
    }

    /// Writes these bytes and gives the file its name.
    ///
    /// # Errors
    /// Those of [`finish`](Self::finish).
    pub fn write(self, bytes: &[u8]) -> Result<(), ImageFileError> {
        let path = self.path.clone();
        self.finish(|file| file.write_all(bytes).map_err(|source| ImageFileError::io(&path, source)))
    }

    /// [`finish`](Self::finish) for callers that need the temporary name as well.
    pub(crate) fn finish_at(
        mut self,
        write: impl FnOnce(&mut BufWriter<File>, &Path) -> Result<(), ImageFileError>,
    ) -> Result<(), ImageFileError> {
        let failed = |e| ImageFileError::io(&self.path, e);
        if let Some(file) = &self.file {
            let mut buffered = BufWriter::new(file.try_clone().map_err(failed)?);
            write(&mut buffered, &self.temporary)?;
            buffered.flush().map_err(failed)?;
            // The content is on the disk before the name is: a power cut leaves the old file or the new one.
            file.sync_all().map_err(failed)?;
        }
        // Windows cannot rename an open file.
        if cfg!(windows) {
            self.file = None;
        }
        // Held over the renaming: a handler of Ctrl-C sees either the temporary file or the finished one.
        let mut list = unfinished();
        fs::rename(&self.temporary, &self.path).map_err(|e| ImageFileError::io(&self.path, e))?;
        list.iter_mut().for_each(|list| list.retain(|t| *t != self.temporary));
        drop(list);
        sync_folder(&self.path);
        Ok(())
    }
}

impl Drop for Output {
    fn drop(&mut self) {
        if let Some(list) = &mut *unfinished()
            && let Some(index) = list.iter().position(|t| *t == self.temporary)
        {
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
            Output::create(&path).unwrap().write(text.as_bytes()).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_stay() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("far")).unwrap();
        let write = |name: &str| Output::create(folder.path().join(name))?.write(b"picture");
        for (link, target) in [("a.png", "far/b.png"), ("c.png", "a.png"), ("d.png", "d.png")] {
            std::os::unix::fs::symlink(target, folder.path().join(link)).unwrap();
        }
        for name in ["a.png", "c.png"] {
            write(name).unwrap();
            assert_eq!(fs::read_to_string(folder.path().join("far/b.png")).unwrap(), "picture");
            assert!(fs::symlink_metadata(folder.path().join(name)).unwrap().is_symlink());
            fs::remove_file(folder.path().join("far/b.png")).unwrap();
        }
        assert!(write("d.png").is_err_and(|e| e.to_string().contains("without an end")));
        assert!(Output::create("/dev/null").is_err_and(|e| e.to_string().contains("device")));
    }

    #[test]
    fn what_the_dead_have_left_is_swept() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        // No process has this number; process 1 lives; other programs' files are theirs.
        let dead = format!(".a.exr.{}.tmp", u32::MAX - 1);
        let (alive, other) = (".b.exr.1.tmp", format!(".vimrc.{}.tmp", u32::MAX - 1));
        let held = format!(".c.json.{}.tmp", u32::MAX - 2);
        for name in [dead.as_str(), alive, &other, &held] {
            fs::write(path(name), b"half").unwrap();
        }
        let lock = File::open(path(&held)).unwrap();
        lock.lock().unwrap();
        drop(Output::create(path("new.png")).unwrap());
        let there = |name: &str| path(name).exists();
        assert!(!there(&dead) && there(&other) && there(&held));
        assert!(cfg!(not(target_os = "linux")) || there(alive));
    }

    #[test]
    fn folders_and_missing_folders_are_refused_at_once() {
        let folder = tempfile::tempdir().unwrap();
        assert!(Output::create(folder.path()).is_err());
        assert!(Output::create(folder.path().join("no/a.png")).is_err());
        assert!(Output::create("/").is_err());
    }
}
