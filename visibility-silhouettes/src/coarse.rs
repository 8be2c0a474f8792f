//! Simplified meshes, for outlines that are seen from a distance.

use crate::topology::{Sides, WHOLE};
use core::ops::Range;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// The most triangles of a patch. Its rim is not simplified, so a small patch loses few triangles.
const PATCH: usize = 2048;
/// One in this many corners inside a patch is kept.
const KEPT: usize = 8;
/// A patch that keeps more than this fraction of its triangles is not simplified.
const WORTH: f64 = 0.6;
/// The cosine of the largest angle by which a triangle's normal turns in one step.
const TURN: f64 = 0.3;

/// A mesh in patches, and their simplified forms. Each form has the rim of its patch, so that any forms fit together.
#[derive(Debug)]
pub(crate) struct Coarse {
    /// The patch of each triangle of the mesh; [`WHOLE`] if it has no simplified form.
    pub(crate) patches: Vec<u16>,
    /// Corners of the mesh that simplified forms store as corners of their own, since these may be moved.
    pub(crate) own: Vec<u32>,
    /// The triangles of the simplified forms, between corners of the mesh on rims and their own corners, which are numbered after
    /// those of the mesh; and the patches of these triangles.
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) triangle_patches: Vec<u16>,
    /// Each corner that is left out, and the number in `triangles` of the triangle next to it.
    pub(crate) left_out: Vec<[u32; 2]>,
    /// Patches with a simplified form.
    pub(crate) count: usize,
}

/// The most patches: two of their numbers fit into a [`Tag`](topology::Tag).
const MOST: usize = 1 << 14;

/// Simplifies a mesh patch by patch; `None` if that saves too little.
pub(crate) fn coarse(positions: &[Vec3], triangles: &[[u32; 3]]) -> Option<Coarse> {
    let middle = |t: &[u32; 3]| t.iter().map(|i| positions[*i as usize]).sum();
    let middles: Vec<Vec3> = triangles.par_iter().map(middle).collect();
    let middle = |t: &u32| middles[*t as usize];
    let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
    let parts = divide(&mut order, 0, &middle);
    let forms: Vec<Option<Form>> = parts
        .par_iter()
        .map(|part| Patch::new(positions, triangles, &order[part.clone()]).simplified(positions.len()))
        .collect();
    let mut out = Coarse {
        patches: vec![WHOLE; triangles.len()],
        own: Vec::new(),
        triangles: Vec::new(),
        triangle_patches: Vec::new(),
        left_out: Vec::new(),
        count: 0,
    };
    for (part, form) in parts.into_iter().zip(forms) {
        let (Some(form), true) = (form, out.count < MOST) else { continue };
        let patch = out.count as u16;
        let first = out.triangles.len() as u32;
        order[part].iter().for_each(|t| out.patches[*t as usize] = patch);
        out.triangle_patches.extend(form.triangles.iter().map(|_| patch));
        let (mesh, before) = (positions.len() as u32, out.own.len() as u32);
        let place = |i: u32| if i < mesh { i } else { i + before };
        out.triangles.extend(form.triangles.iter().map(|t| t.map(place)));
        out.own.extend(form.own);
        out.left_out.extend(form.left_out.iter().map(|[corner, near]| [*corner, near + first]));
        out.count += 1;
    }
    (out.count > 0).then_some(out)
}

/// Halves a list of triangles by the centres of their corners until the parts are small. Returns the parts.
fn divide(order: &mut [u32], first: usize, middle: &(impl Fn(&u32) -> Vec3 + Sync)) -> Vec<Range<usize>> {
    if order.len() <= PATCH {
        return core::iter::once(first..first + order.len()).collect();
    }
    let bounds = order.iter().map(middle).fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[a, b], m| [a.min(m), b.max(m)]);
    let axis = (bounds[1] - bounds[0]).max_position();
    let half = order.len() / 2;
    order.select_nth_unstable_by(half, |a, b| middle(a)[axis].total_cmp(&middle(b)[axis]).then(a.cmp(b)));
    let (low, high) = order.split_at_mut(half);
    let (mut parts, more) = rayon::join(|| divide(low, first, middle), || divide(high, first + half, middle));
    parts.extend(more);
    parts
}

/// The simplified form of a patch, in the numbers of the mesh; the patch's own corners are numbered after these.
struct Form {
    own: Vec<u32>,
    triangles: Vec<[u32; 3]>,
    left_out: Vec<[u32; 2]>,
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

/// A step of a corner onto another one, and the number of steps when it was proposed. Steps are ordered by their cost, in the highest 64 bits
/// (those of non-negative numbers have the same order), then by their corners.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Step(u128);

impl Step {
    /// Bits of the number of a corner.
    const BITS: u32 = 21;

    fn new(cost: f64, from: u32, to: u32, steps: u32) -> Self {
        let corners = u64::from(from) << Self::BITS | u64::from(to);
        let low = corners << (64 - 2 * Self::BITS) | u64::from(steps);
        Self(u128::from(cost.to_bits()) << 64 | u128::from(low))
    }

    /// From which corner, onto which one, and the number of steps before.
    fn parts(self) -> [u32; 3] {
        let (low, rest) = (self.0 as u64, 64 - 2 * Self::BITS);
        let of = |bits: u64, count: u32| (bits & ((1 << count) - 1)) as u32;
        [of(low >> (64 - Self::BITS), Self::BITS), of(low >> rest, Self::BITS), of(low, rest)]
    }
}

/// The proposed steps of each corner, and a tree over the corners: each place has the cheaper one of the steps in the two places below it.
struct Steps {
    lists: Vec<Vec<Step>>,
    /// The root is at 1, the places below `k` are `2k` and `2k + 1`.
    tree: Vec<Step>,
}

impl Steps {
    /// More than any step.
    const NONE: Step = Step(u128::MAX);

    fn new(lists: Vec<Vec<Step>>) -> Self {
        let leaves = lists.len().next_power_of_two();
        let mut tree = vec![Self::NONE; 2 * leaves];
        lists.iter().zip(&mut tree[leaves..]).for_each(|(list, place)| *place = Self::cheapest_of(list));
        for k in (1..leaves).rev() {
            tree[k] = tree[2 * k].min(tree[2 * k + 1]);
        }
        Self { lists, tree }
    }

    fn cheapest_of(list: &[Step]) -> Step {
        list.iter().fold(Self::NONE, |best, step| best.min(*step))
    }

    fn cheapest(&self) -> Option<Step> {
        (self.tree[1] != Self::NONE).then_some(self.tree[1])
    }

    /// Changes the steps of a corner.
    fn change(&mut self, from: u32, change: impl FnOnce(&mut Vec<Step>)) {
        let list = &mut self.lists[from as usize];
        change(list);
        let mut k = self.tree.len() / 2 + from as usize;
        let mut best = Self::cheapest_of(list);
        while self.tree[k] != best {
            self.tree[k] = best;
            if k == 1 {
                break;
            }
            k /= 2;
            best = self.tree[2 * k].min(self.tree[2 * k + 1]);
        }
    }
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
    fn simplified(mut self, mesh: usize) -> Option<Form> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology;
    use lobe_core::oracle::Random;
    use std::collections::BTreeMap;

    /// A wavy sheet, folded so that it meets itself: triangles of 60 by 60 squares.
    fn sheet(random: &mut Random) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        const SIDE: u32 = 60;
        let mut positions = Vec::new();
        let mut triangles = Vec::new();
        for i in 0..=SIDE {
            for k in 0..=SIDE {
                let height = (i as f32 * 0.2).sin() + (k as f32 * 0.15).cos() + random.uniform() as f32 * 0.05;
                positions.push(Vec3::new(i as f32, height, k as f32));
            }
        }
        let corner = |i: u32, k: u32| i * (SIDE + 1) + k;
        for (i, k) in (0..SIDE).flat_map(|i| (0..SIDE).map(move |k| (i, k))) {
            let [a, b, c, d] = [corner(i, k), corner(i + 1, k), corner(i, k + 1), corner(i + 1, k + 1)];
            triangles.extend([[a, b, c], [c, b, d]]);
        }
        // A fin across two patches: edges of three triangles.
        positions.push(Vec3::new(30.0, 9.0, 30.0));
        let top = positions.len() as u32 - 1;
        triangles.extend((0..SIDE).map(|k| [corner(30, k), corner(30, k + 1), top]));
        (positions, triangles)
    }

    /// Steps of few costs, which change at random.
    #[test]
    fn the_cheapest_step_is_the_least_of_all() {
        let mut random = Random::new(6);
        for count in [0, 1, 2, 37] {
            let mut number = |below: usize| (random.uniform() * below as f64) as u32;
            let mut propose = |from: usize| -> Vec<Step> {
                (0..number(5)).map(|at| Step::new(f64::from(number(9)), from as u32, number(count), at)).collect()
            };
            let mut lists: Vec<Vec<Step>> = (0..count).map(&mut propose).collect();
            let mut steps = Steps::new(lists.clone());
            for k in 0..200_usize {
                let least = lists.iter().flatten().min().copied();
                assert_eq!(steps.cheapest().map(Step::parts), least.map(Step::parts));
                let Some(from) = (7 * k).checked_rem(count) else { continue };
                lists[from] = propose(from);
                steps.change(from as u32, |list| list.clone_from(&lists[from]));
            }
        }
        assert_eq!(Step::new(0.5, (1 << 21) - 1, 5, (1 << 22) - 1).parts(), [(1 << 21) - 1, 5, (1 << 22) - 1]);
        assert!(
            Step::new(0.5, 9, 9, 9) < Step::new(0.75, 0, 0, 0) && Step::new(0.5, 1, 9, 9) < Step::new(0.5, 2, 0, 0)
        );
    }

    /// For any choice of forms, and on any side of each triangle, all outlines are closed.
    #[test]
    fn any_forms_go_together() {
        let mut random = Random::new(3);
        let (positions, mut triangles) = sheet(&mut random);
        topology::oriented(&mut triangles);
        let fine = triangles.len();
        let coarse = coarse(&positions, &triangles).expect("a large mesh");
        assert!(coarse.count > 1 && coarse.triangles.len() * 3 < fine);
        triangles.extend(coarse.triangles);
        let patches = [coarse.patches, coarse.triangle_patches].concat();
        let edges = topology::tagged_edges(&triangles, fine as u32, &patches);
        for _ in 0..20 {
            let forms: Vec<bool> = (0..coarse.count).map(|_| random.uniform() < 0.5).collect();
            let side: Vec<i32> = (0..triangles.len()).map(|_| (random.uniform() * 3.0) as i32 - 1).collect();
            let mut ends = BTreeMap::new();
            let mut drawn = 0;
            for (edge, tag) in &edges {
                if tag.patches().all(|(patch, is_coarse)| forms[usize::from(patch)] == is_coarse) {
                    let step = side[edge.triangle() as usize] - edge.other().map_or(0, |t| side[t as usize]);
                    let [from, to] = edge.ends().map(|k| triangles[edge.triangle() as usize][k]);
                    *ends.entry(from).or_insert(0) -= step;
                    *ends.entry(to).or_insert(0) += step;
                    drawn += edge.triangles().count();
                }
            }
            assert!(ends.values().all(|sum| *sum == 0));
            // Each side of each triangle occurs once.
            let is_chosen = |t: &usize| patches[*t] == WHOLE || forms[usize::from(patches[*t])] == (*t >= fine);
            assert_eq!(drawn, 3 * (0..triangles.len()).filter(is_chosen).count());
        }
    }
}
