use crate::shadow_tree::{ShadowNode, ShadowTree};
use crate::weights::node_lobe;
use crate::{PaperWeights, Tables};
use glam::Vec3;
use lobe_core::{Lobe, VisibilitySum};
use shading::{Coverage, Shaft, Visibility, VisibilityLobes, VisibilityQuery};
use std::sync::OnceLock;
use visibility_mask::{Blockers, MAX_DEPTH, Mask, UnitSquare, mask_depth};

/// The paper's visibility (§5.3): shadow nodes of a quad-tree as least-squares lobes, for any [`Blockers`].
///
/// `V = 1 − Σ wᵢcᵢ` (Eq. 38): one lobe of scale 1 for each shadow node, the lobe of the sphere around the node's square (Eqs. 34,
/// 35, Fig. 10), times a weight by level and distance ([`PaperWeights`]). A leaf is in shadow if it is wholly covered; partly
/// covered leaves are ignored; a node whose leaves are all in shadow is one node. The same sum serves every reflectance lobe. For
/// [`PaperIntegrator`](crate::PaperIntegrator): the weights assume that the table gives `f̃·L` first.
///
/// # Decisions that the paper leaves open
/// - Leaves of the unit square outside the light's disc need not be covered and have no lobe: full cover is one root node, whatever
///   the square's corners show.
/// - "Wholly covered" is decided on two row lines through each leaf, exactly along them (one line at depth 6).
/// - The receiver's horizon plays no part; the reflectance lobe ends there.
/// - The square's sides follow the world's X axis, so that neighbouring receivers turn their squares alike.
///
/// # Cost
/// One mask of depth + 1 for each receiver that any blocker may shade, in the umbra too, and one lobe for each shadow node.
///
/// # Accuracy
/// Mean error of V in penumbrae over random blockers, in % (in brackets the bias; `tests/visibility.rs` measures):
///
/// | half-angle | Lambert, depth 4 | 5 | 6 | Phong 20, depth 4 | 5 | 6 |
/// |---|---|---|---|---|---|---|
/// | 1° | 6.0 (+6.0) | 3.9 (+3.9) | 2.6 (+2.5) | 6.1 (+6.1) | 4.0 (+4.0) | 2.8 (+2.7) |
/// | 6° | 3.4 (+3.3) | 1.7 (+1.1) | 1.6 (−0.4) | 2.9 (+2.2) | 2.2 (0.0) | 2.5 (−1.5) |
/// | 15° | 3.7 (+3.6) | 2.0 (+1.4) | 1.7 (−0.1) | 4.8 (+1.0) | 4.8 (−1.3) | 5.1 (−2.7) |
///
/// # Limits
/// A baseline, reproduced. Partly covered leaves let light through. Lobes reach beyond their nodes, so a reflectance lobe about as
/// narrow as the light gains nothing from depth. Lights under 2.9° use the weights of 2.9°, but the product table is too coarse for
/// their lobes: a full cover by level-1 nodes leaves 10 % of the light at 1°, one by leaves a third at 0.25°. `MaskVisibility` has
/// none of these limits.
#[derive(Clone, Debug)]
pub struct PaperVisibility<'t, B> {
    blockers: B,
    tables: &'t Tables,
    /// By depth, solved for at their first use.
    weights: [OnceLock<PaperWeights>; MAX_DEPTH as usize + 1],
}

impl<'t, B: Blockers> PaperVisibility<'t, B> {
    /// Quad-trees of the depth of a query's accuracy, clamped to 1…[`MAX_DEPTH`]; the paper uses 4 or 5. The first query of a depth
    /// solves for the weights, which takes milliseconds: [`with_weights`](Self::with_weights) takes solved ones.
    #[must_use]
    pub fn new(blockers: B, tables: &'t Tables) -> Self {
        Self { blockers, tables, weights: Default::default() }
    }

    /// Uses weights of a depth that were solved before.
    #[must_use]
    pub fn with_weights(mut self, weights: PaperWeights) -> Self {
        let depth = weights.depth() as usize;
        self.weights[depth] = OnceLock::from(weights);
        self
    }

    /// The blockers.
    pub fn blockers(&self) -> &B {
        &self.blockers
    }

    /// The weights of a depth.
    pub fn weights(&self, depth: u32) -> &PaperWeights {
        let depth = depth.clamp(1, MAX_DEPTH);
        self.weights[depth as usize].get_or_init(|| PaperWeights::solve(depth, self.tables))
    }
}

/// Working memory of [`PaperVisibility`].
#[derive(Clone, Debug)]
pub struct PaperScratch<S> {
    blockers: S,
    mask: Mask,
    tree: ShadowTree,
    nodes: Vec<ShadowNode>,
    sum: VisibilitySum,
}

impl<S> PaperScratch<S> {
    /// The unit square of the last receiver.
    #[must_use]
    pub fn square(&self) -> &UnitSquare {
        self.mask.square()
    }

    /// Its shadow nodes, in the order of its lobes.
    #[must_use]
    pub fn nodes(&self) -> &[ShadowNode] {
        &self.nodes
    }
}

impl<B: Blockers> Visibility for PaperVisibility<'_, B> {
    type Scratch = PaperScratch<B::Scratch>;

    fn scratch(&self) -> Self::Scratch {
        PaperScratch {
            blockers: self.blockers.scratch(),
            mask: Mask::default(),
            tree: ShadowTree::uncovered(1),
            nodes: Vec::new(),
            sum: VisibilitySum::default(),
        }
    }

    fn enter(&self, shaft: &Shaft, scratch: &mut Self::Scratch) -> Coverage {
        self.blockers.enter(shaft, &mut scratch.blockers)
    }

    /// [`Coverage::Lit`] if no leaf is in shadow. An umbra is [`Coverage::Partial`]: the paper sums its root lobe.
    /// [`Coverage::Dark`] only for a point light, which has no square.
    fn coverage(&self, query: &VisibilityQuery<'_>, scratch: &mut Self::Scratch) -> Coverage {
        scratch.nodes.clear();
        if query.cone.one_minus_cos > 1.0 {
            return Coverage::Lit;
        }
        let selected = self.blockers.select(query, &mut scratch.blockers);
        if selected == Coverage::Lit {
            return Coverage::Lit;
        }
        if query.cone.one_minus_cos <= 0.0 {
            return Coverage::Dark;
        }
        let depth = mask_depth(query.accuracy);
        if scratch.tree.depth() != depth {
            scratch.tree = ShadowTree::uncovered(depth);
        }
        let square = UnitSquare::facing(query.cone, Vec3::X);
        scratch.mask.reset(&square, scratch.tree.mask_depth(), square.axis);
        if selected == Coverage::Dark {
            scratch.mask.block_all();
        } else {
            self.blockers.splat(query, &mut scratch.blockers, &mut scratch.mask);
        }
        scratch.tree.read(&scratch.mask);
        scratch.tree.shadows(&mut scratch.nodes);
        if scratch.nodes.is_empty() { Coverage::Lit } else { Coverage::Partial }
    }

    /// The fraction of the [lobes](VisibilityLobes::lobes), by closed products.
    fn fraction(&self, query: &VisibilityQuery<'_>, brdf: &Lobe, unshadowed: f32, scratch: &mut Self::Scratch) -> Vec3 {
        let mut sum = core::mem::take(&mut scratch.sum);
        let fraction = self.fraction_of_lobes(query, brdf, unshadowed, scratch, &mut sum);
        scratch.sum = sum;
        fraction
    }
}

impl<B: Blockers> VisibilityLobes for PaperVisibility<'_, B> {
    fn lobes(
        &self,
        query: &VisibilityQuery<'_>,
        _brdf: &Lobe,
        _unshadowed: f32,
        scratch: &mut Self::Scratch,
        out: &mut VisibilitySum,
    ) {
        let square = scratch.mask.square();
        let weights = self.weights(query.accuracy.depth).at(0.5 / square.disc);
        out.clear(1.0);
        out.lobes.writer().extend(scratch.nodes.iter().map(|&node| {
            let lobe = node_lobe(square, node, &self.tables.caps);
            Lobe { flux: lobe.flux * -weights[node.level as usize], ..lobe }
        }));
    }
}
