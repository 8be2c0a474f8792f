//! One patch of a mesh, and its simplified form.

use super::steps::{Step, Steps};
use crate::topology::Sides;
use glam::{DVec3, Vec3};

/// One in this many corners inside a patch is kept.
const KEPT: usize = 8;
/// A patch that keeps more than this fraction of its triangles is not simplified.
const WORTH: f64 = 0.6;
/// The cosine of the largest angle by which a triangle's normal turns in one step.
const TURN: f64 = 0.3;

/// The simplified form of a patch, in the numbers of the mesh; the patch's own corners are numbered after these.
pub(super) struct Form {
    pub(super) own: Vec<u32>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) left_out: Vec<[u32; 2]>,
}

/// A patch with fewer corners, in the numbers of those that it was made of.
#[derive(Debug)]
pub(crate) struct Reduced {
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Corners that are left and not on the rim.
    pub(crate) inner: Vec<u32>,
    /// Corners that are left out, and the place in `triangles` of the triangle next to each.
    pub(crate) left_out: Vec<[u32; 2]>,
}

/// A sum of squared distances from planes, `xᵀAx + 2b·x + c`, times their triangles' areas.
#[derive(Clone, Copy, Default)]
struct Quadric([f64; 10]);

impl Quadric {
    fn of_plane(n: DVec3, d: f64, weight: f64) -> Self {
        let DVec3 { x, y, z } = n;
        Self([x * x, y * y, z * z, x * y, y * z, z * x, x * d, y * d, z * d, d * d].map(|q| q * weight))
    }

    fn plus(&self, other: &Self) -> Self {
        Self(core::array::from_fn(|k| self.0[k] + other.0[k]))
    }

    fn at(&self, DVec3 { x, y, z }: DVec3) -> f64 {
        let q = &self.0;
        let square = q[0] * x * x + q[1] * y * y + q[2] * z * z;
        square + 2.0 * (q[3] * x * y + q[4] * y * z + q[5] * z * x + q[6] * x + q[7] * y + q[8] * z) + q[9]
    }
}

/// A part of a mesh that is simplified by moving corners onto neighbours, the smallest error first (M. Garland, P. Heckbert,
/// *Surface Simplification Using Quadric Error Metrics*, 1997).
pub(crate) struct Patch {
    /// Numbers of the corners in the mesh, and their positions relative to one of them.
    numbers: Vec<u32>,
    positions: Vec<DVec3>,
    /// The triangles that still have an area.
    triangles: Vec<[u32; 3]>,
    /// Triangles of each corner.
    around: Vec<Vec<u32>>,
    quadrics: Vec<Quadric>,
    /// Corners of the rim, and of edges that do not have two triangles.
    is_fixed: Vec<bool>,
    /// The corner that each corner was moved onto, and how often its surroundings have changed.
    onto: Vec<u32>,
    /// The number of steps so far, and for each corner the number when its surroundings changed last.
    steps: u32,
    changed: Vec<u32>,
}

/// Marks of corners, all of which are cleared at once.
struct Marks {
    stamps: Vec<u32>,
    now: u32,
}

impl Marks {
    fn new(count: usize) -> Self {
        Self { stamps: vec![0; count], now: 0 }
    }

    fn clear(&mut self) {
        self.now += 1;
    }

    /// Marks a corner; whether it was not marked.
    fn set(&mut self, i: u32) -> bool {
        core::mem::replace(&mut self.stamps[i as usize], self.now) != self.now
    }

    /// Removes the mark of a corner; whether it had one.
    fn unset(&mut self, i: u32) -> bool {
        core::mem::replace(&mut self.stamps[i as usize], 0) == self.now
    }
}

impl Patch {
    pub(crate) fn new(positions: &[Vec3], triangles: &[[u32; 3]], part: &[u32]) -> Self {
        // Each corner of each triangle by its number, with its place among all.
        let corners = part.iter().flat_map(|t| triangles[*t as usize]);
        let mut all: Vec<u64> = corners.zip(0_u64..).map(|(i, place)| u64::from(i) << 32 | place).collect();
        all.sort_unstable();
        let mut numbers = Vec::new();
        let mut own = vec![[0; 3]; part.len()];
        for same in all.chunk_by(|a, b| a >> 32 == b >> 32) {
            same.iter().map(|key| *key as u32 as usize).for_each(|at| own[at / 3][at % 3] = numbers.len() as u32);
            numbers.push((same[0] >> 32) as u32);
        }
        let origin = numbers.first().map_or(DVec3::ZERO, |i| positions[*i as usize].as_dvec3());
        let count = numbers.len();
        let mut patch = Self {
            positions: numbers.iter().map(|i| positions[*i as usize].as_dvec3() - origin).collect(),
            triangles: own,
            around: (0..count).map(|_| Vec::with_capacity(8)).collect(),
            quadrics: vec![Quadric::default(); count],
            is_fixed: vec![false; count],
            onto: (0..count as u32).collect(),
            steps: 0,
            changed: vec![0; count],
            numbers,
        };
        for (t, corners) in (0..).zip(&patch.triangles) {
            let [a, b, c] = corners.map(|i| patch.positions[i as usize]);
            let normal = (b - a).cross(c - a);
            let unit = normal.normalize_or_zero();
            let quadric = Quadric::of_plane(unit, -unit.dot(a), normal.length());
            for i in corners.map(|i| i as usize) {
                patch.around[i].push(t);
                patch.quadrics[i] = patch.quadrics[i].plus(&quadric);
            }
        }
        let is_fixed = &mut patch.is_fixed;
        Sides::of(&patch.triangles).each(|group| {
            if group.len() != 2 || group[0].is_down() == group[1].is_down() {
                let (a, b) = group[0].ends();
                (is_fixed[a as usize], is_fixed[b as usize]) = (true, true);
            }
        });
        patch
    }

    /// The corners of the triangles of a corner, others than itself; most occur twice.
    fn ring(&self, i: u32) -> impl Iterator<Item = u32> {
        self.around[i as usize].iter().flat_map(|t| self.triangles[*t as usize]).filter(move |k| *k != i)
    }

    /// Lists the corners that share a triangle with one.
    fn neighbours(&self, i: u32, marks: &mut Marks, all: &mut Vec<u32>) {
        marks.clear();
        all.clear();
        all.extend(self.ring(i).filter(|k| marks.set(*k)));
    }

    /// The step of a corner onto a neighbour, unless it is fixed.
    fn proposal(&self, from: u32, to: u32) -> Option<Step> {
        let [a, b] = [from as usize, to as usize];
        let price = || self.quadrics[a].plus(&self.quadrics[b]).at(self.positions[b]).max(0.0);
        (!self.is_fixed[a]).then(|| Step::new(price(), from, to, self.steps))
    }

    /// Whether a corner can be moved onto a neighbour: the surface stays one, and no triangle turns over.
    fn may_move(&self, from: u32, to: u32, marks: &mut Marks) -> bool {
        let around = &self.around[from as usize];
        if around.iter().filter(|t| self.triangles[**t as usize].contains(&to)).count() != 2 {
            return false;
        }
        let keeps = |t: &u32| {
            let corners = self.triangles[*t as usize];
            let normal = |corners: [u32; 3]| {
                let [a, b, c] = corners.map(|i| self.positions[i as usize]);
                (b - a).cross(c - a)
            };
            let [was, is] = [normal(corners), normal(corners.map(|i| if i == from { to } else { i }))];
            corners.contains(&to) || was.dot(is) > TURN * (was.length_squared() * is.length_squared()).sqrt()
        };
        if !around.iter().all(keeps) {
            return false;
        }
        // The corners of both rings.
        marks.clear();
        self.ring(from).for_each(|k| _ = marks.set(k));
        self.ring(to).filter(|k| marks.unset(*k)).count() == 2
    }

    fn step(&mut self, from: u32, to: u32) {
        for t in core::mem::take(&mut self.around[from as usize]) {
            let corners = &mut self.triangles[t as usize];
            if corners.contains(&to) {
                for i in *corners {
                    self.around[i as usize].retain(|other| *other != t);
                }
                *corners = [to; 3];
            } else {
                corners.iter_mut().filter(|i| **i == from).for_each(|i| *i = to);
                self.around[to as usize].push(t);
            }
        }
        self.quadrics[to as usize] = self.quadrics[to as usize].plus(&self.quadrics[from as usize]);
        self.onto[from as usize] = to;
        self.steps += 1;
        self.changed[from as usize] = self.steps;
        self.changed[to as usize] = self.steps;
    }

    /// Moves corners until one in so many of the inner ones is left, or none can be moved. Patches of more than two million corners stay as they
    /// are.
    fn simplify(&mut self, kept: usize) {
        if self.numbers.len() > 1 << Step::BITS {
            return;
        }
        let (mut list, mut marks) = (Vec::new(), Marks::new(self.numbers.len()));
        let propose = |from: u32| {
            self.neighbours(from, &mut marks, &mut list);
            list.iter().filter_map(|to| self.proposal(from, *to)).collect()
        };
        let mut steps = Steps::new((0..self.numbers.len() as u32).map(propose).collect());
        let inner = self.is_fixed.iter().filter(|fixed| !**fixed).count();
        let mut left = inner - inner / kept;
        while left > 0 {
            let Some(step) = steps.cheapest() else { break };
            let [from, to, _] = step.parts();
            if self.is_stale(step) || !self.may_move(from, to, &mut marks) {
                steps.change(from, |list| list.retain(|other| *other != step));
                continue;
            }
            self.step(from, to);
            left -= 1;
            self.neighbours(to, &mut marks, &mut list);
            steps.change(from, Vec::clear);
            steps.change(to, |own| {
                own.clear();
                own.extend(list.iter().filter_map(|near| self.proposal(to, *near)));
            });
            for near in &list {
                steps.change(*near, |own| {
                    own.retain(|other| !self.is_stale(*other));
                    own.extend(self.proposal(*near, to));
                });
            }
        }
    }

    /// Whether one of a step's corners has changed since the step was proposed.
    fn is_stale(&self, step: Step) -> bool {
        let [from, to, at] = step.parts();
        self.changed[from as usize] > at || self.changed[to as usize] > at
    }

    /// The simplified form, if it is worth it. `mesh` is the number of the mesh's corners.
    pub(super) fn simplified(mut self, mesh: usize) -> Option<Form> {
        self.simplify(KEPT);
        let kept = self.kept();
        if kept.len() as f64 > WORTH * self.triangles.len() as f64 {
            return None;
        }
        let left_out = self.left_out(&kept);
        let mut numbers = self.numbers.clone();
        let mut own = Vec::new();
        for (i, number) in numbers.iter_mut().enumerate() {
            if !self.is_fixed[i] && self.onto[i] == i as u32 {
                own.push(*number);
                *number = (mesh + own.len() - 1) as u32;
            }
        }
        let triangles = kept.iter().map(|t| self.triangles[*t as usize].map(|i| numbers[i as usize])).collect();
        Some(Form { own, triangles, left_out })
    }

    /// The patch with one in so many of its inner corners, in the numbers that it was given.
    pub(crate) fn reduced(mut self, kept: usize) -> Reduced {
        self.simplify(kept);
        let kept = self.kept();
        let left_out = self.left_out(&kept);
        let triangles = kept.iter().map(|t| self.triangles[*t as usize].map(|i| self.numbers[i as usize])).collect();
        let is_inner = |i: &usize| !self.is_fixed[*i] && self.onto[*i] == *i as u32;
        let inner = (0..self.numbers.len()).filter(is_inner).map(|i| self.numbers[i]).collect();
        Reduced { triangles, inner, left_out }
    }

    /// The triangles that still have an area.
    fn kept(&self) -> Vec<u32> {
        let all = 0..self.triangles.len() as u32;
        all.filter(|t| self.triangles[*t as usize][0] != self.triangles[*t as usize][1]).collect()
    }

    /// Each corner that was moved, and the place in `kept` of the triangle next to it.
    fn left_out(&self, kept: &[u32]) -> Vec<[u32; 2]> {
        let mut places = vec![0; self.triangles.len()];
        kept.iter().zip(0..).for_each(|(t, place)| places[*t as usize] = place);
        let mut prisms = vec![Prism::default(); self.triangles.len()];
        kept.iter().for_each(|t| prisms[*t as usize] = self.prism(*t));
        let (mut rings, mut marks) = (vec![Vec::new(); self.numbers.len()], Marks::new(self.numbers.len()));
        let left_out = (0..self.numbers.len() as u32).filter(|i| self.onto[*i as usize] != *i);
        let left_out = left_out.filter_map(|i| {
            Some([self.numbers[i as usize], places[self.nearest(i, &prisms, (&mut rings, &mut marks))? as usize]])
        });
        left_out.collect()
    }

    fn prism(&self, t: u32) -> Prism {
        let [a, b, c] = self.triangles[t as usize].map(|k| self.positions[k as usize]);
        let n = (b - a).cross(c - a);
        let square = n.length_squared();
        let sides = [(a, b), (b, c), (c, a)].map(|(u, v)| {
            let g = n.cross(v - u) / square;
            (g, -g.dot(u))
        });
        let size = square.sqrt();
        let off = n * (1e-3 / (size * size.sqrt()));
        Prism { sides, off: (off, -off.dot(a)) }
    }

    /// The triangle next to a corner that has been moved, among those around where it is now. The triangles around a corner are kept in
    /// `rings`: they are the same for all that have been moved onto it.
    fn nearest(&self, i: u32, prisms: &[Prism], (rings, marks): (&mut [Vec<u32>], &mut Marks)) -> Option<u32> {
        let mut at = i;
        while self.onto[at as usize] != at {
            at = self.onto[at as usize];
        }
        let ring = &mut rings[at as usize];
        if ring.is_empty() {
            let mut near = Vec::new();
            self.neighbours(at, marks, &mut near);
            near.sort_unstable();
            for t in near.iter().chain([&at]).flat_map(|k| &self.around[*k as usize]) {
                if !ring.contains(t) {
                    ring.push(*t);
                }
            }
        }
        let p = self.positions[i as usize];
        let mut best = (f64::NEG_INFINITY, None);
        for t in ring.iter() {
            let depth = prisms[*t as usize].depth(p);
            if depth > best.0 {
                best = (depth, Some(*t));
            }
        }
        best.1
    }
}

/// The space above and below a triangle: its sides as half-spaces, in units of its heights, and its plane, in a thousandth of
/// the root of its area.
#[derive(Clone, Copy, Default)]
struct Prism {
    sides: [(DVec3, f64); 3],
    off: (DVec3, f64),
}

impl Prism {
    /// How deep a point lies inside of the triangle's sides, seen along its normal: 0 inside, less the farther it is outside or
    /// off the plane.
    fn depth(&self, p: DVec3) -> f64 {
        let inside = self.sides.iter().fold(0.0_f64, |least, (g, d)| least.min(g.dot(p) + d));
        inside - (self.off.0.dot(p) + self.off.1).abs()
    }
}
