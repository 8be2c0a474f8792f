use super::clock::ClockArgs;
use super::console::ConsoleArgs;
use super::model::ModelArgs;
use super::values::{exposure, size, whole};
use clap::Args;
use cosine_lobes::render_cpu::PixelSamples;
use std::path::PathBuf;

/// Camera rays of a pixel that an outline crosses, unless all have as many.
const EDGE_SAMPLES: u32 = 8;

/// Options of all commands that take a picture of a scene.
#[derive(Args, Clone, Debug)]
pub(crate) struct ViewArgs {
    /// Scene (.toml), model (.gltf, .glb, .obj, .ply); the built-in scene when left out
    pub(crate) file: Option<PathBuf>,

    /// Image size in pixels, instead of the scene's
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(crate) size: Option<(u32, u32)>,

    /// Camera rays a pixel: 1 through its centre, more through a fixed set of points, box-filtered. When left out, `render` and
    /// `reference` take 8 where an outline crosses the pixel and 1 elsewhere, `trade` 1
    #[arg(long, value_name = "N", value_parser = whole(1..=1024))]
    pub(crate) samples: Option<u32>,

    /// Brightness of PNG files in stops: radiance times 2^E. When left out it is metered, so that nine tenths of the lit pixels at the
    /// scene's first moment are darker than half of white
    #[arg(long, value_name = "E", value_parser = exposure, allow_negative_numbers = true)]
    pub(crate) exposure: Option<f32>,

    #[command(flatten)]
    pub(crate) clock: ClockArgs,

    /// The glTF file's clip of that name or number (from 0) instead of its first; a scene file names its own
    #[arg(long, value_name = "CLIP", requires = "file")]
    pub(crate) clip: Option<String>,

    #[command(flatten)]
    pub(crate) model: ModelArgs,

    #[command(flatten)]
    pub(crate) console: ConsoleArgs,
}

impl ViewArgs {
    /// The camera rays of a picture's pixels.
    pub(crate) fn samples(&self) -> PixelSamples {
        self.samples.map_or(PixelSamples::Edges(EDGE_SAMPLES), PixelSamples::Uniform)
    }
}
