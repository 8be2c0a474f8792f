//! The texts of the kernels. Each is a module of its own, made of the pieces that a frame uses and no others.

use crate::binding::{
    Access::{self, Read, Uniform, Write},
    Binding, Slot,
};
use crate::{kernels, wgsl};
use lobe_core::wgsl as lobes;
use shading::gpu::{GpuBlockers, GpuLight, GpuPages, GpuPass};
use visibility_mask::{Fineness, wgsl as masks};

/// The properties of a frame that its kernels depend on.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Variant {
    pub(crate) depth: u32,
    /// Resolution of the masks for broad lobes and for narrow ones.
    pub(crate) fineness: [Fineness; 2],
    pub(crate) materials: MaterialText,
    /// Name and text of the kind of light.
    pub(crate) light: [&'static str; 2],
    pub(crate) shown: Shown,
    /// The strategies that block something.
    pub(crate) own: Vec<OwnText>,
    /// Size of the stack for the rays that they trace.
    pub(crate) stack: Option<u32>,
    /// Whether the paper's method is used instead of moments.
    pub(crate) paper: bool,
}

/// The texts of the materials.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct MaterialText {
    pub(crate) name: String,
    pub(crate) wgsl: String,
    pub(crate) is_lambert: bool,
    pub(crate) has_microfacets: bool,
}

/// The shape in which a light may appear.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shown {
    /// A cone.
    Cone,
    /// An outline, or a cone.
    Outline,
    /// An outline that shows an image.
    Image,
}

impl Shown {
    pub(crate) fn of<L: GpuLight>(light: &L) -> Self {
        match (light.gpu_roundness(), light.image()) {
            (None, _) => Self::Cone,
            (Some(_), None) => Self::Outline,
            (Some(_), Some(_)) => Self::Image,
        }
    }

    /// Words of a lobe's integral.
    pub(crate) const fn words(self) -> u64 {
        match self {
            Self::Cone | Self::Outline => 1,
            Self::Image => 3,
        }
    }
}

/// A buffer of a strategy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct OwnBuffer {
    /// The first number of its slots.
    pub(crate) first: u32,
    /// The pages, if the buffer is read by words.
    pub(crate) pages: Option<GpuPages>,
    pub(crate) name: &'static str,
    pub(crate) element: &'static str,
}

impl OwnBuffer {
    pub(crate) fn slots(&self) -> impl Iterator<Item = Slot> {
        let count = self.pages.map_or(1, GpuPages::count);
        (self.first..self.first + count).map(Slot::Own)
    }

    pub(crate) fn declaration(&self, access: Access) -> String {
        let binding = Slot::Own(self.first).binding();
        if let Some(pages) = self.pages {
            return pages.wgsl(self.name, binding);
        }
        let access = if access == Write { "read_write" } else { "read" };
        let Self { name, element, .. } = self;
        format!("@group(0) @binding({binding}) var<storage, {access}> {name}: array<{element}>;\n")
    }
}

/// The texts of a strategy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct OwnText {
    pub(crate) name: &'static str,
    pub(crate) shared: String,
    pub(crate) coverage: String,
    pub(crate) coverage_needs: Vec<&'static str>,
    pub(crate) splat: String,
    pub(crate) splat_needs: Vec<&'static str>,
    pub(crate) has_edges: bool,
    pub(crate) buffers: Vec<OwnBuffer>,
}

impl OwnText {
    pub(crate) fn new(blockers: &dyn GpuBlockers, buffers: Vec<OwnBuffer>) -> Self {
        Self {
            name: blockers.name(),
            shared: blockers.shared(),
            coverage: blockers.coverage(),
            coverage_needs: blockers.coverage_needs(),
            splat: blockers.splat(),
            splat_needs: blockers.splat_needs(),
            has_edges: blockers.has_edges(),
            buffers,
        }
    }

    /// The declarations of its buffers.
    fn declarations(&self) -> String {
        self.buffers.iter().map(|buffer| buffer.declaration(Read)).collect()
    }
}

impl Variant {
    /// The buffers of the kernels that shade.
    fn bindings(&self) -> Vec<Binding> {
        let tables: &[Binding] = if self.paper { &[(Slot::Tables, Read)] } else { &[] };
        let own = self.own.iter().flat_map(|own| &own.buffers).flat_map(OwnBuffer::slots).map(|slot| (slot, Read));
        let own: Vec<Binding> = own.collect();
        let world: &[Binding] =
            if self.stack.is_some() { &[(Slot::Nodes, Read), (Slot::Primitives, Read)] } else { &[] };
        let images: &[Binding] = if self.shown == Shown::Image { &[(Slot::Images, Read)] } else { &[] };
        [SHADED.as_slice(), &own, world, tables, images].concat()
    }

    /// The name of the kernel, for messages and the log.
    fn name(&self) -> String {
        let strategies: Vec<&str> = self.own.iter().map(|own| own.name).collect();
        let strategies = if strategies.is_empty() { "no blockers".to_owned() } else { strategies.join(" + ") };
        let method = if self.paper { ", paper" } else { "" };
        format!("{strategies}, {}, {}, depth {}{method}", self.light[0], self.materials.name, self.depth)
    }

    /// The integrals of lobes over a light.
    fn integral(&self) -> Vec<&'static str> {
        let MaterialText { is_lambert, has_microfacets, .. } = self.materials;
        let mut pieces = if has_microfacets { vec![lobes::MICROFACETS] } else { Vec::new() };
        if self.shown != Shown::Image {
            pieces.extend(match (is_lambert, has_microfacets) {
                (true, _) => [lobes::CAP_LAMBERT, ""],
                (false, true) => [lobes::CAP, lobes::CAP_MICROFACETS],
                (false, false) => [lobes::CAP, lobes::CAP_NO_MICROFACETS],
            });
        }
        if self.shown != Shown::Cone {
            pieces.push(lobes::OUTLINE_INTEGRAL);
            pieces.push(if has_microfacets { lobes::OUTLINE_MICROFACETS } else { lobes::OUTLINE_NO_MICROFACETS });
        }
        pieces.push(match self.shown {
            Shown::Cone => OVER_CONES,
            Shown::Outline => lobes::OUTLINE_PLAIN,
            Shown::Image => lobes::OUTLINE_IMAGE,
        });
        pieces
    }

    /// How a point sees the light, and the light's integrals in the queue.
    fn light(&self) -> Vec<&'static str> {
        let light = self.light[1];
        match self.shown {
            Shown::Cone => vec![light, lobes::NO_OUTLINE, kernels::INTEGRALS],
            Shown::Outline => vec![light, lobes::OUTLINE, kernels::INTEGRALS],
            Shown::Image => vec![light, lobes::OUTLINE, lobes::IMAGE, IMAGES, kernels::INTEGRALS_BY_CHANNEL],
        }
    }

    /// How masks show the emitting region.
    const fn window(&self) -> &'static str {
        match self.shown {
            Shown::Cone => masks::ROUND,
            Shown::Outline | Shown::Image => masks::FLAT,
        }
    }

    /// The visible fraction of lobes, from masks.
    fn fractions(&self) -> Vec<&'static str> {
        let MaterialText { is_lambert, has_microfacets, .. } = self.materials;
        let mut pieces = vec![masks::FRACTION, masks::VISIBILITY];
        if is_lambert && self.shown != Shown::Image {
            pieces.push(masks::LAMBERT);
            return pieces;
        }
        pieces.push(masks::LOBES);
        if has_microfacets {
            pieces.extend([lobes::MICROFACETS, masks::MICROFACETS]);
        }
        match (self.shown, has_microfacets) {
            (Shown::Image, true) => pieces.extend([masks::IMAGE, masks::IMAGE_MICROFACETS]),
            (Shown::Image, false) => pieces.extend([masks::IMAGE, masks::IMAGE_NO_MICROFACETS]),
            _ => pieces.push(masks::ALIKE),
        }
        pieces
    }

    /// Whether anything blocks.
    pub(crate) fn is_blocked(&self) -> bool {
        !self.own.is_empty()
    }

    /// Ray queries of strategies against the scene.
    fn world(&self) -> Vec<String> {
        let of = |size: u32| vec![format!("const STACK = {size}u;"), wgsl::BVH.to_owned(), wgsl::ANY_HIT.to_owned()];
        self.stack.map_or_else(Vec::new, of)
    }
}

/// A kernel's entry point, text and bindings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Text {
    pub(crate) entry: &'static str,
    /// The entry point and the variant.
    pub(crate) name: String,
    pub(crate) text: String,
    pub(crate) bindings: Vec<Binding>,
}

impl Text {
    /// Pieces that several parts need are included once.
    pub(crate) fn new(entry: &'static str, pieces: &[&str], bindings: &[Binding]) -> Self {
        let mut once: Vec<&str> = Vec::with_capacity(pieces.len());
        for piece in pieces {
            if !once.contains(piece) {
                once.push(piece);
            }
        }
        Self { entry, name: entry.to_owned(), text: once.join("\n"), bindings: bindings.to_vec() }
    }

    fn of(self, variant: &Variant) -> Self {
        Self { name: format!("{} ({})", self.entry, variant.name()), ..self }
    }
}

/// Declares the points for a kernel that declares nothing else of [`kernels::POINTS`].
pub(crate) const POINTS_ALONE: &str = "@group(0) @binding(1) var<storage, read> points: array<Receiver>;\n";

/// The text of a strategy's own pass.
pub(crate) fn pass(pass: &GpuPass, declarations: &str, bindings: &[Binding]) -> Text {
    let mut pieces = vec![kernels::FRAME, lobes::GEOMETRY, declarations, &pass.text];
    pieces.extend(&pass.needs);
    Text::new(pass.entry, &pieces, bindings)
}

/// The kernel that computes the size of the penumbra kernel's dispatch.
pub(crate) fn args() -> Text {
    let pieces = [kernels::FRAME, kernels::QUEUE, kernels::ARGS];
    Text::new("args_of_queue", &pieces, &[(Slot::Frame, Uniform), (Slot::Queue, Write), (Slot::Indirect, Write)])
}

/// The bindings of the kernels that shade.
const SHADED: [Binding; 5] = [
    (Slot::Frame, Uniform),
    (Slot::Points, Read),
    (Slot::Materials, Read),
    (Slot::Radiance, Write),
    (Slot::Queue, Write),
];

const OVER_CONES: &str =
    "fn light_integral(at: Receiver, lobe: Lobe, cone: Cone) -> f32 { return cap_integral(at, lobe, cone); }";
const IMAGES: &str = "@group(0) @binding(8) var<storage, read> light_images: array<u32>;";

/// The kernel that classifies each point as lit, dark or in penumbra for a light.
pub(crate) fn classify(variant: &Variant) -> Text {
    let reflectance = &variant.materials.wgsl;
    let (integral, kernel) = if variant.paper {
        (vec![paper::wgsl::TABLES], kernels::PAPER_CLASSIFY)
    } else {
        (variant.integral(), kernels::CLASSIFY)
    };
    let of = |own: &OwnText| format!("coverage = max(coverage, {}_coverage(tile, at, cone));", own.name);
    let all: String = variant.own.iter().map(of).collect();
    let hook = format!(
        "fn blockers_coverage(tile: u32, at: Receiver, cone: Cone) -> u32 {{ var coverage = LIT; {all} return coverage; }}"
    );
    let world = variant.world();
    let mut pieces = vec![
        kernels::FRAME,
        kernels::QUEUE,
        kernels::POINTS,
        kernels::TILES,
        lobes::SPECIAL,
        lobes::GEOMETRY,
        lobes::LOBE,
        reflectance,
        &hook,
        kernel,
    ];
    pieces.extend(variant.light());
    pieces.extend(integral);
    pieces.extend(world.iter().map(String::as_str));
    if variant.is_blocked() {
        pieces.push(masks::FACET);
    }
    let declarations: Vec<String> = variant.own.iter().map(OwnText::declarations).collect();
    for (own, declarations) in variant.own.iter().zip(&declarations) {
        pieces.extend([own.shared.as_str(), declarations, &own.coverage]);
        pieces.extend(&own.coverage_needs);
    }
    if pieces.contains(&masks::SQUARE) {
        pieces.push(variant.window());
    }
    Text::new("classify", &pieces, &variant.bindings()).of(variant)
}

/// The kernel that shades the points in a light's penumbra.
pub(crate) fn penumbra(variant: &Variant) -> Text {
    let reflectance = &variant.materials.wgsl;
    let [broad, narrow] = variant.fineness;
    let header = match (variant.paper, variant.materials.is_lambert && variant.shown != Shown::Image) {
        (true, _) => paper::wgsl::header(variant.depth),
        (false, true) => masks::header(variant.depth, broad),
        (false, false) => masks::header_of_lobes(variant.depth, broad, narrow, variant.materials.has_microfacets),
    };
    let edges = variant.own.iter().filter(|own| own.has_edges);
    let edges = edges.map(|own| format!("edges += {}_edges(lane, tile, at, light, window);", own.name));
    let edges: String = edges.collect();
    let splats = variant.own.iter().map(|own| format!("{}_splat(lane, tile, at, light, mask);", own.name));
    let splats: String = splats.collect();
    let world = variant.world();
    let hooks = format!(
        "fn blockers_edges(lane: u32, tile: u32, at: Receiver, light: Cone, window: Cone) -> vec4f {{ \
        var edges = vec4f(0.0); {edges} return edges; }}\n\
        fn blockers_splat(lane: u32, tile: u32, at: Receiver, light: Cone, mask: Mask) {{ {splats} }}"
    );
    let mut pieces = vec![
        kernels::FRAME,
        kernels::QUEUE,
        kernels::POINTS,
        lobes::SPECIAL,
        lobes::GEOMETRY,
        lobes::LOBE,
        reflectance,
        &header,
        masks::SQUARE,
        variant.window(),
        masks::MASK,
        masks::EDGES,
        masks::TOTAL,
        &hooks,
    ];
    if variant.paper {
        pieces.extend([paper::wgsl::TABLES, paper::wgsl::VISIBILITY, kernels::PAPER_PENUMBRA]);
    } else {
        pieces.push(kernels::PENUMBRA);
        pieces.extend(variant.fractions());
    }
    pieces.extend(variant.light());
    pieces.extend(world.iter().map(String::as_str));
    if variant.is_blocked() {
        pieces.push(masks::FACET);
    }
    let declarations: Vec<String> = variant.own.iter().map(OwnText::declarations).collect();
    for (own, declarations) in variant.own.iter().zip(&declarations) {
        pieces.extend([own.shared.as_str(), declarations, &own.splat]);
        pieces.extend(&own.splat_needs);
    }
    Text::new("penumbra", &pieces, &variant.bindings()).of(variant)
}

#[cfg(test)]
#[path = "module_tests.rs"]
mod tests;
