//! Halves edges by the surface area heuristic until they fit into leaves.

use crate::tree::WIDE;
use glam::{Vec3, Vec4};

/// The most edges that are sorted for the best cut; more edges are put into bins.
const SORTED: usize = 256;
const BINS: usize = 32;
/// Parts with more edges than this are halved on all threads.
const PARALLEL: usize = 1 << 14;
/// Parts below this number of others are halved in the middle: the best cuts through edges that meet in one point take a leaf at a time.
const DEEPEST: u32 = 48;

/// The halves of a part of the edges.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Halves {
    /// Half the areas of their boxes.
    pub(crate) areas: [f32; 2],
    /// The leaves with which the second halves of the halves begin; 0 for a half that fits into a leaf.
    pub(crate) middles: [u32; 2],
}

/// Edges that are halved until they fit into leaves. All leaves but the last are full, so a second half begins with a leaf, by whose
/// number it is known.
#[derive(Debug)]
pub(crate) struct Halving {
    /// By the first leaf of the second half.
    pub(crate) halves: Vec<Halves>,
    /// The first leaf of the second half of all edges, or 0.
    pub(crate) root: u32,
    /// The edges in the order of the leaves.
    pub(crate) order: Vec<u32>,
}

impl Halving {
    /// Halves edges with these boxes (low, high). It does not depend on the number of threads.
    ///
    /// J. Goldsmith, J. Salmon, *Automatic Creation of Object Hierarchies for Ray Tracing*, 1987; costs are counted in leaves.
    pub(crate) fn new(boxes: impl IntoIterator<Item = [Vec3; 2]>) -> Self {
        let mut items: Vec<Item> = (0..).zip(boxes).map(|(number, bounds)| Item::new(number, bounds)).collect();
        let mut halves = vec![Halves::default(); items.len().div_ceil(WIDE)];
        let mut spare = if items.len() > SORTED { items.clone() } else { Vec::new() };
        let around = Around::of(&items);
        let root = halve(&mut items, &mut spare, (&mut halves, 0), &around, 0);
        Self { halves, root, order: items.iter().map(Item::number).collect() }
    }
}

/// The most edges of a leaf, or of a node with eight leaves: parts of larger ones are multiples of it, because full nodes are fewer.
pub(crate) fn unit(count: usize) -> usize {
    if count > WIDE * WIDE { WIDE * WIDE } else { WIDE }
}

/// The box of an edge with the edge's number in the fourth numbers, 16 bits in each: all of it moves at once.
#[derive(Clone, Copy, Default)]
struct Item {
    low: Vec4,
    high: Vec4,
}

impl Item {
    fn new(number: u32, [low, high]: [Vec3; 2]) -> Self {
        // Numbers from 1 to 1.01, with which arithmetic is as fast as with others.
        let half = |bits: u32| f32::from_bits(1.0_f32.to_bits() | bits);
        Self { low: low.extend(half(number & 0xffff)), high: high.extend(half(number >> 16)) }
    }

    fn number(&self) -> u32 {
        self.low.w.to_bits() & 0xffff | self.high.w.to_bits() << 16
    }

    /// Twice the box's middle; the fourth number means nothing.
    fn middle(&self) -> Vec4 {
        self.low + self.high
    }

    /// The place of the middle along an axis, as whole numbers in the order of `f32::total_cmp`; equal ones by their edges.
    fn key(&self, axis: usize) -> u64 {
        u64::from(ordered(self.middle()[axis])) << 32 | u64::from(self.number())
    }
}

fn ordered(x: f32) -> u32 {
    let bits = x.to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

/// A box whose fourth numbers mean nothing.
#[derive(Clone, Copy)]
struct Bounds {
    low: Vec4,
    high: Vec4,
}

impl Bounds {
    const NONE: Self = Self { low: Vec4::INFINITY, high: Vec4::NEG_INFINITY };

    fn join(&mut self, low: Vec4, high: Vec4) {
        (self.low, self.high) = (self.low.min(low), self.high.max(high));
    }

    /// The axis along which it is longest.
    fn longest(&self) -> usize {
        (self.high - self.low).truncate().max_position()
    }

    fn half_area(&self) -> f32 {
        let side = (self.high - self.low).max(Vec4::ZERO);
        side.x * side.y + side.y * side.z + side.z * side.x
    }
}

/// The boxes around some edges and around twice their middles.
struct Around {
    edges: Bounds,
    middles: Bounds,
}

impl Around {
    fn of(items: &[Item]) -> Self {
        let mut around = Self { edges: Bounds::NONE, middles: Bounds::NONE };
        for item in items {
            around.edges.join(item.low, item.high);
            around.middles.join(item.middle(), item.middle());
        }
        around
    }
}

/// The leaves that `count` edges fill.
fn leaves(count: usize) -> f32 {
    count.div_ceil(WIDE) as f32
}

/// A way to halve edges: the size of the first half along an axis.
struct Cut {
    cost: f32,
    axis: usize,
    count: usize,
}

impl Cut {
    const NONE: Self = Self { cost: f32::INFINITY, axis: 0, count: 0 };

    /// Whether another one is better, which it becomes then.
    fn improves(&mut self, cost: f32, axis: usize, count: usize) -> bool {
        let is_better = cost < self.cost;
        if is_better {
            *self = Self { cost, axis, count };
        }
        is_better
    }

    /// The size of the first half of so many edges: leaves are full.
    fn size(&self, of: usize) -> usize {
        let unit = unit(of);
        let count = if self.cost.is_finite() { self.count } else { of / 2 };
        ((count + unit / 2) / unit * unit).clamp(unit, (of - 1) / unit * unit)
    }
}

/// Halves edges and their halves; `spare` is memory for as many. `halves` begins with the edges' first leaf, whose number is given. Returns
/// the first leaf of the second half, or 0 for edges that fit into a leaf.
///
/// Edges that are too many to be sorted keep their order within the halves: by number.
fn halve(
    items: &mut [Item],
    spare: &mut [Item],
    (halves, first): (&mut [Halves], u32),
    around: &Around,
    depth: u32,
) -> u32 {
    if items.len() <= SORTED {
        return Sorted::halve(items, halves, first);
    }
    let bins = Bins::new(items, &around.middles);
    let cut = if depth < DEEPEST { bins.best() } else { Cut { axis: around.middles.longest(), ..Cut::NONE } };
    let count = cut.size(items.len());
    let is_whole = bins.part(items, spare, &cut, count);
    if !is_whole {
        // Middles that are no numbers lie in bins at random.
        let mut keys: Vec<u64> = items.iter().map(|item| item.key(cut.axis)).collect();
        let limit = *keys.select_nth_unstable(count).1;
        part(items, spare, |item| item.key(cut.axis) < limit);
    }
    let (low, high) = items.split_at_mut(count);
    let (low_spare, high_spare) = spare.split_at_mut(count);
    let leaf = count / WIDE;
    let middle = first + leaf as u32;
    let around = [Around::of(low), Around::of(high)];
    let areas = [0, 1].map(|k| around[k].edges.half_area());
    let (low_halves, high_halves) = halves.split_at_mut(leaf);
    let middles = both(
        low.len().min(high.len()) > PARALLEL,
        || halve(low, low_spare, (low_halves, first), &around[0], depth + 1),
        || halve(high, high_spare, (high_halves, middle), &around[1], depth + 1),
    );
    // The second half does not use its first place.
    halves[leaf] = Halves { areas, middles };
    middle
}

/// The results of two functions, on two threads if they are large.
fn both<T: Send>(are_large: bool, one: impl FnOnce() -> T + Send, other: impl FnOnce() -> T + Send) -> [T; 2] {
    if are_large { rayon::join(one, other).into() } else { [one(), other()] }
}

/// Moves the items that `is_low` holds for to the front; all keep their order. Returns their number.
fn part<T: Copy>(items: &mut [T], spare: &mut [T], is_low: impl Fn(&T) -> bool) -> usize {
    let (mut low, mut high) = (0, 0);
    for k in 0..items.len() {
        // Both, without a branch that cannot be predicted.
        let item = items[k];
        (items[low], spare[high]) = (item, item);
        let is_low = usize::from(is_low(&item));
        low += is_low;
        high += 1 - is_low;
    }
    items[low..].copy_from_slice(&spare[..high]);
    low
}

/// Bins of equal width along each axis: the boxes around their edges and how many these are.
struct Bins {
    low: Vec4,
    /// Bins a unit; 0 along an axis along which all middles are the same.
    scale: Vec4,
    boxes: [[Bounds; BINS]; 3],
    counts: [[u32; BINS]; 3],
}

impl Bins {
    fn new(items: &[Item], middles: &Bounds) -> Self {
        let size = (middles.high - middles.low).to_array();
        let [x, y, z] = [0, 1, 2].map(|k| if size[k] > 0.0 { BINS as f32 / size[k] } else { 0.0 });
        let mut bins = Self {
            low: middles.low,
            scale: Vec4::new(x, y, z, 0.0),
            boxes: [[Bounds::NONE; BINS]; 3],
            counts: [[0; BINS]; 3],
        };
        for item in items {
            let places = bins.places(item);
            for ((boxes, counts), place) in bins.boxes.iter_mut().zip(&mut bins.counts).zip(places) {
                boxes[place].join(item.low, item.high);
                counts[place] += 1;
            }
        }
        bins
    }

    fn places(&self, item: &Item) -> [usize; 3] {
        let [x, y, z, _] = ((item.middle() - self.low) * self.scale).to_array();
        [x, y, z].map(Self::place)
    }

    fn place(scaled: f32) -> usize {
        (scaled as usize).min(BINS - 1)
    }

    /// The best cut between two bins.
    fn best(&self) -> Cut {
        let mut best = Cut::NONE;
        for axis in (0..3).filter(|axis| self.scale[*axis] > 0.0) {
            let (boxes, counts) = (&self.boxes[axis], &self.counts[axis]);
            let mut after = [0.0; BINS];
            let (mut bounds, mut count) = (Bounds::NONE, 0);
            for k in (1..BINS).rev() {
                bounds.join(boxes[k].low, boxes[k].high);
                count += counts[k] as usize;
                after[k] = if count > 0 { bounds.half_area() * leaves(count) } else { f32::INFINITY };
            }
            (bounds, count) = (Bounds::NONE, 0);
            for k in 1..BINS {
                bounds.join(boxes[k - 1].low, boxes[k - 1].high);
                count += counts[k - 1] as usize;
                if count > 0 {
                    best.improves(bounds.half_area() * leaves(count) + after[k], axis, count);
                }
            }
        }
        best
    }

    /// Moves the first `count` edges along the cut's axis to the front. Returns whether these are so many.
    fn part(&self, items: &mut [Item], spare: &mut [Item], cut: &Cut, count: usize) -> bool {
        let axis = cut.axis;
        // The bin of the first edge behind the cut, and the edges in the bins before it.
        let (mut bin, mut before) = (0, 0);
        while bin < BINS - 1 && before + self.counts[axis][bin] as usize <= count {
            before += self.counts[axis][bin] as usize;
            bin += 1;
        }
        let (low, scale) = (self.low[axis], self.scale[axis]);
        let within = items.iter().filter(|item| Self::place((item.middle()[axis] - low) * scale) == bin);
        let mut keys: Vec<u64> = within.map(|item| item.key(axis)).collect();
        if count - before >= keys.len() {
            return false;
        }
        let limit = *keys.select_nth_unstable(count - before).1;
        part(items, spare, |item| item.key(axis) < limit) == count
    }
}

/// Few edges, sorted once along each axis.
struct Sorted {
    items: [Item; SORTED],
    /// Places in `items`.
    orders: [[u8; SORTED]; 3],
}

impl Sorted {
    /// As [`halve`] for edges in the order of their numbers. They come out in the order of their leaves, and along x in these.
    fn halve(items: &mut [Item], halves: &mut [Halves], first: u32) -> u32 {
        if items.len() <= WIDE {
            return 0;
        }
        let count = items.len();
        let mut sorted = Self { items: [Item::default(); SORTED], orders: [[0; SORTED]; 3] };
        sorted.items[..count].copy_from_slice(items);
        let mut keys = [0; SORTED];
        for (axis, order) in sorted.orders.iter_mut().enumerate() {
            let keys = &mut keys[..count];
            for ((key, item), place) in keys.iter_mut().zip(&*items).zip(0..) {
                *key = u64::from(ordered(item.middle()[axis])) << 32 | place;
            }
            keys.sort_unstable();
            order.iter_mut().zip(keys).for_each(|(place, key)| *place = *key as u8);
        }
        let root = sorted.part([0, count], halves, first);
        for (item, place) in items.iter_mut().zip(sorted.orders[0]) {
            *item = sorted.items[usize::from(place)];
        }
        root
    }

    fn part(&mut self, [begin, end]: [usize; 2], halves: &mut [Halves], first: u32) -> u32 {
        let of = end - begin;
        if of <= WIDE {
            return 0;
        }
        let (cut, areas) = self.best([begin, end]);
        let count = cut.size(of);
        let mut is_low = [false; SORTED];
        self.orders[cut.axis][begin..begin + count].iter().for_each(|place| is_low[usize::from(*place)] = true);
        for axis in (0..3).filter(|axis| *axis != cut.axis) {
            part(&mut self.orders[axis][begin..end], &mut [0; SORTED], |place| is_low[usize::from(*place)]);
        }
        let (leaf, middle) = (count / WIDE, begin + count);
        let areas = if cut.cost.is_finite() { areas } else { self.areas([begin, middle, end]) };
        let (low_halves, high_halves) = halves.split_at_mut(leaf);
        let middles =
            [self.part([begin, middle], low_halves, first), self.part([middle, end], high_halves, first + leaf as u32)];
        halves[leaf] = Halves { areas, middles };
        first + leaf as u32
    }

    /// The best cut behind any multiple of [`unit`], and half the areas of the boxes of both sides.
    fn best(&self, [begin, end]: [usize; 2]) -> (Cut, [f32; 2]) {
        let (of, unit) = (end - begin, unit(end - begin));
        let (mut best, mut areas) = (Cut::NONE, [0.0; 2]);
        for (axis, order) in self.orders.iter().enumerate() {
            let order = &order[begin..end];
            let item = |k: usize| &self.items[usize::from(order[k])];
            if item(of - 1).middle()[axis] - item(0).middle()[axis] <= 0.0 {
                continue;
            }
            // Of the edges from each multiple of the unit on.
            let mut after = [0.0; SORTED / WIDE];
            let mut bounds = Bounds::NONE;
            for first in (unit..of).step_by(unit).rev() {
                (first..of.min(first + unit)).map(item).for_each(|item| bounds.join(item.low, item.high));
                after[first / WIDE] = bounds.half_area();
            }
            bounds = Bounds::NONE;
            for count in (unit..of).step_by(unit) {
                (count - unit..count).map(item).for_each(|item| bounds.join(item.low, item.high));
                let both = [bounds.half_area(), after[count / WIDE]];
                let cost = both[0] * leaves(count) + both[1] * leaves(of - count);
                if best.improves(cost, axis, count) {
                    areas = both;
                }
            }
        }
        (best, areas)
    }

    /// Half the areas of the boxes around the edges from each place to the next.
    fn areas(&self, [begin, middle, end]: [usize; 3]) -> [f32; 2] {
        [begin..middle, middle..end].map(|range| {
            let mut bounds = Bounds::NONE;
            let places = self.orders[0][range].iter();
            places.map(|place| self.items[usize::from(*place)]).for_each(|item| bounds.join(item.low, item.high));
            bounds.half_area()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::ops::Range;
    use lobe_core::oracle::Random;

    type Boxes = Vec<[Vec3; 2]>;

    fn half_area(boxes: impl Iterator<Item = [Vec3; 2]>) -> f32 {
        let none = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        let [low, high] = boxes.fold(none, |a, b| [a[0].min(b[0]), a[1].max(b[1])]);
        let side = (high - low).max(Vec3::ZERO);
        side.x * side.y + side.y * side.z + side.z * side.x
    }

    /// The first half by the definition: all cuts along all axes, each with sums of its own.
    fn first_half(boxes: &Boxes, edges: &[u32]) -> Vec<u32> {
        let middle = |e: u32| boxes[e as usize][0] + boxes[e as usize][1];
        let (of, unit) = (edges.len(), unit(edges.len()));
        let mut best = (f32::INFINITY, 0, of / 2);
        let along = |axis: usize| {
            let mut order = edges.to_vec();
            order.sort_by(|a, b| middle(*a)[axis].total_cmp(&middle(*b)[axis]).then(a.cmp(b)));
            order
        };
        for axis in 0..3 {
            let order = along(axis);
            let [low, high] = [order[0], order[of - 1]].map(|e| middle(e)[axis]);
            if low == high {
                continue;
            }
            let bin = |e: u32| (((middle(e)[axis] - low) * (BINS as f32 / (high - low))) as usize).min(BINS - 1);
            let sizes: Vec<usize> = match of <= SORTED {
                true => (unit..of).step_by(unit).collect(),
                false => (1..BINS).map(|k| order.iter().filter(|e| bin(**e) < k).count()).collect(),
            };
            for count in sizes.into_iter().filter(|count| *count > 0 && *count < of) {
                let area = |part: &[u32]| half_area(part.iter().map(|e| boxes[*e as usize])) * leaves(part.len());
                let cost = area(&order[..count]) + area(&order[count..]);
                if cost < best.0 {
                    best = (cost, axis, count);
                }
            }
        }
        let count = ((best.2 + unit / 2) / unit * unit).clamp(unit, (of - 1) / unit * unit);
        along(best.1)[..count].to_vec()
    }

    fn check(boxes: &Boxes, halving: &Halving, range: Range<usize>, middle: u32) {
        if range.len() <= WIDE {
            assert_eq!(middle, 0);
            return;
        }
        let at = WIDE * middle as usize;
        let sorted = |edges: &[u32]| {
            let mut edges = edges.to_vec();
            edges.sort_unstable();
            edges
        };
        let halves = [range.start..at, at..range.end];
        let wanted = first_half(boxes, &halving.order[range]);
        assert_eq!(sorted(&halving.order[halves[0].clone()]), sorted(&wanted));
        let Halves { areas, middles } = halving.halves[middle as usize];
        for ((half, area), middle) in halves.into_iter().zip(areas).zip(middles) {
            assert_eq!(half_area(halving.order[half.clone()].iter().map(|e| boxes[*e as usize])), area);
            check(boxes, halving, half, middle);
        }
    }

    /// Edges anywhere, on a coarse grid where many middles are equal, in one plane, and all in one place.
    #[test]
    fn halves_are_those_of_the_definition() {
        let mut random = Random::new(8);
        for count in [1, 7, 8, 9, 64, 65, 256, 257, 600, 5000] {
            for kind in 0..4 {
                let mut number = || random.uniform() as f32 - 0.4;
                let mut corner = || match kind {
                    0 => Vec3::new(number(), number(), number()),
                    1 => (4.0 * Vec3::new(number(), number(), 3.0 * number())).round(),
                    2 => Vec3::new(number(), -0.0, number()),
                    _ => Vec3::ONE,
                };
                let boxes: Boxes =
                    (0..count).map(|_| [corner(), corner()]).map(|[p, q]| [p, p + 0.3 * q.abs()]).collect();
                let halving = Halving::new(boxes.iter().copied());
                check(&boxes, &halving, 0..count, halving.root);
            }
        }
    }

    /// The best cuts through edges from one point to a line take a leaf each: as deep as there are leaves, which no stack has room for.
    #[test]
    fn a_fan_is_no_chain() {
        let boxes = (0..200_000).map(|i| [Vec3::ZERO, Vec3::new(1.0, 1e-5 * i as f32, 0.0)]);
        let depth = crate::tree::Tree::new(boxes, 0).0.depth();
        assert!(depth < 100, "{depth}");
    }

    /// Large parts are halved on several threads.
    #[test]
    fn no_edge_is_lost() {
        let mut random = Random::new(9);
        let mut corner = || Vec3::from_array(core::array::from_fn(|_| random.uniform() as f32));
        let mut boxes: Boxes = (0..100_000).map(|_| [corner(), corner()]).map(|[p, q]| [p, p + q]).collect();
        for has_nan in [false, true] {
            if has_nan {
                boxes.iter_mut().step_by(3).for_each(|b| b[0].x = f32::NAN);
                boxes[7] = [Vec3::INFINITY, Vec3::NEG_INFINITY];
            }
            let mut order = Halving::new(boxes.iter().copied()).order;
            order.sort_unstable();
            assert!(order.iter().zip(0..100_000).all(|(a, b)| *a == b));
        }
    }
}
