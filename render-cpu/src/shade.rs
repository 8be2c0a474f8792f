use core::convert::Infallible;
use core::time::Duration;
use glam::Vec3;
use lobe_core::{
    BrdfLobes, Coverage, FractionIntegrator, Integrator, LightId, LightLobes, LightVisibility, Observer, Receiver,
    Shaft, Stage, Tile, TileContributions, TileInteraction, TileLight, TileLobes, Visibility, cap_integrals,
};
use rayon::prelude::*;
use scene::{Counts, Frame, GROUP, Shade, ShadeStats, ShadingPoints, StageSeconds};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

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
/// Groups of 64 points in list order share the culling of blockers; rayon takes the groups. Results do not depend on
/// the number of threads. Nothing is allocated per point.
///
/// ```
/// use glam::Vec3;
/// use lobe_core::{Accuracy, Unshadowed};
/// use render_cpu::CpuShader;
/// use scene::{Frame, Shade, ShadingPoints};
/// let mut shader = CpuShader::new(Unshadowed);
/// let frame: Frame<'_> = Frame::new(&[], &[], Accuracy::new(0.003));
/// shader.shade(&ShadingPoints::default(), &frame, &mut []).unwrap();
/// ```
#[derive(Clone, Copy, Debug)]
pub struct CpuShader<V, I = FractionIntegrator> {
    visibility: V,
    integrator: I,
}

/// The layers that [`CpuShader::shade_layers`] writes beside the radiance: one entry a point, lights point by point.
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
        Self { visibility, integrator: FractionIntegrator }
    }
}

impl<V: Visibility, I: Integrator<V>> CpuShader<V, I> {
    /// Any integrator; the paper's wants a visibility whose lobes are the paper's.
    #[must_use]
    pub fn with_integrator(visibility: V, integrator: I) -> Self {
        Self { visibility, integrator }
    }

    /// The visibility strategy.
    pub const fn visibility(&self) -> &V {
        &self.visibility
    }

    /// Shades, and keeps what the picture is made of.
    ///
    /// # Panics
    /// When `out` is not as long as the points, or a material number is out of range.
    pub fn shade_layers<M: BrdfLobes + Sync, L: LightLobes + Sync>(
        &self,
        points: &ShadingPoints,
        frame: &Frame<'_, M, L>,
        out: &mut [Vec3],
    ) -> (ShadeStats, Layers) {
        let (stats, layers) = self.run(points, frame, out, true);
        let mut all = Layers::default();
        for layer in layers.into_iter().flatten() {
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
        layers: bool,
    ) -> (ShadeStats, Vec<Option<Layers>>) {
        assert_eq!(points.receivers.len(), out.len(), "one output a point");
        let start = Instant::now();
        // In a box: it is large, and changes hands often.
        let memory = || {
            Box::new(Memory {
                tile: Tile::default(),
                lobes: TileLobes::default(),
                cones: TileLight::default(),
                integrals: Vec::new(),
                lit: TileContributions::default(),
                scratch: self.visibility.scratch(),
                integration: I::Scratch::default(),
            })
        };
        let pool = Mutex::new(Vec::new());
        let groups: Vec<(GroupStats, Option<Layers>)> = out
            .par_chunks_mut(GROUP)
            .enumerate()
            .with_max_len(RUN)
            .map_init(
                || Lent::new(&pool),
                |lent, (group, out)| {
                    let memory = lent.memory.get_or_insert_with(memory);
                    let first = group * GROUP;
                    let receivers = &points.receivers[first..first + out.len()];
                    let materials = &points.materials[first..first + out.len()];
                    let mut layers = layers.then(Layers::default);
                    let mut stats = GroupStats::new(is_timed(group));
                    self.group(receivers, materials, frame, memory, &mut stats, &mut layers, out);
                    (stats, layers)
                },
            )
            .collect();
        let seconds = start.elapsed().as_secs_f64();
        let mut counts = Counts::default();
        let mut stages = [Duration::ZERO; 5];
        let mut layers = Vec::with_capacity(groups.len());
        for (stats, layer) in groups {
            stats.add_to(&mut counts);
            stages.iter_mut().zip(stats.stages).for_each(|(a, b)| *a += b);
            layers.push(layer);
        }
        // Parts of the timed groups, in seconds of the whole call.
        let timed: f64 = stages.iter().map(Duration::as_secs_f64).sum();
        let share = |k: usize| if timed > 0.0 { stages[k].as_secs_f64() / timed * seconds } else { 0.0 };
        let stages = StageSeconds {
            reflectance: share(0),
            lighting: share(1),
            mask: share(2),
            visibility_lobes: share(3),
            integration: share(4),
        };
        (ShadeStats { seconds, stages, counts }, layers)
    }

    #[expect(clippy::too_many_arguments, reason = "the group's slices and its memory")]
    fn group<M: BrdfLobes, L: LightLobes>(
        &self,
        receivers: &[Receiver],
        materials: &[u32],
        frame: &Frame<'_, M, L>,
        memory: &mut Memory<V, I>,
        stats: &mut GroupStats,
        layers: &mut Option<Layers>,
        out: &mut [Vec3],
    ) {
        out.fill(Vec3::ZERO);
        let count = receivers.len();
        if let Some(layers) = layers.as_mut() {
            layers.unshadowed.resize(count, Vec3::ZERO);
            layers.lights.resize(count * frame.lights.len(), Vec3::ZERO);
            layers.lobes.resize(count, 0);
            layers.integrals.resize(count, 0);
        }
        stats.restart();
        let Memory { tile, lobes, cones, integrals, lit, scratch, integration } = memory;
        tile.set(receivers);
        let (sphere, half_extent) = tile.bounds();
        // A facet under a smooth normal may hide the light that nothing else does.
        let is_bent = receivers.iter().any(|at| at.face != at.normal);
        I::reflectance(frame.materials, materials, receivers, tile, lobes);
        stats.lap(0);
        for (l, light) in frame.lights.iter().enumerate() {
            light.tile_light(receivers, tile, cones);
            // A light that shows an image is integrated where it is seen.
            if I::TAKES_INTEGRALS && light.image().is_none() {
                cap_integrals(cones, lobes, integrals);
            }
            stats.lap(1);
            let (id, accuracy) = (LightId(l as u32), frame.accuracy);
            let shaft = Shaft::new(sphere, light.bounds_from(&sphere), id).in_box(half_extent);
            // Receivers that all face away from the light need no query.
            let any =
                !I::TAKES_INTEGRALS || light.image().is_some() || integrals.iter().any(|integral| *integral > 0.0);
            let mut visibility = match any {
                true => LightVisibility::enter(&self.visibility, &shaft, accuracy, scratch),
                false => LightVisibility::alone(&self.visibility, id, accuracy, scratch),
            }
            .with_image(light.image());
            if is_bent {
                visibility.query_each_receiver();
            }
            stats.lap(2);
            let threshold = frame.threshold;
            let tile = TileInteraction { at: receivers, lobes, light: cones, integrals, threshold };
            self.integrator.tile(&tile, &mut visibility, integration, stats, lit);
            for (i, out) in out.iter_mut().enumerate() {
                *out += lit.radiance(i);
            }
            if let Some(layers) = layers.as_mut() {
                for i in 0..count {
                    let (lit, [lobes, integrals]) = lit.get(i);
                    layers.unshadowed[i] += lit.unshadowed;
                    layers.lights[i * frame.lights.len() + l] = lit.radiance;
                    layers.lobes[i] += lobes;
                    layers.integrals[i] += integrals;
                }
            }
            stats.lap(4);
        }
    }
}

impl<V, I, M, L> Shade<M, L> for CpuShader<V, I>
where
    V: Visibility,
    I: Integrator<V>,
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
        Ok(self.run(points, frame, out, false).0)
    }
}

/// One thread's memory.
struct Memory<V: Visibility, I: Integrator<V>> {
    /// A group and its reflectance lobes.
    tile: Tile,
    lobes: TileLobes,
    /// A light as the group sees it, the lobes' integrals over it, and what they come to.
    cones: TileLight,
    integrals: Vec<f32>,
    lit: TileContributions,
    scratch: V::Scratch,
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
    clock: Option<Instant>,
    stages: [Duration; 5],
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
            clock: timed.then(Instant::now),
            stages: [Duration::ZERO; 5],
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
            *clock = Instant::now();
        }
    }

    /// The time since the last lap belongs to `stage`.
    fn lap(&mut self, stage: usize) {
        if let Some(clock) = self.clock.as_mut() {
            let now = Instant::now();
            self.stages[stage] += now - *clock;
            *clock = now;
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
