//! Finds the triangles that share an edge.

use core::ops::Range;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// No patch, or a patch without a simplified form.
pub(crate) const WHOLE: u16 = u16::MAX;
/// No triangle on that side of an edge.
pub(crate) const NONE: u32 = u32::MAX >> 1;
/// Marks an edge between two triangles in one plane, which is never a silhouette.
const FLAT: u32 = 1 << 31;

/// An edge by the triangles on its two sides, in 8 bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    /// The first triangle times eight, plus twice the number of the corner at which the edge begins, plus one if the edge runs
    /// down: from a later position of the caller's to an earlier one.
    first: u32,
    /// The triangle that runs the other way, or [`NONE`]; the highest bit is [`FLAT`].
    second: u32,
}

impl Edge {
    /// The side of a triangle, and the triangle on its other side.
    pub(crate) fn new(side: &Side, second: u32) -> Self {
        Self { first: 8 * side.triangle + 2 * side.corner + u32::from(side.down), second }
    }

    pub(crate) fn triangle(self) -> u32 {
        self.first / 8
    }

    pub(crate) fn is_down(self) -> bool {
        self.first % 2 == 1
    }

    /// The triangle that runs the other way, if there is one.
    pub(crate) fn other(self) -> Option<u32> {
        let second = self.second & !FLAT;
        (second != NONE).then_some(second)
    }

    pub(crate) fn triangles(self) -> impl Iterator<Item = u32> {
        [Some(self.triangle()), self.other()].into_iter().flatten()
    }

    /// Replaces the triangles' numbers.
    pub(crate) fn renumber(&mut self, places: &[u32]) {
        self.first = 8 * places[self.triangle() as usize] + self.first % 8;
        self.second = self.other().map_or(NONE, |t| places[t as usize]) | self.second & FLAT;
    }

    /// Its ends as corners of the first triangle, in that triangle's direction.
    pub(crate) fn ends(self) -> [usize; 2] {
        let corner = (self.first / 2 % 4) as usize;
        [corner, (corner + 1) % 3]
    }

    /// A box around it, among these corners and triangles.
    pub(crate) fn bounds(self, corners: &[Vec3], triangles: &[[u32; 3]]) -> [Vec3; 2] {
        let [a, b] = self.ends().map(|k| corners[triangles[self.triangle() as usize][k] as usize]);
        [a.min(b), a.max(b)]
    }

    pub(crate) fn is_flat(self) -> bool {
        self.second & FLAT != 0
    }

    pub(crate) fn set_flat(&mut self, flat: bool) {
        self.second = self.second & !FLAT | if flat { FLAT } else { 0 };
    }
}

/// The normal of a triangle with twice its area as length, in f64.
pub(crate) fn normal([a, b, c]: [Vec3; 3]) -> DVec3 {
    let a = a.as_dvec3();
    (b.as_dvec3() - a).cross(c.as_dvec3() - a)
}

/// Gives equal positions one number. Returns the positions, and for each original one its number.
pub(crate) fn weld(positions: &[Vec3]) -> (Vec<Vec3>, Vec<u32>) {
    // Equal ones become neighbours, the first in front. Adding zero makes −0 equal to 0.
    let key = |(p, number): (&Vec3, u32)| {
        let [x, y, z] = (*p + Vec3::ZERO).to_array().map(|x| u128::from(x.to_bits()));
        x << 96 | y << 64 | z << 32 | u128::from(number)
    };
    let mut keys: Vec<u128> = positions.iter().zip(0..).map(key).collect();
    keys.par_sort_unstable();
    let mut numbers = vec![0; positions.len()];
    for group in keys.chunk_by(|a, b| a >> 32 == b >> 32) {
        group.iter().for_each(|key| numbers[*key as u32 as usize] = group[0] as u32);
    }
    // From the first of each group to a number in their order.
    let mut welded = Vec::new();
    for place in 0..positions.len() {
        numbers[place] = if numbers[place] == place as u32 {
            welded.push(positions[place]);
            welded.len() as u32 - 1
        } else {
            numbers[numbers[place] as usize]
        };
    }
    (welded, numbers)
}

/// New numbers for `count` items, in the order of their first use; unused items come last.
pub(crate) fn by_first_use(count: usize, uses: impl Iterator<Item = u32>) -> Vec<u32> {
    let (mut places, mut next) = (vec![u32::MAX; count], 0);
    for used in uses.chain(0..count as u32) {
        if places[used as usize] == u32::MAX {
            places[used as usize] = next;
            next += 1;
        }
    }
    places
}

/// Items in the order of their new numbers.
pub(crate) fn placed<T: Copy>(things: &[T], places: &[u32]) -> Vec<T> {
    let mut out = things.to_vec();
    for (thing, place) in things.iter().zip(places) {
        out[*place as usize] = *thing;
    }
    out
}

/// One side of a triangle: its two ends, lower number first, then its identity.
#[derive(Clone, Copy)]
pub(crate) struct Side {
    ends: (u32, u32),
    /// Runs from the higher number to the lower.
    down: bool,
    triangle: u32,
    corner: u32,
}

impl Side {
    pub(crate) fn ends(&self) -> (u32, u32) {
        self.ends
    }

    pub(crate) fn is_down(&self) -> bool {
        self.down
    }

    pub(crate) fn triangle(&self) -> u32 {
        self.triangle
    }

    /// By its first end and its key.
    fn of(first: u32, key: u64) -> Self {
        let ends = (first, (key >> 32) as u32);
        let low = key as u32;
        Self { ends, down: low >> 31 == 1, triangle: (low & !(1 << 31)) / 4, corner: low % 4 }
    }
}

/// The sides of all triangles in the order of their ends, 8 bytes each.
#[derive(Debug)]
pub(crate) struct Sides {
    /// For each corner the first of the sides that have it as their first end, and the number of all.
    firsts: Vec<u32>,
    /// The rest of each side: its second end in the highest 32 bits, then whether it runs down, its triangle and its corner, so that keys
    /// have the order of sides.
    keys: Vec<u64>,
}

/// First ends whose sides one thread sorts and pairs at once.
const ENDS: usize = 1 << 13;

impl Sides {
    /// By the first end by counting, then the few of each by comparison.
    ///
    /// # Panics
    /// For more than 2²⁹ triangles.
    pub(crate) fn of(triangles: &[[u32; 3]]) -> Self {
        assert!(triangles.len() <= 1 << 29, "too many triangles for one mesh: {}", triangles.len());
        let count = triangles.iter().flatten().max().map_or(0, |last| *last as usize + 1);
        let ends = |corners: &[u32; 3], k: usize| (corners[k], corners[(k + 1) % 3]);
        let mut firsts = vec![0_u32; count + 1];
        for corners in triangles {
            for (a, b) in [0, 1, 2].map(|k| ends(corners, k)) {
                firsts[a.min(b) as usize + 1] += 1;
            }
        }
        for k in 0..count {
            firsts[k + 1] += firsts[k];
        }
        let mut places = firsts.clone();
        let mut keys = vec![0; 3 * triangles.len()];
        for (number, corners) in (0_u64..).zip(triangles) {
            for corner in 0..3 {
                let (a, b) = ends(corners, corner);
                let place = &mut places[a.min(b) as usize];
                keys[*place as usize] =
                    u64::from(a.max(b)) << 32 | u64::from(a > b) << 31 | number << 2 | corner as u64;
                *place += 1;
            }
        }
        let mut sides = Self { firsts, keys };
        sides.sort();
        sides
    }

    fn sort(&mut self) {
        let mut parts = Vec::new();
        let mut rest = &mut self.keys[..];
        for ends in self.firsts.chunks(ENDS) {
            let next = (parts.len() + 1) * ENDS;
            let last = self.firsts[next.min(self.firsts.len() - 1)];
            let (own, after) = core::mem::take(&mut rest).split_at_mut((last - ends[0]) as usize);
            rest = after;
            parts.push((ends, own));
        }
        parts.into_par_iter().for_each(|(ends, mut keys)| {
            for (k, first) in ends.iter().enumerate() {
                let count = ends.get(k + 1).map_or(keys.len(), |next| (next - first) as usize);
                let (own, after) = core::mem::take(&mut keys).split_at_mut(count);
                own.sort_unstable();
                keys = after;
            }
        });
    }

    /// Ranges of first ends.
    fn ranges(&self) -> impl IndexedParallelIterator<Item = Range<usize>> {
        let count = self.firsts.len() - 1;
        (0..count.div_ceil(ENDS)).into_par_iter().map(move |k| k * ENDS..count.min((k + 1) * ENDS))
    }

    /// Passes on all sides, those with the same ends together.
    pub(crate) fn each(&self, group: impl FnMut(&[Side])) {
        self.each_of(0..self.firsts.len() - 1, group);
    }

    /// The same for sides with a first end in a range.
    fn each_of(&self, ends: Range<usize>, mut group: impl FnMut(&[Side])) {
        let mut sides = Vec::new();
        for first in ends {
            let keys = &self.keys[self.firsts[first] as usize..self.firsts[first + 1] as usize];
            for keys in keys.chunk_by(|a, b| a >> 32 == b >> 32) {
                sides.clear();
                sides.extend(keys.iter().map(|key| Side::of(first as u32, *key)));
                group(&sides);
            }
        }
    }

    /// Everything that sides with the same ends give, in the order of their ends, on all threads.
    pub(crate) fn collect<T: Copy + Send>(&self, group: impl Fn(&[Side], &mut Vec<T>) + Sync) -> Vec<T> {
        let of_range = |ends: Range<usize>| {
            let mut all = Vec::with_capacity((self.firsts[ends.end] - self.firsts[ends.start]) as usize / 2 + 1);
            self.each_of(ends, |sides| group(sides, &mut all));
            all
        };
        let mut parts: Vec<Vec<T>> = self.ranges().map(of_range).collect();
        if parts.len() == 1 { parts.remove(0) } else { parts.concat() }
    }

    /// Whether any sides with the same ends fulfil a condition.
    fn any(&self, test: impl Fn(&[Side]) -> bool + Sync) -> bool {
        self.ranges().any(|ends| {
            let mut any = false;
            self.each_of(ends, |sides| any |= test(sides));
            any
        })
    }
}

/// Turns triangles so that neighbours run in opposite directions along their common edge, wherever possible.
///
/// Visibility does not depend on the winding of a triangle. But two triangles that agree cancel if both face the receiver, and
/// their edge can be left out early.
fn orient(triangles: &mut [[u32; 3]], sides: &Sides) -> bool {
    let agree = |pair: &[Side]| pair.len() != 2 || pair[0].down != pair[1].down;
    if !sides.any(|group| !agree(group)) {
        return false;
    }
    let mut neighbours = vec![[(NONE, false); 3]; triangles.len()];
    sides.each(|group| {
        let [one, other] = group else { return };
        let same = one.down == other.down;
        for (one, other) in [(one, other), (other, one)] {
            neighbours[one.triangle as usize][one.corner as usize] = (other.triangle, same);
        }
    });
    let mut turned: Vec<Option<bool>> = vec![None; triangles.len()];
    let mut stack = Vec::new();
    for start in 0..triangles.len() {
        if turned[start].is_some() {
            continue;
        }
        turned[start] = Some(false);
        stack.push(start);
        while let Some(t) = stack.pop() {
            let is_turned = turned[t] == Some(true);
            for (neighbour, same) in neighbours[t] {
                if neighbour != NONE && turned[neighbour as usize].is_none() {
                    turned[neighbour as usize] = Some(is_turned != same);
                    stack.push(neighbour as usize);
                }
            }
        }
    }
    for (corners, turned) in triangles.iter_mut().zip(turned) {
        if turned == Some(true) {
            corners.swap(1, 2);
        }
    }
    true
}

/// The sides of a mesh whose equal positions have one number, after its triangles are turned.
pub(crate) fn oriented(triangles: &mut [[u32; 3]]) -> Sides {
    let sides = Sides::of(triangles);
    if orient(triangles, &sides) { Sides::of(triangles) } else { sides }
}

/// All edges of a mesh.
///
/// If more than two triangles share an edge, or two run the same way, it occurs more than once.
pub(crate) fn edges(sides: &Sides) -> Vec<Edge> {
    sides.collect(|group, edges| pairs(group, |edge| edges.push(edge)))
}

/// Pairs sides that have the same ends; sides that run up come first.
pub(crate) fn pairs(sides: &[Side], mut push: impl FnMut(Edge)) {
    let (up, down) = sides.split_at(sides.partition_point(|side| !side.down));
    for k in 0..up.len().max(down.len()) {
        match (up.get(k), down.get(k)) {
            (Some(one), other) => push(Edge::new(one, other.map_or(NONE, |o| o.triangle))),
            (None, Some(one)) => push(Edge::new(one, NONE)),
            (None, None) => {}
        }
    }
}

/// The forms of the patches on its two sides for which an edge is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Tag([u16; 2]);

impl Tag {
    /// A patch, and whether its simplified form is meant.
    fn of(patch: u16, is_coarse: bool) -> u16 {
        if patch == WHOLE { 0 } else { 2 * patch + 2 + u16::from(is_coarse) }
    }

    /// The patches, and whether their simplified form is meant. Empty if the edge is always drawn.
    pub(crate) fn patches(self) -> impl Iterator<Item = (u16, bool)> {
        self.0.into_iter().filter(|half| *half != 0).map(|half| ((half - 2) / 2, half % 2 == 1))
    }

    pub(crate) fn is_coarse(self) -> bool {
        self.patches().any(|(_, coarse)| coarse)
    }
}

/// The edges of a mesh and of simplified forms of its patches, with their tags. The first `fine` triangles belong to the mesh;
/// `patches` has the patches of all.
///
/// Any choice of forms is closed: each triangle's sides occur exactly if its form is chosen.
pub(crate) fn tagged_edges(triangles: &[[u32; 3]], fine: u32, patches: &[u16]) -> Vec<(Edge, Tag)> {
    let patch = |side: &Side| patches[side.triangle as usize];
    let half = |side: &Side| Tag::of(patch(side), side.triangle >= fine);
    Sides::of(triangles).collect(|group, edges: &mut Vec<(Edge, Tag)>| {
        // The most frequent kind: inside of one patch and of one of its forms.
        if group.iter().all(|side| half(side) == half(&group[0])) {
            pairs(group, |edge| edges.push((edge, Tag([half(&group[0]), 0]))));
            return;
        }
        // The sides of two patches, if there are two, and those of others.
        let of = |wanted: u16| -> Vec<Side> { group.iter().filter(|s| patch(s) == wanted).copied().collect() };
        let first = of(patch(&group[0]));
        let other = group.iter().map(patch).find(|p| *p != patch(&group[0])).map(of).unwrap_or_default();
        if other.is_empty() {
            let (fine, coarse): (Vec<Side>, Vec<Side>) = group.iter().partition(|side| side.triangle < fine);
            for sides in [fine, coarse] {
                pairs(&sides, |edge| edges.push((edge, Tag([half(&sides[0]), 0]))));
            }
            return;
        }
        // One triangle for each form, on the same side of the edge.
        let is_one = |sides: &[Side]| {
            let forms = if patch(&sides[0]) == WHOLE { 1 } else { 2 };
            let fine = sides.iter().filter(|side| side.triangle < fine).count();
            sides.len() == forms && fine == 1 && sides.iter().all(|side| side.down == sides[0].down)
        };
        let is_pair = first.len() + other.len() == group.len() && first[0].down != other[0].down;
        if is_pair && is_one(&first) && is_one(&other) {
            // One edge for each choice of their forms.
            for (a, b) in first.iter().flat_map(|a| other.iter().map(move |b| (a, b))) {
                let (up, down) = if a.down { (b, a) } else { (a, b) };
                edges.push((Edge::new(up, down.triangle), Tag([half(a), half(b)])));
            }
        } else {
            edges.extend(group.iter().map(|side| (Edge::new(side, NONE), Tag([half(side), 0]))));
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tetrahedron with one triangle turned over has six edges with two triangles each.
    #[test]
    fn triangles_are_turned_to_agree() {
        let mut triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 3, 2]];
        let edges = edges(&oriented(&mut triangles));
        assert_eq!(edges.len(), 6);
        assert!(edges.iter().all(|e| e.other().is_some()));
        for edge in edges {
            let [a, b] = edge.ends().map(|k| triangles[edge.triangle() as usize][k]);
            let other = triangles[edge.other().unwrap() as usize];
            assert!((0..3).any(|k| other[k] == b && other[(k + 1) % 3] == a));
        }
    }

    /// A Möbius strip cannot be turned to agree: one edge occurs twice, with one triangle each.
    #[test]
    fn a_strip_with_a_twist_keeps_all_sides() {
        let n = 5;
        let mut triangles = Vec::new();
        for k in 0..n {
            let [a, b] = [2 * k, 2 * k + 1];
            let [c, d] = if k + 1 < n { [2 * k + 2, 2 * k + 3] } else { [1, 0] };
            triangles.extend([[a, b, c], [c, b, d]]);
        }
        let edges = edges(&oriented(&mut triangles));
        let sides: usize = edges.iter().map(|e| 1 + usize::from(e.other().is_some())).sum();
        assert_eq!(sides, 3 * triangles.len());
        assert_eq!(edges.iter().filter(|e| e.other().is_none()).count(), 2 * n as usize + 2);
    }

    /// In the order of their ends, those that run up first, then by triangle.
    #[test]
    fn sides_come_in_order() {
        let mut random = lobe_core::oracle::Random::new(4);
        let mut corner = |count: u32| (random.uniform() * f64::from(count)) as u32;
        for count in [3, 50, 40_000] {
            let triangles: Vec<[u32; 3]> = (0..30_000).map(|_| [corner(count), corner(count), corner(count)]).collect();
            let mut wanted = Vec::new();
            for (t, corners) in (0_u32..).zip(&triangles) {
                for k in 0..3 {
                    let (a, b) = (corners[k], corners[(k + 1) % 3]);
                    wanted.push((a.min(b), a.max(b), a > b, t, k as u32));
                }
            }
            wanted.sort_unstable();
            let numbers = |side: &Side| (side.ends.0, side.ends.1, side.down, side.triangle, side.corner);
            let sides = Sides::of(&triangles);
            assert!(sides.collect(|group, all| all.extend(group.iter().map(numbers))) == wanted);
            let mut groups = wanted.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1));
            sides.each(|group| assert_eq!(groups.next().map(<[_]>::len), Some(group.len())));
            assert!(groups.next().is_none());
        }
        assert!(Sides::of(&[]).collect(|group, all| all.push(group.len())).is_empty());
    }

    #[test]
    fn equal_positions_have_one_number() {
        let (welded, numbers) = weld(&[Vec3::ZERO, Vec3::X, Vec3::new(-0.0, 0.0, -0.0), Vec3::X]);
        assert_eq!((welded.len(), numbers), (2, vec![0, 1, 0, 1]));
    }
}
