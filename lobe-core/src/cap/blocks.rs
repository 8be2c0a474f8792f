use super::chord::{self, Chord};
use super::pair::Pair;
use super::{Form, finish, lambert, slab};
use crate::lanes::{Block, Lane, WIDTH, map, row};
use core::f32::consts::FRAC_1_PI;
use fearless_simd::{Level, dispatch};

/// Integrals that wait for others of their kind: a block of each kind, evaluated when it is full.
pub(super) struct Blocks {
    level: Level,
    crossed: Block<2>,
    slab: Block<12>,
    whole: Block<12>,
    few: Block<14>,
    many: Block<14>,
    piece: Block<14>,
    edge: Block<14>,
}

impl Blocks {
    pub(super) fn new(level: Level) -> Self {
        Self {
            level,
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
    pub(super) fn push(&mut self, form: &Form, k: usize, out: &mut [f32]) {
        match form {
            Form::Done(value) => out[k] += value,
            Form::Slab(pair) => {
                if self.slab.push(bytemuck::cast(*pair), k) {
                    self.slab(out);
                }
            }
            Form::Whole(pair) => {
                if self.whole.push(bytemuck::cast(*pair), k) {
                    self.whole(out);
                }
            }
            other => self.push_crossed(other, k, out),
        }
    }

    /// The rarer forms.
    #[cold]
    #[inline(never)]
    fn push_crossed(&mut self, form: &Form, k: usize, out: &mut [f32]) {
        match form {
            Form::Crossed { cos_beta, sin_sq } => {
                if self.crossed.push([*cos_beta, *sin_sq], k) {
                    self.crossed(out);
                }
            }
            Form::Pieces(pair) => {
                for piece in Chord::pieces(pair) {
                    if self.piece.push(bytemuck::cast(piece), k) {
                        sum::<{ chord::PIECE }, true>(self.level, &mut self.piece, out);
                    }
                }
            }
            Form::Edge(pair) => {
                for piece in Chord::pieces(pair) {
                    if self.edge.push(bytemuck::cast(piece), k) {
                        sum::<{ chord::EDGE }, true>(self.level, &mut self.edge, out);
                    }
                }
            }
            Form::Done(_) | Form::Slab(_) | Form::Whole(_) => {}
        }
    }

    /// Evaluates what still waits.
    pub(super) fn finish(mut self, out: &mut [f32]) {
        self.whole(out);
        self.slab(out);
        self.crossed(out);
        sum::<{ chord::FEW }, false>(self.level, &mut self.few, out);
        sum::<{ chord::MANY }, false>(self.level, &mut self.many, out);
        sum::<{ chord::PIECE }, true>(self.level, &mut self.piece, out);
        sum::<{ chord::EDGE }, true>(self.level, &mut self.edge, out);
    }

    fn crossed(&mut self, out: &mut [f32]) {
        if self.crossed.len > 0 {
            let [values] = map::<Crossed, 2, 1>(self.level, &self.crossed.columns);
            self.crossed.flush(&values, out);
        }
    }

    fn slab(&mut self, out: &mut [f32]) {
        if self.slab.len > 0 {
            let [values] = map::<Slab, 12, 1>(self.level, &self.slab.columns);
            self.slab.flush(&values, out);
        }
    }

    /// From axes to chords, which then wait with those that want as many nodes.
    fn whole(&mut self, out: &mut [f32]) {
        if self.whole.len == 0 {
            return;
        }
        let chords = map::<Whole, 12, 14>(self.level, &self.whole.columns);
        for j in 0..self.whole.len {
            // The weight is the first of a chord's numbers.
            if chords[0][j] <= 0.0 {
                continue;
            }
            let (row, k) = (row(&chords, j), self.whole.of[j]);
            if bytemuck::cast::<_, Chord>(row).is_narrow() {
                if self.few.push(row, k) {
                    sum::<{ chord::FEW }, false>(self.level, &mut self.few, out);
                }
            } else if self.many.push(row, k) {
                sum::<{ chord::MANY }, false>(self.level, &mut self.many, out);
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
    let mut sums = [0.0; WIDTH];
    let columns = &block.columns;
    dispatch!(level, _simd => {
        for (cos, sin) in nodes {
            for (j, sum) in sums.iter_mut().enumerate() {
                let chord: Chord = bytemuck::cast(row(columns, j));
                *sum += chord.node::<CUT>(cos, sin);
            }
        }
    });
    let values: [f32; WIDTH] = core::array::from_fn(|j| finish(columns[0][j], sums[j]));
    block.flush(&values, out);
}
