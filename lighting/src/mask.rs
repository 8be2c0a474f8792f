use crate::UnitSquare;
use glam::{Vec2, Vec3};

/// The deepest quad-tree: 64 × 64 cells.
pub const MAX_DEPTH: u32 = 6;
const SIDE: usize = 1 << MAX_DEPTH;
/// The right end of a cell in the units of `Mask::left` and `Mask::right`.
const FULL: u8 = u8::MAX;

/// The visibility mask: the leaves of the complete quad-tree of a depth (§5.3 of the paper, Fig. 9), as bits with
/// fractional coverage at the edges.
///
/// `2^depth` rows of `2^depth` cells. A row is a line through its cells' centres; what emits and what blocks on that
/// line is known exactly along the line (to 1/255 of a cell): a cell is blocked, open, or open between two points. Across
/// the lines it is sampled. So an edge that crosses the rows is exact, one along the rows is as good as their number:
/// let [`UnitSquare::right`] point across the edges that matter.
///
/// Blockers fuse by union, so their order does not matter. The paper decides a leaf as a whole and drops those that are
/// partly covered.
#[derive(Clone, Debug)]
pub struct Mask {
    square: UnitSquare,
    depth: u32,
    whole_disc: bool,
    /// Emitting interval of each row in cells from the window's left side.
    emitting: [(f32, f32); SIDE],
    /// Cells blocked from end to end, and those blocked in part, as bits.
    blocked: [u64; SIDE],
    partial: [u64; SIDE],
    /// A partly blocked cell is open between these fractions.
    left: [[u8; SIDE]; SIDE],
    right: [[u8; SIDE]; SIDE],
    /// Of those, the ones that edges along the row cut, and between which heights they are open.
    flat: [u64; SIDE],
    low: [[u8; SIDE]; SIDE],
    high: [[u8; SIDE]; SIDE],
}

/// From which side a shape reaches into a row, for [`Mask::block_area`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Covers {
    /// It covers the row's lower side (smaller y).
    FromBelow,
    /// It covers the row's upper side.
    FromAbove,
    /// It ends on both sides.
    Within,
}

impl Default for Mask {
    fn default() -> Self {
        Self {
            square: UnitSquare::default(),
            depth: MAX_DEPTH,
            whole_disc: false,
            emitting: [(0.0, 0.0); SIDE],
            blocked: [0; SIDE],
            partial: [0; SIDE],
            left: [[0; SIDE]; SIDE],
            right: [[0; SIDE]; SIDE],
            flat: [0; SIDE],
            low: [[0; SIDE]; SIDE],
            high: [[0; SIDE]; SIDE],
        }
    }
}

impl Mask {
    /// Starts anew: no blocker; what emits is the light's disc above the horizon of `normal` (world space).
    ///
    /// # Panics
    /// When `depth` is not in 1…[`MAX_DEPTH`].
    pub fn reset(&mut self, square: &UnitSquare, depth: u32, normal: Vec3) {
        assert!((1..=MAX_DEPTH).contains(&depth), "mask depth {depth} is not in 1..={MAX_DEPTH}");
        self.depth = depth;
        self.square = *square;
        let n = square.local(normal);
        let above = n.z > 0.0 && n.z * n.z >= square.disc * square.disc * n.truncate().length_squared();
        self.whole_disc = above && square.half == square.disc && square.center == Vec2::ZERO;
        for j in 0..self.side() {
            self.blocked[j] = 0;
            self.partial[j] = 0;
            self.flat[j] = 0;
            let y = self.row_y(j);
            let half = (square.disc * square.disc - y * y).max(0.0).sqrt();
            // Above the horizon: n.x x + n.y y + n.z > 0.
            let rest = n.y * y + n.z;
            let (mut from, mut to) = (-half, half);
            if n.x > 0.0 {
                from = from.max(-rest / n.x);
            } else if n.x < 0.0 {
                to = to.min(-rest / n.x);
            } else if rest <= 0.0 {
                to = from;
            }
            self.emitting[j] = self.cells(from, to);
        }
    }

    /// Whether the window shows all of the light's disc and the horizon cuts nothing off it.
    pub(crate) fn is_whole_disc(&self) -> bool {
        self.whole_disc
    }

    /// Cells of row `j` that any blocker touches.
    pub(crate) fn touched_cells(&self, j: usize) -> u64 {
        self.blocked[j] | self.partial[j]
    }

    /// Cells in a row, rows in the mask.
    #[must_use]
    pub fn side(&self) -> usize {
        1 << self.depth
    }

    /// Depth of the quad-tree.
    #[must_use]
    pub fn depth(&self) -> u32 {
        self.depth
    }

    /// The window that the mask covers.
    #[must_use]
    pub fn square(&self) -> &UnitSquare {
        &self.square
    }

    /// Side of a cell in plane coordinates.
    #[must_use]
    pub fn cell(&self) -> f32 {
        2.0 * self.square.half / self.side() as f32
    }

    /// Plane coordinate y of row `j`.
    #[must_use]
    pub fn row_y(&self, j: usize) -> f32 {
        self.square.center.y + ((j as f32 + 0.5) - 0.5 * self.side() as f32) * self.cell()
    }

    /// Plane coordinates of the centre of cell `i` of row `j`.
    #[must_use]
    pub fn cell_center(&self, i: usize, j: usize) -> Vec2 {
        Vec2::new(self.square.center.x + ((i as f32 + 0.5) - 0.5 * self.side() as f32) * self.cell(), self.row_y(j))
    }

    /// Plane coordinates as cells from the left side, clamped to the row. An empty or NaN interval gives an empty one.
    fn cells(&self, from: f32, to: f32) -> (f32, f32) {
        let side = self.side() as f32;
        let scale = side / (2.0 * self.square.half);
        let left = self.square.center.x - self.square.half;
        let (from, to) = ((from - left) * scale, (to - left) * scale);
        if from < to { (from.clamp(0.0, side), to.clamp(0.0, side)) } else { (0.0, 0.0) }
    }

    /// Blocks row `j` between two plane coordinates x; infinite ones are fine, an empty or NaN interval blocks nothing.
    pub fn block_span(&mut self, j: usize, from: f32, to: f32) {
        let (from, to) = self.cells(from, to);
        let (first, last) = (from as usize, to as usize);
        let (before, after) = (fraction(from - first as f32), fraction(to - last as f32));
        if from >= to {
            return;
        }
        if first == last {
            self.block_inside(j, first, before, after);
            return;
        }
        if before > 0 {
            let (left, right) = self.open(j, first);
            self.set_open(j, first, left, right.min(before));
        }
        let full = if before > 0 { first + 1 } else { first };
        self.blocked[j] |= ones(last as u32) & !ones(full as u32);
        if after > 0 && last < self.side() {
            let (left, right) = self.open(j, last);
            self.set_open(j, last, left.max(after), right);
        }
    }

    /// Blocks of row `j` the area that a shape takes of each cell, from eight lines: for shapes whose edge runs along the
    /// row, which would else enter or leave it all at once. `span` gives plane coordinates x of the shape at a height y.
    ///
    /// A cell is then open between two heights, as well as between two points along the row: what is open is taken to be
    /// the product of both.
    pub fn block_area(&mut self, j: usize, covers: Covers, span: impl Fn(f32) -> (f32, f32)) {
        const LINES: usize = 8;
        let mut area = [0.0_f32; SIDE + 1];
        let (mut low, mut high) = (self.side(), 0);
        for k in 0..LINES {
            let y = self.row_y(j) + self.cell() * ((k as f32 + 0.5) / LINES as f32 - 0.5);
            let (from, to) = span(y);
            let (from, to) = self.cells(from, to);
            if from >= to {
                continue;
            }
            let (first, last) = (from as usize, to as usize);
            area[first] -= from - first as f32;
            area[last] -= (last + 1) as f32 - to;
            area[first..=last].iter_mut().for_each(|a| *a += 1.0);
            (low, high) = (low.min(first), high.max(last + 1));
        }
        for (i, area) in area.iter().enumerate().take(high.min(self.side())).skip(low) {
            let covered = fraction(area / LINES as f32);
            if covered == FULL {
                self.blocked[j] |= 1 << i;
            } else if covered > 0 && self.blocked[j] >> i & 1 == 0 {
                let (low, high) = self.heights(j, i);
                let (low, high) = match covers {
                    Covers::FromBelow => (low.max(covered), high),
                    Covers::FromAbove => (low, high.min(FULL - covered)),
                    Covers::Within => (low + hidden(covered, low, high), high),
                };
                let (left, right) = self.open(j, i);
                self.set_open(j, i, left, right);
                self.flat[j] |= 1 << i;
                (self.low[j][i], self.high[j][i]) = (low, high);
                if low >= high {
                    self.blocked[j] |= 1 << i;
                }
            }
        }
    }

    /// Blocks a part of one cell. Where it leaves something open on either side, as much is taken off the open part's
    /// left as is hidden if it lies anywhere in the cell: so the order of thin blockers does not matter, and many of
    /// them darken a cell as their random union does.
    fn block_inside(&mut self, j: usize, i: usize, from: u8, to: u8) {
        let (left, right) = self.open(j, i);
        if from <= left || to >= right {
            let (left, right) = if from <= left { (left.max(to), right) } else { (left, right.min(from)) };
            self.set_open(j, i, left, right);
        } else {
            self.set_open(j, i, left + hidden(to - from, left, right), right);
        }
    }

    /// Blocks every cell.
    pub fn block_all(&mut self) {
        self.blocked = [u64::MAX; SIDE];
    }

    /// Blocks each cell for whose centre's unit direction (in world space) `test` says so: the slow way, for shapes
    /// without spans.
    pub fn block_where(&mut self, test: impl Fn(Vec3) -> bool) {
        for j in 0..self.side() {
            for i in Bits(self.lit_cells(j)) {
                let p = self.cell_center(i, j);
                if test(self.square.world(p.extend(1.0)).normalize()) {
                    self.blocked[j] |= 1 << i;
                }
            }
        }
    }

    fn open(&self, j: usize, i: usize) -> (u8, u8) {
        if self.partial[j] >> i & 1 == 1 { (self.left[j][i], self.right[j][i]) } else { (0, FULL) }
    }

    fn heights(&self, j: usize, i: usize) -> (u8, u8) {
        if self.flat[j] >> i & 1 == 1 { (self.low[j][i], self.high[j][i]) } else { (0, FULL) }
    }

    fn set_open(&mut self, j: usize, i: usize, left: u8, right: u8) {
        self.partial[j] |= 1 << i;
        self.left[j][i] = left;
        self.right[j][i] = right;
        if left >= right {
            self.blocked[j] |= 1 << i;
        }
    }

    /// Cells of row `j` that emit at all.
    #[must_use]
    pub fn emitting_cells(&self, j: usize) -> u64 {
        let (from, to) = self.emitting[j];
        let end = to as u32 + u32::from(to > to as u32 as f32);
        ones(end) & !ones(from as u32)
    }

    /// Cells of row `j` that emit and are not blocked from end to end.
    #[must_use]
    pub fn lit_cells(&self, j: usize) -> u64 {
        self.emitting_cells(j) & !self.blocked[j]
    }

    /// Cells of row `j` that emit from end to end, and of those the ones without any blocker.
    pub(crate) fn whole_cells(&self, j: usize) -> (u64, u64) {
        let (from, to) = self.emitting[j];
        let first = from as u32 + u32::from(from > from as u32 as f32);
        let end = to as u32;
        let emitting = if first < end { ones(end) & !ones(first) } else { 0 };
        (emitting, emitting & !self.blocked[j] & !self.partial[j])
    }

    /// Part of a cell of row `j` that emits, as (start, length) in cells.
    pub(crate) fn emitting_part(&self, i: usize, j: usize) -> (f32, f32) {
        let (from, to) = self.emitting[j];
        let (from, to) = (from.max(i as f32), to.min(i as f32 + 1.0));
        (from, (to - from).max(0.0))
    }

    /// Part of a cell of row `j` that emits and is not blocked.
    pub(crate) fn lit_part(&self, i: usize, j: usize) -> (f32, f32) {
        let (from, to) = self.emitting[j];
        if self.blocked[j] >> i & 1 == 1 {
            return (from, 0.0);
        }
        let (left, right) = self.open(j, i);
        let at = |x: u8| i as f32 + f32::from(x) * (1.0 / f32::from(FULL));
        let (from, to) = (from.max(at(left)), to.min(at(right)));
        let length = (to - from).max(0.0);
        if self.flat[j] >> i & 1 == 0 {
            return (from, length);
        }
        // As much along the row, about the same middle.
        let share = f32::from(self.high[j][i] - self.low[j][i]) * (1.0 / f32::from(FULL));
        (from + 0.5 * (1.0 - share) * length, share * length)
    }

    /// Emitting and lit area in cells.
    #[must_use]
    pub fn areas(&self) -> (f32, f32) {
        let row = |j: usize| {
            let (from, to) = self.emitting[j];
            (to - from, Bits(self.lit_cells(j)).map(|i| self.lit_part(i, j).1).sum::<f32>())
        };
        (0..self.side()).map(row).fold((0.0, 0.0), |(a, b), (c, d)| (a + c, b + d))
    }

    /// True when nothing that emits is blocked.
    #[must_use]
    pub fn is_lit(&self) -> bool {
        (0..self.side()).all(|j| self.touched_cells(j) & self.emitting_cells(j) == 0)
    }

    /// True when every emitting cell is blocked.
    #[must_use]
    pub fn is_dark(&self) -> bool {
        (0..self.side()).all(|j| self.lit_cells(j) == 0)
    }
}

/// As much as a part hides of an open interval if it lies anywhere in the cell.
fn hidden(part: u8, from: u8, to: u8) -> u8 {
    let full = u32::from(FULL);
    ((u32::from(part) * u32::from(to - from) + full / 2) / full) as u8
}

/// A fraction of a cell in 255ths, rounded.
fn fraction(x: f32) -> u8 {
    (x * f32::from(FULL) + 0.5) as u8
}

/// The lowest `n` bits, n ≤ 64.
pub(crate) fn ones(n: u32) -> u64 {
    if n >= 64 { u64::MAX } else { (1 << n) - 1 }
}

/// The positions of the set bits.
pub(crate) struct Bits(pub(crate) u64);

impl Iterator for Bits {
    type Item = usize;

    fn next(&mut self) -> Option<usize> {
        if self.0 == 0 {
            return None;
        }
        let i = self.0.trailing_zeros() as usize;
        self.0 &= self.0 - 1;
        Some(i)
    }
}
