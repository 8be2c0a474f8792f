use crate::edge_list::{Block, COLUMNS, ENDS, ID, LANES, PLANES};
use crate::lanes::columns;
use crate::topology::{self, Edge, normal};
use crate::tree::Tree;
use fearless_simd::Simd;
use glam::{Vec3, Vec4};
use rayon::prelude::*;

/// A triangle mesh as the silhouettes of it are found: planes of triangles, edges with the triangles on both sides, and a
/// hierarchy of the edges.
///
/// Any triangles: open, self-intersecting, wound either way, with edges of more than two triangles. Those with two equal corners
/// are left out. The mesh may move ([`refit`](Self::refit)) as long as its triangles keep their corners.
///
/// # Cost
/// About 72 bytes a triangle.
#[derive(Clone, Debug)]
pub struct SilhouetteMesh {
    /// The number of the object that the triangles belong to.
    object: u32,
    /// With a fourth number beside, so that eight are soon turned into columns.
    positions: Vec<Vec4>,
    /// For each of `positions` the one of the caller's that it is a copy of.
    sources: Vec<u32>,
    triangles: Vec<[u32; 3]>,
    /// Unit normal `n` and `−n·a`, from f64.
    planes: Vec<[f32; 4]>,
    /// In the order of the tree's leaves.
    edges: Vec<Edge>,
    tree: Tree,
}

impl SilhouetteMesh {
    /// Prepares a mesh: pairs its edges and builds the hierarchy.
    ///
    /// # Panics
    /// When a triangle has a corner that is not among `positions`.
    #[must_use]
    pub fn new(object: u32, positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let (welded, numbers) = topology::weld(positions);
        let mut sources = vec![0; welded.len()];
        for (source, number) in numbers.iter().enumerate().rev() {
            sources[*number as usize] = source as u32;
        }
        let mut triangles: Vec<_> = triangles.iter().map(|t| t.map(|i| numbers[i as usize])).collect();
        // One without area blocks nothing, but may have some later.
        triangles.retain(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
        let mut edges = topology::edges(&mut triangles);
        let bounds = |e: &Edge| {
            let [a, b] = e.ends().map(|k| welded[triangles[e.triangle() as usize][k] as usize]);
            [a.min(b), a.max(b)]
        };
        let boxes: Vec<_> = edges.iter().map(bounds).collect();
        let (tree, order) = Tree::new(&boxes);
        edges = order.iter().map(|i| edges[*i as usize]).collect();
        // Neighbours in the tree become neighbours in memory.
        let places = topology::by_first_use(triangles.len(), edges.iter().flat_map(|e| e.triangles()));
        edges.iter_mut().for_each(|edge| edge.renumber(&places));
        triangles = topology::placed(&triangles, &places);
        let places = topology::by_first_use(welded.len(), triangles.iter().flatten().copied());
        triangles.iter_mut().flatten().for_each(|corner| *corner = places[*corner as usize]);
        let (welded, sources) = (topology::placed(&welded, &places), topology::placed(&sources, &places));
        let positions = welded.iter().map(|p| p.extend(0.0)).collect();
        let planes = vec![[0.0; 4]; triangles.len()];
        let mut mesh = Self { object, positions, sources, triangles, planes, edges, tree };
        mesh.fit();
        mesh
    }

    /// Follows a mesh that has moved: the same triangles between other positions. `false`, and nothing is changed, when
    /// there are other positions than before.
    ///
    /// Corners that were equal stay one corner; a triangle without area blocks nothing until it has one.
    ///
    /// # Cost
    /// Linear in the triangles, on all threads.
    pub fn refit(&mut self, positions: &[Vec3]) -> bool {
        if self.sources.iter().any(|source| *source as usize >= positions.len()) {
            return false;
        }
        for (position, source) in self.positions.iter_mut().zip(&self.sources) {
            *position = positions[*source as usize].extend(0.0);
        }
        self.fit();
        true
    }

    /// Planes, flat edges, boxes and cones from the positions.
    fn fit(&mut self) {
        let Self { positions, triangles, planes, edges, tree, .. } = self;
        let corners = |t: u32| triangles[t as usize].map(|i| positions[i as usize].truncate());
        planes.par_iter_mut().with_min_len(1024).zip(0..triangles.len() as u32).for_each(|(plane, t)| {
            let corners = corners(t);
            let n = normal(corners).normalize_or_zero();
            let d = -n.dot(corners[0].as_dvec3());
            *plane = [n.x as f32, n.y as f32, n.z as f32, d as f32];
        });
        edges.par_iter_mut().with_min_len(1024).for_each(|edge| {
            let flat = edge.other().is_some_and(|other| {
                let [p, q] = [edge.triangle(), other].map(|t| planes[t as usize]);
                let alike = p[0] * q[0] + p[1] * q[1] + p[2] * q[2] > 0.999_999;
                alike && is_flat(corners(edge.triangle()), corners(other))
            });
            edge.set_flat(flat);
        });
        tree.fit(|range| {
            range.filter(|i| !edges[*i].is_flat()).map(|i| {
                let edge = edges[i];
                let corners = corners(edge.triangle());
                let normal = |t: u32| Vec3::from_slice(&planes[t as usize]);
                (edge.ends().map(|k| corners[k]), normal(edge.triangle()), edge.other().map(normal))
            })
        });
    }

    /// The number of the object.
    #[must_use]
    pub fn object(&self) -> u32 {
        self.object
    }

    /// Triangles with three different corners.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// Edges.
    #[must_use]
    pub fn edge_count(&self) -> usize {
        self.edges.len()
    }

    /// Memory, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(&self.positions[..])
            + size_of_val(&self.sources[..])
            + size_of_val(&self.triangles[..])
            + size_of_val(&self.planes[..])
            + size_of_val(&self.edges[..])
            + self.tree.bytes()
    }

    pub(crate) fn tree(&self) -> &Tree {
        &self.tree
    }

    /// Writes the planes on both sides of up to eight edges side by side; returns which of them are not flat, as bits.
    #[inline(always)]
    pub(crate) fn fetch_planes<S: Simd>(&self, simd: S, first: usize, count: usize, out: &mut Block<COLUMNS>) -> u32 {
        let mut lanes = 0;
        let mut sides = [[[0.0; 4]; LANES]; 2];
        for (lane, edge) in self.edges[first..first + count.min(LANES)].iter().enumerate() {
            // Upward, so that all records of an edge make the same calculation, whatever the hierarchy.
            let down = usize::from(edge.is_down());
            sides[down][lane] = self.planes[edge.triangle() as usize];
            sides[1 - down][lane] = edge.other().map_or([0.0; 4], |t| self.planes[t as usize]);
            lanes |= u32::from(!edge.is_flat()) << lane;
        }
        for (rows, first) in sides.iter().zip(PLANES) {
            columns(simd, rows, &mut out[first..first + 4]);
        }
        lanes
    }

    /// The same for the ends and the numbers of those that `lanes` has; `base` is the number of the mesh's first edge.
    #[inline(always)]
    pub(crate) fn fetch_ends<S: Simd>(
        &self,
        simd: S,
        first: usize,
        mut lanes: u32,
        base: u32,
        out: &mut Block<COLUMNS>,
    ) {
        let mut ends = [[[0.0; 4]; LANES]; 2];
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & (LANES - 1);
            lanes &= lanes - 1;
            let edge = self.edges[first + lane];
            let corners = &self.triangles[edge.triangle() as usize];
            let down = usize::from(edge.is_down());
            let [p, q] = edge.ends();
            ends[down][lane] = self.positions[corners[p] as usize].to_array();
            ends[1 - down][lane] = self.positions[corners[q] as usize].to_array();
        }
        for (rows, first) in ends.iter().zip(ENDS) {
            columns(simd, rows, &mut out[first..first + 3]);
        }
        for (number, id) in (base + first as u32..).zip(&mut out[ID]) {
            *id = f32::from_bits(number);
        }
    }

    /// How a point lies to the triangles that run along an edge upward and downward: 1 in front,
    /// −1 behind, 0 in the plane or where there is no triangle. Exact but for the rounding of f64.
    pub(crate) fn sides(&self, edge: usize, x: Vec3) -> [f32; 2] {
        let edge = self.edges[edge];
        let side = |t: u32| side(self.triangles[t as usize].map(|i| self.positions[i as usize].truncate()), x);
        let [one, other] = [side(edge.triangle()), edge.other().map_or(0.0, side)];
        if edge.is_down() { [other, one] } else { [one, other] }
    }
}

/// 1 where a point is in front of a triangle's plane, −1 behind it, 0 in it.
pub(crate) fn side(corners: [Vec3; 3], x: Vec3) -> f32 {
    let along = normal(corners).dot(x.as_dvec3() - corners[0].as_dvec3());
    if along > 0.0 {
        1.0
    } else if along < 0.0 {
        -1.0
    } else {
        0.0
    }
}

/// Whether two triangles lie in one plane and face the same way, so that no point is between their planes.
fn is_flat(one: [Vec3; 3], other: [Vec3; 3]) -> bool {
    let [m, n] = [normal(one), normal(other)];
    m.dot(n) > 0.0 && m.cross(n) == glam::DVec3::ZERO && other.iter().all(|p| side(one, *p) == 0.0)
}
