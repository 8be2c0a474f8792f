use super::values::{crop, frames, map_resolution, positive, threshold, tiles, tolerance, whole};
use super::{PngArgs, ViewArgs};
use crate::failure::Failure;
use crate::input;
use crate::quality::Quality;
use clap::{Args, ValueEnum};
use cosine_lobes::Window;
use cosine_lobes::render_cpu::TILE;
use cosine_lobes::renderer::{self, LayerSet, Settings};
use cosine_lobes::scene::Strategy;
use cosine_lobes::shading::Accuracy;
use std::path::PathBuf;

/// The layers of `--layers`.
const LAYERS: LayerSet = LayerSet { objects: false, ..LayerSet::ALL };

/// Render a picture
///
/// Writes PNG (sRGB after exposure and tone map) or OpenEXR (linear RGB, 32-bit float), by the ending of the file's name.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  lobes render
  lobes render scene.toml -o a.png -o a.exr --tolerance 0.003
  lobes render scene.toml -o a.exr --layers --stats a.json
  lobes render scene.toml -o unshadowed.exr --visibility none
  lobes render model.glb --visibility spheres           faster shadows, of spheres fitted to it
  lobes render walk.glb -o walk.png --frames 0..24      walk.0000.png to walk.0023.png
  lobes render scene.toml --quality draft               fast; interactive and high cost more
  lobes render scene.toml --tiles 2/8 -o part2.exr      the second of eight parts")]
pub(crate) struct RenderArgs {
    #[command(flatten)]
    pub(crate) view: ViewArgs,

    /// File to write, .png or .exr; may be given several times
    #[arg(long, short, value_name = "FILE", default_value = "lobes.png")]
    pub(crate) output: Vec<PathBuf>,

    #[command(flatten)]
    pub(crate) png: PngArgs,

    /// How objects block light
    #[arg(long, value_enum, default_value_t = Visibility::Scene)]
    pub(crate) visibility: Visibility,

    /// Texels a side of each light's shadow map, 16 to 8192; when left out, 256 to 2048 by the light's width
    #[arg(long, value_name = "N", value_parser = map_resolution)]
    pub(crate) map_resolution: Option<u32>,

    /// How lobes are fitted and integrated
    #[arg(long, value_enum, default_value_t = Method::Moments)]
    pub(crate) method: Method,

    /// Device that computes
    #[arg(long, value_enum, default_value_t = Device::Cpu)]
    pub(crate) device: Device,

    /// Requested mean error in penumbra, as a fraction of the unshadowed radiance: above 0, at most 0.1
    #[arg(long, value_name = "T", default_value_t = 0.005, value_parser = tolerance)]
    pub(crate) tolerance: f32,

    /// Depth of the visibility mask: 2^D cells a side, 1 to 6; when left out, what the tolerance requires
    #[arg(long, value_name = "D", value_parser = whole(1..=6))]
    pub(crate) depth: Option<u32>,

    /// Tolerance and depth from the measured front of error against time, instead of --tolerance and --depth
    #[arg(long, value_enum, conflicts_with_all = ["tolerance", "depth", "time_budget"])]
    pub(crate) quality: Option<Quality>,

    /// The best tolerance and depth whose frame takes at most MS milliseconds, measured on this scene before its first frame
    #[arg(long, value_name = "MS", value_parser = positive, conflicts_with_all = ["tolerance", "depth", "crop", "tiles"])]
    pub(crate) time_budget: Option<f32>,

    /// Let the tolerance be a part of each pixel's own radiance in the dark ends of penumbrae as well, not in rooms lit through
    /// a window alone
    #[arg(long)]
    pub(crate) own_radiance: bool,

    /// Under eight lights and more: interpolate shadows between pixels where no penumbra is narrower than their distance, within the
    /// tolerance of all lights together (CPU)
    #[arg(long, conflicts_with = "crop")]
    pub(crate) interpolate: bool,

    /// Drop contributions whose radiance is below this
    #[arg(long, value_name = "R", default_value_t = 0.0, value_parser = threshold)]
    pub(crate) threshold: f32,

    /// Add to .exr files, besides beauty (channels R, G, B): unshadowed and light0, light1 … (the part of each light)
    /// as NAME.R, .G, .B; normal.X, .Y, .Z; depth.Z (distance from the plane of the eye, infinite where nothing is
    /// seen); lobes.N and products.N (visibility lobes and lobe integrals of the pixel)
    #[arg(long)]
    pub(crate) layers: bool,

    /// Render the animation's frames A to B, B not included, each to a file of its own: -o out.png gives out.0007.png.
    /// Existing frames are kept if the same command made them: their files carry a mark of the scene, the
    /// options and the version. So the same command resumes an interrupted run, and renders changed frames again
    #[arg(long, value_name = "A..B", value_parser = frames, conflicts_with_all = ["frame", "time", "repeat"])]
    pub(crate) frames: Option<(u32, u32)>,

    /// Only the pixels from column X0 and row Y0 to before X1 and Y1, to the bit as in the whole picture. An .exr file says where
    /// they belong (lobes merge puts such parts together)
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = crop, conflicts_with = "tiles")]
    pub(crate) crop: Option<[u32; 4]>,

    /// Only the I-th of N bands of rows, from 1: work for N processes or machines. Bands are whole tiles of 8 rows, so that N is at
    /// most an eighth of the rows
    #[arg(long, value_name = "I/N", value_parser = tiles)]
    pub(crate) tiles: Option<(u32, u32)>,

    /// Write times and counts of each stage to this file, as JSON (the output of --json)
    #[arg(long, value_name = "FILE")]
    pub(crate) stats: Option<PathBuf>,

    /// Shade N times and report the median time
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole(1..=10_000))]
    pub(crate) repeat: u32,
}

impl RenderArgs {
    /// Tolerance and depth, where no time budget decides.
    pub(crate) fn accuracy(&self) -> Accuracy {
        let requested = Accuracy::new(self.tolerance);
        match self.quality {
            Some(quality) => quality.accuracy(),
            None => self.depth.map_or(requested, |depth| requested.with_depth(depth)),
        }
    }

    /// The settings of the renderer, without the device.
    pub(crate) fn settings(&self) -> Settings {
        Settings {
            strategy: self.visibility.strategy(),
            method: self.method.into(),
            accuracy: self.accuracy(),
            time_budget: self.time_budget,
            own_radiance: self.own_radiance,
            interpolate: self.interpolate,
            threshold: self.threshold,
            samples: self.view.samples(),
            map_resolution: self.map_resolution,
            layers: if self.layers { LAYERS } else { LayerSet::NONE },
            repeat: self.repeat,
            cache: input::cache_folder(),
            ..Settings::default()
        }
    }

    /// The requested part of a picture of that size.
    pub(crate) fn window(&self, width: u32, height: u32) -> Result<Window, Failure> {
        let mut window = Window::whole(width as usize, height as usize);
        if let Some([left, top, right, bottom]) = self.crop {
            if right > width || bottom > height {
                return Err(Failure::new(format_args!("--crop: the picture has only {width} x {height} pixels")));
            }
            (window.columns, window.rows) = (left as usize..right as usize, top as usize..bottom as usize);
        }
        if let Some((number, count)) = self.tiles {
            // Whole tiles of 8 rows: their points are culled together.
            let tiles = height.div_ceil(TILE);
            if count > tiles {
                return Err(Failure::new(format_args!(
                    "--tiles: {height} rows are {tiles} tiles of 8, which are not divided"
                )));
            }
            let border = |k: u32| (u64::from(tiles) * u64::from(k) / u64::from(count)) as u32 * TILE;
            window.rows = border(number - 1) as usize..border(number).min(height) as usize;
        }
        Ok(window)
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Visibility {
    /// Each object as the scene file says (its key `visibility`); where it says nothing meshes by their silhouettes, spheres
    /// and sets of spheres as they are
    Scene,
    /// The spheres that stand for the objects
    Spheres,
    /// Depth maps around the lights, of the true triangles: no spheres to build; spheres stay exact
    ShadowMap,
    /// The silhouettes of the true triangles: exact, nothing to build; spheres stay exact
    Silhouettes,
    /// Shadow rays on the true triangles and spheres: exact, and slower
    Rays,
    /// Nothing: no shadows
    None,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Method {
    /// Fits that conserve flux and direction, integrals in closed form; of each reflectance lobe the fraction that the mask leaves
    Moments,
    /// The same with visibility as a sum of lobes, cut from the mask's quad-tree, and products with them
    Lobes,
    /// The paper as printed: least-squares lobes, tabulated products, shadow nodes with level weights
    Paper,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Device {
    /// All cores
    Cpu,
    /// The strongest graphics adapter, by Vulkan, Metal or Direct3D 12; a software one where there is no other. The same picture
    /// to a thousandth of its maximum, but for single points under lights wider than 65°. Without --layers
    Gpu,
    /// The graphics adapter if it is hardware and supports the picture, else all cores; reports which
    Auto,
}

impl From<Method> for renderer::Method {
    fn from(method: Method) -> Self {
        match method {
            Method::Moments => Self::Moments,
            Method::Lobes => Self::Lobes,
            Method::Paper => Self::Paper,
        }
    }
}

impl Visibility {
    /// The common strategy of all objects; `None` where each has its own.
    pub(crate) fn strategy(self) -> Option<Strategy> {
        match self {
            Self::Scene => None,
            Self::Spheres => Some(Strategy::Spheres),
            Self::ShadowMap => Some(Strategy::ShadowMap),
            Self::Silhouettes => Some(Strategy::Silhouettes),
            Self::Rays => Some(Strategy::Rays),
            Self::None => Some(Strategy::None),
        }
    }
}
