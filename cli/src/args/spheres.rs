use super::values::{fraction, seed, whole};
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
    #[arg(long, value_name = "N", value_parser = whole(1..=100_000))]
    pub(crate) count: Option<u32>,

    /// As few spheres as have this silhouette error, a fraction of the silhouette's area, above 0, at most 1. Neither with
    /// --draft nor with --bounding, which do not follow the silhouette
    #[arg(long, value_name = "T", value_parser = fraction, conflicts_with = "draft")]
    pub(crate) tolerance: Option<f32>,

    /// The glTF file's clip of that name or number (from 0) at whose first moment the set is fitted, instead of its first
    #[arg(long, value_name = "CLIP")]
    pub(crate) clip: Option<String>,

    /// File to write, .json; without it only figures are printed
    #[arg(long, short, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,

    /// Write the bones that carry each sphere as well, for other programs: `render` binds sets itself
    #[arg(long, requires = "output")]
    pub(crate) bones: bool,

    /// Draw mesh and spheres over each other
    #[arg(long, value_name = "PNG")]
    pub(crate) preview: Option<PathBuf>,

    /// Let every point of the surface be in a sphere: a bound, whose shadow is a little too large; for closed meshes, and
    /// not with --tolerance
    #[arg(long, conflicts_with = "tolerance")]
    pub(crate) bounding: bool,

    /// Several times faster, with about three times the silhouette error; not with --tolerance
    #[arg(long)]
    pub(crate) draft: bool,

    /// Chooses the random steps of the search
    #[arg(long, value_name = "S", default_value_t = 0, value_parser = seed)]
    pub(crate) seed: u64,

    /// No progress, no summary
    #[arg(long, short)]
    pub(crate) quiet: bool,

    /// Print the figures as JSON
    #[arg(long)]
    pub(crate) json: bool,
}
