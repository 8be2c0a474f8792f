use crate::bits::ones;
use crate::lanes::NUMBERS;
use crate::row::{self, COARSE, EIGHT, EightRows, MAX_DEPTH, ROWS, Row, SIDE, WIDTH};
use crate::square::THINNEST;
use crate::{LitBounds, Raster, UnitSquare};
use fearless_simd::{Level, Simd, dispatch, f32x8, prelude::*, u32x8};
use glam::{Vec2, Vec3};
use lobe_core::Outline;
use std::sync::LazyLock;

mod blocking;

/// The visibility mask: the leaves of the complete quad-tree of a depth (§5.3 of the paper, Fig. 9), sampled as bits.
///
/// `2^depth` rows of `2^depth` cells. A row is a line through its cells' centres with 256 samples, whatever the depth
/// ([`MaskVisibility`](crate::MaskVisibility) uses 64 if the tolerance allows). Along the row a span is exact to 1/256 of the
/// window. Samples are shifted from row to row, so that an edge across many rows is exact to a fraction of that. Across the rows an
/// edge is sampled at its crossings with their lines; an edge along a row is drawn by area ([`block_area`](Self::block_area)), with
/// eight heights among the samples. An edge across the rows is the most exact: let [`UnitSquare::right`] point across the edges
/// that matter.
///
/// Blockers combine by union, bit by bit: their order does not matter, and blocking twice has no effect. The paper decides a leaf
/// as a whole and drops leaves that are partly covered.
#[derive(Clone, Debug)]
pub struct Mask {
    square: UnitSquare,
    depth: u32,
    whole_disc: bool,
    /// Plane coordinate of the window's left side, and samples per unit of plane coordinates.
    left: f32,
    scale: f32,
    /// Half-planes `a x + b y + c > 0` of the square's plane; nothing outside of one emits.
    sides: Vec<Vec3>,
    /// Centre and radius of the light's disc.
    circle: (Vec2, f32),
    /// The receiver's normal in the square's frame.
    horizon: Vec3,
    /// Emitting samples of each row: from, to.
    emitting: [[u32; SIDE]; 2],
    /// Samples that emit and are not blocked: the rows of a fine mask; for a coarse one the two halves of its rows, one word each.
    lit: [Row; ROWS],
    halves: [[u32; ROWS]; 2],
    coarse: bool,
    /// Openings between samples.
    openings: Vec<([Vec2; 2], f32)>,
    /// Half-planes of the next square's plane, outside of which nothing emits.
    cell: Vec<Vec3>,
}

/// The emitting samples of a window that shows a whole disc: the same for all lights.
struct Disc {
    emitting: [[u32; SIDE]; 2],
    lit: [Row; ROWS],
    halves: [[u32; ROWS]; 2],
}

/// First for fine masks, then for coarse ones.
static DISCS: LazyLock<[[Disc; MAX_DEPTH as usize + 1]; 2]> = LazyLock::new(|| {
    [false, true].map(|coarse| {
        core::array::from_fn(|depth| {
            let mut mask = Mask { depth: depth as u32, coarse, ..Mask::default() };
            mask.fit();
            mask.emit(Vec3::Z);
            Disc { emitting: mask.emitting, lit: mask.lit, halves: mask.halves }
        })
    })
});

impl Default for Mask {
    fn default() -> Self {
        let square = UnitSquare::default();
        Self {
            square,
            depth: MAX_DEPTH,
            whole_disc: false,
            left: -1.0,
            scale: 1.0,
            sides: Vec::new(),
            circle: (Vec2::ZERO, 1.0),
            horizon: Vec3::Z,
            emitting: [[0; SIDE]; 2],
            lit: [row::NONE; ROWS],
            halves: [[0; ROWS]; 2],
            coarse: false,
            openings: Vec::new(),
            cell: Vec::new(),
        }
    }
}

impl Mask {
    /// Clears the mask: no blocker; the light's disc above the horizon of `normal` (world space) emits.
    ///
    /// # Panics
    /// If `depth` is not in 1…[`MAX_DEPTH`].
    pub fn reset(&mut self, square: &UnitSquare, depth: u32, normal: Vec3) {
        self.reset_to(square, depth, normal, None);
    }

    /// As [`reset`](Self::reset), for a window [around an outline](UnitSquare::around_outline): the part of the outline above the
    /// horizon emits.
    ///
    /// # Panics
    /// If `depth` is not in 1…[`MAX_DEPTH`].
    pub fn reset_to(&mut self, square: &UnitSquare, depth: u32, normal: Vec3, outline: Option<&Outline>) {
        assert!((1..=MAX_DEPTH).contains(&depth), "mask depth {depth} is not in 1..={MAX_DEPTH}");
        self.depth = depth;
        self.square = *square;
        self.fit();
        self.openings.clear();
        self.sides.clone_from(&self.cell);
        self.circle = (Vec2::ZERO, square.disc);
        let n = square.local(normal);
        self.horizon = n;
        if let Some(outline) = outline {
            // Of a light as thin as a thread all of the window emits, which is not as thin.
            if !is_thread(outline, square) {
                self.sides.extend(sides(outline, square));
            }
            self.circle = outline.circle([square.right, square.up]).unwrap_or(self.circle);
            self.whole_disc = false;
            self.emit(n);
            return;
        }
        let above =
            self.cell.is_empty() && n.z > 0.0 && n.z * n.z >= square.disc * square.disc * n.truncate().length_squared();
        self.whole_disc = above && square.half == Vec2::splat(square.disc) && square.center == Vec2::ZERO;
        if self.whole_disc {
            let (disc, side) = (&DISCS[usize::from(self.coarse)][depth as usize], self.side());
            for (emitting, disc) in self.emitting.iter_mut().zip(&disc.emitting) {
                emitting[..side].copy_from_slice(&disc[..side]);
            }
            if self.coarse {
                for (halves, disc) in self.halves.iter_mut().zip(&disc.halves) {
                    halves[..side].copy_from_slice(&disc[..side]);
                }
            } else {
                self.lit[..side].copy_from_slice(&disc.lit[..side]);
            }
        } else {
            self.emit(n);
        }
    }

    /// Computes the scale of the window.
    fn fit(&mut self) {
        self.left = self.square.center.x - self.square.half.x;
        self.scale = self.width() as f32 / (2.0 * self.square.half.x);
    }

    /// Sets whether rows have 64 samples instead of 256, from the next [`reset`](Self::reset) on: for tolerances of a few
    /// thousandths and more.
    pub(crate) fn set_coarse(&mut self, coarse: bool) {
        self.coarse = coarse;
    }

    /// Sets the half-planes `a x + b y + c > 0` outside of which nothing emits, from the next [`reset`](Self::reset) on.
    pub(crate) fn set_cell(&mut self, cell: impl Iterator<Item = Vec3>) {
        self.cell.clear();
        self.cell.extend(cell);
    }

    /// Samples in a row.
    pub(crate) fn width(&self) -> usize {
        if self.coarse { COARSE } else { WIDTH }
    }

    /// Computes the emitting samples, with the normal in the square's frame.
    fn emit(&mut self, n: Vec3) {
        dispatch!(Level::new(), simd => self.emit_rows(simd, n));
    }

    #[inline(always)]
    fn emit_rows<S: Simd>(&mut self, simd: S, n: Vec3) {
        let (raster, side) = (self.raster(), self.side() as f32);
        let (center, cell, (middle, disc)) = (self.square.center.y, self.cell().y, self.circle);
        let zero = f32x8::splat(simd, 0.0);
        for base in (0..self.side()).step_by(EIGHT) {
            let line = f32x8::simd_from(simd, NUMBERS) + (base as f32 + 0.5);
            let y = (line - 0.5 * side) * cell + center;
            let off = y - middle.y;
            let half = (f32x8::splat(simd, disc * disc) - off * off).max(zero).sqrt();
            // Above the horizon: n.x x + n.y y + n.z > 0.
            let (mut from, mut to) = (middle.x - half, middle.x + half);
            for n in core::iter::once(&n).chain(&self.sides) {
                let rest = y * n.y + n.z;
                if n.x > 0.0 {
                    from = from.max(-rest / n.x);
                } else if n.x < 0.0 {
                    to = to.min(-rest / n.x);
                } else {
                    to = rest.simd_le(zero).select(from, to);
                }
            }
            let emits = from.simd_lt(to) & line.simd_lt(f32x8::splat(simd, side));
            let shift = f32x8::simd_from(simd, *Raster::shifts(base));
            let at = [(from - raster.left) * raster.samples - shift, (to - raster.left) * raster.samples - shift];
            let nothing = u32x8::splat(simd, 0);
            let from = emits.select(raster.indices(simd, at[0]), nothing);
            let to = emits.select(raster.indices(simd, at[1]), nothing);
            from.store_slice(&mut self.emitting[0][base..base + EIGHT]);
            to.store_slice(&mut self.emitting[1][base..base + EIGHT]);
            if self.coarse {
                let [low, high] = row::halves(simd, from, to);
                low.store_slice(&mut self.halves[0][base..base + EIGHT]);
                high.store_slice(&mut self.halves[1][base..base + EIGHT]);
            } else {
                for j in base..base + EIGHT {
                    self.lit[j] = row::span(self.emitting[0][j], self.emitting[1][j]);
                }
            }
        }
    }

    /// The half-planes `a x + b y + c > 0` in which the light emits, one of them above the horizon.
    pub fn half_planes(&self) -> impl Iterator<Item = Vec3> {
        core::iter::once(self.horizon).chain(self.sides.iter().copied())
    }

    /// The centre and the radius of a circle in which the light emits.
    #[must_use]
    pub fn circle(&self) -> (Vec2, f32) {
        self.circle
    }

    /// The part of the window that emits at a height, in one more half-plane if given: from, to. Empty if `to` is not above `from`.
    #[must_use]
    pub fn emits_at(&self, y: f32, also: Option<Vec3>) -> [f32; 2] {
        let (middle, disc) = self.circle;
        let off = y - middle.y;
        let half = (disc * disc - off * off).max(0.0).sqrt();
        let [low, high] = [-1.0, 1.0].map(|side| self.square.center.x + side * self.square.half.x);
        let (mut from, mut to) = (low.max(middle.x - half), high.min(middle.x + half));
        for n in self.half_planes().chain(also) {
            let rest = y * n.y + n.z;
            if n.x > 0.0 {
                from = from.max(-rest / n.x);
            } else if n.x < 0.0 {
                to = to.min(-rest / n.x);
            } else if rest <= 0.0 {
                to = from;
            }
        }
        [from, to]
    }

    /// Whether the window shows the whole disc of the light, above the horizon.
    pub(crate) fn is_whole_disc(&self) -> bool {
        self.whole_disc
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

    /// Sides of a cell in plane coordinates.
    #[must_use]
    pub fn cell(&self) -> Vec2 {
        2.0 * self.square.half / self.side() as f32
    }

    /// Plane coordinate y of row `j`.
    #[must_use]
    pub fn row_y(&self, j: usize) -> f32 {
        self.square.center.y + ((j as f32 + 0.5) - 0.5 * self.side() as f32) * self.cell().y
    }

    /// Plane coordinates of the centre of cell `i` of row `j`.
    #[must_use]
    pub fn cell_center(&self, i: usize, j: usize) -> Vec2 {
        Vec2::new(self.square.center.x + ((i as f32 + 0.5) - 0.5 * self.side() as f32) * self.cell().x, self.row_y(j))
    }

    #[inline(always)]
    fn index(&self, position: f32) -> u32 {
        row::index(position).min(self.width() as u32)
    }

    /// Converts plane coordinates x to samples of row `j`, clamped to the row. An empty or NaN interval gives an empty one.
    fn samples(&self, j: usize, from: f32, to: f32) -> (u32, u32) {
        if from < to {
            let at = |x: f32| self.index((x - self.left) * self.scale - row::PHASE[j]);
            (at(from), at(to))
        } else {
            (0, 0)
        }
    }

    /// Samples of row `j` that emit and are not below a plane through the receiver, with its normal in the square's frame: from,
    /// to. Empty if `to` is not above `from`.
    #[must_use]
    pub fn emitting_above(&self, n: Vec3, j: usize) -> (u32, u32) {
        let (from, to) = self.emitting(j);
        let (start, end) = below(n, self.row_y(j));
        let (start, end) = self.samples(j, start, end);
        if start >= end {
            (from, to)
        } else if start == 0 {
            (from.max(end), to)
        } else {
            (from, to.min(start))
        }
    }

    /// The lit samples of the eight rows from `j` on, a multiple of eight: 64 in each word, for the requested number of words. Rows
    /// beyond the mask are dark.
    #[inline(always)]
    pub fn lit_rows(&self, j: usize, samples: &mut [EightRows]) {
        let count = EIGHT.min(self.side() - j);
        for (number, word) in samples.iter_mut().enumerate() {
            *word = [0; EIGHT];
            for (k, bits) in word[..count].iter_mut().enumerate() {
                *bits = self.lit(j + k).0.get(number).copied().unwrap_or_default();
            }
        }
    }

    /// The conversion from plane coordinates to rows and samples.
    #[inline(always)]
    #[must_use]
    pub fn raster(&self) -> Raster {
        Raster {
            left: self.left,
            bottom: self.square.center.y - self.square.half.y,
            samples: self.scale,
            rows: self.side() as f32 / (2.0 * self.square.half.y),
            width: self.width() as f32,
        }
    }

    /// Emitting samples of row `j`: from, to. Empty if `to` is not above `from`.
    #[inline(always)]
    #[must_use]
    pub fn emitting(&self, j: usize) -> (u32, u32) {
        (self.emitting[0][j], self.emitting[1][j])
    }

    /// Samples of row `j` that are lit.
    #[inline(always)]
    pub(crate) fn lit(&self, j: usize) -> Row {
        if self.coarse { row::coarse(self.halves[0][j], self.halves[1][j]) } else { self.lit[j] }
    }

    /// The lit samples of all rows of a fine mask.
    #[inline(always)]
    pub(crate) fn fine_rows(&self) -> &[Row] {
        &self.lit[..1 << self.depth]
    }

    /// The rows of a coarse mask, as halves.
    #[inline(always)]
    pub(crate) fn halves(&self) -> [&[u32]; 2] {
        [&self.halves[0][..1 << self.depth], &self.halves[1][..1 << self.depth]]
    }

    /// Eight rows of a coarse mask, as halves.
    #[inline(always)]
    fn eight_halves<S: Simd>(&self, simd: S, j: usize) -> [u32x8<S>; 2] {
        // A closure would not be compiled with the wide instructions.
        let [low, high] = &self.halves;
        [u32x8::simd_from(simd, row::eight(low, j)), u32x8::simd_from(simd, row::eight(high, j))]
    }

    /// Cells of row `j` with any emitting sample.
    #[must_use]
    pub fn emitting_cells(&self, j: usize) -> u64 {
        self.cells_of(self.emitting(j))
    }

    /// The cells that contain samples of a row.
    pub(crate) fn cells_of(&self, (from, to): (u32, u32)) -> u64 {
        let width = self.width() as u32 >> self.depth;
        if from < to { ones(to.div_ceil(width)) & !ones(from / width) } else { 0 }
    }

    /// Cells of row `j` that emit and are not blocked from end to end.
    #[must_use]
    pub fn lit_cells(&self, j: usize) -> u64 {
        row::any(&self.lit(j), self.width() >> self.depth)
    }

    /// True if no sample of row `j` is lit.
    #[must_use]
    #[inline(always)]
    pub fn is_row_dark(&self, j: usize) -> bool {
        if self.coarse { self.halves[0][j] | self.halves[1][j] == 0 } else { self.lit[j] == row::NONE }
    }

    /// Which of the eight rows from `j` on have a lit sample between two samples, as bits.
    #[doc(hidden)]
    #[must_use]
    #[inline(always)]
    pub fn rows_lit_between<S: Simd>(&self, simd: S, j: usize, from: u32, to: u32) -> u32 {
        if self.coarse {
            let span = row::span_of_64(from, to);
            let [low, high] = self.eight_halves(simd, j);
            let (low, high) = (low & u32x8::splat(simd, span as u32), high & u32x8::splat(simd, (span >> 32) as u32));
            return (low | high).simd_ne(u32x8::splat(simd, 0)).to_bitmask() as u32;
        }
        let span = row::span(from, to);
        let mut lit = 0;
        for (k, row) in row::eight(&self.lit, j).iter().enumerate() {
            lit |= u32::from(row::and(row, &span) != row::NONE) << k;
        }
        lit
    }

    /// The rows and samples that contain all lit samples; empty if there are none.
    #[doc(hidden)]
    #[must_use]
    #[inline(always)]
    pub fn lit_bounds<S: Simd>(&self, simd: S) -> LitBounds {
        let (mut rows, mut columns) = (0_u64, row::NONE);
        if self.coarse {
            let zero = u32x8::splat(simd, 0);
            let mut any = [zero; 2];
            for base in (0..self.side()).step_by(EIGHT) {
                let [low, high] = self.eight_halves(simd, base);
                any = [any[0] | low, any[1] | high];
                rows |= u64::from((low | high).simd_ne(zero).to_bitmask() as u32) << base;
            }
            let [low, high]: [[u32; EIGHT]; 2] = [any[0].into(), any[1].into()];
            let or = |lanes: [u32; EIGHT]| lanes.iter().fold(0, |a, b| a | b);
            columns = row::coarse(or(low), or(high));
        } else {
            for (j, row) in self.fine_rows().iter().enumerate() {
                columns = row::with(&columns, row);
                rows |= u64::from(*row != row::NONE) << j;
            }
        }
        let samples = row::bounds(&columns);
        LitBounds { rows: [rows.trailing_zeros(), u64::BITS - rows.leading_zeros()], samples }
    }

    /// The part of a cell that contains samples of its row, as (start, length) in cells.
    pub(crate) fn part_of(&self, i: usize, (from, to): (u32, u32)) -> (f32, f32) {
        let width = (self.width() >> self.depth) as f32;
        let at = |sample: u32| (sample as f32 / width).clamp(i as f32, i as f32 + 1.0);
        let (from, to) = (at(from), at(to));
        (from, (to - from).max(0.0))
    }

    /// Number of samples that emit.
    pub(crate) fn emitting_count(&self) -> u32 {
        (0..self.side()).map(|j| self.emitting[1][j].saturating_sub(self.emitting[0][j])).sum()
    }

    /// Number of samples that are lit.
    #[doc(hidden)]
    #[must_use]
    pub fn lit_count(&self) -> u32 {
        dispatch!(Level::new(), _simd => self.count_lit())
    }

    #[inline(always)]
    fn count_lit(&self) -> u32 {
        if self.coarse {
            let [low, high] = self.halves();
            let both = low.iter().zip(high).map(|(low, high)| u64::from(*low) | u64::from(*high) << 32);
            return both.map(u64::count_ones).sum();
        }
        self.fine_rows().iter().map(row::count).sum()
    }

    /// Marks an opening between samples, with its ends on a line along the rows or across them, in plane coordinates: the mask may show nothing of it,
    /// and is drawn again around it. `line` is the distance of the lines on which openings are looked for.
    pub fn mark_opening(&mut self, ends: [Vec2; 2], line: f32) {
        self.openings.push((ends, line));
    }

    /// The openings that are marked, and the distances of their lines.
    pub(crate) fn openings(&self) -> &[([Vec2; 2], f32)] {
        &self.openings
    }

    /// The area of a sample in plane coordinates.
    pub(crate) fn sample_area(&self) -> f32 {
        self.cell().element_product() * self.side() as f32 / self.width() as f32
    }

    /// Emitting and lit area in cells.
    #[must_use]
    pub fn areas(&self) -> (f32, f32) {
        let (mut emitting, mut lit) = (0, 0);
        for j in 0..self.side() {
            emitting += self.emitting[1][j].saturating_sub(self.emitting[0][j]);
            lit += row::count(&self.lit(j));
        }
        let cell = (self.width() >> self.depth) as f32;
        (emitting as f32 / cell, lit as f32 / cell)
    }

    /// True if no emitting sample is blocked.
    #[must_use]
    pub fn is_lit(&self) -> bool {
        if self.whole_disc && self.coarse {
            let (disc, side) = (&DISCS[1][self.depth as usize], self.side());
            return self.halves.iter().zip(&disc.halves).all(|(a, b)| a[..side] == b[..side]);
        }
        (0..self.side()).all(|j| self.lit(j) == row::span(self.emitting[0][j], self.emitting[1][j]))
    }

    /// True if every emitting sample is blocked.
    #[must_use]
    #[inline(always)]
    pub fn is_dark(&self) -> bool {
        (0..self.side()).all(|j| self.is_row_dark(j))
    }
}

/// Whether an outline is thinner than a window can be.
fn is_thread(outline: &Outline, square: &UnitSquare) -> bool {
    let points = outline.on_plane([square.right, square.up]);
    let (low, high) = points.fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    (high - low).min_element() < THINNEST * (high - low).max_element()
}

/// The inner half-planes of an outline's sides, in its own plane.
fn sides(outline: &Outline, square: &UnitSquare) -> impl Iterator<Item = Vec3> {
    let corners = outline.on_plane([square.right, square.up]);
    let next = corners.clone().cycle().skip(1);
    corners.zip(next).map(|(p, q)| {
        let edge = q - p;
        Vec3::new(-edge.y, edge.x, edge.y * p.x - edge.x * p.y)
    })
}

/// The plane coordinates x below a plane through the receiver, at a height y: from, to.
fn below(n: Vec3, y: f32) -> (f32, f32) {
    let rest = n.y * y + n.z;
    if n.x > 0.0 {
        (f32::NEG_INFINITY, -rest / n.x)
    } else if n.x < 0.0 {
        (-rest / n.x, f32::INFINITY)
    } else if rest <= 0.0 {
        (f32::NEG_INFINITY, f32::INFINITY)
    } else {
        (0.0, 0.0)
    }
}
