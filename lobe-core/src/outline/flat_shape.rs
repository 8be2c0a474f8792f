use super::Outline;
use super::near_part::{FAR, Place, near_part};
use crate::{SeenLight, Sphere};
use glam::{Mat4, Vec3};

/// How far rounding takes places off a plane, at most, as a part of their coordinates.
const IN_PLANE: f32 = 4.0 * f32::EPSILON;

/// A convex polygon or a disc in the world, which receivers see as an [`Outline`].
#[derive(Clone, Debug, PartialEq)]
pub struct FlatShape {
    corners: [Vec3; Outline::MOST],
    count: usize,
    normal: Vec3,
    disc: Option<f32>,
    bounds: Sphere,
    roundness: f32,
}

impl FlatShape {
    /// A polygon of 3 to [`Outline::MOST`] corners in one plane, counter-clockwise seen from the side of the unit normal; the mean of its corners
    /// is the middle of `bounds`.
    ///
    /// # Panics
    /// For other numbers of corners.
    #[must_use]
    pub fn polygon(points: &[Vec3], normal: Vec3, bounds: Sphere, roundness: f32) -> Self {
        let count = points.len();
        assert!((3..=Outline::MOST).contains(&count), "{count} corners");
        let mut corners = [points[0]; Outline::MOST];
        corners[..count].copy_from_slice(points);
        Self { corners, count, normal, disc: None, bounds, roundness }
    }

    /// The disc inside of a square: in the same plane, about a middle.
    #[must_use]
    pub fn with_disc(self, disc: Sphere, normal: Vec3) -> Self {
        Self { disc: Some(disc.radius), bounds: disc, roundness: 1.0, normal, ..self }
    }

    /// The corners; of a disc those of a square around it.
    #[must_use]
    pub fn corners(&self) -> &[Vec3] {
        &self.corners[..self.count]
    }

    /// The unit normal.
    #[must_use]
    pub const fn normal(&self) -> Vec3 {
        self.normal
    }

    /// A sphere around it.
    #[must_use]
    pub const fn bounds(&self) -> Sphere {
        self.bounds
    }

    /// Of a disc its radius.
    #[must_use]
    pub const fn disc(&self) -> Option<f32> {
        self.disc
    }

    /// The part that it fills of the circle around it.
    #[must_use]
    pub const fn roundness(&self) -> f32 {
        self.roundness
    }

    /// The same at another size about its middle.
    #[must_use]
    pub fn scaled(self, factor: f32) -> Self {
        let center = self.bounds.center;
        Self {
            corners: self.corners.map(|p| center + factor * (p - center)),
            disc: self.disc.map(|radius| factor * radius),
            bounds: Sphere { radius: factor * self.bounds.radius, ..self.bounds },
            ..self
        }
    }

    /// The same moved by a matrix without scale.
    #[must_use]
    pub fn moved(&self, placement: Mat4) -> Self {
        let center = placement.transform_point3(self.bounds.center);
        let normal = placement.transform_vector3(self.normal).normalize_or(self.normal);
        let corners = self.corners.map(|p| placement.transform_point3(p));
        Self { corners, normal, bounds: Sphere { center, ..self.bounds }, ..*self }
    }

    /// How far a receiver is before its plane; negative behind it.
    #[must_use]
    pub fn height(&self, from: Vec3) -> f32 {
        self.normal.dot(from - self.bounds.center)
    }

    /// The outline that a receiver sees, from either side; none in its plane. Of a shape that is more than 1000 times as large as far the
    /// part near the receiver.
    #[must_use]
    pub fn outline(&self, from: Vec3) -> Option<Outline> {
        let height = self.height(from);
        if height.abs() * FAR >= self.bounds.radius {
            return self.whole_outline(from);
        }
        let axis = if height > 0.0 { -self.normal } else { self.normal };
        let near = self.near_part(from, axis).map(|near| near.with_roundness(self.roundness));
        near.or_else(|| self.whole_outline(from))
    }

    /// The same of all of it; none of a shape that is more than 100 000 times as large as far.
    #[must_use]
    pub fn whole_outline(&self, from: Vec3) -> Option<Outline> {
        let axis = if self.height(from) > 0.0 { -self.normal } else { self.normal };
        let mut outline = match self.disc {
            Some(radius) => Outline::disc(self.bounds.center - from, radius, axis),
            None => {
                let mut corners = [Vec3::ZERO; Outline::MOST];
                corners.iter_mut().zip(self.corners()).for_each(|(to, p)| *to = *p - from);
                Outline::new(&corners[..self.count], axis)
            }
        };
        if let Some(outline) = &mut outline {
            outline.roundness = Some(self.roundness);
        }
        outline
    }

    /// The light that a receiver sees of it.
    #[must_use]
    pub fn seen_from(&self, from: Vec3, is_two_sided: bool, radiance: Vec3) -> SeenLight {
        SeenLight::of_outline(self.bright(from, is_two_sided), self.bounds.center - from, radiance)
    }

    /// Whether a receiver is before a light on one side, or beside one on both: not in its plane but for the rounding of places, where the light's
    /// own surface would see all of it.
    #[must_use]
    pub fn is_before(&self, from: Vec3, is_two_sided: bool) -> bool {
        let height = self.height(from);
        let rounding = || IN_PLANE * self.normal.abs().dot(from.abs() + self.bounds.center.abs());
        if is_two_sided { height.abs() > rounding() } else { height > 0.0 }
    }

    /// The outline that a receiver sees of a light on one side, or on both.
    fn bright(&self, from: Vec3, is_two_sided: bool) -> Option<Outline> {
        if self.is_before(from, is_two_sided) { self.outline(from) } else { None }
    }

    /// The part of it above a receiver's horizon.
    pub(crate) fn bright_above(&self, from: Vec3, normal: Vec3, is_two_sided: bool) -> Option<Outline> {
        let mut bright = self.bright(from, is_two_sided);
        Outline::keep_above(&mut bright, normal);
        bright
    }

    /// The corners that make its outline: places in the world, and what is added to them as a receiver before the front or behind it sees them.
    pub(super) fn seen_corners(&self, is_front: bool) -> ([(Vec3, Vec3); Outline::MOST], usize) {
        if let Some(radius) = self.disc {
            let axis = if is_front { -self.normal } else { self.normal };
            return (Outline::around_disc(radius, axis).map(|offset| (self.bounds.center, offset)), Outline::MOST);
        }
        (self.corners.map(|p| (p, Vec3::ZERO)), self.count)
    }

    /// Of a shape that is far larger than its distance the part near a receiver; none where it is elsewhere.
    #[cold]
    fn near_part(&self, from: Vec3, axis: Vec3) -> Option<Outline> {
        match self.disc {
            Some(radius) => near_part(&Place::Disc(self.bounds.center, f64::from(radius)), from, axis),
            None => near_part(&Place::Polygon(self.corners()), from, axis),
        }
    }
}
