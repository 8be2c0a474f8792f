use crate::Snapshot;
use glam::Vec3;
use renderer::{Image, ImageStats, Layers, RenderError, Upkeep};
use std::sync::Arc;

/// A picture of a session.
#[derive(Clone, Debug, Default)]
pub struct Picture {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Linear radiance toward the eye, W·m⁻²·sr⁻¹ per channel, row by row; empty where the picture is [on a GPU](Self::pixels).
    pub radiance: Vec<Vec3>,
    /// The same on the GPU that made it, if it [stays](crate::Session::set_on_gpu) there.
    #[cfg(feature = "gpu")]
    pub on_gpu: Option<Arc<renderer::GpuPicture>>,
    /// The layers that were [requested](crate::Session::set_layers).
    pub layers: Layers,
    /// By how much its sides are shorter than those of the whole picture, rounded up: 1 is the whole one; 0 where none was made.
    pub divisor: u32,
    /// Whether it is the sum of a light that moves and of an earlier picture without it, but for rounding or, where its sides are shorter, for the
    /// grain of pixels; a picture with the bits of the renderer follows.
    pub is_sum: bool,
    /// The number of changes that it shows: edits, refused ones included, and steps back and forth.
    pub edits: u64,
    /// The latest of these changes that a [reference](crate::Session::reference) shows: one with as many or more is of this picture.
    pub seen: u64,
    /// Seconds from the first edit that no earlier picture shows until this picture was there; 0 where there is no new one.
    pub latency: f64,
    /// Seconds that it took.
    pub seconds: f64,
    /// How it was made.
    pub stats: ImageStats,
    /// How often what is kept between pictures was made or followed so far.
    pub upkeep: Upkeep,
    /// The scene that it shows.
    pub scene: Arc<Snapshot>,
}

impl Picture {
    /// Whether it has no pixels: before the first picture, and where none is made.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.radiance.is_empty() && !self.is_on_gpu()
    }

    /// Whether it is the renderer's whole picture, of all that it shows.
    #[must_use]
    pub const fn is_whole(&self) -> bool {
        self.divisor == 1 && !self.is_sum
    }

    /// Whether its pixels are on a GPU alone.
    #[must_use]
    pub const fn is_on_gpu(&self) -> bool {
        #[cfg(feature = "gpu")]
        return self.on_gpu.is_some();
        #[cfg(not(feature = "gpu"))]
        false
    }

    /// Its radiance, row by row. Of a picture on a GPU the first call waits for it and reads it back: 16 bytes a pixel.
    ///
    /// # Errors
    /// [`RenderError`] if the GPU is lost.
    pub fn pixels(&self) -> Result<&[Vec3], RenderError> {
        #[cfg(feature = "gpu")]
        if let Some(picture) = &self.on_gpu {
            return Ok(picture.radiance()?);
        }
        Ok(&self.radiance)
    }
}

/// Pixels of a picture, where they were made.
#[derive(Debug, Default)]
pub(crate) struct Made {
    pub(crate) image: Image,
    #[cfg(feature = "gpu")]
    pub(crate) on_gpu: Option<Arc<renderer::GpuPicture>>,
}

impl From<Image> for Made {
    fn from(image: Image) -> Self {
        Self {
            image,
            #[cfg(feature = "gpu")]
            on_gpu: None,
        }
    }
}
