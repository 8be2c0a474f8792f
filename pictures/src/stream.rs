use crate::checksum::{UNKNOWN, seal_file};
use crate::exr_part::exposure_comment;
use crate::png_file::encoder;
use crate::stamp::STAMP;
use crate::{Display, ExrPart, ImageFileError, Output, Window};
use exr::block::writer::ChunksWriter;
use exr::block::{self, UncompressedBlock};
use exr::meta::attribute::ChannelDescription;
use exr::meta::header::{Header, ImageAttributes, LayerAttributes};
use exr::prelude::{AttributeValue, Compression, IntegerBounds, LineOrder, SampleType, Text, Vec2};
use glam::Vec3;
use std::collections::VecDeque;
use std::io::{Seek, Write};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

/// A picture that is written to files band by band, from top to bottom, so that it is never in memory as a whole.
///
/// The files have the bytes that they would have if they were written at once. Each is written by a thread of its own.
/// Dropped unfinished, it leaves nothing behind.
///
/// ```
/// use pictures::{ExrLayer, ExrPart, Output, PictureStream, Window, read_exr};
/// use glam::Vec3;
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("a.exr");
/// let mut stream = PictureStream::new(Window::whole(4, 32));
/// stream.add_exr(Output::create(&path)?, &["R".to_owned(), "G".to_owned(), "B".to_owned()])?;
/// for top in [0, 16] {
///     let rows = [Vec3::ONE; 4 * 16];
///     let window = Window { image: [4, 32], columns: 0..4, rows: top..top + 16 };
///     stream.send(ExrPart::of_layers(window, &[ExrLayer::color("beauty", &rows)]));
/// }
/// stream.finish()?;
/// assert_eq!(read_exr(&path)?.height(), 32);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct PictureStream {
    window: Window,
    exposure: Option<f32>,
    writers: Vec<Writer>,
}

#[derive(Debug)]
struct Writer {
    /// None when all has been sent.
    bands: Option<SyncSender<Arc<ExrPart>>>,
    thread: Option<JoinHandle<Result<(), ImageFileError>>>,
}

impl PictureStream {
    /// A picture, or a part of one, that is written nowhere yet.
    #[must_use]
    pub const fn new(window: Window) -> Self {
        Self { window, exposure: None, writers: Vec::new() }
    }

    /// Gives OpenEXR files that are added from now on an [exposure](ExrPart::exposure); they have none by default.
    pub const fn expose(&mut self, exposure: Option<f32>) {
        self.exposure = exposure;
    }

    /// Writes it also to an OpenEXR file with channels of these names.
    ///
    /// # Errors
    /// When there is no thread for it.
    pub fn add_exr(&mut self, output: Output, channels: &[String]) -> Result<(), ImageFileError> {
        let (window, exposure, mut names) = (self.window.clone(), self.exposure, channels.to_vec());
        names.sort_unstable();
        self.add(output, move |output, bands| write_exr_bands(output, &window, exposure, &names, bands))
    }

    /// Writes it also to a PNG file, of its channels R, G and B.
    ///
    /// # Errors
    /// When there is no thread for it.
    pub fn add_png(&mut self, output: Output, display: Display) -> Result<(), ImageFileError> {
        let window = self.window.clone();
        self.add(output, move |output, bands| write_png_bands(output, &window, &display, bands))
    }

    fn add(
        &mut self,
        output: Output,
        write: impl FnOnce(Output, Bands) -> Result<(), ImageFileError> + Send + 'static,
    ) -> Result<(), ImageFileError> {
        // One band waits while another one is being written.
        let (sender, receiver) = sync_channel(1);
        let path = output.path().to_owned();
        let work = move || write(output, Bands { receiver, waiting: VecDeque::new() });
        let thread = std::thread::Builder::new().name("picture".to_owned()).spawn(work);
        let thread = thread.map_err(|e| ImageFileError::io(&path, e))?;
        self.writers.push(Writer { bands: Some(sender), thread: Some(thread) });
        Ok(())
    }

    /// Hands over the next rows, as wide as the picture. False when a file can no longer be written:
    /// [`finish`](Self::finish) gives the reason.
    pub fn send(&mut self, band: ExrPart) -> bool {
        let band = Arc::new(band);
        self.writers.iter().all(|w| w.bands.as_ref().is_some_and(|bands| bands.send(band.clone()).is_ok()))
    }

    /// Waits until all files are complete and have their names.
    ///
    /// # Errors
    /// The error of the first file that could not be written, or an error for missing rows.
    pub fn finish(mut self) -> Result<(), ImageFileError> {
        self.writers.iter_mut().for_each(|w| w.bands = None);
        let mut result = Ok(());
        for writer in &mut self.writers {
            if let Some(thread) = writer.thread.take() {
                let written = thread.join().unwrap_or_else(|fault| std::panic::resume_unwind(fault));
                result = result.and(written);
            }
        }
        result
    }
}

impl Drop for PictureStream {
    fn drop(&mut self) {
        for writer in &mut self.writers {
            writer.bands = None;
            if let Some(thread) = writer.thread.take() {
                // Until it has removed its unfinished file.
                drop(thread.join());
            }
        }
    }
}

/// The rows that have been sent and not written yet.
struct Bands {
    receiver: Receiver<Arc<ExrPart>>,
    waiting: VecDeque<Arc<ExrPart>>,
}

impl Bands {
    /// The band that has a row of the image; none when it is never sent. Bands above it are dropped.
    fn with_row(&mut self, row: usize) -> Option<Arc<ExrPart>> {
        while self.waiting.front().is_some_and(|band| band.window.rows.end <= row) {
            self.waiting.pop_front();
        }
        loop {
            if let Some(band) = self.waiting.iter().find(|band| band.window.rows.contains(&row)) {
                return Some(band.clone());
            }
            self.waiting.push_back(self.receiver.recv().ok()?);
        }
    }
}

/// The error for missing rows.
const INCOMPLETE: &str = "the picture is not complete";

fn write_exr_bands(
    output: Output,
    window: &Window,
    exposure: Option<f32>,
    names: &[String],
    mut bands: Bands,
) -> Result<(), ImageFileError> {
    let (path, stamp) = (output.path().to_owned(), output.stamp().map(|s| format!("{s} {UNKNOWN}")));
    let header = header(window, exposure, names, stamp.as_deref());
    let failed = |e: exr::error::Error| match e {
        exr::error::Error::Io(e) => ImageFileError::io(&path, e),
        e => ImageFileError::format(&path, e.to_string()),
    };
    let invalid = || exr::error::Error::Invalid(INCOMPLETE.into());
    output.finish_at(|file, temporary| {
        let headers = [header].into_iter().collect();
        let written = block::write(&mut *file, headers, true, |meta, chunks| {
            for (number, index) in block::enumerate_ordered_header_block_indices(&meta.headers) {
                let mut missing = false;
                let mut last: Option<Arc<ExrPart>> = None;
                let data = UncompressedBlock::from_lines(&meta.headers[0].channels, index, |line| {
                    let row = window.rows.start + line.location.position.y();
                    if !last.as_ref().is_some_and(|band| band.window.rows.contains(&row)) {
                        // Rows of a block come in order, each with all its channels.
                        last = bands.with_row(row);
                    }
                    let values = last.as_ref().and_then(|band| {
                        let values = band.channel(&names[line.location.channel])?;
                        let width = band.window.columns.len();
                        values.get((row - band.window.rows.start) * width..)?.get(..line.location.sample_count)
                    });
                    missing |= values.is_none_or(|values| line.write_samples_from_slice(values).is_err());
                });
                if missing {
                    return Err(invalid());
                }
                chunks.write_chunk(number, data.compress_to_chunk(&meta.headers)?)?;
            }
            Ok(())
        });
        written.map_err(failed)?;
        if let Some(stamp) = &stamp {
            let io = |e| ImageFileError::io(&path, e);
            file.flush().map_err(io)?;
            file.rewind().map_err(io)?;
            seal_file(temporary, file, stamp).map_err(io)?;
        }
        Ok(())
    })
}

/// The header of a file in scan lines, ZIP-compressed.
fn header(window: &Window, exposure: Option<f32>, names: &[String], stamp: Option<&str>) -> Header {
    let channels = names.iter().map(|name| ChannelDescription::named(name.as_str(), SampleType::F32)).collect();
    let (size, [width, height]) = (Vec2(window.columns.len(), window.rows.len()), window.image);
    let own = LayerAttributes {
        layer_position: Vec2(window.columns.start as i32, window.rows.start as i32),
        comments: exposure.map(exposure_comment),
        ..LayerAttributes::default()
    };
    let mut shared = ImageAttributes::new(IntegerBounds::from_dimensions(Vec2(width, height)));
    let text = |s: &str| (Text::from(STAMP), AttributeValue::Text(Text::from(s)));
    shared.other.extend(stamp.map(text));
    Header::new(Text::from(""), size, channels)
        .with_encoding(Compression::ZIP16, exr::meta::BlockDescription::ScanLines, LineOrder::Increasing)
        .with_attributes(own)
        .with_shared_attributes(shared)
}

fn write_png_bands(output: Output, window: &Window, display: &Display, mut bands: Bands) -> Result<(), ImageFileError> {
    let (path, stamp) = (output.path().to_owned(), output.stamp().map(str::to_owned));
    let [width, height] = window.size();
    let mut incomplete = false;
    let result = output.finish(|file| {
        let encode = || -> Result<(), png::EncodingError> {
            let mut whole = encoder(file, width, height, display.depth, stamp)?;
            let mut writer = whole.stream_writer()?;
            let mut bytes = vec![0; display.depth.pixel() * width];
            for row in window.rows.clone() {
                let band = bands.with_row(row);
                let line = band.as_ref().and_then(|band| {
                    let start = (row - band.window.rows.start) * width;
                    let [r, g, b] = ["R", "G", "B"].map(|c| band.channel(c).and_then(|c| c.get(start..start + width)));
                    Some((r?, g?, b?))
                });
                let Some((r, g, b)) = line else {
                    incomplete = true;
                    return Err(std::io::Error::other(INCOMPLETE).into());
                };
                let pixels = r.iter().zip(g).zip(b).map(|((r, g), b)| Vec3::new(*r, *g, *b));
                display.row_into(pixels, [window.columns.start, row], &mut bytes);
                writer.write_all(&bytes)?;
            }
            writer.finish()?;
            whole.finish()
        };
        encode().map_err(|e| match e {
            png::EncodingError::IoError(e) => ImageFileError::io(&path, e),
            e => ImageFileError::format(&path, e.to_string()),
        })
    });
    if incomplete { Err(ImageFileError::format(&path, INCOMPLETE)) } else { result }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ExrLayer, ToneMap, read_stamp, write_png};
    use std::fs;

    /// Rows of a picture of two layers.
    fn part(window: Window) -> ExrPart {
        let at = |y: usize, x: usize| Vec3::new(x as f32 * 0.01, y as f32 * 0.02, 0.5 - 0.001 * (y * 37 + x) as f32);
        let values: Vec<Vec3> =
            window.rows.clone().flat_map(|y| window.columns.clone().map(move |x| at(y, x))).collect();
        let depth = values.iter().map(|v| v.z).collect();
        ExrPart::of_layers(window, &[ExrLayer::color("beauty", &values), ExrLayer::scalar("depth", 'Z', depth)])
    }

    #[test]
    fn bytes_are_those_of_a_picture_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = |n: &str| folder.path().join(n);
        let read = |n: &str| fs::read(path(n)).unwrap();
        for (stamp, window) in [
            (None, Window::whole(37, 50)),
            (Some("0.1.0 abc"), Window::whole(37, 50)),
            (None, Window { image: [60, 70], columns: 5..42, rows: 9..50 }),
        ] {
            let exposure = stamp.map(|_| 1.5);
            let whole = ExrPart { exposure, ..part(window.clone()) };
            let beauty: Vec<Vec3> = (0..whole.channels[0].1.len())
                .map(|i| Vec3::from_array(["R", "G", "B"].map(|c| whole.channel(c).unwrap()[i])))
                .collect();
            let [width, height] = window.size();
            let names: Vec<String> = whole.channels.iter().map(|c| c.0.clone()).collect();
            let output = |n: &str| Output::create(path(n)).unwrap().stamped(stamp);
            whole.write(output("once.exr")).unwrap();
            let display = Display { exposure: 0.5, tone: ToneMap::Agx, ..Display::default() };
            let bytes = display.bytes(&beauty, &window);
            write_png(output("once.png"), width, height, &bytes).unwrap();
            for step in [1, 7, 16, 100] {
                let mut stream = PictureStream::new(window.clone());
                stream.expose(exposure);
                stream.add_exr(output("bands.exr"), &names).unwrap();
                stream.add_png(output("bands.png"), display).unwrap();
                for top in window.rows.clone().step_by(step) {
                    let rows = top..(top + step).min(window.rows.end);
                    assert!(stream.send(part(Window { rows, ..window.clone() })));
                }
                stream.finish().unwrap();
                assert!(read("once.exr") == read("bands.exr") && read("once.png") == read("bands.png"), "{step}");
                assert_eq!(ExrPart::read(&path("bands.exr")).unwrap().exposure, exposure);
                for name in ["bands.exr", "bands.png"] {
                    assert_eq!(read_stamp(&path(name)).unwrap().as_deref(), stamp);
                }
            }
        }
    }

    #[test]
    fn what_is_not_complete_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let start = || {
            let mut stream = PictureStream::new(Window::whole(37, 50));
            let names = ["R", "G", "B", "depth.Z"].map(str::to_owned);
            stream.add_exr(Output::create(folder.path().join("a.exr")).unwrap(), &names).unwrap();
            stream.add_png(Output::create(folder.path().join("a.png")).unwrap(), Display::default()).unwrap();
            stream.send(part(Window { image: [37, 50], columns: 0..37, rows: 0..20 }));
            stream
        };
        drop(start());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
        let error = start().finish().unwrap_err().to_string();
        assert!(error.contains(INCOMPLETE), "{error}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
