use std::fmt::{self, Debug, Write};
use xxhash_rust::xxh3::Xxh3;

/// A hash of its input: the same for the same input, on every machine.
pub(crate) struct Fingerprint(Xxh3);

impl Fingerprint {
    pub(crate) fn new() -> Self {
        Self(Xxh3::new())
    }

    /// Adds all that the value's debug form shows.
    pub(crate) fn debug(mut self, value: &impl Debug) -> Self {
        // Hashing does not fail.
        let _ = write!(self, "{value:?}");
        self
    }

    pub(crate) fn bytes(mut self, bytes: &[u8]) -> Self {
        self.0.update(&(bytes.len() as u64).to_le_bytes());
        self.0.update(bytes);
        self
    }

    pub(crate) fn value(&self) -> u64 {
        self.0.digest()
    }
}

impl Write for Fingerprint {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.update(text.as_bytes());
        Ok(())
    }
}
