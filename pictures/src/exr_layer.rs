//! A layer of an OpenEXR file.

use glam::Vec3;

/// A named plane of an OpenEXR file: `channels` have one letter each and one value a pixel each.
#[derive(Clone, Debug, PartialEq)]
pub struct ExrLayer {
    /// Its name: channels are called `NAME.C`; of the layer `beauty` just `C`.
    pub name: String,
    /// Channel letters with their values, row by row from the top.
    pub channels: Vec<(char, Vec<f32>)>,
}

impl ExrLayer {
    /// A layer of three channels.
    fn vectors(name: &str, letters: [char; 3], values: &[Vec3]) -> Self {
        let channel = |k: usize| (letters[k], values.iter().map(|v| v[k]).collect());
        Self { name: name.to_owned(), channels: vec![channel(0), channel(1), channel(2)] }
    }

    /// A layer of linear RGB.
    #[must_use]
    pub fn color(name: &str, values: &[Vec3]) -> Self {
        Self::vectors(name, ['R', 'G', 'B'], values)
    }

    /// A layer of vectors X, Y, Z.
    #[must_use]
    pub fn vector(name: &str, values: &[Vec3]) -> Self {
        Self::vectors(name, ['X', 'Y', 'Z'], values)
    }

    /// A layer of one number a pixel, under the given letter.
    #[must_use]
    pub fn scalar(name: &str, letter: char, values: Vec<f32>) -> Self {
        Self { name: name.to_owned(), channels: vec![(letter, values)] }
    }
}
