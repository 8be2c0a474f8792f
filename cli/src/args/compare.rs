use super::values::{exposure, positive};
use clap::Args;
use std::path::PathBuf;

/// Compare a picture with a reference
///
/// Errors are differences of linear radiance, test minus reference.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  lobes compare a.exr ref.exr
  lobes compare a.exr ref.exr --unshadowed unshadowed.exr --json
  lobes compare a.exr ref.exr --diff difference.png --heatmap flip.png")]
pub(crate) struct CompareArgs {
    /// Test: an OpenEXR file with channels R, G, B, bare or in a layer named beauty
    #[arg(value_name = "A")]
    pub(crate) test: PathBuf,

    /// Reference: another one of the same size
    #[arg(value_name = "B")]
    pub(crate) reference: PathBuf,

    /// The same view without shadows (its layer unshadowed, if it has one): adds the errors in penumbra, light and shadow,
    /// as fractions of its luminance (Rec. 709)
    #[arg(long, value_name = "U")]
    pub(crate) unshadowed: Option<PathBuf>,

    /// Brightness in stops at which FLIP looks at both pictures
    #[arg(long, value_name = "E", default_value_t = 0.0, value_parser = exposure, allow_negative_numbers = true)]
    pub(crate) exposure: f32,

    /// Write the signed difference of luminance: red where the test is brighter, blue where it is darker
    #[arg(long, value_name = "PNG")]
    pub(crate) diff: Option<PathBuf>,

    /// The difference that has full colour in --diff; when left out, the 99th percentile of the pixels that differ
    #[arg(long, value_name = "D", value_parser = positive)]
    pub(crate) diff_scale: Option<f32>,

    /// Write the FLIP map of visible differences
    #[arg(long, value_name = "PNG")]
    pub(crate) heatmap: Option<PathBuf>,

    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}
