use std::path::{Path, PathBuf};

/// Why a scene is refused. The message is always one line, begins with the file where there is one, then the line and
/// the column where they are known, and says what was found and what was expected.
#[derive(Debug)]
#[non_exhaustive]
pub enum SceneError {
    /// A file cannot be read.
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// Something at a known place of a text file is wrong.
    Parse {
        /// The file.
        path: PathBuf,
        /// Line, counted from 1.
        line: usize,
        /// Column in characters, counted from 1; 0 when unknown.
        column: usize,
        /// The fault.
        message: String,
    },
    /// A file's content is wrong at a place that has no line.
    File {
        /// The file.
        path: PathBuf,
        /// The fault.
        message: String,
    },
    /// A scene made in memory is wrong.
    Invalid {
        /// The fault.
        message: String,
    },
}

impl SceneError {
    /// A file whose content is wrong.
    #[must_use]
    pub fn file(path: &Path, message: impl Into<String>) -> Self {
        Self::File { path: path.to_owned(), message: message.into() }
    }

    /// A line of a text file, counted from 1, that is wrong.
    #[must_use]
    pub fn at_line(path: &Path, line: usize, message: impl Into<String>) -> Self {
        Self::Parse { path: path.to_owned(), line, column: 0, message: message.into() }
    }

    /// A scene made in memory that is wrong.
    #[must_use]
    pub fn invalid(message: impl Into<String>) -> Self {
        Self::Invalid { message: message.into() }
    }

    /// The file that is to blame, where there is one.
    #[must_use]
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::Read { path, .. } | Self::Parse { path, .. } | Self::File { path, .. } => Some(path),
            Self::Invalid { .. } => None,
        }
    }
}

/// Puts a text on one line of bounded length, whatever a parser or a file put into it.
fn one_line(text: &str) -> String {
    const MAX: usize = 400;
    let mut line: String = text.split_whitespace().collect::<Vec<_>>().join(" ");
    line.retain(|c| !c.is_control());
    if let Some((cut, _)) = line.char_indices().nth(MAX) {
        line.truncate(cut);
        line.push('…');
    }
    line
}

impl std::fmt::Display for SceneError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let name = |path: &Path| one_line(&path.display().to_string());
        match self {
            Self::Read { path, source } => write!(f, "{}: cannot read: {}", name(path), one_line(&source.to_string())),
            Self::Parse { path, line, column: 0, message } => {
                write!(f, "{}:{line}: {}", name(path), one_line(message))
            }
            Self::Parse { path, line, column, message } => {
                write!(f, "{}:{line}:{column}: {}", name(path), one_line(message))
            }
            Self::File { path, message } => write!(f, "{}: {}", name(path), one_line(message)),
            Self::Invalid { message } => f.write_str(&one_line(message)),
        }
    }
}

impl std::error::Error for SceneError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Read { source, .. } => Some(source),
            _ => None,
        }
    }
}
