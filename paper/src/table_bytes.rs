use crate::{ProductTable, Resolution};

/// Marks the file, and its version after it.
const MAGIC: [u8; 8] = *b"lobes-pt";
const VERSION: u32 = 1;
/// Magic, version, angles, exponents an interval.
const HEADER: usize = 20;
/// No finer table is needed; a header that says more is damaged.
const MOST: u32 = 1024;

/// Why bytes are not a [`ProductTable`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum TableFormatError {
    /// The bytes do not begin as a product table does.
    NotATable,
    /// Written by another version of this format.
    Version(u32),
    /// The number of bytes is not what the header announces, or the header makes no sense.
    Length,
    /// An entry is negative or not a number.
    Entry,
}

impl core::fmt::Display for TableFormatError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NotATable => f.write_str("not a lobe product table"),
            Self::Version(found) => write!(f, "product table of version {found}, this is version {VERSION}"),
            Self::Length => f.write_str("product table is cut short or damaged"),
            Self::Entry => f.write_str("product table holds a value that is negative or not a number"),
        }
    }
}

impl core::error::Error for TableFormatError {}

impl ProductTable {
    /// The table as bytes, little endian: 8 bytes of magic, version, angles and exponents an interval as u32, then the
    /// entries as pairs of f32.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let Resolution { angles, per_interval } = self.resolution();
        let mut bytes = Vec::with_capacity(HEADER + self.size());
        bytes.extend(MAGIC);
        for word in [VERSION, angles as u32, per_interval as u32] {
            bytes.extend(word.to_le_bytes());
        }
        bytes.extend(self.entries().iter().flatten().flat_map(|x| x.to_le_bytes()));
        bytes
    }

    /// Reads what [`to_bytes`](Self::to_bytes) wrote.
    ///
    /// # Errors
    /// [`TableFormatError`] when the bytes are anything else; nothing is allocated before the length is checked.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, TableFormatError> {
        let Some((magic, rest)) = bytes.split_first_chunk::<8>().filter(|(magic, _)| **magic == MAGIC) else {
            return Err(TableFormatError::NotATable);
        };
        debug_assert_eq!(magic, &MAGIC);
        let word = |at: usize| {
            let four = rest.get(at..at + 4).and_then(|s| <[u8; 4]>::try_from(s).ok());
            four.map(u32::from_le_bytes).ok_or(TableFormatError::Length)
        };
        let version = word(0)?;
        if version != VERSION {
            return Err(TableFormatError::Version(version));
        }
        let (angles, per_interval) = (word(4)?, word(8)?);
        if !(2..=MOST).contains(&angles) || !(2..=MOST).contains(&per_interval) {
            return Err(TableFormatError::Length);
        }
        let resolution = Resolution { angles: angles as usize, per_interval: per_interval as usize };
        let body = &bytes[HEADER..];
        if body.len() != 8 * Self::entry_count(resolution) {
            return Err(TableFormatError::Length);
        }
        let value = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
        let entries: Vec<[f32; 2]> = body.chunks_exact(8).map(|b| [value(&b[..4]), value(&b[4..])]).collect();
        if !entries.iter().flatten().all(|x| x.is_finite() && *x >= 0.0) {
            return Err(TableFormatError::Entry);
        }
        Self::from_entries(resolution, entries).ok_or(TableFormatError::Length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_trip_and_refusals() {
        let table = ProductTable::build_with(Resolution { angles: 5, per_interval: 2 });
        let bytes = table.to_bytes();
        assert_eq!(ProductTable::from_bytes(&bytes), Ok(table));
        for length in [0, 7, 8, 12, 19, 20, bytes.len() - 1] {
            assert!(ProductTable::from_bytes(&bytes[..length]).is_err(), "{length}");
        }
        let with = |at: usize, value: &[u8]| {
            let mut changed = bytes.clone();
            changed[at..at + value.len()].copy_from_slice(value);
            ProductTable::from_bytes(&changed).expect_err("damaged")
        };
        assert_eq!(with(0, b"x"), TableFormatError::NotATable);
        assert_eq!(with(8, &[9]), TableFormatError::Version(9));
        assert_eq!(with(12, &[6]), TableFormatError::Length);
        assert_eq!(with(12, &[255; 8]), TableFormatError::Length);
        assert_eq!(with(HEADER, &f32::NAN.to_le_bytes()), TableFormatError::Entry);
    }
}
