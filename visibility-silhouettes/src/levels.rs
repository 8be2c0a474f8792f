//! Simplified forms of a mesh before a whole sky: each level simplifies larger patches than the one before.

use crate::coarse;
use crate::edge_list::{Block, COLUMNS};
use crate::mesh::{Patch, SilhouetteMesh};
use crate::topology::{self, Edge, Side, Sides, normal};
use crate::tree::{Tree, WIDE};
use core::ops::Range;
use fearless_simd::{Level, dispatch};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// The most triangles of the mesh in a patch of the first level. Patches of the next level have [`TIMES`] as many, until one is the mesh.
const FIRST: usize = 512;
const TIMES: usize = 8;
/// One in so many corners inside a patch is kept, of those that the level before has.
const KEPT: usize = 4;
/// A patch is seen in its form from this many of its radii away, and the part of the distance at which details as large as its own may be left out before
/// a light: outlines of one patch are a small part of a sky's (measured).
const NEAR: f32 = 1.2;
const DETAIL: f32 = 0.4;
/// Corners move by this part of the mean offset of those left out. A polyhedron of many triangles whose corners are on a sphere has the sphere's mean outline if these move out by half
/// of it; left-out corners are on facets themselves (measured: the sky over 400 bumpy spheres and an armadillo).
const SETTLE: f64 = 0.45;
/// A mesh has no levels if the first one keeps more than this part of its triangles.
const WORTH: f64 = 0.6;
/// The most forms: their numbers fit into a [`Tag`].
const MOST: usize = 1 << 16;

/// The forms of the triangles on the two sides of an edge; 0 for the second where it is the first, or where there is no triangle.
pub(crate) type Tag = [u16; 2];

/// Forms of a mesh, of which any receiver sees some that are closed together.
///
/// # Method
/// A mesh is halved into patches, patches of patches, and so on up to the whole. Each has a form that keeps its rim, made of the forms of the
/// patches in it: inside, the rims of those are simplified too. A receiver sees a patch in its form from a distance on; of patches in each
/// other it sees the largest form. Of patches without a form that is seen it sees the mesh. An edge on a rim is stored for all pairs of
/// forms that may meet there.
#[derive(Clone, Debug)]
pub(crate) struct Levels {
    /// The edges of all forms, eight places for each leaf, without a hierarchy.
    mesh: SilhouetteMesh,
    /// Of each leaf's edges the ends and planes side by side, and the tag that all of them have.
    leaves: Vec<(Block<COLUMNS>, Tag)>,
    /// Patches before those in them.
    nodes: Vec<Node>,
    /// For each form the hierarchy of its edges, those inside before those on its rim where it meets forms that are not finer.
    forms: Vec<Tree>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    patch: Patch,
    /// Behind the last of the patches in it.
    end: u32,
    /// The form of the mesh itself there, of patches of the first level; 0 for others.
    fine: u16,
}

impl Node {
    /// Whether a receiver sees the patch in its form, if it is in no other one that it sees so.
    fn is_far(&self, from: Vec3, scale: f32) -> bool {
        let Patch { center, radius, detail } = self.patch;
        from.distance(center) > NEAR * radius + DETAIL * scale * detail
    }
}

/// The form of a patch by its number.
fn form_of(node: usize) -> u16 {
    node as u16 + 1
}

/// A patch while forms are made.
#[derive(Clone, Debug)]
struct Part {
    range: Range<usize>,
    level: usize,
    parent: Option<usize>,
    end: usize,
}

/// A form while forms are made: its triangles, a box around all that it stands for, and the square of what it differs by.
#[derive(Clone, Debug, Default)]
struct Made {
    triangles: Vec<[u32; 3]>,
    bounds: [Vec3; 2],
    detail_sq: f64,
}

impl Made {
    fn patch(&self) -> Patch {
        let [low, high] = self.bounds;
        Patch { center: 0.5 * (low + high), radius: 0.5 * low.distance(high), detail: self.detail_sq.sqrt() as f32 }
    }
}

impl Levels {
    /// Of a mesh, from its positions now. None if it saves too little.
    ///
    /// # Cost
    /// About as much time as [`SilhouetteMesh::with_coarse`], and 300 bytes a triangle.
    pub(crate) fn new(mesh: &SilhouetteMesh) -> Option<Self> {
        let (mut corners, fine) = mesh.fine_triangles();
        let (parts, order) = parts(&corners, &fine);
        let made = make(&parts, &order, &fine, &mut corners)?;
        let Forms { nodes, triangles, of_triangles, chains } = Forms::of(&parts, &made, &order, &fine)?;
        let mut edges = tagged(&triangles, &of_triangles, &chains);
        // Whatever the forms for lights are: these may have borders where those of a closed mesh have none.
        let is_closed = edges.iter().all(|(edge, _)| edge.other().is_some());
        edges.sort_by_key(|(_, tag)| *tag);
        let leaves = in_leaves(&edges, &corners, &triangles);
        let mut placed = Vec::with_capacity(leaves.len() * WIDE);
        let mut ranges: Vec<Vec<Range<usize>>> = vec![Vec::new(); chains.len()];
        for (tag, leaf) in &leaves {
            let first = placed.len();
            ranges[usize::from(tag[0])].push(first..first + leaf.len());
            // Places of which nothing is read.
            placed.extend(leaf.iter().chain(core::iter::repeat(&leaf[0])).take(WIDE));
        }
        let mesh = SilhouetteMesh::of_edges(corners, triangles, placed, is_closed);
        let mut forms: Vec<Tree> = ranges.iter().map(|leaves| Tree::over(leaves)).collect();
        forms.par_iter_mut().for_each(|tree| tree.fit(|range| range.filter_map(|i| mesh.shape(i))));
        let columns_of = |number: usize| {
            let mut block: Block<COLUMNS> = [[0.0; WIDE]; COLUMNS];
            let first = number * WIDE;
            dispatch!(Level::new(), simd => {
                mesh.fetch_planes(simd, first, WIDE, &mut block);
                mesh.fetch_ends(simd, first, 255, [0; 2], 0, &mut block);
            });
            block
        };
        let leaves = leaves.par_iter().enumerate().map(|(number, (tag, _))| (columns_of(number), *tag)).collect();
        Some(Self { mesh, leaves, nodes, forms })
    }

    /// Lists the forms that a receiver sees; `seen` says of each whether it is among them.
    ///
    /// A simplified form is seen of a patch that is far enough away and in no other one that is.
    pub(crate) fn choose(&self, from: Vec3, scale: f32, list: &mut Vec<u16>, seen: &mut Vec<bool>) {
        seen.clear();
        seen.resize(self.forms.len(), false);
        // On the other side of edges inside of a form.
        seen[0] = true;
        list.clear();
        let mut number = 0;
        while let Some(node) = self.nodes.get(number) {
            let is_far = node.is_far(from, scale);
            let form = if is_far { form_of(number) } else { node.fine };
            if form != 0 {
                list.push(form);
                seen[usize::from(form)] = true;
            }
            number = if is_far { node.end as usize } else { number + 1 };
        }
    }

    pub(crate) fn is_closed(&self) -> bool {
        self.mesh.is_closed()
    }

    /// The hierarchy of a form.
    pub(crate) fn tree(&self, form: u16) -> &Tree {
        &self.forms[usize::from(form)]
    }

    /// The edges of a leaf by the number of the first of them, and their tag.
    #[inline(always)]
    pub(crate) fn leaf(&self, first: u32) -> &(Block<COLUMNS>, Tag) {
        &self.leaves[first as usize / WIDE]
    }

    /// [`SilhouetteMesh::sides`].
    pub(crate) fn sides(&self, edge: u32, x: Vec3) -> [f32; 2] {
        self.mesh.sides(edge as usize, x)
    }

    pub(crate) fn is_fine(&self, form: u16) -> bool {
        usize::from(form) > self.nodes.len()
    }

    /// The radius of a sphere around the mesh.
    pub(crate) fn radius(&self) -> f32 {
        self.nodes.first().map_or(0.0, |node| node.patch.radius)
    }

    /// Whether it is a simplified form.
    pub(crate) fn is_coarse(&self, form: u16) -> bool {
        form != 0 && !self.is_fine(form)
    }

    /// Memory, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let trees: usize = self.forms.iter().map(|tree| tree.bytes() + size_of::<Tree>()).sum();
        self.mesh.bytes() + size_of_val(&self.leaves[..]) + size_of_val(&self.nodes[..]) + trees
    }
}

/// Patches of triangles in each other, larger ones first, and the order of the triangles in them.
fn parts(corners: &[Vec3], triangles: &[[u32; 3]]) -> (Vec<Part>, Vec<u32>) {
    let middle = |t: &[u32; 3]| t.iter().map(|i| corners[*i as usize]).sum();
    let middles: Vec<Vec3> = triangles.par_iter().map(middle).collect();
    let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
    let mut parts = Vec::new();
    let mut level = 0;
    while FIRST * TIMES.pow(level as u32) < triangles.len() {
        level += 1;
    }
    divide(&mut order, 0, (level, None), &middles, &mut parts);
    (parts, order)
}

/// Halves a list of triangles by their middles until it is a patch of a level, and then of the levels below.
fn divide(
    order: &mut [u32],
    first: usize,
    (level, parent): (usize, Option<usize>),
    middles: &[Vec3],
    parts: &mut Vec<Part>,
) {
    if order.len() <= FIRST * TIMES.pow(level as u32) {
        let number = parts.len();
        parts.push(Part { range: first..first + order.len(), level, parent, end: 0 });
        if level > 0 {
            divide(order, first, (level - 1, Some(number)), middles, parts);
        }
        parts[number].end = parts.len();
        return;
    }
    let middle = |t: &u32| middles[*t as usize];
    let none = [Vec3::INFINITY, Vec3::NEG_INFINITY];
    let bounds = order.iter().map(middle).fold(none, |[a, b], m| [a.min(m), b.max(m)]);
    let axis = (bounds[1] - bounds[0]).max_position();
    let half = order.len() / 2;
    order.select_nth_unstable_by(half, |a, b| middle(a)[axis].total_cmp(&middle(b)[axis]).then(a.cmp(b)));
    let (low, high) = order.split_at_mut(half);
    divide(low, first, (level, parent), middles, parts);
    divide(high, first + half, (level, parent), middles, parts);
}

/// The forms of all patches. Their inner corners are new ones.
fn make(parts: &[Part], order: &[u32], fine: &[[u32; 3]], corners: &mut Vec<Vec3>) -> Option<Vec<Made>> {
    let mut all = vec![Made::default(); parts.len()];
    let mut inside: Vec<Vec<usize>> = vec![Vec::new(); parts.len()];
    for (number, part) in parts.iter().enumerate() {
        if let Some(parent) = part.parent {
            inside[parent].push(number);
        }
    }
    let levels = parts.first()?.level;
    for level in 0..=levels {
        let of_level: Vec<usize> = (0..parts.len()).filter(|number| parts[*number].level == level).collect();
        let made: Vec<(Made, Vec<u32>, Vec<Vec3>)> = of_level
            .par_iter()
            .map(|number| {
                let own = order[parts[*number].range.clone()].iter().map(|t| fine[*t as usize]);
                let below: Vec<&Made> = inside[*number].iter().map(|k| &all[*k]).collect();
                let triangles = if level == 0 {
                    own.collect()
                } else {
                    below.iter().flat_map(|made| made.triangles.iter().copied()).collect::<Vec<_>>()
                };
                made_of(&triangles, &below, corners)
            })
            .collect();
        for (number, (mut made, inner, moved)) in of_level.into_iter().zip(made) {
            let first = corners.len() as u32;
            for corner in made.triangles.iter_mut().flatten() {
                if let Ok(place) = inner.binary_search(corner) {
                    *corner = first + place as u32;
                }
            }
            corners.extend(moved);
            all[number] = made;
        }
        if level == 0 {
            let kept: usize = all.iter().map(|made| made.triangles.len()).sum();
            if kept as f64 > WORTH * fine.len() as f64 {
                return None;
            }
        }
    }
    Some(all)
}

/// The form of a patch, its inner corners in the numbers of those that they replace, and their places.
fn made_of(triangles: &[[u32; 3]], below: &[&Made], corners: &[Vec3]) -> (Made, Vec<u32>, Vec<Vec3>) {
    let all: Vec<u32> = (0..triangles.len() as u32).collect();
    let coarse::Reduced { triangles: kept, inner, left_out } =
        coarse::Patch::new(corners, triangles, &all).reduced(KEPT);
    let mut sums = vec![(DVec3::ZERO, 0.0); inner.len()];
    for [corner, near] in &left_out {
        let own = kept[*near as usize];
        let (n, away) = offset(own.map(|i| corners[i as usize]), corners[*corner as usize]);
        for place in own.iter().filter_map(|i| inner.binary_search(i).ok()) {
            sums[place].0 += n * away;
            sums[place].1 += 1.0;
        }
    }
    let settled =
        |(i, (sum, count)): (&u32, &(DVec3, f64))| corners[*i as usize] + (*sum * (SETTLE / count.max(1.0))).as_vec3();
    let moved: Vec<Vec3> = inner.iter().zip(&sums).map(settled).collect();
    let place = |i: u32| inner.binary_search(&i).map_or(corners[i as usize], |place| moved[place]);
    let away = |[corner, near]: &[u32; 2]| distance(kept[*near as usize].map(place), corners[*corner as usize]);
    let own_sq = left_out.iter().map(|pair| away(pair).powi(2)).sum::<f64>() / left_out.len().max(1) as f64;
    let before = below.iter().map(|made| made.detail_sq).sum::<f64>() / below.len().max(1) as f64;
    let join = |[a, b]: [Vec3; 2], [c, d]: [Vec3; 2]| [a.min(c), b.max(d)];
    let none = [Vec3::INFINITY, Vec3::NEG_INFINITY];
    let around = triangles.iter().flatten().map(|i| corners[*i as usize]).chain(moved.iter().copied());
    let bounds = around.map(|p| [p; 2]).chain(below.iter().map(|made| made.bounds)).fold(none, join);
    (Made { triangles: kept, bounds, detail_sq: own_sq + before }, inner, moved)
}

/// The unit normal of a triangle, and how far a point is before its plane.
fn offset(corners: [Vec3; 3], p: Vec3) -> (DVec3, f64) {
    let n = normal(corners).normalize_or_zero();
    (n, n.dot(p.as_dvec3() - corners[0].as_dvec3()))
}

/// How far a point is from a triangle. A limb that a form leaves out may lie in the planes of those that are left.
fn distance(corners: [Vec3; 3], p: Vec3) -> f64 {
    let [a, b, c] = corners.map(|corner| corner.as_dvec3());
    let (n, p) = ((b - a).cross(c - a), p.as_dvec3());
    let sides = [(a, b), (b, c), (c, a)];
    if n != DVec3::ZERO && sides.iter().all(|(u, v)| n.cross(*v - *u).dot(p - *u) >= 0.0) {
        return n.normalize().dot(p - a).abs();
    }
    let to_side = |(u, v): (DVec3, DVec3)| {
        let along = (p - u).dot(v - u) / (v - u).length_squared().max(f64::MIN_POSITIVE);
        p.distance(u + along.clamp(0.0, 1.0) * (v - u))
    };
    sides.into_iter().map(to_side).fold(f64::INFINITY, f64::min)
}

/// All forms while levels are made.
struct Forms {
    nodes: Vec<Node>,
    /// The triangles of all forms, and the form of each.
    triangles: Vec<[u32; 3]>,
    of_triangles: Vec<u16>,
    /// By the numbers of forms.
    chains: Vec<Chain>,
}

impl Forms {
    /// Numbers the forms of patches, then those of the mesh itself in patches of the first level; `None` if there are too many.
    fn of(parts: &[Part], made: &[Made], order: &[u32], fine: &[[u32; 3]]) -> Option<Self> {
        let fine_forms = parts.iter().filter(|part| part.level == 0).count();
        let count = parts.len() + 1 + fine_forms;
        if count > MOST {
            return None;
        }
        let mut next_fine = form_of(parts.len());
        let nodes = Vec::with_capacity(parts.len());
        let chains = vec![Chain::default(); count];
        let mut all = Self { nodes, triangles: Vec::new(), of_triangles: Vec::new(), chains };
        for (number, (part, made)) in parts.iter().zip(made).enumerate() {
            let form = form_of(number);
            all.add(form, made.triangles.iter().copied());
            all.chains[usize::from(form)] = Chain { place: part.level + 1, above: part.parent.map_or(0, form_of) };
            let mut node = Node { patch: made.patch(), end: part.end as u32, fine: 0 };
            if part.level == 0 {
                node.fine = next_fine;
                all.add(next_fine, order[part.range.clone()].iter().map(|t| fine[*t as usize]));
                all.chains[usize::from(next_fine)] = Chain { place: 0, above: form };
                next_fine += 1;
            }
            all.nodes.push(node);
        }
        Some(all)
    }

    fn add(&mut self, form: u16, triangles: impl Iterator<Item = [u32; 3]>) {
        self.triangles.extend(triangles);
        self.of_triangles.resize(self.triangles.len(), form);
    }
}

/// Edges in the order of their tags, in leaves of neighbours with one tag.
fn in_leaves(edges: &[(Edge, Tag)], corners: &[Vec3], triangles: &[[u32; 3]]) -> Vec<(Tag, Vec<Edge>)> {
    let runs: Vec<&[(Edge, Tag)]> = edges.chunk_by(|a, b| a.1 == b.1).collect();
    let leaves_of = |run: &&[(Edge, Tag)]| {
        let (tree, order) = Tree::new(run.iter().map(|(edge, _)| edge.bounds(corners, triangles)), 0);
        let edges: Vec<Edge> = order.iter().map(|i| run[*i as usize].0).collect();
        tree.leaves().into_iter().map(|leaf| (run[0].1, edges[leaf].to_vec())).collect::<Vec<_>>()
    };
    runs.par_iter().flat_map_iter(leaves_of).collect()
}

/// The place of a form among those of the patches in each other, and the form above it; 0 for none.
#[derive(Clone, Copy, Debug, Default)]
struct Chain {
    place: usize,
    above: u16,
}

/// The edges of triangles of several forms, with their tags. Whatever forms are drawn that are seen together, each side of each of their triangles occurs once.
fn tagged(triangles: &[[u32; 3]], forms: &[u16], chains: &[Chain]) -> Vec<(Edge, Tag)> {
    let form = |side: &Side| forms[side.triangle() as usize];
    Sides::of(triangles).collect(|group, edges| {
        if group.iter().all(|side| form(side) == form(&group[0])) {
            topology::pairs(group, |edge| edges.push((edge, [form(&group[0]), 0])));
            return;
        }
        let mut group = group.to_vec();
        group.sort_by_key(|side| (form(side), side.is_down()));
        // Inside of a form as many sides run up as down.
        let mut rest = Vec::new();
        for own in group.chunk_by(|a, b| form(a) == form(b)) {
            if own.iter().filter(|side| side.is_down()).count() * 2 == own.len() {
                topology::pairs(own, |edge| edges.push((edge, [form(&own[0]), 0])));
            } else {
                rest.extend_from_slice(own);
            }
        }
        let (mut down, mut up): (Vec<Side>, Vec<Side>) = rest.into_iter().partition(Side::is_down);
        let top = |sides: &mut Vec<Side>| {
            sides.sort_by_key(|side| chains[usize::from(form(side))].place);
            let is_chain = sides.iter().enumerate().all(|(place, side)| chains[usize::from(form(side))].place == place)
                && sides.windows(2).all(|two| chains[usize::from(form(&two[0]))].above == form(&two[1]));
            sides.last().filter(|_| is_chain).map(|side| chains[usize::from(form(side))].above)
        };
        let tops = [top(&mut up), top(&mut down)];
        if tops[0].is_some() && tops[0] == tops[1] {
            for (one, other) in up.iter().flat_map(|one| down.iter().map(move |other| (one, other))) {
                let edge = Edge::new(one, other.triangle());
                let [a, b] = [form(one), form(other)];
                let is_finer = chains[usize::from(a)].place <= chains[usize::from(b)].place;
                edges.push((edge, if is_finer { [a, b] } else { [b, a] }));
            }
        } else {
            edges.extend(up.iter().chain(&down).map(|side| (Edge::new(side, topology::NONE), [form(side), 0])));
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_core::oracle::Random;
    use std::collections::BTreeMap;

    /// A wavy sheet with a hole and a fin that stands on it: borders, and edges of three triangles.
    fn sheet(random: &mut Random) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        const SIDE: u32 = 90;
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for i in 0..=SIDE {
            for k in 0..=SIDE {
                let height = (i as f32 * 0.2).sin() + (k as f32 * 0.15).cos() + random.uniform() as f32 * 0.05;
                positions.push(Vec3::new(i as f32, height, k as f32));
            }
        }
        let corner = |i: u32, k: u32| i * (SIDE + 1) + k;
        for (i, k) in (0..SIDE).flat_map(|i| (0..SIDE).map(move |k| (i, k))) {
            if (20..24).contains(&i) && (50..60).contains(&k) {
                continue;
            }
            let [a, b, c, d] = [corner(i, k), corner(i + 1, k), corner(i, k + 1), corner(i + 1, k + 1)];
            triangles.extend([[a, b, c], [c, b, d]]);
        }
        positions.push(Vec3::new(45.0, 9.0, 45.0));
        let top = positions.len() as u32 - 1;
        triangles.extend((0..SIDE).map(|k| [corner(45, k), corner(45, k + 1), top]));
        (positions, triangles)
    }

    /// Bodies with long limbs, side by side.
    fn stars(count: u32, n: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for body in 0..count {
            let first = positions.len() as u32;
            let tilt = glam::Quat::from_rotation_x(0.4 + body as f32);
            for (ring, k) in (0..=n).flat_map(|ring| (0..n).map(move |k| (ring, k))) {
                let theta = (ring as f32 + 0.01) / (n as f32 + 0.02) * core::f32::consts::PI;
                let phi = k as f32 / n as f32 * core::f32::consts::TAU;
                let d = Vec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin());
                let limbs = [Vec3::X, Vec3::Y, Vec3::NEG_X, Vec3::new(0.0, -0.6, 0.8), Vec3::new(0.0, -0.6, -0.8)];
                let limb = |limb: Vec3| 1.5 * ((d.dot(limb) - 1.0) * 30.0).exp();
                let radius = 0.5 + limbs.into_iter().map(limb).sum::<f32>();
                positions.push(tilt * d * radius + Vec3::X * 5.0 * body as f32);
                let at = |ring: u32, k: u32| first + ring * n + k % n;
                let [a, b, c, d] = [at(ring, k), at(ring, k + 1), at(ring + 1, k), at(ring + 1, k + 1)];
                triangles.extend((ring < n).then_some([[a, b, c], [b, d, c]]).into_iter().flatten());
            }
        }
        (positions, triangles)
    }

    /// The detail of a form is no less than what its surface is off by, also where whole limbs are left out.
    #[test]
    fn forms_say_what_they_leave_out() {
        let (mut corners, fine) = stars(4, 64);
        let (parts, order) = parts(&corners, &fine);
        let made = make(&parts, &order, &fine, &mut corners).expect("a large mesh");
        let mut most = 0.0_f64;
        for (part, made) in parts.iter().zip(&made).filter(|(part, _)| part.level > 0) {
            let own = order[part.range.clone()].iter().flat_map(|t| fine[*t as usize]).step_by(37);
            let nearest = |i: u32| {
                let of = |t: &[u32; 3]| distance(t.map(|k| corners[k as usize]), corners[i as usize]);
                made.triangles.iter().map(of).fold(f64::INFINITY, f64::min)
            };
            let all: Vec<f64> = own.map(|i| nearest(i).powi(2)).collect();
            let off = (all.iter().sum::<f64>() / all.len() as f64).sqrt();
            let detail = made.detail_sq.sqrt();
            println!("level {}: {} triangles, {off:.4} off, detail {detail:.4}", part.level, made.triangles.len());
            assert!(off <= detail, "{off} > {detail}");
            most = most.max(off);
        }
        assert!(most > 0.01, "nothing is left out: {most}");
    }

    /// From any place, and on any side of each triangle, all outlines are closed, and each side of each triangle that is seen occurs once.
    #[test]
    fn forms_that_are_seen_are_closed() {
        let mut random = Random::new(5);
        let (positions, triangles) = sheet(&mut random);
        let mesh = SilhouetteMesh::with_coarse(0, &positions, &triangles);
        let levels = mesh.levels().expect("a large mesh");
        let (corners, all, _) = levels.mesh.geometry();
        let (mut kinds, mut rims) = ([0; 2], 0);
        for case in 0..60 {
            let from = Vec3::new(random.between(-40.0, 130.0) as f32, 3.0, random.between(-40.0, 130.0) as f32);
            let scale = random.log_uniform(10.0, 1000.0) as f32;
            let (mut list, mut seen) = (Vec::new(), Vec::new());
            levels.choose(from, scale, &mut list, &mut seen);
            let side: Vec<i32> = (0..all.len()).map(|_| (random.uniform() * 3.0) as i32 - 1).collect();
            let (mut ends, mut sides) = (BTreeMap::new(), BTreeMap::new());
            // Places where the mesh meets its forms.
            let fine = list.iter().filter(|form| levels.is_fine(**form)).count();
            rims += usize::from(fine > 0 && fine < list.len());
            for form in &list {
                kinds[usize::from(levels.is_fine(*form))] += 1;
                for leaf in levels.tree(*form).leaves() {
                    let (_, [_, other]) = levels.leaf(leaf.start as u32);
                    if !seen[usize::from(*other)] {
                        continue;
                    }
                    for edge in leaf {
                        let (one, other, _) = levels.mesh.triangles_of(edge);
                        let ([p, q], _) = levels.mesh.ends_of(edge);
                        let step = side[one as usize] - other.map_or(0, |t| side[t as usize]);
                        *ends.entry(p.to_array().map(f32::to_bits)).or_insert(0) -= step;
                        *ends.entry(q.to_array().map(f32::to_bits)).or_insert(0) += step;
                        *sides.entry(one).or_insert(0) += 1;
                        other.into_iter().for_each(|t| *sides.entry(t).or_insert(0) += 1);
                    }
                }
            }
            assert!(ends.values().all(|sum| *sum == 0), "case {case}");
            assert!(sides.values().all(|count| *count == 3), "case {case}");
            let area = |t: &u32| {
                let [a, b, c] = all[*t as usize].map(|i| corners[i as usize].truncate());
                (b.x - a.x) * (c.z - a.z) - (b.z - a.z) * (c.x - a.x)
            };
            // Seen triangles cover the sheet once: the hole is 4 by 10 squares, and the fin stands upright.
            let covered: f32 = sides.keys().map(|t| 0.5 * area(t).abs()).sum();
            assert!((covered - 8060.0).abs() < 300.0, "case {case}: {covered}");
        }
        assert!(kinds.iter().all(|count| *count > 50) && rims > 20, "{kinds:?} {rims}");
    }
}
