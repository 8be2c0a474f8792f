use super::clock::ClockArgs;
use super::console::ConsoleArgs;
use super::model::ModelArgs;
use super::values::{fraction, frames, positive, tolerance, whole};
use clap::{Args, ValueEnum};
use cosine_lobes::renderer::Settings;
use cosine_lobes::shading::Accuracy;
use std::path::PathBuf;

/// Bake the light of a model or scene into a glTF file
///
/// Lights every texel or vertex with all lights and skies, with exact shadows, and writes a binary glTF that viewers and engines show. The
/// rest of a glTF file stays as it is; scene files, OBJ and PLY become a new one. An interrupted run keeps its finished work in
/// OUTPUT.checkpoint, and the same command goes on from there.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  lobes bake room.glb -o baked.glb                      any viewer shows it
  lobes bake room.glb -o baked.glb --as lightmap        for engines; baked.lightmap0.exr and .png beside it
  lobes bake room.glb -o baked.glb --as lightmap --per-light
  lobes bake room.glb -o baked.glb --as vertex-colors   no textures
  lobes bake room.glb -o baked.glb --as vertex-colors --subdivide 0.02
  lobes bake scene.toml -o baked.glb --density 40 --page 2048
  lobes bake walk.glb -o lit.glb --frames 0..24         lit.0000.glb to lit.0023.glb")]
pub(crate) struct BakeArgs {
    /// Model or scene (.glb, .gltf, .toml, .obj, .ply)
    pub(crate) file: PathBuf,

    /// File to write, .glb
    #[arg(long, short, value_name = "FILE", default_value = "baked.glb")]
    pub(crate) output: PathBuf,

    /// How light is written
    #[arg(long = "as", value_enum, default_value_t = Form::Emission)]
    pub(crate) form: Form,

    /// Side of a page of texels, 16 to 16384
    #[arg(long, value_name = "N", default_value_t = 1024, value_parser = whole(16..=16384))]
    pub(crate) page: u32,

    /// Texels along a unit of length, on as many pages as it takes; when left out, what fits one page. With --subdivide edges along a
    /// unit, at most; when left out, 512 along the longest side of all surfaces
    #[arg(long, value_name = "D", value_parser = positive)]
    pub(crate) density: Option<f32>,

    /// Texels around each chart that repeat its edge, 1 to 16
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = whole(1..=16))]
    pub(crate) padding: u32,

    /// Points along a texel's side, 1 to 8: a texel is the mean over their square
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = whole(1..=8))]
    pub(crate) samples: u32,

    /// Make new texture coordinates also where the file has a second set
    #[arg(long)]
    pub(crate) unwrap: bool,

    /// Give double-sided surfaces a back with light of its own; without it both sides show the light of the front. Of scene files, OBJ and
    /// PLY all surfaces are double-sided then
    #[arg(long)]
    pub(crate) both_sides: bool,

    /// Write maps of each light, too (.exr): light is linear, so that programs can dim and colour lights afterwards
    #[arg(long)]
    pub(crate) per_light: bool,

    /// With --as vertex-colors: divide triangles until light between their vertices is off by at most this part of the mean light
    #[arg(long, value_name = "ERROR", value_parser = fraction)]
    pub(crate) subdivide: Option<f32>,

    /// The most vertices that --subdivide makes, up to 2 million; the largest errors are mended first
    #[arg(long, value_name = "N", default_value_t = 1_000_000, requires = "subdivide", value_parser = whole(1..=2_000_000))]
    pub(crate) vertices: u32,

    /// Requested mean error in penumbra, as a fraction of the unshadowed light: above 0, at most 0.1
    #[arg(long, value_name = "T", default_value_t = 0.005, value_parser = tolerance)]
    pub(crate) tolerance: f32,

    /// Bake the light of the animation's frames A to B, B not included, each to a file of its own: -o out.glb gives out.0007.glb, with maps
    /// beside it. Existing frames are kept if the same command made them, and nothing else did since: so the same command resumes an
    /// interrupted run
    #[arg(long, value_name = "A..B", value_parser = frames, conflicts_with_all = ["frame", "time"])]
    pub(crate) frames: Option<(u32, u32)>,

    #[command(flatten)]
    pub(crate) clock: ClockArgs,

    /// The glTF file's clip of that name or number (from 0) whose moments are baked, instead of its first
    #[arg(long, value_name = "CLIP")]
    pub(crate) clip: Option<String>,

    #[command(flatten)]
    pub(crate) model: ModelArgs,

    #[command(flatten)]
    pub(crate) console: ConsoleArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Form {
    /// Light and colour together as emission of black materials (KHR_materials_emissive_strength)
    Emission,
    /// Light maps beside the materials (MOZ_lightmap), and each page as OpenEXR and PNG
    Lightmap,
    /// Colours of vertices, of unlit materials (KHR_materials_unlit)
    VertexColors,
}

impl BakeArgs {
    /// The settings of the baker.
    pub(crate) fn settings(&self) -> bake::BakeSettings {
        bake::BakeSettings {
            form: match self.form {
                Form::Emission => bake::Form::Emission,
                Form::Lightmap => bake::Form::Lightmap,
                Form::VertexColors => bake::Form::VertexColors,
            },
            page: self.page,
            density: self.density,
            padding: self.padding,
            samples: self.samples,
            per_light: self.per_light,
            unwrap: self.unwrap,
            both_sides: self.both_sides,
            subdivide: self.subdivide,
            most_vertices: self.vertices,
        }
    }

    /// The settings of the light.
    pub(crate) fn render_settings(&self) -> Settings {
        let cache = crate::input::cache_folder();
        Settings { accuracy: Accuracy::new(self.tolerance), cache, keep_points: false, ..Settings::default() }
    }
}
