/// CRC-32 (IEEE 802.3) of some bytes as eight hexadecimal digits: what files that are read back carry, so that a flipped bit
/// is noticed.
///
/// ```
/// assert_eq!(pictures::checksum(b"123456789"), "cbf43926");
/// ```
#[must_use]
pub fn checksum(bytes: &[u8]) -> String {
    format!("{:08x}", crc32fast::hash(bytes))
}

/// What stands for a [`checksum`] while it is taken.
pub(crate) const UNKNOWN: &str = "00000000";

/// Puts the checksum of a file into the file: `text`, which occurs in it and ends with [`UNKNOWN`], gets it instead.
pub(crate) fn seal(file: &mut [u8], text: &str) {
    if let Some(place) = place(file, text) {
        let sum = checksum(file);
        file[place].copy_from_slice(sum.as_bytes());
    }
}

/// Whether a file has the checksum that `text` in it ends with.
pub(crate) fn is_sealed(mut file: Vec<u8>, text: &str) -> bool {
    let Some(place) = place(&file, text) else { return false };
    let sum = file[place.clone()].to_vec();
    file[place].copy_from_slice(UNKNOWN.as_bytes());
    checksum(&file).as_bytes() == sum
}

/// Where the last eight bytes of a text are in a file.
fn place(file: &[u8], text: &str) -> Option<core::ops::Range<usize>> {
    let start = file.windows(text.len().max(1)).position(|part| part == text.as_bytes())?;
    let end = start + text.len();
    Some(end.checked_sub(UNKNOWN.len())?..end)
}
