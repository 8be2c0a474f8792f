//! The casters that a map needs, and the faces that show them.

use crate::clip::Polygon;
use crate::face::{Face, Frame};
use crate::options::ReceiverBounds;
use glam::DVec3;

/// A triangle relative to the light's centre.
pub(crate) type Triangle = [DVec3; 3];

/// A wider image than this half-angle (60°), here its cosine, becomes a cube.
const WIDEST_COS: f64 = 0.5;
/// Texels around the needed window, for the averages at its rim and, on a cube, for an overlap at the seams.
const BORDER: f64 = 2.0;
/// Texel sizes are powers of this factor, and a window begins at a whole texel. After a small motion the next frame then has the
/// same grid; otherwise the edges of all texels would jump between frames.
const STEP: f64 = 1.189_207_115_002_721;
/// Axes of faces that are not a cube's are rounded to steps of this tangent, for the same reason.
const TURN: f64 = 1.0 / 32.0;
/// Rounding of receivers' coordinates, relative to the scene.
const ROUNDING: f64 = 2e-6;

/// The inputs that faces are fitted to.
pub(crate) struct Fit<'a> {
    pub(crate) radius: f64,
    pub(crate) resolution: u32,
    pub(crate) receivers: Option<&'a [DVec3; 8]>,
    /// Largest distance of a caster's corner.
    pub(crate) far: f64,
}

/// The window of a face in its plane at distance 1, and the depths in it.
#[derive(Clone, Copy, Debug)]
struct Window {
    low: [f64; 2],
    high: [f64; 2],
    near: f64,
    far: f64,
}

impl Fit<'_> {
    /// The smallest depth that is drawn: nearer points are inside the light, whose surface is nearest to the plane in a cube's
    /// corner.
    pub(crate) fn near(&self) -> f64 {
        (0.577 * self.radius).max(1e-6 * self.far)
    }

    /// Whether a triangle can be between a receiver and the light.
    pub(crate) fn needs(&self, triangle: &Triangle, magnitude: f64) -> bool {
        let [a, b, c] = *triangle;
        let normal = (b - a).cross(c - a);
        let length = normal.length();
        if length <= 0.0 || triangle.iter().all(|p| p.length() <= self.radius) {
            return false;
        }
        let Some(receivers) = self.receivers else { return true };
        // Skips a triangle if all receivers and the light are on one side of its plane.
        let n = normal / length;
        let slack = ROUNDING * magnitude;
        let light = -n.dot(a);
        let (low, high) = extremes(receivers.iter().map(|p| n.dot(*p - a)));
        if (low >= -slack && light >= self.radius - slack) || (high <= slack && -light >= self.radius - slack) {
            return false;
        }
        // Skips a triangle outside the capsule around receivers and light.
        let center = receivers.iter().sum::<DVec3>() / 8.0;
        let wide = receivers.iter().map(|p| p.distance(center)).fold(self.radius, f64::max);
        let middle = (a + b + c) / 3.0;
        let size = triangle.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
        let t = (middle.dot(center) / center.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        middle.distance(center * t) <= wide + size + slack
    }

    /// One perspective face if the casters fit into it; else the faces of a cube that show any caster.
    pub(crate) fn faces(&self, triangles: &[Triangle]) -> Vec<Face> {
        let around_casters = cone(triangles).filter(|(_, cos)| *cos >= WIDEST_COS).map(|(axis, _)| axis);
        let toward_receivers = self.receivers.and_then(|r| r.iter().sum::<DVec3>().try_normalize());
        // Tries the direction to the receivers only if no needed caster is beside the light.
        let toward_receivers = toward_receivers
            .filter(|axis| triangles.iter().flatten().all(|p| axis.dot(*p) >= self.near().max(self.radius)));
        let best = [around_casters, toward_receivers]
            .into_iter()
            .flatten()
            .filter_map(|axis| {
                let frame = Frame::toward(rounded(axis));
                self.window(&frame, triangles, false).map(|window| (frame, window))
            })
            .filter(|(_, w)| w.low.iter().chain(&w.high).all(|x| x.abs() <= 2.5))
            .min_by(|a, b| a.1.extent().total_cmp(&b.1.extent()));
        if let Some((frame, window)) = best {
            // One texel less, since the window begins at a whole texel.
            let texel = window.extent().max(1e-12) / (f64::from(self.resolution) - 2.0 * BORDER - 1.0);
            return vec![window.face(frame, STEP.powf((texel.ln() / STEP.ln()).ceil()))];
        }
        let texel = 2.0 / f64::from(self.resolution);
        Frame::cube()
            .into_iter()
            .filter_map(|frame| self.window(&frame, triangles, true).map(|window| window.face(frame, texel)))
            .collect()
    }

    /// The window that the casters need on a face; `None` if they need none. A face of a cube shows only its own part.
    fn window(&self, frame: &Frame, triangles: &[Triangle], cube: bool) -> Option<Window> {
        let shafts = self.receivers.map(|receivers| Edges::new(receivers.map(|p| frame.local(p)), self.radius));
        let mut all: Option<Window> = None;
        for triangle in triangles {
            let near = self.near();
            let mut polygon = Polygon::new(&triangle.map(|p| frame.local(p))).clip(|p: DVec3| p.z - near);
            if cube {
                for side in [DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y] {
                    polygon = polygon.clip(|p| p.z - side.dot(p));
                }
            }
            let corners = polygon.corners();
            if corners.is_empty() {
                continue;
            }
            let (near, far) = extremes(corners.iter().map(|p| p.z));
            let (mut x, mut y) =
                (extremes(corners.iter().map(|p| p.x / p.z)), extremes(corners.iter().map(|p| p.y / p.z)));
            if let Some(shafts) = &shafts {
                let (sx, sy) = (shafts.range(0, near), shafts.range(1, near));
                x = (x.0.max(sx.0), x.1.min(sx.1));
                y = (y.0.max(sy.0), y.1.min(sy.1));
                if x.0 > x.1 || y.0 > y.1 {
                    continue;
                }
            }
            let here = Window { low: [x.0, y.0], high: [x.1, y.1], near, far };
            all = Some(all.map_or(here, |w| w.union(&here)));
        }
        all
    }
}

impl Window {
    fn union(&self, o: &Self) -> Self {
        Self {
            low: [self.low[0].min(o.low[0]), self.low[1].min(o.low[1])],
            high: [self.high[0].max(o.high[0]), self.high[1].max(o.high[1])],
            near: self.near.min(o.near),
            far: self.far.max(o.far),
        }
    }

    fn extent(&self) -> f64 {
        (self.high[0] - self.low[0]).max(self.high[1] - self.low[1])
    }

    fn face(&self, frame: Frame, texel: f64) -> Face {
        let start = |k: usize| (self.low[k] / texel - BORDER).floor();
        let side = |k: usize| (self.high[k] / texel + BORDER).ceil() - start(k);
        Face {
            frame,
            left: start(0) * texel,
            bottom: start(1) * texel,
            texel,
            width: side(0) as usize,
            height: side(1) as usize,
            z0: (self.near * self.far).sqrt(),
            layers: Vec::new(),
        }
    }
}

/// Rounds a direction, so that all near directions give the same one.
fn rounded(axis: DVec3) -> DVec3 {
    let largest = axis.abs().max_element();
    let rounded = |x: f64| (x / largest / TURN).round() * TURN;
    DVec3::new(rounded(axis.x), rounded(axis.y), rounded(axis.z)).normalize()
}

/// The lines from receivers to the light's rim, projected along each axis of a face: they bound all points in between.
struct Edges {
    /// For each receiver and axis: normals (across, along) of the lower and upper line. `None` if not bounded.
    lines: [[Option<[[f64; 2]; 2]>; 2]; 8],
    radius: f64,
}

impl Edges {
    fn new(receivers: [DVec3; 8], radius: f64) -> Self {
        Self { lines: receivers.map(|p| [p.x, p.y].map(|across| tangents(across, p.z, 0.0, radius))), radius }
    }

    /// The range of coordinates at distance 1 of points at distance `z` or more, between receivers and light.
    fn range(&self, axis: usize, z: f64) -> (f64, f64) {
        let mut range = (f64::INFINITY, f64::NEG_INFINITY);
        for lines in &self.lines {
            let Some([low, high]) = lines[axis] else { return (f64::NEG_INFINITY, f64::INFINITY) };
            // Solves a u + b ≤ r/z.
            let at = |[a, b]: [f64; 2]| (self.radius / z - b) / a;
            let bound = |[a, b]: [f64; 2], lower: bool| {
                if (a < 0.0) == lower && a.abs() > 1e-9 { Some(at([a, b])) } else { None }
            };
            range.0 = range.0.min(bound(low, true).unwrap_or(f64::NEG_INFINITY));
            range.1 = range.1.max(bound(high, false).unwrap_or(f64::INFINITY));
        }
        range
    }
}

/// Unit normals `n` of the two common tangents of the light's disc (around the origin) and a receivers' disc (around
/// `(across, along)`), outward: `n·p ≤ radius` for all points of their hull. The lower one first. `None` if one disc contains the
/// other.
pub(crate) fn tangents(across: f64, along: f64, spread: f64, radius: f64) -> Option<[[f64; 2]; 2]> {
    let distance = across.hypot(along);
    let cos = (radius - spread) / distance;
    if cos.is_nan() || cos.abs() >= 1.0 {
        return None;
    }
    let sin = (1.0 - cos * cos).sqrt();
    let (x, z) = (across / distance, along / distance);
    // The direction to the receivers, rotated by ± the angle.
    Some([[x * cos - z * sin, z * cos + x * sin], [x * cos + z * sin, z * cos - x * sin]])
}

pub(crate) fn extremes(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

/// A cone that contains all corners of the casters: axis and cosine of the half-angle.
fn cone(triangles: &[Triangle]) -> Option<(DVec3, f64)> {
    let directions = || triangles.iter().flatten().filter_map(|p| p.try_normalize());
    let (low, high) =
        directions().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), d| (low.min(d), high.max(d)));
    let axis = (0.5 * (low + high)).try_normalize()?;
    Some((axis, directions().map(|d| d.dot(axis)).fold(1.0, f64::min)))
}

/// The bounds' corners relative to the light.
pub(crate) fn corners(bounds: &ReceiverBounds, light: DVec3) -> [DVec3; 8] {
    bounds.corners().map(|p| p.as_dvec3() - light)
}
