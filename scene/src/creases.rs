//! Smooth normals that stop at creases.

use crate::Mesh;
use crate::edges::Edges;
use crate::joined::Joined;
use crate::normals::same_places;
use glam::DVec3;
use std::collections::HashMap;

/// The vertices of a mesh that was split at its creases.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Split {
    /// The vertex that each came from.
    pub sources: Vec<u32>,
    /// The number of the common normal of each, and whether it has the opposite one.
    pub groups: Vec<(u32, bool)>,
}

impl Mesh {
    /// Splits the vertices along the edges where faces meet at more than `crease` degrees, so that no normal is shared across
    /// them. Faces that meet there with opposite windings count as turned round.
    ///
    /// # Panics
    /// When a triangle refers to a vertex that does not exist.
    pub fn split_at_creases(&mut self, crease: f32) -> Split {
        let joined = joined_corners(self, f64::from(crease).to_radians().cos());
        let mut split = Split { sources: Vec::new(), groups: Vec::new() };
        let (mut vertices, mut numbers) = (HashMap::new(), HashMap::new());
        let mut corner = 0;
        for t in &mut self.triangles {
            for vertex in t {
                let (root, turned) = joined[corner];
                corner += 1;
                let next = numbers.len() as u32;
                let group = *numbers.entry(root).or_insert(next);
                *vertex = *vertices.entry((*vertex, group, turned)).or_insert_with(|| {
                    split.sources.push(*vertex);
                    split.groups.push((group, turned));
                    split.sources.len() as u32 - 1
                });
            }
        }
        let sources = &split.sources;
        self.positions = picked(&self.positions, sources);
        self.colors = picked(&self.colors, sources);
        self.uv_sets.iter_mut().for_each(|set| *set = picked(set, sources));
        self.normals.clear();
        split
    }
}

/// The values of other vertices; none of none.
pub(crate) fn picked<T: Copy>(values: &[T], sources: &[u32]) -> Vec<T> {
    if values.is_empty() { Vec::new() } else { sources.iter().map(|&i| values[i as usize]).collect() }
}

/// For each corner, triangle by triangle, the corner that stands for all that share its normal, and whether it has the opposite one.
fn joined_corners(mesh: &Mesh, cos: f64) -> Vec<(u32, bool)> {
    let places = same_places(&mesh.positions);
    let normals: Vec<DVec3> = mesh.triangles.iter().map(|&t| mesh.face_cross(t).normalize_or_zero()).collect();
    let triangles: Vec<[u32; 3]> = mesh.triangles.iter().map(|t| t.map(|i| places[i as usize])).collect();
    let edges = Edges::of(&triangles);
    let mut joined = Joined::new(3 * triangles.len());
    let sides = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    for (number, [a, b]) in (0..).zip(sides) {
        let sides = edges.between(a, b);
        let own = sides.partition_point(|side| side.number < number);
        // Of edges with very many faces only neighbours in the list are compared.
        for other in sides.iter().skip(own + 1).take(8) {
            let turned = other.is_back == sides[own].is_back;
            let along = normals[sides[own].triangle() as usize].dot(normals[other.triangle() as usize]);
            // Rounding must not make an edge of what is said to be none.
            if (if turned { -along } else { along }) < cos - 1e-6 {
                continue;
            }
            for end in [false, true] {
                joined.join(sides[own].corner(end), other.corner(end), turned);
            }
        }
    }
    (0..3 * mesh.triangles.len() as u32).map(|corner| joined.root(corner)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    /// The largest angle in degrees between a corner's normal and its face, and the number of different normals.
    fn look(mesh: &Mesh) -> (f64, usize) {
        let mut most = 0.0f64;
        let mut kinds: Vec<Vec3> = Vec::new();
        for &t in &mesh.triangles {
            let face = mesh.face_cross(t).normalize();
            for n in t.map(|i| mesh.normals[i as usize]) {
                most = most.max(face.dot(n.as_dvec3()).clamp(-1.0, 1.0).acos().to_degrees());
                if !kinds.iter().any(|k| k.dot(n) > 0.999) {
                    kinds.push(n);
                }
            }
        }
        (most, kinds.len())
    }

    fn smoothed(mut mesh: Mesh, crease: f32) -> Mesh {
        let groups = mesh.split_at_creases(crease).groups;
        mesh.smooth_normals_of(&groups);
        mesh.validate().unwrap();
        mesh
    }

    /// A strip of faces, each turned by some degrees against the one before.
    fn bent(turns: &[f64]) -> Mesh {
        let (mut at, mut angle) = (DVec3::ZERO, 0.0f64);
        let mut mesh = Mesh::default();
        for turn in [0.0].iter().chain(turns).chain(&[0.0]) {
            for z in [0.0, 1.0] {
                mesh.positions.push((at + DVec3::Z * z).as_vec3());
            }
            angle += turn.to_radians();
            at += DVec3::new(angle.cos(), angle.sin(), 0.0);
        }
        for k in 0..=turns.len() as u32 {
            let i = 2 * k;
            mesh.triangles.extend([[i, i + 1, i + 3], [i, i + 3, i + 2]]);
        }
        mesh
    }

    #[test]
    fn cubes_are_flat_below_their_edges_and_smooth_above() {
        let cube = |shared: bool| {
            let mut mesh = Mesh::cuboid(Vec3::ZERO, Vec3::ONE);
            if shared {
                let places = same_places(&mesh.positions);
                let of = |place: u32| places.iter().position(|p| *p == place).unwrap();
                mesh.positions = (0..8).map(|place| mesh.positions[of(place)]).collect();
                mesh.triangles.iter_mut().flatten().for_each(|i| *i = places[*i as usize]);
            }
            mesh
        };
        for shared in [false, true] {
            let flat = smoothed(cube(shared), 89.0);
            assert!(look(&flat).0 < 1e-3 && look(&flat).1 == 6, "{:?}", look(&flat));
            let round = smoothed(cube(shared), 91.0);
            assert!((look(&round).0 - 54.7356).abs() < 0.1 && look(&round).1 == 8, "{:?}", look(&round));
        }
    }

    #[test]
    fn each_edge_is_judged_alone() {
        let mesh = smoothed(bent(&[20.0, 50.0, 20.0, 20.0]), 30.0);
        // One edge is split: two vertices more.
        assert_eq!(mesh.positions.len(), bent(&[20.0, 50.0, 20.0, 20.0]).positions.len() + 2);
        assert!((look(&mesh).0 - 10.0).abs() < 0.5, "{:?}", look(&mesh));
    }

    /// Faces that wind the other way are smoothed as if they did not, each with normals on its own side.
    #[test]
    fn windings_do_not_matter() {
        let even = smoothed(bent(&[20.0, 20.0, 20.0, 20.0]), 60.0);
        let mut mixed = bent(&[20.0, 20.0, 20.0, 20.0]);
        for k in [1, 4, 5, 7] {
            mixed.triangles[k].swap(1, 2);
        }
        let mixed = smoothed(mixed, 60.0);
        for (k, (a, b)) in even.triangles.iter().zip(&mixed.triangles).enumerate() {
            for i in a {
                let n = even.normals[*i as usize];
                let near = |j: &&u32| mixed.positions[**j as usize] == even.positions[*i as usize];
                let other = mixed.normals[*b.iter().find(near).unwrap() as usize];
                assert!((n.dot(other).abs() - 1.0).abs() < 1e-5, "{k}");
                assert!(mixed.face_cross(*b).dot(other.as_dvec3()) > 0.0, "{k}");
            }
        }
    }
}
