//! Shared meshes at their places: one hierarchy for each mesh, in its own coordinates, and one over the places.

use super::Update;
use super::build::build;
use super::primitive::Corners;
use super::tree::{Tree, hierarchy_scale};
use core::cell::Cell;
use glam::{Mat4, Vec3, Vec3A};
use obvhs::Boundable;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::node::CwBvhNode;
use obvhs::ray::Ray;
use obvhs::triangle::Triangle;
use rayon::prelude::*;
use scene::{Duplicates, Instances, Mesh, Scene, Shape};
use std::sync::Arc;

/// Eight values, one for each child of a node.
pub(super) type Lanes = [f32; 8];

/// By how much boxes are widened, over the coordinates from which they are computed: several times the rounding of corners.
const ROUNDING: f32 = 1e-6;
/// The same over the distance to the start of a ray.
const RAY_ROUNDING: f32 = 5e-7;

/// A mesh that stands at places, and its hierarchy.
struct Shared {
    mesh: Arc<Mesh>,
    bvh: CwBvh,
    /// Units of the hierarchy a unit of the mesh.
    scale: f32,
    /// The largest coordinates along the axes.
    reach: Vec3,
}

/// A place of a shared mesh.
#[derive(Clone, Copy)]
struct Instance {
    shared: u32,
    object: u32,
    visible: bool,
    /// The object's number of its first triangle.
    index: u32,
    /// Its first number among all triangles of instances.
    first: u32,
    matrix: Mat4,
    is_mirrored: bool,
    /// From the hierarchy's units to the world; boxes are wider by `pad`.
    axes: [Vec3; 3],
    pad: Vec3,
}

/// An instance in the hierarchy over all.
#[derive(Clone, Copy)]
pub(super) struct InstanceBox {
    instance: u32,
    bounds: Aabb,
}

impl Boundable for InstanceBox {
    fn aabb(&self) -> Aabb {
        self.bounds
    }
}

/// The boxes of a node's children in the world: middles, relative to some point, and half their sides.
pub(super) struct Boxes {
    pub(super) centers: [Lanes; 3],
    pub(super) halves: [Lanes; 3],
}

/// All shared meshes of a scene at their places.
pub(super) struct InstanceTree {
    shared: Vec<Shared>,
    instances: Vec<Instance>,
    top: Tree<InstanceBox>,
    count: u32,
}

impl core::fmt::Debug for InstanceTree {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("InstanceTree")
            .field("meshes", &self.shared.len())
            .field("places", &self.instances.len())
            .finish()
    }
}

/// The objects of a scene that are instances and met by rays, the first of equal ones.
fn wanted<'s>(scene: &'s Scene, duplicates: &mut Duplicates) -> Vec<(u32, bool, &'s Instances)> {
    let all = scene.objects.iter().enumerate().filter(|(_, object)| object.is_met());
    let instances = all.filter_map(|(number, object)| match &object.shape {
        Shape::Instances(instances) => Some((number, object.visible, instances)),
        _ => None,
    });
    instances
        .filter(|(number, ..)| duplicates.is_first_mesh(&scene.objects, *number))
        .map(|(number, visible, instances)| (number as u32, visible, instances))
        .collect()
}

impl Shared {
    fn new(mesh: &Arc<Mesh>) -> Self {
        let reach = mesh.positions.iter().fold(Vec3::ZERO, |reach, p| reach.max(p.abs()));
        let scale = hierarchy_scale(reach.max_element());
        let corner = |i: u32| Vec3A::from(mesh.positions[i as usize]) * scale;
        let triangles: Vec<_> = mesh.triangles.iter().map(|t| t.map(corner)).collect();
        let triangles: Vec<_> = triangles.into_iter().map(|[v0, v1, v2]| Triangle { v0, v1, v2 }).collect();
        Self { mesh: Arc::clone(mesh), bvh: build(&triangles), scale, reach }
    }
}

impl Instance {
    fn new(shared: u32, of: &Shared, matrix: &Mat4) -> Self {
        let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.truncate());
        let is_mirrored = axes[0].cross(axes[1]).dot(axes[2]) < 0.0;
        let [x, y, z] = axes.map(Vec3::abs);
        let far = x * of.reach.x + y * of.reach.y + z * of.reach.z + matrix.w_axis.truncate().abs();
        let pad = Vec3::splat(ROUNDING * far.max_element());
        let axes = axes.map(|axis| axis / of.scale);
        Self { shared, object: 0, visible: true, index: 0, first: 0, matrix: *matrix, is_mirrored, axes, pad }
    }

    /// A box around the mesh at this place.
    fn bounds(&self, of: &Shared) -> Aabb {
        let bounds = of.mesh.bounds_at(&self.matrix);
        Aabb::new((bounds.min - self.pad).into(), (bounds.max + self.pad).into())
    }

    /// The boxes of a node's children, relative to `from`.
    #[inline(always)]
    fn boxes(&self, node: &CwBvhNode, from: Vec3) -> Boxes {
        let step = node.e.map(|e| f32::from_bits(u32::from(e) << 23));
        let children = [
            (&node.child_min_x, &node.child_max_x),
            (&node.child_min_y, &node.child_max_y),
            (&node.child_min_z, &node.child_max_z),
        ];
        let origin = self.matrix.w_axis.truncate() - from;
        let [ox, oy, oz] = origin.to_array();
        let mut boxes = Boxes { centers: [[ox; 8], [oy; 8], [oz; 8]], halves: self.pad.to_array().map(|pad| [pad; 8]) };
        for (axis, (low, high)) in children.into_iter().enumerate() {
            let (p, step, along) = (node.p[axis], step[axis], self.axes[axis].to_array());
            for l in 0..8 {
                let (low, high) = (f32::from(low[l]), f32::from(high[l]));
                let (c, h) = (p + (low + high) * (0.5 * step), (high - low) * (0.5 * step));
                for (k, along) in along.iter().enumerate() {
                    boxes.centers[k][l] += along * c;
                    boxes.halves[k][l] += along.abs() * h;
                }
            }
        }
        boxes
    }
}

impl InstanceTree {
    pub(super) fn new(scene: &Scene) -> Self {
        Self::from_earlier(&wanted(scene, &mut Duplicates::default()), Vec::new())
    }

    fn from_earlier(wanted: &[(u32, bool, &Instances)], mut kept: Vec<Shared>) -> Self {
        let mut meshes: Vec<&Arc<Mesh>> = wanted.iter().map(|(_, _, all)| all.mesh()).collect();
        meshes.sort_unstable_by_key(|mesh| Arc::as_ptr(mesh));
        meshes.dedup_by_key(|mesh| Arc::as_ptr(mesh));
        kept.sort_unstable_by_key(|shared| Arc::as_ptr(&shared.mesh));
        kept.retain(|shared| meshes.binary_search_by_key(&Arc::as_ptr(&shared.mesh), |m| Arc::as_ptr(m)).is_ok());
        let is_known =
            |mesh: &&Arc<Mesh>| kept.binary_search_by_key(&Arc::as_ptr(mesh), |s| Arc::as_ptr(&s.mesh)).is_ok();
        let new: Vec<&Arc<Mesh>> = meshes.into_iter().filter(|mesh| !is_known(mesh)).collect();
        let made: Vec<Shared> = new.into_par_iter().map(Shared::new).collect();
        kept.extend(made);
        kept.sort_unstable_by_key(|shared| Arc::as_ptr(&shared.mesh));
        let mut instances = Vec::new();
        let mut count = 0;
        for (object, visible, all) in wanted {
            let found = kept.binary_search_by_key(&Arc::as_ptr(all.mesh()), |s| Arc::as_ptr(&s.mesh));
            let Ok(shared) = found else { continue };
            let triangles = all.mesh().triangles.len() as u32;
            for (matrix, index) in all.places().iter().zip(0..) {
                let instance = Instance::new(shared as u32, &kept[shared], matrix);
                instances.push(Instance {
                    object: *object,
                    visible: *visible,
                    index: index * triangles,
                    first: count,
                    ..instance
                });
                count += triangles;
            }
        }
        let boxes: Vec<InstanceBox> = (0..instances.len() as u32)
            .into_par_iter()
            .map(|number| {
                let instance: &Instance = &instances[number as usize];
                InstanceBox { instance: number, bounds: instance.bounds(&kept[instance.shared as usize]) }
            })
            .collect();
        let all = boxes.iter().fold(Aabb::empty(), |all, b| all.union(&b.bounds));
        let scale =
            if boxes.is_empty() { 1.0 } else { hierarchy_scale(all.min.abs().max(all.max.abs()).max_element()) };
        let top = Tree::new(&boxes, scale, |boxes| {
            let boxes = boxes.iter().map(|b| Aabb::new(b.bounds.min * scale, b.bounds.max * scale));
            build(&boxes.collect::<Vec<_>>())
        });
        Self { shared: kept, instances, top, count }
    }

    /// Follows the scene.
    pub(super) fn update(&mut self, scene: &Scene) -> Update {
        let wanted = wanted(scene, &mut Duplicates::default());
        let of = |(object, visible, all): &(u32, bool, &Instances)| {
            let (object, visible, mesh) = (*object, *visible, Arc::as_ptr(all.mesh()));
            all.places().iter().map(move |matrix| (object, visible, mesh, *matrix)).collect::<Vec<_>>()
        };
        let mut done = Update::Kept;
        let mut number = 0;
        for (object, visible, mesh, matrix) in wanted.iter().flat_map(of) {
            let same = self.instances.get_mut(number).filter(|instance| {
                let known = Arc::as_ptr(&self.shared[instance.shared as usize].mesh);
                (instance.object, known, instance.matrix) == (object, mesh, matrix)
            });
            let Some(instance) = same else {
                done = Update::Built;
                break;
            };
            if core::mem::replace(&mut instance.visible, visible) != visible {
                done = Update::Marked;
            }
            number += 1;
        }
        if done == Update::Built || number != self.instances.len() {
            *self = Self::from_earlier(&wanted, core::mem::take(&mut self.shared));
            done = Update::Built;
        }
        done
    }

    /// The number of triangles.
    pub(super) const fn count(&self) -> u32 {
        self.count
    }

    pub(super) const fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The instance of a triangle, and its place in the mesh's hierarchy.
    fn find(&self, number: u32) -> (&Instance, u32) {
        let instance = &self.instances[self.instances.partition_point(|instance| instance.first <= number) - 1];
        (instance, number - instance.first)
    }

    /// Object and number of a triangle.
    pub(super) fn name(&self, number: u32) -> (u32, u32) {
        let (instance, place) = self.find(number);
        let triangle = self.shared[instance.shared as usize].bvh.primitive_indices[place as usize];
        (instance.object, instance.index + triangle)
    }

    pub(super) fn triangle(&self, number: u32) -> Corners {
        let (instance, place) = self.find(number);
        self.corners(instance, place)
    }

    /// A triangle in the world, with the bits that it has in [`Instances::expanded`].
    #[inline]
    fn corners(&self, instance: &Instance, place: u32) -> Corners {
        let Shared { mesh, bvh, .. } = &self.shared[instance.shared as usize];
        let triangle = bvh.primitive_indices[place as usize];
        let corner = |i: u32| Vec3A::from(instance.matrix.transform_point3(mesh.positions[i as usize]));
        let [a, b, c] = mesh.triangles[triangle as usize];
        let [b, c] = if instance.is_mirrored { [c, b] } else { [b, c] };
        let v0 = corner(a);
        let (e1, e2) = (corner(b) - v0, corner(c) - v0);
        Corners { v0, e1, e2, object: instance.object, index: instance.index + triangle, visible: instance.visible }
    }

    /// Calls `found` for triangles in boxes that are not `outside`, until it says true. Returns whether it did.
    pub(super) fn visit(
        &self,
        outside: &impl Fn(&Aabb) -> bool,
        found: &mut impl FnMut(u32, &Corners) -> bool,
    ) -> bool {
        self.top.visit(outside, &mut |_, top: &InstanceBox| {
            self.visit_one(&self.instances[top.instance as usize], outside, found)
        })
    }

    fn visit_one(
        &self,
        instance: &Instance,
        outside: &impl Fn(&Aabb) -> bool,
        found: &mut impl FnMut(u32, &Corners) -> bool,
    ) -> bool {
        let bvh = &self.shared[instance.shared as usize].bvh;
        let mut stack = [0u32; 7 * 32 + 1];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let node = &bvh.nodes[stack[count] as usize];
            let boxes = instance.boxes(node, Vec3::ZERO);
            for child in 0..8 {
                let at = |rows: &[Lanes; 3]| Vec3A::from_array([rows[0][child], rows[1][child], rows[2][child]]);
                let (center, half) = (at(&boxes.centers), at(&boxes.halves));
                if node.is_child_empty(child) || outside(&Aabb::new(center - half, center + half)) {
                    continue;
                }
                if node.is_leaf(child) {
                    let (first, n) = node.child_primitives(child);
                    if (first..first + n).any(|i| found(instance.first + i, &self.corners(instance, i))) {
                        return true;
                    }
                } else {
                    stack[count] = node.child_node_index(child);
                    count += 1;
                }
            }
        }
        false
    }

    /// Calls `found` for triangles whose boxes a ray meets nearer than `limit`, until it says true. Returns whether it did.
    pub(super) fn along(&self, ray: &Ray, limit: &Cell<f32>, found: &mut impl FnMut(u32, &Corners) -> bool) -> bool {
        if self.is_empty() {
            return false;
        }
        let zero = ray.direction.cmpeq(Vec3A::ZERO);
        let inverse = Vec3A::select(zero, Vec3A::splat(1e30), ray.direction.recip());
        let outside = |bounds: &Aabb| {
            let (low, high) = (bounds.min - ray.origin, bounds.max - ray.origin);
            let pad = low.abs().max(high.abs()) * RAY_ROUNDING;
            let (a, b) = ((low - pad) * inverse, (high + pad) * inverse);
            let enter = a.min(b).max_element().max(ray.tmin * 0.999_999);
            enter > a.max(b).min_element().min(limit.get() * 1.000_001)
        };
        self.visit(&outside, found)
    }

    /// The number of a triangle on a ray: any for which `meet` gives a distance.
    pub(super) fn any(&self, ray: &Ray, meet: impl Fn(&Corners, &Ray) -> f32) -> Option<u32> {
        let mut met = None;
        self.along(ray, &Cell::new(ray.tmax), &mut |number, corners| {
            let is_met = meet(corners, ray).is_finite();
            met = is_met.then_some(number);
            is_met
        });
        met
    }

    /// The nearest triangle on a ray, and its distance.
    pub(super) fn nearest(&self, ray: &Ray, meet: impl Fn(&Corners, &Ray) -> f32) -> Option<(Corners, f32)> {
        let limit = Cell::new(ray.tmax);
        let mut nearest = None;
        self.along(ray, &limit, &mut |_, corners| {
            let t = meet(corners, &Ray { tmax: limit.get(), ..*ray });
            if t.is_finite() && (nearest.is_none() || t < limit.get()) {
                limit.set(t);
                nearest = Some((*corners, t));
            }
            false
        });
        nearest
    }

    /// The tree over the places, and the numbers of instances in its boxes.
    pub(super) const fn top(&self) -> &Tree<InstanceBox> {
        &self.top
    }
}

/// An instance as packets of rays walk through it.
pub(super) struct Walk<'s> {
    instance: &'s Instance,
    pub(super) bvh: &'s CwBvh,
    /// The number of its first triangle, among those of instances.
    pub(super) first: u32,
}

impl InstanceTree {
    /// An instance of the tree over all, if the camera sees it.
    pub(super) fn walk(&self, number: u32) -> Option<Walk<'_>> {
        let instance = &self.instances[self.top.primitives[number as usize].instance as usize];
        let bvh = &self.shared[instance.shared as usize].bvh;
        instance.visible.then_some(Walk { instance, bvh, first: instance.first })
    }
}

impl Walk<'_> {
    #[inline(always)]
    pub(super) fn boxes(&self, node: &CwBvhNode, from: Vec3) -> Boxes {
        self.instance.boxes(node, from)
    }
}
