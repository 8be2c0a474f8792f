//! Points on a disc, well spread, several sets of them.

use crate::reference::{Sequence, mix};
use crate::wide::LANES;
use core::f64::consts::FRAC_PI_4;

/// Sets to choose from; a point also turns its set by an angle of its own.
const SETS: usize = 16;

/// Eight points of the unit disc: coordinates and squared distance from the middle.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Points {
    pub(super) x: [f32; LANES],
    pub(super) y: [f32; LANES],
    pub(super) square: [f32; LANES],
}

/// Owen-scrambled Sobol' points, mapped to the disc without tearing strata apart (P. Shirley, K. Chiu, *A Low Distortion
/// Map Between Disk and Square*, 1997).
#[derive(Clone, Debug)]
pub(super) struct Discs {
    blocks: Vec<Points>,
    per_set: usize,
}

impl Discs {
    pub(super) fn new(count: u32) -> Self {
        let per_set = (count as usize).div_ceil(LANES);
        let mut blocks = vec![Points::default(); per_set * SETS];
        for (set, blocks) in blocks.chunks_mut(per_set.max(1)).enumerate() {
            let sequence = Sequence::new(mix(0x6c6f_6265, set as u64));
            for i in 0..count {
                let (x, y) = concentric(sequence.get(i, 0), sequence.get(i, 1));
                let (block, lane) = (&mut blocks[i as usize / LANES], i as usize % LANES);
                (block.x[lane], block.y[lane]) = (x as f32, y as f32);
                block.square[lane] = (x * x + y * y) as f32;
            }
        }
        Self { blocks, per_set }
    }

    /// One of the sets.
    pub(super) fn set(&self, number: u64) -> &[Points] {
        &self.blocks[(number % SETS as u64) as usize * self.per_set..][..self.per_set]
    }
}

fn concentric(u: f64, v: f64) -> (f64, f64) {
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    let (r, phi) = if a.abs() > b.abs() {
        (a, FRAC_PI_4 * (b / a))
    } else if b != 0.0 {
        (b, FRAC_PI_4 * (2.0 - a / b))
    } else {
        (0.0, 0.0)
    };
    let (s, c) = phi.sin_cos();
    (r * c, r * s)
}
