//! Spheres as triangles.

use glam::Vec3;
use lobe_core::Sphere;
use scene::Mesh;
use std::collections::HashMap;

/// Triangles of one sphere: at least and at most this number of steps along an edge of an icosahedron.
const STEPS: [u32; 2] = [8, 32];

/// The steps of a sphere as large as the whole: its triangles are a 1800th of its radius inside of it, at most.
const WHOLE: f32 = 24.0;

/// The triangles that all spheres of a scene may have together.
const MOST: f32 = 1e6;

/// Steps along an edge for spheres of that radius in a scene of that size: `24 √(r/size)`, so that the distance of triangles and spheres is the
/// same everywhere. Of `count` spheres each has fewer where all would have too many.
pub(crate) fn steps(radius: f32, size: f32, count: usize) -> u32 {
    let steps = WHOLE * (radius / size.max(f32::MIN_POSITIVE)).sqrt();
    let steps = if steps.is_finite() { (steps.ceil() as u32).clamp(STEPS[0], STEPS[1]) } else { STEPS[0] };
    let most = (MOST / (20.0 * count.max(1) as f32)).sqrt() as u32;
    steps.min(most.max(1))
}

/// Adds a sphere to a mesh: the triangles of an icosahedron, each divided into `steps`², all corners on the sphere.
pub(crate) fn add(mesh: &mut Mesh, sphere: &Sphere, steps: u32) {
    let mut known: HashMap<[u32; 3], u32> = HashMap::new();
    let corners = icosahedron();
    for (a, b, c) in faces(&corners) {
        let mut row_before: Vec<u32> = Vec::new();
        for i in 0..=steps {
            let row: Vec<u32> = (0..=i)
                .map(|j| {
                    // Sums of the same products on both sides of an edge.
                    let weights = [steps - i, i - j, j].map(|k| k as f32 / steps as f32);
                    let parts = [(a, weights[0]), (b, weights[1]), (c, weights[2])];
                    let mut parts = parts.map(|(corner, weight)| (corner, corners[corner] * weight));
                    parts.sort_by_key(|(corner, part)| (*part == Vec3::ZERO, *corner));
                    let normal = parts.iter().map(|(_, part)| *part).sum::<Vec3>().normalize();
                    *known.entry((normal + 0.0).to_array().map(f32::to_bits)).or_insert_with(|| {
                        mesh.positions.push(sphere.center + normal * sphere.radius);
                        mesh.normals.push(normal);
                        mesh.positions.len() as u32 - 1
                    })
                })
                .collect();
            for j in 0..row_before.len() {
                mesh.triangles.push([row_before[j], row[j], row[j + 1]]);
                if j + 1 < row_before.len() {
                    mesh.triangles.push([row_before[j], row[j + 1], row_before[j + 1]]);
                }
            }
            row_before = row;
        }
    }
}

/// The corners of an icosahedron.
fn icosahedron() -> Vec<Vec3> {
    let golden = 0.5 * (1.0 + 5.0_f32.sqrt());
    let signs = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
    let turned = |[x, y]: [f32; 2], axis: usize| {
        let mut p = [0.0; 3];
        (p[axis], p[(axis + 1) % 3]) = (x, y * golden);
        Vec3::from_array(p).normalize()
    };
    (0..3).flat_map(|axis| signs.map(|pair| turned(pair, axis))).collect()
}

/// Its faces, against the clock from outside.
fn faces(corners: &[Vec3]) -> Vec<(usize, usize, usize)> {
    let is_edge = |a: usize, b: usize| a != b && corners[a].dot(corners[b]) > 0.4;
    let mut all = Vec::new();
    for a in 0..corners.len() {
        for b in a + 1..corners.len() {
            for c in b + 1..corners.len() {
                if is_edge(a, b) && is_edge(b, c) && is_edge(c, a) {
                    let is_outward = corners[a].cross(corners[b]).dot(corners[c]) > 0.0;
                    all.push(if is_outward { (a, b, c) } else { (a, c, b) });
                }
            }
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed, wound outward, on the sphere, and as near to it as is stated.
    #[test]
    fn triangles_are_a_sphere() {
        for (count, radius) in [(1, 2.0), (8, 0.5), (24, 3.0)] {
            let sphere = Sphere { center: Vec3::new(1.0, 2.0, 3.0), radius };
            let mut mesh = Mesh::default();
            add(&mut mesh, &sphere, count);
            assert_eq!(
                (mesh.triangles.len(), mesh.positions.len()),
                (20 * count as usize * count as usize, 10 * (count * count) as usize + 2)
            );
            let mut edges = std::collections::HashSet::new();
            let (mut volume, mut inside) = (0.0, 0.0_f32);
            for t in &mesh.triangles {
                (0..3).for_each(|k| assert!(edges.insert((t[k], t[(k + 1) % 3]))));
                let [a, b, c] = t.map(|i| (mesh.positions[i as usize] - sphere.center).as_dvec3());
                volume += a.dot(b.cross(c)) / 6.0;
                inside = inside.max(1.0 - (a + b + c).as_vec3().length() / (3.0 * radius));
            }
            assert!(edges.iter().all(|(a, b)| edges.contains(&(*b, *a))));
            let whole = 4.0 / 3.0 * core::f64::consts::PI * f64::from(radius).powi(3);
            assert!(volume > 0.0 && volume < whole && (count == 1 || volume > 0.97 * whole), "{volume} of {whole}");
            assert!(count < 24 || inside < 1.0 / 1000.0, "{inside}");
            for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
                assert!((p.distance(sphere.center + *n * radius)) < 1e-5 && (n.length() - 1.0).abs() < 1e-6);
            }
        }
        assert_eq!(steps(1.0, 1.0, 1), 24);
        assert_eq!(steps(0.01, 1.0, 1), 8);
        assert!(20 * steps(0.01, 1.0, 100_000).pow(2) * 100_000 <= 2_000_000);
    }
}
