//! A few triangles against single rays, eight at a time.

use super::World;
use super::primitive::{Corners, Exact, GIANT, GIANT_EDGE};
use fearless_simd::{Level, Simd, dispatch, f32x8, prelude::*};
use glam::{Vec3, Vec3A};
use lobe_core::vec3x8::{LANES, Vec3x8};
use obvhs::ray::Ray;
use scene::rounding::{CLOSE, EDGE};
use shading::Shaft;

/// x, y and z of eight vectors.
type Rows = [[f32; LANES]; 3];

/// Eight triangles side by side: first corners, and the edges from them. One whose edges are 0 is met by no ray.
#[derive(Clone, Debug, Default)]
struct Block {
    v0: Rows,
    e1: Rows,
    e2: Rows,
}

/// Some triangles of a [`World`], for single rays; valid for that world only.
#[derive(Clone, Debug, Default)]
pub struct TriangleList {
    blocks: Vec<Block>,
    /// Their places in the hierarchy.
    places: Vec<u32>,
    /// Those that rays have started near to, and giants.
    exact: Vec<(u32, Exact)>,
}

impl TriangleList {
    /// True when no triangle is in it.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    fn clear(&mut self) {
        self.blocks.clear();
        self.places.clear();
        self.exact.clear();
    }

    /// A triangle in f64 by its place in the hierarchy, made once: most rays start near to the same triangle.
    fn exact(&mut self, world: &World<'_>, place: u32) -> Exact {
        if let Some((_, exact)) = self.exact.iter().find(|(other, _)| *other == place) {
            return *exact;
        }
        let exact = world.exact(&world.triangle(place));
        self.exact.push((place, exact));
        exact
    }

    fn push(&mut self, place: u32, corners: &Corners) {
        let lane = self.places.len() % LANES;
        if lane == 0 {
            self.blocks.push(Block::default());
        }
        self.places.push(place);
        if let Some(block) = self.blocks.last_mut() {
            let set = |rows: &mut Rows, v: Vec3A| rows.iter_mut().zip(v.to_array()).for_each(|(row, x)| row[lane] = x);
            set(&mut block.v0, corners.v0);
            set(&mut block.e1, corners.e1);
            set(&mut block.e2, corners.e2);
        }
    }

    /// The lanes of a block whose triangles a ray meets, as far as f32 says, and those where it cannot.
    ///
    /// The bits are those of [`Corners::meet`].
    #[inline(always)]
    fn meet<S: Simd>(simd: S, block: &Block, ray: &Ray) -> [u32; 2] {
        let (v0, e1, e2) = (lanes(simd, &block.v0), lanes(simd, &block.e1), lanes(simd, &block.e2));
        let o = Vec3x8::splat(simd, ray.origin.into());
        let d = Vec3x8::splat(simd, ray.direction.into());
        let p = d.cross(e2);
        let inverse = f32x8::splat(simd, 1.0) / e1.dot(p);
        let s = o - v0;
        let u = s.dot(p) * inverse;
        let q = s.cross(e1);
        let v = d.dot(q) * inverse;
        let within = |edge: f32| {
            let least = f32x8::splat(simd, -edge);
            u.simd_ge(least) & v.simd_ge(least) & (u + v).simd_le(f32x8::splat(simd, 1.0 + edge))
        };
        let around = within(GIANT_EDGE);
        if around.to_bitmask() == 0 {
            return [0; 2];
        }
        let t = e2.dot(q) * inverse;
        let (size1, size2) = (e1.length_squared(), e2.length_squared());
        let slant_sq = (size1 * inverse) * (size2 * inverse);
        let giant = size1.max(size2).simd_gt(t * t * (GIANT * GIANT));
        let close = t.abs().simd_le((s.length_squared() * slant_sq).sqrt() * CLOSE);
        let between = t.simd_gt(f32x8::splat(simd, ray.tmin)) & t.simd_le(f32x8::splat(simd, ray.tmax));
        let [around, inside] = [around, within(EDGE)].map(|mask| mask.to_bitmask() as u32);
        let [close, giant] = [close, giant].map(|mask| mask.to_bitmask() as u32);
        [inside & between.to_bitmask() as u32 & !close & !giant, (inside & close) | (around & giant)]
    }
}

#[inline(always)]
fn lanes<S: Simd>(simd: S, [x, y, z]: &Rows) -> Vec3x8<S> {
    Vec3x8 { x: f32x8::simd_from(simd, *x), y: f32x8::simd_from(simd, *y), z: f32x8::simd_from(simd, *z) }
}

impl World<'_> {
    /// Lists the triangles of the objects `of` whose boxes meet the shaft, in `out`. False, and an unfinished list, when
    /// there are more than `limit`.
    pub fn list_triangles(
        &self,
        shaft: &Shaft,
        of: impl Fn(u32) -> bool,
        limit: usize,
        out: &mut TriangleList,
    ) -> bool {
        out.clear();
        self.each_triangle_in(shaft, of, limit, |place, corners| out.push(place, corners))
    }

    /// Whether one of some triangles lies on a ray of unit direction nearer than `distance`.
    #[must_use]
    pub fn meets_one(&self, origin: Vec3, direction: Vec3, distance: f32, of: &mut TriangleList) -> bool {
        let ray = Ray::new(origin.into(), direction.into(), 0.0, distance);
        dispatch!(Level::new(), simd => self.meets_listed(simd, &ray, of))
    }

    #[inline(always)]
    fn meets_listed<S: Simd>(&self, simd: S, ray: &Ray, of: &mut TriangleList) -> bool {
        for number in 0..of.blocks.len() {
            let [met, mut close] = TriangleList::meet(simd, &of.blocks[number], ray);
            if met != 0 {
                return true;
            }
            while close != 0 {
                let place = of.places[LANES * number + close.trailing_zeros() as usize];
                let t = of.exact(self, place).distance(ray);
                if t > ray.tmin && t <= ray.tmax {
                    return true;
                }
                close &= close - 1;
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_core::Sphere;
    use lobe_core::oracle::Random;
    use scene::{Mesh, Object, Proxy};
    use shading::LightId;
    use test_scenes::floor_and_sphere;

    /// Loose triangles, those among them without area, and rays that start anywhere, on a triangle, or on an edge of one.
    #[test]
    fn eight_triangles_at_once_are_met_as_each_alone() {
        let mut random = Random::new(7);
        let mut vector = |size: f64| {
            let mut x = || random.between(-size, size) as f32;
            Vec3::new(x(), x(), x())
        };
        let mut positions: Vec<Vec3> = (0..3 * 60).map(|k| vector(2.0) + vector(0.1) * (k % 7) as f32).collect();
        positions[4] = positions[3];
        let triangles: Vec<[u32; 3]> = (0..60).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let corners: Vec<[Vec3; 3]> = triangles.iter().map(|t| t.map(|i| positions[i as usize])).collect();
        let mut scene = floor_and_sphere();
        let mesh = Mesh { positions, triangles, ..Mesh::default() };
        scene.objects = vec![Object::mesh("soup", mesh, 0, Proxy::Count(1))];
        let world = World::new(&scene);
        let mut list = TriangleList::default();
        let (mut hits, mut rays) = (0, 0);
        for case in 0..3000 {
            let sphere = Sphere { center: vector(2.0), radius: 0.3 + 0.001 * case as f32 };
            let shaft = Shaft::new(sphere, sphere, LightId(0));
            let limit = 8 + case % 90;
            let is_whole = world.list_triangles(&shaft, |_| true, limit, &mut list);
            assert_eq!(is_whole, list.places.len() <= limit);
            let [a, b, c] = corners[case % corners.len()];
            let origin = match case % 4 {
                0 => vector(2.0),
                1 => world.leave(0.2 * a + 0.3 * b + 0.5 * c, (b - a).cross(c - a).normalize_or(Vec3::Y)),
                2 => 0.25 * a + 0.75 * b,
                _ => a,
            };
            let direction = vector(1.0).normalize_or(Vec3::X);
            let distance = 0.001 * case as f32;
            let ray = Ray::new(origin.into(), direction.into(), 0.0, distance);
            let alone = list.places.iter().any(|place| {
                let corners = &world.hierarchy.triangles.primitives[*place as usize];
                corners.meet(&ray, |_| world.exact_distance(corners, &ray)).is_finite()
            });
            assert_eq!(
                world.meets_one(origin, direction, distance, &mut list),
                alone,
                "{origin} {direction} {distance}"
            );
            (hits, rays) = (hits + usize::from(alone), rays + 1);
        }
        assert!(hits > rays / 20 && hits < rays / 2, "{hits} of {rays}");
    }
}
