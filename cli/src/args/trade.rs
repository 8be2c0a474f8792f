use super::values::{map_resolution, tolerance, whole};
use super::{Method, ViewArgs, Visibility};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Measure the cost of accuracy: error against time of all settings on one scene
///
/// Shades the same visible points with every method, strategy, tolerance and depth, and by shadow rays with several numbers of
/// samples a light; compares each with one converged reference. Writes trade.csv, trade.json, trade.md, a plot with the Pareto front
/// marked (trade.svg, trade.png), pictures at equal time (sheet.png), and the reference with its checkpoint. Ctrl-C keeps the
/// finished rows; the same command resumes.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  lobes trade scene.toml -o trade
  lobes trade scene.toml -o trade --tolerance 0.01,0.001 --depth 4,6 --spp 16,256
  lobes trade model.glb -o trade --geometry mesh        all strategies against the true triangles
  lobes trade scene.toml -o trade --device cpu,gpu      both in one table")]
pub(crate) struct TradeArgs {
    #[command(flatten)]
    pub(crate) view: ViewArgs,

    /// Folder to write to; made where there is none
    #[arg(long, short, value_name = "DIR")]
    pub(crate) output: PathBuf,

    /// Geometry that casts shadows in the reference and for the sampler
    #[arg(long, value_enum, default_value_t = TradeGeometry::Spheres)]
    pub(crate) geometry: TradeGeometry,

    /// Methods, separated by commas
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = [Method::Moments, Method::Lobes, Method::Paper])]
    pub(crate) method: Vec<Method>,

    /// Strategies, separated by commas; when left out, all that see the geometry
    #[arg(long, value_enum, value_delimiter = ',')]
    pub(crate) visibility: Vec<Visibility>,

    /// Devices that shade lobes, separated by commas; the sampler runs on the CPU
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = [TradeDevice::Cpu])]
    pub(crate) device: Vec<TradeDevice>,

    /// Tolerances, separated by commas
    #[arg(long, value_name = "T,…", value_delimiter = ',', value_parser = tolerance,
          default_values_t = [0.03, 0.01, 0.005, 0.003, 0.001])]
    pub(crate) tolerance: Vec<f32>,

    /// Depths of the visibility mask, separated by commas
    #[arg(long, value_name = "D,…", value_delimiter = ',', value_parser = whole(1..=6), default_values_t = [3, 4, 5, 6])]
    pub(crate) depth: Vec<u32>,

    /// Samples a light and point of the sampler, separated by commas
    #[arg(long, value_name = "N,…", value_delimiter = ',', value_parser = whole(1..=65536),
          default_values_t = [1, 4, 16, 64, 256])]
    pub(crate) spp: Vec<u32>,

    /// Samples a light and point of the reference
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = whole(1..=1 << 20))]
    pub(crate) reference_spp: u32,

    /// Times that each setting is shaded; fewer, at least three, where that takes long
    #[arg(long, value_name = "N", default_value_t = 9, value_parser = whole(3..=1000))]
    pub(crate) repeat: u32,

    /// Texels a side of each light's shadow map
    #[arg(long, value_name = "N", value_parser = map_resolution)]
    pub(crate) map_resolution: Option<u32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum TradeDevice {
    /// All cores
    Cpu,
    /// The strongest graphics adapter, points sent to it and radiance read back in its time
    Gpu,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum TradeGeometry {
    /// The spheres that stand for the objects: measures the error of the lobes alone
    Spheres,
    /// The true triangles and spheres: the error of `spheres` includes that of the sphere sets
    Mesh,
}
