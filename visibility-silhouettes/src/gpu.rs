//! The strategy on a GPU.

use crate::tree::{Node, Tree, WIDE};
use crate::{SilhouetteMesh, wgsl};
use glam::Vec3;
use lobe_core::wgsl::{Piece, constant};
use shading::gpu::{GpuBlockers, GpuBuffer, GpuSkyPart};

/// No triangle on a side of an edge, or no child in a place of a node.
pub(crate) const NONE: u32 = u32::MAX;
/// The buffer of nodes, corners, triangles and edges.
const DATA: &str = "silhouettes_data";
/// Rows of a node's child.
const CHILD: usize = 3;

/// Four words, as kernels read them.
type Row = [u32; 4];

/// The `silhouettes` strategy for a GPU: the same as [`SilhouetteBlockers`](crate::SilhouetteBlockers) without
/// [`with_tolerance`](crate::SilhouetteBlockers::with_tolerance), that is exact.
///
/// # Method
/// One thread a point looks for any silhouette in front of the light; if there is none, one ray decides. Otherwise a workgroup
/// lists the point's silhouettes, with one thread for a child of a node or for an edge, and counts surfaces in its memory as
/// [`SilhouetteBlockers`](crate::SilhouetteBlockers) does. The side of a triangle on which a point lies is computed in f32 if that
/// is certain, else with twice the digits. All sums are of integers, so two runs give the same masks.
///
/// # Domain
/// Sphere lights that no triangle reaches into, and flat lights. The triangles that a flat light's plane may cut must be given to
/// [`with_clipped`](Self::with_clipped). Rays must meet exactly the triangles of these meshes.
///
/// # Cost
/// 100 bytes a triangle, packed again by each [`new`](Self::new).
///
/// ```
/// use glam::Vec3;
/// use shading::gpu::GpuBlockers;
/// use visibility_silhouettes::{GpuSilhouettes, SilhouetteMesh};
/// let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
/// let silhouettes = GpuSilhouettes::new(&[SilhouetteMesh::new(0, &corners, &[[0, 1, 2]])]);
/// assert!(silhouettes.asks_any_hit() && silhouettes.buffers()[0].name == "silhouettes_data");
/// ```
#[derive(Clone, Debug)]
pub struct GpuSilhouettes {
    rows: Vec<Row>,
    /// The most nodes from the root to a leaf.
    depth: usize,
}

/// Rows before the nodes: the places of nodes, corners, triangles and edges; the place and length of the list of lights.
const HEADER: usize = 2;

/// Kernels are compiled for multiples of this depth, so that most scenes share them.
const DEPTH_STEP: usize = 4;

impl GpuSilhouettes {
    /// The outlines of several meshes at their present positions.
    #[must_use]
    pub fn new<'m>(meshes: impl IntoIterator<Item = &'m SilhouetteMesh>) -> Self {
        let meshes: Vec<&SilhouetteMesh> = meshes.into_iter().filter(|m| !m.trees()[0].nodes().is_empty()).collect();
        let mut packed = Packed::default();
        let boxes: Vec<[Vec3; 2]> = meshes.iter().map(|mesh| mesh.trees()[0].bounds()).collect();
        let (mut top, order) = Tree::new(boxes.iter().copied(), 0);
        top.fit(|range| order[range].iter().map(|mesh| (boxes[*mesh as usize], Vec3::ZERO, None, 0.0)));
        packed.node_count = match meshes.len() {
            1 => 0,
            _ => top
                .nodes()
                .iter()
                .map(|node| 1 + node.count[..usize::from(node.len)].iter().filter(|c| **c > 0).count())
                .sum(),
        };
        let mut roots = Vec::with_capacity(meshes.len());
        let mut deepest = 0;
        for mesh in &meshes {
            roots.push(packed.node_count as u32);
            packed.add(mesh);
            deepest = deepest.max(mesh.trees()[0].depth());
        }
        let mut depth = deepest;
        let mut first = Vec::new();
        if meshes.len() != 1 {
            let of = |number: u32| (meshes[number as usize].trees()[0], roots[number as usize]);
            first = top_nodes(&top, &order, of);
            depth += top.depth() + 1;
        }
        first.append(&mut packed.nodes);
        if first.is_empty() {
            first = node([].into_iter());
        }
        let corners = HEADER + first.len();
        let triangles = corners + packed.corners.len();
        let edges = triangles + packed.triangles.len();
        let mut rows = vec![[HEADER, corners, triangles, edges].map(|at| at as u32), [0; 4]];
        rows.append(&mut first);
        rows.append(&mut packed.corners);
        rows.append(&mut packed.triangles);
        rows.append(&mut packed.edges);
        Self { rows, depth: depth.max(1).next_multiple_of(DEPTH_STEP) }
    }

    /// Sets, for each light of the frames, the triangles of these meshes that its plane may cut: for a light with an outline all
    /// [around it](crate::AroundLight), with the sphere of [`gpu_bounds`](shading::gpu::GpuLight::gpu_bounds), for others none. Surfaces
    /// block up to that plane. Each receiver looks at all of them.
    #[must_use]
    pub fn with_clipped(mut self, triangles: &[Vec<[Vec3; 3]>]) -> Self {
        self.rows[1] = [self.rows.len() as u32, triangles.len() as u32, 0, 0];
        let mut start = self.rows.len() + triangles.len();
        for of_light in triangles {
            self.rows.push([start as u32, of_light.len() as u32, 0, 0]);
            start += 3 * of_light.len();
        }
        self.rows.extend(triangles.iter().flatten().flatten().map(|p| floats(p.to_array(), 0)));
        self
    }
}

/// The data of several meshes, in the order of the rows.
#[derive(Default)]
struct Packed {
    node_count: usize,
    nodes: Vec<Row>,
    corners: Vec<Row>,
    triangles: Vec<Row>,
    edges: Vec<Row>,
}

fn floats([x, y, z]: [f32; 3], w: u32) -> Row {
    [x.to_bits(), y.to_bits(), z.to_bits(), w]
}

/// A child of a node: box, cone, the number of its first edge or node, and its count of edges; 0 for a node.
fn child(node: &Node, k: usize, first: u32, count: u32) -> [Row; CHILD] {
    let at = |c: usize| [node.bounds[c][k], node.bounds[c + 1][k], node.bounds[c + 2][k]];
    [floats(at(0), node.bounds[9][k].to_bits()), floats(at(3), first), floats(at(6), count)]
}

/// A node of up to eight children.
fn node(children: impl Iterator<Item = [Row; CHILD]>) -> Vec<Row> {
    let mut rows: Vec<Row> = children.take(WIDE).flatten().collect();
    rows.resize(CHILD * WIDE, [0, 0, 0, NONE]);
    rows
}

/// The nodes above those of the meshes. `of` returns the tree and the root of a mesh by its number. A leaf of `top` becomes a node,
/// after the others.
fn top_nodes<'m>(top: &Tree, order: &[u32], of: impl Fn(u32) -> (&'m Tree, u32)) -> Vec<Row> {
    let (mut nodes, mut leaves) = (Vec::new(), Vec::new());
    for branch in top.nodes() {
        let mut children = Vec::with_capacity(WIDE);
        for k in 0..usize::from(branch.len) {
            let (mut first, count) = (branch.first[k], usize::from(branch.count[k]));
            if count > 0 {
                let meshes = &order[first as usize..first as usize + count];
                let above = Tree::above(meshes.iter().map(|mesh| of(*mesh).0));
                first = (top.nodes().len() + leaves.len() / (CHILD * WIDE)) as u32;
                leaves.extend(node(meshes.iter().enumerate().map(|(k, mesh)| child(&above, k, of(*mesh).1, 0))));
            }
            children.push(child(branch, k, first, 0));
        }
        nodes.extend(node(children.into_iter()));
    }
    nodes.extend(leaves);
    nodes
}

impl Packed {
    fn add(&mut self, mesh: &SilhouetteMesh) {
        let (first_corner, first_edge) = (self.corners.len() as u32, self.edges.len() as u32);
        let first_triangle = (self.triangles.len() / 2) as u32;
        let first_node = self.node_count as u32;
        for branch in mesh.trees()[0].nodes() {
            let children = (0..usize::from(branch.len)).map(|k| {
                let count = u32::from(branch.count[k]);
                let base = if count == 0 { first_node } else { first_edge };
                child(branch, k, base + branch.first[k], count)
            });
            self.nodes.extend(node(children));
        }
        self.node_count += mesh.trees()[0].nodes().len();
        let (corners, triangles, planes) = mesh.geometry();
        self.corners.extend(corners.iter().map(|p| floats(p.truncate().to_array(), 0)));
        for (triangle, [x, y, z, d]) in triangles.iter().zip(planes) {
            self.triangles.push(floats([*x, *y, *z], d.to_bits()));
            let [a, b, c] = triangle.map(|i| first_corner + i);
            self.triangles.push([a, b, c, u32::from(mesh.is_closed())]);
        }
        self.edges.extend(mesh.upward_edges().map(|([a, b], sides)| {
            let [one, other] = sides.map(|t| t.map_or(NONE, |t| first_triangle + t));
            [first_corner + a, first_corner + b, one, other]
        }));
    }
}

impl GpuBlockers for GpuSilhouettes {
    fn name(&self) -> &'static str {
        "silhouettes"
    }

    fn constants(&self) -> String {
        constant("SILHOUETTES_DEPTH", &self.depth)
    }

    fn coverage(&self) -> &'static Piece {
        &wgsl::COVERAGE
    }

    fn splat(&self) -> &'static Piece {
        &wgsl::SPLAT
    }

    fn has_edges(&self) -> bool {
        true
    }

    fn sky(&self) -> Option<GpuSkyPart> {
        Some(GpuSkyPart { piece: &wgsl::SKY, reads: vec![DATA] })
    }

    fn asks_any_hit(&self) -> bool {
        true
    }

    fn buffers(&self) -> Vec<GpuBuffer<'_>> {
        vec![GpuBuffer::of(DATA, "vec4u", self.rows.as_flattened())]
    }
}
