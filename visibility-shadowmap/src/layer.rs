//! One depth layer of a face and its pyramid.

use glam::Vec4;
use rayon::prelude::*;

/// The q of a texel without a surface.
pub(crate) const EMPTY: f32 = f32::NEG_INFINITY;

/// Neighbours belong to one surface if their depths differ by less than this many texel sizes. Measured: values of 3…6 give nearly
/// the same, minimal error.
const KAPPA: f32 = 4.0;

/// Two steps in a line belong to one steep surface if they differ by less than this factor. The last two steps before a sphere's
/// outline differ by 2.41 at most.
const LIKE: f32 = 2.5;

/// Marks nodes whose texels' corners are means of the four texels around them.
pub(crate) const MEANS: u32 = u32::MAX;

/// A depth image and its pyramid: bounds of q, and the deviation of q from the bilinear function between a node's corners.
#[derive(Clone, Debug)]
pub(crate) struct Layer {
    width: usize,
    height: usize,
    /// Continuity limit κ·texel.
    limit: f32,
    q: Vec<f32>,
    /// For each node of level 1 the index in `outlines` of its texels' corners; [`MEANS`] if the corners are means of texels.
    places: Vec<u32>,
    /// q at the four corners of the four texels of a node of level 1 at an outline.
    outlines: Vec<[[f32; 4]; 4]>,
    /// `levels[k]` has nodes of `2^(k+1)` texels a side.
    levels: Vec<Level>,
}

#[derive(Clone, Debug)]
struct Level {
    width: usize,
    nodes: Vec<Node>,
}

/// Part of a layer: `2^level` texels a side, at most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Node {
    /// Bounds of q, texels' corners included (except for a single texel); `min > max` if there is no surface.
    pub(crate) min: f32,
    pub(crate) max: f32,
    /// Largest difference from the bilinear function of the corners; infinite if a texel is empty.
    pub(crate) deviation: f32,
}

impl Node {
    const NOTHING: Self = Self { min: f32::INFINITY, max: f32::NEG_INFINITY, deviation: f32::INFINITY };

    pub(crate) fn is_empty(&self) -> bool {
        self.min > self.max
    }
}

/// A part of a node: a trapezoid at one depth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Part {
    /// Counter-clockwise from the lower left.
    pub(crate) corners: [[f32; 2]; 4],
    pub(crate) q: f32,
}

impl Part {
    /// A trapezoid that covers a fraction of the texels' rectangle, along the side that is nearest to the centre of the covered
    /// texels. Its slant follows the offset of that centre from the middle of the side; exact if an outline runs straight from side
    /// to side. `sum`: sums of i, j, q and 1 over the covered texels, of `count`.
    fn new([x0, x1, y0, y1]: [f32; 4], sum: Vec4, count: f32) -> Self {
        let (width, height) = (x1 - x0, y1 - y0);
        let share = sum.w / count;
        let (dx, dy) = ((sum.x / sum.w - 0.5 * (x0 + x1)) / width, (sum.y / sum.w - 0.5 * (y0 + y1)) / height);
        // The width at its two ends.
        let ends = |off: f32| {
            let first = (share * (1.0 - 6.0 * off)).max(2.0 * share - 1.0).max(0.0).min(2.0 * share).min(1.0);
            (first, 2.0 * share - first)
        };
        let mut corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
        if dx.abs() >= dy.abs() {
            let (low, high) = ends(dy);
            if dx >= 0.0 {
                (corners[0][0], corners[3][0]) = (x1 - low * width, x1 - high * width);
            } else {
                (corners[1][0], corners[2][0]) = (x0 + low * width, x0 + high * width);
            }
        } else {
            let (left, right) = ends(dx);
            if dy >= 0.0 {
                (corners[0][1], corners[1][1]) = (y1 - left * height, y1 - right * height);
            } else {
                (corners[3][1], corners[2][1]) = (y0 + left * height, y0 + right * height);
            }
        }
        Self { corners, q: sum.z / sum.w }
    }
}

impl Layer {
    /// `None` if no texel has a surface.
    pub(crate) fn new(width: usize, height: usize, texel: f64, q: Vec<f32>) -> Option<Self> {
        if q.iter().all(|q| *q == EMPTY) {
            return None;
        }
        let limit = KAPPA * texel as f32;
        let mut layer = Self { width, height, limit, q, places: Vec::new(), outlines: Vec::new(), levels: Vec::new() };
        layer.work_out_corners();
        let (mut w, mut h) = (width, height);
        // Corner values of the level below, so that they are computed once.
        let mut below = Vec::new();
        for level in 1.. {
            let below_width = w;
            (w, h) = (w.div_ceil(2), h.div_ceil(2));
            let (mut nodes, mut corners) = (vec![Node::NOTHING; w * h], vec![[0.0; 4]; w * h]);
            nodes.par_chunks_mut(w).zip(corners.par_chunks_mut(w)).enumerate().for_each(|(j, (nodes, corners))| {
                for (i, (node, corners)) in nodes.iter_mut().zip(corners).enumerate() {
                    (*node, *corners) = layer.make(level, i, j, &below, below_width);
                }
            });
            below = corners;
            layer.levels.push(Level { width: w, nodes });
            if w * h == 1 {
                break;
            }
        }
        Some(layer)
    }

    /// Computes the corners at outlines.
    fn work_out_corners(&mut self) {
        let (columns, rows) = self.size(1);
        let is_there = |i: usize, j: usize| i < self.width && j < self.height && self.q[j * self.width + i] != EMPTY;
        let node = |i: usize, j: usize| {
            let texels = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(x, y)| (2 * i + x, 2 * j + y));
            if !texels.iter().any(|(i, j)| is_there(*i, *j)) || self.is_smooth(i, j) {
                return None;
            }
            let corners = |i: usize, j: usize| [0, 1, 2, 3].map(|k| self.corner_beside(i, j, k));
            Some(texels.map(|(i, j)| if is_there(i, j) { corners(i, j) } else { [EMPTY; 4] }))
        };
        let row = |j: usize| (0..columns).filter_map(|i| Some((i, node(i, j)?))).collect::<Vec<_>>();
        let found: Vec<_> = (0..rows).into_par_iter().map(row).collect();
        let mut places = vec![MEANS; columns * rows];
        let mut outlines = Vec::with_capacity(found.iter().map(Vec::len).sum());
        for (j, row) in found.into_iter().enumerate() {
            for (i, four) in row {
                places[j * columns + i] = outlines.len() as u32;
                outlines.push(four);
            }
        }
        (self.places, self.outlines) = (places, outlines);
    }

    pub(crate) fn top(&self) -> u32 {
        self.levels.len() as u32
    }

    /// The texels row by row.
    pub(crate) fn q(&self) -> &[f32] {
        &self.q
    }

    #[inline(always)]
    pub(crate) fn node(&self, level: u32, i: usize, j: usize) -> Node {
        if level == 0 {
            let q = self.q[j * self.width + i];
            if q == EMPTY { Node::NOTHING } else { Node { min: q, max: q, deviation: 0.0 } }
        } else {
            let level = &self.levels[level as usize - 1];
            level.nodes[j * level.width + i]
        }
    }

    /// Texels of a node: first column, end of columns, first row, end of rows.
    #[inline(always)]
    pub(crate) fn texels(&self, level: u32, i: usize, j: usize) -> [usize; 4] {
        [i << level, ((i + 1) << level).min(self.width), j << level, ((j + 1) << level).min(self.height)]
    }

    /// Number of columns and rows of nodes in a level.
    pub(crate) fn size(&self, level: u32) -> (usize, usize) {
        let up = |n: usize| n.div_ceil(1 << level);
        (up(self.width), up(self.height))
    }

    fn make(&self, level: u32, i: usize, j: usize, below: &[[f32; 4]], below_width: usize) -> (Node, [f32; 4]) {
        let (columns, rows) = self.size(level - 1);
        let around = (0..4).map(|k| (2 * i + (k & 1), 2 * j + (k >> 1))).filter(|(i, j)| *i < columns && *j < rows);
        if around.clone().all(|(i, j)| self.node(level - 1, i, j).is_empty()) {
            return (Node::NOTHING, [0.0; 4]);
        }
        let mut children = [(Node::NOTHING, (0, 0), [0.0; 4]); 4];
        let mut count = 0;
        for (ci, cj) in around {
            let child = self.node(level - 1, ci, cj);
            let corners = match level {
                1 if child.is_empty() => [0.0; 4],
                1 => self.corners(0, ci, cj),
                _ => below[cj * below_width + ci],
            };
            children[count] = (child, (ci, cj), corners);
            count += 1;
        }
        let children = &children[..count];

        let mut node = Node::NOTHING;
        for (child, _, corners) in children {
            (node.min, node.max) = (node.min.min(child.min), node.max.max(child.max));
            if level == 1 && !child.is_empty() {
                for q in corners {
                    (node.min, node.max) = (node.min.min(*q), node.max.max(*q));
                }
            }
        }
        if children.iter().any(|(child, ..)| child.deviation.is_infinite()) {
            return (node, [0.0; 4]);
        }
        // The same as `corners(level, i, j)`, since a node shares its corners with its children.
        let (right, up) = (usize::from(2 * i + 1 < columns), usize::from(2 * j + 1 < rows));
        let of = |i: usize, j: usize, corner: usize| children[j * (1 + right) + i].2[corner];
        let corners = [of(0, 0, 0), of(right, 0, 1), of(right, up, 2), of(0, up, 3)];
        let [x0, x1, y0, y1] = self.texels(level, i, j);
        let at = |x: usize, y: usize| {
            let (s, t) = ((x - x0) as f32 / (x1 - x0) as f32, (y - y0) as f32 / (y1 - y0) as f32);
            let [a, b, c, d] = corners;
            (a * (1.0 - s) + b * s) * (1.0 - t) + (d * (1.0 - s) + c * s) * t
        };
        let (mut within, mut between) = (0.0_f32, 0.0_f32);
        for (child, (ci, cj), corners) in children {
            within = within.max(child.deviation);
            let [x0, x1, y0, y1] = self.texels(level - 1, *ci, *cj);
            for (q, (x, y)) in corners.iter().zip([(x0, y0), (x1, y0), (x1, y1), (x0, y1)]) {
                between = between.max((q - at(x, y)).abs());
            }
        }
        node.deviation = within + between;
        (node, corners)
    }

    /// Whether all texels of a node of level 1 and around it exist and belong to one surface.
    pub(crate) fn is_smooth(&self, i: usize, j: usize) -> bool {
        let (Some(x), Some(y)) = ((2 * i).checked_sub(1), (2 * j).checked_sub(1)) else { return false };
        if x + 4 > self.width || y + 4 > self.height {
            return false;
        }
        let rows = (y..y + 4).map(|y| &self.q[y * self.width + x..][..4]);
        let (low, high) = rows.flatten().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), q| (l.min(*q), h.max(*q)));
        low > EMPTY && high - low < self.limit * (1.0 + low)
    }

    /// q at the corners of a node, counter-clockwise from the lower left: each is the mean of the texels around the corner that
    /// belong to the surface of the node's own texel there.
    #[inline(always)]
    pub(crate) fn corners(&self, level: u32, i: usize, j: usize) -> [f32; 4] {
        let [x0, x1, y0, y1] = self.texels(level, i, j);
        let (x1, y1) = (x1 - 1, y1 - 1);
        [self.corner(x0, y0, 0), self.corner(x1, y0, 1), self.corner(x1, y1, 2), self.corner(x0, y1, 3)]
    }

    /// q at corner `k` of texel `(i, j)`.
    #[inline(always)]
    fn corner(&self, i: usize, j: usize, k: usize) -> f32 {
        let place = self.place(i / 2, j / 2);
        if place != MEANS {
            return self.outlines[place as usize][i % 2 + j % 2 * 2][k];
        }
        if self.q[j * self.width + i] == EMPTY {
            return EMPTY;
        }
        let (x, y) = (i + usize::from(k == 1 || k == 2), j + usize::from(k > 1));
        let at = |x: usize, y: usize| self.q[y * self.width + x];
        ((at(x - 1, y - 1) + at(x, y)) + (at(x, y - 1) + at(x - 1, y))) / 4.0
    }

    /// The index in [`outlines`](Self::outlines) of the texels' corners of a node of level 1, or [`MEANS`].
    #[inline(always)]
    pub(crate) fn place(&self, i: usize, j: usize) -> u32 {
        self.places[j * self.width.div_ceil(2) + i]
    }

    /// q at the corners of the texels of nodes at outlines.
    pub(crate) fn outlines(&self) -> &[[[f32; 4]; 4]] {
        &self.outlines
    }

    /// The largest differences of q from a node's bilinear function along its edges below, right, above, left: the node's deviation
    /// if there is a neighbour, 0 at an outline.
    #[inline(always)]
    pub(crate) fn edge_deviations(&self, [x0, x1, y0, y1]: [usize; 4], deviation: f32) -> [f32; 4] {
        if deviation <= 0.0 {
            return [0.0; 4];
        }
        let (x, y) = ((x0 + x1) / 2, (y0 + y1) / 2);
        let around = [(x, y0.wrapping_sub(1)), (x1, y), (x, y1), (x0.wrapping_sub(1), y)];
        let there = |(x, y): (usize, usize)| x < self.width && y < self.height && self.q[y * self.width + x] != EMPTY;
        around.map(|at| if there(at) { deviation } else { 0.0 })
    }

    /// The parts of a node: trapezoids for those of its texels for which `blocks`, a function of place and q, is true. The first
    /// part has q from `middle` on, the second one less. `None` if q differs by more than `range` within a part. Visits 4 × 4
    /// texels of a larger node.
    #[inline(always)]
    pub(crate) fn parts(
        &self,
        [x0, x1, y0, y1]: [usize; 4],
        step: usize,
        [middle, range]: [f32; 2],
        blocks: impl Fn(f32, f32, f32) -> bool,
    ) -> Option<[Option<Part>; 2]> {
        let mut count = 0.0_f32;
        // Sums over the near part and over the far one, and bounds of q.
        let (mut sums, mut low, mut high) = ([Vec4::ZERO; 2], [f32::INFINITY; 2], [EMPTY; 2]);
        for y in (y0..y1).skip(step / 2).step_by(step) {
            for x in (x0..x1).skip(step / 2).step_by(step) {
                count += 1.0;
                let (i, j, q) = (x as f32 + 0.5, y as f32 + 0.5, self.q[y * self.width + x]);
                if q != EMPTY && blocks(i, j, q) {
                    let part = usize::from(q < middle);
                    sums[part] += Vec4::new(i, j, q, 1.0);
                    (low[part], high[part]) = (low[part].min(q), high[part].max(q));
                }
            }
        }
        if high[0] - low[0] > range || high[1] - low[1] > range {
            return None;
        }
        let texels = [x0, x1, y0, y1].map(|x| x as f32);
        Some(sums.map(|sum| (sum.w > 0.0).then(|| Part::new(texels, sum, count))))
    }

    /// q of a texel; [`EMPTY`] outside.
    #[inline(always)]
    fn texel(&self, x: isize, y: isize) -> f32 {
        let inside = x >= 0 && y >= 0 && (x as usize) < self.width && (y as usize) < self.height;
        if inside { self.q[y as usize * self.width + x as usize] } else { EMPTY }
    }

    /// q at corner `k` of texel `(i, j)` with a surface. All texels around a corner that belong to one surface get the same value,
    /// so that there is no gap between them. Exact on a plane, and also at its outline, where the value continues the surface.
    fn corner_beside(&self, i: usize, j: usize, k: usize) -> f32 {
        let own = self.q[j * self.width + i];
        let (right, up) = (k == 1 || k == 2, k > 1);
        let (x, y) = (i as isize - isize::from(!right), j as isize - isize::from(!up));
        let at = |x, y| self.texel(x, y);
        // The four texels around the corner: lower left, lower right, upper left, upper right.
        let q = [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)];
        let all = ((q[0] + q[3]) + (q[1] + q[2])) * 0.25;
        let (low, high) = q.iter().fold((f32::INFINITY, EMPTY), |(low, high), q| (low.min(*q), high.max(*q)));
        if low > EMPTY && high - low < self.limit * (1.0 + low) {
            return all;
        }
        let columns = [y, y + 1].map(|y| self.joined([at(x - 1, y), at(x, y), at(x + 1, y), at(x + 2, y)]));
        let rows = [x, x + 1].map(|x| self.joined([at(x, y - 1), at(x, y), at(x, y + 1), at(x, y + 2)]));
        let diagonal = |a: usize, b: usize| self.near(q[a], q[b], 1.5);
        let joins = [
            (columns[0], 0b0011),
            (columns[1], 0b1100),
            (rows[0], 0b0101),
            (rows[1], 0b1010),
            (diagonal(0, 3), 0b1001),
            (diagonal(1, 2), 0b0110),
        ];
        let set = connected(1 << (usize::from(!right) + 2 * usize::from(!up)), &joins);
        let has = |k: usize| set >> k & 1 == 1;
        // Growth of q from the texel before to the k-th of the four, outward along an axis.
        let outward = |k: usize, along_x: bool| {
            let (x, y) = (x + (k & 1) as isize, y + (k >> 1) as isize);
            let (dx, dy) = if along_x { (2 * (k & 1) as isize - 1, 0) } else { (0, 2 * (k >> 1) as isize - 1) };
            let (before, further) = (at(x + dx, y + dy), at(x + 2 * dx, y + 2 * dy));
            self.joined([further, before, q[k], EMPTY]).then(|| q[k] - before)
        };
        // Faces overlap, so surfaces need not be continued at a face's border.
        let border = x < 0 || y < 0 || x as usize + 1 == self.width || y as usize + 1 == self.height;
        let outward = |k: usize, along_x: bool| if border { None } else { outward(k, along_x) };
        match set.count_ones() {
            4 => all,
            3 if has(0) && has(3) => 0.5 * (q[0] + q[3]),
            3 => 0.5 * (q[1] + q[2]),
            2 => {
                let first = set.trailing_zeros() as usize;
                let last = (31 - set.leading_zeros()) as usize;
                let mean = 0.5 * (q[first] + q[last]);
                match last - first {
                    // Two texels side by side: continues along y. One above the other: continues along x.
                    1 if first != 1 => mean + half_mean(outward(first, false), outward(last, false)),
                    2 => mean + half_mean(outward(first, true), outward(last, true)),
                    _ => mean,
                }
            }
            _ => {
                let k = set.trailing_zeros() as usize;
                own + half_mean(outward(k, true), None) + half_mean(outward(k, false), None)
            }
        }
    }

    fn near(&self, a: f32, b: f32, factor: f32) -> bool {
        // |Δz| < κ·size is |Δq| < κ texel (1 + q); never true if one is empty.
        (a - b).abs() < factor * self.limit * (1.0 + 0.5 * (a + b))
    }

    /// Whether the middle two of four texels in a line belong to one surface: their depths are near to each other, or the surface
    /// is as steep before or after them.
    fn joined(&self, [before, a, b, after]: [f32; 4]) -> bool {
        let step = b - a;
        let like = |other: f32| {
            other.is_finite()
                && step * other > 0.0
                && step.abs() < LIKE * other.abs()
                && other.abs() < LIKE * step.abs()
        };
        self.near(a, b, 1.0) || step.is_finite() && (like(a - before) || like(after - b))
    }

    /// The largest q: the nearest surface.
    pub(crate) fn nearest(&self) -> f32 {
        self.levels.last().map_or(EMPTY, |level| level.nodes[0].max)
    }

    pub(crate) fn bytes(&self) -> usize {
        let corners = size_of_val(&self.places[..]) + size_of_val(&self.outlines[..]);
        self.q.len() * size_of::<f32>()
            + corners
            + self.levels.iter().map(|l| l.nodes.len() * size_of::<Node>()).sum::<usize>()
    }
}

/// The texels around a corner that are connected with those of `set`, as bits, by the pairs that belong to one surface.
#[inline(always)]
fn connected(mut set: u32, joins: &[(bool, u32)]) -> u32 {
    for _ in 0..3 {
        for (_, pair) in joins.iter().filter(|(is, _)| *is) {
            if set & pair != 0 {
                set |= pair;
            }
        }
    }
    set
}

/// Half the mean of two growths, as far as they are known.
#[inline(always)]
fn half_mean(a: Option<f32>, b: Option<f32>) -> f32 {
    match (a, b) {
        (Some(a), Some(b)) => 0.25 * (a + b),
        (Some(a), None) | (None, Some(a)) => 0.5 * a,
        (None, None) => 0.0,
    }
}
