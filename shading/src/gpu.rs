//! The parts that materials, lights and blockers bring to a GPU: WGSL text, and the words that it reads. Nothing here knows a graphics
//! library; `render-gpu` puts the parts together, the built-in ones and anybody's own alike.
//!
//! A text may call what [`wgsl`](lobe_core::wgsl) defines (`GEOMETRY`, `LOBE`, `SPECIAL`) and reads the light from `frame`: `frame.light`
//! (the light's [bounds](crate::LightLobes::bounds)), `frame.radiance`, `frame.shape`. Names start with that of the part, so that parts do not
//! collide.

use crate::{BrdfLobes, LightLobes};
use core::fmt::Debug;
use lobe_core::wgsl::Piece;
use lobe_core::{Outline, Sphere};
use std::borrow::Cow;

pub use crate::gpu_pages::GpuPages;

/// Materials as kernels read them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GpuMaterialSet {
    /// The models that occur, in words: part of a kernel's name.
    pub name: String,
    /// Defines `fn brdf_lobe_count(material: u32) -> u32` and `fn brdf_lobe(material: u32, at: Receiver, k: u32) -> Lobe`: the lobes of
    /// [`brdf_lobes`](BrdfLobes::brdf_lobes) in the same order, with a flux of 0 where a receiver has less. Both read `materials`, an
    /// `array<u32>`, which render-gpu declares.
    pub wgsl: String,
    /// The pieces that it calls; `LOBE` of lobe-core is there.
    pub needs: Vec<&'static Piece>,
    /// The words of `materials`. Not empty.
    pub words: Vec<u32>,
    /// The largest number of lobes of a material.
    pub max_lobes: u32,
    /// Whether all lobes are Lambert's: exponent 1 about the normal. Kernels are smaller then.
    pub is_lambert: bool,
    /// Whether there may be lobes of [microfacets](lobe_core::Microfacets).
    pub has_microfacets: bool,
    /// Whether these may have a [grain](lobe_core::Grain).
    pub has_grain: bool,
}

/// Materials that a GPU can shade.
///
/// ```
/// use glam::Vec3;
/// use shading::gpu::{GpuMaterialSet, GpuMaterials};
/// use lobe_core::{BrdfLobe, Lobe, Receiver};
/// use shading::BrdfLobes;
///
/// /// Reflects back to where the light came from, in a colour.
/// struct Retro(Vec3);
///
/// impl BrdfLobes for Retro {
///     fn brdf_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
///         out.push(Lobe::with_flux(at.view, 40.0, self.0).into());
///     }
/// }
///
/// impl GpuMaterials for Retro {
///     fn gpu_set(materials: &[Self]) -> Result<GpuMaterialSet, String> {
///         let wgsl = "fn brdf_lobe_count(material: u32) -> u32 { return 1u; }
///             fn brdf_lobe(material: u32, at: Receiver, k: u32) -> Lobe {
///                 let color = vec3u(materials[3u * material], materials[3u * material + 1u], materials[3u * material + 2u]);
///                 return Lobe(at.view, 40.0, bitcast<vec3f>(color), LOBE_PLAIN);
///             }";
///         let words = materials.iter().flat_map(|m| m.0.to_array()).map(f32::to_bits).collect();
///         Ok(GpuMaterialSet { name: "retro".into(), wgsl: wgsl.into(), words, max_lobes: 1, ..GpuMaterialSet::default() })
///     }
/// }
/// ```
pub trait GpuMaterials: BrdfLobes + Sized {
    /// All of a frame's materials, numbered as in the list.
    ///
    /// # Errors
    /// Which of them a GPU cannot shade, in a sentence.
    fn gpu_set(materials: &[Self]) -> Result<GpuMaterialSet, String>;

    /// The same by [`cosine_lobes`](BrdfLobes::cosine_lobes). Provided: [`gpu_set`](Self::gpu_set), of materials without microfacets.
    ///
    /// # Errors
    /// As [`gpu_set`](Self::gpu_set).
    fn gpu_cosine_set(materials: &[Self]) -> Result<GpuMaterialSet, String> {
        Self::gpu_set(materials)
    }
}

/// Name and text of a kind of light.
pub type GpuText = (&'static str, &'static Piece);

/// The most rows of a light's [shape](GpuLight::gpu_shape).
pub const GPU_SHAPE: usize = 2 + Outline::MOST;

/// A kind of light that a GPU can shade with.
pub trait GpuLight: LightLobes {
    /// The kind, in a word: part of a kernel's name.
    const NAME: &'static str;

    /// Defines `fn light_cone(at: Receiver) -> Cone` and `fn light_radiance(at: Receiver) -> vec3f`: as
    /// [`cone`](LightLobes::cone) and [`radiance`](LightLobes::radiance). The cone of a light with an [outline](LightLobes::outline) comes from
    /// `outline_cone`, after `outline_new` or `outline_disc` and before `outline_keep_above(at.normal)`
    /// ([`OUTLINE`](lobe_core::wgsl::OUTLINE)).
    const WGSL: &'static Piece;

    /// Name and text for this light, among all of a frame: lights of the same text share their kernels. [`NAME`](Self::NAME) and
    /// [`WGSL`](Self::WGSL), unless the type has several kinds.
    ///
    /// # Errors
    /// Why a GPU cannot shade with it, in a sentence.
    fn gpu_text(&self, frame: &[Self]) -> Result<GpuText, String>
    where
        Self: Sized,
    {
        let _ = frame;
        Ok((Self::NAME, Self::WGSL))
    }

    /// Of a light that may have an [outline](LightLobes::outline) its [roundness](lobe_core::Outline::roundness), by which masks are made finer.
    /// None, the default, for a light that is always a cone.
    fn gpu_roundness(&self) -> Option<f32> {
        None
    }

    /// The value of `frame.light`: a sphere around the light and, of one with an outline, around windows on it.
    fn gpu_bounds(&self) -> Sphere {
        match self.gpu_roundness() {
            Some(_) => Outline::sphere_around(self.bounds()),
            None => self.bounds(),
        }
    }

    /// The value of `frame.radiance`.
    fn gpu_radiance(&self) -> [f32; 3];

    /// The value of `frame.shape`, an `array<vec4f, 26>`: the first of these, and zeros. Nothing by default.
    fn gpu_shape(&self) -> Vec<[f32; 4]> {
        Vec::new()
    }
}

/// A buffer of a part. Kernels that shade read it: `var<storage, read> NAME: array<ELEMENT>`, which render-gpu declares.
#[derive(Clone, Debug, PartialEq)]
pub struct GpuBuffer<'a> {
    /// Its name in WGSL; starts with that of its part.
    pub name: &'static str,
    /// Type of its elements in WGSL: `u32`, `vec4f`, or a struct of the part's text.
    pub element: &'static str,
    /// Its contents, which are not empty. `arrayLength` counts just these.
    pub contents: GpuContents<'a>,
}

impl<'a> GpuBuffer<'a> {
    /// One of words that a CPU has.
    #[must_use]
    pub fn of(name: &'static str, element: &'static str, words: impl Into<Cow<'a, [u32]>>) -> Self {
        Self { name, element, contents: GpuContents::Words(words.into()) }
    }
}

/// Contents of a buffer.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum GpuContents<'a> {
    /// These words. Only those that differ from the last time are uploaded.
    Words(Cow<'a, [u32]>),
    /// More words than a binding may have to hold. They are in [`GpuPages`] and read by `fn NAME_word(k: u32) -> u32`; elements are `u32`.
    Pages {
        /// The words.
        words: &'a [u32],
        /// A number that is another one whenever the words are: equal words are not compared.
        revision: u64,
    },
    /// So many words that [passes](GpuBlockers::passes) write.
    Room(u32),
    /// So many for each tile of 64 points.
    RoomPerTile(u32),
}

/// Work before the points of a light are classified.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GpuPass {
    /// The entry point, of workgroups of any size.
    pub entry: &'static str,
    /// Its text, without declarations of buffers. `GEOMETRY` of lobe-core is there, and `frame`.
    pub piece: &'static Piece,
    /// Names of the part's buffers that it reads; `points` are the points of the slice, an `array<Receiver>`.
    pub reads: Vec<&'static str>,
    /// Names of those that it writes, too.
    pub writes: Vec<&'static str>,
    /// Its workgroups, and when they run.
    pub run: GpuRun,
}

/// When a [`GpuPass`] runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum GpuRun {
    /// For each light, with a workgroup for each tile of 64 points: `frame` is the light's.
    Tiles,
    /// So many workgroups, when what it reads has changed. Its `frame` says nothing.
    Changed(u32),
}

/// How blockers draw before a whole sky.
///
/// With NAME for the blockers' [`name`](GpuBlockers::name), by workgroups of one receiver each:
/// - `fn NAME_sky(lane: u32, at: Receiver)` draws all outlines above the horizon by `sky_draw_arc` or `sky_cross` of visibility-mask's
///   `SKY_BUFFER`, in any order; all threads call it, so there may be barriers, and it may be called several times;
/// - `fn NAME_sky_hides(at: Receiver, direction: vec3f) -> bool`, for one thread, whether they hide a direction;
/// - `fn NAME_sky_has_facet(at: Receiver) -> bool`, whether the receiver's own facet hides what is below it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GpuSkyPart {
    /// These functions.
    pub piece: &'static Piece,
    /// Names of the part's buffers that they read.
    pub reads: Vec<&'static str>,
}

/// Blockers that a GPU can shade with.
///
/// # Functions
/// With NAME for [`name`](Self::name):
/// - of [`coverage`](Self::coverage): `fn NAME_coverage(tile: u32, at: Receiver, cone: Cone) -> u32`, one thread a receiver: `LIT`, `PARTIAL` or
///   `DARK`, as the `select` of `Blockers`;
/// - of [`splat`](Self::splat): `fn NAME_splat(lane: u32, tile: u32, at: Receiver, light: Cone, mask: Mask)`, one thread a row of the mask, by the
///   functions of visibility-mask's `mask.wgsl`: `mask_block_span` and others. The threads of a workgroup have the same receiver, and all
///   of them call it: there may be barriers and workgroup memory;
/// - where [`has_edges`](Self::has_edges), of the same: `fn NAME_edges(lane: u32, tile: u32, at: Receiver, light: Cone, window: Cone) -> vec4f`, a thread's part of the
///   sum of edges, and of that of four times the angles of straight ones (or 0);
/// - for use where [`asks_any_hit`](Self::asks_any_hit), of a scene's triangles and spheres: `any_hit(origin: vec3f, direction: vec3f, distance: f32)
///   -> bool`, whether one lies on a ray; `any_hit_cone(origin: vec3f, cone: Cone, face: vec3f) -> bool`, false only where no ray meets any that
///   leaves into the cone, on the side of `face` of the plane through the origin (or 0: all), up to the light; `any_hit_leave(at: Receiver) -> vec3f`,
///   where rays start that leave a receiver; `any_hit_of(object: u32)`, said before the rays of a receiver on an object where the scene knows objects
///   that block for their like alone; `any_hit_has(object: u32) -> bool`, whether an object's shapes
///   are among them; `any_hit_side(a: vec3f, b: vec3f, c: vec3f, x: vec3f) -> f32`, above 0 where a point is in front of a triangle, below 0 behind it, to 2⁻⁴⁰ of
///   the triangle's size.
///
/// # Pieces
/// The pieces of a part [name](Piece::needs) those of the crates that they call, such as visibility-mask's `FACET`, and its `MASK` and `EDGES` for
/// masks. A choice is the shader's: `OUTLINE` or `NO_OUTLINE` of lobe-core, the header of masks, their `ROUND` or `FLAT`.
pub trait GpuBlockers: Debug + Sync {
    /// The prefix of the names of its functions and buffers.
    fn name(&self) -> &'static str;

    /// Constants that depend on the blockers, as [`constant`](lobe_core::wgsl::constant) writes them. Kernels are made for each value.
    fn constants(&self) -> String {
        String::new()
    }

    /// `NAME_coverage`, and what it needs.
    fn coverage(&self) -> &'static Piece;

    /// `NAME_splat`, and `NAME_edges` where there is one, and what they need.
    fn splat(&self) -> &'static Piece;

    /// Whether masks are turned across its edges.
    fn has_edges(&self) -> bool {
        false
    }

    /// How they draw before a whole sky. None, the default: the patches of an environment are lights like others.
    fn sky(&self) -> Option<GpuSkyPart> {
        None
    }

    /// Whether its functions ask what rays meet. The shader must have a scene for that.
    fn asks_any_hit(&self) -> bool {
        false
    }

    /// Whether nothing of it blocks now: kernels are made without it.
    fn is_empty(&self) -> bool {
        false
    }

    /// The buffers that its functions read, as of now.
    fn buffers(&self) -> Vec<GpuBuffer<'_>>;

    /// Its passes, which run in this order before its functions are called.
    fn passes(&self) -> Vec<GpuPass> {
        Vec::new()
    }
}
