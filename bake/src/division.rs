//! Triangles that are divided at the middles of their edges.

use glam::{DVec3, Vec3};
use scene::Mesh;
use scene_files::GltfPart;
use std::collections::HashMap;

/// A vertex as weights of the vertices of a mesh: at most three, the corners of one triangle. All weights are multiples of a power of two,
/// so that they are exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Blend {
    pub(crate) vertices: [u32; 3],
    pub(crate) weights: [f64; 3],
}

impl Blend {
    /// A vertex itself.
    pub(crate) const fn one(vertex: u32) -> Self {
        Self { vertices: [vertex; 3], weights: [1.0, 0.0, 0.0] }
    }

    /// The middle of two vertices of one triangle.
    fn middle(a: Self, b: Self) -> Self {
        let mut out = Self { vertices: a.vertices, weights: [0.0; 3] };
        let mut count = 0;
        for (vertex, weight) in a.parts().chain(b.parts()) {
            match out.vertices[..count].iter().position(|known| *known == vertex) {
                Some(place) => out.weights[place] += 0.5 * weight,
                None if count < 3 => {
                    (out.vertices[count], out.weights[count]) = (vertex, 0.5 * weight);
                    count += 1;
                }
                None => debug_assert!(false, "both are on one triangle"),
            }
        }
        out
    }

    /// The vertices with weights above 0, and these.
    pub(crate) fn parts(&self) -> impl Iterator<Item = (u32, f64)> {
        self.vertices.into_iter().zip(self.weights).filter(|(_, weight)| *weight > 0.0)
    }

    /// The vertex that it is, if it is no mixture.
    pub(crate) fn single(&self) -> Option<u32> {
        (self.weights[0] == 1.0).then_some(self.vertices[0])
    }

    /// The mixture of a list with one value a vertex.
    pub(crate) fn of(&self, values: &[Vec3]) -> Vec3 {
        if let Some(vertex) = self.single() {
            return values[vertex as usize];
        }
        let each = self.parts().map(|(vertex, weight)| values[vertex as usize].as_dvec3() * weight);
        each.fold(DVec3::ZERO, |sum, value| sum + value).as_vec3()
    }
}

/// A triangle, or a part of one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    /// The triangle of the mesh.
    pub(crate) whole: u32,
    /// Its vertices in the division.
    pub(crate) corners: [u32; 3],
    /// Their places in the triangle, as weights of its second and third corner.
    pub(crate) at: [[f64; 2]; 3],
    /// The edges from each corner to the next; [`UNDIVIDED`] for those that are not divided.
    edges: [u32; 3],
}

/// The number of edges that are not divided: they are too short.
const UNDIVIDED: u32 = u32::MAX;

/// The places of an edge's ends, as bits, the lesser end first.
type EdgeKey = [[u32; 3]; 2];

/// The edges of all surfaces by their ends' places, so that triangles on both sides of an edge are divided alike, whatever mesh they are
/// of.
#[derive(Debug)]
pub(crate) struct Edges {
    numbers: HashMap<EdgeKey, u32>,
    lengths: Vec<f64>,
    /// Edges of at most this length are not divided.
    finest: f64,
}

impl Edges {
    pub(crate) fn new(finest: f64) -> Self {
        Self { numbers: HashMap::new(), lengths: Vec::new(), finest }
    }

    fn number(&mut self, a: Vec3, b: Vec3) -> u32 {
        let length = a.as_dvec3().distance(b.as_dvec3());
        let middle = 0.5 * (a + b);
        if length <= self.finest || middle == a || middle == b {
            return UNDIVIDED;
        }
        // −0 and 0 are the same place.
        let [p, q] = [a, b].map(|p| (p + 0.0).to_array().map(f32::to_bits));
        let next = self.lengths.len() as u32;
        let number = *self.numbers.entry(if p < q { [p, q] } else { [q, p] }).or_insert(next);
        if number == next {
            self.lengths.push(length);
        }
        number
    }

    /// The longest of a piece's edges, if it is divided: of several the one that was met first.
    fn longest(&self, piece: &Piece) -> Option<usize> {
        let known = (0..3).filter(|k| piece.edges[*k] != UNDIVIDED);
        let length = |k: &usize| (self.lengths[piece.edges[*k] as usize], core::cmp::Reverse(piece.edges[*k]));
        known.max_by(|a, b| {
            let ((p, i), (q, j)) = (length(a), length(b));
            p.total_cmp(&q).then(i.cmp(&j))
        })
    }

    /// The length of a piece's longest edge; 0 where none is divided.
    pub(crate) fn size(&self, piece: &Piece) -> f64 {
        self.longest(piece).map_or(0.0, |k| self.lengths[piece.edges[k] as usize])
    }
}

/// Edges at least this part of a triangle's longest are divided with it: so that triangles stay as round as they are.
const LONG: f64 = 0.7;

/// The edges to be divided.
#[derive(Clone, Debug)]
pub(crate) struct Marks(Vec<bool>);

impl Marks {
    /// The long edges of pieces, and those that must be divided with them: wherever an edge of a triangle is divided, its longest is, too
    /// (M. Rivara, *Mesh refinement processes based on the generalized bisection of simplices*, 1984). So no triangle becomes a sliver.
    pub(crate) fn new<'a>(
        edges: &Edges,
        chosen: impl Iterator<Item = &'a Piece>,
        all: &(impl Iterator<Item = &'a Piece> + Clone),
    ) -> Self {
        let mut marks = vec![false; edges.lengths.len()];
        for piece in chosen {
            let long = LONG * edges.size(piece);
            let known = piece.edges.iter().filter(|edge| **edge != UNDIVIDED);
            known.for_each(|edge| marks[*edge as usize] |= edges.lengths[*edge as usize] >= long);
        }
        let is_marked = |marks: &[bool], edge: u32| edge != UNDIVIDED && marks[edge as usize];
        loop {
            let mut is_done = true;
            for piece in all.clone() {
                if !piece.edges.iter().any(|edge| is_marked(&marks, *edge)) {
                    continue;
                }
                if let Some(longest) = edges.longest(piece) {
                    let mark = &mut marks[piece.edges[longest] as usize];
                    is_done &= *mark;
                    *mark = true;
                }
            }
            if is_done {
                return Self(marks);
            }
        }
    }

    fn has(&self, edge: u32) -> bool {
        edge != UNDIVIDED && self.0[edge as usize]
    }

    pub(crate) fn is_empty(&self) -> bool {
        !self.0.contains(&true)
    }
}

/// The triangles of a surface as they are divided.
#[derive(Debug)]
pub(crate) struct Division<'a> {
    mesh: &'a Mesh,
    /// The vertices: first those of the mesh, in their order.
    pub(crate) vertices: Vec<Blend>,
    positions: Vec<Vec3>,
    pub(crate) pieces: Vec<Piece>,
    middles: HashMap<[u32; 2], u32>,
}

/// Faces around a vertex of a mesh without normals are one side of it as long as the cosine of their angle is above this.
const FLAT: f32 = 0.999;

impl<'a> Division<'a> {
    /// The triangles of a part. In a mesh without normals, which is flat, each face gets vertices of its own where it meets others at an edge.
    pub(crate) fn new(part: &'a GltfPart, edges: &mut Edges) -> Self {
        let mesh = &part.geometry;
        let vertices = (0..mesh.positions.len() as u32).map(Blend::one).collect();
        let positions = mesh.positions.clone();
        let mut own = Self { mesh, vertices, positions, pieces: Vec::new(), middles: HashMap::new() };
        let mut sides: HashMap<u32, Vec<(Vec3, u32)>> = HashMap::new();
        for (whole, triangle) in mesh.triangles.iter().enumerate() {
            let mut corners = *triangle;
            if mesh.normals.is_empty() {
                let [a, b, c] = triangle.map(|i| mesh.positions[i as usize].as_dvec3());
                let normal = (b - a).cross(c - a).normalize_or_zero().as_vec3();
                corners = corners.map(|vertex| own.side(vertex, normal, sides.entry(vertex).or_default()));
            }
            let at = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
            let piece = own.piece(edges, whole as u32, corners, at);
            own.pieces.push(piece);
        }
        own
    }

    /// The vertex of a flat mesh for a face of that normal.
    fn side(&mut self, vertex: u32, normal: Vec3, known: &mut Vec<(Vec3, u32)>) -> u32 {
        if let Some((_, same)) = known.iter().find(|(other, _)| other.dot(normal) >= FLAT || normal == Vec3::ZERO) {
            return *same;
        }
        let number = if known.is_empty() { vertex } else { self.add(Blend::one(vertex)) };
        known.push((normal, number));
        number
    }

    fn add(&mut self, vertex: Blend) -> u32 {
        self.positions.push(vertex.of(&self.mesh.positions));
        self.vertices.push(vertex);
        self.vertices.len() as u32 - 1
    }

    fn piece(&self, edges: &mut Edges, whole: u32, corners: [u32; 3], at: [[f64; 2]; 3]) -> Piece {
        let place = |k: usize| self.positions[corners[k % 3] as usize];
        let edges = [0, 1, 2].map(|k| edges.number(place(k), place(k + 1)));
        Piece { whole, corners, at, edges }
    }

    fn middle(&mut self, a: u32, b: u32) -> u32 {
        let key = [a.min(b), a.max(b)];
        if let Some(known) = self.middles.get(&key) {
            return *known;
        }
        let number = self.add(Blend::middle(self.vertices[key[0] as usize], self.vertices[key[1] as usize]));
        self.middles.insert(key, number);
        number
    }

    /// The vertices that a division adds.
    pub(crate) fn new_vertices(&self, marks: &Marks) -> usize {
        let mut all: Vec<[u32; 2]> = Vec::new();
        for piece in &self.pieces {
            for k in (0..3).filter(|k| marks.has(piece.edges[*k])) {
                let (a, b) = (piece.corners[k], piece.corners[(k + 1) % 3]);
                all.push([a.min(b), a.max(b)]);
            }
        }
        all.sort_unstable();
        all.dedup();
        all.len()
    }

    /// Divides all pieces at their marked edges. `each` hears of each new piece, in order, the place of the piece that it is of, and whether
    /// it is that piece.
    pub(crate) fn divide(&mut self, edges: &mut Edges, marks: &Marks, mut each: impl FnMut(usize, bool)) {
        let before = core::mem::take(&mut self.pieces);
        let mut pieces = Vec::with_capacity(before.len());
        for (place, piece) in before.into_iter().enumerate() {
            let first = pieces.len();
            self.split(edges, marks, piece, &mut pieces);
            let is_same = pieces.len() == first + 1;
            (first..pieces.len()).for_each(|_| each(place, is_same));
        }
        self.pieces = pieces;
    }

    fn split(&mut self, edges: &mut Edges, marks: &Marks, piece: Piece, out: &mut Vec<Piece>) {
        let is_marked = piece.edges.map(|edge| marks.has(edge));
        let Some(longest) = edges.longest(&piece).filter(|_| is_marked.contains(&true)) else {
            out.push(piece);
            return;
        };
        // Its longest edge is from the first corner to the second now.
        let turned = |k: usize| (longest + k) % 3;
        let [a, b, c] = [0, 1, 2].map(|k| (piece.corners[turned(k)], piece.at[turned(k)]));
        let mut between =
            |p: (u32, [f64; 2]), q: (u32, [f64; 2])| (self.middle(p.0, q.0), [0, 1].map(|k| 0.5 * (p.1[k] + q.1[k])));
        let ab = between(a, b);
        let bc = is_marked[turned(1)].then(|| between(b, c));
        let ca = is_marked[turned(2)].then(|| between(c, a));
        let new: Vec<[(u32, [f64; 2]); 3]> = match (bc, ca) {
            (Some(bc), Some(ca)) => vec![[a, ab, ca], [ab, b, bc], [ab, bc, ca], [ca, bc, c]],
            (Some(bc), None) => vec![[c, a, ab], [ab, b, bc], [ab, bc, c]],
            (None, Some(ca)) => vec![[a, ab, ca], [ca, ab, c], [ab, b, c]],
            (None, None) => vec![[c, a, ab], [b, c, ab]],
        };
        for corners in new {
            let (numbers, at) = (corners.map(|(number, _)| number), corners.map(|(_, at)| at));
            let made = self.piece(edges, piece.whole, numbers, at);
            out.push(made);
        }
    }

    /// Whether something is not as in the mesh.
    pub(crate) fn is_divided(&self) -> bool {
        self.vertices.len() > self.mesh.positions.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;

    /// A grid of triangles in two parts that meet along an edge, each with vertices of its own there.
    fn halves() -> [GltfPart; 2] {
        [0.0, 1.0].map(|left| {
            let place = |k: u32| Vec3::new(left + (k % 3) as f32 * 0.5, 0.1 * (k % 2) as f32, (k / 3) as f32 * 0.7);
            let cell = |k: u32| [[k, k + 3, k + 4], [k, k + 4, k + 1]];
            let geometry = Mesh {
                positions: (0..9).map(place).collect(),
                triangles: [0, 1, 3, 4].into_iter().flat_map(cell).collect(),
                ..Mesh::default()
            };
            GltfPart { geometry, ..GltfPart::default() }
        })
    }

    fn area(of: impl Iterator<Item = [Vec3; 3]>) -> f64 {
        of.map(|t| t.map(|p| p.as_dvec3())).map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum()
    }

    /// Divided here and there for some rounds: areas are kept, every edge inside has two triangles with the same ends, of one part or two,
    /// and places in the whole triangle are those of the vertices.
    #[test]
    fn shared_edges_divide_alike() {
        let parts = halves();
        let mut edges = Edges::new(0.02);
        let mut divisions = parts.each_ref().map(|part| Division::new(part, &mut edges));
        let before: f64 = parts.iter().map(|part| part.geometry.area()).sum();
        for round in 0..5 {
            let is_chosen =
                |piece: &&Piece| (piece.whole + round).is_multiple_of(3) && piece.corners[0].is_multiple_of(2);
            let all = || divisions.iter().flat_map(|division| &division.pieces);
            let marks = Marks::new(&edges, all().filter(is_chosen), &all());
            assert!(!marks.is_empty());
            for division in &mut divisions {
                let (vertices, new) = (division.vertices.len(), division.new_vertices(&marks));
                division.divide(&mut edges, &marks, |_, _| ());
                assert_eq!(division.vertices.len(), vertices + new);
            }
        }
        let corners = |division: &Division<'_>| -> Vec<[Vec3; 3]> {
            division.pieces.iter().map(|piece| piece.corners.map(|i| division.positions[i as usize])).collect()
        };
        let all: Vec<[Vec3; 3]> = divisions.iter().flat_map(corners).collect();
        assert!(all.len() > 100, "{}", all.len());
        assert!((area(all.iter().copied()) - before).abs() < 1e-6 * before);
        let bits = |p: Vec3| p.to_array().map(f32::to_bits);
        let mut count: HashMap<EdgeKey, usize> = HashMap::new();
        for t in &all {
            for k in 0..3 {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                let on_border = |axis: usize, at: f32| a[axis] == at && b[axis] == at;
                if !(on_border(0, 0.0) || on_border(0, 2.0) || on_border(2, 0.0) || on_border(2, 1.4)) {
                    let (p, q) = (bits(a), bits(b));
                    *count.entry(if p < q { [p, q] } else { [q, p] }).or_default() += 1;
                }
            }
        }
        assert!(count.values().all(|count| *count == 2), "{:?}", count.values().filter(|count| **count != 2).count());
        for division in &divisions {
            for piece in &division.pieces {
                let [a, b, c] = division.mesh.triangles[piece.whole as usize]
                    .map(|i| division.mesh.positions[i as usize].as_dvec3());
                for (corner, [v, w]) in piece.corners.into_iter().zip(piece.at) {
                    let place = a * (1.0 - v - w) + b * v + c * w;
                    assert!(place.distance(division.positions[corner as usize].as_dvec3()) < 1e-6);
                }
            }
        }
    }

    /// Triangles stay as round as they are: their smallest angle is at least half of the smallest before.
    #[test]
    fn no_slivers_arise() {
        let geometry = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(0.3, 0.0, 0.6)],
            triangles: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        let part = GltfPart { geometry, ..GltfPart::default() };
        let mut edges = Edges::new(1e-3);
        let mut division = Division::new(&part, &mut edges);
        for _ in 0..12 {
            // Only what touches one corner.
            let chosen = division.pieces.iter().filter(|piece| piece.corners.contains(&1));
            let marks = Marks::new(&edges, chosen, &division.pieces.iter());
            division.divide(&mut edges, &marks, |_, _| ());
        }
        let angle = |corners: [u32; 3]| {
            let p = corners.map(|i| division.positions[i as usize]).map(|p| Vec2::new(p.x, p.z));
            (0..3).map(|k| (p[(k + 1) % 3] - p[k]).angle_to(p[(k + 2) % 3] - p[k]).abs()).fold(9.0, f32::min)
        };
        let least = division.pieces.iter().map(|piece| angle(piece.corners)).fold(9.0, f32::min);
        assert!(division.pieces.len() > 20 && least > 0.5 * angle([0, 1, 2]), "{} {least}", division.pieces.len());
    }

    /// A flat cube of eight vertices has four on each side.
    #[test]
    fn flat_faces_have_vertices_of_their_own() {
        let positions: Vec<Vec3> =
            (0..8).map(|k| Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2) as f32)).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        let mut part = GltfPart { geometry: Mesh { positions, triangles, ..Mesh::default() }, ..GltfPart::default() };
        let mut edges = Edges::new(0.1);
        let count = |part: &GltfPart, edges: &mut Edges| Division::new(part, edges).vertices.len();
        assert_eq!(count(&part, &mut edges), 24);
        part.geometry.normals = vec![Vec3::Y; 8];
        assert_eq!(count(&part, &mut edges), 8);
    }
}
