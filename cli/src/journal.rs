//! The finished steps of a bake, on disk beside its output.

use crate::console::{self, note};
use bake::Steps;
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use xxhash_rust::xxh3::xxh3_64;

/// A bake that is done sooner keeps nothing.
const SOON: Duration = Duration::from_secs(1);

const MAGIC: &[u8; 16] = b"lobes bake 1\0\0\0\0";

/// Steps of one bake, in a file that grows: a header with the job, then for each step its length, its hash and its bytes. A step that a killed
/// process has left half-written at the end is noticed and cut off.
pub(crate) struct Journal {
    path: PathBuf,
    job: u64,
    quiet: bool,
    /// Known steps that are not taken up yet, and the place of the last one that was.
    known: Option<(File, u64)>,
    /// Steps that are not written yet, as they will stand in the file.
    waiting: Vec<u8>,
    start: Instant,
    file: Option<File>,
    /// Whether writing failed: then the bake goes on without.
    is_lost: bool,
}

impl Journal {
    /// The name of the file for an output.
    pub(crate) fn path(output: &Path) -> PathBuf {
        let mut name = output.as_os_str().to_owned();
        name.push(".checkpoint");
        name.into()
    }

    /// Steps of a job, with those of an earlier run if there are some. Those of another job give a note and are replaced.
    pub(crate) fn open(output: &Path, job: u64, quiet: bool) -> Self {
        let path = Self::path(output);
        let known = match header(&path, job) {
            Ok(known) => known,
            Err(fault) => {
                if !quiet {
                    note(format_args!("lobes: warning: {}: {fault}", path.display()));
                }
                None
            }
        };
        if known.is_some() && !quiet {
            note(format_args!("lobes: goes on from {}", path.display()));
        }
        let known = known.map(|file| (file, MAGIC.len() as u64 + 8));
        Self { path, job, quiet, known, waiting: Vec::new(), start: Instant::now(), file: None, is_lost: false }
    }

    /// Ends a bake that is done: nothing is left.
    pub(crate) fn end(mut self) {
        self.file = None;
        self.known = None;
        let _ = std::fs::remove_file(&self.path);
        console::kept(None);
    }

    fn flush(&mut self) -> io::Result<()> {
        let file = match &mut self.file {
            Some(file) => file,
            None => {
                let mut file = File::create(&self.path)?;
                file.write_all(MAGIC)?;
                file.write_all(&self.job.to_le_bytes())?;
                self.file.insert(file)
            }
        };
        file.write_all(&self.waiting)?;
        self.waiting.clear();
        console::kept(Some(self.path.clone()));
        Ok(())
    }
}

/// A file that begins as one of this job, behind its header; none where there is no file.
fn header(path: &Path, job: u64) -> Result<Option<File>, String> {
    let mut file = match OpenOptions::new().read(true).write(true).open(path) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
        file => file.map_err(|e| e.to_string())?,
    };
    let mut head = [0; MAGIC.len() + 8];
    let is_read = file.read_exact(&mut head).is_ok();
    if !is_read || !head.starts_with(MAGIC) {
        return Err("is damaged; made anew".to_owned());
    }
    if head[MAGIC.len()..] != job.to_le_bytes() {
        return Err("belongs to another bake and will be replaced".to_owned());
    }
    Ok(Some(file))
}

/// The next step of a file, whole and undamaged.
fn record(file: &mut File) -> Option<Vec<u8>> {
    let mut head = [0; 16];
    file.read_exact(&mut head).ok()?;
    let word = |at: usize| Some(u64::from_le_bytes(head[at..at + 8].try_into().ok()?));
    let rest = file.metadata().ok()?.len().checked_sub(file.stream_position().ok()?)?;
    let length = word(0).filter(|length| *length <= rest)?;
    let mut bytes = vec![0; length as usize];
    file.read_exact(&mut bytes).ok()?;
    (word(8)? == xxh3_64(&bytes)).then_some(bytes)
}

impl Steps for Journal {
    fn resume(&mut self) -> Option<Vec<u8>> {
        let (file, last) = self.known.as_mut()?;
        let place = file.stream_position().ok()?;
        let found = record(file);
        *last = place;
        if found.is_some() {
            console::kept(Some(self.path.clone()));
        }
        found
    }

    fn keep(&mut self, result: Vec<u8>) {
        if self.is_lost {
            return;
        }
        if let Some((mut file, end)) = self.known.take() {
            // The last step that was read was not whole.
            let cut = file.set_len(end).and_then(|()| file.seek(SeekFrom::Start(end)));
            self.file = cut.is_ok().then_some(file);
        }
        self.waiting.extend_from_slice(&(result.len() as u64).to_le_bytes());
        self.waiting.extend_from_slice(&xxh3_64(&result).to_le_bytes());
        self.waiting.extend_from_slice(&result);
        if self.file.is_none() && self.start.elapsed() < SOON {
            return;
        }
        if let Err(error) = self.flush() {
            self.is_lost = true;
            self.waiting = Vec::new();
            if !self.quiet {
                let path = self.path.display();
                note(format_args!("lobes: warning: {path}: {error}; an interrupted bake begins again"));
            }
        }
    }
}
