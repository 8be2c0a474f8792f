use glam::{Vec3, Vec4};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::bits::BitImage;
use crate::options::BuildOptions;
use crate::random::{fibonacci, quasi_random};
use crate::solid::Solid;
use crate::surface::Surface;
use crate::tree::TriangleTree;
use crate::view::Frame;

/// How well a sphere set stands for its mesh. D is the diagonal of the mesh's bounding box.
///
/// Volumes come from 2¹⁷ and lengths from about 2·10⁴ low-discrepancy points, so the last digits are the points'; the
/// same set has the same figures everywhere. Inside means |winding number| > ½.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SetQuality {
    /// `|mesh ∩ union| / |mesh|`; for a mesh without volume the fraction of its surface inside the union.
    pub coverage: f32,
    /// `|union \ mesh| / |mesh|`; for a mesh without volume `|union| / D³`.
    pub protrusion_volume: f32,
    /// Largest distance from the union's exposed surface, where it is outside the mesh, to the mesh, over D.
    pub hausdorff_outside: f32,
    /// 95th percentile of the distance from the mesh's surface to the union, over D.
    pub p95_gap: f32,
    /// Mean over 64 directions of `area(S_mesh xor S_union)/area(S_mesh)`, S the silhouettes of parallel projections.
    pub silhouette_error: f32,
}

/// The verdict of [`SetQuality::verdict`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It stands well enough for its mesh.
    Suits,
    /// More spheres would.
    FewSpheres,
    /// A full descent would; this was a draft.
    Draft,
    /// It is a bound, which no number of spheres makes tight; for an open mesh it may fill the inside as well.
    Bounding,
    /// Spheres do not suit the mesh: its shadows are better cast by its triangles.
    Unsuitable,
}

const VOLUME_POINTS: usize = 1 << 17;
const SURFACE_POINTS: usize = 20_000;
const DIRECTIONS: usize = 64;
const PIXELS: usize = 768;

/// Fraction of the mesh's surface that may lie deeper below the union's surface than `h` of [`self_distance`].
const DEEPER: f32 = 0.05;

impl SetQuality {
    /// Silhouette error above which spheres do not suit a mesh: its shadows are better cast by its triangles.
    pub const UNSUITABLE: f32 = 0.15;

    /// Whether the spheres are good enough to replace the mesh: `silhouette_error` ≤ [`Self::UNSUITABLE`].
    #[must_use]
    pub fn suits(&self) -> bool {
        self.silhouette_error <= Self::UNSUITABLE
    }

    /// Whether the set is good enough to replace its mesh, and the reason if not.
    ///
    /// Errors fall about as `n^−0.66` in the number of spheres (the bunny: 0.0667 with 16, 0.0271 with 64) and to a third by
    /// the full descent. If the error predicted for 64 spheres is still above [`Self::UNSUITABLE`], the mesh does not
    /// suit spheres.
    #[must_use]
    pub fn verdict(&self, options: &BuildOptions) -> Verdict {
        let ample = (options.count as f32 / 64.0).min(1.0).powf(0.66);
        let full = if options.rounds == 0 { 1.0 / 3.0 } else { 1.0 };
        if self.suits() {
            Verdict::Suits
        } else if self.silhouette_error * ample * full > Self::UNSUITABLE && !options.bounding {
            Verdict::Unsuitable
        } else if options.rounds == 0 {
            Verdict::Draft
        } else if options.bounding {
            Verdict::Bounding
        } else {
            Verdict::FewSpheres
        }
    }

    /// The silhouette error alone, of spheres in unit space.
    pub(crate) fn silhouette_error_of(surface: &Surface, spheres: &[Vec4]) -> f32 {
        let errors: Vec<f64> = (0..DIRECTIONS)
            .into_par_iter()
            .map_init(
                || (BitImage::new(PIXELS), BitImage::new(PIXELS)),
                |(mesh, set), i| {
                    let corners = surface.triangles.iter().flatten().map(|p| (*p, 0.0));
                    let all = spheres.iter().map(|sphere| (sphere.truncate(), sphere.w));
                    let frame = Frame::new(fibonacci(i, DIRECTIONS), corners.chain(all), 1e-3, PIXELS);
                    mesh.clear();
                    set.clear();
                    frame.draw_mesh(&surface.triangles, mesh);
                    frame.draw_spheres(spheres, set);
                    f64::from(mesh.differences(set)) / f64::from(mesh.count().max(1))
                },
            )
            .collect();
        (errors.iter().sum::<f64>() / DIRECTIONS as f64) as f32
    }

    /// Measures spheres in unit space.
    pub(crate) fn measure(surface: &Surface, tree: &TriangleTree, solid: &Solid, spheres: &[Vec4]) -> Self {
        let (mesh, both, alone, domain) = volumes(surface, tree, solid, spheres);
        let gaps = surface_distances(surface, spheres);
        let n = gaps.len();
        // Fewer points than this say nothing about a volume.
        let hollow = mesh < 32;
        let covered = gaps.iter().filter(|gap| **gap <= 0.0).count() as f32 / n as f32;
        let point = domain / VOLUME_POINTS as f32;
        Self {
            coverage: if hollow { covered } else { both as f32 / mesh as f32 },
            protrusion_volume: if hollow { alone as f32 * point } else { alone as f32 / mesh as f32 },
            hausdorff_outside: protrusion(tree, solid, spheres),
            p95_gap: gaps[(n * 95 / 100).min(n - 1)].max(0.0),
            silhouette_error: Self::silhouette_error_of(surface, spheres),
        }
    }
}

/// The distance τ that a ray must go before the object's own spheres may block it, in units of D: `τ = √(2 r̄ h)`,
/// `r̄ = Σr³/Σr²`, h the depth below the union's surface that 5 % of the mesh's surface exceeds.
pub(crate) fn self_distance(surface: &Surface, spheres: &[Vec4]) -> f32 {
    let gaps = surface_distances(surface, spheres);
    let h = (-gaps[(gaps.len() as f32 * DEEPER) as usize]).max(0.0);
    let (cubes, squares) =
        spheres.iter().fold((0.0, 0.0), |(c, s), sphere| (c + sphere.w.powi(3), s + sphere.w.powi(2)));
    if squares > 0.0 { (2.0 * cubes / squares * h).sqrt() } else { 0.0 }
}

/// `min_i |p − c_i| − r_i`: the distance to the union outside it, minus a lower bound of the depth inside.
fn union_distance(spheres: &[Vec4], p: Vec3) -> f32 {
    spheres.iter().map(|sphere| sphere.truncate().distance(p) - sphere.w).fold(f32::INFINITY, f32::min)
}

/// Points in the mesh, in mesh and union, in the union alone, of `VOLUME_POINTS` in a box of the returned volume.
fn volumes(surface: &Surface, tree: &TriangleTree, solid: &Solid, spheres: &[Vec4]) -> (usize, usize, usize, f32) {
    let [mut lo, mut hi] = surface.unit_bounds();
    for sphere in spheres {
        lo = lo.min(sphere.truncate() - sphere.w);
        hi = hi.max(sphere.truncate() + sphere.w);
    }
    let (mesh, both, alone) = (0..VOLUME_POINTS)
        .into_par_iter()
        .map(|i| {
            let p = lo + quasi_random(i) * (hi - lo);
            let (mesh, set) = (solid.contains(tree, p), union_distance(spheres, p) <= 0.0);
            (usize::from(mesh), usize::from(mesh && set), usize::from(set && !mesh))
        })
        .reduce(|| (0, 0, 0), |a, b| (a.0 + b.0, a.1 + b.1, a.2 + b.2));
    (mesh, both, alone, (hi - lo).element_product())
}

/// [`union_distance`] at points spread evenly over the mesh's surface, ascending.
fn surface_distances(surface: &Surface, spheres: &[Vec4]) -> Vec<f32> {
    let spread = surface.spread();
    let mut distances: Vec<f32> = (0..SURFACE_POINTS)
        .into_par_iter()
        .map(|i| {
            let (t, [u, v, w]) = spread(quasi_random(i));
            let [a, b, c] = surface.triangles[t];
            union_distance(spheres, a * u + b * v + c * w)
        })
        .collect();
    distances.sort_by(f32::total_cmp);
    distances
}

/// Largest distance to the mesh from points of the union's exposed surface outside the mesh.
fn protrusion(tree: &TriangleTree, solid: &Solid, spheres: &[Vec4]) -> f32 {
    let area: f32 = spheres.iter().map(|sphere| sphere.w * sphere.w).sum();
    if area <= 0.0 {
        return 0.0;
    }
    spheres
        .par_iter()
        .map(|sphere| {
            let points = ((SURFACE_POINTS as f32 * sphere.w * sphere.w / area) as usize).max(64);
            let mut most = 0.0_f32;
            for i in 0..points {
                let p = sphere.truncate() + fibonacci(i, points) * sphere.w;
                if union_distance(spheres, p) >= -1e-5 * sphere.w && !solid.contains(tree, p) {
                    most = most.max(tree.distance(p, f32::INFINITY));
                }
            }
            most
        })
        .reduce(|| 0.0, f32::max)
}
