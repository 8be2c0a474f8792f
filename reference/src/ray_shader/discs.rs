//! Points on a disc, well spread, several sets of them.

use crate::cone::concentric;
use crate::sobol::{Sequence, mix};
use lobe_core::vec3x8::LANES;

/// Sets to choose from; a point also turns its set by an angle of its own.
const SETS: usize = 16;

/// Eight points of the unit disc: coordinates and squared distance from the middle.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Points {
    pub(super) x: [f32; LANES],
    pub(super) y: [f32; LANES],
    pub(super) square: [f32; LANES],
}

/// Owen-scrambled Sobol' points, mapped to the disc [concentrically](concentric).
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
                let (r, phi) = concentric(sequence.get(i, 0), sequence.get(i, 1));
                let (sin, cos) = phi.sin_cos();
                let (x, y) = (r * cos, r * sin);
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
