//! The edges that a receiver must test: lists that near receivers share.

use crate::edge_list::EdgeList;
use crate::hull::{Fineness, Hull, Leaf, Memory};
use crate::levels::Levels;
use crate::placed::Placed;
use crate::tree::Tree;
use crate::{SilhouetteInstances, SilhouetteMesh};
use fearless_simd::{Level, Simd, dispatch};
use glam::Vec3;
use lobe_core::Sphere;
use shading::{LightId, Shaft};

/// Cells per side into which the receivers of a shaft are divided, each with a list of its own.
const CELLS: usize = 3;
/// Shorter lists are not divided.
const LONG: usize = 48;
/// A shaft has no list if it meets more leaves of the hierarchy than this, and more than so many times those of one receiver at its
/// centre: its receivers are then too far apart.
const SHAFT_LEAVES: usize = 64;
const SHAFT_TIMES: usize = 12;
/// Receivers in a sphere then share a list: its radius is this many times the distance to the nearest neighbour.
const NEIGHBOURS: f32 = 2.5;
/// The same limits for a sphere. If it has no list, so many receivers have lists of their own before the next try.
const NEARBY_LEAVES: usize = 128;
const NEARBY_TIMES: usize = 4;
const ALONE: u32 = 16;
/// A receiver that meets more leaves than this has no list, which would take 8 MB, and more time than rays through the samples of its mask.
const MOST_LEAVES: usize = 1 << 14;
/// The most edges of all lists that are kept.
const KEPT_EDGES: usize = 1 << 18;
/// More meshes than this have a hierarchy.
const MANY: usize = 16;
/// Number of spheres whose lists are kept.
const KEPT: usize = 16;

/// Meshes whose edges are numbered consecutively.
#[derive(Debug)]
pub(crate) struct Meshes<'m> {
    meshes: Vec<&'m SilhouetteMesh>,
    /// A hierarchy over the boxes of many meshes, and their numbers in the order of its leaves.
    top: Option<(Tree, Vec<u32>)>,
    /// The number of each mesh's first edge.
    bases: Vec<u32>,
    /// The number of their edges; those of instances come after them.
    own: u32,
    instances: Option<&'m SilhouetteInstances>,
    /// Whether places are left out whose mesh has forms for a whole sky there.
    has_forms: bool,
    pub(crate) fineness: Fineness,
}

/// Meshes before a whole sky.
#[derive(Debug)]
pub(crate) struct SkyMeshes<'m> {
    /// Forms of meshes.
    pub(crate) levels: Vec<&'m Levels>,
    /// Shared meshes of which some places have forms.
    pub(crate) placed: Option<&'m SilhouetteInstances>,
    /// All that has none.
    pub(crate) rest: Meshes<'m>,
}

impl<'m> Meshes<'m> {
    pub(crate) fn new(meshes: Vec<&'m SilhouetteMesh>) -> Self {
        let next = |sum: &mut u32, mesh: &&SilhouetteMesh| {
            let base = *sum;
            *sum += mesh.edge_count() as u32;
            Some(base)
        };
        let bases = meshes.iter().scan(0, next).collect();
        let own = meshes.iter().map(|mesh| mesh.edge_count() as u32).sum();
        let top = (meshes.len() > MANY).then(|| hierarchy(&meshes));
        Self { meshes, top, bases, own, instances: None, has_forms: false, fineness: Fineness::default() }
    }

    /// Makes the forms for a whole sky. None if no mesh has any.
    pub(crate) fn with_levels(&self) -> Option<SkyMeshes<'m>> {
        let (levels, rest): (Vec<_>, Vec<_>) = self.meshes.iter().copied().partition(|mesh| mesh.levels().is_some());
        let levels: Vec<&Levels> = levels.into_iter().filter_map(SilhouetteMesh::levels).collect();
        let placed = self.instances.filter(|all| all.have_levels());
        let (instances, fineness, has_forms) = (self.instances, self.fineness, placed.is_some());
        // Without forms all meshes are as they were, and so is the hierarchy over them.
        (!levels.is_empty() || has_forms).then(|| {
            let rest = Self { instances, fineness, has_forms, ..Self::new(rest) };
            SkyMeshes { levels, placed, rest }
        })
    }

    /// [`SilhouetteMesh::pack`] of all but instances.
    pub(crate) fn pack(&self) {
        self.meshes.iter().for_each(|mesh| mesh.pack());
    }

    /// Adds instances of shared meshes.
    pub(crate) fn with_instances(self, instances: &'m SilhouetteInstances) -> Self {
        Self { instances: (!instances.is_empty()).then_some(instances), ..self }
    }

    /// The place of an edge of an instance, and the edge's number in its mesh.
    fn placed(&self, edge: u32) -> Option<(Placed<'m>, usize)> {
        let instances = self.instances.filter(|_| edge >= self.own)?;
        Some(instances.find(edge - self.own))
    }

    /// On which sides of an edge's two triangles a point lies.
    pub(crate) fn sides(&self, edge: u32, x: Vec3) -> [f32; 2] {
        if let Some((placed, edge)) = self.placed(edge) {
            return placed.sides(edge, x);
        }
        let mesh = self.bases.partition_point(|base| *base <= edge) - 1;
        self.meshes[mesh].sides((edge - self.bases[mesh]) as usize, x)
    }

    /// Whether an edge is drawn for a receiver that looks at a light.
    pub(crate) fn is_drawn(&self, edge: u32, x: Vec3, light: Sphere) -> bool {
        self.is_drawn_at(edge, x, self.fineness.scale(x, light))
    }

    /// The same by [`Fineness::scale`].
    pub(crate) fn is_drawn_at(&self, edge: u32, x: Vec3, scale: f32) -> bool {
        if let Some((placed, edge)) = self.placed(edge) {
            return placed.is_drawn(edge, x, scale);
        }
        let mesh = self.bases.partition_point(|base| *base <= edge) - 1;
        self.meshes[mesh].is_drawn((edge - self.bases[mesh]) as usize, x, scale)
    }

    /// Lists the edges that may be silhouettes inside of a hull; returns in how many leaves they are. Gives up where these are
    /// more than `most`.
    pub(crate) fn list(&self, hull: &Hull, most: usize, memory: &mut Memory, out: &mut EdgeList) -> Option<usize> {
        out.clear();
        let mut left = most;
        let mut find = |number: usize, memory: &mut Memory, left: &mut usize| {
            let (mesh, base) = (self.meshes[number], self.bases[number]);
            dispatch!(Level::new(), simd => hull.find(simd, mesh, base, memory, left, out))
        };
        let all = match &self.top {
            None => (0..self.meshes.len()).all(|number| find(number, memory, &mut left)),
            Some(top) => {
                let met = met(hull, top, memory);
                let all = met.iter().all(|number| find(*number as usize, memory, &mut left));
                memory.met = met;
                all
            }
        };
        let all = all
            && self.instances.is_none_or(|instances| {
                let wanted = (instances, self.has_forms);
                dispatch!(Level::new(), simd => hull.find_instances(simd, wanted, self.own, memory, &mut left, out))
            });
        all.then(|| most - left)
    }
}

/// A hierarchy over meshes, and the order in which its leaves have them.
fn hierarchy(meshes: &[&SilhouetteMesh]) -> (Tree, Vec<u32>) {
    let trees = |number: u32| meshes[number as usize].trees().into_iter().filter(|tree| !tree.nodes().is_empty());
    let bounds = |number: u32| {
        let boxes = trees(number).map(Tree::bounds).reduce(|[a, b], [low, high]| [a.min(low), b.max(high)]);
        boxes.unwrap_or_default()
    };
    let numbers: Vec<u32> = (0..meshes.len() as u32).filter(|number| trees(*number).next().is_some()).collect();
    let (mut tree, order) = Tree::new(numbers.iter().map(|number| bounds(*number)), 0);
    let order: Vec<u32> = order.into_iter().map(|i| numbers[i as usize]).collect();
    // Without normals nothing is left out for its side.
    tree.fit(|range| order[range].iter().map(|number| (bounds(*number), Vec3::ZERO, None, 0.0)));
    (tree, order)
}

/// The numbers of the meshes that are inside of a hull, ascending, as all of them would be searched.
fn met(hull: &Hull, (tree, order): &(Tree, Vec<u32>), memory: &mut Memory) -> Vec<u32> {
    let mut met = core::mem::take(&mut memory.met);
    let Memory { stack, places, .. } = memory;
    places.clear();
    let mut all = usize::MAX;
    dispatch!(Level::new(), simd => hull.leaves(simd, tree, None, stack, &mut all, places));
    met.clear();
    let range = |leaf: &Leaf| leaf.first as usize..leaf.first as usize + usize::from(leaf.count);
    met.extend(places.iter().flat_map(|leaf| &order[range(leaf)]));
    met.sort_unstable();
    met
}

/// The lists of a shaft.
///
/// The hierarchy is searched once for the whole shaft if that gives a short list; cells of the receivers' box then narrow the list.
/// Otherwise it is searched for spheres around neighbours, or for single receivers if even neighbours see too different outlines.
#[derive(Clone, Debug)]
pub(crate) struct Lists {
    shaft: Shaft,
    margin: f32,
    fineness: Fineness,
    /// The edges of the whole shaft, if they were listed.
    edges: EdgeList,
    is_whole: bool,
    /// Whether the lists of single receivers are too long.
    is_too_long: bool,
    cells: Vec<Cell>,
    nearby: Vec<Nearby>,
    /// Spheres of this shaft so far.
    made: usize,
    /// Receivers of this shaft so far.
    seen: Vec<Vec3>,
    /// Number of leaves for the last receiver with a list of its own.
    single: usize,
    /// Number of receivers that still get lists of their own.
    alone: u32,
    memory: Memory,
}

#[derive(Clone, Debug, Default)]
struct Cell {
    edges: EdgeList,
    is_listed: bool,
}

/// Receivers in a sphere and their list.
#[derive(Clone, Debug, Default)]
struct Nearby {
    receivers: Sphere,
    edges: EdgeList,
}

impl Default for Lists {
    fn default() -> Self {
        Self {
            shaft: Shaft::new(Sphere::default(), Sphere::default(), LightId(0)),
            margin: 0.0,
            fineness: Fineness::default(),
            edges: EdgeList::default(),
            is_whole: true,
            is_too_long: false,
            cells: vec![Cell::default(); CELLS.pow(3)],
            nearby: vec![Nearby::default(); KEPT],
            made: 0,
            seen: Vec::new(),
            single: 0,
            alone: 0,
            memory: Memory::default(),
        }
    }
}

impl Lists {
    /// Begins a shaft whose rays start within `margin` of the receivers, with outlines of a fineness.
    pub(crate) fn enter(&mut self, meshes: &Meshes<'_>, shaft: &Shaft, margin: f32, fineness: Fineness) {
        self.cells.iter_mut().for_each(|cell| cell.is_listed = false);
        self.made = 0;
        self.seen.clear();
        self.alone = 0;
        self.shaft = *shaft;
        self.margin = margin;
        self.fineness = fineness;
        let Sphere { center, radius } = shaft.receivers;
        let mut list = |shaft: &Shaft, most| {
            meshes.list(&Hull::new(shaft, margin, fineness), most, &mut self.memory, &mut self.edges)
        };
        let first = if radius > 0.0 { SHAFT_LEAVES } else { MOST_LEAVES };
        self.is_whole = list(shaft, first).is_some();
        self.is_too_long = !self.is_whole && radius == 0.0;
        if !self.is_whole && radius > 0.0 {
            let middle = shaft.from_receivers(Sphere { center, radius: 0.0 });
            let single = list(&middle, MOST_LEAVES);
            self.is_too_long = single.is_none();
            self.single = single.unwrap_or_default();
            let most = (SHAFT_TIMES * self.single).min(MOST_LEAVES);
            self.is_whole = most > first && list(shaft, most).is_some();
        }
    }

    /// Whether a receiver meets too many leaves: rays are to tell what it sees.
    pub(crate) fn is_too_long(&self) -> bool {
        self.is_too_long
    }

    /// Whether no receiver of the shaft has edges to test.
    pub(crate) fn is_empty(&self) -> bool {
        self.is_whole && self.edges.is_empty()
    }

    /// How far from the receivers rays may start.
    pub(crate) fn margin(&self) -> f32 {
        self.margin
    }

    /// A sphere around all starts of rays.
    pub(crate) fn origins(&self) -> Sphere {
        let Sphere { center, radius } = self.shaft.receivers;
        Sphere { center, radius: radius + self.margin }
    }

    /// The edges of the whole shaft, if they were listed.
    pub(crate) fn whole(&self) -> Option<&EdgeList> {
        self.is_whole.then_some(&self.edges)
    }

    /// Whether the shaft has more than one receiver.
    pub(crate) fn is_shared(&self) -> bool {
        self.shaft.receivers.radius > 0.0
    }

    /// The edges that a receiver of the shaft must test; none if there are [too many](Self::is_too_long).
    #[inline(always)]
    pub(crate) fn at<S: Simd>(&mut self, simd: S, meshes: &Meshes<'_>, at: Vec3) -> &EdgeList {
        if self.is_too_long {
            self.edges.clear();
            return &self.edges;
        }
        if !self.is_whole {
            return self.around(meshes, at);
        }
        let Shaft { receivers: Sphere { center, .. }, half_extent, .. } = self.shaft;
        if self.edges.len() < LONG || !self.is_shared() {
            return &self.edges;
        }
        let size = 2.0 * half_extent / CELLS as f32;
        let low = center - half_extent;
        // In a box without thickness any cell will do.
        let place = ((at - low) / size).floor().clamp(Vec3::ZERO, Vec3::splat(CELLS as f32 - 1.0));
        let place = place.to_array().map(|x| x as usize);
        let cell = &mut self.cells[(place[0] * CELLS + place[1]) * CELLS + place[2]];
        if !cell.is_listed {
            let middle = low + (Vec3::from_array(place.map(|x| x as f32)) + 0.5) * size;
            let sphere = Sphere { center: middle, radius: 0.5 * size.length() };
            let shaft = self.shaft.from_receivers(sphere).in_box(0.5 * size);
            Hull::new(&shaft, self.margin, self.fineness).narrow(simd, &self.edges, &mut cell.edges);
            cell.is_listed = true;
        }
        &cell.edges
    }

    /// The list of a sphere that contains a receiver.
    fn around(&mut self, meshes: &Meshes<'_>, at: Vec3) -> &EdgeList {
        let is_in = |list: &Nearby| {
            let radius = list.receivers.radius;
            list.receivers.center.distance_squared(at) <= radius * radius
        };
        let known = self.nearby[..self.made.min(KEPT)].iter().position(is_in);
        let number = known.unwrap_or_else(|| self.add(meshes, at));
        self.seen.push(at);
        &self.nearby[number].edges
    }

    /// Makes a list for a receiver and for its neighbours, if these are known to be near.
    #[cold]
    fn add(&mut self, meshes: &Meshes<'_>, at: Vec3) -> usize {
        if self.nearby.iter().map(|near| near.edges.len()).sum::<usize>() > KEPT_EDGES {
            self.nearby.fill_with(Nearby::default);
            self.made = 0;
        }
        let number = self.made % KEPT;
        self.made += 1;
        let mut edges = core::mem::take(&mut self.nearby[number].edges);
        let near = self.seen.iter().map(|p| p.distance_squared(at)).filter(|d| *d > 0.0).fold(f32::INFINITY, f32::min);
        let is_alone = self.alone > 0 || near == f32::INFINITY;
        self.alone = self.alone.saturating_sub(1);
        let mut receivers = Sphere { center: at, radius: if is_alone { 0.0 } else { NEIGHBOURS * near.sqrt() } };
        let (shaft, margin, fineness) = (self.shaft, self.margin, self.fineness);
        let mut list = |receivers, most| {
            let hull = Hull::new(&shaft.from_receivers(receivers), margin, fineness);
            meshes.list(&hull, most, &mut self.memory, &mut edges)
        };
        let most = NEARBY_LEAVES.max(NEARBY_TIMES * self.single).min(MOST_LEAVES);
        if is_alone || list(receivers, most).is_none() {
            self.alone = if is_alone { self.alone } else { ALONE };
            receivers.radius = 0.0;
            let single = list(receivers, MOST_LEAVES);
            // The rest of the shaft's receivers as well.
            self.is_too_long = single.is_none();
            self.single = single.unwrap_or_default();
        }
        if self.is_too_long {
            edges.clear();
        }
        self.nearby[number] = Nearby { receivers, edges };
        number
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edge_list::COLUMNS;
    use lobe_core::oracle::Random;

    fn bits(list: &EdgeList) -> Vec<[u32; COLUMNS]> {
        (0..list.len()).map(|i| core::array::from_fn(|column| list.get(column, i).to_bits())).collect()
    }

    /// Cards at random, and one that has no edges: the same list by the hierarchy over them as one after the other.
    #[test]
    fn many_meshes_are_listed_as_few_are() {
        let mut random = Random::new(4);
        let mut vector = || random.axis().as_vec3() * random.between(0.1, 9.0) as f32;
        let mut card = |corners: u32| {
            let (p, u, v) = (vector(), 0.1 * vector(), 0.1 * vector());
            let triangles = [[0, 1, 2], [2, 1, 3]];
            SilhouetteMesh::new(0, &[p, p + u, p + v, p + u + v], &triangles[..corners as usize - 2])
        };
        let cards: Vec<SilhouetteMesh> = (0..100).map(|k| card(if k == 70 { 2 } else { 4 })).collect();
        let many = Meshes::new(cards.iter().collect());
        assert!(many.top.is_some());
        let few = Meshes { top: None, ..Meshes::new(cards.iter().collect()) };
        let (mut count, mut lists) = (0, [EdgeList::default(), EdgeList::default()]);
        for _ in 0..50 {
            let (receivers, light) =
                (Sphere { center: vector(), radius: 0.5 }, Sphere { center: vector(), radius: 1.0 });
            let hull = Hull::new(&Shaft::new(receivers, light, LightId(0)), 1e-3, Fineness::default());
            for (meshes, out) in [&many, &few].into_iter().zip(&mut lists) {
                meshes.list(&hull, usize::MAX, &mut Memory::default(), out).expect("as many as there are");
            }
            let [one, other] = lists.each_ref().map(bits);
            assert_eq!(one, other);
            count += one.len();
        }
        assert!(count > 100 && count < 10_000, "{count}");
    }

    /// A wavy sheet, and the same edges in lists with and without packets.
    #[test]
    fn packed_edges_are_listed_as_others_are() {
        const SIDE: u32 = 30;
        let at = |i: u32, k: u32| Vec3::new(i as f32, (i as f32 * 0.7).sin() + (k as f32 * 0.9).cos(), k as f32);
        let positions: Vec<Vec3> = (0..SIDE).flat_map(|i| (0..SIDE).map(move |k| at(i, k))).collect();
        let squares = (0..SIDE - 1).flat_map(|i| (0..SIDE - 1).map(move |k| i * SIDE + k));
        let triangles: Vec<[u32; 3]> =
            squares.flat_map(|a| [[a, a + SIDE, a + 1], [a + 1, a + SIDE, a + SIDE + 1]]).collect();
        let mesh = SilhouetteMesh::new(0, &positions, &triangles);
        // Numbers of the second one begin behind those of the first.
        let meshes = Meshes::new(vec![&mesh, &mesh]);
        let mut lists = [EdgeList::default(), EdgeList::default()];
        for (is_packed, out) in [false, true].into_iter().zip(&mut lists) {
            if is_packed {
                meshes.pack();
            }
            assert_eq!(mesh.packed(0).is_some(), is_packed);
            for origin in [Vec3::new(3.0, 2.0, 4.0), Vec3::new(20.0, -3.0, 9.0)] {
                let origins = [origin, origin + 0.3];
                let hull = Hull::of_sky(&origins, &[Vec3::Y, Vec3::X], None);
                let mut list = EdgeList::default();
                let leaves = meshes.list(&hull, usize::MAX, &mut Memory::default(), &mut list);
                assert!(leaves.is_some_and(|leaves| leaves > 20));
                (0..list.len()).for_each(|i| out.push(core::array::from_fn(|column| list.get(column, i))));
            }
        }
        let [plain, packed] = &lists;
        assert!(plain.len() > 300 && plain.len() == packed.len());
        for (column, i) in (0..COLUMNS).flat_map(|column| (0..plain.len()).map(move |i| (column, i))) {
            assert_eq!(plain.get(column, i).to_bits(), packed.get(column, i).to_bits(), "{column} {i}");
        }
    }
}
