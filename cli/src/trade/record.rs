use super::row::{Row, mark_front};
use super::setting::Setting;
use super::table;
use crate::console;
use crate::failure::Failure;
use cosine_lobes::{ImageFileError, Output};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The rows so far, in a file that is whole at every moment.
pub(super) struct Record {
    folder: PathBuf,
    stamp: String,
    rows: Vec<Row>,
}

impl Record {
    /// Reads the rows of the folder's file that have the same stamp; rows of another scene or other options are dropped. So are
    /// damaged ones, with a line on stderr unless `quiet`.
    pub(super) fn open(folder: &Path, stamp: &str, quiet: bool) -> Self {
        let mut record = Self { folder: folder.to_owned(), stamp: stamp.to_owned(), rows: Vec::new() };
        let Ok(bytes) = std::fs::read(record.path()) else { return record };
        let fault = match serde_json::from_slice::<Vec<Row>>(&bytes) {
            Ok(rows) => {
                record.rows = rows.into_iter().filter(|row| row.stamp == record.stamp).collect();
                let all = record.rows.len();
                record.rows.retain(|row| row.checksum == row.sum());
                match all - record.rows.len() {
                    0 => return record,
                    bad => format!("{} damaged; measured anew", console::counted(bad, "row")),
                }
            }
            Err(error) => format!("no table of this command ({error}); measured anew"),
        };
        if !quiet {
            console::note(format_args!("lobes: warning: {}: {fault}", record.path().display()));
        }
        record
    }

    pub(super) fn path(&self) -> PathBuf {
        self.folder.join("trade.json")
    }

    pub(super) fn rows(&self) -> &[Row] {
        &self.rows
    }

    pub(super) fn find(&self, setting: &Setting) -> Option<&Row> {
        self.rows.iter().find(|row| row.is(setting))
    }

    pub(super) fn add(&mut self, mut row: Row) -> Result<(), Failure> {
        row.checksum = row.sum();
        self.rows.push(row);
        mark_front(&mut self.rows);
        write(&self.path(), &serde_json::to_string_pretty(&self.rows)?)
    }

    /// CSV and Markdown.
    pub(super) fn write_tables(&self, about: &str, points: usize) -> Result<(), Failure> {
        write(&self.folder.join("trade.csv"), &table::csv(&self.rows))?;
        write(&self.folder.join("trade.md"), &table::markdown(&self.rows, about, points))
    }
}

/// A text file, whole or not at all.
pub(super) fn write(path: &Path, text: &str) -> Result<(), Failure> {
    let failed = |source| ImageFileError::Io { path: path.to_owned(), source };
    Ok(Output::create(path)?.finish(|file| writeln!(file, "{}", text.trim_end()).map_err(failed))?)
}

#[cfg(test)]
mod tests {
    use super::super::row::tests::row;
    use super::*;

    #[test]
    fn rows_of_the_same_stamp_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let open = |stamp: &str| Record::open(folder.path(), stamp, true);
        let mut record = open("1");
        record.add(row("a", 1.0, 0.1)).unwrap();
        record.add(row("b", 2.0, 0.2)).unwrap();
        let again = open("1");
        assert_eq!(again.rows(), record.rows());
        assert_eq!(again.rows().iter().map(|r| r.front).collect::<Vec<_>>(), [true, false]);
        assert!(open("2").rows().is_empty());
        // A digit that has changed: the row goes, the other one stays.
        let text = std::fs::read_to_string(record.path()).unwrap();
        let changed = text.replacen("\"mean\": 0.1", "\"mean\": 0.3", 1);
        assert_ne!(changed, text);
        std::fs::write(record.path(), changed).unwrap();
        assert_eq!(open("1").rows().iter().map(|r| r.method.as_str()).collect::<Vec<_>>(), ["b"]);
        for broken in [&b"[{\"scene\": 3"[..], b"\xff\xfe"] {
            std::fs::write(record.path(), broken).unwrap();
            assert!(open("1").rows().is_empty());
        }
    }
}
