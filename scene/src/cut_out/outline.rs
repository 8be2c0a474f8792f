//! Outlines of the part of a triangle that is left, with no more corners than they need.

use foldhash::fast::RandomState;
use glam::DVec2;
use std::collections::HashSet;

/// With numbers of vertices as keys.
pub(super) type HashMap<K, V> = std::collections::HashMap<K, V, RandomState>;

/// The numbers of the vertices made between two others: in the middle of them, or where alpha's line crosses.
pub(super) type Made = HashMap<(u32, u32, bool), u32>;

/// Vertices of a chain that are looked at together: the time of a chain goes with this number at worst.
const LONGEST_CHAIN: usize = 256;

/// A corner of a loop: a vertex that exists and must stay, or a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Corner {
    pub(super) place: DVec2,
    pub(super) vertex: Option<u32>,
}

/// A triangle, and the pieces of it that alpha has left.
pub(super) struct Pieces<'a> {
    pub(super) triangle: [u32; 3],
    pub(super) pieces: &'a [[u32; 3]],
    pub(super) made: &'a Made,
    /// The two vertices that each made one is between.
    pub(super) parents: &'a HashMap<u32, [u32; 2]>,
    /// Places of the vertices in texels.
    pub(super) place: &'a dyn Fn(u32) -> DVec2,
}

/// A closed line, with what is left on its left if the triangle turns to the left.
#[derive(Debug)]
pub(super) struct Loop {
    /// All vertices.
    pub(super) full: Vec<Corner>,
    /// Within the tolerance of it.
    pub(super) simple: Vec<Corner>,
}

impl Pieces<'_> {
    /// The outlines, simplified by up to `tolerance` texels. Vertices on the triangle's sides stay where an outline ends at them, and go
    /// where they lie between two such, so that neighbours meet. `None` where the pieces do not fit together.
    pub(super) fn outlines(&self, tolerance: f64) -> Option<Vec<Loop>> {
        let mut sides = Sides { all: self, known: HashMap::default() };
        let mut outlines = Vec::new();
        for mut line in self.loops()? {
            let stays = sides.ends(&mut line);
            // Less is a speck.
            if line.len() < 3 {
                continue;
            }
            let full: Vec<_> = line.iter().map(|v| Corner { place: (self.place)(*v), vertex: Some(*v) }).collect();
            let vertex =
                |(corner, stays): (&Corner, bool)| Corner { vertex: corner.vertex.filter(|_| stays), ..*corner };
            let marked: Vec<_> = full.iter().zip(stays).map(vertex).collect();
            outlines.push(Loop { simple: simplified(&marked, tolerance), full });
        }
        Some(outlines)
    }

    /// The edges that only one piece has, as closed lines. Pieces of other sizes have parts of each other's edges: so of the shortest.
    fn loops(&self) -> Option<Vec<Vec<u32>>> {
        let mut edges = Vec::new();
        for [a, b, c] in self.pieces {
            [(a, b), (b, c), (c, a)].into_iter().for_each(|(p, q)| self.shortest(*p, *q, &mut edges));
        }
        let all: HashSet<_, RandomState> = edges.iter().copied().collect();
        edges.retain(|(p, q)| !all.contains(&(*q, *p)));
        let mut next: HashMap<u32, Vec<u32>> = HashMap::default();
        edges.iter().for_each(|(p, q)| next.entry(*p).or_default().push(*q));
        let mut loops = Vec::new();
        for (first, _) in edges {
            let Some(second) = next.get_mut(&first).and_then(Vec::pop) else { continue };
            let mut line = vec![first];
            let mut here = second;
            while here != first {
                let from = line[line.len() - 1];
                line.push(here);
                here = self.turn(from, here, next.get_mut(&here)?)?;
            }
            loops.push(line);
        }
        Some(loops)
    }

    fn shortest(&self, p: u32, q: u32, out: &mut Vec<(u32, u32)>) {
        match self.made.get(&(p.min(q), p.max(q), true)) {
            Some(middle) => {
                self.shortest(p, *middle, out);
                self.shortest(*middle, q, out);
            }
            None => out.push((p, q)),
        }
    }

    /// Takes the next vertex. Where lines touch, the one that turns most to the left stays with the same part.
    fn turn(&self, from: u32, here: u32, next: &mut Vec<u32>) -> Option<u32> {
        if next.len() < 2 {
            return next.pop();
        }
        let place = |v| (self.place)(v);
        let along = place(here) - place(from);
        let turn = |v: u32| along.perp_dot(place(v) - place(here)).atan2(along.dot(place(v) - place(here)));
        let most = (0..next.len()).max_by(|i, j| turn(next[*i]).total_cmp(&turn(next[*j])))?;
        Some(next.swap_remove(most))
    }
}

/// On which of the triangle's sides vertices lie.
struct Sides<'a> {
    all: &'a Pieces<'a>,
    known: HashMap<u32, u8>,
}

impl Sides<'_> {
    /// A bit for each side.
    fn of(&mut self, vertex: u32) -> u8 {
        if let Some(k) = self.all.triangle.iter().position(|v| *v == vertex) {
            return [0b101, 0b011, 0b110][k];
        }
        if let Some(known) = self.known.get(&vertex) {
            return *known;
        }
        let sides = self.all.parents.get(&vertex).map_or(0, |[a, b]| self.of(*a) & self.of(*b));
        self.known.insert(vertex, sides);
        sides
    }

    /// Takes those vertices of a line away that lie between two others on one side of the triangle, and says which of the others lie on
    /// sides.
    fn ends(&mut self, line: &mut Vec<u32>) -> Vec<bool> {
        let sides: Vec<u8> = line.iter().map(|v| self.of(*v)).collect();
        let n = line.len();
        let is_between = |k: usize| sides[(k + n - 1) % n] & sides[k] & sides[(k + 1) % n] != 0;
        let stays: Vec<usize> = (0..n).filter(|k| self.all.triangle.contains(&line[*k]) || !is_between(*k)).collect();
        *line = stays.iter().map(|k| line[*k]).collect();
        stays.iter().map(|k| sides[*k] != 0).collect()
    }
}

/// A closed line with fewer corners, at most `tolerance` away from it. Between those that must stay they move so that the area stays
/// the same.
fn simplified(line: &[Corner], tolerance: f64) -> Vec<Corner> {
    let n = line.len();
    let farthest = |from: usize| {
        let distance = |k: &usize| line[*k].place.distance_squared(line[from].place);
        (0..n).max_by(|i, j| distance(i).total_cmp(&distance(j))).unwrap_or(0)
    };
    // Chains begin and end at corners that stay, or at two that are far from each other.
    let first = line.iter().position(|corner| corner.vertex.is_some()).unwrap_or_else(|| farthest(0));
    let place = |k: usize| line[(first + k) % n].place;
    let stays = |k: usize| line[(first + k) % n].vertex.is_some();
    let opposite = (farthest(first) + n - first) % n;
    let is_free = !(0..n).any(stays);
    let mut kept = vec![0];
    let mut since = 0;
    for k in 1..=n {
        if stays(k) || k == n || is_free && k == opposite || k - since == LONGEST_CHAIN {
            let known = kept.len();
            fewest(&place, since, k, tolerance, &mut kept);
            // A chord whose ends both stay cannot move.
            if kept.len() == known + 1 && stays(since) && stays(k) {
                kept.truncate(known);
                fewest(&place, since, k, 0.2 * tolerance, &mut kept);
            }
            since = k;
        }
    }
    kept.pop();
    let chords = Chords { place: &place, kept: &kept, n, tolerance };
    let corner = |j: usize| {
        let vertex = line[(first + kept[j]) % n].vertex;
        Corner { place: if vertex.is_some() { place(kept[j]) } else { chords.same_area(j, &stays) }, vertex }
    };
    (0..kept.len()).map(corner).collect()
}

/// The corners after `from` up to `to` that a line within the tolerance needs.
fn fewest(place: &impl Fn(usize) -> DVec2, from: usize, to: usize, tolerance: f64, out: &mut Vec<usize>) {
    let (a, b) = (place(from), place(to));
    let distance = |k: usize| {
        let along = b - a;
        let t = ((place(k) - a).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        place(k).distance_squared(a + t * along)
    };
    let farthest = (from + 1..to).map(|k| (distance(k), k)).max_by(|x, y| x.0.total_cmp(&y.0));
    match farthest {
        Some((far, k)) if far > tolerance * tolerance => {
            fewest(place, from, k, tolerance, out);
            fewest(place, k, to, tolerance, out);
        }
        _ => out.push(to),
    }
}

/// The lines from each kept corner to the next.
struct Chords<'a, P: Fn(usize) -> DVec2> {
    place: &'a P,
    /// Numbers of corners, from 0 on.
    kept: &'a [usize],
    /// Corners of the whole line.
    n: usize,
    tolerance: f64,
}

impl<P: Fn(usize) -> DVec2> Chords<'_, P> {
    /// The `j`-th chord's ends, both moved to its right until as much lies on one side of it as on the other; where an end stays, the other
    /// one twice as far.
    fn moved(&self, j: usize, stays: &impl Fn(usize) -> bool) -> [DVec2; 2] {
        let (from, to) = (self.kept[j], self.kept.get(j + 1).copied().unwrap_or(self.n));
        let (a, b) = ((self.place)(from), (self.place)(to));
        let doubled: f64 = (from..to).map(|k| ((self.place)(k) - a).perp_dot((self.place)(k + 1) - a)).sum();
        let along = b - a;
        let out = -along.perp() * (0.5 * doubled / along.length_squared());
        let out = if out.is_finite() { out.clamp_length_max(self.tolerance) } else { DVec2::ZERO };
        match [stays(from), stays(to)] {
            [false, false] => [a + out, b + out],
            [true, false] => [a, b + 2.0 * out],
            [false, true] => [a + 2.0 * out, b],
            [true, true] => [a, b],
        }
    }

    /// Where the chords before and after the `j`-th kept corner meet once they have moved; between their ends where that is far from it.
    fn same_area(&self, j: usize, stays: &impl Fn(usize) -> bool) -> DVec2 {
        let before = self.moved((j + self.kept.len() - 1) % self.kept.len(), stays);
        let after = self.moved(j, stays);
        let (d, e) = (before[1] - before[0], after[1] - after[0]);
        let t = (after[0] - before[0]).perp_dot(e) / d.perp_dot(e);
        let (own, met) = ((self.place)(self.kept[j]), before[0] + t * d);
        if met.distance(own) <= 3.0 * self.tolerance { met } else { 0.5 * (before[1] + after[0]) }
    }
}
