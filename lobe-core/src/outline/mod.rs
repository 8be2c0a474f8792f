//! Flat lights: what a receiver sees of a convex polygon.

mod capsule;
mod cells;
mod cubature;
mod flat_shape;
mod grid;
mod image;
mod integral;
mod lambert;
mod near_part;
mod of_tile;
mod on_plane;
mod parts;
mod rules;
mod sides;
#[cfg(test)]
mod tests;
pub(crate) mod wgsl;

pub use self::capsule::{Capsule, distance_of_segments};
pub use self::flat_shape::FlatShape;
pub use self::image::{LightImage, fingerprint};
pub(crate) use self::integral::integral;
pub use self::integral::{image_integral, light_image_integral, light_integral, outline_integral};
pub(crate) use self::of_tile::of_flat;

use crate::lanes::Lane;
use crate::{Cone, Lobe, Sphere, orthonormal_basis};
use glam::{Vec2, Vec3};

/// The light of a convex polygon, or of a disc, as a receiver sees it: uniformly bright inside, dark outside.
///
/// Corners are relative to the receiver and lie in one plane, before which the receiver is. Seen through the plane at distance 1 along
/// [`axis`](Self::axis) the polygon keeps its shape: a rectangle stays one. Masks are drawn there, and surfaces behind the plane do
/// not block.
///
/// ```
/// use glam::Vec3;
/// use lobe_core::Outline;
/// let corners = [[-1.0, -1.0, 2.0], [1.0, -1.0, 2.0], [1.0, 1.0, 2.0], [-1.0, 1.0, 2.0]].map(Vec3::from_array);
/// let light = Outline::new(&corners, Vec3::Z).unwrap();
/// assert_eq!((light.axis(), light.height()), (Vec3::Z, 2.0));
/// assert!(light.cone().one_minus_cos < 0.4);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outline {
    corners: [Vec3; Self::ROOM],
    count: usize,
    /// The middle of the whole light, whatever a horizon leaves of it.
    center: Vec3,
    axis: Vec3,
    height: f32,
    /// Radius about the middle, where it is a disc; the corners are then those of a polygon around it.
    radius: Option<f32>,
    /// The two vectors that measure places on the light: a step along a half side times its own is one, times the other's zero.
    sides: [Vec3; 2],
    /// Whether a horizon has cut something off it.
    is_clipped: bool,
    /// See [`with_roundness`](Self::with_roundness).
    roundness: Option<f32>,
    /// See [`with_body`](Self::with_body), and how far along the axis its last visible part is.
    body: Option<(Capsule, f32)>,
}

/// From a circle to the corners of the polygon around it.
const AROUND: f32 = 1.008_629;

/// Surfaces block up to this part of the way to the light's plane.
const DEPTH: f32 = 0.999_9;

/// Cones of outlines that are wider than this are the whole hemisphere before the light's plane.
const WIDEST: f32 = 0.9;

/// Cosine and sine of the multiples of 15°.
const TURNS: [[f32; 2]; Outline::MOST] = [
    [1.0, 0.0],
    [0.965_925_8, 0.258_819_04],
    [0.866_025_4, 0.5],
    [0.707_106_77, 0.707_106_77],
    [0.5, 0.866_025_4],
    [0.258_819_04, 0.965_925_8],
    [0.0, 1.0],
    [-0.258_819_04, 0.965_925_8],
    [-0.5, 0.866_025_4],
    [-0.707_106_77, 0.707_106_77],
    [-0.866_025_4, 0.5],
    [-0.965_925_8, 0.258_819_04],
    [-1.0, 0.0],
    [-0.965_925_8, -0.258_819_04],
    [-0.866_025_4, -0.5],
    [-0.707_106_77, -0.707_106_77],
    [-0.5, -0.866_025_4],
    [-0.258_819_04, -0.965_925_8],
    [0.0, -1.0],
    [0.258_819_04, -0.965_925_8],
    [0.5, -0.866_025_4],
    [0.707_106_77, -0.707_106_77],
    [0.866_025_4, -0.5],
    [0.965_925_8, -0.258_819_04],
];

impl Outline {
    /// The most corners of a light.
    pub const MOST: usize = 24;
    /// Blockers count as far beside a light as this, in radii of a sphere around it: nearer ones turn its masks.
    pub const BEYOND: f32 = 1.1;
    /// Each of two horizons adds one, the receiver's and a lobe's.
    const ROOM: usize = Self::MOST + 2;

    /// A polygon of 3 to [`MOST`](Self::MOST) corners relative to the receiver, in any order around it; `axis` is the unit normal of its plane
    /// on the side away from the receiver. None where the receiver is in the plane or behind it.
    #[must_use]
    pub fn new(corners: &[Vec3], axis: Vec3) -> Option<Self> {
        let count = corners.len();
        if !(3..=Self::MOST).contains(&count) {
            return None;
        }
        let (mut heights, mut size, mut area) = (0.0, 0.0_f32, 0.0);
        sides::each(&Extent { axis, first: corners[0] }, corners, |[height, reach, twice_area]| {
            heights += height;
            size = size.max(reach);
            area += twice_area;
        });
        let height = heights / count as f32;
        // Seen at a flatter angle it is a line, and its plane coordinates leave f32.
        if !(height > 1e-5 * size && size.is_finite()) {
            return None;
        }
        let center = corners.iter().sum::<Vec3>() / count as f32;
        let mut own = [Vec3::ZERO; Self::ROOM];
        own[..count].copy_from_slice(corners);
        if area < 0.0 {
            own[..count].reverse();
        }
        Some(Self {
            corners: own,
            count,
            center,
            axis,
            height,
            radius: None,
            sides: [Vec3::ZERO; 2],
            is_clipped: false,
            roundness: None,
            body: None,
        })
    }

    /// A disc relative to the receiver; as [`new`](Self::new).
    #[must_use]
    pub fn disc(center: Vec3, radius: f32, axis: Vec3) -> Option<Self> {
        let mut corners = Self::around_disc(radius, axis);
        corners.iter_mut().for_each(|p| *p += center);
        let mut disc = Self::new(&corners, axis);
        if let Some(disc) = &mut disc {
            disc.center = center;
            disc.radius = Some(radius);
        }
        disc
    }

    /// From a disc's middle to the corners of the polygon around it.
    fn around_disc(radius: f32, axis: Vec3) -> [Vec3; Self::MOST] {
        let (u, v) = orthonormal_basis(axis);
        let reach = radius * AROUND;
        let mut corners = [Vec3::ZERO; Self::MOST];
        for (corner, [cos, sin]) in corners.iter_mut().zip(TURNS) {
            *corner = (u * cos + v * sin) * reach;
        }
        corners
    }

    /// The same light with places on it: from its middle along two half sides at right angles, for a [`LightImage`]. Windows on it are
    /// turned as these are.
    #[must_use]
    pub fn with_sides(self, [u, v]: [Vec3; 2]) -> Self {
        let side = |u: Vec3, v: Vec3| {
            let across = v.cross(self.axis);
            across / u.dot(across)
        };
        Self { sides: [side(u, v), side(v, u)], ..self }
    }

    /// The direction of places' first half side.
    #[must_use]
    pub fn side(&self) -> Vec3 {
        self.sides[1].cross(self.axis)
    }

    /// Where points of the plane at distance 1, in a [frame](Self::frame), are on the light.
    #[must_use]
    pub fn places(&self, [right, up]: [Vec3; 2]) -> Places {
        let place = |v: Vec3| Vec2::new(self.sides[0].dot(v), self.sides[1].dot(v));
        let [x, y, axis] = [right, up, self.axis].map(|v| place(v) * self.height);
        Places { origin: axis - place(self.center), x, y }
    }

    /// Middle and radius on the plane at distance 1, in a [frame](Self::frame), of a disc.
    #[must_use]
    pub fn circle(&self, [right, up]: [Vec3; 2]) -> Option<(Vec2, f32)> {
        let radius = self.radius?;
        Some((Vec2::new(right.dot(self.center), up.dot(self.center)) / self.height, radius / self.height))
    }

    /// Twice the area, positive where the corners go counter-clockwise seen from the receiver (in a frame whose third direction is the
    /// axis).
    fn twice_area(&self) -> f32 {
        let first = self.corners[0];
        let fan = |pair: &[Vec3]| self.axis.dot((pair[0] - first).cross(pair[1] - first));
        self.corners[1..self.count].windows(2).map(fan).sum()
    }

    /// The corners, counter-clockwise in a frame whose third direction is the [axis](Self::axis).
    #[must_use]
    pub fn corners(&self) -> &[Vec3] {
        &self.corners[..self.count]
    }

    /// A point inside: the mean of the corners.
    #[must_use]
    pub fn middle(&self) -> Vec3 {
        self.corners().iter().sum::<Vec3>() / self.count as f32
    }

    /// The unit normal of its plane, away from the receiver.
    #[must_use]
    pub const fn axis(&self) -> Vec3 {
        self.axis
    }

    /// How far its plane is from the receiver.
    #[must_use]
    pub const fn height(&self) -> f32 {
        self.height
    }

    /// Leaves of a light what is above the plane through the receiver with this normal. One that is cut already ends at the horizon, but for
    /// rounding. Returns whether anything has changed.
    pub(crate) fn keep_above(light: &mut Option<Self>, normal: Vec3) -> bool {
        let is_above = |light: &Self| light.is_clipped || light.corners().iter().all(|p| normal.dot(*p) >= 0.0);
        let Some(whole) = light.as_ref().filter(|light| !is_above(light)) else { return false };
        *light = whole.above(normal);
        true
    }

    /// The part of it above the plane through the receiver with this normal; none where there is none. Of a disc only the corners are cut.
    #[must_use]
    pub fn above(&self, normal: Vec3) -> Option<Self> {
        let corners = self.corners();
        let mut heights = [0.0; Self::ROOM];
        heights.iter_mut().zip(corners).for_each(|(height, p)| *height = normal.dot(*p));
        let heights = &heights[..self.count];
        if heights.iter().all(|h| *h >= 0.0) {
            return Some(*self);
        }
        let mut out = Self { count: 0, is_clipped: true, ..*self };
        for (i, (p, h)) in corners.iter().zip(heights).enumerate() {
            let next = (i + 1) % self.count;
            let (q, g) = (corners[next], heights[next]);
            if *h >= 0.0 {
                out.push(*p);
            }
            if (*h >= 0.0) != (g >= 0.0) {
                out.push(*p + (q - *p) * (h / (h - g)));
            }
        }
        if out.count > 0 && out.is_last(out.corners[0]) {
            out.count -= 1;
        }
        (out.count >= 3).then_some(out)
    }

    /// Whether a point is the last corner, but for rounding: the line through the two would go anywhere.
    fn is_last(&self, p: Vec3) -> bool {
        self.count > 0 && self.corners[self.count - 1].distance_squared(p) <= 1e-11 * p.length_squared()
    }

    /// Whether a horizon has cut something off it.
    #[must_use]
    pub const fn is_clipped(&self) -> bool {
        self.is_clipped
    }

    fn push(&mut self, p: Vec3) {
        // A convex polygon is cut in two places: more are of rounding.
        if self.count < Self::ROOM && !self.is_last(p) {
            self.corners[self.count] = p;
            self.count += 1;
        }
    }

    /// A frame whose third direction is the [axis](Self::axis), the first as near to `across` as that allows; any where `across` is along
    /// the axis.
    #[must_use]
    pub fn frame(&self, across: Vec3) -> [Vec3; 2] {
        let aside = across - self.axis * across.dot(self.axis);
        let (square, all) = (aside.length_squared(), across.length_squared());
        let right = if square > 1e-10 * all && (1e-30..f32::INFINITY).contains(&square) {
            let right = aside / square.sqrt();
            // Of a long vector's small rest the rounding is not at right angles to the axis.
            (right - self.axis * right.dot(self.axis)).normalize()
        } else {
            orthonormal_basis(self.axis).0
        };
        [right, self.axis.cross(right)]
    }

    /// The same, of a light that is known to fill this part of the circle around it, whatever of it is seen.
    #[must_use]
    pub fn with_roundness(self, roundness: f32) -> Self {
        Self { roundness: Some(roundness), ..self }
    }

    /// The same as the outline of a body, of which no visible part is farther along the axis than `end`. Surfaces before the body then block, and no others: not
    /// all that are before the outline's plane. Strategies without such a test keep to the plane.
    #[must_use]
    pub fn with_body(self, body: Capsule, end: f32) -> Self {
        Self { body: Some((body, end)), ..self }
    }

    /// The body of which it is the outline, if it is one of a body.
    #[must_use]
    pub fn body(&self) -> Option<&Capsule> {
        self.body.as_ref().map(|(body, _)| body)
    }

    /// The part that it fills of the circle around it: little for a tube.
    #[must_use]
    pub fn roundness(&self) -> f32 {
        if let Some(roundness) = self.roundness {
            return roundness;
        }
        let middle = self.middle();
        let square = self.corners().iter().map(|p| p.distance_squared(middle)).fold(0.0, f32::max);
        (0.5 * self.twice_area() / (core::f32::consts::PI * square.max(f32::MIN_POSITIVE))).clamp(0.0, 1.0)
    }

    /// The corners on the plane at distance 1 along the axis, in a [frame](Self::frame).
    pub fn on_plane(&self, [right, up]: [Vec3; 2]) -> impl Iterator<Item = Vec2> + Clone {
        let scale = 1.0 / self.height;
        self.corners().iter().map(move |p| Vec2::new(right.dot(*p), up.dot(*p)) * scale)
    }

    /// The point of it next to a place of that plane, in a [frame](Self::frame); of a disc that of the polygon around it.
    #[must_use]
    pub fn nearest(&self, frame: [Vec3; 2], place: Vec2) -> Vec2 {
        on_plane::OnPlane::new(self, frame).nearest(place)
    }

    /// A sphere around all of it, its [body](Self::with_body) included, and as far beside it as blockers count, relative to the receiver.
    #[must_use]
    pub fn sphere(&self) -> Sphere {
        let flat = self.corners().iter().map(|p| p.distance_squared(self.center)).fold(0.0, f32::max).sqrt();
        let of_body = self.body().map_or(0.0, |body| body.reach_from(self.center));
        Self::sphere_around(Sphere { center: self.center, radius: flat.max(of_body) })
    }

    /// Whether windows on it are turned as its [sides](Self::with_sides) are, and so never reach beyond it.
    #[must_use]
    pub fn has_sides(&self) -> bool {
        self.sides[0] != Vec3::ZERO
    }

    /// The same from a sphere around the light.
    #[must_use]
    pub fn sphere_around(bounds: Sphere) -> Sphere {
        Sphere { radius: bounds.radius * Self::BEYOND, ..bounds }
    }

    /// A cone around all of it. Along the cone's axis nothing of it is farther than `distance·cos²θ`, where surfaces end to block a cone; wider
    /// cones are the hemisphere before the plane, with no such end.
    #[must_use]
    pub fn cone(&self) -> Cone {
        let toward = self.center.normalize();
        let (mut fall, mut depth) = (0.0_f32, 0.0_f32);
        sides::each(&Toward { toward }, self.corners(), |[of_corner, along]| {
            fall = fall.max(of_corner);
            depth = depth.max(along);
        });
        if fall > WIDEST {
            return Cone { axis: self.axis, one_minus_cos: 1.0, distance: f32::INFINITY };
        }
        let cos = 1.0 - fall;
        Cone { axis: toward, one_minus_cos: fall, distance: depth / (cos * cos) }
    }

    /// Solid angle, and the mean direction times that: `∫ v dv` over the outline, by the triangles of a fan (A. Van Oosterom, J. Strackee,
    /// *The Solid Angle of a Plane Triangle*, 1983) and by Lambert's formula.
    #[must_use]
    pub fn moments(&self) -> (f32, Vec3) {
        let (corners, first) = (self.corners(), self.corners[0]);
        let mut solid = 0.0;
        for pair in corners[1..].windows(2) {
            let [a, b, c] = [first, pair[0], pair[1]].map(|p| p.as_dvec3());
            let [x, y, z] = [a, b, c].map(|p| p.length());
            let below = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
            solid += 2.0 * a.dot((b - a).cross(c - a)).atan2(below);
        }
        let mut mean = glam::DVec3::ZERO;
        for (i, a) in corners.iter().enumerate() {
            let (a, b) = (a.as_dvec3(), corners[(i + 1) % self.count].as_dvec3());
            let cross = a.cross(b - a);
            let size = cross.length();
            if size > 0.0 {
                mean += cross * (0.5 * size.atan2(a.dot(b)) / size);
            }
        }
        // Of the polygon around a disc.
        let sides = core::f64::consts::PI / Self::MOST as f64;
        let part = if self.radius.is_some() { sides / sides.tan() } else { 1.0 };
        ((solid * part) as f32, (mean * part).as_vec3())
    }

    /// The cosine lobe with the flux and the mean vector of light of this radiance.
    #[must_use]
    pub fn lobe(&self, radiance: Vec3) -> Lobe {
        let (solid, mean) = self.moments();
        let length = mean.length().min(solid * 0.999_999_9);
        let exponent = crate::exponent_of_spread(1.0 - length / solid.max(f32::MIN_POSITIVE));
        Lobe::with_flux(mean.normalize_or(self.axis), exponent, radiance * solid)
    }

    /// How far from the receiver, along the axis, surfaces block: almost to the light's plane. A surface in that plane, which makes the
    /// light visible, does not hide it.
    #[must_use]
    pub fn depth(&self) -> f32 {
        DEPTH * self.height
    }

    /// How far from the receiver, along the axis, any surface may block: the [depth](Self::depth), or, where its [body](Self::with_body) counts, as far as
    /// the last visible part of that is.
    #[must_use]
    #[inline]
    pub fn depth_to(&self, body_counts: bool) -> f32 {
        self.body.filter(|_| body_counts).map_or_else(|| self.depth(), |(_, end)| end)
    }

    /// How far a ray along a direction inside the outline goes before surfaces do not block it any more: to the [body](Self::with_body), or else to
    /// the plane.
    #[must_use]
    #[inline]
    pub fn distance(&self, direction: Vec3) -> f32 {
        self.distance_to(true, direction)
    }

    /// The same, to the plane where the body does not count.
    #[must_use]
    pub fn distance_to(&self, body_counts: bool, direction: Vec3) -> f32 {
        if let Some(entry) = self.body().filter(|_| body_counts).and_then(|body| body.entry(direction)) {
            return entry;
        }
        let along = self.axis.dot(direction);
        if along > 0.0 { self.depth_to(body_counts) / along } else { f32::INFINITY }
    }
}

/// How far a corner is along the axis, and at most in a coordinate; twice the area of the triangle from the first corner to a side.
struct Extent {
    axis: Vec3,
    first: Vec3,
}

impl Lane<3, 3, 3> for Extent {
    #[inline(always)]
    fn value(&self, p: [f32; 3], q: [f32; 3]) -> [f32; 3] {
        let (p, q) = (Vec3::from_array(p), Vec3::from_array(q));
        let larger = |a: f32, b: f32| if a > b { a } else { b };
        let reach = larger(larger(p.x.abs(), p.y.abs()), p.z.abs());
        [self.axis.dot(p), reach, self.axis.dot((p - self.first).cross(q - self.first))]
    }
}

/// One minus the cosine between a corner and a direction, and how far the corner is along that.
struct Toward {
    toward: Vec3,
}

impl Lane<3, 3, 2> for Toward {
    #[inline(always)]
    fn value(&self, corner: [f32; 3], _: [f32; 3]) -> [f32; 2] {
        let p = Vec3::from_array(corner);
        let direction = p * (1.0 / p.length());
        [0.5 * (direction - self.toward).length_squared(), p.dot(self.toward)]
    }
}

/// Places on a light ([`Outline::places`]).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Places {
    origin: Vec2,
    x: Vec2,
    y: Vec2,
}

impl Places {
    /// That of the point `(x, y)` of the plane at distance 1.
    #[must_use]
    #[inline]
    pub fn at(&self, x: f32, y: f32) -> Vec2 {
        self.origin + self.x * x + self.y * y
    }

    /// How large an area of that plane is in places.
    #[must_use]
    #[inline]
    pub fn area(&self, area: f32) -> f32 {
        (self.x.perp_dot(self.y) * area).abs()
    }
}
