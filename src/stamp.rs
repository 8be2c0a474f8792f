use exr::meta::MetaData;
use exr::prelude::{AttributeValue, Text};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// The name under which files carry it: an attribute of OpenEXR, a text chunk of PNG.
pub(crate) const STAMP: &str = "cosine-lobes";

/// The line that a PNG or OpenEXR file was [stamped](crate::Output::stamped) with; `None` where there is no such file or
/// no such line.
#[must_use]
pub fn read_stamp(path: &Path) -> Option<String> {
    let open = || Some(BufReader::new(File::open(path).ok()?));
    let of_png = || {
        let reader = png::Decoder::new(open()?).read_info().ok()?;
        let mut texts = reader.info().uncompressed_latin1_text.iter();
        texts.find(|t| t.keyword == STAMP).map(|t| t.text.clone())
    };
    let of_exr = || {
        let meta = MetaData::read_from_buffered(open()?, false).ok()?;
        let header = meta.headers.first()?;
        let known = [&header.shared_attributes.other, &header.own_attributes.other];
        match known.into_iter().find_map(|all| all.get(&Text::from(STAMP)))? {
            AttributeValue::Text(text) => Some(text.to_string()),
            _ => None,
        }
    };
    of_png().or_else(of_exr)
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
        for stamp in [None, Some("one 1"), Some("two")] {
            let output = |path: &Path| Output::create(path).unwrap().stamped(stamp);
            write_png(output(&png), 2, 1, &[7; 6]).unwrap();
            write_exr(output(&exr), 2, 1, &[ExrLayer::color("beauty", &[Vec3::ONE; 2])]).unwrap();
            assert_eq!((read_stamp(&png).as_deref(), read_stamp(&exr).as_deref()), (stamp, stamp));
        }
        for broken in [&[][..], b"no picture"] {
            std::fs::write(&png, broken).unwrap();
            assert_eq!(read_stamp(&png), None);
        }
        assert_eq!(read_stamp(folder.path()), None);
        assert_eq!(read_stamp(&folder.path().join("missing.exr")), None);
    }
}
