use crate::console;
use std::fmt::Display;
use std::process::ExitCode;

/// Why a command ends without its result: one line for the user.
#[derive(Debug)]
pub(crate) struct Failure {
    message: String,
    code: u8,
}

impl Failure {
    /// Something the user can put right.
    pub(crate) fn new(message: impl Display) -> Self {
        Self { message: message.to_string(), code: 2 }
    }

    /// The failure of another program, which has told it.
    pub(crate) const fn said(code: u8) -> Self {
        Self { message: String::new(), code }
    }

    /// Ctrl-C, after everything was put away; no message where nothing is left of the work.
    pub(crate) fn interrupted(message: impl Display) -> Self {
        Self { message: message.to_string(), code: 130 }
    }

    pub(crate) fn message(&self) -> &str {
        &self.message
    }

    pub(crate) fn report(self) -> ExitCode {
        console::give_way();
        // A message that quotes a file or a parser may hold line breaks.
        let line = self.message.split_whitespace().collect::<Vec<_>>().join(" ");
        match self.code {
            130 if line.is_empty() => console::note(console::interrupted()),
            130 => console::note(format_args!("lobes: interrupted: {line}")),
            _ if line.is_empty() => {}
            _ => console::note(format_args!("lobes: error: {line}")),
        }
        ExitCode::from(self.code)
    }
}

impl<E: std::error::Error> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::new(error)
    }
}
