//! The pictures that a command writes.

use crate::failure::Failure;
use cosine_lobes::{Display, ExrLayer, ExrPart, Output, Picture, PictureStream, Window};
use std::fs::canonicalize;
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

/// Whether a file with that ending can have layers besides its picture.
pub(crate) fn holds_layers(path: &Path) -> bool {
    matches!(format(path), Ok(Format::Exr))
}

/// The file that a path means, however it is spelled; the path itself if its folder does not exist.
fn identity(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let new = || Some(canonicalize(folder).ok()?.join(path.file_name()?));
    canonicalize(path).ok().or_else(new).unwrap_or_else(|| path.to_owned())
}

/// Refuses outputs that are the same file twice, or a file that the command reads.
pub(crate) fn distinct<'a>(
    outputs: impl IntoIterator<Item = &'a PathBuf>,
    inputs: impl IntoIterator<Item = &'a PathBuf>,
) -> Result<(), Failure> {
    let inputs: Vec<PathBuf> = inputs.into_iter().map(|p| identity(p)).collect();
    let mut known = Vec::new();
    for path in outputs {
        let file = identity(path);
        let fault = match (known.contains(&file), inputs.contains(&file)) {
            (true, _) => "given twice as an output",
            (_, true) => "both read and written",
            _ => "",
        };
        if !fault.is_empty() {
            return Err(Failure::new(format_args!("{}: {fault}", path.display())));
        }
        known.push(file);
    }
    Ok(())
}

/// The path of one frame: its number, of four digits at least, before the ending. `out.png` gives `out.0007.png`.
pub(crate) fn numbered(path: &Path, frame: u32) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_owned();
    name.push(format!(".{frame:04}"));
    if let Some(ending) = path.extension() {
        name.push(".");
        name.push(ending);
    }
    path.with_file_name(name)
}

/// Opens an output that can only be a PNG file.
pub(crate) fn create_png(path: &PathBuf) -> Result<Output, Failure> {
    match format(path) {
        Ok(Format::Png) => Ok(Output::create(path)?),
        _ => Err(Failure::new(format_args!("{}: the name must end in .png", path.display()))),
    }
}

/// Opens an output that can only be a binary glTF file.
pub(crate) fn create_glb(path: &PathBuf) -> Result<Output, Failure> {
    match path.extension() {
        Some(ending) if ending.eq_ignore_ascii_case("glb") => Ok(Output::create(path)?),
        _ => Err(Failure::new(format_args!("{}: the name must end in .glb", path.display()))),
    }
}

/// Opens an output that can only be a JSON file.
pub(crate) fn create_json(path: &PathBuf) -> Result<Output, Failure> {
    match path.extension() {
        Some(ending) if ending.eq_ignore_ascii_case("json") => Ok(Output::create(path)?),
        _ => Err(Failure::new(format_args!("{}: the name must end in .json", path.display()))),
    }
}

/// Outputs that are open and waiting for their picture.
pub(crate) struct Files {
    list: Vec<(Format, Output)>,
}

impl Files {
    /// Opens all of them, with the line that they carry. A path that cannot be written is refused before anything is computed.
    pub(crate) fn create(paths: &[PathBuf], stamp: Option<&str>) -> Result<Self, Failure> {
        let formats: Vec<Format> = paths.iter().map(|p| format(p)).collect::<Result<_, _>>()?;
        let open = |(format, path): (Format, &PathBuf)| Ok((format, Output::create(path)?.stamped(stamp)));
        Ok(Self { list: formats.into_iter().zip(paths).map(open).collect::<Result<_, Failure>>()? })
    }

    /// Whether there is a PNG file among them.
    pub(crate) fn has_png(&self) -> bool {
        self.list.iter().any(|(format, _)| matches!(format, Format::Png))
    }

    /// Writes the picture to all of them, and the further layers to those that can hold them.
    pub(crate) fn write(self, picture: &Picture, display: &Display, further: &[ExrLayer]) -> Result<(), Failure> {
        let window = Window::whole(picture.width(), picture.height());
        let main = ExrLayer::color("beauty", picture.pixels());
        let layers: Vec<ExrLayer> = std::iter::once(main).chain(further.iter().cloned()).collect();
        self.write_part(display, ExrPart::of_layers(window, &layers))
    }

    /// Writes them band by band, with channels of these names where a file can hold them; OpenEXR files with an exposure, if there
    /// is one.
    pub(crate) fn stream(
        self,
        window: Window,
        display: &Display,
        exposure: Option<f32>,
        channels: &[String],
    ) -> Result<PictureStream, Failure> {
        let mut stream = PictureStream::new(window);
        stream.expose(exposure);
        for (format, output) in self.list {
            match format {
                Format::Png => stream.add_png(output, *display)?,
                Format::Exr => stream.add_exr(output, channels)?,
            }
        }
        Ok(stream)
    }

    /// Writes all channels of a part to those that can hold them, and its picture to the others.
    pub(crate) fn write_part(self, display: &Display, part: ExrPart) -> Result<(), Failure> {
        let names: Vec<String> = part.channels.iter().map(|(name, _)| name.clone()).collect();
        let mut stream = self.stream(part.window.clone(), display, part.exposure, &names)?;
        // The stream reports the reason when it is finished.
        let _ = stream.send(part);
        Ok(stream.finish()?)
    }
}
