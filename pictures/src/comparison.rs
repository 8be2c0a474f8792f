use crate::{Picture, luminance};

/// Two pictures that were to be compared have different sizes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("sizes differ: {}x{} against {}x{}", test.0, test.1, reference.0, reference.1)]
pub struct SizesDiffer {
    /// Width and height of the tested picture.
    pub test: (usize, usize),
    /// Width and height of the reference.
    pub reference: (usize, usize),
}

fn same_size(test: &Picture, reference: &Picture) -> Result<(), SizesDiffer> {
    let size = |p: &Picture| (p.width(), p.height());
    if size(test) == size(reference) {
        Ok(())
    } else {
        Err(SizesDiffer { test: size(test), reference: size(reference) })
    }
}

/// Errors of a picture A against a reference B, in linear radiance over all pixels and channels.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Comparison {
    /// Mean absolute error, `mean |A − B|`.
    pub mae: f64,
    /// Root mean square error.
    pub rmse: f64,
    /// Largest absolute error of a channel.
    pub max: f64,
    /// Mean over pixels of `|A − B|/B` in luminance ("pixel to pixel"), where B exceeds a thousandth of its mean.
    pub mean_relative: f64,
    /// `|A − B|/B` in luminance where B is at least a thousandth of white: the error of each pixel as a fraction of its own radiance. White is
    /// twice the luminance that nine of ten lit pixels of B stay below, as a picture is exposed.
    pub own: RegionError,
    /// Signed mean error, `mean (A − B)`.
    pub bias: f64,
    /// Mean of the reference.
    pub reference_mean: f64,
    /// Number of pixels.
    pub pixels: usize,
}

impl Comparison {
    /// Compares `test` (A) with `reference` (B).
    ///
    /// # Errors
    /// When the sizes differ.
    pub fn of(test: &Picture, reference: &Picture) -> Result<Self, SizesDiffer> {
        same_size(test, reference)?;
        let pairs = || test.pixels().iter().zip(reference.pixels());
        let count = 3.0 * test.pixels().len().max(1) as f64;
        let (mut absolute, mut squared, mut max, mut bias, mut total) = (0.0, 0.0, 0.0f64, 0.0, 0.0);
        for (a, b) in pairs() {
            for (a, b) in a.to_array().into_iter().zip(b.to_array()) {
                let error = f64::from(a) - f64::from(b);
                absolute += error.abs();
                squared += error * error;
                max = max.max(error.abs());
                bias += error;
                total += f64::from(b);
            }
        }
        let floor = 1e-3 * pairs().map(|(_, b)| luminance(*b)).sum::<f64>() / (count / 3.0);
        let relative = pairs()
            .map(|(a, b)| (luminance(*a), luminance(*b)))
            .filter(|(_, b)| *b > floor && *b > 0.0)
            .map(|(a, b)| (a - b).abs() / b);
        let darkest = DARKEST * white(reference);
        let own = pairs().map(|(a, b)| (luminance(*a), luminance(*b))).filter(|(_, b)| *b > 0.0 && *b >= darkest);
        Ok(Self {
            mae: absolute / count,
            rmse: (squared / count).sqrt(),
            max,
            mean_relative: mean(relative),
            own: RegionError::of(own.map(|(a, b)| (a - b).abs() / b).collect()),
            bias: bias / count,
            reference_mean: total / count,
            pixels: test.pixels().len(),
        })
    }
}

/// Pixels darker than this part of white have no error of their own.
const DARKEST: f64 = 1e-3;
/// So many of the lit pixels are darker than half of white.
const BRIGHT: f64 = 0.9;

/// The luminance of white in a picture that is exposed for it.
fn white(picture: &Picture) -> f64 {
    let mut lit: Vec<f64> =
        picture.pixels().iter().map(|p| luminance(*p)).filter(|y| *y > 0.0 && y.is_finite()).collect();
    lit.sort_unstable_by(f64::total_cmp);
    lit.len().checked_sub(1).map_or(0.0, |last| 2.0 * lit[(BRIGHT * last as f64).round() as usize])
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0usize), |(s, n), v| (s + v, n + 1));
    if count == 0 { 0.0 } else { sum / count as f64 }
}

/// Errors over some of the pixels, as fractions of their unshadowed radiance or of their own.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct RegionError {
    /// Number of pixels.
    pub pixels: usize,
    /// Mean absolute error.
    pub mean: f64,
    /// 99th percentile of the absolute error.
    pub p99: f64,
    /// Largest absolute error.
    pub max: f64,
}

impl RegionError {
    fn of(mut errors: Vec<f64>) -> Self {
        let pixels = errors.len();
        if pixels == 0 {
            return Self::default();
        }
        errors.sort_unstable_by(f64::total_cmp);
        // The smallest value that at least 99 % of the pixels do not exceed.
        let p99 = errors[(pixels * 99).div_ceil(100) - 1];
        Self { pixels, mean: mean(errors.iter().copied()), p99, max: errors[pixels - 1] }
    }
}

/// The error apart for pixels in penumbra, in full light and in full shadow.
///
/// All in luminance: for a pixel with unshadowed luminance U > 0 the error is `|A − B|/U`, and `B/U` gives the region.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct ShadowErrors {
    /// `B/U` strictly between 1 % and 99 %.
    pub penumbra: RegionError,
    /// `B/U` at least 99.9 %, where U exceeds a thousandth of its mean: below, a light that has nearly set makes the
    /// noise of the reference the largest error.
    pub lit: RegionError,
    /// `B` exactly 0.
    pub dark: RegionError,
    /// The number of dark pixels that are not exactly 0 in the tested picture.
    pub dark_nonzero: usize,
}

impl ShadowErrors {
    /// Compares `test` (A) with `reference` (B), given the same view without shadows (U).
    ///
    /// # Errors
    /// When the sizes differ.
    pub fn of(test: &Picture, reference: &Picture, unshadowed: &Picture) -> Result<Self, SizesDiffer> {
        same_size(test, reference)?;
        same_size(unshadowed, reference)?;
        let (mut penumbra, mut lit, mut dark, mut dark_nonzero) = (Vec::new(), Vec::new(), Vec::new(), 0);
        let floor = 1e-3 * mean(unshadowed.pixels().iter().map(|u| luminance(*u)));
        for ((a, b), u) in test.pixels().iter().zip(reference.pixels()).zip(unshadowed.pixels()) {
            let whole = luminance(*u);
            if whole <= 0.0 {
                continue;
            }
            let visible = luminance(*b) / whole;
            let error = (luminance(*a) - luminance(*b)).abs() / whole;
            if visible > 0.01 && visible < 0.99 {
                penumbra.push(error);
            }
            if visible >= 0.999 && whole > floor {
                lit.push(error);
            }
            if *b == glam::Vec3::ZERO {
                dark.push(error);
                dark_nonzero += usize::from(*a != glam::Vec3::ZERO);
            }
        }
        Ok(Self {
            penumbra: RegionError::of(penumbra),
            lit: RegionError::of(lit),
            dark: RegionError::of(dark),
            dark_nonzero,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn gray(values: &[f32]) -> Picture {
        Picture::new(values.len(), 1, values.iter().map(|v| Vec3::splat(*v)).collect())
    }

    /// Worked by hand; every value is a binary fraction, so nothing is rounded but the luminance weights.
    #[test]
    fn numbers_by_hand() {
        let c = Comparison::of(&gray(&[1.5, 2.0, 0.0, 1.0]), &gray(&[1.0, 4.0, 0.0, 3.0])).unwrap();
        assert_eq!((c.mae, c.max, c.bias, c.reference_mean, c.pixels), (1.125, 2.0, -0.875, 2.0, 4));
        assert!((c.rmse - (8.25f64 / 4.0).sqrt()).abs() < 1e-12);
        assert!((c.mean_relative - (0.5 + 0.5 + 2.0 / 3.0) / 3.0).abs() < 1e-12);
        assert_eq!((c.own.pixels, c.own.max), (3, 2.0 / 3.0));
        assert!((c.own.mean - (0.5 + 0.5 + 2.0 / 3.0) / 3.0).abs() < 1e-12);
    }

    /// Pixels darker than a thousandth of white, twice the ninth of ten pixels, have no error of their own.
    #[test]
    fn own_errors_end_at_a_thousandth_of_white() {
        let reference = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 64.0, 0.003, 0.001, 0.0];
        let test = reference.map(|b| 1.25 * b);
        let c = Comparison::of(&gray(&test), &gray(&reference)).unwrap();
        assert_eq!(c.own.pixels, 9);
        assert!((c.own.mean - 0.25).abs() < 1e-6 && (c.own.max - 0.25).abs() < 1e-6);
    }

    #[test]
    fn shadow_regions_by_hand() {
        //                 lit   penumbra dark  dark  no light  just lit (0.995: in no region)
        let unshadowed = gray(&[2.0, 2.0, 2.0, 2.0, 0.0, 1.0]);
        let reference = gray(&[2.0, 1.0, 0.0, 0.0, 0.0, 0.995]);
        let test = gray(&[2.0, 1.5, 0.0, 0.5, 9.0, 0.0]);
        let s = ShadowErrors::of(&test, &reference, &unshadowed).unwrap();
        assert_eq!((s.penumbra.pixels, s.lit.pixels, s.dark.pixels, s.dark_nonzero), (1, 1, 2, 1));
        assert!((s.penumbra.mean - 0.25).abs() < 1e-12 && (s.penumbra.max - 0.25).abs() < 1e-12);
        assert_eq!(s.lit.max, 0.0);
        assert!((s.dark.max - 0.25).abs() < 1e-12);
    }

    #[test]
    fn percentile() {
        let r = RegionError::of((1..=200).rev().map(f64::from).collect());
        assert_eq!((r.p99, r.max, r.mean), (198.0, 200.0, 100.5));
        assert_eq!(RegionError::of(vec![3.0]).p99, 3.0);
    }

    #[test]
    fn sizes_must_agree() {
        let error = Comparison::of(&gray(&[1.0]), &gray(&[1.0, 1.0])).unwrap_err();
        assert_eq!(error.to_string(), "sizes differ: 1x1 against 2x1");
    }
}
