use super::row::{Row, mark_front};
use super::setting::Setting;
use super::table;
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
    /// Takes over what the folder's file has of the same stamp; rows of another scene or other options go.
    pub(super) fn open(folder: &Path, stamp: &str) -> Result<Self, Failure> {
        let mut record = Self { folder: folder.to_owned(), stamp: stamp.to_owned(), rows: Vec::new() };
        if let Ok(text) = std::fs::read_to_string(record.path()) {
            let broken = |e| Failure::new(format_args!("{}: no table of this command: {e}", record.path().display()));
            record.rows = serde_json::from_str(&text).map_err(broken)?;
            record.rows.retain(|row| row.stamp == record.stamp);
        }
        Ok(record)
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

    pub(super) fn add(&mut self, row: Row) -> Result<(), Failure> {
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
        let mut record = Record::open(folder.path(), "1").unwrap();
        record.add(row("a", 1.0, 0.1)).unwrap();
        record.add(row("b", 2.0, 0.2)).unwrap();
        let again = Record::open(folder.path(), "1").unwrap();
        assert_eq!(again.rows(), record.rows());
        assert_eq!(again.rows().iter().map(|r| r.front).collect::<Vec<_>>(), [true, false]);
        assert!(Record::open(folder.path(), "2").unwrap().rows().is_empty());
        std::fs::write(record.path(), "[{\"scene\": 3").unwrap();
        assert!(Record::open(folder.path(), "1").is_err());
    }
}
