use core::convert::Infallible;
use render_cpu::BlockersError;
use sphere_sets::BuildError;
use std::collections::TryReserveError;
use visibility_shadowmap::MapError;

/// The message of [`RenderError::NotOnGpu`] for layers.
pub(crate) const LAYERS: &str = "layers are made by the CPU only";
#[cfg(feature = "gpu")]
pub(crate) const NO_WGSL: &str = "it has no blockers for a GPU";
#[cfg(feature = "gpu")]
pub(crate) const NO_GPU: &str = "the renderer has no GPU on which a picture could stay: its device is the CPU";
pub(crate) const BETWEEN: &str = "visible fractions are interpolated by the CPU only";
pub(crate) const LOBES: &str = "visibility as lobes is summed by the CPU only";

/// Why a picture could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The spheres of an object could not be fitted, read or moved with it.
    #[error(transparent)]
    Blockers(BlockersError),
    /// A shadow map could not be drawn.
    #[error(transparent)]
    Map(#[from] MapError),
    /// The shadow maps of all lights do not fit.
    #[error(
        "shadow maps of {resolution}² texels for {lights} lights take more than the {} MB that there is room for: silhouettes need none",
        .room / 1_000_000
    )]
    MapRoom {
        /// Texels a side of the finest map.
        resolution: u32,
        /// Number of lights.
        lights: usize,
        /// Bytes that there is room for.
        room: u64,
    },
    /// The picture does not fit into memory.
    #[error(transparent)]
    Memory(#[from] TryReserveError),
    /// The GPU failed.
    #[cfg(feature = "gpu")]
    #[error(transparent)]
    Gpu(#[from] render_gpu::GpuError),
    /// The GPU does not support this.
    #[error("{0}")]
    NotOnGpu(&'static str),
    /// The paper's light lobes exist only for sphere lights.
    #[error("method \"paper\" is for sphere lights: light {0} is {1}; use \"moments\"")]
    PaperLight(usize, &'static str),
    /// The scene is not valid.
    #[error(transparent)]
    Scene(#[from] scene::SceneError),
    /// An edit is refused.
    #[error(transparent)]
    Edit(#[from] crate::EditError),
    /// An object blocks by a strategy that the renderer was not given.
    #[error("object \"{object}\" blocks by `{name}`: the renderer has no such strategy")]
    NoStrategy {
        /// The object's name.
        object: String,
        /// The strategy.
        name: &'static str,
    },
    /// A custom strategy cannot follow the scene, or cannot block on a device.
    #[error("strategy `{name}`: {fault}")]
    Strategy {
        /// The strategy.
        name: &'static str,
        /// The strategy's own message.
        fault: String,
    },
    /// A setting is out of its range.
    #[error("{name} is {value}: expected {expected}")]
    Setting {
        /// The setting.
        name: &'static str,
        /// Its value.
        value: String,
        /// Its range.
        expected: &'static str,
    },
    /// The listener, or the request of [`set_cancel`](crate::Renderer::set_cancel), has stopped the work.
    #[error("cancelled")]
    Cancelled,
}

impl From<Infallible> for RenderError {
    fn from(never: Infallible) -> Self {
        match never {}
    }
}

impl From<BlockersError> for RenderError {
    fn from(error: BlockersError) -> Self {
        match error {
            BlockersError::Build { source: BuildError::Cancelled, .. } => Self::Cancelled,
            error => Self::Blockers(error),
        }
    }
}
