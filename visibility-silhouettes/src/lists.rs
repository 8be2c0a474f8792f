//! The edges that a receiver must test: lists that near receivers share.

use crate::edge_list::EdgeList;
use crate::hull::{Fineness, Hull, Memory};
use crate::levels::Levels;
use crate::placed::Placed;
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
/// Number of spheres whose lists are kept.
const KEPT: usize = 16;

/// Meshes whose edges are numbered consecutively.
#[derive(Debug)]
pub(crate) struct Meshes<'m> {
    meshes: Vec<&'m SilhouetteMesh>,
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
        Self { meshes, bases, own, instances: None, has_forms: false, fineness: Fineness::default() }
    }

    /// Makes the forms for a whole sky. None if no mesh has any.
    pub(crate) fn with_levels(&self) -> Option<SkyMeshes<'m>> {
        let (levels, rest): (Vec<_>, Vec<_>) = self.meshes.iter().copied().partition(|mesh| mesh.levels().is_some());
        let levels: Vec<&Levels> = levels.into_iter().filter_map(SilhouetteMesh::levels).collect();
        let placed = self.instances.filter(|all| all.have_levels());
        let (instances, fineness, has_forms) = (self.instances, self.fineness, placed.is_some());
        let rest = Self { instances, fineness, has_forms, ..Self::new(rest) };
        (!levels.is_empty() || has_forms).then_some(SkyMeshes { levels, placed, rest })
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
        let all = self.meshes.iter().zip(&self.bases).all(|(mesh, base)| {
            dispatch!(Level::new(), simd => {
                hull.find(simd, mesh, *base, memory, &mut left, out)
            })
        });
        let all = all
            && self.instances.is_none_or(|instances| {
                let wanted = (instances, self.has_forms);
                dispatch!(Level::new(), simd => hull.find_instances(simd, wanted, self.own, memory, &mut left, out))
            });
        all.then(|| most - left)
    }
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
        let first = if radius > 0.0 { SHAFT_LEAVES } else { usize::MAX };
        self.is_whole = list(shaft, first).is_some();
        if !self.is_whole {
            let middle = shaft.from_receivers(Sphere { center, radius: 0.0 });
            self.single = list(&middle, usize::MAX).unwrap_or_default();
            let most = SHAFT_TIMES * self.single;
            self.is_whole = most > first && list(shaft, most).is_some();
        }
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

    /// The edges that a receiver of the shaft must test.
    #[inline(always)]
    pub(crate) fn at<S: Simd>(&mut self, simd: S, meshes: &Meshes<'_>, at: Vec3) -> &EdgeList {
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
        let most = NEARBY_LEAVES.max(NEARBY_TIMES * self.single);
        if is_alone || list(receivers, most).is_none() {
            self.alone = if is_alone { self.alone } else { ALONE };
            receivers.radius = 0.0;
            self.single = list(receivers, usize::MAX).unwrap_or_default();
        }
        self.nearby[number] = Nearby { receivers, edges };
        number
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edge_list::COLUMNS;

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
