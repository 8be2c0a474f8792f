//! Triangles that reach into the light: only their parts in front of its near side block.

use crate::edge_list::Columns;
use crate::select::{NUMBERS, STEP, Silhouettes};
use core::f64::consts::TAU;
use glam::{DVec3, Vec3};
use lobe_core::{Outline, Sphere};

/// Sides of the circle whose chords replace arcs: within 0.1 % of its radius.
const SIDES: f64 = 64.0;
/// Arcs that end on the rim of the light's disc are drawn slightly beyond it, by this factor.
const BEYOND: f32 = 1.001;

/// The cosine of the largest angle of one chord, with a small margin.
const ONE_CHORD: f64 = 0.995_19;
/// Rounding of a distance from the light's plane, relative to the plane's distance.
const ROUNDING: f64 = 1e-5;

/// A light seen from a receiver.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LightSphere {
    center: DVec3,
    radius: f64,
}

/// A piece of an outline, seen from a receiver, and the growth of the number of surfaces to its right.
pub(crate) type Chord = (Vec3, Vec3, i32);

/// The plane of the circle in which a cone touches its light, across the axis: surfaces count as far as this plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Front {
    pub(crate) axis: Vec3,
    pub(crate) distance: f32,
}

impl Front {
    /// Whether points are certainly in front of the plane, and whether they are certainly behind it.
    fn sides(&self, points: &[Vec3]) -> [bool; 2] {
        let depths = points.iter().map(|p| f64::from(self.axis.dot(*p)) - f64::from(self.distance));
        let margin = ROUNDING * f64::from(self.distance);
        [depths.clone().all(|depth| depth < -margin), depths.clone().all(|depth| depth > margin)]
    }

    /// A point moved away from the axis, slightly beyond the light's rim.
    fn beyond(&self, p: Vec3) -> Vec3 {
        let along = self.axis * self.axis.dot(p);
        along + (p - along) * BEYOND
    }
}

/// The part of an edge that is inside a light, or hidden by it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Inside {
    Nowhere,
    /// From its first end to a point.
    First(Vec3),
    /// From a point to its second end.
    Second(Vec3),
    Between([Vec3; 2]),
    All,
}

impl Inside {
    /// Of an edge, found by a test that always runs along it the same way: both triangles of the edge get the same bits.
    pub(crate) fn either_way(a: Vec3, b: Vec3, find: impl FnOnce(Vec3, Vec3) -> Self) -> Self {
        if b.to_array() < a.to_array() {
            return match find(b, a) {
                Self::First(p) => Self::Second(p),
                Self::Second(p) => Self::First(p),
                Self::Between([p, q]) => Self::Between([q, p]),
                same => same,
            };
        }
        find(a, b)
    }

    /// Calls `push` for the parts of the edge that are outside.
    pub(crate) fn each_outside(self, a: Vec3, b: Vec3, mut push: impl FnMut(Vec3, Vec3)) {
        match self {
            Self::Nowhere => push(a, b),
            Self::First(p) => push(p, b),
            Self::Second(p) => push(a, p),
            Self::Between([p, q]) => {
                push(a, p);
                push(q, b);
            }
            Self::All => {}
        }
    }
}

/// Points at which a convex outline of up to four sides leaves the inside (true) or enters it, in order, and whether all of it is inside.
pub(crate) struct Events {
    list: [(bool, Vec3); 8],
    count: usize,
    pub(crate) all: bool,
}

impl Events {
    pub(crate) const fn new() -> Self {
        Self { list: [(false, Vec3::ZERO); 8], count: 0, all: true }
    }

    /// Those of the next side.
    pub(crate) fn add(&mut self, inside: Inside) {
        self.all &= inside == Inside::All;
        match inside {
            Inside::First(p) => self.push(true, p),
            Inside::Second(p) => self.push(false, p),
            Inside::Between([p, q]) => {
                self.push(false, p);
                self.push(true, q);
            }
            Inside::Nowhere | Inside::All => {}
        }
    }

    fn push(&mut self, leaves: bool, p: Vec3) {
        self.list[self.count] = (leaves, p);
        self.count += 1;
    }

    pub(crate) const fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// From where to where arcs run inside the outline: from each point at which that leaves the inside to the next, at which it enters again.
    pub(crate) fn arcs(&self) -> impl Iterator<Item = [Vec3; 2]> {
        let passed = &self.list[..self.count];
        let next = passed.iter().cycle().skip(1);
        passed.iter().zip(next).filter(|((leaves, _), _)| *leaves).map(|((_, from), (_, to))| [*from, *to])
    }
}

/// Whether a point of a plane is inside of a convex outline that turns about its normal.
pub(crate) fn is_around(sides: impl IntoIterator<Item = [DVec3; 2]>, p: DVec3, normal: DVec3) -> bool {
    sides.into_iter().all(|[a, b]| (b - a).cross(p - a).dot(normal) > 0.0)
}

/// The sides of a triangle.
pub(crate) const fn sides_of([a, b, c]: [DVec3; 3]) -> [[DVec3; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

impl LightSphere {
    /// A light seen from `origin`.
    pub(crate) fn new(light: Sphere, origin: Vec3) -> Self {
        Self { center: light.center.as_dvec3() - origin.as_dvec3(), radius: f64::from(light.radius) }
    }

    fn holds(&self, p: Vec3) -> bool {
        p.as_dvec3().distance_squared(self.center) < self.radius * self.radius
    }

    /// The distance of the front side along a ray from the receiver; infinite if the ray passes beside it.
    pub(crate) fn distance(&self, direction: Vec3) -> f32 {
        let d = direction.as_dvec3();
        let along = d.dot(self.center);
        let aside = (self.center - d * along).length_squared();
        (along - (self.radius * self.radius - aside).max(0.0).sqrt()) as f32
    }

    fn inside(&self, a: Vec3, b: Vec3) -> Inside {
        Inside::either_way(a, b, |a, b| self.find_inside(a, b))
    }

    fn find_inside(&self, a: Vec3, b: Vec3) -> Inside {
        let [from, edge] = [a.as_dvec3() - self.center, b.as_dvec3() - a.as_dvec3()];
        let (square, half) = (edge.length_squared(), -from.dot(edge));
        // Solves |from + t·edge| = radius.
        let nearest = (from + edge * (half / square)).length_squared();
        let root = ((self.radius * self.radius - nearest).max(0.0) / square).sqrt();
        let [enter, leave] = [half / square - root, half / square + root];
        let at = |t: f64| (a.as_dvec3() + edge * t.clamp(0.0, 1.0)).as_vec3();
        // The ends decide for all edges that share them.
        match (self.holds(a), self.holds(b)) {
            (true, true) => Inside::All,
            (true, false) => Inside::First(at(leave)),
            (false, true) => Inside::Second(at(enter)),
            (false, false) if root > 0.0 && enter > 0.0 && leave < 1.0 => Inside::Between([at(enter), at(leave)]),
            (false, false) => Inside::Nowhere,
        }
    }

    /// Whether the light's surface may cut a triangle, seen from any receiver: nearly cutting counts too.
    pub(crate) fn may_clip(light: Sphere, corners: [Vec3; 3]) -> bool {
        let scaled = |scale: f64| {
            let sphere = Self::new(light, Vec3::ZERO);
            Self { radius: sphere.radius * scale, ..sphere }
        };
        let [small, large] = [scaled(0.999), scaled(1.001)];
        if corners.iter().all(|p| small.holds(*p)) {
            return false;
        }
        let sides = [0, 1, 2].map(|k| large.inside(corners[k], corners[(k + 1) % 3]));
        sides.iter().any(|side| *side != Inside::Nowhere) || large.is_within(corners)
    }

    /// The normal of a triangle, and the distance of its plane from the sphere's centre along it.
    fn plane(&self, corners: [Vec3; 3]) -> (DVec3, f64) {
        let [a, b, c] = corners.map(|p| p.as_dvec3());
        let normal = (b - a).cross(c - a).normalize_or_zero();
        (normal, normal.dot(a - self.center))
    }

    /// Whether the plane of a triangle cuts the sphere in a circle whose centre is inside the triangle.
    fn is_within(&self, corners: [Vec3; 3]) -> bool {
        let (normal, off) = self.plane(corners);
        let middle = self.center + normal * off;
        off.abs() < self.radius && is_around(sides_of(corners.map(|p| p.as_dvec3())), middle, normal)
    }

    /// The parts of silhouettes outside the sphere.
    pub(crate) fn outside(&self, silhouettes: &Silhouettes, out: &mut Silhouettes) {
        keep_outside(silhouettes, |a, b| self.inside(a, b), out);
    }

    /// Appends the outlines of the hole that the sphere cuts into a triangle, as far as they are on the light's front side. Corners
    /// are relative to the receiver; `side` is 1 if the receiver is in front of the triangle, −1 if behind it.
    ///
    /// The part of the triangle inside the sphere is convex: along the triangle's outline an arc begins where the outline leaves
    /// the sphere and ends where it enters again.
    pub(crate) fn clip(&self, front: &Front, corners: [Vec3; 3], side: impl Fn() -> f32, out: &mut Vec<Chord>) {
        if front.sides(&corners)[1] {
            return;
        }
        let (normal, off) = self.plane(corners);
        let rho = (self.radius * self.radius - off * off).sqrt();
        if normal == DVec3::ZERO || rho.is_nan() || rho <= 0.0 {
            return;
        }
        let side = side();
        if side == 0.0 {
            return;
        }
        let middle = self.center + normal * off;
        let circle = || Circle::new(middle, normal, rho, front);
        let mut events = Events::new();
        for k in 0..3 {
            events.add(self.inside(corners[k], corners[(k + 1) % 3]));
        }
        if !events.is_empty() {
            for [from, to] in events.arcs() {
                // Most arcs are one chord, in front of the plane or behind it.
                let [a, b] = [from, to].map(|p| p.as_dvec3() - middle);
                let is_short = a.cross(b).dot(normal) > 0.0
                    && a.dot(b) > ONE_CHORD * (a.length_squared() * b.length_squared()).sqrt();
                match front.sides(&[from, to]) {
                    [true, _] if is_short => out.push((to, from, side as i32)),
                    [_, true] if is_short => {}
                    _ => circle().draw(front, Some([from, to]), side, out),
                }
            }
        } else if !events.all && self.is_within(corners) {
            circle().draw(front, None, side, out);
        }
    }
}

/// The parts of silhouettes outside a light.
pub(crate) fn keep_outside(silhouettes: &Silhouettes, inside: impl Fn(Vec3, Vec3) -> Inside, out: &mut Silhouettes) {
    out.clear();
    for i in 0..silhouettes.len() {
        let end = |c: usize| Vec3::from_array([c, c + 1, c + 2].map(|c| silhouettes.get(c, i)));
        let (a, b, step) = (end(0), end(3), silhouettes.get(STEP, i));
        inside(a, b).each_outside(a, b, |a, b| add(out, [a, b], step));
    }
}

/// Adds a chord to silhouettes.
pub(crate) fn add_chord(out: &mut Silhouettes, (a, b, step): Chord) {
    add(out, [a, b], step as f32);
}

fn add(out: &mut Silhouettes, [a, b]: [Vec3; 2], step: f32) {
    let mut numbers = [step; NUMBERS];
    numbers[..3].copy_from_slice(&a.to_array());
    numbers[3..6].copy_from_slice(&b.to_array());
    Columns::push(out, numbers);
}

/// The plane of a flat light, seen from a receiver: only surfaces in front of it block.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Behind {
    axis: DVec3,
    depth: f64,
}

impl Behind {
    /// Parallel to the light's at a depth.
    pub(crate) fn new(light: &Outline, depth: f32) -> Self {
        Self { axis: light.axis().as_dvec3(), depth: f64::from(depth) }
    }

    /// Its normal, and how far along that it is from the world's origin, if the receiver's rays start at a point.
    pub(crate) fn placed(&self, origin: Vec3) -> (Vec3, f64) {
        (self.axis.as_vec3(), self.axis.dot(origin.as_dvec3()) + self.depth)
    }

    fn holds(&self, p: Vec3) -> bool {
        self.axis.dot(p.as_dvec3()) > self.depth
    }

    pub(crate) fn along(&self, p: DVec3) -> f64 {
        self.axis.dot(p)
    }

    /// How far before it a point is, seen from the receiver.
    pub(crate) fn before_it(&self, p: DVec3) -> f64 {
        self.depth - self.axis.dot(p)
    }

    /// As [`LightSphere::inside`].
    pub(crate) fn inside(&self, a: Vec3, b: Vec3) -> Inside {
        let cut = |a: Vec3, b: Vec3| {
            let (p, q) = (a.as_dvec3(), b.as_dvec3());
            let (from, to) = (self.axis.dot(p) - self.depth, self.axis.dot(q) - self.depth);
            (p + (q - p) * (from / (from - to)).clamp(0.0, 1.0)).as_vec3()
        };
        // The same point, whichever way the edge runs.
        let point = || if b.to_array() < a.to_array() { cut(b, a) } else { cut(a, b) };
        match (self.holds(a), self.holds(b)) {
            (true, true) => Inside::All,
            (true, false) => Inside::First(point()),
            (false, true) => Inside::Second(point()),
            (false, false) => Inside::Nowhere,
        }
    }

    /// The parts of silhouettes in front of the plane.
    pub(crate) fn before(&self, silhouettes: &Silhouettes, out: &mut Silhouettes) {
        keep_outside(silhouettes, |a, b| self.inside(a, b), out);
    }

    /// The outline in which the plane cuts a triangle, as [`LightSphere::clip`].
    pub(crate) fn clip(&self, corners: [Vec3; 3], side: impl Fn() -> f32) -> Option<Chord> {
        let held = corners.map(|p| self.holds(p));
        if held[0] == held[1] && held[1] == held[2] {
            return None;
        }
        let (mut from, mut to) = (None, None);
        for k in 0..3 {
            match self.inside(corners[k], corners[(k + 1) % 3]) {
                Inside::First(p) => from = Some(p),
                Inside::Second(p) => to = Some(p),
                _ => {}
            }
        }
        let side = side() as i32;
        (side != 0).then_some((to?, from?, side))
    }
}

/// The circle in which the plane of a triangle cuts a sphere.
struct Circle {
    middle: DVec3,
    /// Perpendicular unit vectors of the circle; they turn as the triangle's corners do.
    u: DVec3,
    v: DVec3,
    /// The angles between which the circle is in front of the light's plane; `None` if no part of it is.
    front: Option<[f64; 2]>,
}

impl Circle {
    /// Angles count from the point that is nearest to the receiver along the view's axis.
    fn new(middle: DVec3, normal: DVec3, rho: f64, front: &Front) -> Self {
        let axis = front.axis.as_dvec3();
        let toward = axis - normal * axis.dot(normal);
        let u = -toward.normalize_or(normal.any_orthonormal_vector()) * rho;
        let v = normal.cross(u);
        // depth(φ) = middle − |u·axis| cos φ.
        let (room, reach) = (f64::from(front.distance) - middle.dot(axis), -u.dot(axis));
        let front = if room >= reach {
            Some([-0.5 * TAU, 0.5 * TAU])
        } else if room <= -reach {
            None
        } else {
            let half = (-room / reach).clamp(-1.0, 1.0).acos();
            Some([-half, half])
        };
        Self { middle, u, v, front }
    }

    fn at(&self, angle: f64) -> Vec3 {
        let (sin, cos) = angle.sin_cos();
        (self.middle + self.u * cos + self.v * sin).as_vec3()
    }

    /// Appends the front part of the arc from one point to another, or of the whole circle. The arc is drawn backward, since it is
    /// the outline of the surface around it.
    fn draw(&self, plane: &Front, ends: Option<[Vec3; 2]>, side: f32, out: &mut Vec<Chord>) {
        let Some([low, high]) = self.front else { return };
        let whole = high - low >= TAU;
        let angle = |p: Vec3| {
            let d = p.as_dvec3() - self.middle;
            self.v.dot(d).atan2(self.u.dot(d))
        };
        let (start, span) = match ends {
            Some([from, to]) => (angle(from), (angle(to) - angle(from)).rem_euclid(TAU)),
            None => (-0.5 * TAU, TAU),
        };
        // The front part may be two pieces: the arc passes it from `start` on, and again after one turn.
        for turn in [0.0, TAU] {
            let (from, to) = if whole {
                if turn > 0.0 {
                    break;
                }
                (start, start + span)
            } else {
                ((low + turn).max(start), (high + turn).min(start + span))
            };
            if from >= to {
                continue;
            }
            let count = ((to - from) / TAU * SIDES).ceil().max(1.0) as usize;
            let point = |k: usize| {
                let t = from + (to - from) * k as f64 / count as f64;
                // The arc's ends are exact to the bit; ends on the rim are slightly outside of it.
                match ends {
                    Some([first, _]) if k == 0 && from == start => first,
                    Some([_, last]) if k == count && to == start + span => last,
                    None if k == count && whole => self.at(from),
                    _ if !whole && (k == 0 || k == count) => plane.beyond(self.at(t)),
                    _ => self.at(t),
                }
            };
            let mut before = point(count);
            for k in (0..count).rev() {
                let next = point(k);
                out.push((before, next, side as i32));
                before = next;
            }
        }
    }
}
