use glam::Vec3;
use lobe_core::{Contribution, Observer, Receiver, Stage, TileContributions, TileLobes};
use visibility_mask::sky::{Horizon, SkyBlockers, SkyTable, SkyTile, SkyView};

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
/// lobe is summed over a table of the sky's light ([`visibility_mask::sky`]). Lobes that the table's samples do not resolve stay,
/// and all those of receivers that see less than an eighth of the sky.
#[derive(Clone, Debug)]
pub struct SkyShader<'a, B> {
    table: &'a SkyTable,
    /// For each light of the frame whether it is a part of the table.
    replaced: Vec<bool>,
    blockers: B,
}

impl<'a, B: SkyBlockers> SkyShader<'a, B> {
    /// A table, the lights of the frame that it stands for, and what hides them.
    #[must_use]
    pub const fn new(table: &'a SkyTable, replaced: Vec<bool>, blockers: B) -> Self {
        Self { table, replaced, blockers }
    }
}

/// Working memory of a [`SkyShader`].
#[derive(Clone, Debug)]
pub struct SkyScratch<S> {
    view: SkyView,
    horizons: Vec<Horizon>,
    blockers: S,
}

impl<B: SkyBlockers> SkyLighting for SkyShader<'_, B> {
    type Scratch = SkyScratch<B::Scratch>;

    fn scratch(&self) -> Self::Scratch {
        SkyScratch { view: SkyView::default(), horizons: Vec::new(), blockers: self.blockers.scratch() }
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
        let SkyScratch { view, horizons, blockers } = scratch;
        out.begin(at.len());
        horizons.clear();
        horizons.extend(at.iter().map(|at| Horizon::new(at, self.blockers.has_facet(at))));
        let tile = SkyTile { receivers: at, horizons, meridians: self.table.meridians() };
        self.blockers.enter(&tile, blockers);
        let mut is_left = false;
        let mut resolved = Vec::new();
        for (number, at) in at.iter().enumerate() {
            resolved.clear();
            resolved.extend(lobes.of(number).filter(|(_, lobe)| SkyView::resolves(self.table, lobe)));
            is_left |= resolved.len() < lobes.of(number).count();
            if resolved.is_empty() {
                continue;
            }
            view.begin(self.table, tile.horizons[number]);
            let in_doubt = self.blockers.draw(&tile, number, view.buffer_mut(), blockers);
            view.settle(self.table, in_doubt, |v| self.blockers.hides(&tile, number, v, blockers));
            observer.coverage(view.coverage());
            observer.end(Stage::Mask);
            let mut sum = Contribution::default();
            for (_, lobe) in &resolved {
                let [seen, all] = view.integrals(self.table, at, lobe).map(|integral| lobe.flux() * integral);
                sum.unshadowed += all;
                if all.max_element() > threshold {
                    sum.radiance += seen;
                } else if all != Vec3::ZERO {
                    observer.prune();
                }
            }
            if view.is_little(sum.radiance, sum.unshadowed) {
                is_left = true;
                continue;
            }
            resolved.iter().for_each(|(row, _)| lobes.remove(*row));
            observer.count(0, resolved.len());
            observer.end(Stage::Integration);
            out.put(number, &sum, resolved.len());
        }
        is_left
    }
}
