use super::values::{seed, whole};
use super::{PngArgs, ViewArgs};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Compute the same picture by Monte Carlo, as a reference
///
/// Writes OpenEXR files with the layers beauty (channels R, G, B), unshadowed and stderr (the standard error of each pixel,
/// from eight independent randomisations). Ctrl-C keeps the finished work beside the output; the same command resumes
/// it.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  lobes reference scene.toml -o ref.exr --spp 4096
  lobes reference scene.toml -o ref.exr --spp 1024 --keep     then, to refine it:
  lobes reference scene.toml -o ref.exr --spp 16384
  lobes reference scene.toml -o true.exr --geometry mesh      shadows of the real triangles")]
pub(crate) struct ReferenceArgs {
    #[command(flatten)]
    pub(crate) view: ViewArgs,

    /// File to write, .exr or .png; may be given several times
    #[arg(long, short, value_name = "FILE", default_value = "reference.exr")]
    pub(crate) output: Vec<PathBuf>,

    #[command(flatten)]
    pub(crate) png: PngArgs,

    /// Samples a light and point, rounded up to a multiple of 8; powers of two converge best
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = whole(1..=1 << 24))]
    pub(crate) spp: u32,

    /// Geometry that casts shadows
    #[arg(long, value_enum, default_value_t = Geometry::Scene)]
    pub(crate) geometry: Geometry,

    /// Without shadows
    #[arg(long, conflicts_with = "geometry")]
    pub(crate) unshadowed: bool,

    /// Chooses the randomisations
    #[arg(long, value_name = "S", default_value_t = 0, value_parser = seed)]
    pub(crate) seed: u64,

    /// Keep the checkpoint (OUTPUT.checkpoint, 192 bytes a point), to refine the result later
    #[arg(long)]
    pub(crate) keep: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Geometry {
    /// The geometry of `render`: spheres for objects that block by spheres, the true geometry of the others
    Scene,
    /// The spheres that stand for the objects
    Spheres,
    /// The true geometry of all objects: triangles and spheres
    Mesh,
}
