//! The sum of [`FractionIntegrator`](crate::FractionIntegrator) for all receivers of a tile: sixteen rows in one instruction.

use crate::integrator::FractionSource;
use crate::tile_blocks::Blocks;
use crate::{Contribution, Coverage, Interaction, LightCoverage, LightVisibility, Observer, Stage, Visibility};
use glam::Vec3;
use lobe_core::lanes::{Kept, Lane, Level, WIDTH, ones, row, rows_above, update};
use lobe_core::{BrdfLobe, PackedLobe, Receiver, TileLight, TileLobes, TileRadiance};

/// The receivers of a tile and one light: [`Interaction`] for many.
#[derive(Clone, Copy, Debug)]
pub struct TileInteraction<'a> {
    /// The receivers.
    pub at: &'a [Receiver],
    /// Their reflectance lobes.
    pub lobes: &'a TileLobes,
    /// The light as they see it.
    pub light: &'a TileLight,
    /// [`cap_integrals`](lobe_core::cap_integrals) of these lobes over this light. Unused where the integrator does not
    /// [take integrals](crate::Integrator::TAKES_INTEGRALS) or the light shows an image.
    pub integrals: &'a [f32],
    /// See [`Interaction::threshold`].
    pub threshold: f32,
    /// The error that a visible fraction may have where it is interpolated between receivers, which are 8 rows of 8 then. 0: none is.
    pub slack: f32,
}

/// The contributions of one light to the receivers of a tile, and working memory.
#[derive(Clone, Debug, Default)]
pub struct TileContributions {
    blocks: Vec<Kept<SUMS>>,
    brdf: Vec<BrdfLobe>,
}

/// One receiver's sums over its reflectance lobes: a row of the columns.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Sums {
    /// The integral of the lobe that is added next.
    integral: f32,
    radiance: Vec3,
    unshadowed: Vec3,
    /// Counters, as floats: integrals, visibility lobes, lobes above the threshold and lobes dropped below it.
    integrals: f32,
    visibility_lobes: f32,
    above: f32,
    dropped: f32,
}

const SUMS: usize = size_of::<Sums>() / size_of::<f32>();
/// Columns of [`Sums`].
const INTEGRAL: usize = core::mem::offset_of!(Sums, integral) / 4;
const RADIANCE: usize = core::mem::offset_of!(Sums, radiance) / 4;
const UNSHADOWED: usize = core::mem::offset_of!(Sums, unshadowed) / 4;
const INTEGRALS: usize = core::mem::offset_of!(Sums, integrals) / 4;
const VISIBILITY_LOBES: usize = core::mem::offset_of!(Sums, visibility_lobes) / 4;
const ABOVE: usize = core::mem::offset_of!(Sums, above) / 4;
const DROPPED: usize = core::mem::offset_of!(Sums, dropped) / 4;

impl TileContributions {
    /// Radiance toward the eye of receiver `i`.
    ///
    /// # Panics
    /// When the tile has no such receiver's block.
    #[must_use]
    #[inline]
    pub fn radiance(&self, i: usize) -> Vec3 {
        let sums = &self.blocks[i / WIDTH].0;
        Vec3::from_array(core::array::from_fn(|c| sums[RADIANCE + c][i % WIDTH]))
    }

    /// The contribution to receiver `i`, and how many visibility lobes and integrals it took.
    ///
    /// # Panics
    /// When the tile has no such receiver's block.
    #[must_use]
    pub fn get(&self, i: usize) -> (Contribution, [u32; 2]) {
        let sums: Sums = bytemuck::cast(row(&self.blocks[i / WIDTH].0, i % WIDTH));
        let Sums { radiance, unshadowed, integrals, visibility_lobes, .. } = sums;
        (Contribution { radiance, unshadowed }, [visibility_lobes as u32, integrals as u32])
    }

    /// Begins the contributions of a light that is summed elsewhere: none yet of so many receivers.
    pub fn begin(&mut self, receivers: usize) {
        self.reset(receivers);
    }

    /// Sets the contribution to receiver `i`, for which so many integrals were taken.
    ///
    /// # Panics
    /// When the tile has no such receiver's block.
    pub fn put(&mut self, i: usize, sum: &Contribution, integrals: usize) {
        self.set(i, sum.radiance, [0, integrals]);
        self.set_color(UNSHADOWED, i, sum.unshadowed);
    }

    /// No contributions yet.
    fn reset(&mut self, receivers: usize) {
        self.blocks.resize(receivers.div_ceil(WIDTH), Kept::default());
        self.blocks.iter_mut().for_each(|block| block.0[INTEGRAL + 1..].as_flattened_mut().fill(0.0));
    }

    pub(crate) fn set(&mut self, i: usize, radiance: Vec3, [lobes, integrals]: [usize; 2]) {
        self.set_color(RADIANCE, i, radiance);
        let sums = &mut self.blocks[i / WIDTH].0;
        sums[INTEGRALS][i % WIDTH] += integrals as f32;
        sums[VISIBILITY_LOBES][i % WIDTH] += lobes as f32;
    }

    fn set_color(&mut self, first: usize, i: usize, color: Vec3) {
        let sums = &mut self.blocks[i / WIDTH].0;
        for (column, value) in sums[first..first + 3].iter_mut().zip(color.to_array()) {
            column[i % WIDTH] = value;
        }
    }
}

impl TileInteraction<'_> {
    /// The twin of the integrator's `radiance` for one receiver: the same sum, bit for bit.
    ///
    /// All receivers' unshadowed sums come first, in columns. Receivers of which some lobe is above the threshold then
    /// ask for their coverage, and those in penumbra for fractions.
    pub(crate) fn radiance<V: Visibility + ?Sized>(
        &self,
        visibility: &mut LightVisibility<'_, V>,
        source: &mut impl FractionSource<V>,
        observer: &mut impl Observer,
        out: &mut TileContributions,
    ) {
        if visibility.image().is_some() {
            let radiance = |point: &Interaction<'_>, observer: &mut Counted<'_, _>| {
                crate::integrator::radiance(point, visibility, source, observer)
            };
            return self.one_by_one(radiance, observer, out);
        }
        out.reset(self.at.len());
        self.sum_unshadowed(out);
        let is_spread = self.slack > 0.0 && visibility.group_coverage() != Coverage::Lit;
        let mut blocks = (is_spread && self.at.len() == Blocks::COUNT).then(|| Blocks::new(self, out)).flatten();
        if let Some(blocks) = &mut blocks {
            let mut evaluate = |i: usize, visibility: &mut LightVisibility<'_, V>, out: &mut TileContributions| {
                self.shadow(i, visibility, source, &mut *observer, out);
            };
            blocks.spread(self, visibility, &mut evaluate, out);
        }
        for first in (0..self.at.len()).step_by(WIDTH) {
            let rows = self.count(first, observer, out);
            if let Some(blocks) = &blocks {
                blocks.interpolated(first..first + rows).for_each(|v| observer.coverage(v));
                continue;
            }
            let above = rows_above(&out.blocks[first / WIDTH].0[ABOVE], 0.0);
            for j in ones(above & ((1 << rows) - 1)) {
                self.shadow(first + j, visibility, source, observer, out);
            }
        }
    }

    /// The contributions without visibility: those lobes above the threshold whose integrals were given, at no query.
    pub fn unshadowed(&self, observer: &mut impl Observer, out: &mut TileContributions) {
        out.reset(self.at.len());
        self.sum_unshadowed(out);
        for first in (0..self.at.len()).step_by(WIDTH) {
            self.count(first, observer, out);
        }
    }

    /// Counts the integrals of a block of receivers, and the lobes that were dropped. Returns the number of receivers.
    fn count(&self, first: usize, observer: &mut impl Observer, out: &TileContributions) -> usize {
        let sums = &out.blocks[first / WIDTH].0;
        let rows = WIDTH.min(self.at.len() - first);
        observer.count(0, total(&sums[INTEGRALS], rows));
        (0..total(&sums[DROPPED], rows)).for_each(|_| observer.prune());
        rows
    }

    /// Adds every lobe to its receiver's row, without visibility.
    fn sum_unshadowed(&self, out: &mut TileContributions) {
        let (level, threshold) = (Level::new(), self.threshold);
        for (number, integrals) in self.integrals.chunks_exact(WIDTH).enumerate() {
            let block = number % self.lobes.blocks_of_place();
            let sums = &mut out.blocks[block].0;
            sums[INTEGRAL].copy_from_slice(integrals);
            match self.light.radiances() {
                TileRadiance::Same(light) => {
                    update(level, &AddLobe { light, threshold }, sums, self.lobes.block(number));
                }
                TileRadiance::Each(each) => {
                    let mut both = [[0.0; WIDTH]; 11];
                    both[..8].copy_from_slice(self.lobes.block(number));
                    both[8..].copy_from_slice(&each[block].0);
                    update(level, &AddLobeOfEach { threshold }, sums, &both);
                }
            }
        }
    }

    /// Multiplies the lobes of one receiver by their visible fractions.
    fn shadow<V: Visibility + ?Sized>(
        &self,
        i: usize,
        visibility: &mut LightVisibility<'_, V>,
        source: &mut impl FractionSource<V>,
        observer: &mut impl Observer,
        out: &mut TileContributions,
    ) {
        if visibility.group_coverage() == Coverage::Lit {
            observer.coverage(Coverage::Lit);
            return;
        }
        let seen = self.light.seen_by(i);
        match visibility.observed(&self.at[i], &seen.cone, seen.outline.as_ref(), observer) {
            LightCoverage::Lit => {}
            LightCoverage::Dark => out.set(i, Vec3::ZERO, [0, 0]),
            LightCoverage::Partial(penumbra) => {
                let light = seen.radiance;
                let (mut radiance, mut counts) = (Vec3::ZERO, [0, 0]);
                for (number, lobe) in self.lobes.of(i) {
                    let integral = self.integrals[number];
                    let unshadowed = lobe.flux() * light * integral;
                    if unshadowed.max_element() > self.threshold {
                        let (fraction, [lobes, integrals]) =
                            source.fraction(visibility, &penumbra, &lobe, integral, observer);
                        radiance += unshadowed * fraction;
                        counts = [counts[0] + lobes, counts[1] + integrals];
                    }
                }
                out.set(i, radiance, counts);
            }
        }
    }

    /// The contributions of one receiver after the other, as `radiance` gives them: [`Integrator::tile`](crate::Integrator::tile) of methods that
    /// have nothing faster.
    pub fn one_by_one<O: Observer>(
        &self,
        mut radiance: impl FnMut(&Interaction<'_>, &mut Counted<'_, O>) -> Contribution,
        observer: &mut O,
        out: &mut TileContributions,
    ) {
        out.reset(self.at.len());
        let mut brdf = core::mem::take(&mut out.brdf);
        for (i, at) in self.at.iter().enumerate() {
            brdf.clear();
            brdf.extend(self.lobes.of(i).map(|(_, lobe)| lobe));
            let light = self.light.seen_by(i);
            let point = Interaction { at, brdf: &brdf, light: &light, threshold: self.threshold };
            let mut counted = Counted { observer: &mut *observer, counts: [0, 0] };
            let sum = radiance(&point, &mut counted);
            let counts = counted.counts;
            out.set(i, sum.radiance, counts);
            out.set_color(UNSHADOWED, i, sum.unshadowed);
        }
        out.brdf = brdf;
    }
}

/// Sum of small whole numbers.
fn total(column: &[f32; WIDTH], rows: usize) -> usize {
    let mut sums: [f32; WIDTH] = core::array::from_fn(|j| if j < rows { column[j] } else { 0.0 });
    // By halves, since one after the other would wait for each other.
    for half in [8, 4, 2, 1] {
        let (low, high) = sums.split_at_mut(half);
        low.iter_mut().zip(high).for_each(|(a, b)| *a += *b);
    }
    sums[0] as usize
}

/// An observer that counts for one receiver, and passes all on to another: of [`TileInteraction::one_by_one`].
pub struct Counted<'p, P> {
    observer: &'p mut P,
    counts: [usize; 2],
}

impl<P: Observer> Observer for Counted<'_, P> {
    fn end(&mut self, stage: Stage) {
        self.observer.end(stage);
    }
    fn count(&mut self, lobes: usize, integrals: usize) {
        self.counts = [self.counts[0] + lobes, self.counts[1] + integrals];
        self.observer.count(lobes, integrals);
    }
    fn prune(&mut self) {
        self.observer.prune();
    }
    fn coverage(&mut self, coverage: Coverage) {
        self.observer.coverage(coverage);
    }
}

/// Adds a lobe to the sums of a receiver: `flux · light's radiance · ∫ lobe over the light`, where the light has the same
/// radiance toward all receivers.
struct AddLobe {
    light: Vec3,
    threshold: f32,
}

/// The same where the radiance differs from receiver to receiver: it follows the lobe.
struct AddLobeOfEach {
    threshold: f32,
}

impl Lane<SUMS, 11, SUMS> for AddLobeOfEach {
    #[inline(always)]
    fn value(&self, sums: [f32; SUMS], row: [f32; 11]) -> [f32; SUMS] {
        let [lobe @ .., r, g, b] = row;
        AddLobe { light: Vec3::new(r, g, b), threshold: self.threshold }.value(sums, lobe)
    }
}

impl Lane<SUMS, 8, SUMS> for AddLobe {
    #[inline(always)]
    fn value(&self, sums: [f32; SUMS], lobe: [f32; 8]) -> [f32; SUMS] {
        let (sums, lobe) = (bytemuck::cast::<_, Sums>(sums), bytemuck::cast::<_, PackedLobe>(lobe));
        let unshadowed = lobe.flux * self.light * sums.integral;
        let larger = |a: f32, b: f32| if a > b { a } else { b };
        let largest = larger(larger(unshadowed.x, unshadowed.y), unshadowed.z);
        let above = largest > self.threshold;
        let below = !above && largest > 0.0;
        let taken = |x: f32| if above { x } else { 0.0 };
        bytemuck::cast(Sums {
            radiance: sums.radiance + Vec3::new(taken(unshadowed.x), taken(unshadowed.y), taken(unshadowed.z)),
            unshadowed: sums.unshadowed + unshadowed,
            integrals: sums.integrals + if lobe.flux == Vec3::ZERO { 0.0 } else { 1.0 },
            above: if above { sums.above + 1.0 } else { sums.above },
            dropped: if below { sums.dropped + 1.0 } else { sums.dropped },
            ..sums
        })
    }
}
