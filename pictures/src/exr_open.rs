//! Opens OpenEXR files, and refuses those whose headers claim more pixels than the file can hold.

use crate::ImageFileError;
use exr::meta::MetaData;
use exr::meta::attribute::ChannelDescription;
use exr::meta::header::Header;
use std::fs::File;
use std::io::{BufReader, Seek};
use std::path::Path;

/// Compression packs no picture more densely: deflate by 1032.
const DENSEST: u64 = 4096;

/// A file that can be read at all.
pub(crate) fn open(path: &Path) -> Result<BufReader<File>, ImageFileError> {
    let file = File::open(path).map_err(|e| ImageFileError::io(path, e))?;
    let metadata = file.metadata().map_err(|e| ImageFileError::io(path, e))?;
    if metadata.is_dir() {
        return Err(ImageFileError::format(path, "is a folder"));
    }
    let mut file = BufReader::new(file);
    // A broken header is reported by the code that reads the picture.
    let claimed = MetaData::read_from_buffered(&mut file, false).map_or(0, |meta| {
        let bytes = |h: &Header| {
            let channel = |c: &ChannelDescription| c.sample_type.bytes_per_sample() as u64;
            let pixels = (h.layer_size.width() as u64).saturating_mul(h.layer_size.height() as u64);
            pixels.saturating_mul(h.channels.list.iter().map(channel).sum())
        };
        meta.headers.iter().map(bytes).fold(0, u64::saturating_add)
    });
    if claimed > DENSEST.saturating_mul(metadata.len()).saturating_add(1 << 20) {
        let (size, megabytes) = (metadata.len(), claimed >> 20);
        return Err(ImageFileError::format(path, format!("{megabytes} MB of pixels in a file of {size} bytes")));
    }
    file.rewind().map_err(|e| ImageFileError::io(path, e))?;
    Ok(file)
}
