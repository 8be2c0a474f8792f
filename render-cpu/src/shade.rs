use crate::SkyLighting;
use crate::faint::{Faint, MANY};
use crate::group::{Group, GroupStats};
use crate::layers::{Layers, ShadeRequest};
use crate::lent::Lent;
use core::convert::Infallible;
use core::ops::Range;
use glam::Vec3;
use lobe_core::{Receiver, Tile, TileLight, TileLobes, cap_integrals};
use rayon::prelude::*;
use scene::{Frame, GROUP, Shade, ShadeStats, ShadingPoints, Stopwatch};
use shading::{
    BrdfLobes, FractionIntegrator, Integrator, LightId, LightLobes, LightVisibility, Shaft, TileContributions,
    TileInteraction, Visibility,
};
use std::sync::Mutex;

/// Groups that a thread takes at once, at most: what is dear is often side by side.
const RUN: usize = 16;
/// Shades points with lobe sums on the CPU, with any visibility strategy.
///
/// [Groups](ShadingPoints::groups) of up to 64 points in list order share the culling of blockers; rayon takes the groups. Results do not depend on
/// the number of threads. Nothing is allocated per point.
///
/// Under eight lights and more a point's dimmest lights are added without a query of their shadows, all with the visible fraction of its other lights. Their
/// unshadowed radiance, largest channels, is at most half the tolerance of the point's own radiance: `Σ u ≤ ½ tolerance · L`.
///
/// ```
/// use glam::Vec3;
/// use shading::{Accuracy, Unshadowed};
/// use render_cpu::CpuShader;
/// use scene::{Frame, Shade, ShadingPoints};
/// let mut shader = CpuShader::new(Unshadowed);
/// let frame: Frame<'_> = Frame::new(&[], &[], Accuracy::new(0.003));
/// shader.shade(&ShadingPoints::default(), &frame, &mut []).unwrap();
/// ```
#[derive(Clone, Copy, Debug)]
pub struct CpuShader<V, I = FractionIntegrator, K = ()> {
    visibility: V,
    integrator: I,
    sky: K,
    is_interpolated: bool,
}

/// Lobes of a flux of 1 whose integral over a patch of a sky is below this are left out there, where most of the sky was summed at once.
const FAINT: f32 = 1e-6;

impl<V: Visibility> CpuShader<V> {
    /// The default integrator with this visibility.
    #[must_use]
    pub fn new(visibility: V) -> Self {
        Self { visibility, integrator: FractionIntegrator, sky: (), is_interpolated: false }
    }
}

impl<V: Visibility, I: Integrator<V>> CpuShader<V, I> {
    /// Any integrator; the paper's wants a visibility whose lobes are the paper's.
    #[must_use]
    pub fn with_integrator(visibility: V, integrator: I) -> Self {
        Self { visibility, integrator, sky: (), is_interpolated: false }
    }
}

impl<V, I> CpuShader<V, I> {
    /// The same with some of the lights summed at once. In [`Layers`] their sum is that of the first of them.
    #[must_use]
    pub fn with_sky<K: SkyLighting>(self, sky: K) -> CpuShader<V, I, K> {
        CpuShader {
            visibility: self.visibility,
            integrator: self.integrator,
            sky,
            is_interpolated: self.is_interpolated,
        }
    }

    /// Interpolates visible fractions under eight lights and more, or does not, as after [`new`](Self::new).
    ///
    /// In [square tiles](ShadingPoints::squares) on one face, where no [penumbra](Visibility::narrowest_penumbra) of a light is narrower than the diagonal of
    /// a block: from the block's corners, where these differ by `12 e` at most and the middle by `e` from what they give there. `e = tolerance/(s √n)`, `s` the light's
    /// largest part of a point's unshadowed radiance, `n` the number of lights. Without edges between the block and the light one query is enough,
    /// and exact. All other points have queries of their own. Fractions then depend on the tile that a point is in.
    #[must_use]
    pub fn interpolating(self, is_interpolated: bool) -> Self {
        Self { is_interpolated, ..self }
    }
}

impl<V: Visibility, I: Integrator<V>, K: SkyLighting> CpuShader<V, I, K> {
    /// The visibility strategy.
    pub const fn visibility(&self) -> &V {
        &self.visibility
    }

    /// Shades, and keeps all that the picture is made of.
    ///
    /// # Panics
    /// When `out` is not as long as the points, or a material number is out of range.
    pub fn shade_layers<M: BrdfLobes + Sync, L: LightLobes + Sync>(
        &self,
        points: &ShadingPoints,
        frame: &Frame<'_, M, L>,
        out: &mut [Vec3],
    ) -> (ShadeStats, Layers) {
        let all = ShadeRequest { unshadowed: true, lights: true, counts: true, cancel: None };
        self.shade_with(points, frame, out, &all)
    }

    /// Shades, and keeps the requested layers. Once the request to stop is made a thread does no more than 64 points under one
    /// light; `out` and the layers are unfinished then.
    ///
    /// # Panics
    /// When `out` is not as long as the points, or a material number is out of range.
    pub fn shade_with<M: BrdfLobes + Sync, L: LightLobes + Sync>(
        &self,
        points: &ShadingPoints,
        frame: &Frame<'_, M, L>,
        out: &mut [Vec3],
        request: &ShadeRequest<'_>,
    ) -> (ShadeStats, Layers) {
        let (stats, layers) = self.run(points, frame, out, request);
        let mut all = Layers::default();
        let count = |wanted: bool, each: usize| if wanted { points.receivers.len() * each } else { 0 };
        all.unshadowed.reserve_exact(count(request.unshadowed, 1));
        all.lights.reserve_exact(count(request.lights, frame.lights.len()));
        all.lobes.reserve_exact(count(request.counts, 1));
        all.integrals.reserve_exact(count(request.counts, 1));
        for layer in layers {
            all.unshadowed.extend(layer.unshadowed);
            all.lights.extend(layer.lights);
            all.lobes.extend(layer.lobes);
            all.integrals.extend(layer.integrals);
        }
        (stats, all)
    }

    fn run<M: BrdfLobes + Sync, L: LightLobes + Sync>(
        &self,
        points: &ShadingPoints,
        frame: &Frame<'_, M, L>,
        out: &mut [Vec3],
        request: &ShadeRequest<'_>,
    ) -> (ShadeStats, Vec<Layers>) {
        assert_eq!(points.receivers.len(), out.len(), "one output a point");
        let watch = Stopwatch::start();
        // In a box: it is large, and changes hands often.
        let memory = || Box::new(Memory::new(self));
        let pool = Mutex::new(Vec::new());
        let begin = || -> ShadeGroup<'_> {
            let mut lent = Lent::new(&pool);
            Box::new(move |group, part, out| {
                let memory = lent.memory.get_or_insert_with(memory);
                let (receivers, materials) = (&points.receivers[part.clone()], &points.materials[part]);
                self.group((receivers, materials), frame, memory, group, out);
            })
        };
        let (stats, layers) = in_parallel(points, request, out, &begin);
        (GroupStats::sum(&stats, watch.seconds()), layers)
    }

    fn group<M: BrdfLobes, L: LightLobes>(
        &self,
        (receivers, materials): (&[Receiver], &[u32]),
        frame: &Frame<'_, M, L>,
        memory: &mut Memory<V, I, K>,
        group: &mut Group<'_>,
        out: &mut [Vec3],
    ) {
        out.fill(Vec3::ZERO);
        let count = frame.lights.len();
        group.make_room(receivers.len(), count);
        if group.is_cancelled() {
            return;
        }
        group.stats.restart();
        memory.tile.set(receivers);
        I::reflectance(frame.materials, materials, receivers, &memory.tile, &mut memory.lobes);
        group.stats.lap(0);
        let single = (0..count).filter(|light| !self.sky.replaces(*light));
        if I::TAKES_INTEGRALS && single.clone().count() >= MANY {
            self.many_lights(receivers, frame, memory, group, out);
        } else {
            for light in single {
                if group.is_cancelled() {
                    return;
                }
                self.light(receivers, frame, (light, Sum::All), memory, group);
                group.add(&memory.lit, light, count, out);
            }
        }
        let Some(place) = self.sky.place() else { return };
        let Memory { lobes, lit, sky, .. } = &mut *memory;
        let is_left = self.sky.tile(receivers, lobes, frame.threshold, sky, &mut group.stats, lit);
        group.add(lit, place, count, out);
        // Narrower lobes see patches, one by one.
        for light in (0..count).filter(|light| is_left && self.sky.replaces(*light)) {
            if group.is_cancelled() {
                return;
            }
            if self.light(receivers, frame, (light, Sum::Rest), memory, group) {
                group.add(&memory.lit, light, count, out);
            }
        }
    }

    /// The contributions of many lights to a group: those that are [faint](Faint) for a receiver are added without a query.
    fn many_lights<M: BrdfLobes, L: LightLobes>(
        &self,
        receivers: &[Receiver],
        frame: &Frame<'_, M, L>,
        memory: &mut Memory<V, I, K>,
        group: &mut Group<'_>,
        out: &mut [Vec3],
    ) {
        let (count, tolerance) = (frame.lights.len(), frame.accuracy.tolerance);
        let is_single = |light: &usize| !self.sky.replaces(*light);
        // A light that shows an image is integrated where it is seen; one without shadows needs no query.
        let is_known = |light: &usize| frame.lights[*light].image().is_none() && frame.lights[*light].has_shadows();
        memory.faint.begin(receivers.len(), count);
        for light in (0..count).filter(is_single).filter(is_known) {
            let Memory { tile, lobes, cones, integrals, lit, faint, .. } = &mut *memory;
            frame.lights[light].tile_light(receivers, tile, cones);
            cap_integrals(cones, lobes, integrals);
            let threshold = frame.threshold;
            TileInteraction { at: receivers, lobes, light: cones, integrals, threshold, slack: 0.0 }
                .unshadowed(&mut group.stats, lit);
            faint.add(light, lit);
            group.count_integrals(faint.integrals(), true);
        }
        memory.faint.find(tolerance);
        group.stats.lap(1);
        for light in (0..count).filter(is_single) {
            if group.is_cancelled() {
                return;
            }
            if !is_known(&light) {
                self.light(receivers, frame, (light, Sum::All), memory, group);
                group.add(&memory.lit, light, count, out);
                continue;
            }
            let strong = memory.faint.strong(light);
            self.some_receivers(receivers, frame, (light, strong), memory, group, out);
        }
        memory.faint.find_late(out, tolerance);
        for light in 0..count {
            if group.is_cancelled() {
                return;
            }
            let late = memory.faint.late(light);
            self.some_receivers(receivers, frame, (light, late), memory, group, out);
        }
        group.add_faint(&memory.faint, count, out);
    }

    /// Adds the contributions of one of many lights to some receivers, as bits. Its integrals and dropped lobes were counted before.
    fn some_receivers<M: BrdfLobes, L: LightLobes>(
        &self,
        receivers: &[Receiver],
        frame: &Frame<'_, M, L>,
        (light, only): (usize, u64),
        memory: &mut Memory<V, I, K>,
        group: &mut Group<'_>,
        out: &mut [Vec3],
    ) {
        if only == 0 {
            return;
        }
        let pruned = group.stats.pruned;
        self.light(receivers, frame, (light, Sum::Only(only)), memory, group);
        group.add(&memory.lit, light, frame.lights.len(), out);
        group.stats.pruned = pruned;
        group.stats.integrals -= memory.faint.integrals().iter().sum::<u32>() as usize;
        group.count_integrals(memory.faint.integrals(), false);
    }

    /// The contributions of one light to a group, in `memory.lit`: none, and `false`, where lobes that a sky has left see nothing of it.
    fn light<M: BrdfLobes, L: LightLobes>(
        &self,
        receivers: &[Receiver],
        frame: &Frame<'_, M, L>,
        (light, sum): (usize, Sum),
        memory: &mut Memory<V, I, K>,
        group: &mut Group<'_>,
    ) -> bool {
        let is_rest = sum == Sum::Rest;
        let (id, light, stats) = (LightId(light as u32), &frame.lights[light], &mut group.stats);
        let slack = memory.faint.slack(id.0 as usize, frame.accuracy.tolerance);
        let Memory { tile, lobes, cones, integrals, lit, scratch, integration, .. } = memory;
        let (sphere, half_extent) = tile.bounds();
        light.tile_light(receivers, tile, cones);
        // A light that shows an image is integrated where it is seen.
        if I::TAKES_INTEGRALS && (is_rest || light.image().is_none()) {
            cap_integrals(cones, lobes, integrals);
        }
        if let Sum::Only(only) = sum {
            let others = (0..receivers.len()).filter(|i| only & 1 << i == 0);
            others.flat_map(|i| lobes.of(i)).for_each(|(number, _)| integrals[number] = 0.0);
        }
        stats.lap(1);
        let is_seen = |i: usize| lobes.of(i).any(|(number, _)| integrals[number] > FAINT);
        if is_rest && I::TAKES_INTEGRALS && !(0..receivers.len()).any(is_seen) {
            return false;
        }
        let accuracy = frame.accuracy;
        let shaft = Shaft::new(sphere, light.bounds_from(&sphere), id);
        let shaft = shaft.in_box(half_extent).with_extent(light.extent());
        // Receivers that all face away from the light need no query.
        let any = !I::TAKES_INTEGRALS || light.image().is_some() || integrals.iter().any(|integral| *integral > 0.0);
        let mut visibility = match (light.has_shadows(), any) {
            (false, _) => LightVisibility::unhidden(&self.visibility, id, accuracy, scratch),
            (true, true) => LightVisibility::enter(&self.visibility, &shaft, accuracy, scratch),
            (true, false) => LightVisibility::alone(&self.visibility, id, accuracy, scratch),
        }
        .with_image(light.image());
        // A facet under a smooth normal may hide the light that nothing else does.
        if light.has_shadows() && receivers.iter().any(|at| at.face != at.normal) {
            visibility.query_each_receiver();
        }
        stats.lap(2);
        let slack = match sum {
            Sum::Only(u64::MAX) if self.is_interpolated && group.is_square => slack,
            _ => 0.0,
        };
        let tile = TileInteraction { at: receivers, lobes, light: cones, integrals, threshold: frame.threshold, slack };
        self.integrator.tile(&tile, &mut visibility, integration, stats, lit);
        true
    }
}

impl<V, I, K, M, L> Shade<M, L> for CpuShader<V, I, K>
where
    V: Visibility,
    I: Integrator<V>,
    K: SkyLighting,
    M: BrdfLobes + Sync,
    L: LightLobes + Sync,
{
    type Error = Infallible;

    fn shade(
        &mut self,
        points: &ShadingPoints,
        frame: &Frame<'_, M, L>,
        out: &mut [Vec3],
    ) -> Result<ShadeStats, Infallible> {
        Ok(self.run(points, frame, out, &ShadeRequest::default()).0)
    }
}

/// Shades one group of points, with a thread's memory.
type ShadeGroup<'s> = Box<dyn FnMut(&mut Group<'_>, Range<usize>, &mut [Vec3]) + 's>;

/// All groups, in parallel: `begin` is called for each run of groups. Behind `dyn`, so that it is not compiled for each kind of shader.
fn in_parallel<'s>(
    points: &ShadingPoints,
    request: &ShadeRequest<'_>,
    out: &mut [Vec3],
    begin: &(dyn Fn() -> ShadeGroup<'s> + Sync),
) -> (Vec<GroupStats>, Vec<Layers>) {
    let groups: Vec<(GroupStats, Layers)> = parted(points, out)
        .into_par_iter()
        .enumerate()
        .with_max_len(RUN)
        .map_init(begin, |shade, (number, (part, out))| {
            let is_square = part.len() == GROUP && points.squares.binary_search(&part.start).is_ok();
            let mut group = Group::new(number, is_square, request);
            shade(&mut group, part, out);
            (group.stats, group.layers)
        })
        .collect();
    groups.into_iter().unzip()
}

/// The groups of points, each with its part of `out`.
fn parted<'o>(points: &ShadingPoints, out: &'o mut [Vec3]) -> Vec<(Range<usize>, &'o mut [Vec3])> {
    let mut rest = out;
    let cut = |part: Range<usize>| {
        let (own, after) = core::mem::take(&mut rest).split_at_mut(part.len());
        rest = after;
        (part, own)
    };
    points.groups().into_iter().map(cut).collect()
}

/// The part of a light's contributions to a group that is summed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sum {
    All,
    /// Those of lobes that a sky has left.
    Rest,
    /// Those to some receivers, as bits.
    Only(u64),
}

/// One thread's memory.
struct Memory<V: Visibility, I: Integrator<V>, K: SkyLighting> {
    /// A group and its reflectance lobes.
    tile: Tile,
    lobes: TileLobes,
    /// A light as the group sees it, the lobes' integrals over it, and what they come to.
    cones: TileLight,
    integrals: Vec<f32>,
    lit: TileContributions,
    faint: Faint,
    scratch: V::Scratch,
    sky: K::Scratch,
    integration: I::Scratch,
}

impl<V: Visibility, I: Integrator<V>, K: SkyLighting> Memory<V, I, K> {
    fn new(shader: &CpuShader<V, I, K>) -> Self {
        Self {
            tile: Tile::default(),
            lobes: TileLobes::default(),
            cones: TileLight::default(),
            integrals: Vec::new(),
            lit: TileContributions::default(),
            faint: Faint::default(),
            scratch: shader.visibility.scratch(),
            sky: shader.sky.scratch(),
            integration: I::Scratch::default(),
        }
    }
}
