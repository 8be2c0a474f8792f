use crate::ImageFileError;
use crate::checksum::is_sealed;
use exr::meta::MetaData;
use exr::prelude::{AttributeValue, Text};
use std::io::{Cursor, ErrorKind};
use std::path::Path;

/// The name under which files carry it: an attribute of OpenEXR, a text chunk of PNG.
pub(crate) const STAMP: &str = "cosine-lobes";

const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";

/// The line that a PNG or OpenEXR file was [stamped](crate::Output::stamped) with; `None` without such a file or
/// such a line. The whole file is checked: a PNG file by the checksums of its chunks, an OpenEXR file by the checksum in the line.
///
/// # Errors
/// [`ImageFileError`] for a file that cannot be read, has another format, is cut short or has other bytes than were written.
pub fn read_stamp(path: &Path) -> Result<Option<String>, ImageFileError> {
    let file = match std::fs::read(path) {
        Err(e) if e.kind() == ErrorKind::NotFound => return Ok(None),
        file => file.map_err(|e| ImageFileError::io(path, e))?,
    };
    let found = if file.starts_with(PNG) { of_png(&file) } else { of_exr(file) };
    found.map_err(|()| ImageFileError::format(path, "is damaged or no picture"))
}

fn of_png(file: &[u8]) -> Result<Option<String>, ()> {
    let (mut rest, mut stamp) = (&file[PNG.len()..], None);
    loop {
        let (head, tail) = rest.split_at_checked(8).ok_or(())?;
        let (length, kind) = head.split_at(4);
        let length = u32::from_be_bytes(length.try_into().map_err(|_| ())?) as usize;
        let (data, tail) = tail.split_at_checked(length).ok_or(())?;
        let (sum, tail) = tail.split_at_checked(4).ok_or(())?;
        let mut hasher = crc32fast::Hasher::new();
        hasher.update(kind);
        hasher.update(data);
        if hasher.finalize().to_be_bytes() != sum {
            return Err(());
        }
        let text = data.strip_prefix(STAMP.as_bytes()).and_then(|data| data.strip_prefix(&[0]));
        match (kind, text) {
            (b"tEXt", Some(text)) => stamp = Some(String::from_utf8_lossy(text).into_owned()),
            (b"IEND", _) => return if tail.is_empty() { Ok(stamp) } else { Err(()) },
            _ => {}
        }
        rest = tail;
    }
}

fn of_exr(file: Vec<u8>) -> Result<Option<String>, ()> {
    let meta = MetaData::read_from_buffered(Cursor::new(&file), false).map_err(|_| ())?;
    let header = meta.headers.first().ok_or(())?;
    let known = [&header.shared_attributes.other, &header.own_attributes.other];
    let text = match known.into_iter().find_map(|all| all.get(&Text::from(STAMP))) {
        Some(AttributeValue::Text(text)) => text.to_string(),
        _ => return Ok(None),
    };
    let (line, _) = text.rsplit_once(' ').ok_or(())?;
    if is_sealed(file, &text) { Ok(Some(line.to_owned())) } else { Err(()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ExrLayer, Output, write_exr, write_png};
    use glam::Vec3;

    #[test]
    fn stamps_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let (png, exr) = (folder.path().join("a.png"), folder.path().join("a.exr"));
        let read = |path: &Path| read_stamp(path).unwrap();
        for stamp in [None, Some("one 1"), Some("two")] {
            let output = |path: &Path| Output::create(path).unwrap().stamped(stamp);
            write_png(output(&png), 2, 1, &[7; 6]).unwrap();
            write_exr(output(&exr), 2, 1, &[ExrLayer::color("beauty", &[Vec3::ONE; 2])]).unwrap();
            assert_eq!((read(&png).as_deref(), read(&exr).as_deref()), (stamp, stamp));
        }
        for broken in [&[][..], b"no picture"] {
            std::fs::write(&png, broken).unwrap();
            assert!(read_stamp(&png).is_err());
        }
        assert!(read_stamp(folder.path()).is_err());
        assert_eq!(read(&folder.path().join("missing.exr")), None);
    }

    /// Every bit of both files, and every length that they can be cut to.
    #[test]
    fn damage_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let (png, exr) = (folder.path().join("a.png"), folder.path().join("a.exr"));
        write_png(Output::create(&png).unwrap().stamped(Some("line 1")), 2, 1, &[7, 1, 2, 3, 4, 5]).unwrap();
        let layer = ExrLayer::color("beauty", &[Vec3::new(0.1, 0.2, 0.3); 2]);
        write_exr(Output::create(&exr).unwrap().stamped(Some("line 1")), 2, 1, &[layer]).unwrap();
        for path in [png, exr] {
            let whole = std::fs::read(&path).unwrap();
            let intact = |bytes: &[u8]| {
                std::fs::write(&path, bytes).unwrap();
                read_stamp(&path).is_ok_and(|stamp| stamp.as_deref() == Some("line 1"))
            };
            assert!(intact(&whole));
            for bit in 0..8 * whole.len() {
                let mut damaged = whole.clone();
                damaged[bit / 8] ^= 1 << (bit % 8);
                assert!(!intact(&damaged), "{}: bit {bit}", path.display());
            }
            for length in 0..whole.len() {
                assert!(!intact(&whole[..length]), "{}: cut after {length}", path.display());
            }
        }
    }
}
