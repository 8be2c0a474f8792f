//! The texts of the kernels: each is a module of its own, of the pieces that a frame uses and no other.

use crate::kernel::{
    Access::{Read, Uniform, Write},
    Binding, Slot,
};
use crate::{kernels, wgsl};
use lobe_core::gpu::{GpuBlockers, GpuLight};
use lobe_core::wgsl as lobes;
use visibility_mask::{Fineness, wgsl as masks};
use visibility_shadowmap::{Pages, wgsl as maps};
use visibility_spheres::wgsl as spheres;

/// Bytes of a tile's list.
pub(crate) const LIST_BYTES: u64 = 4 * visibility_spheres::LIST_WORDS as u64;

/// What the kernels of a frame depend on.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Variant {
    pub(crate) depth: u32,
    /// What broad lobes and narrow ones see.
    pub(crate) fineness: [Fineness; 2],
    pub(crate) materials: MaterialText,
    /// Name and text of the kind of light.
    pub(crate) light: [&'static str; 2],
    pub(crate) shown: Shown,
    pub(crate) strategies: Strategies,
    /// Somebody's own strategies.
    pub(crate) own: Vec<OwnText>,
    /// By the paper's method, and not by moments.
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

/// What a light may be seen as.
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

/// Which strategies have blockers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Strategies {
    pub(crate) spheres: bool,
    /// How the shadow maps are bound.
    pub(crate) maps: Option<Pages>,
    /// Size of the stack of the rays that strategies ask for.
    pub(crate) any_hit: Option<u32>,
}

/// The texts of somebody's own strategy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct OwnText {
    pub(crate) name: &'static str,
    pub(crate) shared: String,
    pub(crate) coverage: String,
    pub(crate) coverage_needs: Vec<&'static str>,
    pub(crate) splat: String,
    pub(crate) splat_needs: Vec<&'static str>,
    pub(crate) has_edges: bool,
    /// Number, name and type of its buffers.
    pub(crate) buffers: Vec<(u32, &'static str, &'static str)>,
}

impl OwnText {
    pub(crate) fn new(blockers: &dyn GpuBlockers, buffers: Vec<(u32, &'static str, &'static str)>) -> Self {
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
        let declare = |(number, name, element): &(u32, &str, &str)| {
            let binding = Slot::Own(*number).binding();
            format!("@group(0) @binding({binding}) var<storage, read> {name}: array<{element}>;\n")
        };
        self.buffers.iter().map(declare).collect()
    }
}

impl Strategies {
    pub(crate) const fn any(self) -> bool {
        self.spheres || self.maps.is_some()
    }

    /// The bindings of those that there are.
    fn bindings(self) -> Vec<Binding> {
        let mut bindings = Vec::new();
        if self.spheres {
            bindings.extend([(Slot::Spheres, Read), (Slot::Lists, Read), (Slot::Bounds, Read)]);
        }
        if let Some(pages) = self.maps {
            bindings.extend((0..pages.count()).map(|page| (Slot::Maps(page), Read)));
        }
        if self.any_hit.is_some() {
            bindings.extend([(Slot::Nodes, Read), (Slot::Primitives, Read)]);
        }
        bindings
    }

    /// The size of the stack of rays.
    fn stack(self) -> String {
        self.any_hit.map_or_else(String::new, |size| format!("const STACK = {size}u;"))
    }

    /// The code that reads the shadow maps.
    fn words(self) -> String {
        self.maps.map_or_else(String::new, Pages::wgsl)
    }

    /// Calls of those that there are.
    fn calls(self) -> impl Iterator<Item = &'static str> {
        let all = [(self.spheres, "spheres"), (self.maps.is_some(), "maps")];
        all.into_iter().filter_map(|(has, name)| has.then_some(name))
    }
}

impl Variant {
    /// The buffers of the kernels that shade.
    fn bindings(&self) -> Vec<Binding> {
        let tables: &[Binding] = if self.paper { &[(Slot::Tables, Read)] } else { &[] };
        let own: Vec<Binding> =
            self.own.iter().flat_map(|own| &own.buffers).map(|(number, ..)| (Slot::Own(*number), Read)).collect();
        let images: &[Binding] = if self.shown == Shown::Image { &[(Slot::Images, Read)] } else { &[] };
        [SHADED.as_slice(), &self.strategies.bindings(), &own, tables, images].concat()
    }

    /// The purpose of the kernel, in words.
    fn name(&self) -> String {
        let strategies: Vec<&str> = self.strategies.calls().chain(self.own.iter().map(|own| own.name)).collect();
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

    /// How a point sees the light, and integrals of it in the queue.
    fn light(&self) -> Vec<&'static str> {
        let light = self.light[1];
        match self.shown {
            Shown::Cone => vec![light, lobes::NO_OUTLINE, kernels::INTEGRALS],
            Shown::Outline => vec![light, lobes::OUTLINE, kernels::INTEGRALS],
            Shown::Image => vec![light, lobes::OUTLINE, lobes::IMAGE, IMAGES, kernels::INTEGRALS_BY_CHANNEL],
        }
    }

    /// How masks show what emits.
    const fn window(&self) -> &'static str {
        match self.shown {
            Shown::Cone => masks::ROUND,
            Shown::Outline | Shown::Image => masks::FLAT,
        }
    }

    /// What lobes see through masks.
    fn fractions(&self) -> Vec<&'static str> {
        let MaterialText { is_lambert, has_microfacets, .. } = self.materials;
        let mut pieces = vec![masks::SHARE, masks::VISIBILITY];
        pieces.push(if is_lambert && self.shown != Shown::Image { masks::LAMBERT } else { masks::LOBES });
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
        self.strategies.any() || !self.own.is_empty()
    }
}

/// A kernel's entry point, text and bindings.
pub(crate) struct Text {
    pub(crate) entry: &'static str,
    /// The entry point, and what the text was made for.
    pub(crate) name: String,
    pub(crate) text: String,
    pub(crate) bindings: Vec<Binding>,
}

impl Text {
    /// Pieces that several parts need are there once.
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

/// Follows spheres with the bounds of their blocks: [`bound_groups`] workgroups.
pub(crate) fn bounds() -> Text {
    let pieces = [kernels::FRAME, spheres::PACKED, kernels::BOUNDS];
    Text::new("bounds", &pieces, &[(Slot::Frame, Uniform), (Slot::Spheres, Read), (Slot::Bounds, Write)])
}

/// Workgroups for so many blocks.
pub(crate) const fn bound_groups(blocks: u32) -> u32 {
    blocks.div_ceil(64)
}

/// The spheres that each tile has to look at.
pub(crate) fn cull() -> Text {
    let pieces = [kernels::FRAME, spheres::PACKED, spheres::SHAFT_TEST, lobes::GEOMETRY, kernels::CULL];
    let bindings = [
        (Slot::Frame, Uniform),
        (Slot::Points, Read),
        (Slot::Spheres, Read),
        (Slot::Lists, Write),
        (Slot::Bounds, Read),
    ];
    Text::new("cull", &pieces, &bindings)
}

/// The size of the penumbra kernel's dispatch.
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

/// What every point sees of a light.
pub(crate) fn classify(variant: &Variant) -> Text {
    let reflectance = &variant.materials.wgsl;
    let (integral, kernel) = if variant.paper {
        (vec![lobes::PAPER], kernels::PAPER_CLASSIFY)
    } else {
        (variant.integral(), kernels::CLASSIFY)
    };
    let strategies = variant.strategies;
    let all = strategies.calls().map(|name| match name {
        "spheres" => "coverage = max(coverage, spheres_coverage(tile, at, cone));",
        _ => "coverage = max(coverage, maps_coverage(at, cone));",
    });
    let own = variant.own.iter().map(|own| format!("coverage = max(coverage, {}_coverage(tile, at, cone));", own.name));
    let all: String = all.map(str::to_owned).chain(own).collect();
    let hook = format!(
        "fn blockers_coverage(tile: u32, at: Receiver, cone: Cone) -> u32 {{ var coverage = LIT; {all} return coverage; }}"
    );
    let (stack, words) = (strategies.stack(), strategies.words());
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
    if strategies.spheres {
        pieces.extend([spheres::PACKED, spheres::CONE_TEST, spheres::BLOCKED_CONE, spheres::SPHERES]);
    }
    if strategies.any_hit.is_some() {
        pieces.extend([stack.as_str(), wgsl::BVH, wgsl::ANY_HIT]);
    }
    if variant.is_blocked() {
        pieces.push(masks::FACET);
    }
    let declarations: Vec<String> = variant.own.iter().map(OwnText::declarations).collect();
    for (own, declarations) in variant.own.iter().zip(&declarations) {
        pieces.extend([own.shared.as_str(), declarations, &own.coverage]);
        pieces.extend(&own.coverage_needs);
    }
    if strategies.maps.is_some() {
        pieces.extend([masks::SQUARE, variant.window(), words.as_str(), maps::COMMON, maps::COVERAGE]);
    }
    Text::new("classify", &pieces, &variant.bindings()).of(variant)
}

/// What the points in a penumbra see.
pub(crate) fn penumbra(variant: &Variant) -> Text {
    let reflectance = &variant.materials.wgsl;
    let [broad, narrow] = variant.fineness;
    let header = match (variant.paper, variant.materials.is_lambert && variant.shown != Shown::Image) {
        (true, _) => masks::paper_header(variant.depth),
        (false, true) => masks::header(variant.depth, broad),
        (false, false) => masks::header_of_lobes(variant.depth, broad, narrow, variant.materials.has_microfacets),
    };
    let strategies = variant.strategies;
    let edges = strategies.calls().map(|name| match name {
        "spheres" => "edges += vec4f(spheres_edges(lane, tile, at, light, window), 0.0, 0.0);",
        _ => "",
    });
    let own = variant.own.iter().filter(|own| own.has_edges);
    let own = own.map(|own| format!("edges += {}_edges(lane, tile, at, light, window);", own.name));
    let edges: String = edges.map(str::to_owned).chain(own).collect();
    let splats = strategies.calls().map(|name| match name {
        "spheres" => "spheres_splat(lane, tile, at, light, mask);",
        _ => "maps_splat(lane, at, light, mask);",
    });
    let own = variant.own.iter().map(|own| format!("{}_splat(lane, tile, at, light, mask);", own.name));
    let splats: String = splats.map(str::to_owned).chain(own).collect();
    let (stack, words) = (strategies.stack(), strategies.words());
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
        pieces.extend([lobes::PAPER, masks::PAPER, kernels::PAPER_PENUMBRA]);
    } else {
        pieces.push(kernels::PENUMBRA);
        pieces.extend(variant.fractions());
    }
    pieces.extend(variant.light());
    if strategies.spheres {
        pieces.extend([
            spheres::PACKED,
            spheres::CONE_TEST,
            spheres::BLOCKED_CONE,
            spheres::SPHERES,
            spheres::ELLIPSE,
            spheres::SPLAT,
            spheres::SPHERES_SPLAT,
        ]);
    }
    if strategies.any_hit.is_some() {
        pieces.extend([stack.as_str(), wgsl::BVH, wgsl::ANY_HIT]);
    }
    if variant.is_blocked() {
        pieces.push(masks::FACET);
    }
    let declarations: Vec<String> = variant.own.iter().map(OwnText::declarations).collect();
    for (own, declarations) in variant.own.iter().zip(&declarations) {
        pieces.extend([own.shared.as_str(), declarations, &own.splat]);
        pieces.extend(&own.splat_needs);
    }
    if strategies.maps.is_some() {
        pieces.extend([words.as_str(), maps::COMMON, maps::SPLAT]);
    }
    Text::new("penumbra", &pieces, &variant.bindings()).of(variant)
}

#[cfg(test)]
#[path = "module_tests.rs"]
mod tests;
