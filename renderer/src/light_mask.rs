use crate::FrameBlockers;
use glam::{Vec2, Vec3};
use lighting::Light;
use lobe_core::Receiver;
use shading::{Accuracy, Coverage, LightId, LightLobes, VisibilityQuery};
use visibility_mask::UnitSquare;

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
    /// The window: the plane before the point on which the samples lie.
    pub square: UnitSquare,
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
        let square = *mask.square();
        Self { coverage, size: [width, rows], samples, sides: 2.0 * square.half, square }
    }

    /// The unit direction toward a place in the window: columns from the left, rows from the top. The middle of a sample is half a column and half
    /// a row behind its number:
    ///
    /// ```text
    /// d = (x·right + y·up + axis)/√(1 + x² + y²)
    /// ```
    #[must_use]
    pub fn direction(&self, column: f32, row: f32) -> Vec3 {
        let UnitSquare { right, up, axis, center, half, .. } = self.square;
        let [width, rows] = self.size.map(|side| side.max(1) as f32);
        let x = center.x + half.x * (2.0 * column / width - 1.0);
        let y = center.y + half.y * (1.0 - 2.0 * row / rows);
        (x * right + y * up + axis).normalize()
    }

    /// The sample that a direction meets; outside the window it is [`MaskSample::Outside`].
    #[must_use]
    pub fn sample(&self, direction: Vec3) -> MaskSample {
        let UnitSquare { right, up, axis, center, half, .. } = self.square;
        let along = direction.dot(axis);
        let place = (Vec2::new(direction.dot(right), direction.dot(up)) / along - center) / half;
        let [width, rows] = self.size;
        // Comparisons of NaN fail.
        if !(along > 0.0 && place.abs().max_element() < 1.0) {
            return MaskSample::Outside;
        }
        let column = (0.5 * (1.0 + place.x) * width as f32) as usize;
        let row = (0.5 * (1.0 - place.y) * rows as f32) as usize;
        self.samples.get(row.min(rows - 1) * width + column.min(width - 1)).copied().unwrap_or(MaskSample::Outside)
    }

    /// The outline of the light above the horizon, as unit directions in a circle: the ends of its samples in each row.
    #[must_use]
    pub fn outline(&self) -> Vec<Vec3> {
        let (mut left, mut right) = (Vec::new(), Vec::new());
        for (row, samples) in self.samples.chunks_exact(self.size[0].max(1)).enumerate() {
            let is_light = |sample: &MaskSample| *sample != MaskSample::Outside;
            let ends = samples.iter().position(is_light).zip(samples.iter().rposition(is_light));
            if let Some((first, last)) = ends {
                let row = row as f32 + 0.5;
                left.push(self.direction(first as f32, row));
                right.push(self.direction(last as f32 + 1.0, row));
            }
        }
        left.extend(right.into_iter().rev());
        left
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
