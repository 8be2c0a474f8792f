use crate::gpu::{
    PLANE_OUTSIDE, PLANE_TUBE, PLANES, TUBE_BESIDE, TUBE_DEPTH, TUBE_END, TUBE_FARTHEST, TUBE_OUT, TUBE_STEPS, shape_of,
};
use crate::{Area, AreaShape, Light, LightError, LightKind};
use core::f32::consts::PI;
use glam::{Mat4, Vec2, Vec3};
use lobe_core::{Capsule, Cone, Outline, Receiver, SeenLight, Sphere};
use shading::gpu::GpuText;
use shading::{LightExtent, LightLobes};

/// From a sphere around a tube to one around its outlines.
const AROUND: f32 = 1.531;

/// A tube with round ends (a capsule) that emits the same radiance in all directions from all of its surface.
///
/// Seen from a receiver it is flat: two straight lines, and arcs of the outlines of the spheres at its ends. A blocker inside or
/// behind the tube does not shade it: the outline knows the tube's surface. Strategies without a test of that, as those of GPUs, count blockers up to the
/// outline's plane, which is where the surface is in the mean: along the tube if it is seen from beside it; across the
/// view, at the nearer end, if the tube is seen along its middle line; and between these two, in proportion to how much of the tube's length is
/// seen; it meets the nearer end in its outer half. A receiver within a radius of the middle line, beyond the ends, sees the sphere at the
/// nearer end. One that is nearer to its side than a tenth of
/// the radius sees it as from there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TubeLight {
    /// The middles of the spheres at its ends; not the same.
    pub ends: [Vec3; 2],
    /// Radius.
    pub radius: f32,
    /// Radiance, W·m⁻²·sr⁻¹ per channel.
    pub radiance: Vec3,
}

impl TubeLight {
    /// Area of its surface.
    #[must_use]
    pub fn area(&self) -> f32 {
        2.0 * PI * self.radius * (self.ends[0].distance(self.ends[1]) + 2.0 * self.radius)
    }

    /// The part that it fills, seen from far beside it, of the circle around it.
    #[must_use]
    pub fn roundness(&self) -> f32 {
        let [length, radius] = [self.ends[0].distance(self.ends[1]), self.radius];
        let reach = 0.5 * length + radius;
        radius * (2.0 * length + PI * radius) / (PI * reach * reach).max(f32::MIN_POSITIVE)
    }

    /// The same with the total power `flux` (W per channel): `L = Φ/(πA)`.
    #[must_use]
    pub fn with_flux(self, flux: Vec3) -> Self {
        Self { radiance: flux / (PI * self.area()), ..self }
    }

    /// The sphere at the end next to a receiver.
    fn nearer_end(&self, x: Vec3) -> Sphere {
        let [a, b] = self.ends;
        let center = if a.distance_squared(x) < b.distance_squared(x) { a } else { b };
        Sphere { center, radius: self.radius }
    }

    /// The ends, relative to a receiver: of a tube that is very long for its distance those of the part near the receiver. The rest gives less than a
    /// hundred-millionth, and would take that part's digits.
    fn ends_from(&self, x: Vec3) -> [Vec3; 2] {
        let [a, b] = self.ends.map(|p| p.as_dvec3() - x.as_dvec3());
        let long = b - a;
        let nearest = (-a.dot(long) / long.length_squared()).clamp(0.0, 1.0);
        let reach = f64::from(TUBE_FARTHEST) * (a + long * nearest).length() / long.length();
        if reach >= 1.0 || reach.is_nan() {
            return self.ends.map(|p| p - x);
        }
        [(nearest - reach).max(0.0), (nearest + reach).min(1.0)].map(|t| (a + long * t).as_vec3())
    }

    /// The outline that a receiver sees: two lines along the tube, which touch it, and between these the arcs of the cones around its ends. None beyond
    /// the ends at most a radius off the middle line, where the nearer end covers the rest.
    #[must_use]
    pub fn outline(&self, at: &Receiver) -> Option<Outline> {
        let [a, b] = self.ends_from(at.position);
        let length = a.distance(b);
        let along = (b - a) / length;
        let places = [a.dot(along), b.dot(along)];
        // From the receiver to the foot of its perpendicular on the middle line.
        let foot = a - along * places[0];
        let height = foot.length();
        let is_beside = places[0] <= 0.0 && places[1] >= 0.0;
        if !(height > 0.0 && length > 0.0 && (is_beside || height > self.radius)) {
            return None;
        }
        let toward = foot / height;
        let height = height.max(TUBE_BESIDE * self.radius);
        let side = toward.cross(along);
        let start = TubeEnd::new(self.radius, height, [toward, -along, -side], -places[0]);
        let end = TubeEnd::new(self.radius, height, [toward, along, side], places[1]);
        let part = end.half_turn / (start.half_turn + end.half_turn);
        let steps = ((TUBE_STEPS as f32 * part).round() as usize).clamp(1, TUBE_STEPS - 1);
        let mut corners = [Vec3::ZERO; TUBE_STEPS + 2];
        let (ends, starts) = corners.split_at_mut(steps + 1);
        end.write_arc(ends);
        start.write_arc(starts);
        let (axis, depth) = self.plane(places.map(|place| toward * height + along * place), toward, height);
        corners.iter_mut().for_each(|p| *p *= depth / axis.dot(*p));
        let outline = Outline::new(&corners, axis)?.with_roundness(self.roundness());
        if foot.length() < height {
            // It is seen as from farther away.
            return Some(outline);
        }
        let last = start.farthest(axis).max(end.farthest(axis)) + Capsule::RIM_DEPTH * self.radius;
        Some(outline.with_body(Capsule { ends: [a, b], radius: self.radius }, last.max(depth)))
    }

    /// The plane in which the surface is in the mean, by its normal and its distance. From a receiver: the ends, the direction to the foot of its
    /// perpendicular on the middle line, and that distance.
    fn plane(&self, [a, b]: [Vec3; 2], toward: Vec3, height: f32) -> (Vec3, f32) {
        // Of a strip near the receiver more than of half a cylinder far away.
        let inward = |distance: f32| self.radius * (1.0 - TUBE_DEPTH * (1.0 - self.radius / distance));
        let [near, far] = if a.length_squared() < b.length_squared() { [a, b] } else { [b, a] };
        let body = far - near;
        let away = body / body.length();
        let place = near.dot(away);
        if place <= 0.0 {
            // The foot is on the tube.
            return (toward, height - inward(height));
        }
        let distance = height.hypot(place);
        let view = (toward * height + away * place) / distance;
        let side = (away * height - toward * place) / distance;
        // How long the tube looks beside its nearer end, and how much farther it goes. The end is no part of the slope.
        let (beside, deeper) = (body.dot(side), body.dot(view));
        let whole = beside + TUBE_END * self.radius;
        let slope = deeper * beside / (whole * whole);
        let length = (1.0 + slope * slope).sqrt();
        // Not through the end's middle: a plate before the end is to hide its outer part, too.
        let depth = distance - inward(distance) + TUBE_OUT * self.radius * slope;
        ((view - side * slope) / length, depth / length)
    }
}

/// The sphere at an end as a receiver sees it: a cone, which the two planes along the tube touch.
struct TubeEnd {
    /// The middle of the circle in which the cone touches the sphere.
    middle: Vec3,
    /// From there to the outermost point of that circle, and across the tube.
    axes: [Vec3; 2],
    /// From the outermost point to where the planes touch.
    half_turn: f32,
}

impl TubeEnd {
    /// Of this radius, `place` along the tube's middle line, whose distance is `height`. Directions: toward the foot of the perpendicular on
    /// that line, outward along it, across it.
    fn new(radius: f32, height: f32, [toward, outward, side]: [Vec3; 3], place: f32) -> Self {
        let end = toward * height + outward * place;
        let distance = height.hypot(place);
        let sin = radius / distance;
        let cos = ((1.0 - sin) * (1.0 + sin)).sqrt();
        let circle = radius * cos;
        let outermost = (outward * height - toward * place) / distance;
        // The planes' own angle to the middle line.
        let slope = radius / height;
        let touch = [slope * place / (distance * cos), ((1.0 - slope) * (1.0 + slope)).sqrt() / cos];
        Self {
            middle: end * (cos * cos),
            axes: [outermost * circle, side * circle],
            half_turn: touch[1].atan2(touch[0]),
        }
    }

    /// How far its visible half reaches along a direction.
    fn farthest(&self, axis: Vec3) -> f32 {
        let [out, across] = self.axes.map(|side| side.dot(axis));
        self.middle.dot(axis) + out.hypot(across)
    }

    /// Corners of a polygon with the area of the arc, from one plane to the other.
    fn write_arc(&self, corners: &mut [Vec3]) {
        let last = corners.len() - 1;
        let step = 2.0 * self.half_turn / last as f32;
        let turn = Vec2::from_angle(step);
        // Of a triangle from the middle to what it stands for.
        let grown = step / turn.y.max(f32::MIN_POSITIVE);
        // All corners but the two on the planes are this far out: (n − 2)R² + 2R = n·grown.
        let reach = match last {
            1 => 1.0,
            2 => grown,
            _ => {
                let inner = last as f32 - 2.0;
                ((1.0 + inner * (inner + 2.0) * grown).sqrt() - 1.0) / inner
            }
        };
        let mut toward = Vec2::from_angle(-self.half_turn);
        for (k, corner) in corners.iter_mut().enumerate() {
            let reach = if k == 0 || k == last { 1.0 } else { reach };
            *corner = self.middle + (self.axes[0] * toward.x + self.axes[1] * toward.y) * reach;
            toward = turn.rotate(toward);
        }
    }
}

impl LightLobes for TubeLight {
    fn bounds(&self) -> Sphere {
        let [a, b] = self.ends;
        Sphere { center: 0.5 * (a + b), radius: 0.500_01 * a.distance(b) + self.radius }
    }

    fn bounds_from(&self, _: &Sphere) -> Sphere {
        Sphere { radius: AROUND * self.bounds().radius, ..self.bounds() }
    }

    fn extent(&self) -> Option<LightExtent> {
        // Seen from beside an end the outline reaches beyond it.
        let along = 0.5 * AROUND * (self.ends[1] - self.ends[0]);
        let margin = 4.0 * self.radius + 0.1 * along.length();
        Some(LightExtent { sides: [along, Vec3::ZERO], margin, is_beyond_all: false })
    }

    fn seen_from(&self, at: &Receiver) -> SeenLight {
        match self.outline(at) {
            None => SeenLight::of_cone(Cone::of_sphere(at.position, self.nearer_end(at.position)), self.radiance),
            outline => SeenLight::of_outline(outline, self.bounds().center - at.position, self.radiance),
        }
    }
}

pub(crate) fn to_segment([a, b]: [Vec3; 2], point: Vec3) -> f32 {
    let along = b - a;
    let t = (point - a).dot(along) / along.length_squared().max(f32::MIN_POSITIVE);
    point.distance(a + along * t.clamp(0.0, 1.0))
}

impl LightKind for TubeLight {
    fn name(&self) -> &'static str {
        "tube"
    }

    fn validate(&self) -> Result<(), LightError> {
        let [a, b] = self.ends;
        for center in self.ends {
            LightError::check_sphere(Sphere { center, radius: self.radius })?;
        }
        if a.distance(b) > 1e-4 * self.radius {
            return Ok(());
        }
        Err(LightError::new("a tube has two ends: both are the same"))
    }

    fn full_radiance(&self) -> Vec3 {
        self.radiance
    }

    fn moved(&self, placement: Mat4) -> Light {
        Self { ends: self.ends.map(|p| placement.transform_point3(p)), ..*self }.into()
    }

    fn area(&self, from: Vec3) -> Option<Area<'_>> {
        let [a, b] = self.ends.map(|p| p.as_dvec3() - from.as_dvec3());
        let shape = AreaShape::Capsule { end: a, along: b - a, radius: f64::from(self.radius) };
        Some(Area { bounds: self.bounds(), shape, shown: None })
    }

    fn distance_to(&self, point: Vec3) -> Option<f32> {
        Some((to_segment(self.ends, point) - self.radius).abs())
    }

    fn roundness(&self) -> Option<f32> {
        Some(Self::roundness(self))
    }

    fn gpu_bounds(&self) -> Sphere {
        self.bounds_from(&self.bounds())
    }

    fn wgsl(&self) -> Option<GpuText> {
        Some(PLANES)
    }

    fn gpu_shape(&self) -> Vec<[f32; 4]> {
        shape_of([0.0; 4], [self.radius, 0.0, PLANE_OUTSIDE, PLANE_TUBE], &self.ends)
    }
}
