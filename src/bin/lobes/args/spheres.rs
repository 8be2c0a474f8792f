use super::values::share;
use clap::Args;
use std::path::PathBuf;

/// Build a set of spheres that casts the shadow of a mesh
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  lobes spheres bunny.obj --count 64 -o bunny.json
  lobes spheres bunny.obj --count 256 -o bunny.json --preview bunny.png --json
  lobes spheres bunny.obj --tolerance 0.02 -o bunny.json     as many as a 2 % error takes")]
pub(crate) struct SpheresArgs {
    /// Mesh (.obj, .ply, .gltf, .glb); several parts are taken together
    pub(crate) mesh: PathBuf,

    /// Spheres at most: 64 when left out, with --tolerance 1024
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) count: Option<u32>,

    /// As few spheres as have this silhouette error, a fraction of the silhouette's area, above 0, at most 1
    #[arg(long, value_name = "T", value_parser = share, conflicts_with = "draft")]
    pub(crate) tolerance: Option<f32>,

    /// File to write, JSON; of a glTF file that moves also the bones of each sphere
    #[arg(long, short, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,

    /// Draw mesh and spheres over each other
    #[arg(long, value_name = "PNG")]
    pub(crate) preview: Option<PathBuf>,

    /// Let every point of the surface be in a sphere: a bound, whose shadow is a little too large
    #[arg(long, conflicts_with = "tolerance")]
    pub(crate) bounding: bool,

    /// Several times faster, with about three times the silhouette error
    #[arg(long)]
    pub(crate) draft: bool,

    /// Chooses the random steps of the search
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub(crate) seed: u64,

    /// No progress, no summary
    #[arg(long, short)]
    pub(crate) quiet: bool,

    /// Print the figures as JSON
    #[arg(long)]
    pub(crate) json: bool,
}
