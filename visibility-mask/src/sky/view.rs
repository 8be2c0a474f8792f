use super::buffer::last_column;
use super::spread::{Spread, is_wide};
use super::{Horizon, SkyBlend, SkyBuffer, SkyResolution, SkyTable, SkyWindow};
use crate::lanes::sum;
use core::f32::consts::FRAC_1_PI;
use fearless_simd::{Level, Simd, dispatch, f32x8, prelude::*};
use glam::Vec3;
use lobe_core::special::{exp_of_eight, ln_1p_of_eight};
use lobe_core::vec3x8::{LANES, Vec3x8};
use lobe_core::{BrdfLobe, BrushedAt, Facets, Lobe, Microfacets, MicrofacetsAt, Receiver, Schlick, is_lambert};
use shading::Coverage;

/// The widest step between samples that a lobe's sum is good for: the factor by which the lobe's standard deviation is larger.
pub(crate) const STEPS: f32 = 1.5;
/// Less than this part of a sky is seen through few samples: a room lit through its window.
pub(crate) const LITTLE: f32 = 1.0 / 8.0;
/// And less than this of a crowd's, whose rows are exact: its openings are many and small, and masks count them no better (measured).
pub(crate) const CROWD_LITTLE: f32 = 1.0 / 64.0;
/// Of a lobe what is below this part of its peak is left out.
const NOTHING: f32 = 1e-5;
/// Lobes with a grain may be narrower across it than other lobes by this factor.
const GRAIN_PARTS: f32 = 8.0;
/// So many samples are looked at together where a part of a lobe may be nothing.
const GROUP: usize = 16;
/// Below this cosine to the pole a normal's horizon may cross meridians near their beginning.
pub(crate) const STEEP: f32 = 0.05;

/// The sky as one receiver after the other sees it: sums of a [`SkyTable`] over the part that a [`SkyBuffer`] leaves lit.
///
/// ```text
/// ∫ L(v) V(v) f(v) dv ≈ Σ samples  (∫ L dω) · seen part · f(mean direction)
/// ```
///
/// # Method
/// All receivers of a view are to use one table. A receiver [begins](Self::begin), [draws](Self::draw) outlines, and [settles](Self::settle) with one ray; then it
/// asks for the [integrals](Self::integrals) of its reflectance lobes, with and without blockers.
///
/// # Accuracy
/// Of Lambert's lobe that of the table, but at the horizon. Sums of a smooth lobe over a regular grid converge faster than any power of the
/// step while it is at least as wide as the step; see [`resolves`](Self::resolves).
#[derive(Clone, Debug, Default)]
pub struct SkyView {
    buffer: SkyBuffer,
    horizon: Option<Horizon>,
    window: SkyWindow,
    is_dark: bool,
    /// Normal and horizon of the last Lambert lobe, its integral, and that above the facet.
    known: Option<(Vec3, Horizon, [Vec3; 2])>,
    /// The second part of microfacets that follows, by its exponent.
    edge: Option<(f32, [Vec3; 2])>,
}

impl SkyView {
    /// Less than this part of a sky is seen through few samples of the second table, too.
    pub const LITTLE_FOR_SECOND: f32 = 1.0 / 32.0;
    /// Where this part of a sky's light is seen, it does not matter how [small](Self::is_small) the visible part of the sky is.
    pub const MUCH: f32 = 0.8;

    /// Begins a receiver.
    pub fn begin(&mut self, table: &SkyTable, horizon: Horizon) {
        self.begin_in(table, horizon, SkyWindow::whole(table.meridians().resolution()));
    }

    /// Begins what a receiver sees through a window, for parts of lobes that are nothing outside of it.
    pub fn begin_in(&mut self, table: &SkyTable, horizon: Horizon, window: SkyWindow) {
        self.buffer.clear(table.meridians().resolution(), window);
        self.window = window;
        self.horizon = Some(horizon);
        self.is_dark = false;
        self.edge = None;
    }

    /// Lets blockers draw all outlines, and do so again if [`SkyBuffer`] turns out to need another way to count them. Returns what they return.
    pub fn draw(&mut self, table: &SkyTable, mut draw: impl FnMut(&mut SkyBuffer) -> bool) -> bool {
        let result = draw(&mut self.buffer);
        let resolution = table.meridians().resolution();
        if !self.buffer.is_to_begin_again(resolution) {
            return result;
        }
        self.buffer.begin_again(resolution);
        draw(&mut self.buffer)
    }

    /// All outlines are drawn. `is_hidden` says whether a surface lies in a direction of the world; it is called once, or, if that may err
    /// (`in_doubt`) so often that two of three answers agree.
    pub fn settle(&mut self, table: &SkyTable, in_doubt: bool, mut is_hidden: impl FnMut(Vec3) -> bool) {
        let Some(horizon) = self.horizon else { return };
        let meridians = table.meridians();
        let witnesses = dispatch!(Level::new(), simd => {
            self.buffer.resolve(simd, meridians, &horizon);
            self.buffer.witnesses(simd, meridians, &horizon)
        });
        let mut hidden = witnesses.as_slice().iter().map(|v| is_hidden(horizon.pole().world(*v)));
        let first = hidden.next().unwrap_or_default();
        self.is_dark = first;
        if in_doubt && let Some(second) = hidden.next().filter(|second| *second != first) {
            self.is_dark = hidden.next().unwrap_or(second);
        }
    }

    /// How much of the sky is seen.
    #[must_use]
    pub fn coverage(&self) -> Coverage {
        if self.is_dark {
            Coverage::Dark
        } else if self.buffer.is_empty() && self.horizon.is_some_and(|horizon| !horizon.is_facet()) {
            Coverage::Lit
        } else {
            Coverage::Partial
        }
    }

    /// Whether no outline leaves room for light: not even for an opening between two rows.
    #[must_use]
    pub fn is_shut(&self) -> bool {
        self.is_dark && self.buffer.is_empty()
    }

    /// The part of a sky that is not [shut](Self::is_shut) below which samples are too coarse for what is seen of it, and finer masks are needed.
    #[must_use]
    pub const fn little(&self) -> f32 {
        if self.buffer.is_crowd() { CROWD_LITTLE } else { LITTLE }
    }

    /// Whether the visible part of the sky is smaller than a part of it, at most a third, whatever light it gives.
    pub fn is_small(&self, part: f32, table: &SkyTable, normal: Vec3) -> bool {
        if self.coverage() != Coverage::Partial {
            return false;
        }
        // Where a third of all rows is open, much is seen.
        let blocks = table.meridians().resolution().blocks();
        let open = (0..blocks).filter(|block| !self.buffer.is_crossed(*block)).count();
        if self.buffer.open_part() > 0.99 && 3 * open > blocks {
            return false;
        }
        let [seen, all] = dispatch!(Level::new(), simd => self.open(simd, table, normal));
        seen < part * all
    }

    /// A uniform sky's light by Lambert's lobe: the part that is seen, and all, in a unit of their own.
    #[inline(always)]
    fn open<S: Simd>(&self, simd: S, table: &SkyTable, normal: Vec3) -> [f32; 2] {
        let Some(horizon) = self.horizon else { return [0.0, 1.0] };
        let zero = f32x8::splat(simd, 0.0);
        let [.., axis] = horizon.pole().frame();
        let (mut seen, mut all) = (zero, zero);
        for block in 0..table.meridians().resolution().blocks() {
            let is_crossed = self.buffer.is_crossed(block);
            let part = f32x8::splat(simd, self.buffer.open_part());
            for (column, cell) in table.block(horizon.pole(), block).iter().enumerate() {
                let v = cell.direction(simd);
                let along = v.dot_one(axis);
                let weight = v.dot_one(normal).max(zero) * (1.0 - along * along).max(zero).sqrt();
                seen += weight * if is_crossed { self.buffer.seen(simd, block, column) } else { part };
                all += weight;
            }
        }
        [sum(seen), sum(all)]
    }

    /// Whether sums over the samples resolve a lobe, if need be by several directions for each sample. Others need finer masks.
    #[must_use]
    pub fn resolves(samples: SkyResolution, lobe: &BrdfLobe) -> bool {
        let part = match lobe {
            BrdfLobe::Cosine(_) => 1.0,
            BrdfLobe::Microfacets(facets) => grain_part(facets),
        };
        is_wide_enough(samples, lobe, part)
    }

    /// The same at a receiver, by one direction for each sample. Where the eye is low over a surface, half vectors that turn sideways by an angle turn reflected
    /// directions by `2 sin(height of the eye)` times it: the highlight is a streak, wide in height and narrow across. A grain makes streaks from any height.
    ///
    /// Tables that resolve a lobe but not its streak sum it by several directions for each sample, right for light that is constant between samples.
    #[must_use]
    pub fn resolves_at(samples: SkyResolution, lobe: &BrdfLobe, normal: Vec3) -> bool {
        let is_wide_across = match lobe {
            BrdfLobe::Cosine(_) => true,
            // Along a streak finer windows cost more than directions for each sample, for no less error (measured).
            BrdfLobe::Microfacets(facets) if samples.lines() > 1 && facets.grain.is_some() => true,
            BrdfLobe::Microfacets(facets) => is_wide(samples, facets, normal),
        };
        is_wide_across && is_wide_enough(samples, lobe, 1.0)
    }

    /// The integrals of sky's radiance times a lobe, over what is seen and over all above the receiver's horizon, for a flux of 1: what
    /// [`cap_integral`](lobe_core::cap_integral) is for a light of uniform radiance.
    pub fn integrals(&mut self, table: &SkyTable, at: &Receiver, lobe: &BrdfLobe) -> [Vec3; 2] {
        self.integrals_of(table, at, lobe, SkyBlend::ALL)
    }

    /// The same of a part of the lobe.
    pub fn integrals_of(&mut self, table: &SkyTable, at: &Receiver, lobe: &BrdfLobe, blend: SkyBlend) -> [Vec3; 2] {
        let Some(horizon) = self.horizon else { return [Vec3::ZERO; 2] };
        let is_whole = self.window.is_whole();
        match lobe {
            BrdfLobe::Cosine(lobe) if is_whole && blend == SkyBlend::ALL && is_lambert(at, lobe) => {
                self.lambert(table, at.normal, &horizon)
            }
            BrdfLobe::Cosine(lobe) => {
                let value = PowerLobe::new(lobe, at.normal);
                dispatch!(Level::new(), simd => self.sums(simd, table, at.normal, &blend, (&value, None)))[0]
            }
            BrdfLobe::Microfacets(facets) => {
                if let (Schlick::F90, Some((exponent, edge))) = (facets.part, self.edge.take())
                    && exponent == facets.exponent
                {
                    return edge;
                }
                let resolution = table.meridians().resolution();
                let spread = Spread::new(resolution, horizon.pole(), (facets, at.normal), blend.begin());
                let spread = spread.as_ref();
                let [base, edge] = match facets.grain {
                    None => {
                        let value = facets.at(at.normal);
                        dispatch!(Level::new(), simd => self.sums(simd, table, at.normal, &blend, (&value, spread)))
                    }
                    Some(grain) => {
                        let value = BrushedAt::new(facets, grain, at.normal);
                        dispatch!(Level::new(), simd => self.sums(simd, table, at.normal, &blend, (&value, spread)))
                    }
                };
                match facets.part {
                    Schlick::F0 => {
                        self.edge = Some((facets.exponent, edge));
                        base
                    }
                    Schlick::F90 => edge,
                }
            }
        }
    }

    /// Of the lobe `n·v/π`.
    fn lambert(&mut self, table: &SkyTable, normal: Vec3, horizon: &Horizon) -> [Vec3; 2] {
        let known = self.known.filter(|known| (known.0, known.1) == (normal, *horizon));
        let [all, open] = known
            .map_or_else(|| dispatch!(Level::new(), simd => open_sky(simd, table, normal, horizon)), |known| known.2);
        self.known = Some((normal, *horizon, [all, open]));
        if self.is_dark {
            return [Vec3::ZERO, all * FRAC_1_PI];
        }
        let part = self.buffer.open_part();
        let more = dispatch!(Level::new(), simd => self.beside(simd, table, normal, horizon, part));
        let seen = (open * part + more).max(Vec3::ZERO);
        [seen * FRAC_1_PI, all * FRAC_1_PI]
    }

    /// `∫ L n·v` over crossed blocks, times what is seen more than a part.
    #[inline(always)]
    fn beside<S: Simd>(&self, simd: S, table: &SkyTable, normal: Vec3, horizon: &Horizon, part: f32) -> Vec3 {
        let zero = f32x8::splat(simd, 0.0);
        let mut sums = Vec3x8::new(zero, zero, zero);
        let resolution = table.meridians().resolution();
        for block in (0..resolution.blocks()).filter(|block| self.buffer.is_crossed(*block)) {
            let end = table.meridians().crossing(simd, block, horizon.local());
            let last = last_column(simd, end, resolution.samples() + 2);
            let samples = table.block(horizon.pole(), block)[..last].iter().enumerate();
            // Before its first outline a row is as open as others.
            for (column, cell) in samples.skip(self.buffer.first_crossed(block)) {
                let mut weight = cell.direction(simd).dot_one(normal).max(zero);
                if horizon.is_facet() {
                    weight *= above(simd, end, column);
                }
                sums = sums + cell.light(simd) * (weight * (self.buffer.seen(simd, block, column) - part));
            }
        }
        Vec3::new(sum(sums.x), sum(sums.y), sum(sums.z))
    }

    /// Of one lobe, or of both parts of microfacets: what is seen, and all.
    #[inline(always)]
    fn sums<S: Simd, const P: usize>(
        &self,
        simd: S,
        table: &SkyTable,
        normal: Vec3,
        blend: &SkyBlend,
        (lobe, spread): (&impl Values<P>, Option<&Spread>),
    ) -> [[Vec3; 2]; P] {
        let Some(horizon) = &self.horizon else { return [[Vec3::ZERO; 2]; P] };
        let [zero, one] = [0.0, 1.0].map(|x| f32x8::splat(simd, x));
        let mut sums = [[Vec3x8::new(zero, zero, zero); 2]; P];
        let resolution = table.meridians().resolution();
        let samples = resolution.samples();
        let local = horizon.pole().local(normal);
        let [start, finish] = self.window.columns();
        let chord = resolution.chord(GROUP);
        for block in self.window.blocks() {
            // Where the receiver's own horizon is, and its facet's.
            let end = if local.z > STEEP { Some(table.meridians().crossing(simd, block, local)) } else { None };
            let last = end.map_or(samples, |end| last_column(simd, end, samples + 2)).min(finish);
            let facet =
                if horizon.is_facet() { Some(table.meridians().crossing(simd, block, horizon.local())) } else { None };
            let is_crossed = !self.is_dark && self.buffer.is_crossed(block);
            let part = f32x8::splat(simd, if self.is_dark { 0.0 } else { self.buffer.open_part() });
            let cells = table.block(horizon.pole(), block).get(start..last).unwrap_or_default();
            for (group, cells) in cells.chunks(GROUP).enumerate() {
                if blend.is_nothing(simd, cells[cells.len() / 2].direction(simd), chord) {
                    continue;
                }
                for (column, cell) in (start + group * GROUP..).zip(cells) {
                    let v = cell.direction(simd);
                    let Some(lobe) = part_of(simd, (lobe, spread), blend, v) else { continue };
                    let inside = match end {
                        _ if lobe.is_spread => one,
                        Some(end) => above(simd, end, column),
                        None => v.dot_one(normal).simd_gt(zero).select(one, zero),
                    };
                    let mut seen = if is_crossed { self.buffer.seen(simd, block, column) } else { part };
                    if let Some(facet) = facet {
                        seen *= above(simd, facet, column);
                    }
                    let mut light = cell.light(simd);
                    if let Some(part) = lobe.part {
                        light = light * part;
                    }
                    for (sums, value) in sums.iter_mut().zip(lobe.values) {
                        let whole = light * (f32x8::simd_from(simd, value) * inside);
                        sums[0] = sums[0] + whole * seen;
                        sums[1] = sums[1] + whole;
                    }
                }
            }
        }
        sums.map(|both| both.map(|s| Vec3::new(sum(s.x), sum(s.y), sum(s.z))))
    }
}

/// `∫ L n·v dv` above the horizon of a normal, and of that what is above the horizon.
#[inline(always)]
fn open_sky<S: Simd>(simd: S, table: &SkyTable, normal: Vec3, horizon: &Horizon) -> [Vec3; 2] {
    let zero = f32x8::splat(simd, 0.0);
    let mut sums = [Vec3x8::new(zero, zero, zero); 2];
    let resolution = table.meridians().resolution();
    let local = horizon.pole().local(normal);
    for block in 0..resolution.blocks() {
        let end = table.meridians().crossing(simd, block, horizon.local());
        let own =
            if local.z > STEEP { table.meridians().crossing(simd, block, local) } else { f32x8::splat(simd, f32::MAX) };
        let last = last_column(simd, own, resolution.samples() + 2);
        for (column, cell) in table.block(horizon.pole(), block)[..last].iter().enumerate() {
            let whole = cell.light(simd) * cell.direction(simd).dot_one(normal).max(zero);
            sums[0] = sums[0] + whole;
            if horizon.is_facet() {
                sums[1] = sums[1] + whole * above(simd, end, column);
            }
        }
    }
    if !horizon.is_facet() {
        sums[1] = sums[0];
    }
    sums.map(|s| Vec3::new(sum(s.x), sum(s.y), sum(s.z)))
}

/// The values of a part of a lobe in eight directions.
struct PartOfLobe<S: Simd, const P: usize> {
    values: [[f32; LANES]; P],
    /// By which they are still to be multiplied, if not by 1.
    part: Option<f32x8<S>>,
    /// Whether they are means over samples: 0 below the horizon.
    is_spread: bool,
}

/// None where all values are nothing.
#[inline(always)]
fn part_of<S: Simd, const P: usize>(
    simd: S,
    (lobe, spread): (&impl Values<P>, Option<&Spread>),
    blend: &SkyBlend,
    v: Vec3x8<S>,
) -> Option<PartOfLobe<S, P>> {
    let part = blend.of_eight(simd, v);
    if let Some(part) = part
        && !part.simd_gt(f32x8::splat(simd, 0.0)).any_true()
    {
        return None;
    }
    if let Some(spread) = spread
        && spread.is_near(simd, v)
    {
        return Some(PartOfLobe { values: spread.values(simd, lobe, blend, v)?, part: None, is_spread: true });
    }
    Some(PartOfLobe { values: lobe.values(simd, v)?, part, is_spread: false })
}

/// The parts of eight samples of a column that lie before the ends of their rows.
#[inline(always)]
fn above<S: Simd>(simd: S, end: f32x8<S>, column: usize) -> f32x8<S> {
    (end - column as f32).max(f32x8::splat(simd, 0.0)).min(f32x8::splat(simd, 1.0))
}

/// Whether samples resolve a lobe if `part` of its exponent is enough.
fn is_wide_enough(samples: SkyResolution, lobe: &BrdfLobe, part: f32) -> bool {
    let step = STEPS * samples.pitch();
    let exponent = match lobe {
        // Without tails, half of its light may lie beside an edge along the only line of a row, which moves by the row's whole width.
        BrdfLobe::Cosine(lobe) if samples.lines() == 1 => 4.0 * lobe.exponent,
        BrdfLobe::Cosine(lobe) => lobe.exponent,
        // Directions turn twice as far as half vectors.
        BrdfLobe::Microfacets(facets) => 0.25 * facets.exponent,
    };
    part * exponent * step * step <= 1.0
}

/// The part of an exponent that samples are to resolve: along a grain lobes are wider, and several directions for each sample resolve them across.
fn grain_part(facets: &Microfacets) -> f32 {
    let Some(grain) = facets.grain else { return 1.0 };
    let alpha = (2.0 / (facets.exponent + 2.0)).sqrt();
    (alpha / grain.alpha(alpha)).max(1.0 / (GRAIN_PARTS * GRAIN_PARTS))
}

/// The values of a lobe of flux 1, or of the two parts of microfacets, in eight unit directions.
pub(super) trait Values<const P: usize> {
    /// None where all of them are nothing.
    fn values<S: Simd>(&self, simd: S, v: Vec3x8<S>) -> Option<[[f32; LANES]; P]>;
}

/// `(e + 1)/2π (a·v)^e`, or times `n·v`.
struct PowerLobe {
    axis: Vec3,
    exponent: f32,
    scale: f32,
    /// Below this `a·v` there is nothing.
    least: f32,
    /// The normal, where the receiver's cosine multiplies the power.
    normal: Option<Vec3>,
}

impl PowerLobe {
    fn new(lobe: &Lobe, normal: Vec3) -> Self {
        let Lobe { axis, exponent, has_cosine, .. } = *lobe;
        let least = if exponent > 1.0 { NOTHING.powf(1.0 / exponent) } else { 0.0 };
        let scale = (exponent + 1.0) * (0.5 * FRAC_1_PI);
        Self { axis, exponent, scale, least, normal: has_cosine.then_some(normal) }
    }
}

impl Values<1> for PowerLobe {
    #[inline(always)]
    fn values<S: Simd>(&self, simd: S, v: Vec3x8<S>) -> Option<[[f32; LANES]; 1]> {
        if !v.dot_one(self.axis).simd_gt(f32x8::splat(simd, self.least)).any_true() {
            return None;
        }
        let zero = f32x8::splat(simd, 0.0);
        let half = v.minus(self.axis).length_squared() * 0.5;
        let power = exp_of_eight(simd, ln_1p_of_eight(simd, -half) * self.exponent);
        let mut values = half.simd_lt(f32x8::splat(simd, 1.0)).select(power * self.scale, zero);
        if let Some(normal) = self.normal {
            values *= v.dot_one(normal).max(zero);
        }
        Some([values.into()])
    }
}

impl Values<2> for MicrofacetsAt {
    #[inline(always)]
    fn values<S: Simd>(&self, simd: S, v: Vec3x8<S>) -> Option<[[f32; LANES]; 2]> {
        Some(self.both_of_eight(simd, v).map(Into::into))
    }
}

impl Values<2> for BrushedAt {
    #[inline(always)]
    fn values<S: Simd>(&self, simd: S, v: Vec3x8<S>) -> Option<[[f32; LANES]; 2]> {
        Some(self.both_of_eight(simd, v).map(Into::into))
    }
}
