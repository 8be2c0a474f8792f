//! The paper's quad-tree of shadow nodes, from a mask.

use visibility_mask::{MAX_DEPTH, Mask, UnitSquare};

/// Leaves along a side of the deepest quad-tree.
const SIDE: usize = 1 << MAX_DEPTH;

/// A node of the paper's quad-tree (Fig. 9): column `x` and row `y` among the `2^level` of its level, from the square's left and lower
/// side; level 0 is the unit square.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShadowNode {
    /// Halvings of the square's sides.
    pub level: u32,
    /// Column.
    pub x: usize,
    /// Row.
    pub y: usize,
}

impl ShadowNode {
    fn children(self) -> [Self; 4] {
        [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| Self {
            level: self.level + 1,
            x: 2 * self.x + dx,
            y: 2 * self.y + dy,
        })
    }
}

/// The quad-tree of Fig. 9 as bits: for each leaf, whether the light's disc touches it and whether any of that part is visible.
///
/// Leaves outside the disc do not count: they need not be covered and have no lobe, so a light that is hidden from rim to rim is
/// one root node, whatever the corners of the square show.
#[derive(Clone, Debug)]
pub(crate) struct ShadowTree {
    depth: u32,
    touched: [u64; SIDE],
    seen: [u64; SIDE],
}

impl ShadowTree {
    /// A tree of the given depth, clamped to 1…[`MAX_DEPTH`], without blockers.
    pub(crate) fn uncovered(depth: u32) -> Self {
        let mut tree = Self { depth: depth.clamp(1, MAX_DEPTH), touched: [0; SIDE], seen: [0; SIDE] };
        let (mut mask, square) = (Mask::default(), UnitSquare::default());
        mask.reset(&square, tree.mask_depth(), square.axis);
        tree.read(&mask);
        tree
    }

    pub(crate) fn depth(&self) -> u32 {
        self.depth
    }

    /// Depth of the mask to fill: two row lines through each leaf, so that a leaf that is covered only along its middle does not
    /// count as covered; a single line at the greatest depth.
    pub(crate) fn mask_depth(&self) -> u32 {
        (self.depth + 1).min(MAX_DEPTH)
    }

    fn side(&self) -> usize {
        1 << self.depth
    }

    /// Reads a mask of depth [`mask_depth`](Self::mask_depth). A leaf is in shadow if nothing of the disc is visible on its row
    /// lines; "partially covered leaves are ignored".
    pub(crate) fn read(&mut self, mask: &Mask) {
        debug_assert_eq!(mask.depth(), self.mask_depth());
        let lines = mask.side() / self.side();
        for row in 0..self.side() {
            let (mut touched, mut seen) = (0, 0);
            for j in row * lines..(row + 1) * lines {
                touched |= mask.emitting_cells(j);
                seen |= mask.lit_cells(j);
            }
            if lines == 2 {
                (touched, seen) = (pairs(touched), pairs(seen));
            }
            (self.touched[row], self.seen[row]) = (touched, seen);
        }
    }

    /// Whether the disc touches a node, and whether any of it is visible there.
    fn state(&self, node: ShadowNode) -> (bool, bool) {
        let size = self.side() >> node.level;
        let columns = (u64::MAX >> (64 - size)) << (node.x * size);
        let (mut touched, mut seen) = (0, 0);
        for row in node.y * size..(node.y + 1) * size {
            touched |= self.touched[row] & columns;
            seen |= self.seen[row] & columns;
        }
        (touched != 0, seen != 0)
    }

    /// The nodes of a level that the disc touches: a full cover by nodes of that level.
    pub(crate) fn cover(&self, level: u32) -> impl Iterator<Item = ShadowNode> {
        let side = 1usize << level;
        (0..side * side).map(move |k| ShadowNode { level, x: k % side, y: k / side }).filter(|node| self.state(*node).0)
    }

    /// The shadow nodes: subdivides from the root, stops at nodes that are wholly in shadow ("frozen") or outside the disc, and
    /// drops leaves that are not wholly covered.
    pub(crate) fn shadows(&self, out: &mut Vec<ShadowNode>) {
        out.clear();
        self.descend(ShadowNode { level: 0, x: 0, y: 0 }, out);
    }

    fn descend(&self, node: ShadowNode, out: &mut Vec<ShadowNode>) {
        match self.state(node) {
            (false, _) => {}
            (true, false) => out.push(node),
            (true, true) if node.level < self.depth => {
                node.children().into_iter().for_each(|child| self.descend(child, out));
            }
            (true, true) => {}
        }
    }
}

/// Bit k of the result: bit 2k or 2k + 1.
fn pairs(bits: u64) -> u64 {
    let mut b = (bits | bits >> 1) & 0x5555_5555_5555_5555;
    b = (b | b >> 1) & 0x3333_3333_3333_3333;
    b = (b | b >> 2) & 0x0f0f_0f0f_0f0f_0f0f;
    b = (b | b >> 4) & 0x00ff_00ff_00ff_00ff;
    b = (b | b >> 8) & 0x0000_ffff_0000_ffff;
    (b | b >> 16) & 0x0000_0000_ffff_ffff
}

#[cfg(test)]
mod tests {
    use super::*;

    fn covered_by(depth: u32, block: impl Fn(&mut Mask)) -> Vec<ShadowNode> {
        let mut tree = ShadowTree::uncovered(depth);
        let (mut mask, square) = (Mask::default(), UnitSquare::default());
        mask.reset(&square, tree.mask_depth(), square.axis);
        block(&mut mask);
        tree.read(&mask);
        let mut out = Vec::new();
        tree.shadows(&mut out);
        out
    }

    fn disc(mask: &mut Mask, x: f32, y: f32, r: f32) {
        for j in 0..mask.side() {
            let half_sq = r * r - (mask.row_y(j) - y).powi(2);
            if half_sq > 0.0 {
                mask.block_span(j, x - half_sq.sqrt(), x + half_sq.sqrt());
            }
        }
    }

    #[test]
    fn pairs_fold_two_bits_into_one() {
        assert_eq!(pairs(u64::MAX), 0xffff_ffff);
        for k in 0..64 {
            assert_eq!(pairs(1 << k), 1 << (k / 2));
        }
    }

    #[test]
    fn nothing_and_all() {
        let root = vec![ShadowNode { level: 0, x: 0, y: 0 }];
        for depth in 1..=MAX_DEPTH {
            assert!(covered_by(depth, |_| ()).is_empty());
            assert_eq!(covered_by(depth, Mask::block_all), root);
            // The corners of the square stay open; a blocker as large as the light is the closest case.
            for r in [1.0, 1.001, 1.01, 1.1] {
                assert_eq!(covered_by(depth, |m| disc(m, 0.0, 0.0, r)), root, "{depth} {r}");
            }
            assert_ne!(covered_by(depth, |m| disc(m, 0.0, 0.0, 0.97)), root);
        }
    }

    #[test]
    fn half_the_light_is_two_quadrants() {
        let left = covered_by(5, |m| (0..m.side()).for_each(|j| m.block_span(j, -2.0, 0.0)));
        assert_eq!(left, [(0, 0), (0, 1)].map(|(x, y)| ShadowNode { level: 1, x, y }));
    }

    #[test]
    fn what_is_touched_is_seen_without_blockers() {
        let mut random = lobe_core::oracle::Random::new(9);
        for depth in 1..=MAX_DEPTH {
            let mut tree = ShadowTree::uncovered(depth);
            for _ in 0..200 {
                let mut mask = Mask::default();
                let disc = random.log_uniform(1e-4, 10.0) as f32;
                mask.reset(
                    &UnitSquare { half: glam::Vec2::splat(disc), disc, ..UnitSquare::default() },
                    tree.mask_depth(),
                    glam::Vec3::Z,
                );
                tree.read(&mask);
                assert_eq!(tree.touched, tree.seen, "depth {depth}, disc {disc}");
            }
        }
    }

    /// The recursive definition, leaf by leaf, on exact discs; leaves within `slack` of its edge may have either result.
    #[test]
    fn leaves_of_a_disc() {
        for depth in 2..=MAX_DEPTH {
            let side = 1usize << depth;
            let cell = 2.0 / side as f32;
            let (cx, cy, r) = (0.23, -0.31, 0.61);
            let nodes = covered_by(depth, |m| disc(m, cx, cy, r));
            let mut leaves = vec![false; side * side];
            for n in &nodes {
                let size = side >> n.level;
                for k in 0..size * size {
                    let leaf = &mut leaves[(n.y * size + k / size) * side + n.x * size + k % size];
                    assert!(!*leaf, "two nodes share a leaf");
                    *leaf = true;
                }
            }
            // Lines run a quarter (or, at the greatest depth, half) of a leaf from its edges; along them there are 256
            // samples.
            let sample = 2.0 / 256.0;
            let slack = cell * if depth < MAX_DEPTH { 0.25 } else { 0.5 } + sample;
            for (k, leaf) in leaves.iter().enumerate() {
                let at = |k: usize| (k as f32 + 0.5) * cell - 1.0;
                let (x, y) = (at(k % side), at(k / side));
                let farthest = |x: f32, y: f32| (x.abs() + 0.5 * cell).hypot(y.abs() + 0.5 * cell);
                if farthest(x, y) > 1.0 {
                    continue;
                }
                let far = farthest(x - cx, y - cy);
                assert!(!*leaf || far <= r + slack, "leaf {k} of depth {depth} is not covered");
                assert!(*leaf || far > r - sample, "leaf {k} of depth {depth} is covered");
            }
        }
    }
}
