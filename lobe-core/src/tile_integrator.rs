use crate::integrator::{look, partly_seen};
use crate::lanes::{Kept, Lane, Level, WIDTH, ones, row, rows_above, update};
use crate::tile::TileRadiance;
use crate::{
    Call, Coverage, Integrator, Lit, Lobe, LobeBuffer, LobesFull, Look, Method, Observer, Receiver, TileLight,
    TileLobes, VisibilityLobes, VisibilitySum, Visit,
};
use glam::Vec3;

/// The receivers of a tile and one light, to be integrated: [`Call`](crate::Call) for many.
#[derive(Clone, Copy, Debug)]
pub struct TileCall<'a> {
    /// The receivers.
    pub at: &'a [Receiver],
    /// Their reflectance lobes.
    pub lobes: &'a TileLobes,
    /// The light as they see it.
    pub light: &'a TileLight,
    /// [`cap_integrals`](crate::cap_integrals) of these lobes over this light. The paper's method has no use for them, nor have lights that
    /// show an image.
    pub integrals: &'a [f32],
}

/// What [`Integrator::tile`] finds, and its working memory.
#[derive(Clone, Debug, Default)]
pub struct TileLit {
    blocks: Vec<Kept<SUMS>>,
    brdf: LobeBuffer,
}

/// Columns: a lobe's integral; radiance; the same without blockers; integrals; visibility lobes; lobes above the threshold,
/// and dropped ones.
const SUMS: usize = 11;

impl TileLit {
    /// Radiance toward the eye of receiver `i`.
    ///
    /// # Panics
    /// When the tile has no such receiver's block.
    #[must_use]
    #[inline]
    pub fn radiance(&self, i: usize) -> Vec3 {
        let [_, x, y, z, ..] = &self.blocks[i / WIDTH].0;
        Vec3::new(x[i % WIDTH], y[i % WIDTH], z[i % WIDTH])
    }

    /// All that was found for receiver `i`, and how many visibility lobes and integrals that took.
    ///
    /// # Panics
    /// When the tile has no such receiver's block.
    #[must_use]
    pub fn get(&self, i: usize) -> (Lit, [u32; 2]) {
        let [_, _, _, _, x, y, z, integrals, lobes, ..] = row(&self.blocks[i / WIDTH].0, i % WIDTH);
        (Lit { radiance: self.radiance(i), unshadowed: Vec3::new(x, y, z) }, [lobes as u32, integrals as u32])
    }

    fn set(&mut self, i: usize, radiance: Vec3, counts: [usize; 2]) {
        let sums = &mut self.blocks[i / WIDTH].0;
        for (column, value) in sums[1..4].iter_mut().zip(radiance.to_array()) {
            column[i % WIDTH] = value;
        }
        sums[7][i % WIDTH] += counts[1] as f32;
        sums[8][i % WIDTH] += counts[0] as f32;
    }
}

impl Integrator<'_> {
    /// [`radiance`](Self::radiance) of all receivers of a tile: the same numbers, for less.
    ///
    /// # Errors
    /// [`LobesFull`] when `sum` is smaller than the strategy's `max_lobes`.
    ///
    /// # Panics
    /// When the parts of `call` are not of one tile.
    pub fn tile<V: VisibilityLobes + ?Sized>(
        &self,
        call: &TileCall<'_>,
        visit: &mut Visit<'_, V>,
        sum: &mut VisibilitySum,
        observer: &mut impl Observer,
        out: &mut TileLit,
    ) -> Result<(), LobesFull> {
        out.blocks.resize(call.at.len().div_ceil(WIDTH), Kept::default());
        out.blocks.iter_mut().for_each(|block| block.0[1..].as_flattened_mut().fill(0.0));
        match self.method {
            Method::Moments if visit.image().is_none() => self.tile_by_moments(call, visit, sum, observer, out),
            Method::Moments | Method::Paper(_) => self.tile_one_by_one(call, visit, sum, observer, out),
        }
    }

    fn tile_by_moments<V: VisibilityLobes + ?Sized>(
        &self,
        call: &TileCall<'_>,
        visit: &mut Visit<'_, V>,
        sum: &mut VisibilitySum,
        observer: &mut impl Observer,
        out: &mut TileLit,
    ) -> Result<(), LobesFull> {
        let (level, threshold) = (Level::new(), self.threshold);
        for (number, integrals) in call.integrals.chunks_exact(WIDTH).enumerate() {
            let block = number % call.lobes.blocks_of_place();
            let sums = &mut out.blocks[block].0;
            sums[0].copy_from_slice(integrals);
            match call.light.radiances() {
                TileRadiance::Same(light) => {
                    update(level, &AddLobe { light, threshold }, sums, call.lobes.block(number));
                }
                TileRadiance::Each(each) => {
                    let mut both = [[0.0; WIDTH]; 11];
                    both[..8].copy_from_slice(call.lobes.block(number));
                    both[8..].copy_from_slice(&each[block].0);
                    update(level, &AddOwn { threshold }, sums, &both);
                }
            }
        }
        for first in (0..call.at.len()).step_by(WIDTH) {
            let [.., integrals, _, seen, dropped] = &out.blocks[first / WIDTH].0;
            let rows = WIDTH.min(call.at.len() - first);
            let total = |column: &[f32; WIDTH]| total(column, rows);
            observer.count(0, total(integrals));
            (0..total(dropped)).for_each(|_| observer.prune());
            for j in ones(rows_above(seen, 0.0) & ((1 << rows) - 1)) {
                self.look_at(call, first + j, visit, sum, observer, out)?;
            }
        }
        Ok(())
    }

    /// One receiver that would be lit, if nothing hid the light.
    fn look_at<V: VisibilityLobes + ?Sized>(
        &self,
        call: &TileCall<'_>,
        i: usize,
        visit: &mut Visit<'_, V>,
        sum: &mut VisibilitySum,
        observer: &mut impl Observer,
        out: &mut TileLit,
    ) -> Result<(), LobesFull> {
        if visit.entered() == Coverage::Lit {
            observer.coverage(Coverage::Lit);
            return Ok(());
        }
        match look(visit, &call.at[i], &call.light.cone(i), call.light.outline(i), observer) {
            Look::Lit => {}
            Look::Dark => out.set(i, Vec3::ZERO, [0, 0]),
            Look::Partial(seen) => {
                let light = call.light.radiance(i);
                let (mut radiance, mut counts) = (Vec3::ZERO, [0, 0]);
                for (number, f) in call.lobes.of(i) {
                    let integral = call.integrals[number];
                    let unshadowed = f.flux * light * integral;
                    if unshadowed.max_element() > self.threshold {
                        radiance += unshadowed * partly_seen(visit, &seen, &f, integral, sum, observer)?;
                        let [lobes, whole] = [&sum.lobes, &sum.whole].map(|sum| sum.lobes().len());
                        counts = [counts[0] + lobes, counts[1] + lobes + whole];
                    }
                }
                out.set(i, radiance, counts);
            }
        }
        Ok(())
    }

    fn tile_one_by_one<V: VisibilityLobes + ?Sized>(
        &self,
        call: &TileCall<'_>,
        visit: &mut Visit<'_, V>,
        sum: &mut VisibilitySum,
        observer: &mut impl Observer,
        out: &mut TileLit,
    ) -> Result<(), LobesFull> {
        let mut brdf = core::mem::take(&mut out.brdf);
        if brdf.capacity() < call.lobes.places() {
            brdf = LobeBuffer::with_capacity(call.lobes.places());
        }
        for (i, at) in call.at.iter().enumerate() {
            let mut writer = brdf.writer();
            call.lobes.of(i).try_for_each(|(_, lobe)| writer.push(lobe))?;
            let light = call.light.term(i);
            let one = Call { at, brdf: brdf.lobes(), light: &light };
            let mut counted = Counted { observer: &mut *observer, counts: [0, 0] };
            let lit = self.radiance(&one, visit, sum, &mut counted)?;
            out.set(i, lit.radiance, counted.counts);
            for (column, value) in out.blocks[i / WIDTH].0[4..7].iter_mut().zip(lit.unshadowed.to_array()) {
                column[i % WIDTH] = value;
            }
        }
        out.brdf = brdf;
        Ok(())
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

/// Counts for one receiver, and passes all on.
struct Counted<'p, P> {
    observer: &'p mut P,
    counts: [usize; 2],
}

impl<P: Observer> Observer for Counted<'_, P> {
    fn end(&mut self, stage: crate::Stage) {
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

/// Adds a lobe to the sums, where the light is as bright toward each receiver.
struct AddLobe {
    light: Vec3,
    threshold: f32,
}

/// The same where it is not: its radiance follows the lobe.
struct AddOwn {
    threshold: f32,
}

impl Lane<SUMS, 11, SUMS> for AddOwn {
    #[inline(always)]
    fn value(&self, sums: [f32; SUMS], row: [f32; 11]) -> [f32; SUMS] {
        let [lobe @ .., r, g, b] = row;
        AddLobe { light: Vec3::new(r, g, b), threshold: self.threshold }.value(sums, lobe)
    }
}

impl Lane<SUMS, 8, SUMS> for AddLobe {
    #[inline(always)]
    fn value(
        &self,
        [integral, r, g, b, all @ .., count, lobes, seen, dropped]: [f32; SUMS],
        lobe: [f32; 8],
    ) -> [f32; SUMS] {
        let flux = bytemuck::cast::<_, Lobe>(lobe).flux;
        let unshadowed = flux * self.light * integral;
        let larger = |a: f32, b: f32| if a > b { a } else { b };
        let largest = larger(larger(unshadowed.x, unshadowed.y), unshadowed.z);
        let above = largest > self.threshold;
        let below = !above && largest > 0.0;
        let taken = |x: f32| if above { x } else { 0.0 };
        [
            integral,
            r + taken(unshadowed.x),
            g + taken(unshadowed.y),
            b + taken(unshadowed.z),
            all[0] + unshadowed.x,
            all[1] + unshadowed.y,
            all[2] + unshadowed.z,
            count + if flux == Vec3::ZERO { 0.0 } else { 1.0 },
            lobes,
            if above { seen + 1.0 } else { seen },
            if below { dropped + 1.0 } else { dropped },
        ]
    }
}
