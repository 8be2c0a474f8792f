use crate::SkyLighting;
use crate::faint::{Faint, MANY};
use core::convert::Infallible;
use core::ops::Range;
use glam::Vec3;
use lobe_core::{Receiver, Tile, TileLight, TileLobes, cap_integrals};
use rayon::prelude::*;
use scene::{Cancel, Counts, Frame, GROUP, Shade, ShadeStats, ShadingPoints, StageSeconds, Stopwatch};
use shading::{
    BrdfLobes, Coverage, FractionIntegrator, Integrator, LightId, LightLobes, LightVisibility, Observer, Shaft, Stage,
    TileContributions, TileInteraction, Visibility,
};
use std::sync::{Mutex, PoisonError};

/// Groups that a thread takes at once, at most: what is dear is often side by side.
const RUN: usize = 16;
/// Whether a group is timed stage by stage: one in 32 is, clocks would cost more than a lit point does. By a hash of its number: every
/// 32nd may be in the same column of a picture all the way down.
const fn is_timed(group: usize) -> bool {
    let mixed = (group as u32).wrapping_mul(0x9e37_79b9);
    (mixed ^ mixed >> 15).wrapping_mul(0x85eb_ca6b) >> 27 == 0
}

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

/// The layers that [`CpuShader::shade_with`] makes on request, and the request that stops it. Nothing by default.
#[derive(Clone, Copy, Debug, Default)]
pub struct ShadeRequest<'a> {
    /// [`Layers::unshadowed`].
    pub unshadowed: bool,
    /// [`Layers::lights`].
    pub lights: bool,
    /// [`Layers::lobes`] and [`Layers::integrals`].
    pub counts: bool,
    /// Looked at for each group of 64 points and each light.
    pub cancel: Option<&'a Cancel>,
}

/// The layers that [`CpuShader::shade_with`] writes beside the radiance: one entry a point, lights point by point; empty where there was
/// no request.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layers {
    /// Radiance without blockers.
    pub unshadowed: Vec<Vec3>,
    /// Radiance of each light: `lights[point * light_count + light]`.
    pub lights: Vec<Vec3>,
    /// Visibility lobes made.
    pub lobes: Vec<u32>,
    /// Lobe integrals evaluated.
    pub integrals: Vec<u32>,
}

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
        let memory = || {
            Box::new(Memory {
                tile: Tile::default(),
                lobes: TileLobes::default(),
                cones: TileLight::default(),
                integrals: Vec::new(),
                lit: TileContributions::default(),
                faint: Faint::default(),
                scratch: self.visibility.scratch(),
                sky: self.sky.scratch(),
                integration: I::Scratch::default(),
            })
        };
        let pool = Mutex::new(Vec::new());
        let parts = points.groups();
        let mut rest = out;
        let cut = |part: Range<usize>| {
            let (own, after) = core::mem::take(&mut rest).split_at_mut(part.len());
            rest = after;
            (part, own)
        };
        let parts: Vec<(Range<usize>, &mut [Vec3])> = parts.into_iter().map(cut).collect();
        let groups: Vec<(GroupStats, Layers)> = parts
            .into_par_iter()
            .enumerate()
            .with_max_len(RUN)
            .map_init(
                || Lent::new(&pool),
                |lent, (group, (part, out))| {
                    let memory = lent.memory.get_or_insert_with(memory);
                    let is_square = part.len() == GROUP && points.squares.binary_search(&part.start).is_ok();
                    let (receivers, materials) = (&points.receivers[part.clone()], &points.materials[part]);
                    let mut group = Group {
                        request,
                        is_square,
                        layers: Layers::default(),
                        stats: GroupStats::new(is_timed(group)),
                    };
                    self.group((receivers, materials), frame, memory, &mut group, out);
                    (group.stats, group.layers)
                },
            )
            .collect();
        let seconds = watch.seconds();
        let mut counts = Counts::default();
        let mut stages = [0.0_f64; 5];
        let mut layers = Vec::with_capacity(groups.len());
        for (stats, layer) in groups {
            stats.add_to(&mut counts);
            stages.iter_mut().zip(stats.stages).for_each(|(a, b)| *a += b);
            layers.push(layer);
        }
        // Parts of the timed groups, in seconds of the whole call.
        let timed: f64 = stages.iter().sum();
        let share = |k: usize| if timed > 0.0 { stages[k] / timed * seconds } else { 0.0 };
        let stages = StageSeconds {
            reflectance: share(0),
            lighting: share(1),
            mask: share(2),
            visibility_lobes: share(3),
            integration: share(4),
        };
        (ShadeStats { seconds, stages, counts }, layers)
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

/// The part of a light's contributions to a group that is summed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sum {
    All,
    /// Those of lobes that a sky has left.
    Rest,
    /// Those to some receivers, as bits.
    Only(u64),
}

/// The results of a group of points, but for their radiance.
struct Group<'a> {
    request: &'a ShadeRequest<'a>,
    /// Whether it is 8 rows of 8 neighbouring pixels.
    is_square: bool,
    layers: Layers,
    stats: GroupStats,
}

impl Group<'_> {
    fn is_cancelled(&self) -> bool {
        self.request.cancel.is_some_and(Cancel::is_cancelled)
    }

    /// Adds the contributions of a light.
    fn add(&mut self, lit: &TileContributions, light: usize, lights: usize, out: &mut [Vec3]) {
        for (i, out) in out.iter_mut().enumerate() {
            *out += lit.radiance(i);
        }
        self.layers.add(lit, light, lights);
        self.stats.lap(4);
    }

    /// Counts a light's integrals in the layer, or takes back those that were counted twice.
    fn count_integrals(&mut self, each: &[u32], is_new: bool) {
        let change = |count: &mut u32, n: u32| *count = if is_new { *count + n } else { *count - n };
        self.layers.integrals.iter_mut().zip(each).for_each(|(count, n)| change(count, *n));
    }

    /// Adds the faint lights of each receiver.
    fn add_faint(&mut self, faint: &Faint, lights: usize, out: &mut [Vec3]) {
        for (i, out) in out.iter_mut().enumerate() {
            let fraction = faint.fraction(i, *out);
            for light in (0..lights).filter(|light| faint.of(*light) & 1 << i != 0) {
                let unshadowed = faint.unshadowed(light, i);
                *out += unshadowed * fraction;
                if let Some(sum) = self.layers.unshadowed.get_mut(i) {
                    *sum += unshadowed;
                }
                if let Some(of_light) = self.layers.lights.get_mut(i * lights + light) {
                    *of_light += unshadowed * fraction;
                }
            }
        }
        self.stats.lap(4);
    }

    fn make_room(&mut self, points: usize, lights: usize) {
        let ShadeRequest { unshadowed, lights: by_light, counts, .. } = *self.request;
        let layers = &mut self.layers;
        layers.unshadowed.resize(if unshadowed { points } else { 0 }, Vec3::ZERO);
        layers.lights.resize(if by_light { points * lights } else { 0 }, Vec3::ZERO);
        layers.lobes.resize(if counts { points } else { 0 }, 0);
        layers.integrals.resize(if counts { points } else { 0 }, 0);
    }
}

impl Layers {
    /// Adds the contributions of a light, to those layers that there are.
    fn add(&mut self, lit: &TileContributions, light: usize, lights: usize) {
        for (i, sum) in self.unshadowed.iter_mut().enumerate() {
            *sum += lit.get(i).0.unshadowed;
        }
        for (i, of_lights) in self.lights.chunks_exact_mut(lights).enumerate() {
            of_lights[light] += lit.radiance(i);
        }
        for (i, (lobes, integrals)) in self.lobes.iter_mut().zip(&mut self.integrals).enumerate() {
            let counts = lit.get(i).1;
            (*lobes, *integrals) = (*lobes + counts[0], *integrals + counts[1]);
        }
    }
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

/// Memory that goes back to others when a run of groups is done.
struct Lent<'p, M> {
    pool: &'p Mutex<Vec<M>>,
    memory: Option<M>,
}

impl<'p, M> Lent<'p, M> {
    /// None, if none is free.
    fn new(pool: &'p Mutex<Vec<M>>) -> Self {
        Self { pool, memory: pool.lock().unwrap_or_else(PoisonError::into_inner).pop() }
    }
}

impl<M> Drop for Lent<'_, M> {
    fn drop(&mut self) {
        self.pool.lock().unwrap_or_else(PoisonError::into_inner).extend(self.memory.take());
    }
}

/// One group's counters and clocks; stages in the order of Table 1.
struct GroupStats {
    clock: Option<Stopwatch>,
    stages: [f64; 5],
    lobes: usize,
    integrals: usize,
    pruned: u64,
    lit: u64,
    dark: u64,
    partial: u64,
}

impl GroupStats {
    fn new(timed: bool) -> Self {
        Self {
            clock: timed.then(Stopwatch::start),
            stages: [0.0; 5],
            lobes: 0,
            integrals: 0,
            pruned: 0,
            lit: 0,
            dark: 0,
            partial: 0,
        }
    }

    fn restart(&mut self) {
        if let Some(clock) = self.clock.as_mut() {
            clock.lap();
        }
    }

    /// The time since the last lap belongs to `stage`.
    fn lap(&mut self, stage: usize) {
        if let Some(clock) = self.clock.as_mut() {
            self.stages[stage] += clock.lap();
        }
    }

    fn add_to(&self, counts: &mut Counts) {
        counts.lobes += self.lobes as u64;
        counts.integrals += self.integrals as u64;
        counts.pruned += self.pruned;
        counts.lit_points += self.lit;
        counts.dark_points += self.dark;
        counts.penumbra_points += self.partial;
    }
}

impl Observer for GroupStats {
    fn end(&mut self, stage: Stage) {
        self.lap(match stage {
            Stage::Lighting => 1,
            Stage::Mask => 2,
            Stage::VisibilityLobes => 3,
            Stage::Integration => 4,
        });
    }

    fn count(&mut self, lobes: usize, integrals: usize) {
        self.lobes += lobes;
        self.integrals += integrals;
    }

    fn prune(&mut self) {
        self.pruned += 1;
    }

    fn coverage(&mut self, coverage: Coverage) {
        match coverage {
            Coverage::Lit => self.lit += 1,
            Coverage::Dark => self.dark += 1,
            Coverage::Partial => self.partial += 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::is_timed;

    #[test]
    fn timed_groups_are_of_all_columns() {
        for columns in 1..=96 {
            let timed: Vec<usize> =
                (0..96 * columns).filter(|group| is_timed(*group)).map(|group| group % columns).collect();
            let all = 3 * columns;
            // Four standard deviations of a count of so many.
            let slack = 4.0 * (all as f64).sqrt();
            assert!(timed.len().abs_diff(all) as f64 <= slack, "{columns} columns: {} of {all}", timed.len());
            // Each column is timed about three times.
            let missed = (0..columns).filter(|column| !timed.contains(column)).count();
            assert!(missed <= columns / 4, "{columns} columns: {missed} missed");
        }
    }
}
