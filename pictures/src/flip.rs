//! LDR-FLIP, the difference between two pictures that an observer sees when they alternate on a screen.
//!
//! P. Andersson, J. Nilsson, T. Akenine-Möller, M. Oskarsson, K. Åström, M. D. Fairchild, *FLIP: A Difference Evaluator
//! for Alternating Images*, Proc. ACM Comput. Graph. Interact. Tech. 3(2), 2020. Two pipelines: colours at the resolution of
//! the eye (filtered by contrast sensitivity, then compared in L\*a\*b\*), and features (edges and
//! points of the luminance), which raise the difference of the colours.

use crate::srgb_to_linear;
use glam::{DMat3, Mat3, Vec3};
use rayon::prelude::*;

/// Pixels of a degree of the visual field, p: that of a screen 0.7 m wide with 3840 pixels, seen from 0.7 m.
pub(crate) const PIXELS_PER_DEGREE: f32 = 67.02;

/// Contrast sensitivity `Σ a exp(−b f²)` at the frequency f in cycles a degree, as pairs (a, b): achromatic, red-green
/// and blue-yellow.
const ACHROMATIC: [(f64, f64); 1] = [(1.0, 0.0047)];
const RED_GREEN: [(f64, f64); 1] = [(1.0, 0.0053)];
const BLUE_YELLOW: [(f64, f64); 2] = [(34.1, 0.04), (13.5, 0.025)];
/// The largest b above: it sets the size of the windows.
const WIDEST: f64 = 0.04;

/// Exponent q_c that compresses large differences of colour.
const COLOR_EXPONENT: f32 = 0.7;
/// Differences up to the fraction p_c of the largest one map to the fraction p_t of the range [0, 1].
const LOW_COLORS: f32 = 0.4;
const LOW_ANSWERS: f32 = 0.95;
/// Width w in degrees of the features that are looked for.
const FEATURE_WIDTH: f64 = 0.082;
/// Exponent q_f of the differences of features.
const FEATURE_EXPONENT: f32 = 0.5;

/// The difference of every pixel, row by row: 0 none, 1 the largest.
///
/// Takes eight-bit sRGB, three bytes a pixel, of two pictures of the same size, `width` pixels wide. Beyond the border
/// they go on as at the border. Symmetric, and exactly 0 where the pictures agree far enough around a pixel (ten pixels
/// at 67 a degree). Cost: about 200 multiplications a pixel of either picture, on all threads.
pub(crate) fn flip(a: &[u8], b: &[u8], width: usize, pixels_per_degree: f32) -> Vec<f32> {
    debug_assert_eq!(a.len(), b.len());
    if width == 0 {
        return Vec::new();
    }
    let space = Space::new();
    let p = f64::from(pixels_per_degree);
    let [a, b] = [a, b].map(|bytes| Seen::new(bytes, width, p, &space));
    let largest = largest_color_difference(&space);
    (0..a.colors.len())
        .into_par_iter()
        .map(|i| {
            let color = spread(color_difference(a.colors[i], b.colors[i]), largest);
            color.powf(1.0 - feature_difference(a.features[i], b.features[i]))
        })
        .collect()
}

/// A picture as an observer sees it.
struct Seen {
    /// Filtered colours in L\*a\*b\*, with Hunt's adjustment.
    colors: Vec<Vec3>,
    /// Strengths of the edge and of the point in each pixel.
    features: Vec<[f32; 2]>,
}

impl Seen {
    fn new(srgb: &[u8], width: usize, pixels_per_degree: f64, space: &Space) -> Self {
        let linear: Vec<f32> = (0..=u8::MAX).map(|byte| srgb_to_linear(f32::from(byte) / 255.0)).collect();
        let opponent: Vec<Vec3> = srgb
            .par_chunks_exact(3)
            .map(|c| space.opponent(Vec3::from([c[0], c[1], c[2]].map(|byte| linear[usize::from(byte)]))))
            .collect();
        let [luminance, red_green, blue_yellow] =
            [0, 1, 2].map(|channel| opponent.par_iter().map(|o| o[channel]).collect::<Vec<f32>>());
        drop(opponent);

        let features = features(&luminance, width, pixels_per_degree);
        let luminance = sensitivity(&luminance, width, pixels_per_degree, &ACHROMATIC);
        let red_green = sensitivity(&red_green, width, pixels_per_degree, &RED_GREEN);
        let blue_yellow = sensitivity(&blue_yellow, width, pixels_per_degree, &BLUE_YELLOW);
        let colors = (0..luminance.len())
            .into_par_iter()
            .map(|i| hunt(space.lab(space.rgb(Vec3::new(luminance[i], red_green[i], blue_yellow[i])))))
            .collect();
        Self { colors, features }
    }
}

/// Conversions between the colour spaces in use. All are relative to the white of sRGB.
struct Space {
    /// Linear sRGB to X/Xn, Y/Yn, Z/Zn.
    xyz: Mat3,
    /// The opposite.
    rgb: Mat3,
}

impl Space {
    fn new() -> Self {
        // IEC 61966-2-1; the columns are the primaries, their sum is the white.
        let primaries = [[0.4124, 0.2126, 0.0193], [0.3576, 0.7152, 0.1192], [0.1805, 0.0722, 0.9505]];
        let xyz = DMat3::from_cols_array_2d(&primaries);
        let white = xyz * glam::DVec3::ONE;
        let xyz = DMat3::from_diagonal(white.recip()) * xyz;
        Self { xyz: xyz.as_mat3(), rgb: xyz.inverse().as_mat3() }
    }

    /// Achromatic, red-green and blue-yellow part of a linear colour: `(Y, X − Y, Y − Z)`, each relative to white.
    ///
    /// YCxCz without its factors 116, 500, 200 and its offset, which a filter of sum 1 lets through unchanged.
    fn opponent(&self, rgb: Vec3) -> Vec3 {
        let [x, y, z] = (self.xyz * rgb).to_array();
        Vec3::new(y, x - y, y - z)
    }

    /// The linear colour that has these opponent parts, clamped to [0, 1].
    fn rgb(&self, opponent: Vec3) -> Vec3 {
        let [y, red_green, blue_yellow] = opponent.to_array();
        (self.rgb * Vec3::new(red_green + y, y, y - blue_yellow)).clamp(Vec3::ZERO, Vec3::ONE)
    }

    /// CIE L\*a\*b\* of a linear colour.
    fn lab(&self, rgb: Vec3) -> Vec3 {
        const DELTA: f32 = 6.0 / 29.0;
        let f = |t: f32| if t > DELTA.powi(3) { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 };
        let [x, y, z] = (self.xyz * rgb).to_array().map(f);
        Vec3::new(116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z))
    }
}

/// Hunt's effect: colours look the more colourful the lighter they are.
fn hunt(lab: Vec3) -> Vec3 {
    let chroma = 0.01 * lab.x;
    Vec3::new(lab.x, chroma * lab.y, chroma * lab.z)
}

/// Compressed distance of two colours: HyAB, `|ΔL| + √(Δa² + Δb²)`, to the power of q_c.
fn color_difference(a: Vec3, b: Vec3) -> f32 {
    let d = a - b;
    (d.x.abs() + d.y.hypot(d.z)).powf(COLOR_EXPONENT)
}

/// c_max: the difference between green and blue, the largest within sRGB.
fn largest_color_difference(space: &Space) -> f32 {
    color_difference(hunt(space.lab(Vec3::Y)), hunt(space.lab(Vec3::Z)))
}

/// Brings differences of colours to [0, 1], steeply up to p_c of the largest one and flat above.
fn spread(difference: f32, largest: f32) -> f32 {
    let knee = LOW_COLORS * largest;
    if difference < knee {
        LOW_ANSWERS * difference / knee
    } else {
        let above = (difference - knee) / (largest - knee);
        (LOW_ANSWERS + (1.0 - LOW_ANSWERS) * above).min(1.0)
    }
}

/// `(max(|Δedge|, |Δpoint|)/√2)^q_f`, in [0, 1].
fn feature_difference(a: [f32; 2], b: [f32; 2]) -> f32 {
    let larger = (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
    (larger * std::f32::consts::FRAC_1_SQRT_2).powf(FEATURE_EXPONENT).min(1.0)
}

/// A plane as the eye resolves it.
fn sensitivity(plane: &[f32], width: usize, pixels_per_degree: f64, terms: &[(f64, f64)]) -> Vec<f32> {
    use std::f64::consts::PI;
    let deviation = |b: f64| (b / (2.0 * PI * PI)).sqrt() * pixels_per_degree;
    let window = (3.0 * deviation(WIDEST)).ceil();
    // The term `a exp(−b f²)` is `a √(π/b) exp(−π² x²/b)` at x degrees. Each is separable, their sum is not.
    let bells = terms.iter().map(|&(a, b)| {
        // The bell is cut at six deviations, where less than 1e-7 is left.
        let bell = bell(window.min((6.0 * deviation(b)).ceil()) as isize, deviation(b));
        (a * (PI / b).sqrt() * bell.iter().sum::<f64>().powi(2), balanced(&bell))
    });
    let bells: Vec<_> = bells.collect();
    let whole: f64 = bells.iter().map(|(weight, _)| weight).sum();
    let mut result = vec![0.0; plane.len()];
    for (weight, bell) in &bells {
        filter(plane, width, [bell, bell], (weight / whole) as f32, &mut result);
    }
    result
}

/// Strengths of edges and of points: lengths of the first and of the second derivatives along x and y, smoothed.
fn features(luminance: &[f32], width: usize, pixels_per_degree: f64) -> Vec<[f32; 2]> {
    let deviation = 0.5 * FEATURE_WIDTH * pixels_per_degree;
    let radius = (3.0 * deviation).ceil() as isize;
    let bell = bell(radius, deviation);
    let derived = |factor: &dyn Fn(f64) -> f64| -> Vec<f64> {
        (-radius..=radius).zip(&bell).map(|(k, g)| g * factor(k as f64 / deviation)).collect()
    };
    let smooth = balanced(&bell);
    let along = |derivative: &[f64]| {
        let derivative = balanced(derivative);
        let [mut x, mut y] = [(); 2].map(|()| vec![0.0; luminance.len()]);
        filter(luminance, width, [&derivative, &smooth], 1.0, &mut x);
        filter(luminance, width, [&smooth, &derivative], 1.0, &mut y);
        x.into_par_iter().zip(y).map(|(x, y)| x.hypot(y))
    };
    along(&derived(&|t| -t)).zip(along(&derived(&|t| t * t - 1.0))).map(|(edge, point)| [edge, point]).collect()
}

/// `exp(−k²/2σ²)` for k from −`radius` to `radius`.
fn bell(radius: isize, deviation: f64) -> Vec<f64> {
    (-radius..=radius).map(|k| (-0.5 * (k as f64 / deviation).powi(2)).exp()).collect()
}

/// The weights with their positive ones scaled to the sum 1 and their negative ones to −1.
fn balanced(weights: &[f64]) -> Vec<f32> {
    let sum = |sign: f64| weights.iter().map(|w| (sign * w).max(0.0)).sum::<f64>();
    let (positive, negative) = (sum(1.0), sum(-1.0));
    weights.iter().map(|w| (w / if *w > 0.0 { positive } else { negative.max(f64::MIN_POSITIVE) }) as f32).collect()
}

/// Adds `gain` times the plane filtered along x and y by the two rows of weights, the middle one of which is at the
/// pixel itself.
fn filter(plane: &[f32], width: usize, [along_x, along_y]: [&[f32]; 2], gain: f32, sum: &mut [f32]) {
    let (left, above) = (along_x.len() / 2, along_y.len() / 2);
    let last = (plane.len() / width).saturating_sub(1);
    // One row filtered along y, carried on to either side as far as the weights along x reach.
    let wide = || vec![0.0f32; width + 2 * left];
    sum.par_chunks_exact_mut(width).enumerate().for_each_init(wide, |wide, (y, sum)| {
        let row = &mut wide[left..left + width];
        row.fill(0.0);
        for (k, weight) in along_y.iter().enumerate() {
            let from = (y + k).saturating_sub(above).min(last) * width;
            for (to, from) in row.iter_mut().zip(&plane[from..from + width]) {
                *to += weight * from;
            }
        }
        let (first, end) = (row[0], row[width - 1]);
        wide[..left].fill(first);
        wide[left + width..].fill(end);
        for (k, weight) in along_x.iter().enumerate() {
            for (to, from) in sum.iter_mut().zip(&wide[k..]) {
                *to += gain * weight * from;
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (usize, usize) = (64, 48);

    fn picture(color: impl Fn(i32, i32) -> [i32; 3]) -> Vec<u8> {
        let pixels = (0..SIZE.1 as i32).flat_map(|y| (0..SIZE.0 as i32).map(move |x| (x, y)));
        pixels.flat_map(|(x, y)| color(x, y).map(|c| c.clamp(0, 255) as u8)).collect()
    }

    /// Bytes without visible order.
    fn noise(x: i32, y: i32, channel: i32) -> i32 {
        let mut h = (x + 64 * y + 4096 * channel) as u32;
        for factor in [0x7feb_352d_u32, 0x846c_a68b] {
            h = (h ^ (h >> 15)).wrapping_add(0x9e37_79b9).wrapping_mul(factor);
        }
        (h >> 24) as i32
    }

    /// Pairs of pictures: gradients, noise, edges, points, shadows.
    fn pairs() -> [[Vec<u8>; 2]; 7] {
        let ramp = |x: i32, y: i32| [4 * x, 5 * y, 255 - 3 * x - y];
        let stripes =
            |wide: i32| move |x: i32, y: i32| if ((x + y / 2) / wide) % 2 == 0 { [230, 51, 26] } else { [26, 77, 204] };
        let ground = [51, 64, 77];
        [
            [picture(ramp), picture(|x, y| ramp(x, y).map(|c| c * 9 / 10))],
            [picture(ramp), picture(|x, y| ramp(x + 2, y + 1))],
            [
                picture(ramp),
                picture(|x, y| {
                    let c = ramp(x, y);
                    [0, 1, 2].map(|k| c[k] + noise(x, y, k as i32) / 8 - 16)
                }),
            ],
            [picture(|x, y| [0, 1, 2].map(|k| noise(x, y, k))), picture(|x, y| [3, 4, 5].map(|k| noise(x, y, k)))],
            [picture(stripes(4)), picture(stripes(5))],
            [picture(|_, _| ground), picture(|x, y| if x % 17 == 8 && y % 13 == 6 { [255; 3] } else { ground })],
            [picture(|x, _| [8 * (x - 16) + 25; 3]), picture(|x, y| [16 * (x - 24 + y / 16) + 25; 3])],
        ]
    }

    /// Pixels (x, y) whose values are recorded.
    const PROBES: [(usize, usize); 5] = [(0, 0), (8, 6), (24, 30), (31, 20), (63, 47)];

    fn mean(values: &[f32]) -> f64 {
        values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64
    }

    /// Against the authors' own implementation (by way of the crate nv-flip 0.1.2) at 67.02
    /// pixels a degree. It has colour constants of more digits; over these pairs and others up to 320×240 pixels the
    /// two differed by 2.4e-4 in a pixel and 6e-5 in the mean at most.
    #[test]
    fn agrees_with_the_authors() {
        let golden = [
            (0.343205, [0.33245, 0.30609, 0.28152, 0.25451, 0.52487]),
            (0.200446, [0.11838, 0.09283, 0.21758, 0.19369, 0.19587]),
            (0.082622, [0.05237, 0.06232, 0.08580, 0.07377, 0.16929]),
            (0.445892, [0.69086, 0.57523, 0.62225, 0.22242, 0.58791]),
            (0.400431, [0.22885, 0.21046, 0.08020, 0.11578, 0.23604]),
            (0.043732, [0.00013, 0.61527, 0.19015, 0.00254, 0.00657]),
            (0.227232, [0.00000, 0.00000, 0.53679, 0.32177, 0.00000]),
        ];
        for (case, ([a, b], (expected, probes))) in pairs().into_iter().zip(golden).enumerate() {
            let map = flip(&a, &b, SIZE.0, PIXELS_PER_DEGREE);
            let error = (mean(&map) - expected).abs();
            assert!(error <= 1e-4, "pair {case}: mean off by {error}");
            for ((x, y), probe) in PROBES.into_iter().zip(probes) {
                let error = (map[y * SIZE.0 + x] - probe).abs();
                assert!(error <= 4e-4, "pair {case}: pixel {x}, {y} off by {error}");
            }
        }
    }

    #[test]
    fn equal_pictures_symmetry_and_range() {
        for [a, b] in pairs() {
            assert!(flip(&a, &a, SIZE.0, PIXELS_PER_DEGREE).iter().all(|v| *v == 0.0));
            let map = flip(&a, &b, SIZE.0, PIXELS_PER_DEGREE);
            assert_eq!(map, flip(&b, &a, SIZE.0, PIXELS_PER_DEGREE));
            assert!(map.iter().all(|v| (0.0..=1.0).contains(v)) && mean(&map) > 0.01);
        }
    }

    #[test]
    fn a_point_is_seen_near_it() {
        let (black, mut point) = (picture(|_, _| [0; 3]), picture(|_, _| [0; 3]));
        point[3 * (24 * SIZE.0 + 32)] = 255;
        let map = flip(&black, &point, SIZE.0, PIXELS_PER_DEGREE);
        for (i, value) in map.iter().enumerate() {
            let away = (i % SIZE.0).abs_diff(32).max((i / SIZE.0).abs_diff(24));
            assert!(if away == 0 { *value > 0.1 } else { away <= 10 || *value == 0.0 }, "{away} away: {value}");
        }
    }

    /// Without features only the colours count, at any size: `L* = 0` and `100` by hand.
    #[test]
    fn flat_pictures() {
        let space = Space::new();
        let expected = spread(100f32.powf(0.7), largest_color_difference(&space));
        for (width, height) in [(1, 1), (1, 7), (7, 1), (40, 30)] {
            let [black, white] = [0, 255].map(|byte| vec![byte; 3 * width * height]);
            let map = flip(&black, &white, width, PIXELS_PER_DEGREE);
            assert_eq!(map.len(), width * height);
            assert!(map.iter().all(|v| (v - expected).abs() < 1e-3), "{} and {expected}", map[0]);
        }
        assert!(flip(&[], &[], 0, PIXELS_PER_DEGREE).is_empty());
        assert_eq!(flip(&[0, 255, 0], &[0, 0, 255], 1, PIXELS_PER_DEGREE), [1.0]);
    }
}
