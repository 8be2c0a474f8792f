//! The command line.

use crate::console;
use crate::failure::Failure;
use clap::{Args, CommandFactory, Parser, Subcommand, ValueEnum};
use cosine_lobes::scene::Strategy;
use cosine_lobes::visibility_shadowmap::MapOptions;
use std::path::PathBuf;

/// Soft shadows and glossy light from area lights, without noise.
///
/// Reflectance, light and visibility are sums of cosine lobes, integrated in closed form. Without a FILE commands use a
/// built-in scene.
#[derive(Debug, Parser)]
#[command(name = "lobes", version, disable_help_subcommand = true, after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

const EXAMPLES: &str = "Examples:
  lobes render                                         the built-in scene, to lobes.png
  lobes render scene.toml -o picture.png -o linear.exr
  lobes reference scene.toml -o ref.exr --spp 4096     the same by Monte Carlo
  lobes compare linear.exr ref.exr                     how far the one is from the other";

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Render(RenderArgs),
    Reference(ReferenceArgs),
    Compare(CompareArgs),
    Check(CheckArgs),
    Spheres(SpheresArgs),
}

/// What all commands that take a picture of a scene share.
#[derive(Args, Debug)]
pub(crate) struct ViewArgs {
    /// Scene (.toml), model (.gltf, .glb, .obj, .ply); the built-in scene when left out
    pub(crate) file: Option<PathBuf>,

    /// Image size in pixels, instead of the scene's
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(crate) size: Option<(u32, u32)>,

    /// Camera rays a pixel: 1 through its centre, more through a fixed set of points, box-filtered
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub(crate) samples: u32,

    /// Brightness of PNG files in stops: radiance times 2^E
    #[arg(long, value_name = "E", default_value_t = 0.0, value_parser = exposure, allow_negative_numbers = true)]
    pub(crate) exposure: f32,

    /// The animation's frame N: the moment N / fps, from 0 (its state as loaded)
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) frame: Option<u32>,

    /// The animation's moment in seconds, from 0
    #[arg(long, value_name = "T", conflicts_with = "frame", value_parser = time)]
    pub(crate) time: Option<f32>,

    /// Frames a second, instead of the file's (24 where it does not say)
    #[arg(long, value_name = "F", value_parser = fps)]
    pub(crate) fps: Option<f32>,

    /// The glTF file's clip of that name or number (from 0) instead of its first; a scene file names its own
    #[arg(long, value_name = "CLIP", requires = "file")]
    pub(crate) clip: Option<String>,

    /// Threads to use, instead of one a core
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub(crate) threads: Option<u32>,

    /// No progress, no summary, no warnings
    #[arg(long, short)]
    pub(crate) quiet: bool,

    /// Print the summary as JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Render a picture
///
/// Writes PNG (eight-bit sRGB after exposure) or OpenEXR (linear RGB, 32-bit float), by the ending of the file's name.
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  lobes render
  lobes render scene.toml -o a.png -o a.exr --tolerance 0.003
  lobes render scene.toml -o a.exr --layers --stats a.json
  lobes render scene.toml -o unshadowed.exr --visibility none
  lobes render model.glb --visibility shadow-map        shadows of the true triangles
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
    #[arg(long, value_name = "D", value_parser = clap::value_parser!(u32).range(1..=6))]
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
    /// Frames whose files are all there are not rendered again (files appear whole or not at all), so the same command
    /// goes on where it was interrupted; delete them after a change of the scene or of options
    #[arg(long, value_name = "A..B", value_parser = frames, conflicts_with_all = ["frame", "time", "repeat"])]
    pub(crate) frames: Option<(u32, u32)>,

    /// Write times and counts of each stage to this file, as JSON: what --json prints
    #[arg(long, value_name = "FILE")]
    pub(crate) stats: Option<PathBuf>,

    /// Shade N times and report the median time
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub(crate) repeat: u32,
}

/// Compute the same picture by Monte Carlo, as a reference
///
/// Writes OpenEXR files with the layers beauty (channels R, G, B), unshadowed and stderr (the standard error of each pixel,
/// from eight independent randomisations). Ctrl-C keeps what was computed beside the output; the same command goes on
/// from there.
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

    /// Samples a light and point, rounded up to a multiple of 8; powers of two converge best
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..=1 << 24))]
    pub(crate) spp: u32,

    /// What casts shadows
    #[arg(long, value_enum, default_value_t = Geometry::Scene)]
    pub(crate) geometry: Geometry,

    /// Without shadows
    #[arg(long, conflicts_with = "geometry")]
    pub(crate) unshadowed: bool,

    /// Chooses the randomisations
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub(crate) seed: u64,

    /// Keep the checkpoint (OUTPUT.checkpoint, 192 bytes a point), to refine the result later
    #[arg(long)]
    pub(crate) keep: bool,
}

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

    /// The difference that has full colour in --diff; when left out, what 99 % of the pixels that differ stay below
    #[arg(long, value_name = "D", value_parser = positive)]
    pub(crate) diff_scale: Option<f32>,

    /// Write the FLIP map of visible differences
    #[arg(long, value_name = "PNG")]
    pub(crate) heatmap: Option<PathBuf>,

    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

/// Validate a scene and say what it requires
#[derive(Args, Debug)]
#[command(after_help = "Examples:
  lobes check scene.toml
  lobes check --schema > scene.toml")]
pub(crate) struct CheckArgs {
    /// Scene (.toml), model (.gltf, .glb, .obj, .ply); the built-in scene when left out
    pub(crate) file: Option<PathBuf>,

    /// Print a scene file that has every key, with its meaning
    #[arg(long, conflicts_with = "file")]
    pub(crate) schema: bool,

    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
}

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

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Visibility {
    /// Each object as the scene file says (its key `visibility`), by spheres where it says nothing
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

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Geometry {
    /// What `render` uses: spheres for objects that block by spheres, the true geometry of the others
    Scene,
    /// The spheres that stand for the objects
    Spheres,
    /// The true geometry of all objects: triangles and balls
    Mesh,
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

/// The name of a choice, as it is typed.
pub(crate) fn name(value: &impl ValueEnum) -> String {
    value.to_possible_value().map(|v| v.get_name().to_owned()).unwrap_or_default()
}

fn number(text: &str, range: &str, good: impl Fn(f32) -> bool) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(value) if good(value) => Ok(value),
        _ => Err(format!("expected a number {range}")),
    }
}

fn tolerance(text: &str) -> Result<f32, String> {
    number(text, "above 0 and at most 0.1", |x| x > 0.0 && x <= 0.1)
}

fn threshold(text: &str) -> Result<f32, String> {
    number(text, "of at least 0", |x| x >= 0.0 && x.is_finite())
}

fn exposure(text: &str) -> Result<f32, String> {
    number(text, "from -32 to 32", |x| x.abs() <= 32.0)
}

fn share(text: &str) -> Result<f32, String> {
    number(text, "above 0, at most 1", |x| x > 0.0 && x <= 1.0)
}

fn positive(text: &str) -> Result<f32, String> {
    number(text, "above 0", |x| x > 0.0 && x.is_finite())
}

fn time(text: &str) -> Result<f32, String> {
    number(text, "of at least 0", |x| x >= 0.0 && x.is_finite())
}

fn fps(text: &str) -> Result<f32, String> {
    number(text, "above 0 and at most 10000", |x| x > 0.0 && x <= 1e4)
}

fn frames(text: &str) -> Result<(u32, u32), String> {
    let ends = text.split_once("..").map(|(a, b)| (a.parse::<u32>(), b.parse::<u32>()));
    match ends {
        Some((Ok(a), Ok(b))) if a < b => Ok((a, b)),
        Some((Ok(a), Ok(b))) => Err(format!("there are no frames from {a} to before {b}")),
        _ => Err("expected A..B, such as 0..24".to_owned()),
    }
}

fn map_resolution(text: &str) -> Result<u32, String> {
    let (least, most) = (MapOptions::MIN_RESOLUTION, MapOptions::MAX_RESOLUTION);
    let good = text.parse::<u32>().ok().filter(|n| (least..=most).contains(n));
    good.ok_or_else(|| format!("a shadow map has {least} to {most} texels a side"))
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let side = |t: &str| t.parse::<u32>().ok().filter(|n| (1..=16384).contains(n));
    match text.split_once(['x', 'X', '×']).map(|(w, h)| (side(w), side(h))) {
        Some((Some(w), Some(h))) => Ok((w, h)),
        _ => Err("expected WIDTHxHEIGHT, each from 1 to 16384, such as 640x360".to_owned()),
    }
}

/// The command asked for; `None` when help or the version was asked for and has been printed.
pub(crate) fn parse() -> Result<Option<Command>, Failure> {
    match Cli::try_parse() {
        Ok(Cli { command: Some(command) }) => Ok(Some(command)),
        Ok(Cli { command: None }) => {
            console::say(Cli::command().render_help());
            Ok(None)
        }
        Err(error) if !error.use_stderr() => {
            console::say(error.render().to_string().trim_end());
            Ok(None)
        }
        Err(error) => {
            // Up to the first empty line: the message and what it lists; then come tips and usage.
            let text = error.render().to_string();
            let message = text.split("\n\n").next().unwrap_or_default().trim_start_matches("error: ");
            let help = "see lobes --help";
            Err(Failure::new(format_args!("{}; {help}", message.trim_end())))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_definition_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn values_are_checked() {
        assert_eq!(size("640x360"), Ok((640, 360)));
        for bad in ["0x0", "640", "x", "1x", "-1x5", "16385x1", "1x1x1", "1.5x2", "999999999999x1"] {
            assert!(size(bad).is_err(), "{bad}");
        }
        for bad in ["0", "-1", "NaN", "inf", "0.11", "", "x"] {
            assert!(tolerance(bad).is_err(), "{bad}");
        }
        assert_eq!(tolerance("0.1"), Ok(0.1));
        assert!(threshold("-1e-9").is_err() && exposure("nan").is_err() && positive("0").is_err());
    }
}
