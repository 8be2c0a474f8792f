//! The texts of the kernels: each is a module of its own, of the pieces that a frame uses and no other.

use crate::kernel::{
    Access::{Read, Uniform, Write},
    Binding, Slot,
};
use crate::{kernels, wgsl};
use brdf::Models;
use lobe_core::wgsl as lobes;
use visibility_mask::{Fineness, wgsl as masks};
use visibility_shadowmap::{Pages, wgsl as maps};
use visibility_spheres::wgsl as spheres;

/// Bytes of a tile's list.
pub(crate) const LIST_BYTES: u64 = 4 * visibility_spheres::LIST_WORDS as u64;

/// What the kernels of a frame depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Variant {
    pub(crate) depth: u32,
    /// What broad lobes and narrow ones see.
    pub(crate) fineness: [Fineness; 2],
    pub(crate) models: Models,
    pub(crate) strategies: Strategies,
    /// By the paper's method, and not by moments.
    pub(crate) paper: bool,
}

/// Which strategies have blockers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Strategies {
    pub(crate) spheres: bool,
    /// How the shadow maps are bound.
    pub(crate) maps: Option<Pages>,
    /// Size of the stack of shadow rays.
    pub(crate) rays: Option<u32>,
}

impl Strategies {
    pub(crate) const fn any(self) -> bool {
        self.spheres || self.maps.is_some() || self.rays.is_some()
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
        if self.rays.is_some() {
            bindings.extend([(Slot::Nodes, Read), (Slot::Primitives, Read)]);
        }
        bindings
    }

    /// The code that reads the shadow maps.
    fn words(self) -> String {
        self.maps.map_or_else(String::new, Pages::wgsl)
    }

    /// Calls of those that there are.
    fn calls(self) -> impl Iterator<Item = &'static str> {
        let all = [(self.spheres, "spheres"), (self.maps.is_some(), "maps"), (self.rays.is_some(), "rays")];
        all.into_iter().filter_map(|(has, name)| has.then_some(name))
    }
}

impl Variant {
    /// The buffers of the kernels that shade.
    fn bindings(&self) -> Vec<Binding> {
        let tables: &[Binding] = if self.paper { &[(Slot::Tables, Read)] } else { &[] };
        [SHADED.as_slice(), &self.strategies.bindings(), tables].concat()
    }

    /// The purpose of the kernel, in words.
    fn name(&self) -> String {
        let strategies: Vec<&str> = self.strategies.calls().collect();
        let strategies = if strategies.is_empty() { "no blockers".to_owned() } else { strategies.join(" + ") };
        let models: Vec<&str> = self.models.names().collect();
        let models = if models.is_empty() { "no materials".to_owned() } else { models.join(" + ") };
        let method = if self.paper { ", paper" } else { "" };
        format!("{strategies}, {models}, depth {}{method}", self.depth)
    }

    /// Whether all reflectance is Lambert's.
    fn is_lambert(&self) -> bool {
        self.models.names().all(|name| name == "lambert")
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
    pub(crate) fn new(entry: &'static str, pieces: &[&str], bindings: &[Binding]) -> Self {
        Self { entry, name: entry.to_owned(), text: pieces.join("\n"), bindings: bindings.to_vec() }
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

/// The size of the stack of shadow rays.
fn stack(strategies: Strategies) -> String {
    strategies.rays.map_or_else(String::new, |size| format!("const STACK = {size}u;"))
}

/// The bindings of the kernels that shade.
const SHADED: [Binding; 5] = [
    (Slot::Frame, Uniform),
    (Slot::Points, Read),
    (Slot::Materials, Read),
    (Slot::Radiance, Write),
    (Slot::Queue, Write),
];

/// What every point sees of a light.
pub(crate) fn classify(variant: &Variant) -> Text {
    let reflectance = brdf::wgsl::compose(variant.models);
    let (integral, kernel) = if variant.paper {
        (lobes::PAPER, kernels::PAPER_CLASSIFY)
    } else {
        (if variant.is_lambert() { lobes::CAP_LAMBERT } else { lobes::CAP }, kernels::CLASSIFY)
    };
    let strategies = variant.strategies;
    let all = strategies.calls().map(|name| match name {
        "spheres" => "coverage = max(coverage, spheres_coverage(tile, at, cone));",
        "rays" => "coverage = max(coverage, rays_coverage(at, cone));",
        _ => "coverage = max(coverage, maps_coverage(at, cone));",
    });
    let hook = format!(
        "fn blockers_coverage(tile: u32, at: Receiver, cone: Cone) -> u32 {{ var coverage = LIT; {} return coverage; }}",
        all.collect::<String>()
    );
    let (stack, words) = (stack(strategies), strategies.words());
    let mut pieces = vec![
        kernels::FRAME,
        kernels::QUEUE,
        kernels::POINTS,
        kernels::TILES,
        lobes::SPECIAL,
        lobes::GEOMETRY,
        lobes::LOBE,
        integral,
        &reflectance,
        &hook,
        kernel,
    ];
    if strategies.spheres {
        pieces.extend([spheres::PACKED, spheres::CONE_TEST, spheres::BLOCKED_CONE, spheres::SPHERES]);
    }
    if strategies.rays.is_some() {
        pieces.extend([stack.as_str(), wgsl::BVH, wgsl::RAYS]);
    }
    if strategies.calls().next().is_some() {
        pieces.push(masks::FACET);
    }
    if strategies.maps.is_some() {
        pieces.extend([masks::SQUARE, words.as_str(), maps::COMMON, maps::COVERAGE]);
    }
    Text::new("classify", &pieces, &variant.bindings()).of(variant)
}

/// What the points in a penumbra see.
pub(crate) fn penumbra(variant: &Variant) -> Text {
    let reflectance = brdf::wgsl::compose(variant.models);
    let [broad, narrow] = variant.fineness;
    let header = match (variant.paper, variant.is_lambert()) {
        (true, _) => masks::paper_header(variant.depth),
        (false, true) => masks::header(variant.depth, broad),
        (false, false) => masks::header_of_lobes(variant.depth, broad, narrow),
    };
    let strategies = variant.strategies;
    let edges = strategies.calls().map(|name| match name {
        "spheres" => "edges += spheres_edges(lane, tile, at, light, window);",
        "rays" => "edges += rays_edges(lane, at, light, window);",
        _ => "",
    });
    let edges: String = edges.collect();
    let splats = strategies.calls().map(|name| match name {
        "spheres" => "spheres_splat(lane, tile, at, light, mask);",
        "rays" => "rays_splat(lane, at, light, mask);",
        _ => "maps_splat(lane, at, light, mask);",
    });
    let splats: String = splats.collect();
    let (stack, words) = (stack(strategies), strategies.words());
    let hooks = format!(
        "fn blockers_edges(lane: u32, tile: u32, at: Receiver, light: Cone, window: Cone) -> vec2f {{ \
        var edges = vec2f(0.0); {edges} return edges; }}\n\
        fn blockers_splat(lane: u32, tile: u32, at: Receiver, light: Cone, mask: Mask) {{ {splats} }}"
    );
    let mut pieces = vec![
        kernels::FRAME,
        kernels::QUEUE,
        kernels::POINTS,
        lobes::SPECIAL,
        lobes::GEOMETRY,
        lobes::LOBE,
        &reflectance,
        &header,
        masks::SQUARE,
        masks::MASK,
        masks::EDGES,
        masks::TOTAL,
        &hooks,
    ];
    if variant.paper {
        pieces.extend([lobes::PAPER, masks::PAPER, kernels::PAPER_PENUMBRA]);
    } else {
        let shares = if variant.is_lambert() { masks::LAMBERT } else { masks::LOBES };
        pieces.extend([masks::SHARE, masks::VISIBILITY, shares, kernels::PENUMBRA]);
    }
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
    if strategies.rays.is_some() {
        pieces.extend([stack.as_str(), wgsl::BVH, wgsl::RAYS, masks::CONTOUR, wgsl::RAYS_SPLAT]);
    }
    if strategies.calls().next().is_some() {
        pieces.push(masks::FACET);
    }
    if strategies.maps.is_some() {
        pieces.extend([words.as_str(), maps::COMMON, maps::SPLAT]);
    }
    Text::new("penumbra", &pieces, &variant.bindings()).of(variant)
}

#[cfg(test)]
#[path = "module_tests.rs"]
mod tests;
