use crate::checksum::{UNKNOWN, seal};
use crate::exr_open::open;
use crate::stamp::STAMP;
use crate::{ExrLayer, ImageFileError, Output, Window};
use exr::prelude::{
    AnyChannel, AnyChannels, AttributeValue, Encoding, FlatSamples, Image, IntegerBounds, Layer, LayerAttributes,
    ReadChannels, ReadLayers, Text, Vec2, WritableImage, read,
};
use std::io::{Cursor, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A part of a picture with all its channels: the output of a run with a window, and the result of merging parts.
#[derive(Clone, Debug, PartialEq)]
pub struct ExrPart {
    /// The place of the part: the data window within the display window.
    pub window: Window,
    /// Channels by name, in the file's order, with one value a pixel of the part.
    pub channels: Vec<(String, Vec<f32>)>,
    /// The exposure of eight-bit pictures of it, in stops, where the file has one.
    pub exposure: Option<f32>,
}

/// Begins the comment of OpenEXR files that have an [exposure](ExrPart::exposure). A second attribute of our own would stand before
/// or after the stamp by chance.
const EXPOSURE: &str = "exposure ";

pub(crate) fn exposure_comment(stops: f32) -> Text {
    Text::from(format!("{EXPOSURE}{stops}").as_str())
}

/// Why parts make no picture.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MergeError {
    /// There are no parts.
    #[error("no parts")]
    Nothing,
    /// A part is of another image: another size, or other channels.
    #[error("part {0} is of another picture than the first")]
    Other(usize),
    /// A part has pixels that another one has too.
    #[error("part {0} has pixels that an earlier one has")]
    Overlap(usize),
    /// Some pixels are in no part: how many, and the columns and rows from and to which they lie.
    #[error(
        "{count} pixels are in no part: those missing lie in columns {}..{}, rows {}..{}",
        columns.start, columns.end, rows.start, rows.end
    )]
    Missing {
        /// Their number.
        count: usize,
        /// The columns among which they are.
        columns: Range<usize>,
        /// The rows.
        rows: Range<usize>,
    },
}

impl ExrPart {
    /// The layers of a part; the channels of the layer `beauty` have no prefix.
    ///
    /// # Panics
    /// When a channel has not one value a pixel of the window.
    #[must_use]
    pub fn of_layers(window: Window, layers: &[ExrLayer]) -> Self {
        let [width, height] = window.size();
        let mut channels = Vec::new();
        for layer in layers {
            for (letter, values) in &layer.channels {
                assert_eq!(values.len(), width * height, "values of channel {letter} of layer {}", layer.name);
                let name = if layer.name == "beauty" { letter.to_string() } else { format!("{}.{letter}", layer.name) };
                channels.push((name, values.clone()));
            }
        }
        Self { window, channels, exposure: None }
    }

    /// Writes one OpenEXR part of 32-bit floats in scan lines, ZIP-compressed; the same bytes for the same values.
    ///
    /// # Errors
    /// When the disk refuses.
    pub fn write(self, output: Output) -> Result<(), ImageFileError> {
        let (path, stamp) = (output.path().to_owned(), output.stamp().map(|s| format!("{s} {UNKNOWN}")));
        let channel =
            |(name, values): (String, Vec<f32>)| AnyChannel::new(Text::from(name.as_str()), FlatSamples::F32(values));
        let channels = AnyChannels::sort(self.channels.into_iter().map(channel).collect());
        let Window { image: [width, height], columns, rows } = &self.window;
        let attributes = LayerAttributes {
            layer_position: Vec2(columns.start as i32, rows.start as i32),
            comments: self.exposure.map(exposure_comment),
            ..LayerAttributes::default()
        };
        let layer = Layer::new(Vec2(columns.len(), rows.len()), attributes, Encoding::SMALL_LOSSLESS, channels);
        let mut image = Image::from_layer(layer);
        image.attributes.display_window = IntegerBounds::from_dimensions(Vec2(*width, *height));
        let text = |s: &String| (Text::from(STAMP), AttributeValue::Text(Text::from(s.as_str())));
        image.attributes.other.extend(stamp.as_ref().map(text));
        let failed = |e: exr::error::Error| ImageFileError::format(&path, e.to_string());
        output.finish(|file| {
            let Some(stamp) = stamp else { return image.write().non_parallel().to_buffered(file).map_err(failed) };
            let mut whole = Cursor::new(Vec::new());
            image.write().non_parallel().to_buffered(&mut whole).map_err(failed)?;
            let mut whole = whole.into_inner();
            seal(&mut whole, &stamp);
            file.write_all(&whole).map_err(|e| ImageFileError::io(&path, e))
        })
    }

    /// Reads the first part of an OpenEXR file, all channels as floats.
    ///
    /// # Errors
    /// When the file cannot be read, is damaged, is subsampled, or has data outside of its display window.
    pub fn read(path: &Path) -> Result<Self, ImageFileError> {
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .all_channels()
            .first_valid_layer()
            .all_attributes()
            .non_parallel()
            .from_buffered(open(path)?)
            .map_err(|e| ImageFileError::format(path, format!("not a readable OpenEXR file: {e}")))?;
        let (layer, display) = (&image.layer_data, image.attributes.display_window);
        let [x, y] = [0, 1].map(|k| {
            let at = |v: Vec2<i32>| i64::from(if k == 0 { v.x() } else { v.y() });
            at(layer.attributes.layer_position) - at(display.position)
        });
        let (size, all) = (layer.size, display.size);
        let inside = |start: i64, length: usize, whole: usize| start >= 0 && start as usize + length <= whole;
        if !inside(x, size.width(), all.width()) || !inside(y, size.height(), all.height()) {
            return Err(ImageFileError::format(path, "its data window is not inside its display window"));
        }
        let (x, y) = (x as usize, y as usize);
        let mut channels = Vec::new();
        for channel in &layer.channel_data.list {
            if channel.sampling != Vec2(1, 1) {
                return Err(ImageFileError::format(path, "subsampled channels are not supported"));
            }
            channels.push((channel.name.to_string(), channel.sample_data.values_as_f32().collect()));
        }
        let window =
            Window { image: [all.width(), all.height()], columns: x..x + size.width(), rows: y..y + size.height() };
        let comment = layer.attributes.comments.as_ref().map(ToString::to_string);
        let stops = comment.as_ref().and_then(|text| text.strip_prefix(EXPOSURE)?.parse::<f32>().ok());
        let exposure = stops.filter(|stops| stops.is_finite());
        Ok(Self { window, channels, exposure })
    }

    /// The picture that parts make: each pixel from the part that has it, unchanged; the exposure is the first part's.
    ///
    /// # Errors
    /// [`MergeError`], which counts parts from 1.
    pub fn merge(parts: &[Self]) -> Result<Self, MergeError> {
        let first = parts.first().ok_or(MergeError::Nothing)?;
        let [width, height] = first.window.image;
        let names = |part: &Self| part.channels.iter().map(|c| c.0.clone()).collect::<Vec<_>>();
        for (number, part) in parts.iter().enumerate() {
            if part.window.image != first.window.image || names(part) != names(first) {
                return Err(MergeError::Other(number + 1));
            }
            let common = |a: &Range<usize>, b: &Range<usize>| a.start.max(b.start) < a.end.min(b.end);
            let overlaps = |earlier: &Self| {
                let (a, b) = (&part.window, &earlier.window);
                common(&a.rows, &b.rows) && common(&a.columns, &b.columns)
            };
            if parts[..number].iter().any(overlaps) {
                return Err(MergeError::Overlap(number + 1));
            }
        }
        // Checked before any memory is reserved: the image has the size in its files' headers, the parts have the size of the data read.
        Self::check_complete(parts, [width, height])?;
        let mut channels: Vec<(String, Vec<f32>)> =
            names(first).into_iter().map(|name| (name, vec![0.0; width * height])).collect();
        for part in parts {
            let (columns, own) = (part.window.columns.clone(), part.window.size()[0]);
            for (line, row) in part.window.rows.clone().enumerate() {
                let place = row * width + columns.start..row * width + columns.end;
                for ((_, all), (_, values)) in channels.iter_mut().zip(&part.channels) {
                    all[place.clone()].copy_from_slice(&values[line * own..(line + 1) * own]);
                }
            }
        }
        Ok(Self { window: Window::whole(width, height), channels, exposure: first.exposure })
    }

    /// Whether parts that do not overlap cover an image.
    fn check_complete(parts: &[Self], [width, height]: [usize; 2]) -> Result<(), MergeError> {
        // Between two of these rows all are alike.
        let mut cuts: Vec<usize> = parts.iter().flat_map(|p| [p.window.rows.start, p.window.rows.end]).collect();
        cuts.extend([0, height]);
        cuts.sort_unstable();
        cuts.dedup();
        let (mut count, mut low, mut high) = (0_usize, [usize::MAX; 2], [0; 2]);
        for pair in cuts.windows(2) {
            let rows = pair[0]..pair[1];
            let here = parts.iter().filter(|p| p.window.rows.start <= rows.start && p.window.rows.end >= rows.end);
            let mut spans: Vec<Range<usize>> = here.map(|p| p.window.columns.clone()).collect();
            spans.sort_unstable_by_key(|span| span.start);
            spans.push(width..width);
            let mut from = 0;
            for span in spans {
                if span.start > from {
                    count = count.saturating_add((span.start - from).saturating_mul(rows.len()));
                    low = [low[0].min(from), low[1].min(rows.start)];
                    high = [high[0].max(span.start), high[1].max(rows.end)];
                }
                from = from.max(span.end);
            }
        }
        if count == 0 {
            return Ok(());
        }
        Err(MergeError::Missing { count, columns: low[0]..high[0], rows: low[1]..high[1] })
    }

    /// A channel's values.
    #[must_use]
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        self.channels.iter().find(|c| c.0 == name).map(|c| c.1.as_slice())
    }
}

/// Reads parts and merges them.
///
/// # Errors
/// Those of [`ExrPart::read`]; errors of [`ExrPart::merge`] name the file.
pub fn merge_exr(paths: &[PathBuf]) -> Result<ExrPart, ImageFileError> {
    let parts = paths.iter().map(|p| ExrPart::read(p)).collect::<Result<Vec<_>, _>>()?;
    ExrPart::merge(&parts).map_err(|error| {
        let number = match error {
            MergeError::Other(n) | MergeError::Overlap(n) => n,
            MergeError::Nothing | MergeError::Missing { .. } => {
                return ImageFileError::format(Path::new("merge"), error.to_string());
            }
        };
        let path = paths.get(number.saturating_sub(1)).cloned().unwrap_or_default();
        ImageFileError::format(&path, error.to_string())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn part(columns: std::ops::Range<usize>, rows: std::ops::Range<usize>) -> ExrPart {
        let window = Window { image: [5, 4], columns: columns.clone(), rows: rows.clone() };
        let at = |y: usize, x: usize| Vec3::new(x as f32, y as f32, -0.1 * (y * 5 + x) as f32);
        let values: Vec<Vec3> = rows.flat_map(|y| columns.clone().map(move |x| at(y, x))).collect();
        let depth = values.iter().map(|v| v.z).collect();
        ExrPart::of_layers(window, &[ExrLayer::color("beauty", &values), ExrLayer::scalar("depth", 'Z', depth)])
    }

    #[test]
    fn parts_come_back_and_make_the_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = |n: &str| folder.path().join(n);
        let parts = [part(0..3, 0..4), part(3..5, 0..1), part(3..5, 1..4)];
        let mut paths = Vec::new();
        for (i, part) in parts.into_iter().enumerate() {
            paths.push(path(&format!("{i}.exr")));
            part.write(Output::create(&paths[i]).unwrap()).unwrap();
        }
        merge_exr(&paths).unwrap().write(Output::create(path("merged.exr")).unwrap()).unwrap();
        part(0..5, 0..4).write(Output::create(path("whole.exr")).unwrap()).unwrap();
        assert_eq!(std::fs::read(path("merged.exr")).unwrap(), std::fs::read(path("whole.exr")).unwrap());
        assert_eq!(ExrPart::read(&paths[1]).unwrap().window, Window { image: [5, 4], columns: 3..5, rows: 0..1 });
        let message = merge_exr(&paths[..2]).unwrap_err().to_string();
        assert!(message.contains("6 pixels are in no part: those missing lie in columns 3..5, rows 1..4"), "{message}");
    }

    #[test]
    fn what_is_no_picture_is_refused() {
        assert_eq!(ExrPart::merge(&[]), Err(MergeError::Nothing));
        assert_eq!(ExrPart::merge(&[part(0..3, 0..4), part(2..5, 0..4)]), Err(MergeError::Overlap(2)));
        let mut other = part(3..5, 0..4);
        other.channels.pop();
        assert_eq!(ExrPart::merge(&[part(0..3, 0..4), other]), Err(MergeError::Other(2)));
    }

    /// A header may claim any size: nothing is reserved for pixels that are in no file.
    #[test]
    fn huge_images_of_small_parts_are_refused() {
        let mut small = part(0..3, 0..4);
        small.window.image = [2_000_000_000, 2_000_000_000];
        let missing = MergeError::Missing {
            count: 4_000_000_000_000_000_000 - 12,
            columns: 0..2_000_000_000,
            rows: 0..2_000_000_000,
        };
        assert_eq!(ExrPart::merge(&[small]), Err(missing));
    }

    #[test]
    fn gaps_are_told_exactly() {
        let missing = |parts: &[ExrPart]| ExrPart::merge(parts).unwrap_err();
        let gap = |count, columns, rows| MergeError::Missing { count, columns, rows };
        assert_eq!(missing(&[part(1..5, 0..4)]), gap(4, 0..1, 0..4));
        assert_eq!(missing(&[part(0..2, 0..4), part(3..5, 0..2)]), gap(8, 2..5, 0..4));
        assert_eq!(missing(&[part(0..5, 0..1), part(0..5, 3..4), part(2..3, 1..3)]), gap(8, 0..5, 1..3));
    }
}
