//! Small meshes and points for tests.

use glam::Vec3;

use crate::random::quasi_random;

/// A low-discrepancy point in the cube `[−½, ½]³`.
pub(crate) fn scattered(i: usize) -> Vec3 {
    quasi_random(i) - 0.5
}

/// Positions and triangles of a sphere of radius 1: the octahedron, each face split into `n²`, outward.
pub(crate) fn sphere(n: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for octant in 0..8 {
        let sign = |bit: u32| if octant >> bit & 1 == 1 { -1.0 } else { 1.0 };
        let axes = [Vec3::X * sign(0), Vec3::Y * sign(1), Vec3::Z * sign(2)];
        let outward = sign(0) * sign(1) * sign(2) > 0.0;
        let start = positions.len() as u32;
        for i in 0..=n {
            for j in 0..=n - i {
                let (a, b) = (i as f32 / n as f32, j as f32 / n as f32);
                positions.push((axes[0] * a + axes[1] * b + axes[2] * (1.0 - a - b)).normalize());
            }
        }
        let at = |i: u32, j: u32| start + i * (n + 1) - i * i.saturating_sub(1) / 2 + j;
        for i in 0..n {
            for j in 0..n - i {
                let mut push = |t: [u32; 3]| triangles.push(if outward { t } else { [t[0], t[2], t[1]] });
                push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                if i + j + 1 < n {
                    push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
            }
        }
    }
    (positions, triangles)
}

/// A closed, non-convex star shape of size about 1, as triangles.
pub(crate) fn bumpy_sphere(n: u32) -> Vec<[Vec3; 3]> {
    let (positions, triangles) = sphere(n);
    let bump = |p: Vec3| p * (0.35 + 0.12 * (5.0 * p.x).sin() * (4.0 * p.y + p.z).cos());
    triangles.iter().map(|t| t.map(|i| bump(positions[i as usize]))).collect()
}

/// The cube `[−½, ½]³`, outward.
pub(crate) fn cube() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let positions =
        (0..8).map(|i| Vec3::new((i & 1) as f32 - 0.5, (i >> 1 & 1) as f32 - 0.5, (i >> 2 & 1) as f32 - 0.5)).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    (positions, triangles)
}
