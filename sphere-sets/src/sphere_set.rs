use core::ops::ControlFlow;

use glam::{BVec3, Mat3, Mat4, Vec3, Vec4};
use lobe_core::{SelfShadow, Sphere};

use crate::build::Builder;
use crate::error::{BuildError, MisfitError};
use crate::options::{BuildOptions, Progress};
use crate::quality::{SetQuality, self_distance};
use crate::self_shadow::self_shadows;
use crate::solid::Solid;
use crate::surface::Surface;
use crate::tree::TriangleTree;

/// Spheres that cast the shadow of a mesh, in the mesh's own space.
///
/// ```
/// use glam::Vec3;
/// use sphere_sets::{BuildOptions, SphereSet};
///
/// let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
/// let tetrahedron = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
/// let set = SphereSet::build(&corners, &tetrahedron, &BuildOptions::new(8))?;
/// assert_eq!(set.spheres.len(), 8);
/// assert!(set.quality.silhouette_error < 0.3);
/// # Ok::<(), sphere_sets::BuildError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SphereSet {
    /// The spheres; their order means nothing.
    pub spheres: Vec<Sphere>,
    /// τ, a length: a sphere of the receiver's own object blocks a direction only if the ray leaves it farther than this
    /// from the receiver. `τ = √(2 r̄ h)`, `r̄ = Σr³/Σr²`, h the depth below the union's surface that 5 % of the mesh's
    /// surface exceeds.
    pub self_distance: f32,
    /// A distance and a smaller sphere for each sphere, fitted to shadow rays on the mesh, for receivers of the own
    /// object; empty where nothing was fitted.
    pub self_shadows: Vec<SelfShadow>,
    /// Triangles of the mesh that the set was made from.
    pub mesh_triangles: usize,
    /// Lowest and highest corner of the mesh's bounding box.
    pub mesh_bounds: [Vec3; 2],
    /// The quality of the set.
    pub quality: SetQuality,
}

impl SphereSet {
    /// Version of the builder. Increase it with every change of the output: this invalidates cached sets.
    pub const BUILDER: u32 = 9;

    /// Builds a sphere set from any triangles: closed or open, in several parts, intersecting, of mixed winding.
    ///
    /// Starts from a greedy cover by inner spheres and then lets the union's silhouettes descend to the mesh's, seen from
    /// 96 directions ([`BuildOptions::rounds`] > 0). The same input gives the same set on any number of threads.
    /// Work is about linear in the count, plus a part that is linear in the triangles.
    ///
    /// # Errors
    /// [`BuildError`] for a mesh without triangles or area, with infinite or missing vertices, or for no spheres requested.
    pub fn build(positions: &[Vec3], triangles: &[[u32; 3]], options: &BuildOptions) -> Result<Self, BuildError> {
        Self::build_with_progress(positions, triangles, options, &mut |_| ControlFlow::Continue(()))
    }

    /// [`SphereSet::build`] that reports how far it is and can be stopped.
    ///
    /// # Errors
    /// As [`SphereSet::build`], and [`BuildError::Cancelled`] if `progress` breaks off.
    pub fn build_with_progress(
        positions: &[Vec3],
        triangles: &[[u32; 3]],
        options: &BuildOptions,
        progress: &mut Progress,
    ) -> Result<Self, BuildError> {
        if options.count == 0 {
            return Err(BuildError::NoSpheres);
        }
        let surface = Surface::new(positions, triangles)?;
        let tree = TriangleTree::new(&surface.triangles);
        let mut builder = Builder::new(&surface, &tree, options.count);
        let unit = builder.build(options, progress)?;
        Ok(Self::judge(&surface, &tree, builder.solid(), triangles.len(), &unit))
    }

    /// The set of spheres in unit space, with its figures.
    pub(crate) fn judge(
        surface: &Surface,
        tree: &TriangleTree,
        solid: &Solid,
        triangles: usize,
        unit: &[Vec4],
    ) -> Self {
        Self {
            spheres: unit.iter().map(|sphere| surface.to_world(*sphere)).collect(),
            self_distance: (f64::from(self_distance(surface, unit)) * surface.diagonal) as f32,
            self_shadows: self_shadows(surface, tree, unit),
            mesh_triangles: triangles,
            mesh_bounds: surface.bounds,
            quality: SetQuality::measure(surface, tree, solid, unit),
        }
    }

    /// Measures any spheres against a mesh: how a set made elsewhere, or by hand, is judged and gets its τ.
    ///
    /// # Errors
    /// As [`SphereSet::build`] for the mesh; [`BuildError::NoSpheres`] for no spheres.
    pub fn measure(positions: &[Vec3], triangles: &[[u32; 3]], spheres: &[Sphere]) -> Result<Self, BuildError> {
        if spheres.is_empty() {
            return Err(BuildError::NoSpheres);
        }
        let surface = Surface::new(positions, triangles)?;
        let tree = TriangleTree::new(&surface.triangles);
        let solid = Solid::new(&surface, &tree, Solid::resolution_for(spheres.len()));
        let unit: Vec<Vec4> = spheres.iter().map(|sphere| surface.to_unit(*sphere)).collect();
        let set = Self::judge(&surface, &tree, &solid, triangles.len(), &unit);
        Ok(Self { spheres: spheres.to_vec(), ..set })
    }

    /// The self-shadow distance τ alone, as [`SphereSet::measure`] finds it, in a fraction of the time.
    ///
    /// # Errors
    /// As [`SphereSet::measure`].
    pub fn self_distance_of(positions: &[Vec3], triangles: &[[u32; 3]], spheres: &[Sphere]) -> Result<f32, BuildError> {
        if spheres.is_empty() {
            return Err(BuildError::NoSpheres);
        }
        let surface = Surface::new(positions, triangles)?;
        let unit: Vec<Vec4> = spheres.iter().map(|sphere| surface.to_unit(*sphere)).collect();
        Ok((f64::from(self_distance(&surface, &unit)) * surface.diagonal) as f32)
    }

    /// Whether the set was made for these triangles, as placed: their number and bounding box (to 10⁻³ of its
    /// diagonal) are the ones it stores, and no sphere lies wholly outside of the box by more than its diagonal.
    ///
    /// # Errors
    /// [`MisfitError`] names the one that differs.
    pub fn check_fits(&self, positions: &[Vec3], triangles: &[[u32; 3]]) -> Result<(), MisfitError> {
        let misfit = |message| Err(MisfitError { message });
        if triangles.len() != self.mesh_triangles {
            return misfit(format!("it had {} triangles, this one has {}", self.mesh_triangles, triangles.len()));
        }
        let corners = triangles.iter().flatten().filter_map(|i| positions.get(*i as usize));
        let bounds = corners.fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[lo, hi], p| [lo.min(*p), hi.max(*p)]);
        let [lo, hi] = self.mesh_bounds;
        let diagonal = lo.distance(hi);
        if !bounds.iter().zip(self.mesh_bounds).all(|(own, stored)| own.distance(stored) <= 1e-3 * diagonal) {
            return misfit(format!("its bounding box was {}, this one's is {}", span(self.mesh_bounds), span(bounds)));
        }
        let away = |b: &Sphere| b.center.distance(b.center.max(lo).min(hi)) - b.radius;
        match self.spheres.iter().position(|b| away(b) > diagonal) {
            Some(k) => misfit(format!("sphere {k} is far outside of its bounding box, {}", span(self.mesh_bounds))),
            None => Ok(()),
        }
    }

    /// The set of the mesh where `placement` puts it: a rotation, a translation and one scale for all axes. Radii and τ grow
    /// with the scale; how a sphere shadows its own object is in units of its radius and only turns. The box is the one around
    /// the turned box, `quality` is as it was.
    ///
    /// ```
    /// use glam::{Mat4, Vec3};
    /// # use sphere_sets::{BuildOptions, SphereSet};
    /// # let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    /// # let set = SphereSet::build(&corners, &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], &BuildOptions::new(4))?;
    /// let placed = set.placed(&(Mat4::from_translation(Vec3::Y) * Mat4::from_scale(Vec3::splat(2.0))));
    /// assert!((placed.spheres[0].radius - 2.0 * set.spheres[0].radius).abs() < 1e-6);
    /// assert_eq!(placed.mesh_bounds, [Vec3::Y, Vec3::new(2.0, 3.0, 2.0)]);
    /// # Ok::<(), sphere_sets::BuildError>(())
    /// ```
    #[must_use]
    pub fn placed(&self, placement: &Mat4) -> Self {
        let scale = placement.x_axis.truncate().length();
        let turn = Mat3::from_mat4(*placement);
        let sphere = |b: &Sphere| Sphere { center: placement.transform_point3(b.center), radius: b.radius * scale };
        let [lo, hi] = self.mesh_bounds;
        let corners = (0..8).map(|k| Vec3::select(BVec3::new(k & 1 == 1, k & 2 == 2, k & 4 == 4), hi, lo));
        let corners = corners.map(|p| placement.transform_point3(p));
        Self {
            spheres: self.spheres.iter().map(sphere).collect(),
            self_distance: self.self_distance * scale,
            self_shadows: self.self_shadows.iter().map(|own| own.turned(turn)).collect(),
            mesh_bounds: corners.fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[lo, hi], p| [lo.min(p), hi.max(p)]),
            ..*self
        }
    }
}

fn span([lo, hi]: [Vec3; 2]) -> String {
    format!("({:.4}, {:.4}, {:.4}) to ({:.4}, {:.4}, {:.4})", lo.x, lo.y, lo.z, hi.x, hi.y, hi.z)
}
