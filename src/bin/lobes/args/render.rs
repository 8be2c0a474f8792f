use super::ViewArgs;
use super::values::{frames, map_resolution, threshold, tolerance, whole};
use clap::{Args, ValueEnum};
use cosine_lobes::scene::Strategy;
use std::path::PathBuf;

/// Render a picture
///
/// Writes PNG (eight-bit sRGB after exposure) or OpenEXR (linear RGB, 32-bit float), by the ending of the file's name.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  lobes render
  lobes render scene.toml -o a.png -o a.exr --tolerance 0.003
  lobes render scene.toml -o a.exr --layers --stats a.json
  lobes render scene.toml -o unshadowed.exr --visibility none
  lobes render model.glb --visibility rays              shadows of the true triangles
  lobes render walk.glb -o walk.png --frames 0..24      walk.0000.png to walk.0023.png")]
pub(crate) struct RenderArgs {
    #[command(flatten)]
    pub(crate) view: ViewArgs,

    /// File to write, .png or .exr; may be given several times
    #[arg(long, short, value_name = "FILE", default_value = "lobes.png")]
    pub(crate) output: Vec<PathBuf>,

    /// How objects block light
    #[arg(long, value_enum, default_value_t = Visibility::Scene)]
    pub(crate) visibility: Visibility,

    /// Texels a side of each light's shadow map, 16 to 8192; when left out, what the light's width takes, 256 to 2048
    #[arg(long, value_name = "N", value_parser = map_resolution)]
    pub(crate) map_resolution: Option<u32>,

    /// How lobes are fitted and integrated
    #[arg(long, value_enum, default_value_t = Method::Moments)]
    pub(crate) method: Method,

    /// What computes
    #[arg(long, value_enum, default_value_t = Device::Cpu)]
    pub(crate) device: Device,

    /// Asked mean error in penumbra, as a fraction of the unshadowed radiance: above 0, at most 0.1
    #[arg(long, value_name = "T", default_value_t = 0.005, value_parser = tolerance)]
    pub(crate) tolerance: f32,

    /// Depth of the visibility mask: 2^D cells a side, 1 to 6; when left out, what the tolerance requires
    #[arg(long, value_name = "D", value_parser = whole(1..=6))]
    pub(crate) depth: Option<u32>,

    /// Drop contributions whose radiance is below this
    #[arg(long, value_name = "R", default_value_t = 0.0, value_parser = threshold)]
    pub(crate) threshold: f32,

    /// Add to .exr files, besides beauty (channels R, G, B): unshadowed and light0, light1 … (the part of each light)
    /// as NAME.R, .G, .B; normal.X, .Y, .Z; depth.Z (distance from the plane of the eye, infinite where nothing is
    /// seen); lobes.N and products.N (visibility lobes and lobe integrals of the pixel)
    #[arg(long)]
    pub(crate) layers: bool,

    /// Render the animation's frames A to B, B not included, each to a file of its own: -o out.png gives out.0007.png.
    /// Frames that are there are kept where this very command has made them: their files carry a mark of the scene, the
    /// options and the version. So the same command goes on where it was interrupted, and makes what changed anew
    #[arg(long, value_name = "A..B", value_parser = frames, conflicts_with_all = ["frame", "time", "repeat"])]
    pub(crate) frames: Option<(u32, u32)>,

    /// Write times and counts of each stage to this file, as JSON: what --json prints
    #[arg(long, value_name = "FILE")]
    pub(crate) stats: Option<PathBuf>,

    /// Shade N times and report the median time
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole(1..=10_000))]
    pub(crate) repeat: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Visibility {
    /// Each object as the scene file says (its key `visibility`); where it says nothing by spheres, and meshes that
    /// are flat or of fewer than 300 triangles by rays
    Scene,
    /// The spheres that stand for the objects
    Spheres,
    /// Depth maps around the lights, of the true triangles: no spheres to build; balls stay exact
    ShadowMap,
    /// Shadow rays on the true triangles and balls: exact, and slower
    Rays,
    /// Nothing: no shadows
    None,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Method {
    /// Fits that conserve flux and direction, integrals in closed form
    Moments,
    /// The paper as printed: least-squares lobes, tabulated products, shadow nodes with level weights
    Paper,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Device {
    /// All cores
    Cpu,
}

impl Visibility {
    /// The strategy that all objects take; none where each has its own.
    pub(crate) fn strategy(self) -> Option<Strategy> {
        match self {
            Self::Scene => None,
            Self::Spheres => Some(Strategy::Spheres),
            Self::ShadowMap => Some(Strategy::ShadowMap),
            Self::Rays => Some(Strategy::Rays),
            Self::None => Some(Strategy::None),
        }
    }
}
