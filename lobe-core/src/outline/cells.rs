//! Integrals of reflectances with long tails over lights that show images, by cells of the image.

use super::cubature::{Peak, Value};
use super::on_plane::OnPlane;
use super::{LightImage, Places};
use glam::{Mat2, UVec2, Vec2, Vec3, Vec3A};

/// A cell is small if half its diagonal is at most this part of `√(1 + t²)`, where `t` is its distance from the peak; both in the peak's widths.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells(pub(super) f32);

impl Cells {
    /// Of Lambert's and other wide lobes.
    pub(super) const WIDE: Self = Self(0.07);
    pub(super) const POWER: Self = Self(0.12);
    pub(super) const FACETS: Self = Self(0.2);
}

/// Cells are halved at least this often: a reflectance varies a little over small lights too.
pub(super) const SHALLOWEST: u32 = 3;

/// A cell that a horizon crosses is small from this part of that on.
pub(super) const AT_HORIZON: f32 = 0.25;

/// The image is taken to change evenly within texels of this copy and coarser ones. It does not within those of the finest, nor of four of them.
pub(super) const SMOOTH: u32 = 2;

/// Among quarters of a cell of which one has less than this part of another's weight, the reflectance is far from linear: it ends at a horizon, or peaks.
pub(super) const EVEN: f32 = 0.25;

/// Cells are halved this often at most: single precision resolves no smaller ones.
pub(super) const DEEPEST: u32 = 20;

/// One of 2ᵈ × 2ᵈ equal parts of a rectangle, in the order of a Z.
#[derive(Clone, Copy, Default)]
struct Cell {
    x: u32,
    y: u32,
    depth: u32,
}

impl Cell {
    const fn first_quarter(self) -> Self {
        Self { x: 2 * self.x, y: 2 * self.y, depth: self.depth + 1 }
    }

    /// The first that is in none of those before it; none after the last.
    fn next(self) -> Option<Self> {
        let Self { mut x, mut y, mut depth } = self;
        while depth > 0 {
            match (x % 2, y % 2) {
                (0, _) => return Some(Self { x: x + 1, y, depth }),
                (_, 0) => return Some(Self { x: x - 1, y: y + 1, depth }),
                _ => (x, y, depth) = (x / 2, y / 2, depth - 1),
            }
        }
        None
    }
}

/// The four quarters of a cell, as far as they have come.
///
/// Each counts with the mean of the image times the reflectance at its middle, and so misses by how much both change together within it. The reflectance changes
/// as it does from quarter to quarter, and the image as it does from half to half of each.
#[derive(Clone, Copy, Default)]
struct Quarters {
    depth: u32,
    count: u32,
    weights: [f32; 4],
    /// Twice by how much the image changes from half to half, to the right and upward.
    changes: [Vec3A; 2],
}

impl Quarters {
    /// Adds the next cell. Returns what all four miss with the last one; 0 where some of them are divided or have no weight.
    fn add(&mut self, cell: Cell, changes: [Vec3A; 2], weight: f32) -> Vec3A {
        let place = cell.x % 2 + 2 * (cell.y % 2);
        if place == 0 {
            *self = Self { depth: cell.depth, ..Self::default() };
        } else if (self.depth, self.count) != (cell.depth, place) {
            return Vec3A::ZERO;
        }
        self.count += 1;
        self.weights[place as usize] = weight;
        self.changes = [0, 1].map(|axis| self.changes[axis] + changes[axis]);
        if self.count < 4 {
            return Vec3A::ZERO;
        }
        let [a, b, c, d] = self.weights;
        if a.min(b).min(c).min(d) < EVEN * a.max(b).max(c).max(d) {
            return Vec3A::ZERO;
        }
        // Over a cell of width 1 two lines of slopes s and t are `s t/12` above the product of their means; halves differ by `s/2`.
        (self.changes[0] * (b + d - a - c) + self.changes[1] * (c + d - a - b)) / 24.0
    }
}

/// The mean of an image by channel, weighted by a reflectance above the receiver's horizon, the first one; it may end at the second one. None where nothing
/// has a weight.
///
/// Microfacets have long tails: a bright place far beside the peak may give most of the light, and nodes in rows and columns would see it through
/// few long parts of the image. So the image is divided into cells that grow with their distance from the peak. Each is a texel of one of the
/// image's copies, the exact mean of what it covers, or a part of a texel of the finest one.
pub(super) fn mean_shown(
    horizons: [Vec3; 2],
    light: &OnPlane<'_>,
    peak: &Peak,
    value: impl Value,
    image: &LightImage,
    Cells(small): Cells,
) -> Option<Vec3> {
    let horizons = horizons.map(|n| light.local(n));
    let (middle, sides) = on_plane(&light.outline.places(light.frame))?;
    // Squares of texels: the copy that has one texel across has as many of them upward, or the other way round.
    let least = image.size().min_element();
    let (roots, levels) = (image.size() / least, least.ilog2());
    let (mut sum, mut weights, mut quarters) = (Vec3A::ZERO, 0.0, Quarters::default());
    for root in 0..roots.element_product() {
        let root = UVec2::new(root % roots.x, root / roots.x);
        let mut next = Some(Cell::default());
        while let Some(cell) = next {
            let half = (roots << cell.depth).as_vec2().recip();
            let texel = (root << cell.depth) + UVec2::new(cell.x, cell.y);
            let place = texel.as_vec2() * (2.0 * half) + half - 1.0;
            let p = middle + sides * place;
            let away = (p - peak.point) / peak.width;
            let diagonal =
                [sides.x_axis * half.x, sides.y_axis * half.y].map(|side| (side / peak.width).length_squared());
            let is_crossed = horizons.iter().any(|n| {
                let [x, y] = [sides.x_axis * half.x, sides.y_axis * half.y].map(|side| n.truncate().dot(side).abs());
                n.dot(p.extend(1.0)).abs() < x + y
            });
            let small = if is_crossed { AT_HORIZON * small } else { small };
            let is_large =
                cell.depth < SHALLOWEST || diagonal[0] + diagonal[1] > small * small * (1.0 + away.length_squared());
            if is_large && cell.depth < DEEPEST {
                next = Some(cell.first_quarter());
                continue;
            }
            next = cell.next();
            let p = p.extend(1.0);
            if horizons[0].dot(p) <= 0.0 {
                continue;
            }
            let inverse = 1.0 / p.length_squared();
            let weight = half.element_product() * (inverse * inverse.sqrt()) * value.at(p, inverse);
            sum += match levels.checked_sub(cell.depth) {
                Some(level) if level >= SMOOTH => {
                    let [a, b, c, d] = image.four(level - 1, 2 * texel);
                    let changes = [b + d - a - c, c + d - a - b];
                    (a + b + c + d) * (0.25 * weight) + quarters.add(cell, changes, weight)
                }
                Some(level) => image.texel(level, texel) * weight,
                None => Vec3A::from(image.at(place, 0.0)) * weight,
            };
            weights += weight;
        }
    }
    (weights > 0.0).then(|| Vec3::from(sum / weights))
}

/// An image's middle and its half sides on the plane at distance 1.
fn on_plane(places: &Places) -> Option<(Vec2, Mat2)> {
    let sides = Mat2::from_cols(places.x, places.y).inverse();
    sides.is_finite().then(|| (sides * -places.origin, sides))
}
