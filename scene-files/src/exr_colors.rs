//! The colours that numbers of an OpenEXR picture mean, as its header says.

use crate::exr_channels::read_meta;
use exr::meta::attribute::{Chromaticities, EnvironmentMap};
use exr::prelude::Vec2;
use glam::{DMat3, DVec3, Mat3, Vec3};

/// ITU-R BT.709: red, green, blue and white, as x and y of CIE 1931.
const REC_709: [[f64; 2]; 4] = [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.3127, 0.329]];
/// Chromaticities that differ by less are the same.
const SAME: f64 = 1e-3;
/// Colours that are cut by more than this part are worth a line.
const WORTH: f32 = 0.01;
/// Cone responses of XYZ by which Bradford's method scales whites: rows as printed.
const BRADFORD: [[f64; 3]; 3] = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

/// The way from the colours of a file to those of Rec. 709.
pub(crate) struct ExrColors {
    /// `None` where they are the same.
    matrix: Option<Mat3>,
    /// A line about an attribute that means nothing.
    note: Option<String>,
}

impl ExrColors {
    /// `None` for files of other formats.
    ///
    /// # Errors
    /// Why the file is no picture, in one line: that of [`read_meta`], or that it is a cube.
    pub(crate) fn read(bytes: &[u8]) -> Result<Option<Self>, String> {
        let Some(meta) = read_meta(bytes)? else { return Ok(None) };
        if meta.headers.iter().any(|header| header.own_attributes.environment_map == Some(EnvironmentMap::Cube)) {
            return Err("its header says envmap = cube, whose six sides are not read: expected latitude and longitude"
                .to_owned());
        }
        let named = meta.headers.first().and_then(|header| header.shared_attributes.chromaticities);
        let colors = named.map(|named| Self::of(places(&named)));
        Ok(Some(colors.unwrap_or(Self { matrix: None, note: None })))
    }

    fn of(places: [[f64; 2]; 4]) -> Self {
        let is_same = |(a, b): (&f64, &f64)| (a - b).abs() <= SAME;
        if places.as_flattened().iter().zip(REC_709.as_flattened()).all(is_same) {
            return Self { matrix: None, note: None };
        }
        let matrix = to_rec_709(places);
        let note = matrix.is_none().then(|| "its chromaticities are no colours: those of sRGB are taken".to_owned());
        Self { matrix, note }
    }

    /// Converts colours. Those that Rec. 709 has not are cut at its border; numbers that are infinite or negative stay as they are. Returns a
    /// line about what is not as the file says.
    pub(crate) fn convert(self, texels: &mut [Vec3]) -> Option<String> {
        let Some(matrix) = self.matrix else { return self.note };
        to_srgb(matrix, texels)
    }
}

/// Multiplies colours, of which those that sRGB lacks are cut at its border; numbers that are infinite or negative stay as they are.
/// Returns a line about those that are cut.
pub(crate) fn to_srgb(matrix: Mat3, texels: &mut [Vec3]) -> Option<String> {
    let mut beyond = 0;
    for texel in texels.iter_mut().filter(|texel| texel.is_finite() && texel.min_element() >= 0.0) {
        let color = matrix * *texel;
        beyond += usize::from(color.min_element() < -WORTH * color.max_element());
        *texel = color.max(Vec3::ZERO);
    }
    (beyond > 0)
        .then(|| format!("{beyond} of {} pixels have colours that sRGB lacks: the nearest are taken", texels.len()))
}

fn places(named: &Chromaticities) -> [[f64; 2]; 4] {
    [named.red, named.green, named.blue, named.white].map(|Vec2(x, y)| [x, y].map(f64::from))
}

/// XYZ of a place, of sum 1.
fn xyz([x, y]: [f64; 2]) -> DVec3 {
    DVec3::new(x, y, 1.0 - x - y)
}

/// XYZ of a white of luminance 1.
fn white(place: [f64; 2]) -> DVec3 {
    xyz(place) / place[1]
}

/// XYZ of red, green and blue as columns; `None` where they are no colours.
fn xyz_of_rgb([red, green, blue, middle]: [[f64; 2]; 4]) -> Option<DMat3> {
    let columns = DMat3::from_cols(xyz(red), xyz(green), xyz(blue));
    let scales = columns.inverse() * white(middle);
    // Three places in a line, or a white outside of their triangle.
    let is_usable = scales.is_finite() && scales.min_element() > 1e-6 && scales.max_element() < 1e6;
    is_usable.then(|| columns * DMat3::from_diagonal(scales))
}

/// Linear Rec. 709 of linear colours with these primaries and this white, which becomes that of Rec. 709 by Bradford's method.
fn to_rec_709(places: [[f64; 2]; 4]) -> Option<Mat3> {
    let own = xyz_of_rgb(places)?;
    let bradford = DMat3::from_cols_array_2d(&BRADFORD).transpose();
    let cones = |place: [f64; 2]| bradford * white(place);
    let scales = cones(REC_709[3]) / cones(places[3]);
    let adapted = bradford.inverse() * DMat3::from_diagonal(scales) * bradford;
    let matrix = (xyz_of_rgb(REC_709)?.inverse() * adapted * own).as_mat3();
    matrix.is_finite().then_some(matrix)
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, Image, WritableImage};
    use std::io::Cursor;

    const AP0: [[f32; 2]; 4] = [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077], [0.32168, 0.33767]];

    /// A file of one pixel.
    fn file(color: Vec3, places: Option<[[f32; 2]; 4]>, map: Option<EnvironmentMap>) -> Vec<u8> {
        let channel = |(name, x): (&str, f32)| AnyChannel::new(name, FlatSamples::F32(vec![x]));
        let channels = ["R", "G", "B"].into_iter().zip(color.to_array()).map(channel);
        let mut image = Image::from_channels((1, 1), AnyChannels::sort(channels.collect()));
        image.attributes.chromaticities = places.map(|places| {
            let [red, green, blue, white] = places.map(|[x, y]| Vec2(x, y));
            Chromaticities { red, green, blue, white }
        });
        image.layer_data.attributes.environment_map = map;
        let mut bytes = Cursor::new(Vec::new());
        image.write().to_buffered(&mut bytes).expect("a file in memory");
        bytes.into_inner()
    }

    fn read(bytes: &[u8]) -> (Vec3, Vec<String>) {
        let mut notes = Vec::new();
        let read = crate::image_file::decode_linear("a.exr", "exr", bytes, &mut notes, &Default::default());
        (read.expect("a picture").1[0], notes)
    }

    #[test]
    fn colours_of_other_primaries_become_those_of_rec_709() {
        let color = Vec3::new(1.287, 1.479, 0.784);
        let of = |places| read(&file(color, places, None));
        let (converted, notes) = of(Some(AP0));
        assert!((converted - Vec3::new(1.265, 1.601, 0.670)).abs().max_element() < 3e-3, "{converted}");
        assert!(notes.is_empty(), "{notes:?}");
        let usual = REC_709.map(|place| place.map(|x| x as f32));
        for same in [None, Some(usual)] {
            assert_eq!(of(same), (color, Vec::new()));
        }
        // CIE XYZ itself, of which the white is that of equal energy.
        let (grey, _) = read(&file(Vec3::ONE, Some([[1.0, 0.0], [0.0, 1.0], [0.0; 2], [1.0 / 3.0; 2]]), None));
        assert!((grey - Vec3::ONE).abs().max_element() < 1e-5, "{grey}");
        for wrong in [[[0.0; 2]; 4], [[0.3; 2]; 4], [[f32::NAN; 2]; 4]] {
            let (same, notes) = of(Some(wrong));
            assert!(same == color && notes.len() == 1 && notes[0].contains("no colours"), "{notes:?}");
        }
    }

    #[test]
    fn colours_beyond_rec_709_are_cut_and_wrong_numbers_stay() {
        let of = |color| read(&file(color, Some(AP0), None));
        let (green, notes) = of(Vec3::Y);
        assert!(green.x == 0.0 && notes.len() == 1 && notes[0].contains("1 of 1 pixels"), "{green} {notes:?}");
        for wrong in [Vec3::new(f32::INFINITY, 1.0, 1.0), Vec3::new(1.0, -1.0, 1.0)] {
            assert_eq!(of(wrong), (wrong, Vec::new()));
        }
    }

    #[test]
    fn cubes_are_refused() {
        let of = |map| ExrColors::read(&file(Vec3::ONE, None, Some(map))).map(|colors| colors.is_some());
        assert_eq!(of(EnvironmentMap::LatitudeLongitude), Ok(true));
        assert!(of(EnvironmentMap::Cube).is_err_and(|message| message.contains("envmap = cube")));
        assert!(ExrColors::read(b"\x89PNG").is_ok_and(|colors| colors.is_none()));
    }
}
