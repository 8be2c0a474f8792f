//! Pieces of surfaces that no edge joins: each becomes one chart or more.

use scene::Mesh;
use std::collections::HashMap;

/// The number of pieces of a mesh: triangles that share an edge, by the places of its ends, are of one piece. Triangles without an area do not
/// count.
///
/// Cost: some 0.3 µs a triangle.
pub(crate) fn count(mesh: &Mesh) -> usize {
    let place = |i: u32| (mesh.positions[i as usize] + 0.0).to_array().map(f32::to_bits);
    let mut parents: Vec<u32> = Vec::new();
    let mut edges: HashMap<_, u32> = HashMap::new();
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|i| mesh.positions[i as usize].as_dvec3());
        if (b - a).cross(c - a).length() == 0.0 {
            continue;
        }
        let own = parents.len() as u32;
        parents.push(own);
        for k in 0..3 {
            let (p, q) = (place(t[k]), place(t[(k + 1) % 3]));
            let other = *edges.entry(if p < q { [p, q] } else { [q, p] }).or_insert(own);
            let (one, other) = (root(&mut parents, own), root(&mut parents, other));
            parents[one.max(other) as usize] = one.min(other);
        }
    }
    (0..parents.len()).filter(|k| parents[*k] == *k as u32).count()
}

/// The first triangle of a piece.
fn root(parents: &mut [u32], mut at: u32) -> u32 {
    while parents[at as usize] != at {
        let above = parents[at as usize];
        parents[at as usize] = parents[above as usize];
        at = above;
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn pieces_are_counted() {
        let at = |x: f32, z: f32| Vec3::new(x, 0.0, z);
        // Two squares that meet in a corner; one of them has vertices of its own for each triangle. A triangle without an area between.
        let positions = vec![
            at(0.0, 0.0),
            at(1.0, 0.0),
            at(1.0, 1.0),
            at(0.0, 1.0),
            at(0.0, -0.0),
            at(1.0, 1.0),
            at(2.0, 1.0),
            at(2.0, 2.0),
            at(1.0, 2.0),
        ];
        let triangles = vec![[0, 1, 2], [4, 5, 3], [5, 6, 7], [5, 7, 8], [0, 1, 1]];
        assert_eq!(count(&Mesh { positions, triangles, ..Mesh::default() }), 2);
        assert_eq!(count(&Mesh::cuboid(Vec3::ZERO, Vec3::ONE)), 1);
        assert_eq!(count(&Mesh::default()), 0);
    }
}
