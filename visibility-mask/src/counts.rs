//! Numbers of emitting and of lit samples in each column of each row: the factors of weights.

use crate::Mask;
use crate::row::{self, EIGHT, Row, SIDE};

/// Blocks of eight columns; each column has one weight. A column of a fine mask has eight samples, of a coarse one four.
pub(crate) const FINE: usize = 4;
pub(crate) const COARSE: usize = 2;

/// Samples of a mask in each column of each row: those that emit and those that are lit.
#[derive(Clone, Debug)]
pub(crate) struct Counts {
    bytes: [u8; SIDE * FINE * EIGHT],
    lit: [f32; SIDE * FINE * EIGHT],
    emitting: [f32; SIDE * FINE * EIGHT],
    /// Depth and width of the mask of a whole disc from which `emitting` was filled, if it was.
    disc: Option<(u32, usize)>,
}

impl Default for Counts {
    fn default() -> Self {
        let none = [0.0; SIDE * FINE * EIGHT];
        Self { bytes: [0; SIDE * FINE * EIGHT], lit: none, emitting: none, disc: None }
    }
}

impl Counts {
    #[inline(always)]
    pub(crate) fn fill<const B: usize>(&mut self, mask: &Mask) {
        let (side, all) = (mask.side(), mask.side() * B * EIGHT);
        let Self { bytes, lit, emitting, disc } = self;
        if B == FINE {
            add_up::<B>(mask.fine_rows().iter().copied(), &mut bytes[..all], &mut lit[..all]);
        } else {
            let [low, high] = mask.halves();
            let rows = low.iter().zip(high).map(|(low, high)| row::coarse(*low, *high));
            add_up::<B>(rows, &mut bytes[..all], &mut lit[..all]);
        }
        let whole = mask.is_whole_disc().then(|| (mask.depth(), mask.width()));
        if whole.is_none() || whole != *disc {
            let rows = (0..side).map(|j| row::span(mask.emitting(j).0, mask.emitting(j).1));
            add_up::<B>(rows, &mut bytes[..all], &mut emitting[..all]);
            *disc = whole;
        }
    }
    /// The columns of each row of the mask, in blocks of eight: lit samples, and emitting samples.
    #[inline(always)]
    pub(crate) fn rows<const B: usize>(&self, mask: &Mask) -> impl Iterator<Item = (&[[f32; EIGHT]], &[[f32; EIGHT]])> {
        let (lit, _) = self.lit.as_chunks::<EIGHT>();
        let (emitting, _) = self.emitting.as_chunks::<EIGHT>();
        lit.chunks_exact(B).zip(emitting.chunks_exact(B)).take(mask.side())
    }
}

/// Sums the bits of each byte or, in coarse rows, half byte, in pairs, fours and eights. The even half bytes come first, then the
/// odd ones.
#[inline(always)]
fn add_up<const B: usize>(rows: impl Iterator<Item = Row>, bytes: &mut [u8], out: &mut [f32]) {
    for (row, bytes) in rows.zip(bytes.chunks_exact_mut(B * EIGHT)) {
        let mut words = row.0;
        for word in &mut words {
            let pairs = *word - (*word >> 1 & 0x5555_5555_5555_5555);
            *word = (pairs & 0x3333_3333_3333_3333) + (pairs >> 2 & 0x3333_3333_3333_3333);
        }
        if B == FINE {
            for word in &mut words {
                *word = (*word + (*word >> 4)) & 0x0f0f_0f0f_0f0f_0f0f;
            }
        } else {
            words[1] = words[0] >> 4 & 0x0f0f_0f0f_0f0f_0f0f;
            words[0] &= 0x0f0f_0f0f_0f0f_0f0f;
        }
        for (word, bytes) in words.iter().zip(bytes.chunks_exact_mut(EIGHT)) {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
    }
    for (out, byte) in out.iter_mut().zip(bytes) {
        *out = f32::from(*byte);
    }
}

/// Plane coordinates x of the columns' centres, in the order of the counts.
#[inline(always)]
pub(crate) fn middles<const B: usize>(mask: &Mask) -> [[f32; EIGHT]; B] {
    let square = mask.square();
    let width = 2.0 * square.half.x / (B * EIGHT) as f32;
    let left = square.center.x - square.half.x + 0.5 * width;
    let mut x = [[0.0; EIGHT]; B];
    for (block, x) in x.iter_mut().enumerate() {
        for (k, x) in x.iter_mut().enumerate() {
            let column = if B == FINE { block * EIGHT + k } else { k * B + block };
            *x = left + width * column as f32;
        }
    }
    x
}
