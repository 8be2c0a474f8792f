use crate::shadow_tree::{ShadowNode, ShadowTree};
use crate::{CapTable, Tables};
use glam::Vec3;
use lobe_core::{Cone, Lobe, Sphere};
use visibility_mask::{MAX_DEPTH, UnitSquare};

/// Levels of the deepest quad-tree.
pub(crate) const LEVELS: usize = MAX_DEPTH as usize + 1;

/// The weights `w_i` of the paper's visibility lobes (Eq. 38), by distance of the unit square and level of the quad-tree.
///
/// # Objective
/// The paper sets them by eye: the first level for "a perfect dark in the umbra area", each next one without a step from the one
/// before. Here they are solved for. A Lambert receiver faces the light, and nodes of one level `l`, all those that touch its disc,
/// cover it from rim to rim. Its radiance must then be zero, `w_l · Σᵢ ∫ (f̃·L)·cᵢ dv = ∫ f̃·L dv`, with the table's own products:
/// one equation a level. A full cover is zero at every level, so a shadow keeps its strength when nodes merge; `tests/visibility.rs`
/// measures the change of a single merge (at most 0.8 % of the light). The weights include the overlap of the lobes, the light
/// outside the square and the errors of the tables.
///
/// # Domain
/// Linear in `dist = 1/(2 tan θ)` between [`DISTANCES`](Self::DISTANCES), as printed; the first and last weights apply outside
/// (half-angles above 63° and below 2.9°, which the paper leaves open).
#[derive(Clone, Debug, PartialEq)]
pub struct PaperWeights {
    depth: u32,
    by_distance: [[f32; LEVELS]; Self::DISTANCES.len()],
}

impl PaperWeights {
    /// The distances for which weights are solved (§5.3), of a square of side 1 around the light's cone.
    pub const DISTANCES: [f32; 12] = [0.25, 0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0];

    /// Solves for the weights of a quad-tree of the given depth, clamped to 1…[`MAX_DEPTH`].
    ///
    /// About `12 · 4^depth` products: milliseconds. Independent of the scene; solve once.
    #[must_use]
    pub fn solve(depth: u32, tables: &Tables) -> Self {
        let tree = ShadowTree::uncovered(depth);
        let depth = tree.depth();
        let by_distance = Self::DISTANCES.map(|dist| {
            let tan = 0.5 / dist;
            let cone = Cone { axis: Vec3::Z, one_minus_cos: one_minus_cos(tan), distance: f32::INFINITY };
            let square = UnitSquare::facing(&cone, Vec3::X);
            let lambert = Lobe::new(cone.axis, 1.0, Vec3::ONE);
            let seen = tables.product(&lambert, &tables.light_lobe(&cone, Vec3::ONE));
            let covered = |level: u32| -> f64 {
                let lobes = tree.cover(level).map(|node| node_lobe(&square, node, &tables.caps));
                lobes.map(|c| f64::from(tables.product(&seen, &c).flux.x)).sum()
            };
            let unshadowed = f64::from(seen.flux.x);
            let weight = |level: usize| {
                if level > depth as usize { 0.0 } else { (unshadowed / covered(level as u32)) as f32 }
            };
            core::array::from_fn(weight)
        });
        Self { depth, by_distance }
    }

    /// Packs the weights for the WGSL of [`wgsl::VISIBILITY`](crate::wgsl::VISIBILITY), which reads them after the pairs of
    /// [`Tables::pack`](Tables::pack): level by level for each distance, two in a pair.
    #[must_use]
    pub fn pack(&self) -> Vec<[f32; 2]> {
        let weights = self.by_distance.as_flattened();
        weights.chunks(2).map(|pair| [pair[0], pair.get(1).copied().unwrap_or(0.0)]).collect()
    }

    /// Depth of the quad-tree that these weights are for.
    #[must_use]
    pub fn depth(&self) -> u32 {
        self.depth
    }

    /// `w_i` of a node of the given level (0 the root) with the unit square at `dist`.
    ///
    /// # Panics
    /// If `level` is above [`MAX_DEPTH`].
    #[must_use]
    pub fn weight(&self, level: u32, dist: f32) -> f32 {
        self.at(dist)[level as usize]
    }

    /// The weights of all levels.
    pub(crate) fn at(&self, dist: f32) -> [f32; LEVELS] {
        let last = Self::DISTANCES.len() - 1;
        let above = Self::DISTANCES.partition_point(|d| *d <= dist).clamp(1, last);
        let (d0, d1) = (Self::DISTANCES[above - 1], Self::DISTANCES[above]);
        let t = ((dist - d0) / (d1 - d0)).clamp(0.0, 1.0);
        let (w0, w1) = (&self.by_distance[above - 1], &self.by_distance[above]);
        core::array::from_fn(|level| w0[level] + t * (w1[level] - w0[level]))
    }
}

/// `1 − cos θ` from `tan θ` without cancellation.
fn one_minus_cos(tan: f32) -> f32 {
    let cos = (1.0 + tan * tan).sqrt().recip();
    tan * tan * cos * cos / (1.0 + cos)
}

/// The lobe of one shadow node, scale 1 (Eqs. 34, 35): the lobe of the sphere around the node's square (Fig. 10).
pub(crate) fn node_lobe(square: &UnitSquare, node: ShadowNode, caps: &CapTable) -> Lobe {
    let half = square.half.x / (1u32 << node.level) as f32;
    let at = |k: usize| (2 * k + 1) as f32 * half - square.half.x;
    let radius = core::f32::consts::SQRT_2 * half;
    let cone = Cone::of_sphere(Vec3::ZERO, Sphere { center: Vec3::new(at(node.x), at(node.y), 1.0), radius });
    caps.occluder(&Cone { axis: square.world(cone.axis).normalize(), ..cone })
}
