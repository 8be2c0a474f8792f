use crate::FrameBlockers;
use glam::Vec2;
use lighting::Light;
use lobe_core::Receiver;
use shading::{Accuracy, Coverage, LightId, LightLobes, VisibilityQuery};

/// A light as a point sees it: which parts of it blockers hide.
#[derive(Clone, Debug, PartialEq)]
pub struct LightMask {
    /// How much of the light is seen.
    pub coverage: Coverage,
    /// Samples in a row, and rows.
    pub size: [usize; 2],
    /// The samples, row by row from the top.
    pub samples: Vec<MaskSample>,
    /// Width and height of the window before the light, as tangents.
    pub sides: Vec2,
}

/// A sample of a [`LightMask`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MaskSample {
    /// Beside the light, or below the horizon.
    Outside,
    /// The light is seen.
    Lit,
    /// A blocker hides it.
    Blocked,
}

/// Samples in a word of a mask.
const WORD: usize = 64;
/// Rows that a mask gives at once.
const EIGHT: usize = 8;
/// Words in a row.
const WORDS: usize = 4;

impl LightMask {
    pub(crate) fn new(
        blockers: FrameBlockers<'_>,
        at: &Receiver,
        (id, light): (LightId, &Light),
        accuracy: Accuracy,
    ) -> Self {
        let seen = light.seen_from(at);
        let (cone, outline, image) = (&seen.cone, seen.outline.as_ref(), light.image());
        let (coverage, mask) = blockers.mask(&VisibilityQuery { at, light: id, cone, outline, image, accuracy });
        let (rows, width) = (mask.side(), WORD * WORDS);
        let mut samples = Vec::with_capacity(rows * width);
        let mut words = [[0; EIGHT]; WORDS];
        // Row 0 of a mask is at the bottom.
        for row in (0..rows).rev() {
            mask.lit_rows(row - row % EIGHT, &mut words);
            let (from, to) = mask.emitting(row);
            samples.extend((0..width).map(|column| match words[column / WORD][row % EIGHT] >> (column % WORD) & 1 {
                1 => MaskSample::Lit,
                _ if (from..to).contains(&(column as u32)) => MaskSample::Blocked,
                _ => MaskSample::Outside,
            }));
        }
        Self { coverage, size: [width, rows], samples, sides: 2.0 * mask.square().half }
    }

    /// The part of the samples on the light that are lit: the visible fraction of the light's area before the point. 0 where nothing of
    /// the light is above the horizon.
    #[must_use]
    pub fn lit(&self) -> f32 {
        let count = |kind| self.samples.iter().filter(|sample| **sample == kind).count() as f32;
        let lit = count(MaskSample::Lit);
        lit / (lit + count(MaskSample::Blocked)).max(1.0)
    }
}
