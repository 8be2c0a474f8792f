//! The structs that the kernels read, as Rust writes them: byte for byte the same as in WGSL.

use bytemuck::{Pod, Zeroable};
use lobe_core::Receiver;
use shading::gpu::GPU_SHAPE;

pub use lobe_core::wgsl::NO_MATERIAL;

/// A [`Receiver`] and the number of its material: `Receiver` of WGSL, 64 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct GpuReceiver {
    /// World position.
    pub position: [f32; 3],
    /// Number of the object.
    pub object: u32,
    /// Shading normal.
    pub normal: [f32; 3],
    /// Number of the material, or [`NO_MATERIAL`].
    pub material: u32,
    /// Geometric normal.
    pub face: [f32; 3],
    /// Unused.
    pub pad0: u32,
    /// Direction toward the eye.
    pub view: [f32; 3],
    /// Unused.
    pub pad1: u32,
}

impl GpuReceiver {
    /// A receiver with its material's number.
    #[must_use]
    pub fn new(at: &Receiver, material: u32) -> Self {
        Self {
            position: at.position.to_array(),
            object: at.object,
            normal: at.normal.to_array(),
            material,
            face: at.face.to_array(),
            view: at.view.to_array(),
            ..Self::default()
        }
    }
}

/// One light of one frame: `Frame` of WGSL, the uniform of binding 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GpuFrame {
    /// The sphere around the light: centre and radius.
    pub(crate) light: [f32; 4],
    pub(crate) radiance: [f32; 3],
    pub(crate) tolerance: f32,
    pub(crate) threshold: f32,
    pub(crate) point_count: u32,
    pub(crate) queue_stride: u32,
    /// Always 2. `note_cut_loops` of queue.wgsl counts to it, to find loops that the driver ended early.
    pub(crate) rounds: u32,
    pub(crate) image: u32,
    pub(crate) number: u32,
    /// Cells a side of a mask.
    pub(crate) cells: f32,
    /// `LookAgain`, as a number.
    pub(crate) look_again: u32,
    /// Parameters of the kind of light.
    pub(crate) shape: [[f32; 4]; GPU_SHAPE],
}
