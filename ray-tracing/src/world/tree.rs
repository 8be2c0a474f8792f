//! A hierarchy over primitives, built once and refitted as they move.

use super::Update;
use super::primitive::Named;
use glam::{Vec3, Vec3A};
use obvhs::Boundable;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::node::CwBvhNode;
use obvhs::ray::Ray;
use scene::Bounds;

/// The power of two that brings coordinates up to `size` to about a million.
pub(crate) fn hierarchy_scale(size: f32) -> f32 {
    let exponent = (20.0 - size.log2().floor()).clamp(-100.0, 60.0);
    f32::from_bits(((127.0 + exponent) as u32) << 23)
}

/// Primitives with their hierarchy; `None` when there are none, which the hierarchy cannot express.
pub(crate) struct Tree<T> {
    pub(super) bvh: Option<CwBvh>,
    /// In the hierarchy's order, in world units.
    pub(super) primitives: Vec<T>,
    /// Units of the hierarchy a world unit: a power of two. obvhs never enters a box that ends nearer than 1e-4, so a
    /// small scene has to be large there.
    scale: f32,
    /// Area of all boxes over the root's when it was built.
    pub(super) built_area: f32,
}

impl<T> core::fmt::Debug for Tree<T> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Tree").field("primitives", &self.primitives.len()).finish_non_exhaustive()
    }
}

impl<T: Copy + Boundable> Tree<T> {
    pub(crate) fn new(primitives: &[T], scale: f32, build: impl FnOnce(&[T]) -> CwBvh) -> Self {
        if primitives.is_empty() {
            return Self { bvh: None, primitives: Vec::new(), scale, built_area: 0.0 };
        }
        let bvh = build(primitives);
        let primitives = bvh.primitive_indices.iter().map(|i| primitives[*i as usize]).collect();
        let mut tree = Self { bvh: Some(bvh), primitives, scale, built_area: 0.0 };
        tree.built_area = tree.fit();
        tree
    }

    /// A box around all primitives.
    pub(super) fn bounds(&self) -> Bounds {
        self.bvh.as_ref().map_or(Bounds::EMPTY, |bvh| {
            let [min, max] = [bvh.total_aabb.min, bvh.total_aabb.max].map(|corner| Vec3::from(corner) / self.scale);
            Bounds { min, max }
        })
    }

    /// Follows primitives that have moved. `None` where these are others or a new hierarchy would be much better: then build it.
    pub(super) fn update(&mut self, primitives: &[T], scale: f32) -> Option<Update>
    where
        T: Named,
    {
        if primitives.is_empty() && self.primitives.is_empty() {
            return Some(Update::Kept);
        }
        if self.scale != scale || self.primitives.len() != primitives.len() {
            return None;
        }
        let order = self.bvh.as_ref().map_or(&[][..], |b| &b.primitive_indices);
        let mut done = Update::Kept;
        for (place, number) in self.primitives.iter_mut().zip(order) {
            let moved = primitives[*number as usize];
            if place.name() != moved.name() {
                return None;
            }
            done = done.max(place.update_to(&moved));
            *place = moved;
        }
        let is_good = done < Update::Refitted || self.fit() <= 2.0 * self.built_area;
        is_good.then_some(done)
    }

    /// Fits all boxes to the primitives, leaves first; gives their area over the root's.
    fn fit(&mut self) -> f32 {
        let Some(bvh) = &mut self.bvh else { return 0.0 };
        let mut boxes = vec![Aabb::empty(); bvh.nodes.len()];
        let mut area = 0.0;
        // Children come after their parents in the list.
        for index in (0..bvh.nodes.len()).rev() {
            let node = &mut bvh.nodes[index];
            let mut children = [Aabb::empty(); 8];
            let mut whole = Aabb::empty();
            for (child, bounds) in children.iter_mut().enumerate() {
                if node.is_child_empty(child) {
                    continue;
                }
                if node.is_leaf(child) {
                    let (first, count) = node.child_primitives(child);
                    for primitive in &self.primitives[first as usize..(first + count) as usize] {
                        *bounds = bounds.union(&primitive.aabb());
                    }
                    *bounds = Aabb::new(bounds.min * self.scale, bounds.max * self.scale);
                } else {
                    *bounds = boxes[node.child_node_index(child) as usize];
                }
                whole = whole.union(bounds);
                area += bounds.half_area();
            }
            quantise(node, &whole, &children);
            boxes[index] = whole;
        }
        bvh.total_aabb = boxes[0];
        bvh.exact_node_aabbs = None;
        area / boxes[0].half_area().max(f32::MIN_POSITIVE)
    }

    /// The nearest primitive on the ray, and the distance along it.
    pub(super) fn nearest(&self, ray: Ray, intersect: impl Fn(&T, &Ray) -> f32) -> Option<(&T, f32)> {
        let mut hit = obvhs::ray::RayHit::none();
        let scaled = self.scaled(ray);
        self.bvh.as_ref()?.ray_traverse(scaled, &mut hit, |r, i| self.intersect(&ray, r, i, &intersect));
        (hit.t < scaled.tmax).then(|| (&self.primitives[hit.primitive_id as usize], hit.t / self.scale))
    }

    pub(crate) fn any(&self, ray: Ray, intersect: impl Fn(&T, &Ray) -> f32) -> bool {
        let meet = |r: &Ray, i| self.intersect(&ray, r, i, &intersect);
        self.bvh.as_ref().is_some_and(|b| !b.ray_traverse_miss(self.scaled(ray), meet))
    }

    /// The number of a primitive on the ray: any.
    pub(crate) fn any_number(&self, ray: Ray, intersect: impl Fn(&T, &Ray) -> f32) -> Option<u32> {
        let met = core::cell::Cell::new(None);
        let meet = |r: &Ray, i| {
            let t = self.intersect(&ray, r, i, &intersect);
            if t.is_finite() {
                met.set(Some(i as u32));
            }
            t
        };
        self.bvh.as_ref()?.ray_traverse_miss(self.scaled(ray), meet);
        met.get()
    }

    /// The ray in the hierarchy's units.
    fn scaled(&self, ray: Ray) -> Ray {
        let s = self.scale;
        // obvhs takes −0 for positive in one place and for negative in another, and misses everything.
        let zero = ray.direction.cmpeq(Vec3A::ZERO);
        let inv_direction = Vec3A::select(zero, Vec3A::splat(1.0 / f32::EPSILON), ray.inv_direction);
        Ray { origin: ray.origin * s, inv_direction, tmin: ray.tmin * s, tmax: ray.tmax * s, ..ray }
    }

    /// Distance in the hierarchy's units to a primitive that is met in world units, on the part that is `left`.
    #[inline]
    fn intersect(&self, ray: &Ray, left: &Ray, i: usize, intersect: &impl Fn(&T, &Ray) -> f32) -> f32 {
        intersect(&self.primitives[i], &Ray { tmax: left.tmax / self.scale, ..*ray }) * self.scale
    }
}

impl<T> Tree<T> {
    /// Units of the hierarchy a world unit.
    pub(super) const fn scale(&self) -> f32 {
        self.scale
    }

    /// A box of the hierarchy in world units.
    pub(super) fn unscaled(&self, bounds: Aabb) -> Aabb {
        Aabb::new(bounds.min / self.scale, bounds.max / self.scale)
    }
}

/// Gives a node its children's boxes, rounded outward to 255 steps of a power of two (H. Ylitie, T. Karras, S. Laine,
/// *Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs*, 2017, §3).
fn quantise(node: &mut CwBvhNode, whole: &Aabb, children: &[Aabb; 8]) {
    let origin = whole.min;
    let mut steps = Vec3A::ZERO;
    for axis in 0..3 {
        // A step more than 1/255 of the box, so that rounding in the differences stays inside.
        let least = ((whole.max[axis] - origin[axis]) / 254.0).max(1e-20);
        let exponent = (least.to_bits() >> 23) + 1;
        node.e[axis] = exponent as u8;
        steps[axis] = f32::from_bits(exponent << 23);
    }
    node.p = origin.into();
    for (child, bounds) in children.iter().enumerate() {
        let empty = node.is_child_empty(child);
        let low = if empty { Vec3A::ZERO } else { ((bounds.min - origin) / steps).floor() };
        let high = if empty { Vec3A::ZERO } else { ((bounds.max - origin) / steps).ceil() };
        let (low, high) = (low.clamp(Vec3A::ZERO, Vec3A::splat(255.0)), high.clamp(Vec3A::ZERO, Vec3A::splat(255.0)));
        (node.child_min_x[child], node.child_max_x[child]) = (low.x as u8, high.x as u8);
        (node.child_min_y[child], node.child_max_y[child]) = (low.y as u8, high.y as u8);
        (node.child_min_z[child], node.child_max_z[child]) = (low.z as u8, high.z as u8);
    }
}
