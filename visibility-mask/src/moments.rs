//! Moments of quad-tree nodes, from bits.

use crate::row;
use crate::{MAX_DEPTH, Mask, UnitSquare};
use glam::Vec3;
use lobe_core::exponent_of_spread;

/// The moments of a set of mask cells, from which its moment lobe is computed.
///
/// Stores `Ω − M·axis` instead of `M·axis`, since the spread of a small light's nodes is a difference in the seventh digit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Moments {
    /// Solid angle Ω, sr.
    pub(crate) omega: f32,
    /// Mean vector `∫ v dΩ` along the square's right and up.
    pub(crate) x: f32,
    pub(crate) y: f32,
    /// `∫ (1 − v·axis) dΩ`.
    pub(crate) defect: f32,
}

impl core::ops::AddAssign for Moments {
    fn add_assign(&mut self, other: Self) {
        self.omega += other.omega;
        self.x += other.x;
        self.y += other.y;
        self.defect += other.defect;
    }
}

/// A set of cells as one lobe: unit axis in the square's frame, exponent, `1 − R`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NodeLobe {
    pub(crate) axis: Vec3,
    pub(crate) exponent: f32,
    pub(crate) spread: f32,
}

impl Moments {
    /// The moment lobe's axis and exponent; `cell` is a lower bound of the spread (a set has at least one cell).
    pub(crate) fn lobe(&self, cell: f32) -> NodeLobe {
        let z = self.omega - self.defect;
        let aside = self.x * self.x + self.y * self.y;
        // Ω² − |M|² = Ω²(1−R)(1+R).
        let rest = (2.0 * self.omega - self.defect) * self.defect - aside;
        let length = (aside + z * z).sqrt();
        let spread = (rest / (self.omega * (self.omega + length))).max(cell * cell / 24.0);
        NodeLobe {
            axis: Vec3::new(self.x, self.y, z) / length.max(f32::MIN_POSITIVE),
            exponent: exponent_of_spread(spread),
            spread,
        }
    }
}

/// Number, sum of positions, sum of squared positions of the set bits of a byte.
const BYTE: [[u8; 3]; 256] = {
    let mut table = [[0; 3]; 256];
    let mut byte = 0;
    while byte < 256 {
        let mut bit = 0;
        while bit < 8 {
            if byte >> bit & 1 == 1 {
                table[byte][0] += 1;
                table[byte][1] += bit as u8;
                table[byte][2] += (bit * bit) as u8;
            }
            bit += 1;
        }
        byte += 1;
    }
    table
};

/// The samples over which a sum is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    /// Emitting samples.
    Emitting,
    /// Emitting samples that are not blocked.
    Lit,
}

/// Whether a block's cells are too far apart, seen from the receiver, to be summed together; only for wide lights.
fn is_wide(mask: &Mask, x0: usize, y0: usize, size: usize) -> bool {
    let side = size as f32 * mask.cell();
    let middle = mask.cell_center(x0, y0) + 0.5 * (side - mask.cell());
    side.max_element().powi(2) > 0.06 * (1.0 + middle.length_squared())
}

/// Moments of a square block of `size` ≤ 8 cells.
pub(crate) fn block(mask: &Mask, part: Part, x0: usize, y0: usize, size: usize) -> Moments {
    if size > 1 && is_wide(mask, x0, y0, size) {
        let half = size / 2;
        let mut sum = Moments::default();
        for (dx, dy) in [(0, 0), (half, 0), (0, half), (half, half)] {
            sum += block(mask, part, x0 + dx, y0 + dy, half);
        }
        return sum;
    }
    Sums::new(mask, part, x0, y0, size).moments(mask, x0, y0)
}

/// Number, first and second moments of a block's samples, in columns of samples and rows from its first sample: independent of the
/// light's size.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    count: u32,
    x: u32,
    y: u32,
    xx: u32,
    yy: u32,
}

impl Sums {
    fn new(mask: &Mask, part: Part, x0: usize, y0: usize, size: usize) -> Self {
        let width = mask.width() / mask.side();
        let (from, to) = (x0 * width, (x0 + size) * width);
        let mut sums = Self::default();
        for dy in 0..size as u32 {
            let j = y0 + dy as usize;
            let row = match part {
                Part::Emitting => {
                    let (from, to) = mask.emitting(j);
                    row::span(from, to)
                }
                Part::Lit => mask.lit(j),
            };
            let (mut count, mut x, mut xx) = (0, 0, 0);
            let mut at = from;
            while at < to {
                // A byte, or a cell if it is smaller.
                let byte = (row.0[at / 64] >> (at % 64)) as usize & ((1 << width.min(8)) - 1);
                let [n, sum, squares] = BYTE[byte].map(u32::from);
                let offset = (at - from) as u32;
                count += n;
                x += sum + offset * n;
                xx += squares + offset * (2 * sum + offset * n);
                at += width.min(8);
            }
            sums.count += count;
            sums.x += x;
            sums.xx += xx;
            sums.y += count * dy;
            sums.yy += count * dy * dy;
        }
        sums
    }

    /// The cells of a block are close together: their solid angle `dA/(1+x²+y²)^{3/2}` and the defect are computed at the mean of
    /// x²+y², their mean vector at the centroid.
    fn moments(&self, mask: &Mask, x0: usize, y0: usize) -> Moments {
        if self.count == 0 {
            return Moments::default();
        }
        let cell = mask.cell();
        let sample = cell.x * (mask.side() as f32 / mask.width() as f32);
        let inverse = 1.0 / self.count as f32;
        let (mx, my) = (self.x as f32 * inverse, self.y as f32 * inverse);
        let (xx, yy) = (self.xx as f32 * inverse - mx * mx, self.yy as f32 * inverse - my * my);
        let variance = (xx.max(0.0) + 1.0 / 12.0) * sample * sample + (yy.max(0.0) + 1.0 / 12.0) * cell.y * cell.y;
        let origin = mask.cell_center(x0, y0);
        let (px, py) = (origin.x - 0.5 * cell.x + (mx + 0.5) * sample, origin.y + my * cell.y);
        let s = px * px + py * py + variance;
        let q_sq = 1.0 / (1.0 + s);
        let q = q_sq.sqrt();
        let omega = self.count as f32 * sample * cell.y * q * q_sq;
        Moments { omega, x: omega * q * px, y: omega * q * py, defect: omega * s * q_sq / (1.0 + q) }
    }
}

/// The sums of an uncut disc's blocks, computed once for a depth.
#[derive(Clone, Debug, Default)]
pub(crate) struct Discs {
    depths: [Vec<Sums>; MAX_DEPTH as usize + 1],
}

impl Discs {
    /// The blocks of `size` cells, row by row. `mask` shows a whole disc.
    fn get(&mut self, mask: &Mask, size: usize) -> &[Sums] {
        let sums = &mut self.depths[mask.depth() as usize];
        if sums.is_empty() {
            // Not computed from the mask that happens to come first, whose disc is rounded in its own way: no result may depend on
            // the order of receivers.
            let mut disc = Mask::default();
            disc.reset(&UnitSquare::default(), mask.depth(), Vec3::Z);
            let side = disc.side() / size;
            let blocks = (0..side * side).map(|i| (i % side * size, i / side * size));
            sums.extend(blocks.map(|(x0, y0)| Sums::new(&disc, Part::Emitting, x0, y0, size)));
        }
        sums
    }
}

/// The upper levels of a mask's quad-tree: level `l` has `4^l` nodes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pyramid {
    levels: [Vec<Moments>; LEVELS],
    top: usize,
}

/// Levels 0…3: the finest has at most 8 × 8 nodes of at most 8 × 8 cells.
const LEVELS: usize = 4;

impl Pyramid {
    /// Sums the moments of the emitting samples, from blocks up.
    pub(crate) fn build_emitting(&mut self, mask: &Mask, discs: &mut Discs) {
        self.build(mask, |x0, y0, size, index| {
            // A disc in its own window has the same samples for all lights.
            if mask.is_whole_disc() && !is_wide(mask, x0, y0, size) {
                discs.get(mask, size)[index].moments(mask, x0, y0)
            } else {
                block(mask, Part::Emitting, x0, y0, size)
            }
        });
    }

    /// Sums the moments of the lit samples; a block without blockers takes those of `emitting`.
    pub(crate) fn build_lit(&mut self, mask: &Mask, emitting: &Self) {
        let finest = &emitting.levels[emitting.top];
        self.build(mask, |x0, y0, size, index| {
            let columns = mask.width() / mask.side();
            let node = row::span((x0 * columns) as u32, ((x0 + size) * columns) as u32);
            let (mut untouched, mut dark) = (true, true);
            for j in y0..y0 + size {
                let (from, to) = mask.emitting(j);
                let lit = row::and(&mask.lit(j), &node);
                untouched &= lit == row::and(&row::span(from, to), &node);
                dark &= lit == row::NONE;
            }
            if untouched {
                finest[index]
            } else if dark {
                Moments::default()
            } else {
                block(mask, Part::Lit, x0, y0, size)
            }
        });
    }

    /// `block(x0, y0, size, index)` returns the finest nodes.
    fn build(&mut self, mask: &Mask, mut block: impl FnMut(usize, usize, usize, usize) -> Moments) {
        self.top = (mask.depth() as usize).min(LEVELS - 1);
        let side = 1usize << self.top;
        let size = mask.side() / side;
        let finest = &mut self.levels[self.top];
        finest.clear();
        for y in 0..side {
            for x in 0..side {
                finest.push(block(x * size, y * size, size, y * side + x));
            }
        }
        for level in (0..self.top).rev() {
            let side = 1usize << level;
            let (coarse, fine) = self.levels.split_at_mut(level + 1);
            let (coarse, fine) = (&mut coarse[level], &fine[0]);
            coarse.clear();
            for y in 0..side {
                for x in 0..side {
                    let mut sum = Moments::default();
                    for child in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                        sum += fine[(2 * y + child.1) * 2 * side + 2 * x + child.0];
                    }
                    coarse.push(sum);
                }
            }
        }
    }

    /// The node `(x, y)` of a level that the pyramid holds.
    pub(crate) fn get(&self, level: usize, x: usize, y: usize) -> Option<Moments> {
        (level <= self.top).then(|| self.levels[level][(y << level) + x])
    }
}
