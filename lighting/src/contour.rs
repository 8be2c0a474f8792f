use crate::mask::Bits;
use crate::{MAX_DEPTH, Mask};
use glam::{Vec2, Vec3};

const SIDE: usize = 1 << MAX_DEPTH;

/// Fills a [`Mask`] from as few answers as possible to one question: *is the light hidden in this direction?* For
/// strategies that have no spans, such as shadow rays.
///
/// # Method
/// Cells along the rim of what emits are asked for first, since what moves in front of the light enters there; then one
/// cell of each block of a coarse grid. Cells that nobody asked for take the answer of their block. Then the contour is
/// followed: wherever neighbours in a row or column differ, those not asked yet are asked, until both sides of the
/// whole contour are known. Where that shows a thin shape, the grid is made twice as fine and the contour followed
/// again. At last the place where the contour crosses each row is found between two cells by bisection, so that spans
/// end at a fraction of a cell.
///
/// It is the working memory, too: keep one a thread.
#[derive(Clone, Debug)]
pub struct Contour {
    start: usize,
    bisections: u32,
    /// Cells that were asked for.
    known: [u64; SIDE],
    /// Cells that are hidden as far as is known.
    dark: [u64; SIDE],
    emitting: [u64; SIDE],
}

impl Default for Contour {
    /// 8 blocks a side, 2 bisections.
    fn default() -> Self {
        Self::new(8, 2)
    }
}

impl Contour {
    /// `start` coarse blocks a side (made a power of two; at most one a cell), `bisections` questions for each place
    /// where the contour crosses a row.
    #[must_use]
    pub fn new(start: usize, bisections: u32) -> Self {
        let start = start.clamp(1, SIDE).next_power_of_two();
        Self { start, bisections, known: [0; SIDE], dark: [0; SIDE], emitting: [0; SIDE] }
    }

    /// Blocks what is hidden, on top of what the mask has already. `hidden` is asked for unit directions in world space,
    /// inside the mask's window and the light, at most a cell below the horizon. Returns the number of questions.
    pub fn block(&mut self, mask: &mut Mask, mut hidden: impl FnMut(Vec3) -> bool) -> usize {
        let square = *mask.square();
        let mut asked = 0;
        let mut ask = |x: f32, y: f32| {
            asked += 1;
            // The centre of a cell on the rim may be outside.
            let p = Vec2::new(x, y).clamp_length_max(square.disc);
            hidden(square.world(p.extend(1.0)).normalize())
        };
        self.find(mask, &mut ask);
        self.write(mask, &mut ask);
        asked
    }

    /// Decides every cell.
    fn find(&mut self, mask: &Mask, ask: &mut impl FnMut(f32, f32) -> bool) {
        let side = mask.side();
        for j in 0..side {
            (self.known[j], self.dark[j], self.emitting[j]) = (0, 0, mask.emitting_cells(j));
        }
        let mut ask = |i: usize, j: usize| {
            let p = mask.cell_center(i, j);
            ask(p.x, p.y)
        };
        let start = self.start.min(side);
        self.rim(side, &mut ask);
        self.coarse(side, start, &mut ask);
        self.follow(side, &mut ask);
        if start < side && self.is_thin(side) {
            self.coarse(side, 2 * start, &mut ask);
            self.follow(side, &mut ask);
        }
    }

    /// Asks for a cell unless its answer is known.
    fn cell(&mut self, i: usize, j: usize, ask: &mut impl FnMut(usize, usize) -> bool) -> bool {
        let bit = 1 << i;
        if self.known[j] & bit == 0 {
            self.known[j] |= bit;
            self.dark[j] = self.dark[j] & !bit | if ask(i, j) { bit } else { 0 };
        }
        self.dark[j] & bit != 0
    }

    /// Asks for every fourth cell of the rim.
    fn rim(&mut self, side: usize, ask: &mut impl FnMut(usize, usize) -> bool) {
        for j in 0..side {
            let e = self.emitting[j];
            let above = if j + 1 < side { self.emitting[j + 1] } else { 0 };
            let below = if j > 0 { self.emitting[j - 1] } else { 0 };
            for i in Bits(e & !(e << 1 & e >> 1 & above & below)) {
                // Along rows, columns and both diagonals every second or fourth cell.
                if (i + 2 * j) % 4 == 0 {
                    self.cell(i, j, ask);
                }
            }
        }
    }

    /// Asks for one cell of each of `blocks`² blocks; the others follow it.
    fn coarse(&mut self, side: usize, blocks: usize, ask: &mut impl FnMut(usize, usize) -> bool) {
        let size = side / blocks;
        let columns = if size == 64 { u64::MAX } else { (1 << size) - 1 };
        for top in (0..side).step_by(size) {
            for left in (0..side).step_by(size) {
                let Some((i, j)) = self.representative(left, top, size) else { continue };
                let dark = self.cell(i, j, ask);
                for j in top..top + size {
                    let unknown = columns << left & !self.known[j];
                    self.dark[j] = if dark { self.dark[j] | unknown } else { self.dark[j] & !unknown };
                }
            }
        }
    }

    /// The middle cell of a block if it emits, else one that is known, else the emitting cell nearest to the middle.
    fn representative(&self, left: usize, top: usize, size: usize) -> Option<(usize, usize)> {
        let (i, j) = (left + size / 2, top + size / 2);
        if self.emitting[j] >> i & 1 == 1 {
            return Some((i, j));
        }
        let mut best = (usize::MAX, None);
        for y in top..top + size {
            for x in left..left + size {
                let distance = x.abs_diff(i).pow(2) + y.abs_diff(j).pow(2);
                if self.known[y] >> x & 1 == 1 {
                    return Some((x, y));
                }
                if self.emitting[y] >> x & 1 == 1 && distance < best.0 {
                    best = (distance, Some((x, y)));
                }
            }
        }
        best.1
    }

    /// Asks for the unknown ones among neighbours that differ, until none is left.
    fn follow(&mut self, side: usize, ask: &mut impl FnMut(usize, usize) -> bool) {
        let mut open = true;
        while open {
            open = false;
            for j in 0..side {
                let (e, d) = (self.emitting[j], self.dark[j]);
                // Bit i: cells i and i + 1 differ.
                let right = (d ^ d >> 1) & e & e >> 1;
                let mut differ = right | right << 1;
                for k in [j.wrapping_sub(1), j + 1] {
                    if k < side {
                        differ |= (d ^ self.dark[k]) & self.emitting[k];
                    }
                }
                for i in Bits(differ & e & !self.known[j]) {
                    self.cell(i, j, ask);
                    open = true;
                }
            }
        }
    }

    /// Whether a lit or dark run of at most three cells lies between others in a row or column.
    fn is_thin(&self, side: usize) -> bool {
        let mut columns = [0u64; SIDE];
        for j in 0..side {
            let e = self.emitting[j];
            for d in [self.dark[j], !self.dark[j]] {
                let d = d & e;
                let ends = !d & e;
                if (1..=3).any(|n| runs(d, n) & ends << 1 & ends >> n != 0) {
                    return true;
                }
            }
            for i in Bits(self.dark[j] & e) {
                columns[i] |= 1 << j;
            }
        }
        let mut emitting = [0u64; SIDE];
        for j in 0..side {
            for i in Bits(self.emitting[j]) {
                emitting[i] |= 1 << j;
            }
        }
        columns.iter().zip(emitting).any(|(dark, e)| {
            [*dark, !dark & e].into_iter().any(|d| {
                let ends = !d & e;
                (1..=3).any(|n| runs(d, n) & ends << 1 & ends >> n != 0)
            })
        })
    }

    /// Blocks the runs of dark cells, their ends found between two centres.
    fn write(&self, mask: &mut Mask, ask: &mut impl FnMut(f32, f32) -> bool) {
        for j in 0..mask.side() {
            let mut dark = self.dark[j] & self.emitting[j];
            let y = mask.row_y(j);
            while dark != 0 {
                let first = dark.trailing_zeros() as usize;
                let length = (dark >> first).trailing_ones() as usize;
                let end = first + length;
                let mut edge = |dark: usize, lit: usize| {
                    if self.emitting[j] >> lit & 1 == 0 {
                        return None;
                    }
                    let (mut dark, mut lit) = (mask.cell_center(dark, j).x, mask.cell_center(lit, j).x);
                    for _ in 0..self.bisections {
                        let middle = 0.5 * (dark + lit);
                        if ask(middle, y) { dark = middle } else { lit = middle }
                    }
                    Some(0.5 * (dark + lit))
                };
                let from = if first == 0 { None } else { edge(first, first - 1) };
                let to = if end >= mask.side() { None } else { edge(end - 1, end) };
                mask.block_span(j, from.unwrap_or(f32::NEG_INFINITY), to.unwrap_or(f32::INFINITY));
                if end >= SIDE {
                    break;
                }
                dark &= u64::MAX << end;
            }
        }
    }
}

/// Bit i: the n cells from i on are set.
fn runs(d: u64, n: usize) -> u64 {
    (1..n).fold(d, |all, k| all & d >> k)
}
