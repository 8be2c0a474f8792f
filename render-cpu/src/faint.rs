//! Lights that add so little to a point that its tolerance allows for their shadows.

use glam::Vec3;
use scene::GROUP;
use shading::TileContributions;

/// Fewer lights are all summed with their shadows.
pub(crate) const MANY: usize = 8;

/// The part of the tolerance that faint lights may take.
const PART: f32 = 0.5;

/// The part of its unshadowed radiance that a receiver is at first taken to have.
const HALF: f32 = 0.5;

/// Lights are sorted by their part of a receiver's unshadowed radiance, four steps an octave.
const STEPS: usize = 4 * 24;

const _: () = assert!(GROUP <= u64::BITS as usize, "a bit for each receiver");

/// The faint lights of each receiver of a group.
///
/// A receiver's *faint* lights are its dimmest ones, which come to at most half the tolerance of its own radiance together:
///
/// ```text
/// Σ faint u ≤ ½ tolerance · L        u: unshadowed radiance of a light, L: radiance with shadows that the others leave; largest channels
/// ```
///
/// They are added without a query, all with the visible fraction that the others have in the mean, so the error is at most `½ tolerance · L`. Since `L` is known only
/// at the end, it is first taken to be half the unshadowed radiance; where it is less, the largest of the faint lights are summed
/// as the others are. Each receiver decides for itself: results do not depend on its group.
#[derive(Clone, Debug, Default)]
pub(crate) struct Faint {
    /// Without blockers: [`GROUP`] receivers a light.
    unshadowed: Vec<Vec3>,
    /// For each light the receivers that it lights, those of them that it is faint for, and those that it turned out not to be, as bits.
    lit: Vec<u64>,
    faint: Vec<u64>,
    late: Vec<u64>,
    /// For each receiver the integrals that a light takes, and the first step that is faint.
    integrals: Vec<u32>,
    first: Vec<usize>,
    /// For each receiver its sum over all lights (largest channels), its parts of each size, and its sum over faint lights.
    all: Vec<f32>,
    parts: Vec<[f32; STEPS]>,
    sums: Vec<Vec3>,
    /// For each light its largest part of a receiver's radiance, and how many lights give any.
    largest: Vec<f32>,
    count: usize,
}

impl Faint {
    /// Begins a group.
    pub(crate) fn begin(&mut self, receivers: usize, lights: usize) {
        self.unshadowed.clear();
        self.unshadowed.resize(lights * GROUP, Vec3::ZERO);
        for bits in [&mut self.lit, &mut self.faint, &mut self.late] {
            bits.clear();
            bits.resize(lights, 0);
        }
        self.all.clear();
        self.all.resize(receivers, 0.0);
        self.parts.clear();
        self.parts.resize(receivers, [0.0; STEPS]);
        self.largest.clear();
        self.first.clear();
        self.integrals.clear();
        self.integrals.resize(receivers, 0);
        self.count = 0;
        self.sums.clear();
        self.sums.resize(receivers, Vec3::ZERO);
    }

    /// Adds what a light gives without blockers.
    pub(crate) fn add(&mut self, light: usize, lit: &TileContributions) {
        let row = &mut self.unshadowed[light * GROUP..][..GROUP];
        for (i, (u, all)) in row.iter_mut().zip(&mut self.all).enumerate() {
            let (sum, [_, integrals]) = lit.get(i);
            *u = sum.radiance;
            self.integrals[i] = integrals;
            *all += u.max_element();
            self.lit[light] |= u64::from(u.max_element() > 0.0) << i;
        }
    }

    /// Finds the faint lights.
    pub(crate) fn find(&mut self, tolerance: f32) {
        let each = || self.unshadowed.chunks_exact(GROUP);
        let largest =
            |row: &[Vec3]| row.iter().zip(&self.all).map(|(u, all)| u.max_element() / all).fold(0.0, f32::max);
        self.largest.extend(each().map(largest));
        self.count = self.largest.iter().filter(|part| **part > 0.0).count();
        for row in each() {
            for ((u, all), parts) in row.iter().zip(&self.all).zip(&mut self.parts) {
                let part = u.max_element() / all;
                if let Some(step) = step(part) {
                    parts[step] += part;
                }
            }
        }
        self.first.extend(self.parts.iter().map(|parts| first_faint(parts, PART * HALF * tolerance)));
        for (row, faint) in each().zip(&mut self.faint) {
            for (i, ((u, all), first)) in row.iter().zip(&self.all).zip(&self.first).enumerate() {
                if step(u.max_element() / all).is_some_and(|step| step >= *first) {
                    *faint |= 1 << i;
                    self.sums[i] += *u;
                }
            }
        }
    }

    /// Finds those that are not faint after all, by the radiance that the others leave: [`late`](Self::late) has them.
    pub(crate) fn find_late(&mut self, out: &[Vec3], tolerance: f32) {
        let most = |out: &Vec3| PART * tolerance * out.max_element();
        let is_too_much = |(sum, out): (&Vec3, &Vec3)| sum.max_element() > most(out);
        let pairs = self.sums.iter().zip(out).enumerate();
        let mut bits = pairs.fold(0_u64, |bits, (i, both)| bits | u64::from(is_too_much(both)) << i);
        while bits != 0 {
            let i = bits.trailing_zeros() as usize;
            bits &= bits - 1;
            let (all, first) = (self.all[i], first_faint(&self.parts[i], most(&out[i]) / self.all[i]));
            for (light, faint) in self.faint.iter_mut().enumerate().filter(|(_, faint)| **faint & 1 << i != 0) {
                let u = self.unshadowed[light * GROUP + i];
                if step(u.max_element() / all).is_some_and(|step| step < first) {
                    *faint &= !(1 << i);
                    self.late[light] |= 1 << i;
                    self.sums[i] -= u;
                }
            }
        }
    }

    /// The receivers that a light turned out not to be faint for.
    pub(crate) fn late(&self, light: usize) -> u64 {
        self.late[light]
    }

    /// The receivers that a light is to be summed for.
    pub(crate) fn strong(&self, light: usize) -> u64 {
        self.lit[light] & !self.faint[light]
    }

    /// The error that a light's visible fraction may have, so that the root of the sum of squares over all lights is the tolerance.
    pub(crate) fn slack(&self, light: usize, tolerance: f32) -> f32 {
        self.largest.get(light).map_or(0.0, |part| (tolerance / (part * (self.count as f32).sqrt())).clamp(0.0, 0.25))
    }

    /// The receivers that a light is faint for.
    pub(crate) fn of(&self, light: usize) -> u64 {
        self.faint[light]
    }

    /// The integrals that a light takes, of each receiver.
    pub(crate) fn integrals(&self) -> &[u32] {
        &self.integrals
    }

    /// The mean visible fraction of a receiver's other lights, which leave this radiance.
    pub(crate) fn fraction(&self, i: usize, out: Vec3) -> f32 {
        let strong = self.all[i] - self.sums[i].max_element();
        if strong > 0.0 { (out.max_element() / strong).min(1.0) } else { 0.0 }
    }

    /// The radiance that a receiver gets from a light without blockers.
    pub(crate) fn unshadowed(&self, light: usize, i: usize) -> Vec3 {
        self.unshadowed[light * GROUP + i]
    }
}

/// The first step whose lights are faint: they and all dimmer ones are at most this part of a receiver's radiance.
fn first_faint(parts: &[f32; STEPS], most: f32) -> usize {
    let mut sum = 0.0;
    let fits = |part: &&f32| {
        sum += **part;
        sum <= most
    };
    STEPS - parts.iter().rev().take_while(fits).count()
}

/// The step of a light's part; none where it gives nothing.
fn step(part: f32) -> Option<usize> {
    let octaves = (1.0_f32.to_bits() >> 21).saturating_sub(part.to_bits() >> 21) as usize;
    (part > 0.0).then_some(octaves.min(STEPS - 1))
}
