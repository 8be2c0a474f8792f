//! The texts of the kernels. Each is a module of its own, made of the pieces that a frame uses and no others.

use crate::binding::{
    Access::{self, Read, Uniform, Write},
    Binding, Slot,
};
use crate::wgsl;
use lobe_core::wgsl::{self as lobes, Piece, constant, join};
use shading::gpu::{GpuBlockers, GpuLight, GpuPages, GpuPass, GpuSkyPart, GpuText};
use visibility_mask::{Fineness, wgsl as masks};

/// The properties of a frame that its kernels depend on.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Variant {
    pub(crate) depth: u32,
    /// Resolution of the masks for broad lobes and for narrow ones.
    pub(crate) fineness: [Fineness; 2],
    pub(crate) materials: MaterialText,
    /// Name and text of the kind of light.
    pub(crate) light: GpuText,
    pub(crate) shown: Shown,
    /// The strategies that block something.
    pub(crate) own: Vec<OwnText>,
    /// Size of the stack for the rays that they trace.
    pub(crate) stack: Option<u32>,
    /// Whether the paper's method is used instead of moments.
    pub(crate) paper: bool,
    /// Whether the light is a patch of a sky, which shines on the lobes that the sky's sums leave.
    pub(crate) is_patch: bool,
    /// Whether masks may be drawn again around a small lit part of the light.
    pub(crate) looks_again: bool,
}

/// The texts of the materials.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct MaterialText {
    pub(crate) name: String,
    pub(crate) wgsl: String,
    pub(crate) needs: Vec<&'static Piece>,
    pub(crate) is_lambert: bool,
    pub(crate) has_microfacets: bool,
    pub(crate) has_grain: bool,
}

impl MaterialText {
    /// Lobes of microfacets in a direction.
    const fn microfacets(&self) -> &'static Piece {
        if self.has_grain { &lobes::MICROFACETS_GRAIN } else { &lobes::MICROFACETS }
    }
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
    pub(crate) constants: String,
    pub(crate) coverage: &'static Piece,
    pub(crate) splat: &'static Piece,
    pub(crate) has_edges: bool,
    pub(crate) sky: Option<GpuSkyPart>,
    pub(crate) buffers: Vec<OwnBuffer>,
}

impl OwnText {
    pub(crate) fn new(blockers: &dyn GpuBlockers, buffers: Vec<OwnBuffer>) -> Self {
        Self {
            name: blockers.name(),
            constants: blockers.constants(),
            coverage: blockers.coverage(),
            splat: blockers.splat(),
            has_edges: blockers.has_edges(),
            sky: blockers.sky(),
            buffers,
        }
    }

    /// Its constants, and the declarations of its buffers.
    fn declarations(&self) -> String {
        let buffers = self.buffers.iter().map(|buffer| buffer.declaration(Read));
        core::iter::once(self.constants.clone()).chain(buffers).collect()
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
        format!("{strategies}, {}, {}, depth {}{method}", self.light.0, self.materials.name, self.depth)
    }

    /// The integrals of lobes over a light.
    fn integral(&self) -> Vec<&'static Piece> {
        let MaterialText { is_lambert, has_microfacets, has_grain, .. } = self.materials;
        let (over_cones, over_outlines) = match (has_microfacets, has_grain) {
            (false, _) => (&lobes::CAP_NO_MICROFACETS, &lobes::OUTLINE_NO_MICROFACETS),
            (true, false) => (&lobes::CAP_MICROFACETS, &lobes::OUTLINE_MICROFACETS),
            (true, true) => (&lobes::CAP_BRUSHED, &lobes::OUTLINE_BRUSHED),
        };
        let over_cones = if is_lambert { &lobes::CAP_LAMBERT } else { over_cones };
        match self.shown {
            Shown::Cone => vec![over_cones, &OVER_CONES],
            Shown::Outline => vec![over_cones, over_outlines, &lobes::OUTLINE_PLAIN],
            Shown::Image => vec![over_outlines, &lobes::OUTLINE_IMAGE],
        }
    }

    /// How a point sees the light, and the light's integrals in the queue.
    fn light(&self) -> Vec<&'static Piece> {
        let light = self.light.1;
        match self.shown {
            Shown::Cone => vec![light, &lobes::NO_OUTLINE, &wgsl::INTEGRALS],
            Shown::Outline => vec![light, &lobes::OUTLINE, &wgsl::INTEGRALS],
            Shown::Image => vec![light, &lobes::IMAGE, &wgsl::INTEGRALS_BY_CHANNEL],
        }
    }

    /// How masks show the emitting region.
    const fn window(&self) -> &'static Piece {
        match self.shown {
            Shown::Cone => &masks::ROUND,
            Shown::Outline | Shown::Image => &masks::FLAT,
        }
    }

    /// The visible fraction of lobes, from masks.
    fn fractions(&self) -> Vec<&'static Piece> {
        let MaterialText { is_lambert, has_microfacets, .. } = self.materials;
        if is_lambert && self.shown != Shown::Image {
            return vec![&masks::LAMBERT];
        }
        let by_channel = match (self.shown, has_microfacets) {
            (Shown::Image, true) => &masks::IMAGE_MICROFACETS,
            (Shown::Image, false) => &masks::IMAGE_NO_MICROFACETS,
            _ => &masks::ALIKE,
        };
        match has_microfacets {
            true => vec![by_channel, self.materials.microfacets(), &masks::MICROFACETS],
            false => vec![by_channel],
        }
    }

    /// Whether anything blocks.
    pub(crate) fn is_blocked(&self) -> bool {
        !self.own.is_empty()
    }

    /// Ray queries of strategies against the scene, and the constant that they need.
    fn world(&self) -> (Option<&'static Piece>, String) {
        self.stack.map_or((None, String::new()), |size| (Some(&wgsl::ANY_HIT), constant("STACK", &size)))
    }

    /// The declarations of all strategies.
    fn declarations(&self) -> String {
        self.own.iter().map(OwnText::declarations).collect()
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
    /// Of pieces, of texts that are made for this kernel alone, and of these buffers, which it declares.
    pub(crate) fn new(entry: &'static str, pieces: &[&'static Piece], texts: &[&str], bindings: &[Binding]) -> Self {
        let buffers: String = bindings.iter().filter_map(|(slot, access)| slot.declaration(*access)).collect();
        let text = join(pieces) + &buffers + &texts.join("\n");
        Self { entry, name: entry.to_owned(), text, bindings: bindings.to_vec() }
    }

    fn of(self, variant: &Variant) -> Self {
        Self { name: format!("{} ({})", self.entry, variant.name()), ..self }
    }
}

/// The text of a strategy's own pass.
pub(crate) fn pass(pass: &GpuPass, declarations: &str, bindings: &[Binding]) -> Text {
    Text::new(pass.entry, &[&wgsl::FRAME, &lobes::GEOMETRY, pass.piece], &[declarations], bindings)
}

/// The kernel that computes the size of the penumbra kernel's dispatch.
pub(crate) fn args() -> Text {
    let bindings = [(Slot::Frame, Uniform), (Slot::Queue, Write), (Slot::Indirect, Write)];
    Text::new("args_of_queue", &[&wgsl::ARGS], &[], &bindings)
}

/// The bindings of the kernels that shade.
const SHADED: [Binding; 5] = [
    (Slot::Frame, Uniform),
    (Slot::Points, Read),
    (Slot::Materials, Read),
    (Slot::Radiance, Write),
    (Slot::Queue, Write),
];

static OVER_CONES: Piece = Piece::new(
    "fn light_integral(at: Receiver, lobe: Lobe, cone: Cone) -> f32 { return cap_integral(at, lobe, cone); }",
);

/// The kernel that classifies each point as lit, dark or in penumbra for a light.
pub(crate) fn classify(variant: &Variant) -> Text {
    let of = |own: &OwnText| format!("coverage = max(coverage, {}_coverage(tile, at, cone));", own.name);
    let all: String = variant.own.iter().map(of).collect();
    let hook = format!(
        "fn blockers_coverage(tile: u32, at: Receiver, cone: Cone) -> u32 {{ var coverage = LIT; {all} return coverage; }}"
    );
    let (world, stack) = variant.world();
    let mut pieces =
        if variant.paper { vec![&wgsl::PAPER_CLASSIFY] } else { [vec![&wgsl::CLASSIFY], variant.integral()].concat() };
    if !variant.paper {
        pieces.push(if variant.is_patch { &wgsl::LOBES_LEFT } else { &wgsl::ALL_LOBES });
    }
    pieces.extend(variant.light());
    pieces.extend(&variant.materials.needs);
    pieces.extend(world);
    if variant.is_blocked() {
        // Texts of strategies may call what shows windows of the light.
        pieces.push(variant.window());
    }
    pieces.extend(variant.own.iter().map(|own| own.coverage));
    let declarations = variant.declarations();
    let texts = [&variant.materials.wgsl, &hook, &declarations, &stack].map(String::as_str);
    Text::new("classify", &pieces, &texts, &variant.bindings()).of(variant)
}

/// The kernel that shades the points in a light's penumbra.
pub(crate) fn penumbra(variant: &Variant) -> Text {
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
    let hooks = format!(
        "fn blockers_edges(lane: u32, tile: u32, at: Receiver, light: Cone, window: Cone) -> vec4f {{ \
        var edges = vec4f(0.0); {edges} return edges; }}\n\
        fn blockers_splat(lane: u32, tile: u32, at: Receiver, light: Cone, mask: Mask) {{ {splats} }}"
    );
    let (world, stack) = variant.world();
    let mut pieces = if variant.paper {
        vec![&wgsl::PAPER_PENUMBRA, &masks::EDGES]
    } else {
        [vec![&wgsl::PENUMBRA], variant.fractions()].concat()
    };
    pieces.extend(variant.light());
    pieces.push(variant.window());
    pieces.extend(&variant.materials.needs);
    pieces.extend(world);
    pieces.extend(variant.own.iter().map(|own| own.splat));
    let declarations = format!(
        "const LOOKS_AGAIN = {};\nconst BLOCKERS_ARE_SEVERAL = {};\n{}",
        variant.looks_again,
        variant.own.len() > 1,
        variant.declarations()
    );
    let texts = [&variant.materials.wgsl, &header, &hooks, &declarations, &stack].map(String::as_str);
    Text::new("penumbra", &pieces, &texts, &variant.bindings()).of(variant)
}

/// The properties of a frame that the kernel depends on which sums its sky at once.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SkyVariant {
    /// The constants of the sky's samples.
    pub(crate) header: String,
    pub(crate) materials: MaterialText,
    /// The strategies that block something; each has a part for skies.
    pub(crate) own: Vec<OwnText>,
    /// Size of the stack for the rays that they trace.
    pub(crate) stack: Option<u32>,
}

/// The kernel that sums a sky at once.
pub(crate) fn sky(variant: &SkyVariant) -> Text {
    let SkyVariant { header, materials, own, stack } = variant;
    let parts: Vec<(&OwnText, &GpuSkyPart)> =
        own.iter().filter_map(|own| own.sky.as_ref().map(|sky| (own, sky))).collect();
    let each = |of: &dyn Fn(&str) -> String| parts.iter().map(|(own, _)| of(own.name)).collect::<String>();
    let draw = each(&|name| format!("{name}_sky(lane, at); "));
    let hide = each(&|name| format!("|| {name}_sky_hides(at, direction) "));
    let facet = each(&|name| format!("|| {name}_sky_has_facet(at) "));
    let hooks = format!(
        "fn blockers_sky(lane: u32, at: Receiver) {{ {draw} }}\n\
        fn blockers_sky_hide(at: Receiver, direction: vec3f) -> bool {{ return false {hide}; }}\n\
        fn blockers_sky_have_facet(at: Receiver) -> bool {{ return false {facet}; }}"
    );
    let mut pieces: Vec<&'static Piece> = vec![&wgsl::SKY];
    match materials.has_microfacets {
        true => pieces.extend([materials.microfacets(), &masks::SKY_MICROFACETS]),
        false => pieces.push(&masks::SKY_NO_MICROFACETS),
    }
    pieces.extend(&materials.needs);
    let mut bindings = SHADED.to_vec();
    bindings.push((Slot::Sky, Read));
    let (mut declarations, mut rays) = (String::new(), String::new());
    for (own, sky) in &parts {
        pieces.push(sky.piece);
        declarations += &own.constants;
        for buffer in own.buffers.iter().filter(|buffer| sky.reads.contains(&buffer.name)) {
            declarations += &buffer.declaration(Read);
            bindings.extend(buffer.slots().map(|slot| (slot, Read)));
        }
    }
    if let Some(size) = stack {
        pieces.push(&wgsl::ANY_HIT);
        rays = constant("STACK", size);
        bindings.extend([(Slot::Nodes, Read), (Slot::Primitives, Read)]);
    }
    let texts = [&materials.wgsl, header, &hooks, &declarations, &rays].map(String::as_str);
    let names = parts.iter().map(|(own, _)| own.name).collect::<Vec<_>>().join(" + ");
    let text = Text::new("sky", &pieces, &texts, &bindings);
    Text { name: format!("sky ({names}, {})", materials.name), ..text }
}

/// The kernel that computes the size of the dispatches of a sky's patches.
pub(crate) fn sky_args() -> Text {
    let bindings = [(Slot::Frame, Uniform), (Slot::Queue, Write), (Slot::Indirect, Write)];
    Text::new("args_of_sky", &[&wgsl::SKY_ARGS], &[], &bindings)
}

#[cfg(test)]
#[path = "module_tests.rs"]
mod tests;
