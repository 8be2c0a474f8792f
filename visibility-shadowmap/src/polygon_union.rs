//! The union of convex polygons, before they are drawn into the mask.

use glam::Vec2;
use visibility_mask::{MAX_DEPTH, Mask, Raster};

/// Samples in a cell: columns in a line, and lines.
pub(crate) const ACROSS: usize = 16;
pub(crate) const LINES: usize = 4;
const SIDE: usize = 1 << MAX_DEPTH;
/// Cells in a word.
const CELLS: usize = 64 / ACROSS;

/// Samples of the mask's window as bits: the union of any number of polygons in any order is exact, and polygons with a
/// common edge leave no gap.
///
/// A texel covers a fraction of a cell. In a [`Mask`] a cell's open part is one interval, so that many texels would combine as if
/// placed at random. Here their union is exact, and the mask gets the area that it covers.
#[derive(Clone, Debug)]
pub(crate) struct PolygonUnion {
    side: usize,
    /// Words in a line.
    words: usize,
    bits: Vec<u64>,
    low: Vec2,
    scale: Vec2,
    spans: Vec<(f32, f32)>,
}

impl Default for PolygonUnion {
    fn default() -> Self {
        Self {
            side: 0,
            words: 0,
            bits: vec![0; SIDE * LINES * SIDE / CELLS],
            low: Vec2::ZERO,
            scale: Vec2::ONE,
            spans: vec![(0.0, 0.0); SIDE * LINES],
        }
    }
}

impl PolygonUnion {
    /// Clears the union, for a mask's window.
    pub(crate) fn begin(&mut self, mask: &Mask) {
        let square = mask.square();
        self.side = mask.side();
        self.words = self.side.div_ceil(CELLS);
        self.low = square.center - square.half;
        self.scale = Vec2::new(ACROSS as f32, LINES as f32) / mask.cell();
        self.bits[..self.side * LINES * self.words].fill(0);
    }

    /// Whether every sample between two corners, in plane coordinates, is covered.
    #[inline(always)]
    pub(crate) fn is_covered(&self, low: Vec2, high: Vec2) -> bool {
        let (low, high) = ((low - self.low) * self.scale, (high - self.low) * self.scale);
        let (lines, columns) = ((self.side * LINES) as f32, (self.side * ACROSS) as f32);
        let (first, end) = (low.y.clamp(0.0, lines) as usize, up(high.y.clamp(0.0, lines)));
        let (from, to) = (low.x.clamp(0.0, columns) as usize, up(high.x.clamp(0.0, columns)));
        from >= to || (first..end).all(|k| is_set(&self.bits[k * self.words..(k + 1) * self.words], from, to))
    }

    /// Adds a convex polygon in plane coordinates. Edge k, from corner k to the next one, moves outward by `grow[k]`; edges after
    /// the fourth do not move.
    #[inline(always)]
    pub(crate) fn polygon(&mut self, points: &mut [Vec2], grow: [f32; 4]) {
        let count = points.len();
        let grows = grow != [0.0; 4];
        let lines = (self.side * LINES) as f32;
        let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for p in points.iter_mut() {
            *p = (*p - self.low) * self.scale;
            (low, high) = (low.min(*p), high.max(*p));
        }
        if grows {
            let most = grow.into_iter().fold(0.0, f32::max) * self.scale.x;
            let (above, below) = (ends(points, grow, high.y), ends(points, grow, low.y));
            low -= Vec2::new(most, below * self.scale.y);
            high += Vec2::new(most, above * self.scale.y);
        }
        // Lines are sampled at their centres: k + ½ in (low, high].
        let line = |y: f32| (y.clamp(0.0, lines) + 0.5) as usize;
        let (first, end) = (line(low.y), line(high.y));
        if first >= end {
            return;
        }
        self.spans[first..end].fill((f32::INFINITY, f32::NEG_INFINITY));
        for k in 0..count {
            let (a, b) = (points[k], points[if k + 1 < count { k + 1 } else { 0 }]);
            // Neighbours on both sides of an edge compute it by the same arithmetic.
            let (a, b) = if (a.y, a.x) <= (b.y, b.x) { (a, b) } else { (b, a) };
            let (from, to) = (line(a.y), line(b.y));
            if from >= to {
                continue;
            }
            let slope = (b.x - a.x) / (b.y - a.y);
            // The shift of the edge along its normal, measured along the line.
            let aside = match grow.get(k) {
                Some(&g) if g > 0.0 => {
                    let g = self.scale * g;
                    (g.x * g.x + slope * slope * g.y * g.y).sqrt()
                }
                _ => 0.0,
            };
            for (k, span) in self.spans[from..to].iter_mut().enumerate() {
                let x = a.x + ((from + k) as f32 + 0.5 - a.y) * slope;
                *span = (span.0.min(x - aside), span.1.max(x + aside));
            }
        }
        if grows {
            self.fill_ends(first, end, low.x, high.x);
        }
        let columns = (self.side * ACROSS) as f32;
        for k in first..end {
            let (from, to) = self.spans[k];
            let column = |x: f32| (x.clamp(0.0, columns) + 0.5) as usize;
            let (from, to) = (column(from), column(to));
            if from < to {
                set(&mut self.bits[k * self.words..(k + 1) * self.words], from, to);
            }
        }
    }

    /// Lines that only the growth reaches take the span of the line next to them, or else the whole range; all are limited to the
    /// range from `low` to `high`.
    #[inline(always)]
    fn fill_ends(&mut self, first: usize, end: usize, low: f32, high: f32) {
        let spans = &mut self.spans[first..end];
        let whole = |span: &(f32, f32)| span.0 <= span.1;
        let begin = spans.iter().position(whole);
        let last = spans.iter().rposition(whole);
        let (Some(begin), Some(last)) = (begin, last) else {
            spans.fill((low, high));
            return;
        };
        let (a, b) = (spans[begin], spans[last]);
        spans[..begin].fill(a);
        spans[last + 1..].fill(b);
        for span in spans {
            *span = (span.0.max(low), span.1.min(high));
        }
    }

    /// Blocks the covered part of the mask.
    pub(crate) fn write(&self, mask: &mut Mask) {
        let cell = mask.cell().x;
        for j in 0..self.side {
            if mask.emitting_cells(j) == 0 {
                continue;
            }
            let lines: [&[u64]; LINES] =
                core::array::from_fn(|k| &self.bits[(j * LINES + k) * self.words..(j * LINES + k + 1) * self.words]);
            // Start of the run of fully covered cells.
            let mut run = None;
            let x = |i: usize| self.low.x + i as f32 * cell;
            for word in 0..self.words {
                let (any, all) = lines.iter().fold((0, u64::MAX), |(any, all), l| (any | l[word], all & l[word]));
                let cells = word * CELLS..((word + 1) * CELLS).min(self.side);
                if all == u64::MAX {
                    run = run.or(Some(cells.start));
                    continue;
                }
                if any == 0 {
                    if let Some(start) = run.take() {
                        mask.block_span(j, x(start), x(cells.start));
                    }
                    continue;
                }
                for i in cells {
                    let covered = covered(&lines, i);
                    let count = covered.count_ones();
                    if count as usize == LINES * ACROSS {
                        run = run.or(Some(i));
                        continue;
                    }
                    if let Some(start) = run.take() {
                        mask.block_span(j, x(start), x(i));
                    }
                    if covered != 0 {
                        // Blocks the covered fraction at the side where more of it is. Its end is shifted among the cell's samples
                        // from cell to cell, or a whole row would round in the same way.
                        let part = cell * count as f32 / (LINES * ACROSS) as f32;
                        let shift = (Raster::shift(i) + Raster::shift(j)) / mask.raster().samples;
                        if (covered & 0x00ff_00ff_00ff_00ff).count_ones() * 2 >= count {
                            mask.block_span(j, x(i), x(i) + part + shift);
                        } else {
                            mask.block_span(j, x(i + 1) - part + shift, x(i + 1));
                        }
                    }
                }
            }
            if let Some(start) = run {
                mask.block_span(j, x(start), f32::INFINITY);
            }
        }
    }
}

/// The samples of cell `i` of a row: 16 bits a line.
fn covered(lines: &[&[u64]; LINES], i: usize) -> u64 {
    let (word, shift) = (i / CELLS, i % CELLS * ACROSS);
    lines.iter().enumerate().map(|(k, line)| (line[word] >> shift & 0xffff) << (16 * k)).sum()
}

/// The shift up or down of the corner at height `y`: the smaller one of its two edges.
fn ends(points: &[Vec2], grow: [f32; 4], y: f32) -> f32 {
    let corner = points.iter().position(|p| p.y == y).unwrap_or(0);
    let of = |k: usize| grow.get(k % points.len()).copied().unwrap_or(0.0);
    of(corner).min(of(corner + points.len() - 1))
}

/// Rounds up, for x ≥ 0.
fn up(x: f32) -> usize {
    let whole = x as usize;
    whole + usize::from(x > whole as f32)
}

/// The words of bits `from..to`, which is not empty, and the bits in the first and the last word.
fn word_range(from: usize, to: usize) -> (usize, usize, u64, u64) {
    (from / 64, (to - 1) / 64, u64::MAX << (from % 64), u64::MAX >> (63 - (to - 1) % 64))
}

fn is_set(line: &[u64], from: usize, to: usize) -> bool {
    let (first, last, head, tail) = word_range(from, to);
    if first == last {
        line[first] & head & tail == head & tail
    } else {
        line[first] & head == head && line[last] & tail == tail && line[first + 1..last].iter().all(|w| *w == u64::MAX)
    }
}

fn set(line: &mut [u64], from: usize, to: usize) {
    let (first, last, head, tail) = word_range(from, to);
    if first == last {
        line[first] |= head & tail;
    } else {
        line[first] |= head;
        line[first + 1..last].fill(u64::MAX);
        line[last] |= tail;
    }
}
