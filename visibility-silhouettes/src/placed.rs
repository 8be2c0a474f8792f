//! Shared meshes at places of their own.

use crate::edge_list::{Block, COLUMNS, PLANES};
use crate::fit::{plane, side};
use crate::lanes::{columns, put_ends, upward};
use crate::levels::Levels;
use crate::mesh::SilhouetteMesh;
use crate::tree::Tree;
use fearless_simd::Simd;
use glam::{DMat4, DVec3, Mat4, Vec3};
use lobe_core::scales_evenly;
use lobe_core::vec3x8::LANES;
use rayon::prelude::*;

/// Axes of a place whose lengths differ by more than this have no simplified forms: their details would differ as well.
const EVEN: f64 = 1e-3;

/// A mesh's place in the world.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    mesh: u32,
    object: u32,
    matrix: Mat4,
    inverse: DMat4,
    /// The largest factor by which the inverse lengthens.
    shrink: f32,
    /// Whether all directions are scaled alike.
    is_even: bool,
    bounds: [Vec3; 2],
}

impl Place {
    #[inline(always)]
    pub(crate) fn to_world(&self, p: Vec3) -> Vec3 {
        self.matrix.transform_point3(p)
    }

    pub(crate) fn to_own(&self, p: Vec3) -> DVec3 {
        self.inverse.transform_point3(p.as_dvec3())
    }

    pub(crate) fn direction_to_own(&self, v: DVec3) -> DVec3 {
        self.inverse.transform_vector3(v)
    }

    pub(crate) const fn matrix(&self) -> &Mat4 {
        &self.matrix
    }

    pub(crate) const fn shrink(&self) -> f32 {
        self.shrink
    }

    pub(crate) const fn is_even(&self) -> bool {
        self.is_even
    }
}

/// Meshes that are prepared once and stand at several places, each as an object of its own or as a part of one.
///
/// Their outlines are those of meshes that have been moved there, decided by the same numbers: the corners of the places, rounded as
/// [`Mat4::transform_point3`] rounds them. Simplified forms are made for the shared mesh.
///
/// # Cost
/// About 62 bytes a triangle of the shared meshes, and 300 for each place.
#[derive(Clone, Debug, Default)]
pub struct SilhouetteInstances {
    meshes: Vec<SilhouetteMesh>,
    places: Vec<Place>,
    /// A hierarchy over the places, and their order in its leaves.
    top: Tree,
    /// The number of each place's first edge, from 0.
    bases: Vec<u32>,
}

/// A mesh that stands at places: its corners, its triangles, and for each place the number of its object and a matrix to the world.
#[derive(Clone, Copy, Debug)]
pub struct SharedMesh<'a> {
    /// Corners in the mesh's own coordinates.
    pub positions: &'a [Vec3],
    /// Triangles.
    pub triangles: &'a [[u32; 3]],
    /// Objects and matrices, which are affine and not flat.
    pub places: &'a [(u32, Mat4)],
    /// Whether it has simplified forms ([`SilhouetteMesh::with_coarse`]).
    pub is_coarse: bool,
}

/// How far the rounding of corners in the world moves them, over the numbers that are added up.
const ROUNDING: f64 = 4e-7;

fn abs(matrix: &Mat4, reach: Vec3) -> Vec3 {
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.truncate().abs());
    x * reach.x + y * reach.y + z * reach.z + matrix.w_axis.truncate().abs()
}

impl SilhouetteInstances {
    /// Prepares meshes at their places.
    ///
    /// # Panics
    /// When a triangle has a corner that is not among the positions.
    #[must_use]
    pub fn new(shared: &[SharedMesh<'_>]) -> Self {
        Self::with_earlier(shared, |_| None).0
    }

    /// The same where some of the meshes are prepared already: `earlier` gives what was made of the mesh with a number, with simplified forms
    /// or without as now, and for places that may have been others. Also returns how many were prepared: those without, and those
    /// whose places round corners to more or fewer digits than before.
    ///
    /// # Panics
    /// As [`new`](Self::new).
    pub fn with_earlier(
        shared: &[SharedMesh<'_>],
        mut earlier: impl FnMut(usize) -> Option<SilhouetteMesh>,
    ) -> (Self, usize) {
        let mut all = Self::default();
        let mut made = 0;
        for (number, mesh) in shared.iter().enumerate() {
            let reach = mesh.positions.iter().fold(Vec3::ZERO, |reach, p| reach.max(p.abs()));
            let of_mesh = |(object, matrix): &(u32, Mat4)| place(number as u32, *object, *matrix, mesh);
            let places: Vec<Place> = mesh.places.par_iter().map(of_mesh).collect();
            let blur = blur(&places, reach);
            let kept = earlier(number).filter(|kept| kept.blur() == blur);
            made += usize::from(kept.is_none());
            all.meshes.push(
                kept.unwrap_or_else(|| SilhouetteMesh::shared(mesh.positions, mesh.triangles, blur, mesh.is_coarse)),
            );
            all.places.extend(places);
        }
        all.arrange();
        (all, made)
    }

    /// The prepared meshes, in the order in which they were given, without their places.
    #[must_use]
    pub fn into_meshes(self) -> Vec<SilhouetteMesh> {
        self.meshes
    }

    /// Orders the places as the leaves of a hierarchy over them have them.
    fn arrange(&mut self) {
        let (mut top, order) = Tree::new(self.places.iter().map(|place| place.bounds), 0);
        self.places = order.iter().map(|i| self.places[*i as usize].clone()).collect();
        let places = &self.places;
        top.fit(|range| places[range].iter().map(|place| (place.bounds, Vec3::ZERO, None, 0.0)));
        self.top = top;
        let mut next = 0;
        self.bases.clear();
        for place in &self.places {
            self.bases.push(next);
            next += self.meshes[place.mesh as usize].edge_count() as u32;
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// The objects that stand at places, each as often as it does.
    pub fn objects(&self) -> impl Iterator<Item = u32> {
        self.places.iter().map(|place| place.object)
    }

    /// The prepared meshes.
    #[must_use]
    pub fn meshes(&self) -> &[SilhouetteMesh] {
        &self.meshes
    }

    /// Memory, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let meshes: usize = self.meshes.iter().map(SilhouetteMesh::bytes).sum();
        meshes + size_of_val(&self.places[..]) + size_of_val(&self.bases[..]) + self.top.bytes()
    }

    pub(crate) const fn top(&self) -> &Tree {
        &self.top
    }

    /// Makes the forms for a whole sky; whether any place has some.
    pub(crate) fn have_levels(&self) -> bool {
        let all = (0..self.places.len()).map(|place| self.at(place).0);
        all.fold(false, |any, placed| any | placed.levels().is_some())
    }

    /// A place with its mesh and the number of its first edge.
    pub(crate) fn at(&self, place: usize) -> (Placed<'_>, u32) {
        let own = &self.places[place];
        (Placed { mesh: &self.meshes[own.mesh as usize], place: own }, self.bases[place])
    }

    /// The place of an edge, and the edge's number in its mesh.
    pub(crate) fn find(&self, edge: u32) -> (Placed<'_>, usize) {
        let place = self.bases.partition_point(|base| *base <= edge) - 1;
        let (placed, base) = self.at(place);
        (placed, (edge - base) as usize)
    }
}

/// The rounding of any of a mesh's places, in the mesh's own units: a power of two, so that few moves of a place change it.
fn blur(places: &[Place], reach: Vec3) -> f32 {
    let of_place =
        |place: &Place| ROUNDING * f64::from(abs(&place.matrix, reach).max_element()) * f64::from(place.shrink);
    let most = places.iter().map(of_place).fold(0.0, f64::max) as f32;
    let power = f32::from_bits(most.to_bits() & 0x7f80_0000);
    if power < most { 2.0 * power } else { power }
}

fn place(mesh: u32, object: u32, matrix: Mat4, shared: &SharedMesh<'_>) -> Place {
    let inverse = matrix.as_dmat4().inverse();
    let lengths = [inverse.x_axis, inverse.y_axis, inverse.z_axis].map(|axis| axis.truncate().length_squared());
    // At most the root of the sum of squares.
    let shrink = lengths.iter().sum::<f64>().sqrt();
    let scale = matrix.x_axis.truncate().as_dvec3().length();
    let is_even = scales_evenly(&matrix, scale, EVEN);
    let shrink = if is_even { 1.002 / scale } else { shrink };
    let none = [Vec3::INFINITY, Vec3::NEG_INFINITY];
    let [low, high] = shared.positions.iter().fold(none, |[low, high], p| {
        let p = matrix.transform_point3(*p);
        [low.min(p), high.max(p)]
    });
    // The corners of simplified forms move a little.
    let margin = if shared.is_coarse { 0.01 * (high - low).length() } else { 0.0 };
    Place { mesh, object, matrix, inverse, shrink: shrink as f32, is_even, bounds: [low - margin, high + margin] }
}

/// A mesh at a place.
#[derive(Clone, Copy)]
pub(crate) struct Placed<'m> {
    pub(crate) mesh: &'m SilhouetteMesh,
    pub(crate) place: &'m Place,
}

impl<'m> Placed<'m> {
    /// The mesh's forms for a whole sky, where all directions are scaled alike.
    pub(crate) fn levels(&self) -> Option<&'m Levels> {
        self.mesh.levels().filter(|_| self.place.is_even())
    }

    #[inline(always)]
    fn corners(&self, triangle: u32) -> [Vec3; 3] {
        let [a, b, c] = self.mesh.corners(triangle);
        [self.place.to_world(a), self.place.to_world(b), self.place.to_world(c)]
    }

    /// [`SilhouetteMesh::sides`] in the world.
    pub(crate) fn sides(&self, edge: usize, x: Vec3) -> [f32; 2] {
        self.mesh.sides_by(edge, |t| side(self.corners(t), x))
    }

    /// [`SilhouetteMesh::is_drawn`].
    pub(crate) fn is_drawn(&self, edge: usize, from: Vec3, scale: f32) -> bool {
        self.mesh.is_drawn(edge, self.place.to_own(from).as_vec3(), scale)
    }

    /// Writes the ends and numbers of edges in `lanes`: [`SilhouetteMesh::fetch_ends`] in the world.
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
            let ([p, q], is_down) = self.mesh.ends_of(first + lane);
            let [p, q] = [self.place.to_world(p), self.place.to_world(q)];
            ([p.extend(0.0).to_array(), q.extend(0.0).to_array()], is_down)
        });
        put_ends(simd, &ends, base + first as u32, marks, out);
    }

    /// Writes the planes on both sides of edges in `lanes`, computed from the corners in the world.
    #[inline(always)]
    pub(crate) fn fetch_planes<S: Simd>(&self, simd: S, first: usize, mut lanes: u32, out: &mut Block<COLUMNS>) {
        let mut sides = [[[0.0; 4]; LANES]; 2];
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize & (LANES - 1);
            lanes &= lanes - 1;
            let (one, other, is_down) = self.mesh.triangles_of(first + lane);
            sides[usize::from(is_down)][lane] = plane(self.corners(one));
            sides[usize::from(!is_down)][lane] = other.map_or([0.0; 4], |t| plane(self.corners(t)));
        }
        for (rows, first) in sides.iter().zip(PLANES) {
            columns(simd, rows, &mut out[first..first + 4]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::edge_list::EdgeList;
    use crate::hull::{Fineness, Hull, Memory};
    use crate::lists::Meshes;
    use crate::select::{NUMBERS, Silhouettes, silhouettes};
    use core::f32::consts::{PI, TAU};
    use fearless_simd::{Level, dispatch};
    use glam::Quat;
    use lobe_core::oracle::Random;
    use lobe_core::{Cone, Sphere};
    use shading::{LightId, Shaft};

    /// A bumpy sphere of `n` rings, with a fin that makes it open and a box whose faces have two triangles each.
    fn shape(n: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for ring in 0..=n {
            for k in 0..n {
                let [theta, phi] = [(ring as f32 + 0.3) / (n + 1) as f32 * PI, k as f32 / n as f32 * TAU];
                let radius = 1.0 + 0.2 * (3.0 * phi).sin() * theta.sin();
                let across = radius * theta.sin();
                positions.push(Vec3::new(across * phi.cos(), radius * theta.cos(), across * phi.sin()));
            }
        }
        for ring in 0..n {
            for k in 0..n {
                let at = |ring: u32, k: u32| ring * n + k % n;
                let [a, b, c, d] = [at(ring, k), at(ring, k + 1), at(ring + 1, k), at(ring + 1, k + 1)];
                triangles.extend([[a, b, c], [b, d, c]]);
            }
        }
        let mut add = |corners: &[Vec3], of: &[[u32; 3]]| {
            let first = positions.len() as u32;
            positions.extend_from_slice(corners);
            triangles.extend(of.iter().map(|t| t.map(|i| i + first)));
        };
        add(&[Vec3::ZERO, Vec3::new(2.0, 0.3, 0.0), Vec3::new(1.5, 1.4, 0.4)], &[[0, 1, 2]]);
        let corner = |k: u32| Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2) as f32) * 0.7 - 1.6;
        let corners: Vec<Vec3> = (0..8).map(corner).collect();
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces: Vec<[u32; 3]> = faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        add(&corners, &faces);
        (positions, triangles)
    }

    fn matrix(random: &mut Random, case: usize) -> Mat4 {
        let turn = Quat::from_axis_angle(random.axis().as_vec3().normalize(), random.between(0.0, 6.0) as f32);
        let size = random.log_uniform(0.05, 20.0) as f32;
        let scale = match case % 4 {
            0 => Vec3::splat(size),
            1 => Vec3::new(-size, size, size),
            2 => Vec3::new(size, 3.0 * size, 0.4 * size),
            _ => Vec3::ONE,
        };
        let far = [0.0, 3.0, 1000.0][case % 3];
        Mat4::from_scale_rotation_translation(scale, turn, random.axis().as_vec3() * (far * size))
    }

    /// Silhouettes of a receiver before a light, as bits, in the order of these.
    fn outlines(meshes: &Meshes<'_>, shaft: &Shaft, x: Vec3, most: &mut usize) -> Vec<[u32; NUMBERS]> {
        let mut list = EdgeList::default();
        let hull = Hull::new(shaft, 1e-4 * shaft.receivers.radius, Fineness::default());
        *most += meshes.list(&hull, usize::MAX, &mut Memory::default(), &mut list).expect("no limit");
        let mut found = Silhouettes::default();
        let cone = Cone::of_sphere(x, shaft.light);
        dispatch!(Level::new(), simd => {
            silhouettes(simd, x, (&cone, None), &list, (|edge| meshes.sides(edge, x), |_| true), &mut found)
        });
        let mut bits: Vec<_> =
            (0..found.len()).map(|i| core::array::from_fn(|c| (found.get(c, i) + 0.0).to_bits())).collect();
        bits.sort_unstable();
        bits
    }

    /// Any receiver and light have the silhouettes of the mesh that has been moved, to the bit.
    #[test]
    fn places_have_the_outlines_of_moved_meshes() {
        let mut random = Random::new(8);
        let (positions, triangles) = shape(14);
        let (mut seen, mut looks) = (0, 0);
        let mut leaves = [0; 2];
        for case in 0..240 {
            let matrix = matrix(&mut random, case);
            let moved: Vec<Vec3> = positions.iter().map(|p| matrix.transform_point3(*p)).collect();
            let whole = SilhouetteMesh::new(0, &moved, &triangles);
            let places = [(0, matrix)];
            let shared = SharedMesh { positions: &positions, triangles: &triangles, places: &places, is_coarse: false };
            let instances = SilhouetteInstances::new(&[shared]);
            let [own, placed] = [Meshes::new(vec![&whole]), Meshes::new(Vec::new()).with_instances(&instances)];
            let middle = matrix.transform_point3(Vec3::ZERO);
            let size = matrix.x_axis.length();
            for _ in 0..20 {
                let mut point =
                    |reach: f64| middle + random.axis().as_vec3() * (size * random.log_uniform(0.3, reach) as f32);
                let (from, to) = (point(4.0), point(30.0));
                let receivers = Sphere { center: from, radius: 0.3 * size };
                let light = Sphere { center: to, radius: size * 0.4 };
                let shaft = Shaft::new(receivers, light, LightId(0));
                let x = from + random.axis().as_vec3() * (0.2 * size);
                if x.distance(to) < 2.0 * light.radius {
                    continue;
                }
                let [want, have] = [(&own, 0), (&placed, 1)].map(|(m, k)| outlines(m, &shaft, x, &mut leaves[k]));
                assert_eq!(have, want, "case {case}: {matrix}");
                seen += want.len();
                looks += 1;
            }
        }
        assert!(2 * seen > looks && looks > 1000, "{seen} of {looks}");
        // Cones are wider by the rounding, and boxes are turned.
        assert!(leaves[1] < 3 * leaves[0], "{leaves:?}");
    }
}
