//! Irradiance of polygons of light.

use super::{FlatShape, Outline, sides};
use crate::lanes::{Columns, Lane, Level, WIDTH, row, update};
use crate::special::atan2;
use glam::Vec3;

/// From the polygon around a disc to that of the disc's area.
pub(super) const EQUAL: f32 = 0.997_136_8;

/// Corners below this part of their distance above a horizon are where it has cut.
pub(super) const CUT: f32 = 1e-5;

/// Squared sines below this have a series.
pub(super) const SHORT: f32 = 0.1;

/// A receiver farther than this part of a light's distance and size before its plane needs no care.
const WELL_BEFORE: f32 = 1e-3;

/// `∫ n·v/π dv` over the outline, which is above the receiver's horizon: Lambert's formula `1/2π Σ θᵢ n·Γᵢ` (*Photometria*, 1760) with
/// `Γᵢ = aᵢ × aᵢ₊₁/|aᵢ × aᵢ₊₁|` over the sides, θᵢ the angle that one is seen under.
///
/// Of a light that is small beside its distance these terms cancel. So the part that they have in common is summed apart: with
/// `1/a₀²` instead of `θᵢ/|aᵢ × aᵢ₊₁|` the sum is that of the polygon's area, and what is left is taken from differences of the corners.
///
/// # Accuracy
/// Relative to the same light above the receiver, against f64: 1e-5 for lights of all sizes from a thousandth of their distance.
pub(super) fn irradiance(normal: Vec3, light: &Outline) -> f32 {
    let plane = Plane::new(normal, light.axis, light.height);
    let around = |corners: &[Vec3]| {
        let first = plane.place(corners[0]);
        let mut sums = [0.0; SUMS];
        sides::each(&OneSide { plane, first }, corners, |[own, area, _]| {
            sums = [sums[0] + own, sums[1] + area, 0.0];
        });
        plane.total(sums, first)
    };
    match light.radius {
        Some(_) if light.is_clipped => {
            let mut corners = light.corners;
            for p in &mut corners[..light.count] {
                if normal.dot(*p) > CUT * p.length() {
                    *p = light.center + (*p - light.center) * EQUAL;
                }
            }
            around(&corners[..light.count])
        }
        Some(radius) => around(&Outline::around_disc(radius, light.axis).map(|offset| light.center + offset * EQUAL)),
        None => around(light.corners()),
    }
}

/// Sum of the sides' own parts, twice the area, and the least height of a corner above the horizon.
const SUMS: usize = 3;

/// The plane of a light as a receiver sees it. Corners are places in it: what rounding moves them out of it would turn small lights.
#[derive(Clone, Copy)]
struct Plane {
    normal: Vec3,
    axis: Vec3,
    height: f32,
    /// Cosine between the receiver's normal and the axis, and their cross product.
    cos: f32,
    across: Vec3,
}

impl Plane {
    #[inline(always)]
    fn new(normal: Vec3, axis: Vec3, height: f32) -> Self {
        Self { normal, axis, height, cos: normal.dot(axis), across: normal.cross(axis) }
    }

    /// From the foot of the receiver's perpendicular to a corner.
    #[inline(always)]
    fn place(&self, corner: Vec3) -> Vec3 {
        corner - self.axis * self.axis.dot(corner)
    }

    /// Adds the side from `p` to `q` of a polygon that begins at `first`.
    #[inline(always)]
    fn add(&self, [sum, area, least]: [f32; SUMS], [first, p, q]: [Vec3; 3]) -> [f32; SUMS] {
        let side = q - p;
        let square = self.height * self.height;
        let of_first = square + first.length_squared();
        let (of_p, of_q) = (square + p.length_squared(), square + q.length_squared());
        let both = (of_p * of_q).sqrt();
        let inverse = 1.0 / if both > f32::MIN_POSITIVE { both } else { f32::MIN_POSITIVE };
        // The cross product of the two corners: beside the axis and along it.
        let along = self.axis.dot(p.cross(side));
        let cross = self.height * self.across.dot(side) + along * self.cos;
        let length = (square * side.length_squared() + along * along).sqrt();
        // The angle over its sine, less one.
        let sin = length * inverse;
        let z = sin * sin;
        let series = z * (1.0 / 6.0 + z * (3.0 / 40.0 + z * (15.0 / 336.0 + z * (105.0 / 3456.0))));
        let cos = square + p.dot(q);
        let wide = atan2(length, cos) / if sin > f32::MIN_POSITIVE { sin } else { f32::MIN_POSITIVE } - 1.0;
        let is_short = (z < SHORT) & (cos > 0.0);
        let beyond = if is_short { series } else { wide };
        // 1/|a||b| − 1/a₀², from the differences of the squares.
        let (from_p, from_q) = ((p - first).dot(p + first), (q - first).dot(q + first));
        let excess = (of_first * (from_p + from_q) + from_p * from_q) / (of_first * (of_first + both));
        let own = (beyond - excess) * inverse;
        let height = self.height * self.cos + self.normal.dot(p);
        let larger = self.axis.dot((p - first).cross(q - first));
        [sum + cross * own, area + larger, if height < least { height } else { least }]
    }

    /// The irradiance over π.
    #[inline(always)]
    fn total(&self, [sum, area, _]: [f32; SUMS], first: Vec3) -> f32 {
        let square = self.height * self.height + first.length_squared();
        (area * self.cos / square + sum) * (0.5 * core::f32::consts::FRAC_1_PI)
    }
}

/// One side of an outline.
struct OneSide {
    plane: Plane,
    first: Vec3,
}

impl Lane<3, 3, SUMS> for OneSide {
    #[inline(always)]
    fn value(&self, p: [f32; 3], q: [f32; 3]) -> [f32; SUMS] {
        let place = |corner| self.plane.place(Vec3::from_array(corner));
        self.plane.add([0.0; SUMS], [self.first, place(p), place(q)])
    }
}

/// A corner of a shape: its place in the world, and what is added to it from the receiver.
type Corner = (Vec3, Vec3);

/// Adds how far a corner's plane is from all receivers of a block.
struct AddHeight {
    corner: Corner,
    axis: Vec3,
}

impl Lane<1, 9, 1> for AddHeight {
    #[inline(always)]
    fn value(&self, [sum]: [f32; 1], [x, y, z, ..]: [f32; 9]) -> [f32; 1] {
        [sum + self.axis.dot((self.corner.0 - Vec3::new(x, y, z)) + self.corner.1)]
    }
}

/// One side of a shape for all receivers of a block, after their heights.
struct Side {
    corners: [Corner; 3],
    axis: Vec3,
}

impl Lane<{ SUMS + 1 }, 9, { SUMS + 1 }> for Side {
    #[inline(always)]
    fn value(&self, row: [f32; SUMS + 1], [x, y, z, u, v, w, ..]: [f32; 9]) -> [f32; SUMS + 1] {
        let (from, [height, sums @ ..]) = (Vec3::new(x, y, z), row);
        let plane = Plane::new(Vec3::new(u, v, w), self.axis, height);
        let [first, p, q] = self.corners;
        let at = |corner: Corner| plane.place((corner.0 - from) + corner.1);
        let [sum, area, least] = plane.add(sums, [at(first), at(p), at(q)]);
        [height, sum, area, least]
    }
}

/// [`irradiance`] of a shape on the receivers of a block, position and normal in its first six columns, bit for bit; NaN for those that the
/// horizon or the shape's own plane comes near to.
pub(crate) fn of_block(level: Level, shape: &FlatShape, is_two_sided: bool, at: &Columns<9>) -> [f32; WIDTH] {
    let mut sides = [0_u32; 2];
    let mut sees = [None; WIDTH];
    let reach = shape.bounds();
    for (j, sees) in sees.iter_mut().enumerate() {
        let [x, y, z, ..] = row(at, j);
        let from = Vec3::new(x, y, z);
        let height = shape.height(from);
        let is_front = height > 0.0;
        if !is_front && !is_two_sided {
            *sees = Some(false);
        } else if height.abs() > WELL_BEFORE * (from.distance(reach.center) + reach.radius) {
            *sees = Some(true);
            sides[usize::from(is_front)] += 1;
        }
    }
    let mut out = [f32::NAN; WIDTH];
    let is_front = sides[1] > 0;
    // Corners go around the other way on the other side.
    if is_front && sides[0] > 0 {
        return out;
    }
    let axis = if is_front { -shape.normal() } else { shape.normal() };
    let mut sums = [[0.0; WIDTH]; SUMS + 1];
    let (corners, count) = shape.seen_corners(is_front);
    if sides != [0; 2] {
        sums_of(level, &corners[..count], axis, (is_front, shape.disc().is_some()), at, &mut sums);
    }
    for (j, out) in out.iter_mut().enumerate() {
        let [x, y, z, u, v, w, ..] = row(at, j);
        let [height, sums @ ..] = row(&sums, j);
        match sees[j] {
            Some(false) => *out = 0.0,
            Some(true) if sums[2] >= 0.0 => {
                let plane = Plane::new(Vec3::new(u, v, w), axis, height);
                let first = if shape.disc().is_none() && is_front { corners[count - 1] } else { corners[0] };
                let offset = if shape.disc().is_some() { first.1 * EQUAL } else { first.1 };
                *out = plane.total(sums, plane.place((first.0 - Vec3::new(x, y, z)) + offset));
            }
            _ => {}
        }
    }
    out
}

/// Heights and sums of all sides. Outlines of polygons seen from the front go around the other way.
fn sums_of(
    level: Level,
    corners: &[Corner],
    axis: Vec3,
    (is_front, is_disc): (bool, bool),
    at: &Columns<9>,
    sums: &mut Columns<{ SUMS + 1 }>,
) {
    let mut heights = [[0.0; WIDTH]];
    for corner in corners {
        update(level, &AddHeight { corner: *corner, axis }, &mut heights, at);
    }
    sums[0] = heights[0].map(|sum| sum / corners.len() as f32);
    sums[3] = [f32::INFINITY; WIDTH];
    let corner = |i: usize| {
        let i = i % corners.len();
        let (place, offset) = corners[if is_front && !is_disc { corners.len() - 1 - i } else { i }];
        (place, if is_disc { offset * EQUAL } else { offset })
    };
    for i in 0..corners.len() {
        update(level, &Side { corners: [corner(0), corner(i), corner(i + 1)], axis }, sums, at);
    }
}
