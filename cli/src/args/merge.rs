use super::PngArgs;
use super::values::exposure;
use clap::Args;
use std::path::PathBuf;

/// Put the parts of a picture together
///
/// Parts are OpenEXR files of `lobes render --tiles I/N` or `--crop`: their data windows give their places. They must cover
/// the picture, each pixel once. The result has the bytes of a single run.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  lobes render scene.toml --tiles 1/2 -o a.exr
  lobes render scene.toml --tiles 2/2 -o b.exr          on another machine
  lobes merge a.exr b.exr -o picture.exr -o picture.png")]
pub(crate) struct MergeArgs {
    /// Parts (.exr), in any order
    #[arg(value_name = "PART", required = true)]
    pub(crate) parts: Vec<PathBuf>,

    /// File to write, .exr (with all layers) or .png; may be given several times
    #[arg(long, short, value_name = "FILE", default_value = "merged.exr")]
    pub(crate) output: Vec<PathBuf>,

    /// Brightness of PNG files in stops: radiance times 2^E. When left out, the value in the first part, else 0
    #[arg(long, value_name = "E", value_parser = exposure, allow_negative_numbers = true)]
    pub(crate) exposure: Option<f32>,

    #[command(flatten)]
    pub(crate) png: PngArgs,

    /// No summary
    #[arg(long, short)]
    pub(crate) quiet: bool,
}
