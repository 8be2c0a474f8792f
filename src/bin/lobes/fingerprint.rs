use std::fmt::{self, Debug, Write};
use std::hash::{DefaultHasher, Hasher};

/// A number that tells what it was fed with: the same for the same, wherever it runs; other builds may give another.
pub(crate) struct Fingerprint(DefaultHasher);

impl Fingerprint {
    pub(crate) fn new() -> Self {
        Self(DefaultHasher::new())
    }

    /// Adds all that the value's debug form shows.
    pub(crate) fn debug(mut self, value: &impl Debug) -> Self {
        // Hashing does not fail.
        let _ = write!(self, "{value:?}");
        self
    }

    pub(crate) fn bytes(mut self, bytes: &[u8]) -> Self {
        self.0.write_usize(bytes.len());
        self.0.write(bytes);
        self
    }

    pub(crate) fn value(&self) -> u64 {
        self.0.finish()
    }
}

impl Write for Fingerprint {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.write(text.as_bytes());
        Ok(())
    }
}
