//! Smooth terminators: receivers on coarse meshes raised onto the surface that their normals describe.

use super::World;
use super::packet::SPHERE;
use glam::{DVec3, Vec3};
use lobe_core::Receiver;
use scene::Shape;

impl World<'_> {
    /// Raises a point of a smooth triangle onto the rounded surface that the normals of its corners describe, and lets the smooth normal
    /// be its horizon:
    ///
    /// ```text
    /// p' = p + Σ bᵢ · max((vᵢ − p)·nᵢ, 0) · nᵢ
    /// ```
    ///
    /// (J. Hanika, *Hacking the Shadow Terminator*, Ray Tracing Gems II, 2021), `bᵢ` the point's barycentric coordinates, `nᵢ` the normals on
    /// the seen side. Where the surface is hollow nothing is raised. `smooth` is the receiver's interpolated normal, before any normal map.
    /// Spheres, flat triangles and points whose smooth normal looks away from the eye stay as they are.
    pub(crate) fn raise(&self, found: u32, smooth: Vec3, at: &mut Receiver) {
        if found & SPHERE != 0 || smooth == at.face {
            return;
        }
        let (object, index) = self.triangle_name(found);
        let shape = &self.scene.objects[object as usize].shape;
        let (Some(corners), Some(normals)) = (shape.corners(index as usize), corner_normals(shape, index as usize))
        else {
            return;
        };
        let (v, p) = (corners.map(Vec3::as_dvec3), at.position.as_dvec3());
        let n = normals.map(|n| {
            let n = n.as_dvec3().normalize_or_zero();
            if n.dot(at.face.as_dvec3()) < 0.0 { -n } else { n }
        });
        let Some(b) = barycentric(&v, p) else { return };
        let raised: DVec3 = (0..3).map(|i| n[i] * (b[i] * (v[i] - p).dot(n[i]).max(0.0))).sum();
        at.position = (p + raised).as_vec3();
        at.face = smooth;
    }
}

/// The normals at a triangle's corners, of any length; none of a flat mesh.
fn corner_normals(shape: &Shape, triangle: usize) -> Option<[Vec3; 3]> {
    match shape {
        Shape::Mesh(mesh) if !mesh.normals.is_empty() => {
            Some(mesh.triangles.get(triangle)?.map(|i| mesh.normals[i as usize]))
        }
        Shape::Instances(instances) if !instances.mesh().normals.is_empty() => {
            let (matrix, vertices) = instances.triangle(triangle);
            Some(vertices.map(|i| instances.normal(matrix, i)))
        }
        _ => None,
    }
}

/// The coordinates of the point of a triangle that is nearest to a point of its plane; none of a triangle without area.
fn barycentric([a, b, c]: &[DVec3; 3], p: DVec3) -> Option<[f64; 3]> {
    let (u, v, w) = (b - a, c - a, p - a);
    let n = u.cross(v);
    let area = n.length_squared();
    if area.is_nan() || area <= 0.0 {
        return None;
    }
    let second = (w.cross(v).dot(n) / area).clamp(0.0, 1.0);
    let third = (u.cross(w).dot(n) / area).clamp(0.0, 1.0 - second);
    Some([1.0 - second - third, second, third])
}
