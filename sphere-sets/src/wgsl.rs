//! The same in WGSL: a piece that a shader's module is [joined](lobe_core::wgsl::join) of.

use crate::bound_set::CARRIERS;
use crate::rig::{MORPH_WORDS, RIG_WORDS};
use lobe_core::wgsl::{Piece, SPECIAL};
use lobe_core::wgsl_numbers;
use visibility_spheres::wgsl::PACKED;

/// The entry point `pose_spheres`, one sphere a thread, 64 a workgroup: a kernel of its own. Needs the buffers `spheres` (of `BlockerSphere`),
/// `rig` (`u32`) and `bones` (`f32`), and no `frame`.
pub static POSE: Piece = Piece::new(include_str!("pose.wgsl"))
    .numbers(wgsl_numbers![RIG_WORDS = RIG_WORDS, MORPH_WORDS = MORPH_WORDS, CARRIERS = CARRIERS])
    .needs(&[&SPECIAL, &PACKED]);
