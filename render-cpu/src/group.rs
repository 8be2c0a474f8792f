//! The results of a group of points, its counters and clocks.

use crate::faint::Faint;
use crate::layers::{Layers, ShadeRequest};
use glam::Vec3;
use scene::{Cancel, Counts, ShadeStats, StageSeconds, Stopwatch};
use shading::{Coverage, Observer, Stage, TileContributions};

/// Whether a group is timed stage by stage: one in 32 is, clocks would cost more than a lit point does. By a hash of its number: every
/// 32nd may be in the same column of a picture all the way down.
const fn is_timed(group: usize) -> bool {
    let mixed = (group as u32).wrapping_mul(0x9e37_79b9);
    (mixed ^ mixed >> 15).wrapping_mul(0x85eb_ca6b) >> 27 == 0
}

/// The results of a group of points, but for their radiance.
pub(crate) struct Group<'a> {
    pub(crate) request: &'a ShadeRequest<'a>,
    /// Whether it is 8 rows of 8 neighbouring pixels.
    pub(crate) is_square: bool,
    pub(crate) layers: Layers,
    pub(crate) stats: GroupStats,
}

impl<'a> Group<'a> {
    pub(crate) fn new(number: usize, is_square: bool, request: &'a ShadeRequest<'a>) -> Self {
        Self { request, is_square, layers: Layers::default(), stats: GroupStats::new(is_timed(number)) }
    }
}

impl Group<'_> {
    pub(crate) fn is_cancelled(&self) -> bool {
        self.request.cancel.is_some_and(Cancel::is_cancelled)
    }

    /// Adds the contributions of a light.
    pub(crate) fn add(&mut self, lit: &TileContributions, light: usize, lights: usize, out: &mut [Vec3]) {
        for (i, out) in out.iter_mut().enumerate() {
            *out += lit.radiance(i);
        }
        self.layers.add(lit, light, lights);
        self.stats.lap(4);
    }

    /// Counts a light's integrals in the layer, or takes back those that were counted twice.
    pub(crate) fn count_integrals(&mut self, each: &[u32], is_new: bool) {
        let change = |count: &mut u32, n: u32| *count = if is_new { *count + n } else { *count - n };
        self.layers.integrals.iter_mut().zip(each).for_each(|(count, n)| change(count, *n));
    }

    /// Adds the faint lights of each receiver.
    pub(crate) fn add_faint(&mut self, faint: &Faint, lights: usize, out: &mut [Vec3]) {
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

    pub(crate) fn make_room(&mut self, points: usize, lights: usize) {
        let ShadeRequest { unshadowed, lights: by_light, counts, .. } = *self.request;
        let layers = &mut self.layers;
        layers.unshadowed.resize(if unshadowed { points } else { 0 }, Vec3::ZERO);
        layers.lights.resize(if by_light { points * lights } else { 0 }, Vec3::ZERO);
        layers.lobes.resize(if counts { points } else { 0 }, 0);
        layers.integrals.resize(if counts { points } else { 0 }, 0);
    }
}

/// One group's counters and clocks; stages in the order of Table 1.
#[derive(Default)]
pub(crate) struct GroupStats {
    clock: Option<Stopwatch>,
    stages: [f64; 5],
    pub(crate) lobes: usize,
    pub(crate) integrals: usize,
    pub(crate) pruned: u64,
    lit: u64,
    dark: u64,
    partial: u64,
}

impl GroupStats {
    fn new(timed: bool) -> Self {
        Self { clock: timed.then(Stopwatch::start), ..Self::default() }
    }

    /// The sum over all groups of a call that took a number of seconds.
    pub(crate) fn sum(groups: &[Self], seconds: f64) -> ShadeStats {
        let mut counts = Counts::default();
        let mut stages = [0.0_f64; 5];
        for group in groups {
            group.add_to(&mut counts);
            stages.iter_mut().zip(group.stages).for_each(|(a, b)| *a += b);
        }
        // Parts of the timed groups, in seconds of the whole call.
        let timed: f64 = stages.iter().sum();
        let [reflectance, lighting, mask, visibility_lobes, integration] =
            stages.map(|stage| if timed > 0.0 { stage / timed * seconds } else { 0.0 });
        let stages = StageSeconds { reflectance, lighting, mask, visibility_lobes, integration };
        ShadeStats { seconds, stages, counts }
    }

    pub(crate) fn restart(&mut self) {
        if let Some(clock) = self.clock.as_mut() {
            clock.lap();
        }
    }

    /// The time since the last lap belongs to `stage`.
    pub(crate) fn lap(&mut self, stage: usize) {
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
            // Four standard deviations of such a count.
            let slack = 4.0 * (all as f64).sqrt();
            assert!(timed.len().abs_diff(all) as f64 <= slack, "{columns} columns: {} of {all}", timed.len());
            // Each column is timed about three times.
            let missed = (0..columns).filter(|column| !timed.contains(column)).count();
            assert!(missed <= columns / 4, "{columns} columns: {missed} missed");
        }
    }
}
