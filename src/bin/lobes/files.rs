//! The pictures that a command writes.

use crate::failure::Failure;
use cosine_lobes::{ExrLayer, Output, Picture, srgb_bytes, write_exr, write_png};
use std::path::{Path, PathBuf};

enum Format {
    Png,
    Exr,
}

fn format(path: &Path) -> Result<Format, Failure> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    match ending.as_deref() {
        Some("png") => Ok(Format::Png),
        Some("exr") => Ok(Format::Exr),
        _ => Err(Failure::new(format_args!("{}: the name must end in .png or .exr", path.display()))),
    }
}

/// Outputs that are open and waiting for their picture.
pub(crate) struct Files {
    list: Vec<(Format, Output)>,
}

impl Files {
    /// Opens all of them: what cannot be written is refused before anything is computed.
    pub(crate) fn create(paths: &[PathBuf]) -> Result<Self, Failure> {
        for (i, path) in paths.iter().enumerate() {
            if paths[..i].contains(path) {
                return Err(Failure::new(format_args!("{}: given twice", path.display())));
            }
        }
        let formats: Vec<Format> = paths.iter().map(|p| format(p)).collect::<Result<_, _>>()?;
        let open = |(format, path): (Format, &PathBuf)| Ok((format, Output::create(path)?));
        Ok(Self { list: formats.into_iter().zip(paths).map(open).collect::<Result<_, Failure>>()? })
    }

    /// Writes the picture to all of them, and the further layers to those that can hold them.
    pub(crate) fn write(self, picture: &Picture, exposure: f32, further: &[ExrLayer]) -> Result<(), Failure> {
        let (width, height) = (picture.width(), picture.height());
        for (format, output) in self.list {
            match format {
                Format::Png => write_png(output, width, height, &srgb_bytes(picture, exposure))?,
                Format::Exr => {
                    let main = ExrLayer::color("beauty", picture.pixels());
                    let layers: Vec<ExrLayer> = std::iter::once(main).chain(further.iter().cloned()).collect();
                    write_exr(output, width, height, &layers)?;
                }
            }
        }
        Ok(())
    }
}
