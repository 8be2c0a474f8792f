use glam::Vec3;

/// A picture of linear RGB values, row 0 at the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    width: usize,
    height: usize,
    pixels: Vec<Vec3>,
}

impl Picture {
    /// A picture of the given size from its pixels, row by row.
    ///
    /// # Panics
    /// When there are not `width`·`height` pixels.
    #[must_use]
    pub fn new(width: usize, height: usize, pixels: Vec<Vec3>) -> Self {
        assert_eq!(pixels.len(), width * height, "pixels of a {width}x{height} picture");
        Self { width, height, pixels }
    }

    /// Width in pixels.
    #[must_use]
    pub const fn width(&self) -> usize {
        self.width
    }

    /// Height in pixels.
    #[must_use]
    pub const fn height(&self) -> usize {
        self.height
    }

    /// The pixels, row by row from the top.
    #[must_use]
    pub fn pixels(&self) -> &[Vec3] {
        &self.pixels
    }

    /// The number of pixels with a component that is infinite or not a number.
    #[must_use]
    pub fn non_finite(&self) -> usize {
        self.pixels.iter().filter(|p| !p.is_finite()).count()
    }
}

/// Luminance of linear RGB with the primaries of ITU-R BT.709: `0.2126 R + 0.7152 G + 0.0722 B`.
#[must_use]
pub fn luminance(rgb: Vec3) -> f64 {
    0.2126 * f64::from(rgb.x) + 0.7152 * f64::from(rgb.y) + 0.0722 * f64::from(rgb.z)
}
