use glam::{Mat3, Mat4, Vec3};
use lobe_core::{SelfShadow, Sphere};

use crate::error::BindError;
use crate::sphere_set::SphereSet;

/// Joints that carry a sphere at most.
pub(crate) const CARRIERS: usize = 4;

/// A sphere set that follows the bones of its mesh: made by [`SphereSet::bind`], posed by [`BoundSet::pose`].
///
/// A sphere rides on a patch of the mesh's surface around it. Under linear blend skinning the centroid of a patch,
/// `Σ_v a_v Σ_j w_vj J_j p_v`, is exactly `Σ_j w_j J_j c_j` with `w_j = Σ_v a_v w_vj` and `c_j` the part of the centroid
/// that joint j carries: so each sphere has up to four joints, with a weight and a point *each*, and one multiplication
/// per joint takes it where the deformed surface is.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundSet {
    pub(crate) rest: SphereSet,
    pub(crate) spheres: Vec<BoundSphere>,
    /// Per morph target, per sphere: the target's offset at weight 1.
    pub(crate) targets: Vec<Vec<Morph>>,
}

/// The joints and weights that carry one sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BoundSphere {
    /// Joints, by falling weight.
    pub(crate) joints: [u16; CARRIERS],
    /// Non-negative, of sum 1; 0 where fewer joints carry the sphere.
    pub(crate) weights: [f32; CARRIERS],
    /// The centre as each joint sees it, in bind space.
    pub(crate) points: [Vec3; CARRIERS],
    /// In bind space.
    pub(crate) radius: f32,
    /// The offset of its near sphere ([`SelfShadow`]) in bind space, as long as at rest.
    pub(crate) offset: Vec3,
}

/// The motion and growth of a sphere by a morph target, in bind space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Morph {
    pub(crate) points: [Vec3; CARRIERS],
    pub(crate) radius: f32,
}

impl BoundSet {
    /// The set as it was bound: in the pose of the rest matrices.
    #[must_use]
    pub const fn rest(&self) -> &SphereSet {
        &self.rest
    }

    /// Joints that [`BoundSet::pose`] needs: one more than the highest that carries a sphere.
    #[must_use]
    pub fn joints(&self) -> usize {
        let used = self.spheres.iter().flat_map(|s| s.joints.iter().zip(s.weights).filter(|(_, w)| *w > 0.0));
        used.map(|(joint, _)| usize::from(*joint) + 1).max().unwrap_or(0)
    }

    /// Morph targets that [`BoundSet::pose`] needs weights of.
    #[must_use]
    pub fn targets(&self) -> usize {
        self.targets.len()
    }

    /// Replaces `out` by the spheres in a pose, and `own` by how their object's own receivers see them: `joints` take bind
    /// space to the world, `morph` are the weights of the morph targets.
    ///
    /// A radius is that in bind space times `|det Σ_j w_j J_j|^⅓`: spheres shrink and stretch with the surface, and rigid
    /// motion moves them exactly. Near spheres turn with the bones ([`SelfShadow::turned`]). A sphere whose matrices are
    /// singular has radius 0. The spheres are finite for any matrices. Their number and order are those of the
    /// set. O(spheres × (4 + targets)), no allocation once `out` is large enough. `own` stays empty for a set without
    /// self-shadows.
    ///
    /// # Errors
    /// [`BindError::Missing`] for fewer joints or morph weights than the set needs; both lists are left as they are.
    pub fn pose(
        &self,
        joints: &[Mat4],
        morph: &[f32],
        out: &mut Vec<Sphere>,
        own: &mut Vec<SelfShadow>,
    ) -> Result<(), BindError> {
        at_least("joints", joints.len(), self.joints())?;
        at_least("morph weights", morph.len(), self.targets.len())?;
        out.clear();
        own.clear();
        for (i, sphere) in self.spheres.iter().enumerate() {
            let (mut points, mut radius) = (sphere.points, sphere.radius);
            for (target, &weight) in self.targets.iter().zip(morph).filter(|(_, weight)| **weight != 0.0) {
                radius += weight * target[i].radius;
                for (point, add) in points.iter_mut().zip(target[i].points) {
                    *point += weight * add;
                }
            }
            let (mut center, mut blend) = (Vec3::ZERO, Mat3::ZERO);
            for (k, &weight) in sphere.weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
                let joint = &joints[usize::from(sphere.joints[k])];
                center += weight * joint.transform_point3(points[k]);
                blend += Mat3::from_mat4(*joint) * weight;
            }
            let radius = radius.max(0.0) * stretch(blend.as_dmat3()) as f32;
            let finite = center.is_finite() && radius.is_finite();
            out.push(if finite { Sphere { center, radius } } else { Sphere::default() });
            if let Some(rest) = self.rest.self_shadows.get(i) {
                own.push(SelfShadow { offset: sphere.offset, ..*rest }.turned(blend));
            }
        }
        Ok(())
    }
}

/// The cube root of a matrix's change of volume: the radius of a sphere as large as the unit sphere's image.
pub(crate) fn stretch(matrix: glam::DMat3) -> f64 {
    matrix.determinant().abs().cbrt()
}

pub(crate) const fn at_least(what: &'static str, found: usize, needed: usize) -> Result<(), BindError> {
    if found < needed { Err(BindError::Missing { what, found, needed }) } else { Ok(()) }
}
