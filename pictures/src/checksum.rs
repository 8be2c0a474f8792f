use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;

/// CRC-32 (IEEE 802.3) of some bytes as eight hexadecimal digits. Files that are read back carry it, so that a flipped bit
/// is noticed.
///
/// ```
/// assert_eq!(pictures::checksum(b"123456789"), "cbf43926");
/// ```
#[must_use]
pub fn checksum(bytes: &[u8]) -> String {
    format!("{:08x}", crc32fast::hash(bytes))
}

/// The placeholder of a [`checksum`] while it is computed.
pub(crate) const UNKNOWN: &str = "00000000";

/// Puts the checksum of a file into the file: `text`, which occurs in it and ends with [`UNKNOWN`], gets it instead.
pub(crate) fn seal(file: &mut [u8], text: &str) {
    if let Some(place) = place(file, text) {
        let sum = checksum(file);
        file[place].copy_from_slice(sum.as_bytes());
    }
}

/// As [`seal`] for a file on the disk, which `path` names for reading and `file` is at the start of, for writing.
pub(crate) fn seal_file(path: &Path, file: &mut (impl Write + Seek), text: &str) -> io::Result<()> {
    let mut from = File::open(path)?;
    let (mut sum, mut part, mut place, mut at) = (crc32fast::Hasher::new(), vec![0; 1 << 20], None, 0_u64);
    loop {
        let count = from.read(&mut part)?;
        if count == 0 {
            break;
        }
        sum.update(&part[..count]);
        // The text is in the header: in the first part.
        if at == 0 {
            place = self::place(&part[..count], text);
        }
        at += count as u64;
    }
    if let Some(place) = place {
        file.seek(SeekFrom::Start(place.start as u64))?;
        file.write_all(format!("{:08x}", sum.finalize()).as_bytes())?;
    }
    Ok(())
}

/// Whether a file has the checksum that `text` in it ends with.
pub(crate) fn is_sealed(mut file: Vec<u8>, text: &str) -> bool {
    let Some(place) = place(&file, text) else { return false };
    let sum = file[place.clone()].to_vec();
    file[place].copy_from_slice(UNKNOWN.as_bytes());
    checksum(&file).as_bytes() == sum
}

/// The place of a text's last eight bytes in a file.
fn place(file: &[u8], text: &str) -> Option<core::ops::Range<usize>> {
    let start = file.windows(text.len().max(1)).position(|part| part == text.as_bytes())?;
    let end = start + text.len();
    Some(end.checked_sub(UNKNOWN.len())?..end)
}
