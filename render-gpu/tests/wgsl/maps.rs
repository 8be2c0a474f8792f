//! The WGSL of shadow maps without a GPU: every variant validates.

use crate::validated::module;
use lobe_core::wgsl::{Piece, join};
use shading::gpu::GpuPages;
use visibility_shadowmap::wgsl;

/// The declarations of kernels.
const FRAME: &str = "struct Frame { light: vec4f, cells: f32, number: u32 }
    @group(0) @binding(0) var<uniform> frame: Frame;";

fn validate(piece: &'static Piece, header: &str) -> naga::Module {
    let words = GpuPages::of(3 << 27, 1 << 27).wgsl("maps", 8);
    module(&(join(&[piece, &visibility_mask::wgsl::ROUND]) + FRAME + &words + header))
}

#[test]
fn coverage_validates() {
    validate(&wgsl::COVERAGE, "");
}

#[test]
fn splat_validates_for_every_mask_and_keeps_two_words_a_row_and_line() {
    for depth in 1..=visibility_mask::MAX_DEPTH {
        for coarse in [false, true] {
            let header = visibility_mask::wgsl::header(
                depth,
                visibility_mask::Fineness { coarse, ..visibility_mask::Fineness::FINE },
            );
            let module = validate(&wgsl::SPLAT, &header);
            let (_, bits) =
                module.global_variables.iter().find(|(_, v)| v.name.as_deref() == Some("union_bits")).expect("a union");
            // Four lines of 16 samples a cell.
            assert_eq!(module.types[bits.ty].inner.size(module.to_ctx()), (4 * 16 / 8) << depth);
        }
    }
}
