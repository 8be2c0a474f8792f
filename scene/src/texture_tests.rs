use crate::{Encoding, Texture, Wrap};
use glam::Vec2;

const NEAR: [Vec2; 2] = [Vec2::ZERO; 2];

/// Texels of pseudo-random bytes.
fn noise(size: [u32; 2], encoding: Encoding) -> Texture {
    let mut state = 1u32;
    let mut byte = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    let texels = (0..size[0] * size[1]).map(|_| core::array::from_fn(|_| byte())).collect();
    Texture::new("noise", size, texels, encoding)
}

#[test]
fn texels_are_at_their_centres() {
    let texture = noise([5, 3], Encoding::Linear);
    let all = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];
    for wrap in all {
        for pixelated in [false, true] {
            for (x, y) in [(0, 0), (4, 0), (2, 1), (4, 2)] {
                let uv = Vec2::new((x as f32 + 0.5) / 5.0, (y as f32 + 0.5) / 3.0);
                let got = texture.sample(uv, NEAR, [wrap; 2], pixelated);
                let want = noise_texel(5, x, y);
                for k in 0..4 {
                    assert!((got[k] - want[k]).abs() < 1e-5, "{wrap:?} {x} {y}: {got:?} {want:?}");
                }
            }
        }
    }
}

/// The value of [`noise`] at a texel.
fn noise_texel(width: u32, x: u32, y: u32) -> [f32; 4] {
    let mut state = 1u32;
    let mut value = 0.0;
    let mut out = [0.0; 4];
    for i in 0..4 * (y * width + x + 1) {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        value = (state >> 24) as f32 / 255.0;
        out[i as usize % 4] = value;
    }
    assert!(value >= 0.0);
    out
}

#[test]
fn wrapped_coordinates_repeat_mirror_or_stay() {
    let texture = noise([7, 4], Encoding::Linear);
    let at = |u: f32, v: f32, wrap| texture.sample(Vec2::new(u, v), NEAR, [wrap; 2], false);
    let near = |a: [f32; 4], b: [f32; 4]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2e-4);
    for (u, v) in [(0.1, 0.2), (0.93, 0.01), (0.5, 0.99)] {
        assert!(near(at(u, v, Wrap::Repeat), at(u + 3.0, v - 2.0, Wrap::Repeat)));
        assert!(near(at(u, v, Wrap::Mirror), at(-u, 2.0 - v, Wrap::Mirror)));
        assert!(near(at(1.0, v, Wrap::Clamp), at(1.0 + u, v, Wrap::Clamp)));
    }
    // Across a seam without a step.
    for wrap in [Wrap::Repeat, Wrap::Mirror] {
        assert!(near(at(0.999_99, 0.3, wrap), at(1.000_01, 0.3, wrap)), "{wrap:?}");
    }
}

#[test]
fn the_pyramid_keeps_the_mean() {
    for size in [[16, 16], [7, 13], [1, 9], [31, 2]] {
        for encoding in [Encoding::Linear, Encoding::Srgb] {
            let texture = noise(size, encoding);
            let mut mean = [0.0; 4];
            for y in 0..size[1] {
                for x in 0..size[0] {
                    let uv = Vec2::new((x as f32 + 0.5) / size[0] as f32, (y as f32 + 0.5) / size[1] as f32);
                    let value = texture.sample(uv, NEAR, [Wrap::Repeat; 2], true);
                    for k in 0..4 {
                        mean[k] += value[k] / (size[0] * size[1]) as f32;
                    }
                }
            }
            let far = texture.sample(Vec2::splat(0.3), [Vec2::X * 40.0, Vec2::Y * 40.0], [Wrap::Repeat; 2], false);
            for k in 0..4 {
                // Each level rounds to a byte.
                assert!((far[k] - mean[k]).abs() < 0.012, "{size:?} {encoding:?}: {far:?} {mean:?}");
            }
        }
    }
}

#[test]
fn footprints_blur_by_as_much_as_they_are_long() {
    // Stripes across u, two texels a period: a footprint of many periods along u sees grey, one along v sees them.
    let texels = (0..64 * 64).map(|i| if i % 2 == 0 { [255; 4] } else { [0, 0, 0, 255] }).collect();
    let stripes = Texture::new("stripes", [64, 64], texels, Encoding::Linear);
    let uv = Vec2::new(10.5 / 64.0, 0.4);
    let at = |a: Vec2, b: Vec2| stripes.sample(uv, [a, b], [Wrap::Repeat; 2], false)[0];
    assert!((at(Vec2::X * 0.25, Vec2::Y / 64.0) - 0.5).abs() < 0.05);
    assert!(at(Vec2::X / 128.0, Vec2::Y * 0.1) > 0.9, "{}", at(Vec2::X / 128.0, Vec2::Y * 0.1));
}

#[test]
fn squares_are_means_over_the_footprint() {
    let texture = noise([5, 3], Encoding::Linear);
    let texel = |x: i64, y: i64| noise_texel(5, x.rem_euclid(5) as u32, y.rem_euclid(3) as u32);
    // The texels that a part of a line covers, with their parts of it.
    let covered = |at: f64, width: f64| {
        let (begin, end) = (at - 0.5 * width, at + 0.5 * width);
        let part = move |k: i64| (((k + 1) as f64).min(end) - (k as f64).max(begin)).max(0.0) / width;
        (begin.floor() as i64..=end.floor() as i64).map(move |k| (k, part(k)))
    };
    for (u, v, across, down) in
        [(0.13, 0.31, 0.9, 0.7), (0.79, 0.66, 0.3, 0.05), (0.402, 0.334, 0.02, 0.01), (-2.61, 7.99, 1.0, 1.0)]
    {
        let sides = [Vec2::new(across / 5.0, 0.0), Vec2::new(0.0, down / 3.0)];
        let got = texture.sample(Vec2::new(u, v), sides, [Wrap::Repeat; 2], true);
        let mut want = [0.0; 4];
        for (x, a) in covered(f64::from(u) * 5.0, f64::from(across)) {
            for (y, b) in covered(f64::from(v) * 3.0, f64::from(down)) {
                texel(x, y).iter().zip(&mut want).for_each(|(value, sum)| *sum += value * (a * b) as f32);
            }
        }
        assert!((0..4).all(|k| (got[k] - want[k]).abs() < 1e-4), "{u} {v}: {got:?} {want:?}");
    }
}

#[test]
fn any_coordinates_give_a_value() {
    let texture = noise([3, 5], Encoding::Srgb);
    let extremes = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, -1e30, 1e-30, 0.0, -0.0, 1.0, 16_777_217.0];
    for u in extremes {
        for v in extremes {
            for d in extremes {
                for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
                    let side = Vec2::new(d, u);
                    let value = texture.sample(Vec2::new(u, v), [side, Vec2::splat(d)], [wrap; 2], d > 0.0);
                    assert!(value.iter().all(|x| (0.0..=1.0001).contains(x)), "{u} {v} {d}: {value:?}");
                }
            }
        }
    }
}

/// Bilinear values in f64, texel by texel, for every wrap, sizes of powers of two and others, and places far from the image.
#[test]
fn lookups_are_bilinear_between_decoded_texels() {
    let wrapped = |i: i64, n: i64, wrap: Wrap| match wrap {
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::Mirror => {
            let k = i.rem_euclid(2 * n);
            k.min(2 * n - 1 - k)
        }
        Wrap::Clamp => i.clamp(0, n - 1),
    };
    let all = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp];
    let mut worst = 0.0_f64;
    for size in [[1, 1], [1, 2], [2, 8], [3, 1], [5, 4], [7, 13], [64, 16]] {
        for encoding in [Encoding::Linear, Encoding::Srgb] {
            let texture = noise(size, encoding);
            let [w, h] = size.map(i64::from);
            let texel = |x: i64, y: i64| {
                let uv = Vec2::new((x as f32 + 0.5) / w as f32, (y as f32 + 0.5) / h as f32);
                texture.sample(uv, NEAR, [Wrap::Clamp; 2], true)
            };
            for wrap in all.into_iter().flat_map(|a| all.map(|b| [a, b])) {
                for k in 0..64 {
                    // Eighths of the image are exact at any distance, and so are texels' edges and centres.
                    let far = [0.0, -3.0, 200.0, 30_000.0][k / 16];
                    let uv = Vec2::new(far + k as f32 / 8.0 - 0.75, far * 0.5 - k as f32 / 16.0 + 0.375);
                    let got = texture.sample(uv, NEAR, wrap, false);
                    let at = [f64::from(uv.x) * w as f64 - 0.5, f64::from(uv.y) * h as f64 - 0.5];
                    let [x, y] = at.map(|x| x.floor() as i64);
                    let [s, t] = at.map(|x| x - x.floor());
                    for (c, got) in got.into_iter().enumerate() {
                        let value = |i, j| f64::from(texel(wrapped(x + i, w, wrap[0]), wrapped(y + j, h, wrap[1]))[c]);
                        let row = |j| value(0, j) * (1.0 - s) + value(1, j) * s;
                        let want = row(0) * (1.0 - t) + row(1) * t;
                        worst = worst.max((f64::from(got) - want).abs());
                        assert!(worst < 2e-6, "{size:?} {wrap:?} {uv}: {got} {want}");
                    }
                }
            }
        }
    }
}

/// Between levels and along a footprint: the means of the levels' own values.
#[test]
fn levels_and_taps_are_means() {
    // Each level of this is known: a ramp of texels along u is a ramp of half as many steps.
    let n = 64;
    let texels = (0..n * n).map(|i| [(4 * (i % n)) as u8; 4]).collect();
    let ramp = Texture::new("ramp", [n, n], texels, Encoding::Linear);
    // In the middle, where none reaches beyond the edge.
    for long in [1.5, 2.0, 3.0, 5.0, 7.5] {
        for short in [0.5, 1.0, 2.0] {
            let sides = [Vec2::X * long / n as f32, Vec2::Y * short / n as f32];
            for (u, sides) in [(0.5, sides), (0.55, sides), (0.47, [sides[1], sides[0]])] {
                let got = ramp.sample(Vec2::new(u, 0.3), sides, [Wrap::Repeat; 2], false)[0];
                let want = 4.0 * (u * n as f32 - 0.5) / 255.0;
                assert!((got - want).abs() < 0.5 / 255.0, "{long} {short} {u}: {got} {want}");
            }
        }
    }
}

/// The widest image, texel by texel, at a coordinate where single precision just separates texels.
#[test]
fn the_largest_image_keeps_its_texels_apart() {
    let width = Texture::MAX_SIDE;
    let texels = (0..width).map(|i| [(i % 251) as u8, (i / 251) as u8, 0, 255]).collect();
    let texture = Texture::new("wide", [width, 1], texels, Encoding::Linear);
    for i in [0, 1, 250, 251, 8191, 8192, 12_345, width - 1] {
        for (far, wrap) in [(0.0, Wrap::Clamp), (-90.0, Wrap::Repeat), (100.0, Wrap::Repeat), (126.0, Wrap::Mirror)] {
            let u = far + (i as f32 + 0.5) / width as f32;
            let got = texture.sample(Vec2::new(u, 0.5), NEAR, [wrap; 2], false);
            let number = (got[0] * 255.0).round() as u32 + 251 * (got[1] * 255.0).round() as u32;
            assert_eq!(number, i, "{far} {wrap:?}");
        }
    }
}
