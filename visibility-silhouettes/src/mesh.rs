use crate::coarse::{self, Coarse};
use crate::draft::Draft;
use crate::edge_list::{Block, COLUMNS, PLANES};
use crate::fit::{self, fit_patches, fit_planes, is_flat, least_height, settle, side};
use crate::lanes::{columns, put_ends, upward};
use crate::levels::Levels;
use crate::topology::{Edge, Tag};
use crate::tree::{Reach, Shape, Tree};
use core::mem::take;
use core::ops::Range;
use fearless_simd::{Level, Simd, dispatch};
use glam::{Vec3, Vec4};
use lobe_core::vec3x8::LANES;
use rayon::prelude::*;
use std::sync::OnceLock;

/// A triangle mesh prepared for finding its silhouettes: planes of triangles, edges with the triangles on both sides, and a
/// hierarchy of the edges.
///
/// Any triangles are allowed: open, self-intersecting, wound either way, with more than two triangles at an edge. Triangles with
/// two equal corners are left out. The mesh may move ([`refit`](Self::refit)) as long as its triangles keep their corners.
///
/// # Cost
/// About 62 bytes a triangle; [`with_coarse`](Self::with_coarse) 30 more, and twice the time.
#[derive(Clone, Debug)]
pub struct SilhouetteMesh {
    /// The number of the object that the triangles belong to.
    object: u32,
    /// With an unused fourth number, so that eight positions are quickly transposed into columns.
    positions: Vec<Vec4>,
    /// For each of `positions` the index of the caller's position that it copies.
    sources: Vec<u32>,
    triangles: Vec<[u32; 3]>,
    /// Unit normal `n` and `−n·a`, from f64.
    planes: Vec<[f32; 4]>,
    /// Edges of the mesh in the order of its tree's leaves, then those of simplified forms in the order of their tree.
    edges: Vec<Edge>,
    tree: Tree,
    coarse_tree: Tree,
    is_closed: bool,
    /// Triangles of the mesh itself.
    triangle_count: usize,
    /// For each edge its condition to be drawn; empty if all are always drawn.
    tags: Vec<Tag>,
    patches: Vec<Patch>,
    /// The patch of each triangle.
    triangle_patches: Vec<u16>,
    /// Corners that only simplified forms have, and corners that these leave out, with the triangles next to them.
    own: Vec<u32>,
    left_out: Vec<[u32; 2]>,
    /// Of a shared mesh, by how much rounding moves its corners at its places. Any of its edges may be a silhouette then.
    blur: Option<f32>,
    /// Then, for each edge, the sine of the angle by which this turns its triangles, and a packet of zeros.
    turns: Vec<f32>,
    /// Forms for a whole sky, made for the first one.
    levels: OnceLock<Option<Box<Levels>>>,
    /// For a sky before a mesh without simplified forms, the edges of each leaf side by side; empty for others.
    packets: OnceLock<Vec<Packet>>,
}

/// Up to eight edges of a leaf, by their numbers in the mesh, and which of them are there and not flat, as bits.
#[derive(Clone, Debug)]
pub(crate) struct Packet {
    pub(crate) columns: Block<COLUMNS>,
    pub(crate) lanes: u32,
}

/// Simplified forms are not drawn for receivers nearer than this many radii of their patch: some of these receivers would need one
/// form and some the other, and lists would contain both.
const NEAR: f32 = 1.5;

/// A part of a mesh with a simplified form: a sphere around it, and the difference of the form.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Patch {
    pub(crate) center: Vec3,
    pub(crate) radius: f32,
    pub(crate) detail: f32,
}

impl Patch {
    /// Whether a receiver sees the simplified form: from this distance on, in units of the difference, it cannot tell the outlines
    /// apart.
    #[inline(always)]
    pub(crate) fn is_coarse(&self, from: Vec3, scale: f32) -> bool {
        from.distance(self.center) > NEAR * self.radius + self.detail * scale
    }

    /// The same for all receivers in a sphere, if they agree.
    pub(crate) fn is_coarse_from(&self, center: Vec3, radius: f32, scale: [f32; 2]) -> Option<bool> {
        let distance = center.distance(self.center);
        let rounding = 1e-5 * (distance + center.abs().element_sum());
        if distance - radius - rounding > NEAR * self.radius + self.detail * scale[1] {
            Some(true)
        } else if distance + radius + rounding < NEAR * self.radius + self.detail * scale[0] {
            Some(false)
        } else {
            None
        }
    }
}

impl SilhouetteMesh {
    /// Prepares a mesh: pairs its edges and builds the hierarchy.
    ///
    /// # Panics
    /// When a triangle has a corner that is not among `positions`, and for more than 2²⁹ triangles.
    #[must_use]
    pub fn new(object: u32, positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        Self::make(object, positions, triangles, None, |_, _| None)
    }

    /// As [`new`](Self::new), for a mesh that stands at places, where rounding moves its corners by up to `blur` in the mesh's own units.
    pub(crate) fn shared(positions: &[Vec3], triangles: &[[u32; 3]], blur: f32, is_coarse: bool) -> Self {
        let simplify = if is_coarse { coarse::coarse } else { |_: &[Vec3], _: &[[u32; 3]]| None };
        Self::make(0, positions, triangles, Some(blur), simplify)
    }

    /// As [`new`](Self::new), with simplified forms for receivers that are far away and allow them
    /// ([`SilhouetteBlockers::with_tolerance`](crate::SilhouetteBlockers::with_tolerance)): for large meshes.
    ///
    /// # Panics
    /// As [`new`](Self::new).
    #[must_use]
    pub fn with_coarse(object: u32, positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        Self::make(object, positions, triangles, None, coarse::coarse)
    }

    fn make(
        object: u32,
        positions: &[Vec3],
        triangles: &[[u32; 3]],
        blur: Option<f32>,
        simplify: impl Fn(&[Vec3], &[[u32; 3]]) -> Option<Coarse>,
    ) -> Self {
        let (mut draft, sides) = Draft::welded(positions, triangles);
        match simplify(&draft.corners, &draft.triangles) {
            Some(coarse) => draft.add(coarse),
            None => draft.pair(&sides),
        }
        drop(sides);
        let trees = draft.plant();
        draft.arrange();
        let is_closed = draft.edges.iter().all(|edge| edge.other().is_some());
        let mut mesh = Self { object, blur, ..Self::of(draft, trees, is_closed) };
        mesh.fit();
        mesh
    }

    /// A mesh in its final order, before anything is computed from its positions.
    fn of(draft: Draft, [tree, coarse_tree]: [Tree; 2], is_closed: bool) -> Self {
        Self {
            object: 0,
            positions: draft.corners.iter().map(|p| p.extend(0.0)).collect(),
            sources: draft.sources,
            planes: vec![[0.0; 4]; draft.triangles.len()],
            triangles: draft.triangles,
            edges: draft.edges,
            tree,
            coarse_tree,
            is_closed,
            triangle_count: draft.triangle_count,
            tags: draft.tags,
            patches: vec![Patch::default(); draft.patch_count],
            triangle_patches: draft.triangle_patches,
            own: draft.own,
            left_out: draft.left_out,
            blur: None,
            turns: Vec::new(),
            levels: OnceLock::new(),
            packets: OnceLock::new(),
        }
    }

    /// Follows a mesh that has moved: the same triangles with new positions. Returns `false` and changes nothing if the number of
    /// positions does not fit.
    ///
    /// Equal corners stay one corner; a triangle without area blocks nothing until it has one.
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

    /// Computes planes, flat edges, boxes and cones from the positions.
    fn fit(&mut self) {
        self.levels = OnceLock::new();
        self.packets = OnceLock::new();
        self.fit_planes();
        self.fit_edges();
        self.fit_turns();
        let Self { positions, triangles, planes, patches, triangle_patches, left_out, .. } = self;
        fit_patches(patches, triangle_patches, left_out, triangles, positions, planes);
        let mut trees = [take(&mut self.tree), take(&mut self.coarse_tree)];
        for (tree, is_coarse) in trees.iter_mut().zip([false, true]) {
            tree.fit(|range| range.filter_map(|edge| self.shape(edge)));
            if !self.patches.is_empty() {
                tree.fit_reaches(|range, middle| self.reach(range, middle, is_coarse));
            }
        }
        [self.tree, self.coarse_tree] = trees;
    }

    /// Moves the corners of simplified forms, and computes the planes of all triangles.
    fn fit_planes(&mut self) {
        let Self { positions, triangles, planes, own, left_out, .. } = self;
        fit_planes(planes, triangles, positions, |_| true);
        if !own.is_empty() {
            let mut moves = vec![false; positions.len()];
            own.iter().for_each(|i| moves[*i as usize] = true);
            settle(own, left_out, triangles, planes, positions);
            fit_planes(planes, triangles, positions, |corners| corners.iter().any(|i| moves[*i as usize]));
        }
    }

    /// Finds the edges that are never silhouettes.
    fn fit_edges(&mut self) {
        let Self { positions, triangles, planes, edges, blur, .. } = self;
        let corners = |t: u32| fit::corners(positions, triangles, t);
        let is_sharp = blur.is_none();
        edges.par_iter_mut().with_min_len(1024).for_each(|edge| {
            let flat = is_sharp
                && edge.other().is_some_and(|other| {
                    let [p, q] = [edge.triangle(), other].map(|t| planes[t as usize]);
                    let alike = p[0] * q[0] + p[1] * q[1] + p[2] * q[2] > 0.999_999;
                    alike && is_flat(corners(edge.triangle()), corners(other))
                });
            edge.set_flat(flat);
        });
    }

    /// Computes by how much rounding turns the triangles of a shared mesh.
    fn fit_turns(&mut self) {
        let Some(blur) = self.blur else { return };
        let turn = |t: u32| (4.0 * blur / least_height(self.corners(t))).min(1.0);
        let turns = self.edges.par_iter().map(|edge| turn(edge.triangle()).max(edge.other().map_or(0.0, turn)));
        self.turns = turns.chain([0.0; LANES]).collect();
    }

    /// For eight edges the sine of the angle by which rounding turns the triangles of a shared mesh.
    #[inline(always)]
    pub(crate) fn turns(&self, first: usize) -> [f32; LANES] {
        self.turns.get(first..).and_then(<[f32]>::first_chunk).copied().unwrap_or_default()
    }

    /// The largest distance at which any of some edges of the mesh may be drawn, or the smallest one for edges of simplified forms.
    fn reach(&self, edges: Range<usize>, middle: Vec3, is_coarse: bool) -> Reach {
        let of = |(patch, _): (u16, bool)| {
            let Patch { center, radius, detail } = self.patches[usize::from(patch)];
            let sign = if is_coarse { -1.0 } else { 1.0 };
            Reach { reach: center.distance(middle) + sign * NEAR * radius, detail: sign * detail }
        };
        let one = |tag: &Tag| tag.patches().filter(|(_, c)| *c == is_coarse).map(of).reduce(|a, b| a.and(b, 0.0));
        let all = self.tags.get(edges).unwrap_or_default().iter().map(one);
        all.reduce(|a, b| Some(a?.and(b?, 0.0))).flatten().unwrap_or(Reach::EVERYWHERE)
    }

    /// Whether its surface has no border, however it is wound: then as many of its triangles face a receiver along a ray as face away, up to
    /// one number.
    pub(crate) fn is_closed(&self) -> bool {
        self.is_closed
    }

    /// The forms for a whole sky, made from the positions now: those of meshes with simplified forms that save enough.
    pub(crate) fn levels(&self) -> Option<&Levels> {
        if self.patches.is_empty() {
            return None;
        }
        self.levels.get_or_init(|| Levels::new(self).map(Box::new)).as_deref()
    }

    /// Puts the edges of each leaf side by side, for many searches: of meshes without simplified forms, which are small.
    pub(crate) fn pack(&self) {
        if self.patches.is_empty() && self.blur.is_none() {
            self.packets.get_or_init(|| (0..self.edges.len()).step_by(LANES).map(|first| self.packet(first)).collect());
        }
    }

    fn packet(&self, first: usize) -> Packet {
        let mut columns: Block<COLUMNS> = [[0.0; LANES]; COLUMNS];
        let lanes = dispatch!(Level::new(), simd => {
            let lanes = self.fetch_planes(simd, first, self.edges.len() - first, &mut columns);
            self.fetch_ends(simd, first, lanes, [0; 2], 0, &mut columns);
            lanes
        });
        Packet { columns, lanes }
    }

    /// The edges of the leaf that begins with an edge, if they are [packed](Self::pack).
    #[inline(always)]
    pub(crate) fn packed(&self, first: usize) -> Option<&Packet> {
        self.packets.get()?.get(first / LANES)
    }

    /// Corners, and the triangles of the mesh itself between them.
    pub(crate) fn fine_triangles(&self) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let mut is_fine = vec![false; self.triangles.len()];
        let edges = self.edges.iter().enumerate().filter(|(i, _)| !self.tag(*i).is_coarse());
        edges.flat_map(|(_, edge)| edge.triangles()).for_each(|t| is_fine[t as usize] = true);
        let fine = self.triangles.iter().zip(is_fine).filter(|(_, is_fine)| *is_fine).map(|(t, _)| *t);
        (self.positions.iter().map(|p| p.truncate()).collect(), fine.collect())
    }

    /// A mesh of edges in this order, for which others keep a hierarchy: planes and corners.
    pub(crate) fn of_edges(corners: Vec<Vec3>, triangles: Vec<[u32; 3]>, edges: Vec<Edge>, is_closed: bool) -> Self {
        let mut draft = Draft::of_edges(corners, triangles, edges);
        draft.arrange();
        let used = draft.triangles.iter().flatten().max().map_or(0, |last| *last as usize + 1);
        draft.corners.truncate(used);
        let mut mesh = Self::of(draft, [Tree::default(), Tree::default()], is_closed);
        mesh.fit();
        mesh
    }

    /// An edge for a hierarchy; none for one that is never a silhouette.
    pub(crate) fn shape(&self, number: usize) -> Option<Shape> {
        let edge = self.edges[number];
        if edge.is_flat() {
            return None;
        }
        let normal = |t: u32| Vec3::from_slice(&self.planes[t as usize]);
        let (one, other) = (edge.triangle(), edge.other());
        let corners = self.corners(one);
        let turn = self.turns.get(number).copied().unwrap_or_default();
        Some((edge.ends().map(|k| corners[k]), normal(one), other.map(normal), turn))
    }

    /// Gives the object another number.
    pub fn set_object(&mut self, object: u32) {
        self.object = object;
    }

    /// The number of the object.
    #[must_use]
    pub fn object(&self) -> u32 {
        self.object
    }

    /// Number of triangles with three different corners.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.triangle_count
    }

    /// Number of edges, including those of simplified forms.
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
            + size_of_val(&self.turns[..])
            + self.tree.bytes()
            + self.coarse_tree.bytes()
            + size_of_val(&self.tags[..])
            + size_of_val(&self.patches[..])
            + size_of_val(&self.triangle_patches[..])
            + size_of_val(&self.own[..])
            + size_of_val(&self.left_out[..])
            + self.levels.get().and_then(Option::as_ref).map_or(0, |levels| levels.bytes())
            + self.packets.get().map_or(0, |packets| size_of_val(&packets[..]))
    }

    /// The tree of the mesh's edges, and that of edges with simplified forms.
    pub(crate) fn trees(&self) -> [&Tree; 2] {
        [&self.tree, &self.coarse_tree]
    }

    pub(crate) fn patches(&self) -> &[Patch] {
        &self.patches
    }

    /// Corners, triangles and their planes, including those of simplified forms.
    pub(crate) fn geometry(&self) -> (&[Vec4], &[[u32; 3]], &[[f32; 4]]) {
        (&self.positions, &self.triangles, &self.planes)
    }

    /// The edges of the mesh without simplified forms, in the order of its tree: the ends of each upward, and the triangles that
    /// run along it upward and downward; no triangles if the edge is never a silhouette.
    pub(crate) fn upward_edges(&self) -> impl Iterator<Item = ([u32; 2], [Option<u32>; 2])> {
        let fine = self.edges.iter().enumerate().take_while(|(i, _)| !self.tag(*i).is_coarse());
        fine.map(|(_, edge)| {
            let corners = &self.triangles[edge.triangle() as usize];
            let mut ends = edge.ends().map(|k| corners[k]);
            let mut sides = [Some(edge.triangle()), edge.other()];
            if edge.is_down() {
                ends.reverse();
                sides.reverse();
            }
            (ends, if edge.is_flat() { [None; 2] } else { sides })
        })
    }

    /// The condition of an edge to be drawn.
    #[inline(always)]
    pub(crate) fn tag(&self, edge: usize) -> Tag {
        self.tags.get(edge).copied().unwrap_or_default()
    }

    /// Whether an edge is drawn for a receiver.
    pub(crate) fn is_drawn(&self, edge: usize, from: Vec3, scale: f32) -> bool {
        self.tag(edge)
            .patches()
            .all(|(patch, coarse)| self.patches[usize::from(patch)].is_coarse(from, scale) == coarse)
    }

    /// Writes the planes on both sides of up to eight edges side by side; returns which of them are not flat, as bits.
    #[inline(always)]
    pub(crate) fn fetch_planes<S: Simd>(&self, simd: S, first: usize, count: usize, out: &mut Block<COLUMNS>) -> u32 {
        let mut lanes = 0;
        let mut sides = [[[0.0; 4]; LANES]; 2];
        for (lane, edge) in self.edges[first..first + count.min(LANES)].iter().enumerate() {
            // Upward, so that all records of an edge compute the same, whatever the hierarchy.
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

    /// The same for the ends and numbers of the edges in `lanes`. `base` is the number of the mesh's first edge. The first of
    /// `marks` has the lanes that are not always drawn; the second is set in all numbers.
    #[inline(always)]
    pub(crate) fn fetch_ends<S: Simd>(
        &self,
        simd: S,
        first: usize,
        lanes: u32,
        marks: [u32; 2],
        base: u32,
        out: &mut Block<COLUMNS>,
    ) {
        let ends = upward(lanes, |lane| {
            let edge = self.edges[first + lane];
            let corners = &self.triangles[edge.triangle() as usize];
            (edge.ends().map(|k| self.positions[corners[k] as usize].to_array()), edge.is_down())
        });
        put_ends(simd, &ends, base + first as u32, marks, out);
    }

    /// The sides on which a point lies of the triangles that run along an edge upward and downward: 1 in front, −1 behind, 0 in the
    /// plane or if there is no triangle. Exact except for the rounding of f64.
    pub(crate) fn sides(&self, edge: usize, x: Vec3) -> [f32; 2] {
        self.sides_by(edge, |t| side(self.corners(t), x))
    }

    /// The same by the side of each triangle.
    pub(crate) fn sides_by(&self, edge: usize, side: impl Fn(u32) -> f32) -> [f32; 2] {
        let (one, other, is_down) = self.triangles_of(edge);
        let [one, other] = [side(one), other.map_or(0.0, side)];
        if is_down { [other, one] } else { [one, other] }
    }

    /// The two triangles at an edge, and whether the first runs along it downward.
    pub(crate) fn triangles_of(&self, edge: usize) -> (u32, Option<u32>, bool) {
        let edge = self.edges[edge];
        (edge.triangle(), edge.other(), edge.is_down())
    }

    /// The ends of an edge in the direction of its first triangle, and whether that is downward.
    #[inline(always)]
    pub(crate) fn ends_of(&self, edge: usize) -> ([Vec3; 2], bool) {
        let edge = self.edges[edge];
        let corners = &self.triangles[edge.triangle() as usize];
        let [from, to] = edge.ends();
        let [p, q] = [self.positions[corners[from] as usize], self.positions[corners[to] as usize]];
        ([p.truncate(), q.truncate()], edge.is_down())
    }

    /// The corners of a triangle.
    pub(crate) fn corners(&self, triangle: u32) -> [Vec3; 3] {
        fit::corners(&self.positions, &self.triangles, triangle)
    }

    /// By how much rounding moves the corners of a shared mesh.
    pub(crate) fn blur(&self) -> f32 {
        self.blur.unwrap_or_default()
    }
}
