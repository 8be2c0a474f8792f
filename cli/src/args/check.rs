use super::model::ModelArgs;
use clap::Args;
use std::path::PathBuf;

/// Validate a scene and say what it requires
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  lobes check scene.toml
  lobes check scene.toml --prices     milliseconds and error of each strategy
  lobes check --schema > scene.toml")]
pub(crate) struct CheckArgs {
    /// Scene (.toml), model (.gltf, .glb, .obj, .ply); the built-in scene when left out
    pub(crate) file: Option<PathBuf>,

    /// The glTF file's clip of that name or number (from 0) instead of its first; a scene file names its own
    #[arg(long, value_name = "CLIP", requires = "file")]
    pub(crate) clip: Option<String>,

    #[command(flatten)]
    pub(crate) model: ModelArgs,

    /// Measure the cost of each strategy on this scene, and the difference of its picture from the exact one. Fits spheres that
    /// do not exist yet, and keeps them
    #[arg(long)]
    pub(crate) prices: bool,

    /// Print a scene file that has every key, with its meaning
    #[arg(long, conflicts_with = "file")]
    pub(crate) schema: bool,

    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}
