use glam::Vec3;
use lobe_core::{BrdfLobe, Lobe, Receiver, TileLobes, is_lambert};
use shading::{Contribution, Observer, Stage, TileContributions};
use visibility_mask::sky::{
    Horizon, SkyBlend, SkyBlockers, SkyHighlight, SkyResolution, SkyTable, SkyTile, SkyView, SkyWindow,
};

/// Lights that a shader sums at once: the patches of an environment.
///
/// `()` is none. [`SkyShader`] is the one there is.
pub trait SkyLighting: Sync {
    /// Working memory, one a thread.
    type Scratch: Send;

    /// New working memory.
    fn scratch(&self) -> Self::Scratch;

    /// Whether a light of the frame is among them.
    fn replaces(&self, light: usize) -> bool;

    /// The first of them, in whose place their sum stands; none where there are none.
    fn place(&self) -> Option<usize>;

    /// The contributions to the receivers of a tile by all lobes that the sums resolve, which are taken out of `lobes`. Whether any are
    /// left: these are to be integrated light by light.
    fn tile(
        &self,
        at: &[Receiver],
        lobes: &mut TileLobes,
        threshold: f32,
        scratch: &mut Self::Scratch,
        observer: &mut impl Observer,
        out: &mut TileContributions,
    ) -> bool;
}

impl SkyLighting for () {
    type Scratch = ();

    fn scratch(&self) {}
    fn replaces(&self, _: usize) -> bool {
        false
    }
    fn place(&self) -> Option<usize> {
        None
    }
    fn tile(
        &self,
        _: &[Receiver],
        _: &mut TileLobes,
        _: f32,
        (): &mut (),
        _: &mut impl Observer,
        _: &mut TileContributions,
    ) -> bool {
        false
    }
}

impl<K: SkyLighting> SkyLighting for Option<K> {
    type Scratch = Option<K::Scratch>;

    fn scratch(&self) -> Self::Scratch {
        self.as_ref().map(K::scratch)
    }
    fn replaces(&self, light: usize) -> bool {
        self.as_ref().is_some_and(|sky| sky.replaces(light))
    }
    fn place(&self) -> Option<usize> {
        self.as_ref().and_then(K::place)
    }
    fn tile(
        &self,
        at: &[Receiver],
        lobes: &mut TileLobes,
        threshold: f32,
        scratch: &mut Self::Scratch,
        observer: &mut impl Observer,
        out: &mut TileContributions,
    ) -> bool {
        let (Some(sky), Some(scratch)) = (self, scratch) else { return false };
        sky.tile(at, lobes, threshold, scratch, observer, out)
    }
}

/// An environment through one buffer a receiver, instead of a mask for each patch.
///
/// For each tile blockers search once; for each receiver they draw once, one ray says what the fewest surfaces are, and each reflectance
/// lobe is summed over a table of the sky's light ([`visibility_mask::sky`]). A lobe that the table's samples do not resolve is divided among it and
/// finer tables, each through a [window](SkyWindow) about the lobe's axis, for which blockers draw again. Diffuse receivers that see less than an eighth of the sky
/// see all of it through the second table. Lobes that no table resolves stay, all those of receivers that see less than an eighth, or a thirty-second through
/// the second table, and those of tiles before which there are too many outlines.
#[derive(Clone, Debug)]
pub struct SkyShader<'a, B> {
    /// Each of smaller steps than the one before.
    tables: Vec<&'a SkyTable>,
    resolutions: Vec<SkyResolution>,
    /// For each light of the frame whether it is a part of the table.
    replaced: Vec<bool>,
    blockers: B,
}

impl<'a, B: SkyBlockers> SkyShader<'a, B> {
    /// Tables of one sky, each of smaller steps than the one before, the lights of the frame that they stand for, and what hides them.
    #[must_use]
    pub fn new(tables: impl IntoIterator<Item = &'a SkyTable>, replaced: Vec<bool>, blockers: B) -> Self {
        let tables: Vec<_> = tables.into_iter().collect();
        let resolutions = tables.iter().map(|table| table.meridians().resolution()).collect();
        Self { tables, resolutions, replaced, blockers }
    }

    /// The first table that resolves a lobe, or else the last one if it does so from higher views.
    fn level(&self, lobe: &BrdfLobe, normal: Vec3) -> Option<usize> {
        let first = self.resolutions.iter().position(|table| SkyView::resolves_at(*table, lobe, normal));
        let last =
            || self.resolutions.len().checked_sub(1).filter(|last| SkyView::resolves(self.resolutions[*last], lobe));
        first.or_else(last)
    }
}

/// Working memory of a [`SkyShader`].
#[derive(Clone, Debug)]
pub struct SkyScratch<S> {
    /// For each table.
    views: Vec<SkyView>,
    sums: Vec<LobeSum>,
    /// Receivers with lobes for the present table, and how they see the sky.
    receivers: Vec<Receiver>,
    horizons: Vec<Horizon>,
    /// For each receiver of the tile how much of the sky it sees.
    seen: Vec<Seen>,
    /// Which of them see so little that the second table sums all their lobes.
    again: Vec<bool>,
    blockers: S,
}

/// A lobe of a receiver, and the integrals of the sky's radiance times it, over what is seen and over all.
#[derive(Clone, Copy, Debug)]
struct LobeSum {
    receiver: usize,
    row: usize,
    lobe: BrdfLobe,
    /// About which finer tables look.
    highlight: SkyHighlight,
    /// The first table that resolves it.
    level: usize,
    seen: Vec3,
    all: Vec3,
}

/// How much of the sky a receiver sees.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    /// Nothing, and surely.
    is_shut: bool,
    /// So little that samples are too coarse: found only for receivers with narrow lobes.
    is_little: bool,
    /// So little of a sky, whatever light that gives: found where the sky is uneven, or a lobe is.
    is_small: bool,
    /// The part of the light, or of the sky, below which it is little or small.
    little: f32,
    /// So little or small for the first table, and not for the second one.
    is_for_second: bool,
}

impl Seen {
    /// By a receiver, whose lobes have been summed over one of the first two tables; from which part of the light on that has enough samples, and the next one, if there is one.
    fn of(
        sums: &[LobeSum],
        at: &Receiver,
        (table, view): (&SkyTable, &mut SkyView),
        (little, of_second): (f32, Option<f32>),
    ) -> Self {
        let mut seen = Self { is_shut: view.is_shut(), little, ..Self::default() };
        let wide = sums.iter().filter(|sum| sum.level == 0);
        let [lit, whole] = wide.fold([Vec3::ZERO; 2], |[lit, whole], sum| {
            let flux = sum.lobe.flux();
            [lit + flux * sum.seen, whole + flux * sum.all]
        });
        let may_be_small = lit.cmplt(SkyView::MUCH * whole).any() || sums.iter().all(|sum| sum.level > 0);
        // Lambert's light of an even sky says itself how much of it is seen.
        let is_diffuse = |sum: &LobeSum| matches!(sum.lobe, BrdfLobe::Cosine(lobe) if is_lambert(at, &lobe));
        let are_diffuse = sums.iter().all(is_diffuse);
        let is_unsaid = table.is_uneven() || !are_diffuse;
        let is_smaller = |part: f32| may_be_small && is_unsaid && view.is_small(part, table, at.normal);
        seen.is_small = is_smaller(little);
        // Of glossy lobes, which see an edge of a window, the second table errs by up to 9 %.
        let is_for = |part: f32| are_diffuse && !is_less([lit, whole], part) && !is_smaller(part);
        seen.is_for_second =
            !seen.is_shut && (seen.is_small || is_less([lit, whole], little)) && of_second.is_some_and(is_for);
        if sums.iter().any(|sum| sum.level > 0) {
            let lambert = Lobe::new(at.normal, 1.0, Vec3::ONE).into();
            seen.is_little = is_less(view.integrals(table, at, &lambert), little);
        }
        seen
    }

    /// Whether lobes of so much light, seen and whole, are better left to patches. Narrow ones see little of a wide sky where they reflect something else;
    /// their samples are fine enough for that, and patches are too coarse for a grain.
    fn leaves(self, is_narrow: bool, has_grain: bool, sum: &Contribution) -> bool {
        let is_little = self.is_small || is_less([sum.radiance, sum.unshadowed], self.little);
        is_little && !self.is_shut && (!is_narrow || self.is_little && !has_grain)
    }
}

/// Whether light that is seen is less than a part of the whole.
fn is_less([seen, whole]: [Vec3; 2], part: f32) -> bool {
    seen.max_element() < part * whole.max_element()
}

impl<B: SkyBlockers> SkyShader<'_, B> {
    /// Adds to all lobes what one of the tables sums: the first table for all receivers of a tile, a finer one for those with narrow
    /// lobes. Returns `false`, and adds nothing, where the tile has too many outlines.
    fn sum(
        &self,
        level: usize,
        at: &[Receiver],
        scratch: &mut SkyScratch<B::Scratch>,
        observer: &mut impl Observer,
    ) -> bool {
        let SkyScratch { views, sums, receivers, horizons, seen: all_seen, again, blockers } = scratch;
        let is_of_one = |a: &LobeSum, b: &LobeSum| a.receiver == b.receiver;
        again.clear();
        again.extend(all_seen.iter().map(|seen| level == 1 && seen.is_for_second));
        let takes_part = |own: &[LobeSum]| again[own[0].receiver] || own.iter().any(|sum| sum.level >= level);
        receivers.clear();
        receivers.extend(sums.chunk_by(is_of_one).filter(|own| takes_part(own)).map(|own| at[own[0].receiver]));
        if receivers.is_empty() {
            return true;
        }
        horizons.clear();
        horizons.extend(receivers.iter().map(|at| Horizon::new(at, self.blockers.has_facet(at))));
        let table = self.tables[level];
        let tile = SkyTile { receivers, horizons, meridians: table.meridians() };
        if !self.blockers.enter(&tile, blockers) {
            return false;
        }
        let view = &mut views[level];
        for (place, own) in sums.chunk_by_mut(is_of_one).filter(|own| takes_part(own)).enumerate() {
            let number = own[0].receiver;
            let mut last = None;
            for sum in own.iter_mut().filter(|sum| sum.level >= level) {
                let blend = SkyBlend::of_level(&self.resolutions[..=sum.level], level, sum.highlight);
                // All lobes see one whole sky; each highlight has a window of its own.
                let looks = (level > 0).then_some(sum.highlight);
                if last != Some(looks) {
                    last = Some(looks);
                    let window = self.window(level, &horizons[place], &blend);
                    self.draw((view, table), (&tile, place), window, blockers);
                    observer.end(Stage::Mask);
                }
                let [seen, all] = view.integrals_of(table, &receivers[place], &sum.lobe, blend);
                sum.seen += seen;
                sum.all += all;
            }
            let at = &receivers[place];
            if level == 0 {
                observer.coverage(view.coverage());
                let little = view.little();
                all_seen[number] = Seen::of(own, at, (table, view), (little, self.for_second()));
            } else if again[number] {
                self.draw((view, table), (&tile, place), SkyWindow::whole(self.resolutions[level]), blockers);
                observer.end(Stage::Mask);
                for sum in own.iter_mut().filter(|sum| sum.level == 0) {
                    [sum.seen, sum.all] = view.integrals_of(table, at, &sum.lobe, SkyBlend::ALL);
                }
                all_seen[number] = Seen::of(own, at, (table, view), (SkyView::LITTLE_FOR_SECOND, None));
            }
            observer.end(Stage::Integration);
        }
        true
    }

    /// From which part of the sky's light on the second table has enough samples; none where it is not [for little](SkyResolution::for_little).
    fn for_second(&self) -> Option<f32> {
        let second = self.resolutions.first()?.for_little();
        (second.is_some() && second == self.resolutions.get(1).copied()).then_some(SkyView::LITTLE_FOR_SECOND)
    }

    /// Draws what a receiver of a tile sees through a window.
    fn draw(
        &self,
        (view, table): (&mut SkyView, &SkyTable),
        (tile, place): (&SkyTile<'_>, usize),
        window: SkyWindow,
        blockers: &mut B::Scratch,
    ) {
        view.begin_in(table, tile.horizons[place], window);
        let in_doubt = view.draw(table, |buffer| self.blockers.draw(tile, place, buffer, blockers));
        view.settle(table, in_doubt, |v| self.blockers.hides(tile, place, v, blockers));
    }

    /// The part of the sky that a part of a lobe is in.
    fn window(&self, level: usize, horizon: &Horizon, blend: &SkyBlend) -> SkyWindow {
        let resolution = self.resolutions[level];
        let cone = blend.cone().map(|(axis, angle)| (horizon.pole().local(axis), angle));
        cone.map_or_else(|| SkyWindow::whole(resolution), |(axis, angle)| SkyWindow::around(resolution, axis, angle))
    }
}

impl<B: SkyBlockers> SkyLighting for SkyShader<'_, B> {
    type Scratch = SkyScratch<B::Scratch>;

    fn scratch(&self) -> Self::Scratch {
        SkyScratch {
            views: vec![SkyView::default(); self.tables.len()],
            sums: Vec::new(),
            receivers: Vec::new(),
            horizons: Vec::new(),
            seen: Vec::new(),
            again: Vec::new(),
            blockers: self.blockers.scratch(),
        }
    }

    fn replaces(&self, light: usize) -> bool {
        self.replaced.get(light).is_some_and(|replaced| *replaced)
    }

    fn place(&self) -> Option<usize> {
        self.replaced.iter().position(|replaced| *replaced)
    }

    fn tile(
        &self,
        at: &[Receiver],
        lobes: &mut TileLobes,
        threshold: f32,
        scratch: &mut Self::Scratch,
        observer: &mut impl Observer,
        out: &mut TileContributions,
    ) -> bool {
        out.begin(at.len());
        let mut is_left = false;
        scratch.sums.clear();
        scratch.seen.clear();
        scratch.seen.resize(at.len(), Seen::default());
        for (receiver, at) in at.iter().enumerate() {
            for (row, lobe) in lobes.of(receiver) {
                let Some(level) = self.level(&lobe, at.normal) else {
                    is_left = true;
                    continue;
                };
                let highlight = SkyHighlight::new(&lobe, at.normal);
                scratch.sums.push(LobeSum { receiver, row, lobe, highlight, level, seen: Vec3::ZERO, all: Vec3::ZERO });
            }
        }
        if !(0..self.tables.len()).all(|level| self.sum(level, at, scratch, observer)) {
            is_left = true;
            scratch.sums.clear();
        }
        for of_one in scratch.sums.chunk_by(|a, b| a.receiver == b.receiver) {
            let receiver = of_one[0].receiver;
            let (mut all, mut count) = (Contribution::default(), 0);
            for is_narrow in [false, true] {
                let of_kind = || of_one.iter().filter(|sum| (sum.level > 0) == is_narrow);
                let mut sum = Contribution::default();
                for LobeSum { lobe, seen, all, .. } in of_kind() {
                    let [seen, all] = [*seen, *all].map(|integral| lobe.flux() * integral);
                    sum.unshadowed += all;
                    if all.max_element() > threshold {
                        sum.radiance += seen;
                    } else if all != Vec3::ZERO {
                        observer.prune();
                    }
                }
                let has_grain = of_kind().any(|sum| sum.highlight.is_streak());
                if scratch.seen[receiver].leaves(is_narrow, has_grain, &sum) {
                    is_left = true;
                    continue;
                }
                of_kind().for_each(|sum| lobes.remove(sum.row));
                count += of_kind().count();
                all.radiance += sum.radiance;
                all.unshadowed += sum.unshadowed;
            }
            observer.count(0, count);
            out.put(receiver, &all, count);
        }
        observer.end(Stage::Integration);
        is_left
    }
}
