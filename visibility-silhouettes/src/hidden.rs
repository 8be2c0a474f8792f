//! Triangles that reach into a tube of light, or behind it: only what is before the tube blocks.

use crate::clip::{Behind, Chord, Events, Inside, is_around, keep_outside};
use crate::select::Silhouettes;
use glam::{DVec3, Vec3};
use lobe_core::{Capsule, distance_of_segments};

/// Chords replace arcs where they are nearer than this part of the radius.
const SAGITTA: f64 = 1e-3;
/// [`Capsule::off`] changes by at most this many times the way.
const STEEPEST: f64 = 1.25;
/// An arc becomes at most 2 to the power of this many chords.
const HALVINGS: u32 = 16;
/// Steps of a search for the tube's surface, and the part of the searched way, or of the radius, at which it ends.
const STEPS: usize = 50;
const NEAR: f64 = 1e-8;

/// All that a tube of light `K` hides from a receiver at the origin, the tube included: the points to which a line of sight meets it first,
/// `⋃ t·K` over `t ≥ 1`. Like the tube it is convex, but for the tube's [rim](Capsule): an edge is in it from one point to another, and what is in it of a
/// triangle has one outline.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hidden {
    body: Capsule,
    radius: f64,
    /// The depth of the light's plane less that of the tube's nearest point.
    deep: f64,
    plane: Behind,
}

/// A side of the part of a triangle that is before the light's plane: where it begins, and whether the plane has made it.
type Side = (Vec3, bool);

/// Up to four sides.
#[derive(Default)]
struct Part {
    sides: [Side; 4],
    count: usize,
}

impl Part {
    /// The part of a triangle before a plane, in the triangle's turn.
    fn before(plane: &Behind, corners: [Vec3; 3]) -> Self {
        let mut part = Self::default();
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            match plane.inside(a, b) {
                Inside::Nowhere => part.push(a, false),
                Inside::First(p) => part.push(p, false),
                Inside::Second(p) => {
                    part.push(a, false);
                    part.push(p, true);
                }
                Inside::All | Inside::Between(_) => {}
            }
        }
        part
    }

    fn push(&mut self, begins: Vec3, is_cut: bool) {
        // A plane makes one side of a triangle.
        if let Some(side) = self.sides.get_mut(self.count) {
            *side = (begins, is_cut);
            self.count += 1;
        }
    }

    fn sides(&self) -> impl Iterator<Item = ([Vec3; 2], bool)> {
        (0..self.count).map(|k| {
            let (from, is_cut) = self.sides[k];
            ([from, self.sides[(k + 1) % self.count].0], is_cut)
        })
    }

    /// Whether a point of its plane is inside of it, which turns about `normal`.
    fn holds(&self, p: DVec3, normal: DVec3) -> bool {
        is_around(self.sides().map(|(side, _)| side.map(|q| q.as_dvec3())), p, normal)
    }
}

impl Hidden {
    /// As far as the light's plane.
    pub(crate) fn new(body: &Capsule, plane: Behind) -> Self {
        let radius = f64::from(body.radius);
        let deep = body.ends.iter().map(|end| plane.before_it(end.as_dvec3())).fold(0.0, f64::max) + radius;
        Self { body: *body, radius, deep, plane }
    }

    pub(crate) fn ends(&self) -> [DVec3; 2] {
        self.body.ends.map(|p| p.as_dvec3())
    }

    /// How far beside the tube's middle line points before the plane may be hidden: no farther from where the line of sight is inside the tube than that
    /// is deep.
    pub(crate) fn reach(&self) -> f32 {
        let steepness = |end: DVec3| (self.plane.along(end) - 1.1 * self.radius) / end.length();
        let least = self.ends().map(steepness).into_iter().fold(1.0, f64::min);
        if least > 0.0 { (1.1 * self.radius + self.deep / least) as f32 } else { f32::INFINITY }
    }

    fn holds(&self, p: DVec3) -> bool {
        self.body.off(p) < 0.0
    }

    /// The point of the surface between one that is held and one that is not, by false position.
    fn surface(&self, inside: DVec3, outside: DVec3) -> DVec3 {
        let at = |t: f64| inside + (outside - inside) * t;
        let off = |t: f64| self.body.off(at(t));
        let (mut low, mut high) = ((0.0, off(0.0)), (1.0, off(1.0)));
        if low.1 >= 0.0 {
            return inside;
        }
        let mut last = 0.0;
        for step in 0..STEPS {
            // Illinois: an end that stays counts half; now and then the middle, where both stay large.
            let t = if step % 8 == 7 {
                0.5 * (low.0 + high.0)
            } else {
                low.0 + (high.0 - low.0) * (low.1 / (low.1 - high.1))
            };
            let value = off(t);
            if value < 0.0 {
                low = (t, value);
                if last < 0.0 {
                    high.1 *= 0.5;
                }
            } else {
                high = (t, value);
                if last > 0.0 {
                    low.1 *= 0.5;
                }
            }
            if high.0 - low.0 < NEAR || value.abs() < NEAR * self.radius {
                return at(t);
            }
            last = value;
        }
        at(low.0)
    }

    fn inside(&self, a: Vec3, b: Vec3) -> Inside {
        Inside::either_way(a, b, |a, b| self.find_inside(a, b))
    }

    fn find_inside(&self, a: Vec3, b: Vec3) -> Inside {
        let [p, q] = [a, b].map(|p| p.as_dvec3());
        if [p, q].iter().all(|p| self.plane.before_it(*p) > self.deep) {
            return Inside::Nowhere;
        }
        let [from, to] = [p, q].map(|p| self.body.off(p));
        match (from < 0.0, to < 0.0) {
            (true, true) => Inside::All,
            (true, false) => Inside::First(self.surface(p, q).as_vec3()),
            (false, true) => Inside::Second(self.surface(q, p).as_vec3()),
            (false, false) if from + to > STEEPEST * p.distance(q) => Inside::Nowhere,
            (false, false) => self.between(p, q).map_or(Inside::Nowhere, |middle| {
                Inside::Between([p, q].map(|end| self.surface(middle, end).as_vec3()))
            }),
        }
    }

    /// A point of an edge, whose ends are not held, that is.
    ///
    /// The triangle of the receiver and the edge comes nearest to the middle line where that pierces it, across from an end of that, or at the edge.
    fn between(&self, p: DVec3, q: DVec3) -> Option<DVec3> {
        let [a, b] = self.ends();
        let normal = p.cross(q);
        let square = normal.length_squared();
        // Where the line of sight to a point, across from it, meets the edge.
        let toward = |at: DVec3| {
            let of = [at.cross(q).dot(normal), p.cross(at).dot(normal)].map(|part| part / square);
            let all = of[0] + of[1];
            (all > 0.0).then(|| p + (q - p) * (of[1] / all).clamp(0.0, 1.0))
        };
        let [before, behind] = [a, b].map(|end| normal.dot(end));
        let pierced = a + (b - a) * (before / (before - behind)).clamp(0.0, 1.0);
        let nearest = p + (q - p) * distance_of_segments([p, q], [a, b]).1;
        let found = [toward(pierced), toward(a), toward(b), Some(nearest)];
        found.into_iter().flatten().find(|at| self.holds(*at))
    }

    /// The parts of silhouettes outside.
    pub(crate) fn outside(&self, silhouettes: &Silhouettes, out: &mut Silhouettes) {
        keep_outside(silhouettes, |a, b| self.inside(a, b), out);
    }

    /// Appends the outlines that a triangle gets where it goes behind the plane or is hidden before that. Corners are relative to the receiver; `side` is 1
    /// if that is in front of the triangle, −1 if behind it. Returns whether any part before the plane may be hidden, or behind it.
    pub(crate) fn clip(&self, corners: [Vec3; 3], side: impl Fn() -> f32, out: &mut Vec<Chord>) -> bool {
        let [a, b, c] = corners.map(|p| p.as_dvec3());
        let heights = [a, b, c].map(|p| self.plane.before_it(p));
        if heights.iter().all(|height| *height > self.deep) || heights.iter().all(|height| *height < 0.0) {
            return false;
        }
        let part = Part::before(&self.plane, corners);
        if part.count == 0 {
            return false;
        }
        let middle = (a + b + c) / 3.0;
        let reach = [a, b, c].iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
        let is_cut = part.sides[..part.count].iter().any(|(_, is_cut)| *is_cut);
        let is_near = self.body.off(middle) < STEEPEST * reach;
        if !is_near && !is_cut {
            return false;
        }
        let side = side() as i32;
        if side == 0 {
            return true;
        }
        if !is_near {
            out.extend(part.sides().filter(|(_, is_cut)| *is_cut).map(|([from, to], _)| (from, to, side)));
            return true;
        }
        let normal = (b - a).cross(c - a).normalize_or_zero();
        self.draw(&part, normal, 2.0 * reach, side, out) || is_cut
    }

    /// Draws the sides that the plane has made, as far as they are not hidden, and the surface inside of the part. Returns whether any of the part is hidden.
    fn draw(&self, part: &Part, normal: DVec3, size: f64, side: i32, out: &mut Vec<Chord>) -> bool {
        let mut events = Events::new();
        for ([a, b], is_cut) in part.sides() {
            let inside = self.inside(a, b);
            events.add(inside);
            if is_cut {
                inside.each_outside(a, b, |from, to| out.push((from, to, side)));
            }
        }
        if events.is_empty() && events.all {
            return true;
        }
        let face = Face::new(self, part, normal, size);
        let mut arc = |ends| face.arc(self, ends, HALVINGS, &mut |from, to| out.push((to, from, side)));
        events.arcs().for_each(&mut arc);
        if !events.is_empty() {
            return true;
        }
        let Some(middle) = face.places().next() else { return false };
        // A hole.
        let u = normal.any_orthonormal_vector();
        let [u, v] = [u, normal.cross(u)];
        let round = [u, v, -u, -v].map(|toward| self.toward(middle, toward, size).as_vec3());
        for k in 0..4 {
            arc([round[k], round[(k + 1) % 4]]);
        }
        true
    }

    /// Where the surface is from a held point along a direction, at most some way off.
    fn toward(&self, from: DVec3, direction: DVec3, most: f64) -> DVec3 {
        let mut step = (0.1 * self.radius).min(most);
        while step < most && self.holds(from + direction * step) {
            step *= 4.0;
        }
        let outside = from + direction * step.min(most);
        if self.holds(outside) { outside } else { self.surface(from, outside) }
    }
}

/// The plane of a triangle that is hidden in part.
struct Face {
    normal: DVec3,
    /// How far surfaces are at most.
    size: f64,
    /// Hidden points of the triangle, some of them at both ends of what is hidden; the others are none.
    places: [Option<DVec3>; 5],
}

impl Face {
    fn new(hidden: &Hidden, part: &Part, normal: DVec3, size: f64) -> Self {
        let [a, b] = hidden.ends();
        let height = normal.dot(part.sides[0].0.as_dvec3());
        let [of_a, of_b] = [a, b].map(|end| height - normal.dot(end));
        // Where the middle line, which is held, goes through the plane; its ends' feet on that; what is behind these ends.
        let pierced = a + (b - a) * (of_a / (of_a - of_b));
        let behind = |end: DVec3| end * (height / normal.dot(end));
        let found = [behind(a), behind(b), a + normal * of_a, b + normal * of_b, pierced];
        let is_place = |p: DVec3| p.is_finite() && part.holds(p, normal) && hidden.holds(p);
        Self { normal, size, places: found.map(|p| is_place(p).then_some(p)) }
    }

    fn places(&self) -> impl Iterator<Item = DVec3> {
        self.places.iter().copied().flatten()
    }

    /// Calls `draw` for chords of the surface from one point of the plane to another, about its normal.
    fn arc(&self, hidden: &Hidden, [from, to]: [Vec3; 2], halvings: u32, draw: &mut impl FnMut(Vec3, Vec3)) {
        let [p, q] = [from, to].map(|p| p.as_dvec3());
        let middle = 0.5 * (p + q);
        let outward = (q - p).cross(self.normal).normalize_or_zero();
        let least = SAGITTA * hidden.radius;
        // First toward what is hidden farthest outside, as the ends of a long tube; then straight on.
        let outside = |p: &DVec3| (*p - middle).dot(outward);
        let is_whole = halvings + 2 > HALVINGS;
        let places = self.places().filter(|p| is_whole && outside(p) > least);
        let far = places.max_by(|p, q| outside(p).total_cmp(&outside(q)));
        let far = far.or_else(|| Some(middle + outward * least).filter(|p| outward != DVec3::ZERO && hidden.holds(*p)));
        match far.filter(|_| halvings > 0) {
            Some(far) => {
                let top = hidden.toward(far, (far - middle).normalize(), self.size).as_vec3();
                self.arc(hidden, [from, top], halvings - 1, draw);
                self.arc(hidden, [top, to], halvings - 1, draw);
            }
            None => draw(from, to),
        }
    }
}
