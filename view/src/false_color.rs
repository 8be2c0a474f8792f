//! Pictures of what is no colour.

use cosine_lobes::glam::Vec3;
use cosine_lobes::luminance;
use cosine_lobes::renderer::Layers;

pub(crate) type Rgb = [u8; 3];

const GREY: Rgb = [70, 70, 74];

/// A part of the unshadowed radiance is no light at all, or all of it, up to this.
const EDGE: f64 = 1e-3;

/// Lit, penumbra or dark: by how much of the unshadowed radiance is left.
pub(crate) fn classes(radiance: &[Vec3], unshadowed: &[Vec3]) -> Vec<Rgb> {
    let class = |(with, without): (&Vec3, &Vec3)| {
        let (with, without) = (luminance(*with), luminance(*without));
        if without <= 0.0 {
            return GREY;
        }
        match with / without {
            part if part <= EDGE => [12, 12, 16],
            part if part >= 1.0 - EDGE => [245, 245, 240],
            part => mix([150, 62, 8], [255, 190, 90], part as f32),
        }
    };
    radiance.iter().zip(unshadowed).map(class).collect()
}

pub(crate) fn normals(normals: &[Vec3]) -> Vec<Rgb> {
    let color = |n: &Vec3| match n.length_squared() > 0.0 {
        true => ((0.5 * *n + 0.5) * 255.0).clamp(Vec3::ZERO, Vec3::splat(255.0)).to_array().map(|c| c as u8),
        false => GREY,
    };
    normals.iter().map(color).collect()
}

/// Nearest white, farthest dark, by the inverse of the distance.
pub(crate) fn depths(depths: &[f32]) -> Vec<Rgb> {
    let seen = || depths.iter().copied().filter(|depth| depth.is_finite() && *depth > 0.0);
    let (near, far) = seen().fold((f32::INFINITY, 0.0_f32), |(near, far), depth| (near.min(depth), far.max(depth)));
    let (most, least) = (1.0 / near, 1.0 / far.max(f32::MIN_POSITIVE));
    let grey = |depth: &f32| {
        if !depth.is_finite() || *depth <= 0.0 {
            return [20, 24, 60];
        }
        let part = (1.0 / depth - least) / (most - least).max(f32::MIN_POSITIVE);
        [(30.0 + 225.0 * part.clamp(0.0, 1.0)) as u8; 3]
    };
    depths.iter().map(grey).collect()
}

/// From yellow for the nearest over red to black for the farthest, evenly by the distance; grey where it is infinite.
pub(crate) fn distances(distances: &[f32], [near, far]: [f32; 2]) -> Vec<Rgb> {
    let color = |distance: &f32| {
        if !distance.is_finite() {
            return GREY;
        }
        heat(1.0 - (distance - near) / (far - near).max(f32::MIN_POSITIVE))
    };
    distances.iter().map(color).collect()
}

/// A colour for each object: hues a golden angle apart.
pub(crate) fn objects(objects: &[u32]) -> Vec<Rgb> {
    objects.iter().map(|object| if *object == Layers::NO_OBJECT { GREY } else { of_number(*object) }).collect()
}

/// The colour of an object's number.
pub(crate) fn of_number(number: u32) -> Rgb {
    let hue = (number as f32 * 0.618_034).fract() * 6.0;
    let channel = |shift: f32| {
        let h = (hue + shift).rem_euclid(6.0);
        let value = (h.min(4.0 - h)).clamp(0.0, 1.0);
        (70.0 + 170.0 * value) as u8
    };
    [channel(2.0), channel(0.0), channel(4.0)]
}

/// Numbers of surfaces in pixels that outlines cross: dark at none, from red to yellow at eight.
pub(crate) fn edges(surfaces: &[u32]) -> Vec<Rgb> {
    let color = |count: &u32| if *count == 0 { [30, 30, 34] } else { heat(0.5 + 0.5 * (*count as f32 / 8.0).min(1.0)) };
    surfaces.iter().map(color).collect()
}

/// From black over red to yellow, by the logarithm.
pub(crate) fn counts(counts: &[f32]) -> Vec<Rgb> {
    let most = counts.iter().copied().fold(1.0_f32, f32::max);
    let color = |count: &f32| heat((count.max(0.0) + 1.0).ln() / (most + 1.0).ln());
    counts.iter().map(color).collect()
}

/// From black at 0 over red to yellow at 1.
fn heat(part: f32) -> Rgb {
    if part < 0.5 {
        mix([8, 6, 20], [190, 40, 60], 2.0 * part)
    } else {
        mix([190, 40, 60], [255, 235, 120], 2.0 * part - 1.0)
    }
}

fn mix(from: Rgb, to: Rgb, part: f32) -> Rgb {
    let part = part.clamp(0.0, 1.0);
    core::array::from_fn(|k| (f32::from(from[k]) + (f32::from(to[k]) - f32::from(from[k])) * part) as u8)
}
