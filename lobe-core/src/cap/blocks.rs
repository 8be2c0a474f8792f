use super::chord::{self, Chord};
use super::pair::Pair;
use super::{Form, Seen, finish, lambert, slab};
use crate::lanes::{Block, Lane, WIDTH, map, row};
use core::f32::consts::FRAC_1_PI;
use fearless_simd::{Level, dispatch};

/// Integrals that wait for others of their kind: a block of each kind, evaluated when it is full.
pub(super) struct Blocks {
    crossed: Block<2>,
    slab: Block<12>,
    whole: Block<12>,
    few: Block<14>,
    many: Block<14>,
    piece: Block<14>,
    edge: Block<14>,
}

impl Blocks {
    pub(super) const fn new() -> Self {
        Self {
            crossed: Block::new(),
            slab: Block::new(),
            whole: Block::new(),
            few: Block::new(),
            many: Block::new(),
            piece: Block::new(),
            edge: Block::new(),
        }
    }

    /// Takes an integral; its value will be added to `out[k]`.
    #[inline(always)]
    pub(super) fn push(&mut self, level: Level, form: Form, pair: &Pair, light: &Seen, k: usize, out: &mut [f32]) {
        match form {
            Form::Slab => {
                if self.slab.push(bytemuck::cast(*pair), k) {
                    self.slab(level, out);
                }
            }
            Form::Whole => {
                if self.whole.push(bytemuck::cast(*pair), k) {
                    self.whole(level, out);
                }
            }
            Form::Crossed => {
                if self.crossed.push([light.cos_beta, light.sin_sq], k) {
                    self.crossed(level, out);
                }
            }
            _ => self.push_pieces(level, form, pair, k, out),
        }
    }

    #[cold]
    #[inline(never)]
    fn push_pieces(&mut self, level: Level, form: Form, pair: &Pair, k: usize, out: &mut [f32]) {
        for piece in Chord::pieces(pair) {
            let row = bytemuck::cast(piece);
            if matches!(form, Form::Edge) {
                if self.edge.push(row, k) {
                    sum::<{ chord::EDGE }, true>(level, &mut self.edge, out);
                }
            } else if self.piece.push(row, k) {
                sum::<{ chord::PIECE }, true>(level, &mut self.piece, out);
            }
        }
    }

    /// Evaluates what still waits.
    pub(super) fn finish(&mut self, level: Level, out: &mut [f32]) {
        self.whole(level, out);
        self.slab(level, out);
        self.crossed(level, out);
        sum::<{ chord::FEW }, false>(level, &mut self.few, out);
        sum::<{ chord::MANY }, false>(level, &mut self.many, out);
        sum::<{ chord::PIECE }, true>(level, &mut self.piece, out);
        sum::<{ chord::EDGE }, true>(level, &mut self.edge, out);
    }

    fn crossed(&mut self, level: Level, out: &mut [f32]) {
        if self.crossed.len > 0 {
            let [values] = map::<Crossed, 2, 1>(level, &self.crossed.columns);
            self.crossed.flush(&values, out);
        }
    }

    fn slab(&mut self, level: Level, out: &mut [f32]) {
        if self.slab.len > 0 {
            let [values] = map::<Slab, 12, 1>(level, &self.slab.columns);
            self.slab.flush(&values, out);
        }
    }

    /// From axes to chords, which then wait with those that want as many nodes.
    fn whole(&mut self, level: Level, out: &mut [f32]) {
        if self.whole.len == 0 {
            return;
        }
        let chords = map::<Whole, 12, 14>(level, &self.whole.columns);
        for j in 0..self.whole.len {
            // The weight is the first of a chord's numbers.
            if chords[0][j] <= 0.0 {
                continue;
            }
            let (row, k) = (row(&chords, j), self.whole.of[j] as usize);
            if bytemuck::cast::<_, Chord>(row).is_narrow() {
                if self.few.push(row, k) {
                    sum::<{ chord::FEW }, false>(level, &mut self.few, out);
                }
            } else if self.many.push(row, k) {
                sum::<{ chord::MANY }, false>(level, &mut self.many, out);
            }
        }
        self.whole.len = 0;
    }
}

struct Crossed;
impl Lane<2, 1> for Crossed {
    #[inline(always)]
    fn value([cos_beta, sin_sq]: [f32; 2]) -> [f32; 1] {
        [lambert::through_horizon(cos_beta, sin_sq) * FRAC_1_PI]
    }
}

struct Slab;
impl Lane<12, 1> for Slab {
    #[inline(always)]
    fn value(row: [f32; 12]) -> [f32; 1] {
        [slab::slab(&bytemuck::cast::<_, Pair>(row))]
    }
}

struct Whole;
impl Lane<12, 14> for Whole {
    #[inline(always)]
    fn value(row: [f32; 12]) -> [f32; 14] {
        bytemuck::cast(Chord::whole(&bytemuck::cast::<_, Pair>(row)))
    }
}

/// The chord sums of a block.
fn sum<const N: usize, const CUT: bool>(level: Level, block: &mut Block<14>, out: &mut [f32]) {
    if block.len == 0 {
        return;
    }
    let nodes = const { chord::nodes::<N>() };
    let columns = &block.columns;
    let sums = dispatch!(level, _simd => {
        let mut sums = [0.0; WIDTH];
        for (cos, sin) in nodes {
            for (j, sum) in sums.iter_mut().enumerate() {
                let chord: Chord = bytemuck::cast(row(columns, j));
                *sum += chord.node::<CUT>(cos, sin);
            }
        }
        sums
    });
    let values: [f32; WIDTH] = core::array::from_fn(|j| finish(columns[0][j], sums[j]));
    block.flush(&values, out);
}
