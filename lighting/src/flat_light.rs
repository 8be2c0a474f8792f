use crate::gpu::{PLANE_DISC, PLANE_OUTSIDE, PLANE_POLYGON, PLANES, shape_of};
use crate::tube_light::to_segment;
use crate::{Area, AreaShape, Light, LightKind, ShownImage};
use core::f32::consts::{PI, TAU};
use glam::{Mat4, Vec3};
use lobe_core::{FlatShape, LightImage, Outline, Receiver, SeenLight, Sphere, Tile, TileLight};
use shading::gpu::GpuText;
use shading::{LightExtent, LightLobes};
use std::sync::Arc;

/// A flat convex shape that emits the same radiance in all directions on one side, or on both.
///
/// Neither seen by the camera nor a blocker. Objects behind its plane do not shade it: a lamp may lie on a ceiling.
///
/// ```
/// use glam::Vec3;
/// use lighting::FlatLight;
/// use lobe_core::Receiver;
/// use shading::LightLobes;
/// let panel = FlatLight::rectangle(Vec3::new(0.0, 3.0, 0.0), Vec3::X, Vec3::Z * 0.5, Vec3::splat(10.0)).unwrap();
/// let at = Receiver::on_surface(Vec3::ZERO, Vec3::Y, Vec3::Y);
/// // X × Z is down.
/// assert_eq!(panel.outline(&at).unwrap().height(), 3.0);
/// assert_eq!(panel.area(), 2.0);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct FlatLight {
    /// Its normal is that of the lit side.
    shape: FlatShape,
    area: f32,
    /// Whether the other side is lit too.
    pub two_sided: bool,
    /// Radiance, W·m⁻²·sr⁻¹ per channel; of a light that shows an image its mean over the rectangle.
    pub radiance: Vec3,
    image: Option<Arc<LightImage>>,
}

/// The fault of a shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FlatLightError {
    /// Not so many corners, or a number that is not finite.
    Corners,
    /// It has no area.
    Degenerate,
    /// Its corners are not in a plane.
    NotFlat,
    /// It is not convex.
    NotConvex,
}

impl core::fmt::Display for FlatLightError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Corners => write!(f, "expected 3 to {} corners with finite coordinates", Outline::MOST),
            Self::Degenerate => f.write_str("the light has no area, or is a million times as long as wide"),
            Self::NotFlat => f.write_str("the corners are not in one plane"),
            Self::NotConvex => f.write_str("the light is not convex"),
        }
    }
}

impl core::error::Error for FlatLightError {}

impl FlatLight {
    /// The rectangle (or parallelogram) `center ± u ± v`, lit on the side of `u × v`.
    ///
    /// # Errors
    /// [`FlatLightError`] where it has no area.
    pub fn rectangle(center: Vec3, u: Vec3, v: Vec3, radiance: Vec3) -> Result<Self, FlatLightError> {
        Self::polygon(&[center - u - v, center + u - v, center + u + v, center - u + v], radiance)
    }

    /// A disc, lit on the side of its normal.
    ///
    /// # Errors
    /// [`FlatLightError`] where it has no area.
    pub fn disc(center: Vec3, normal: Vec3, radius: f32, radiance: Vec3) -> Result<Self, FlatLightError> {
        let normal = normal.normalize_or_zero();
        if radius.is_nan() || radius <= 0.0 || normal == Vec3::ZERO {
            return Err(FlatLightError::Degenerate);
        }
        let (u, v) = normal.any_orthonormal_pair();
        let around = Self::rectangle(center, u * radius, v * radius, radiance)?;
        let shape = around.shape.with_disc(Sphere { center, radius }, normal);
        Ok(Self { shape, area: PI * radius * radius, ..around })
    }

    /// A convex polygon of 3 to 24 corners, lit on the side from which they go counter-clockwise. A corner that repeats the one before it,
    /// but for rounding, does not count.
    ///
    /// # Errors
    /// [`FlatLightError`].
    pub fn polygon(points: &[Vec3], radiance: Vec3) -> Result<Self, FlatLightError> {
        if points.len() < 3 || !points.iter().all(|p| p.is_finite()) {
            return Err(FlatLightError::Corners);
        }
        let points = &distinct(points)[..];
        let count = points.len();
        if count < 3 {
            return Err(FlatLightError::Degenerate);
        }
        if count > Outline::MOST {
            return Err(FlatLightError::Corners);
        }
        let center = points.iter().sum::<Vec3>() / count as f32;
        let radius = points.iter().map(|p| p.distance(center)).fold(0.0, f32::max);
        let first = points[0];
        let twice = points[1..].windows(2).map(|p| (p[0] - first).cross(p[1] - first)).sum::<Vec3>();
        let area = 0.5 * twice.length();
        if area.is_nan() || area <= 1e-6 * radius * radius {
            return Err(FlatLightError::Degenerate);
        }
        let normal = twice.normalize();
        if points.iter().any(|p| normal.dot(*p - center).abs() > 1e-3 * radius) {
            return Err(FlatLightError::NotFlat);
        }
        if !is_convex(points, normal) {
            return Err(FlatLightError::NotConvex);
        }
        let bounds = Sphere { center, radius: radius * 1.000_01 };
        let shape = FlatShape::polygon(points, normal, bounds, area / (PI * radius * radius));
        Ok(Self { shape, area, two_sided: false, radiance, image: None })
    }

    /// The same, lit on both sides.
    #[must_use]
    pub fn on_both_sides(self) -> Self {
        Self { two_sided: true, ..self }
    }

    /// The same with another radiance.
    #[must_use]
    pub fn with_radiance(self, radiance: Vec3) -> Self {
        Self { radiance, ..self }
    }

    /// The same with the total power `flux` (W per channel): `L = Φ/(πA)`, half of it where both sides are lit.
    #[must_use]
    pub fn with_flux(self, flux: Vec3) -> Self {
        let sides = if self.two_sided { 2.0 } else { 1.0 };
        Self { radiance: flux / (PI * self.area * sides), ..self }
    }

    /// The same at another size about its middle, with the same radiance: its lengths times a factor above 0.
    ///
    /// ```
    /// use glam::Vec3;
    /// use lighting::FlatLight;
    /// let panel = FlatLight::rectangle(Vec3::Y, Vec3::X, Vec3::Z, Vec3::ONE)?;
    /// assert_eq!(panel.scaled(0.5), FlatLight::rectangle(Vec3::Y, Vec3::X * 0.5, Vec3::Z * 0.5, Vec3::ONE)?);
    /// # Ok::<(), lighting::FlatLightError>(())
    /// ```
    #[must_use]
    pub fn scaled(self, factor: f32) -> Self {
        Self { area: factor * factor * self.area, shape: self.shape.scaled(factor), ..self }
    }

    /// The same light showing an image, whose mean is its radiance, of a rectangle with right angles. From the lit side, `u` to
    /// the right and `v` upward, the image is as it is; from behind it is mirrored. None for other shapes.
    #[must_use]
    pub fn showing(self, image: Arc<LightImage>) -> Option<Self> {
        let [u, v] = self.sides()?;
        let is_right = u.dot(v).abs() <= 1e-3 * u.length() * v.length();
        (is_right && self.shape.disc().is_none()).then_some(Self { image: Some(image), ..self })
    }

    /// Half sides of a parallelogram.
    fn sides(&self) -> Option<[Vec3; 2]> {
        let [a, b, c, d] = *self.corners() else { return None };
        let (u, v) = (0.5 * (b - a), 0.5 * (d - a));
        ((a + c) - (b + d)).abs().cmple(1e-3 * (u.abs() + v.abs()) + f32::MIN_POSITIVE).all().then_some([u, v])
    }

    /// Its image.
    #[must_use]
    pub fn image(&self) -> Option<&LightImage> {
        self.image.as_deref()
    }

    /// The corners; of a disc those of a square around it.
    #[must_use]
    pub fn corners(&self) -> &[Vec3] {
        self.shape.corners()
    }

    /// The unit normal of the lit side.
    #[must_use]
    pub const fn normal(&self) -> Vec3 {
        self.shape.normal()
    }

    /// Its middle and, where it is a disc, the radius.
    #[must_use]
    pub const fn as_disc(&self) -> (Vec3, Option<f32>) {
        (self.shape.bounds().center, self.shape.disc())
    }

    /// Area of one side.
    #[must_use]
    pub const fn area(&self) -> f32 {
        self.area
    }

    /// The part that it fills of the circle around it.
    #[must_use]
    pub const fn roundness(&self) -> f32 {
        self.shape.roundness()
    }

    /// The outline that a receiver sees, none behind a light of one side.
    #[must_use]
    pub fn outline(&self, at: &Receiver) -> Option<Outline> {
        if !self.shape.is_before(at.position, self.two_sided) {
            return None;
        }
        if self.image.is_none() {
            return self.shape.outline(at.position);
        }
        // Places of an image count from the middle of all of it.
        let outline = self.shape.whole_outline(at.position)?;
        Some(self.sides().map_or(outline, |sides| outline.with_sides(sides)))
    }
}

impl LightLobes for FlatLight {
    fn bounds(&self) -> Sphere {
        self.shape.bounds()
    }

    fn bounds_from(&self, _: &Sphere) -> Sphere {
        Outline::sphere_around(self.shape.bounds())
    }

    fn extent(&self) -> Option<LightExtent> {
        let Sphere { center, radius } = self.shape.bounds();
        let normal = self.normal();
        let along = if self.shape.disc().is_some() { Vec3::ZERO } else { longest_side(self.corners()) };
        let u = along.normalize_or(normal.any_orthonormal_vector());
        let v = normal.cross(u);
        let reach = |n: Vec3| self.corners().iter().map(|p| n.dot(*p - center).abs()).fold(0.0, f32::max);
        let margin = (Outline::BEYOND - 1.0) * radius;
        Some(LightExtent { sides: [u * reach(u), v * reach(v)], margin, is_beyond_all: false })
    }

    fn image(&self) -> Option<&LightImage> {
        self.image.as_deref()
    }

    fn seen_from(&self, at: &Receiver) -> SeenLight {
        SeenLight::of_outline(self.outline(at), self.bounds().center - at.position, self.radiance)
    }

    fn tile_light(&self, at: &[Receiver], tile: &Tile, out: &mut TileLight) {
        if self.image.is_some() {
            return out.one_by_one(tile, at.iter().map(|at| self.seen_from(at)));
        }
        out.flat(tile, &self.shape, self.two_sided, self.radiance);
    }
}

impl LightKind for FlatLight {
    fn name(&self) -> &'static str {
        "flat"
    }

    fn full_radiance(&self) -> Vec3 {
        self.radiance
    }

    fn moved(&self, placement: Mat4) -> Light {
        Self { shape: self.shape.moved(placement), ..self.clone() }.into()
    }

    fn area(&self, from: Vec3) -> Option<Area<'_>> {
        let (center, normal) =
            (self.bounds().center.as_dvec3() - from.as_dvec3(), self.normal().as_dvec3().normalize());
        let height = -normal.dot(center);
        if height == 0.0 || height < 0.0 && !self.two_sided {
            return None;
        }
        let normal = normal * height.signum();
        let shape = match self.shape.disc() {
            Some(radius) => AreaShape::Disc { center, normal, radius: f64::from(radius) },
            None => AreaShape::polygon(self.corners(), normal, from),
        };
        let shown = self.image.as_deref().zip(<&[Vec3; 4]>::try_from(self.corners()).ok()).map(|(image, corners)| {
            let [a, b, c, d] = corners.map(|p| p.as_dvec3() - from.as_dvec3());
            ShownImage { image, middle: 0.25 * (a + b + c + d), sides: [0.5 * (b - a), 0.5 * (d - a)] }
        });
        Some(Area { bounds: self.bounds(), shape, shown })
    }

    fn distance_to(&self, point: Vec3) -> Option<f32> {
        let (corners, normal) = (self.corners(), self.normal());
        if let (center, Some(radius)) = self.as_disc() {
            let height = (point - center).dot(normal);
            let beside = ((point - center - normal * height).length() - radius).max(0.0);
            return Some(height.hypot(beside));
        }
        let edges = || corners.iter().zip(corners.iter().cycle().skip(1)).map(|(a, b)| [*a, *b]);
        let is_above = edges().all(|[a, b]| normal.dot((b - a).cross(point - a)) >= 0.0);
        if is_above {
            return Some((point - corners[0]).dot(normal).abs());
        }
        Some(edges().map(|edge| to_segment(edge, point)).fold(f32::INFINITY, f32::min))
    }

    fn roundness(&self) -> Option<f32> {
        Some(Self::roundness(self))
    }

    fn wgsl(&self) -> Option<GpuText> {
        Some(PLANES)
    }

    fn gpu_shape(&self) -> Vec<[f32; 4]> {
        let side = self.normal().extend(f32::from(u8::from(self.two_sided))).to_array();
        if let Some(radius) = self.shape.disc() {
            return vec![side, [radius, 0.0, PLANE_OUTSIDE, PLANE_DISC]];
        }
        let has_places = f32::from(u8::from(self.image.is_some()));
        shape_of(side, [self.corners().len() as f32, has_places, PLANE_OUTSIDE, PLANE_POLYGON], self.corners())
    }
}

/// The corners without those that repeat the one before: the side between the two might run in any direction.
fn distinct(points: &[Vec3]) -> Vec<Vec3> {
    let (low, high) = points.iter().fold((points[0], points[0]), |(low, high), p| (low.min(*p), high.max(*p)));
    let rounding = f32::EPSILON * low.abs().max(high.abs()).max_element();
    let least = rounding.max(1e-6 * low.distance(high));
    let mut out: Vec<Vec3> = Vec::with_capacity(points.len());
    for p in points {
        if out.last().is_none_or(|last| last.distance(*p) > least) {
            out.push(*p);
        }
    }
    while out.len() > 1 && out[0].distance(out[out.len() - 1]) <= least {
        out.pop();
    }
    out
}

/// From one corner to the next, where that is farthest.
fn longest_side(corners: &[Vec3]) -> Vec3 {
    let sides = corners.iter().zip(corners.iter().cycle().skip(1)).map(|(p, q)| *q - *p);
    sides.fold(Vec3::ZERO, |long, side| if side.length_squared() > long.length_squared() { side } else { long })
}

/// Whether a polygon in a plane of this normal is convex: every corner turns the same way, and all together once.
pub(crate) fn is_convex(points: &[Vec3], normal: Vec3) -> bool {
    let count = points.len();
    let center = points.iter().sum::<Vec3>() / count as f32;
    let spokes = |i: usize| [points[i] - center, points[(i + 1) % count] - center];
    let area = 0.5 * (0..count).map(spokes).map(|[p, q]| normal.dot(p.cross(q))).sum::<f32>().abs();
    let turns = |i: usize| {
        let [p, q, r] = [0, 1, 2].map(|k| points[(i + k) % count]);
        normal.dot((q - p).cross(r - q)) >= -1e-5 * area
    };
    // A star turns the same way everywhere, too.
    let around = (0..count).map(spokes).map(|[p, q]| p.angle_between(q)).sum::<f32>();
    count >= 3 && (0..count).all(turns) && around < 1.5 * TAU
}
