//! Images of one number: opacities and heights.

use scene::{Encoding, Texture};

/// Red, green, blue, alpha.
pub(crate) type Texel = [u8; 4];

/// The channel of a texel that is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Source {
    /// Red, green, blue or alpha.
    Channel(usize),
    /// Its brightness.
    Luminance,
}

impl Source {
    fn of(self, texel: Texel) -> u8 {
        match self {
            Self::Channel(k) => texel[k],
            Self::Luminance => {
                // Rec. 709, of sum 256.
                let [r, g, b, _] = texel.map(u32::from);
                ((54 * r + 183 * g + 19 * b + 128) / 256) as u8
            }
        }
    }
}

/// The image with its opacity for alpha: alpha itself, unless that says nothing.
pub(crate) fn opacity(name: &str, size: [u32; 2], mut texels: Vec<Texel>, source: Option<Source>) -> Texture {
    let has_alpha = texels.iter().any(|texel| texel[3] < u8::MAX);
    let source = source.unwrap_or(if has_alpha { Source::Channel(3) } else { Source::Luminance });
    texels.iter_mut().for_each(|texel| texel[3] = source.of(*texel));
    Texture::new(name, size, texels, Encoding::Linear)
}

/// Whether an image is a normal map: not grey, and bluish in the mean.
pub(crate) fn shows_normals(texels: &[Texel]) -> bool {
    let sums = texels.iter().fold([0u64; 3], |sums, t| core::array::from_fn(|k| sums[k] + u64::from(t[k])));
    let [r, g, b] = sums.map(|sum| sum as f64 / (255.0 * texels.len() as f64));
    (r - 0.5).abs() < 0.15 && (g - 0.5).abs() < 0.15 && b > 0.75
}

/// The slopes of a height field as a normal map, and the factor of its x and y where white is one texel high.
///
/// Slopes are central differences. They are stored as fractions of the steepest one, so that eight bits are enough, with z = 1. So the
/// mean of texels is the mean of slopes.
pub(crate) fn slopes(
    name: &str,
    [width, height]: [u32; 2],
    texels: &[Texel],
    source: Source,
    is_repeated: bool,
) -> (Texture, f32) {
    let (w, h) = (width as usize, height as usize);
    let heights: Vec<i16> = texels.iter().map(|texel| source.of(*texel).into()).collect();
    // Of three neighbours the first and the last.
    let beside = |i: usize, n: usize| match is_repeated {
        true => [(i + n - 1) % n, (i + 1) % n],
        false => [i.saturating_sub(1), (i + 1).min(n - 1)],
    };
    let slope = |x: usize, y: usize| {
        let ([left, right], [above, below]) = (beside(x, w), beside(y, h));
        // Down where the surface rises; v grows downward.
        [heights[y * w + left] - heights[y * w + right], heights[below * w + x] - heights[above * w + x]]
    };
    let all = || (0..h).flat_map(|y| (0..w).map(move |x| (x, y)));
    let steepest = all().flat_map(|(x, y)| slope(x, y)).map(i16::abs).max().unwrap_or(0);
    let share = |slope: i16| (127.5 + 127.5 * f32::from(slope) / f32::from(steepest.max(1))).round() as u8;
    let normals = all().map(|(x, y)| slope(x, y)).map(|[x, y]| [share(x), share(y), u8::MAX, u8::MAX]).collect();
    let texture = Texture::new(name, [width, height], normals, Encoding::Linear);
    (texture, f32::from(steepest) / (2.0 * 255.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;
    use scene::Wrap;

    fn wave(n: u32) -> Vec<Texel> {
        let height = |x: u32, y: u32| {
            let a = core::f32::consts::TAU / n as f32;
            127.5 + 100.0 * (a * x as f32).sin() * (a * y as f32).cos()
        };
        (0..n * n).map(|i| [height(i % n, i / n).round() as u8; 4]).collect()
    }

    /// `n = (−∂h/∂x, −∂h/∂y)` of a wave, y upward, where neighbours differ by many steps of a byte.
    #[test]
    fn slopes_are_the_derivatives_of_the_height() {
        let n = 16;
        let (texture, scale) = slopes("wave", [n, n], &wave(n), Source::Luminance, true);
        let a = core::f64::consts::TAU / f64::from(n);
        for (x, y) in [(0, 0), (3, 5), (8, 15), (15, 8), (12, 4)] {
            let uv = Vec2::new((x as f32 + 0.5) / n as f32, (y as f32 + 0.5) / n as f32);
            let value = texture.sample(uv, [Vec2::ZERO; 2], [Wrap::Repeat; 2], true);
            let got = [0, 1].map(|k| f64::from((2.0 * value[k] - 1.0) * scale));
            let (x, y) = (a * f64::from(x), a * f64::from(y));
            // Of central differences of a sine: sin a in place of a.
            let amplitude = 100.0 / 255.0 * a.sin();
            let want = [-amplitude * x.cos() * y.cos(), -amplitude * x.sin() * y.sin()];
            for k in 0..2 {
                assert!((got[k] - want[k]).abs() < 0.005, "{x} {y}: {got:?} {want:?}");
            }
        }
    }

    #[test]
    fn flat_heights_and_edges() {
        for size in [[1, 1], [1, 4], [3, 1], [2, 2]] {
            let flat = vec![[70, 70, 70, 255]; (size[0] * size[1]) as usize];
            for repeats in [false, true] {
                assert_eq!(slopes("flat", size, &flat, Source::Luminance, repeats).1, 0.0);
            }
        }
        // A step at the edge is one only where the image goes on with its other side.
        let step: Vec<Texel> = (0..8).map(|x| [[0, 0, 0, 255], [255; 4]][usize::from(x % 4 > 1)]).collect();
        let edge = |repeats| {
            let (texture, scale) = slopes("step", [4, 2], &step, Source::Channel(0), repeats);
            let value = texture.sample(Vec2::new(0.01, 0.5), [Vec2::ZERO; 2], [Wrap::Clamp; 2], true);
            (2.0 * value[0] - 1.0) * scale
        };
        assert!((edge(true) - 0.5).abs() < 0.01 && edge(false).abs() < 0.01, "{} {}", edge(true), edge(false));
    }

    #[test]
    fn opacity_is_alpha_where_it_says_something() {
        let grey = vec![[100, 100, 100, 255]; 4];
        assert_eq!(opacity("o", [2, 2], grey.clone(), None).alphas(), [100; 4]);
        assert_eq!(opacity("o", [2, 2], grey, Some(Source::Channel(3))).alphas(), [255; 4]);
        assert_eq!(opacity("o", [2, 2], vec![[100, 200, 0, 30]; 4], None).alphas(), [30; 4]);
        assert_eq!(opacity("o", [2, 2], vec![[100, 200, 0, 30]; 4], Some(Source::Channel(1))).alphas(), [200; 4]);
    }

    #[test]
    fn normals_are_told_from_heights() {
        assert!(shows_normals(&[[128, 128, 255, 255], [100, 160, 230, 255]]));
        assert!(!shows_normals(&wave(8)) && !shows_normals(&[[0, 0, 255, 255]]) && !shows_normals(&[[255; 4]]));
    }
}
