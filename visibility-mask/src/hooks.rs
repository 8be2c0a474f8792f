//! Access to the parts of a mask, only for tests of the WGSL.

use crate::counts::Counts;
use crate::visible_fraction::{narrowest, sums};
use crate::{LitArea, Mask, UnitSquare};
use glam::Vec3;
use lobe_core::{Lobe, Outline, Receiver};

/// The sum of the areas of what is lit.
#[must_use]
pub fn area(lit: &LitArea) -> f32 {
    lit.area()
}

/// A mask without blockers, with coarse rows or fine ones as [`MaskVisibility`](crate::MaskVisibility) chooses them.
#[must_use]
pub fn mask(square: &UnitSquare, depth: u32, coarse: bool, normal: Vec3) -> Mask {
    let mut mask = Mask::default();
    mask.set_coarse(coarse);
    mask.reset(square, depth, normal);
    mask
}

/// The same for a window on an outline.
#[must_use]
pub fn mask_of(square: &UnitSquare, depth: u32, coarse: bool, normal: Vec3, outline: &Outline) -> Mask {
    let mut mask = Mask::default();
    mask.set_coarse(coarse);
    mask.reset_to(square, depth, normal, Some(outline));
    mask
}

/// The lit samples of a row.
#[must_use]
pub fn row(mask: &Mask, j: usize) -> [u64; 4] {
    mask.lit(j).0
}

/// The visible fraction of a lobe through the mask.
#[must_use]
pub fn fraction_of(mask: &Mask, at: &Receiver, lobe: &Lobe) -> f32 {
    let lobe = Lobe { exponent: lobe.exponent.min(narrowest(mask)), ..*lobe };
    sums(mask, mask.square(), at, &lobe, &mut Counts::default())
        .ratio(|| mask.lit_count() as f32 / mask.emitting_count().max(1) as f32)
}
