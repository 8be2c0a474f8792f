//! Meshes made by formulas.

use crate::Mesh;
use core::f32::consts::TAU;
use glam::{Quat, Vec2, Vec3};

impl Mesh {
    /// The parallelogram `center ± u ± v`; its normal is `u × v`. Textures lie on it once, upright where `v` points up.
    #[must_use]
    pub fn quad(center: Vec3, u: Vec3, v: Vec3) -> Self {
        Self {
            positions: vec![center - u - v, center + u - v, center + u + v, center - u + v],
            normals: Vec::new(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            uv_sets: vec![vec![Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO]],
            ..Self::default()
        }
    }

    /// An axis-aligned box with the given edge lengths, wound outward. Textures lie on each face once.
    #[must_use]
    pub fn cuboid(center: Vec3, size: Vec3) -> Self {
        let mut mesh = Self::default();
        let half = 0.5 * size;
        for axis in 0..3 {
            let pick = |k: usize| Vec3::AXES[(axis + k) % 3] * half;
            for sign in [-1.0, 1.0] {
                mesh.append(&Self::quad(center + sign * pick(0), sign * pick(1), pick(2)));
            }
        }
        mesh
    }

    /// A closed tube of the given radius along a closed curve, with smooth normals.
    ///
    /// The cross sections are carried along the curve by rotation-minimising steps, and the twist that is left after one
    /// turn is spread evenly. `sides ≥ 3`, and the spine has at least three points.
    #[must_use]
    pub fn closed_tube(spine: &[Vec3], radius: f32, sides: u32) -> Self {
        let n = spine.len();
        let tangent = |i: usize| (spine[(i + 1) % n] - spine[(i + n - 1) % n]).normalize_or(Vec3::X);
        let mut across = vec![tangent(0).any_orthonormal_vector()];
        for i in 1..=n {
            let turn = Quat::from_rotation_arc(tangent(i - 1), tangent(i % n));
            across.push((turn * across[i - 1]).normalize());
        }
        let (start, end, t0) = (across[0], across[n], tangent(0));
        let twist = end.cross(start).dot(t0).atan2(end.dot(start));
        let mut mesh = Self::default();
        for i in 0..n {
            let t = tangent(i);
            let u = Quat::from_axis_angle(t, twist * i as f32 / n as f32) * across[i];
            let v = t.cross(u);
            for k in 0..sides {
                let (s, c) = (TAU * k as f32 / sides as f32).sin_cos();
                let normal = (u * c + v * s).normalize();
                mesh.positions.push(spine[i] + radius * normal);
                mesh.normals.push(normal);
            }
        }
        let at = |i: usize, k: u32| (i % n) as u32 * sides + k % sides;
        for i in 0..n {
            for k in 0..sides {
                let [a, b, c, d] = [at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)];
                mesh.triangles.extend([[a, d, c], [a, c, b]]);
            }
        }
        mesh
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Signed volume: positive when the mesh is wound outward.
    fn volume(mesh: &Mesh) -> f64 {
        let p = |i: u32| mesh.positions[i as usize].as_dvec3();
        mesh.triangles.iter().map(|&[a, b, c]| p(a).dot(p(b).cross(p(c))) / 6.0).sum()
    }

    #[test]
    fn cuboid_is_closed_and_outward() {
        let mesh = Mesh::cuboid(Vec3::new(5.0, -2.0, 1.0), Vec3::new(1.0, 2.0, 3.0));
        assert!((volume(&mesh) - 6.0).abs() < 1e-5);
        assert!((mesh.area() - 22.0).abs() < 1e-5);
        assert_eq!(mesh.triangles.len(), 12);
    }

    #[test]
    fn torus_has_its_volume_and_true_normals() {
        // A torus of radii 2 and 0.5 about y: V = 2π²Rr².
        let spine: Vec<Vec3> =
            (0..200).map(|i| TAU * i as f32 / 200.0).map(|a| 2.0 * Vec3::new(a.cos(), 0.0, a.sin())).collect();
        let mesh = Mesh::closed_tube(&spine, 0.5, 64);
        mesh.validate().unwrap();
        // The inscribed polygons of 64 and 200 corners lose 0.16 % and 0.05 %.
        let want = 2.0 * core::f64::consts::PI.powi(2) * 2.0 * 0.25;
        assert!((volume(&mesh) / want - 1.0).abs() < 0.003, "{}", volume(&mesh));
        let mut smooth = mesh.clone();
        smooth.smooth_normals();
        let worst = mesh.normals.iter().zip(&smooth.normals).map(|(a, b)| a.dot(*b)).fold(1.0, f32::min);
        assert!(worst > 0.999, "{worst}");
    }
}
