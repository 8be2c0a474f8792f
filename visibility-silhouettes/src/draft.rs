//! A mesh while it is prepared: its edges are paired, then put into the order of trees, then all else into the order of the edges.

use crate::coarse::Coarse;
use crate::topology::{self, Edge, Sides, Tag};
use crate::tree::Tree;
use glam::Vec3;

/// Triangles and edges whose order is not final.
#[derive(Debug, Default)]
pub(crate) struct Draft {
    pub(crate) corners: Vec<Vec3>,
    /// For each of `corners` the index of the caller's position that it copies.
    pub(crate) sources: Vec<u32>,
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) edges: Vec<Edge>,
    /// Triangles and edges of the mesh itself; those of simplified forms are behind them.
    pub(crate) triangle_count: usize,
    edge_count: usize,
    /// For each edge its condition to be drawn; empty if all are always drawn.
    pub(crate) tags: Vec<Tag>,
    /// The patch of each triangle; empty without simplified forms.
    pub(crate) triangle_patches: Vec<u16>,
    pub(crate) patch_count: usize,
    /// Corners that only simplified forms have, and corners that these leave out, with the triangles next to them.
    pub(crate) own: Vec<u32>,
    pub(crate) left_out: Vec<[u32; 2]>,
}

impl Draft {
    /// The mesh itself: equal positions are one corner, and triangles agree with their neighbours where they can.
    /// The edges come with [`pair`](Self::pair) or [`add`](Self::add).
    pub(crate) fn welded(positions: &[Vec3], triangles: &[[u32; 3]]) -> (Self, Sides) {
        let (corners, numbers) = topology::weld(positions);
        let mut sources = vec![0; corners.len()];
        for (source, number) in numbers.iter().enumerate().rev() {
            sources[*number as usize] = source as u32;
        }
        let mut triangles: Vec<_> = triangles.iter().map(|t| t.map(|i| numbers[i as usize])).collect();
        // A triangle without area blocks nothing now, but may have an area later.
        triangles.retain(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
        let sides = topology::oriented(&mut triangles);
        (Self { sources, ..Self::of_edges(corners, triangles, Vec::new()) }, sides)
    }

    /// Pairs the sides of a mesh without simplified forms.
    pub(crate) fn pair(&mut self, sides: &Sides) {
        self.edges = topology::edges(sides);
        self.edge_count = self.edges.len();
    }

    /// Edges in the order of leaves that others keep.
    pub(crate) fn of_edges(corners: Vec<Vec3>, triangles: Vec<[u32; 3]>, edges: Vec<Edge>) -> Self {
        let (triangle_count, edge_count) = (triangles.len(), edges.len());
        Self { corners, triangles, edges, triangle_count, edge_count, ..Self::default() }
    }

    /// Adds simplified forms, and with them a condition to each edge.
    pub(crate) fn add(&mut self, coarse: Coarse) {
        let fine = self.triangle_count as u32;
        self.triangles.extend(coarse.triangles);
        self.own.extend((self.corners.len()..).map(|i| i as u32).take(coarse.own.len()));
        self.corners.extend(coarse.own.iter().map(|i| self.corners[*i as usize]).collect::<Vec<_>>());
        self.sources.extend(coarse.own.iter().map(|i| self.sources[*i as usize]).collect::<Vec<_>>());
        self.triangle_patches = coarse.patches;
        self.triangle_patches.extend(coarse.triangle_patches);
        let all = topology::tagged_edges(&self.triangles, fine, &self.triangle_patches);
        for is_coarse in [false, true] {
            self.edge_count = self.edges.len();
            let these = || all.iter().filter(|(_, tag)| tag.is_coarse() == is_coarse);
            self.edges.extend(these().map(|(edge, _)| *edge));
            self.tags.extend(these().map(|(_, tag)| *tag));
        }
        self.left_out = coarse.left_out.iter().map(|[corner, near]| [*corner, near + fine]).collect();
        self.patch_count = coarse.count;
    }

    /// Puts the edges into the order of the leaves of two trees: of the mesh, and of edges with simplified forms.
    pub(crate) fn plant(&mut self) -> [Tree; 2] {
        let fine = self.edge_count;
        let tree = |edges: &[Edge], first: usize| {
            Tree::new(edges.iter().map(|edge| edge.bounds(&self.corners, &self.triangles)), first)
        };
        let (fine_edges, coarse_edges) = self.edges.split_at(fine);
        let ((tree, mut order), (coarse_tree, coarse_order)) =
            rayon::join(|| tree(fine_edges, 0), || tree(coarse_edges, fine));
        order.extend(coarse_order.iter().map(|i| i + fine as u32));
        self.edges = order.iter().map(|i| self.edges[*i as usize]).collect();
        if !self.tags.is_empty() {
            self.tags = order.iter().map(|i| self.tags[*i as usize]).collect();
        }
        [tree, coarse_tree]
    }

    /// Orders triangles and corners by their first use: neighbours among the edges become neighbours in memory.
    pub(crate) fn arrange(&mut self) {
        let places = topology::by_first_use(self.triangles.len(), self.edges.iter().flat_map(|e| e.triangles()));
        self.edges.iter_mut().for_each(|edge| edge.renumber(&places));
        self.triangles = topology::placed(&self.triangles, &places);
        self.triangle_patches = topology::placed(&self.triangle_patches, &places);
        self.left_out.iter_mut().for_each(|[_, near]| *near = places[*near as usize]);
        let places = topology::by_first_use(self.corners.len(), self.triangles.iter().flatten().copied());
        self.triangles.iter_mut().flatten().for_each(|corner| *corner = places[*corner as usize]);
        self.left_out.iter_mut().for_each(|[corner, _]| *corner = places[*corner as usize]);
        self.own.iter_mut().for_each(|corner| *corner = places[*corner as usize]);
        self.corners = topology::placed(&self.corners, &places);
        self.sources = topology::placed(&self.sources, &places);
    }
}
