mod appearance;
mod build;
mod camera_rays;
mod hierarchy;
mod instance_tree;
mod packet;
mod parallel;
mod primitive;
mod query;
#[cfg(test)]
mod refit_tests;
mod surface;
mod terminator;
mod tree;
mod triangle_list;
mod triangle_packet;

pub(crate) use self::appearance::varied;
pub use self::appearance::{mapped_normal, vertex_tangents};
#[doc(hidden)]
pub use self::build::binary_hierarchy;
pub(crate) use self::build::build;
pub(crate) use self::camera_rays::{Bundle, Rays, SIDE};
pub use self::hierarchy::{Hierarchy, Update};
pub(crate) use self::packet::{NOTHING, RayPacket};
use self::primitive::{Corners, Exact, Named};
pub use self::query::{Primitive, Region};
pub(crate) use self::surface::RayHits;
pub(crate) use self::tree::{Tree, hierarchy_scale};
pub use self::triangle_list::TriangleList;
use glam::{DVec3, Vec3};
use obvhs::ray::Ray;
use scene::Scene;
use std::sync::Arc;

/// A hit of a ray.
#[cfg(test)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Hit {
    /// World position: from the barycentric coordinates of the triangle or on the sphere, in f64, then rounded, so that it
    /// is as near to the surface as an f32 point can be.
    pub(crate) position: Vec3,
    /// Unit shading normal on the ray's side of the surface.
    pub(crate) normal: Vec3,
    /// Unit geometric normal on the ray's side of the surface.
    pub(crate) face_normal: Vec3,
    /// Number of the object.
    pub(crate) object: u32,
}

/// The geometry of a scene, ready for rays: a scene and its [`Hierarchy`].
///
/// Holds the objects that the camera sees and those that block light. Building costs about 0.6 µs a triangle.
#[derive(Debug)]
pub struct World<'s> {
    scene: &'s Scene,
    hierarchy: Arc<Hierarchy>,
}

impl<'s> World<'s> {
    /// Prepares the scene's objects. Triangles without area are left out.
    #[must_use]
    pub fn new(scene: &'s Scene) -> Self {
        Self::with_hierarchy(scene, Arc::new(Hierarchy::new(scene)))
    }

    /// A scene with its hierarchy, which has [followed](Hierarchy::update) it. Costs nothing.
    #[must_use]
    pub const fn with_hierarchy(scene: &'s Scene, hierarchy: Arc<Hierarchy>) -> Self {
        Self { scene, hierarchy }
    }

    /// The scene that was prepared.
    #[must_use]
    pub const fn scene(&self) -> &'s Scene {
        self.scene
    }

    /// The rays of the scene's camera through a picture of some size.
    pub(crate) fn rays(&self, width: u32, height: u32) -> Rays {
        Rays::new(&self.scene.camera, width, height, &self.hierarchy.bounds())
    }

    /// Another number whenever anything that rays meet has moved, come, gone, or begun or ceased to block: no two hierarchies of a
    /// program have the same one otherwise.
    #[must_use]
    pub fn revision(&self) -> u64 {
        self.hierarchy.revision()
    }

    /// Number of triangles, those without area not counted.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.hierarchy.triangles.primitives.len() + self.hierarchy.instances.count() as usize
    }

    /// A triangle by its number: those of meshes first, in the order of their hierarchy, then those of instances.
    #[inline]
    pub(crate) fn triangle(&self, number: u32) -> Corners {
        let own = &self.hierarchy.triangles.primitives;
        match own.get(number as usize) {
            Some(corners) => *corners,
            None => self.hierarchy.instances.triangle(number - own.len() as u32),
        }
    }

    /// Object and number of a triangle.
    #[inline]
    pub(crate) fn triangle_name(&self, number: u32) -> (u32, u32) {
        let own = &self.hierarchy.triangles.primitives;
        match own.get(number as usize) {
            Some(corners) => corners.name(),
            None => self.hierarchy.instances.name(number - own.len() as u32),
        }
    }

    /// The nearest visible surface along a ray of unit direction; tests compare tiles of rays with it.
    #[cfg(test)]
    pub(crate) fn hit(&self, origin: Vec3, direction: Vec3) -> Option<Hit> {
        let ray = Ray::new_inf(origin.into(), direction.into());
        let seen = |visible: bool, t: f32| if visible { t } else { f32::INFINITY };
        let triangle = self.nearest_triangle(ray, |c, r| seen(c.visible, c.intersect(r)));
        let limit = Ray { tmax: triangle.map_or(f32::INFINITY, |(_, t)| t), ..ray };
        let sphere = self.hierarchy.spheres.nearest(limit, |b, r| seen(b.visible, b.intersect(r)));
        match (sphere, triangle) {
            (Some((sphere, t)), _) => {
                let (position, normal) = sphere.surface(origin, direction, t);
                Some(Hit { position, normal, face_normal: normal, object: sphere.object })
            }
            (None, Some((corners, _))) => Some(self.triangle_hit(&corners, origin, direction)),
            (None, None) => None,
        }
    }

    /// True when a triangle or sphere lies on the ray nearer than `distance`.
    ///
    /// The true geometry, not the proxies. `origin` is to be off the surface already, see [`World::leave`].
    #[must_use]
    pub fn occluded(&self, origin: Vec3, direction: Vec3, distance: f32) -> bool {
        self.occluded_by(origin, direction, distance, |_| true)
    }

    /// The same, with only those objects that `by` says yes to by their number.
    #[must_use]
    pub fn occluded_by(&self, origin: Vec3, direction: Vec3, distance: f32, by: impl Fn(u32) -> bool) -> bool {
        let ray = Ray::new(origin.into(), direction.into(), 0.0, distance);
        let meet = |c: &Corners, r: &Ray| {
            if by(c.object) { c.meet(r, |_| self.exact_distance(c, &ray)) } else { f32::INFINITY }
        };
        self.hierarchy.triangles.any(ray, meet)
            || self.hierarchy.instances.any(&ray, meet).is_some()
            || self.hierarchy.spheres.any(ray, |b, r| if by(b.object) { b.meet_casting(r) } else { f32::INFINITY })
    }

    /// Whether the nearest triangle or sphere on a ray of unit direction is met from behind: from inside of a sphere, or from the side on
    /// which a triangle's corners go round with the clock. `None` where the ray meets nothing.
    ///
    /// From inside a closed body whose triangles are wound as usual every ray meets a back. `origin` is to be off the surface already,
    /// see [`leave`](Self::leave).
    #[must_use]
    pub fn meets_back(&self, origin: Vec3, direction: Vec3) -> Option<bool> {
        let ray = Ray::new_inf(origin.into(), direction.into());
        let triangle = self.nearest_triangle(ray, |c, r| c.meet(r, |_| self.exact_distance(c, &ray)));
        let limit = Ray { tmax: triangle.map_or(f32::INFINITY, |(_, t)| t), ..ray };
        if let Some((sphere, _)) = self.hierarchy.spheres.nearest(limit, |b, r| b.intersect(r)) {
            return Some(sphere.sphere.center.distance(origin) < sphere.sphere.radius);
        }
        let [a, b, c] = self.positions(&triangle?.0);
        Some((b - a).cross(c - a).dot(direction.as_dvec3()) > 0.0)
    }

    /// The nearest triangle on a ray, and its distance.
    fn nearest_triangle(&self, ray: Ray, meet: impl Fn(&Corners, &Ray) -> f32) -> Option<(Corners, f32)> {
        let own = self.hierarchy.triangles.nearest(ray, &meet).map(|(corners, t)| (*corners, t));
        let limit = Ray { tmax: own.map_or(ray.tmax, |(_, t)| t), ..ray };
        self.hierarchy.instances.nearest(&limit, meet).or(own)
    }

    /// Start of a shadow ray: `position` moved along the geometric normal by 5e-7 of its largest coordinate (4 to 8 units
    /// in the last place).
    ///
    /// `position` is the point of the surface rounded to f32. This rounding and that of the start move it by less than half
    /// as much along the normal, so the start is on the side of the surface that the normal points to, in scenes of any
    /// size. Rays that leave the surface do not meet it: where a start is too near to a triangle for f32,
    /// [`occluded`](Self::occluded) decides in f64.
    #[must_use]
    pub fn leave(&self, position: Vec3, face_normal: Vec3) -> Vec3 {
        position + face_normal * (5e-7 * position.abs().max_element())
    }

    /// Distance along the ray to a triangle, in f64.
    #[cold]
    fn exact_distance(&self, corners: &Corners, ray: &Ray) -> f32 {
        self.exact(corners).distance(ray)
    }

    /// A triangle in f64, from the corners as they are in the scene.
    fn exact(&self, corners: &Corners) -> Exact {
        Exact::new(self.positions(corners))
    }

    /// The corners of a triangle.
    fn positions(&self, corners: &Corners) -> [DVec3; 3] {
        let shape = &self.scene.objects[corners.object as usize].shape;
        shape.corners(corners.index as usize).unwrap_or_default().map(Vec3::as_dvec3)
    }

    /// The corners of a triangle in world space, by its object and number; `None` if there is none.
    #[must_use]
    pub fn corners(&self, (object, index): (u32, u32)) -> Option<[Vec3; 3]> {
        self.scene.objects.get(object as usize)?.shape.corners(index as usize)
    }

    #[cfg(test)]
    fn triangle_hit(&self, corners: &Corners, origin: Vec3, direction: Vec3) -> Hit {
        let (o, d) = (origin.as_dvec3(), direction.as_dvec3());
        let mesh = self.scene.objects[corners.object as usize].shape.mesh().expect("triangles come from meshes");
        let vertices = mesh.triangles[corners.index as usize];
        let [a, b, c] = vertices.map(|i| mesh.positions[i as usize].as_dvec3());
        let (e1, e2) = (b - a, c - a);
        let p = d.cross(e2);
        let inverse = 1.0 / e1.dot(p);
        let s = o - a;
        let u = (s.dot(p) * inverse).clamp(0.0, 1.0);
        let v = (d.dot(s.cross(e1)) * inverse).clamp(0.0, 1.0 - u);
        let toward = |n: DVec3| if n.dot(d) > 0.0 { -n } else { n };
        let face = toward(e1.cross(e2).normalize_or_zero());
        let mut normal = face;
        if !mesh.normals.is_empty() {
            let [na, nb, nc] = vertices.map(|i| mesh.normals[i as usize].as_dvec3());
            let smooth = (na * (1.0 - u - v) + nb * u + nc * v).normalize_or_zero();
            // On the side of the face that is seen; a normal that still looks away is no use to a viewer.
            let smooth = if smooth.dot(face) < 0.0 { -smooth } else { smooth };
            if smooth.dot(d) < 0.0 {
                normal = smooth;
            }
        }
        Hit {
            position: (a + e1 * u + e2 * v).as_vec3(),
            normal: normal.as_vec3().normalize(),
            face_normal: face.as_vec3().normalize(),
            object: corners.object,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::GBuffer;
    use lobe_core::Sphere;
    use lobe_core::oracle::Random;
    use scene::{Mesh, Shape};
    use test_scenes::floor_and_sphere;

    /// The scene times a power of two, which changes no digit.
    fn scaled(s: f32) -> Scene {
        let mut scene = floor_and_sphere();
        scene.camera.eye *= s;
        scene.camera.target *= s;
        for object in &mut scene.objects {
            match &mut object.shape {
                Shape::Mesh(Mesh { positions, .. }) => positions.iter_mut().for_each(|p| *p *= s),
                Shape::Spheres(spheres) => {
                    spheres.iter_mut().for_each(|b| *b = Sphere { center: b.center * s, radius: b.radius * s });
                }
                Shape::Instances(_) => {}
            }
        }
        scene
    }

    /// Every ray meets backs from inside of a box and a sphere, fronts from outside.
    #[test]
    fn bodies_show_their_backs_inside() {
        let mut scene = Scene::default();
        scene.materials.push(test_scenes::material());
        let cube = Mesh::cuboid(Vec3::new(3.0, 0.0, 0.0), Vec3::ONE);
        scene.objects.push(scene::Object::mesh("cube", cube, 0, scene::Proxy::None));
        let sphere = Sphere { center: Vec3::new(-3.0, 0.0, 0.0), radius: 1.0 };
        scene.objects.push(scene::Object::spheres("sphere", vec![sphere], 0));
        let world = World::new(&scene);
        let mut random = Random::new(3);
        for _ in 0..200 {
            let direction = random.axis().as_vec3().normalize();
            for center in [3.0, -3.0].map(|x| Vec3::X * x) {
                let near = center + random.axis().as_vec3() * 0.4;
                assert_eq!(world.meets_back(near, direction), Some(true), "{near} {direction}");
                let far = near - direction * 20.0;
                assert_eq!(world.meets_back(far, direction), Some(false), "{far} {direction}");
                assert_eq!(world.meets_back(far, -direction), None);
            }
        }
    }

    /// A sphere that makes a light visible is seen, hides what is behind it, and does not hide its own light.
    #[test]
    fn a_lamp_does_not_hide_its_light() {
        let mut scene = floor_and_sphere();
        let light = scene.lights[0].sphere().expect("a sphere");
        let from = light.center - Vec3::Y * (light.radius + 0.1);
        let hidden_up_to = |scene: &Scene, distance: f32| World::new(scene).occluded(from, Vec3::Y, distance);
        let hidden = |scene: &Scene| hidden_up_to(scene, 0.1001);
        assert!(!hidden(&scene) && !hidden_up_to(&scene, 1.0));
        scene.objects.push(scene::Object::spheres("lamp", vec![light], 0));
        assert!(!hidden(&scene) && hidden_up_to(&scene, 1.0) && World::new(&scene).hit(from, Vec3::Y).is_some());
        scene.objects.push(scene::Object::spheres("shade", vec![Sphere { radius: 1.05 * light.radius, ..light }], 0));
        assert!(hidden(&scene));
    }

    /// A point at an edge lies on another face, too: that face hides nothing from it.
    #[test]
    fn a_surface_does_not_hide_what_starts_on_it() {
        let mut scene = floor_and_sphere();
        let corners = [Vec3::new(-8.0, -8.0, -8.0), Vec3::new(8.0, 8.0, -8.0), Vec3::new(0.0, 0.0, 8.0)];
        let mesh = Mesh { positions: corners.to_vec(), triangles: vec![[0, 1, 2]], ..Mesh::default() };
        let sphere = Sphere { center: Vec3::new(0.0, 40.0, 0.0), radius: 2.0 };
        scene.objects = vec![
            scene::Object::mesh("slope", mesh, 0, scene::Proxy::Count(8)),
            scene::Object::spheres("sphere", vec![sphere], 0),
        ];
        let world = World::new(&scene);
        for direction in [Vec3::Y, Vec3::NEG_Y, Vec3::X] {
            assert!(!world.occluded(Vec3::ZERO, direction, 10.0));
            assert!(world.occluded(Vec3::ZERO - direction, direction, 10.0));
        }
        let top = Vec3::new(0.0, 42.0, 0.0);
        assert!(!world.occluded(top, Vec3::Y, 10.0) && world.occluded(top + Vec3::Y, Vec3::NEG_Y, 10.0));
    }

    /// Rays that leave a surface a thousand times as large as the distance to the origin: no plane of it is exact in f32.
    #[test]
    fn a_large_surface_is_left_on_the_right_side() {
        let turn = glam::DQuat::from_xyzw(0.31, -0.22, 0.17, 0.91).normalize();
        let up = turn * DVec3::Y;
        let corner = |x: f64, z: f64| (turn * DVec3::new(x, 0.0, z)).as_vec3();
        let corners = [corner(-1000.0, 900.0), corner(1000.0, 1100.0), corner(300.0, -1000.0)];
        let mesh = Mesh { positions: corners.to_vec(), triangles: vec![[0, 1, 2]], ..Mesh::default() };
        let planet = Sphere { center: (up * -1000.0).as_vec3(), radius: 1000.0 };
        let mut scene = floor_and_sphere();
        scene.objects = vec![scene::Object::mesh("slope", mesh, 0, scene::Proxy::Count(8))];
        let [a, b, c] = corners.map(|p| p.as_dvec3());
        let normal = (b - a).cross(c - a).normalize();
        let normal = normal * normal.dot(up).signum();
        let mut random = Random::new(7);
        let mut seen = [0; 2];
        for part in 0..2 {
            if part == 1 {
                scene.objects = vec![scene::Object::spheres("planet", vec![planet], 0)];
            }
            let world = World::new(&scene);
            for _ in 0..20_000 {
                let size = random.log_uniform(0.01, 3.0);
                let p = turn * DVec3::new(random.between(-size, size), 0.0, random.between(-size, size));
                let center = planet.center.as_dvec3();
                let (on, face) = if part == 0 {
                    (p - normal * normal.dot(p - a), normal)
                } else {
                    let outward = (p - center).normalize();
                    (center + outward * f64::from(planet.radius), outward)
                };
                let (position, face) = (on.as_vec3(), face.as_vec3());
                let direction = random.axis().as_vec3();
                let cos = direction.dot(face);
                if cos.abs() < 1e-3 {
                    continue;
                }
                for side in [face, -face] {
                    let is_inside = part == 1 && side.dot(face) < 0.0;
                    let hidden = world.occluded(world.leave(position, side), direction, 1e6);
                    assert_eq!(hidden, is_inside || direction.dot(side) < 0.0, "{position} {direction} {side}");
                    seen[usize::from(hidden)] += 1;
                }
            }
        }
        assert!(seen.iter().all(|n| *n > 10_000), "{seen:?}");
    }

    /// A thin gap under a large plate: rays from the floor meet it, those from its top do not.
    #[test]
    fn surfaces_close_together_are_told_apart() {
        let plate = |y: f32| Mesh::quad(Vec3::Y * y, Vec3::X * 1000.0, Vec3::NEG_Z * 1000.0);
        let gap = 2e-6;
        let mut scene = floor_and_sphere();
        scene.objects = vec![
            scene::Object::mesh("floor", plate(0.0), 0, scene::Proxy::Count(8)),
            scene::Object::mesh("plate", plate(gap), 0, scene::Proxy::Count(8)),
        ];
        let world = World::new(&scene);
        let direction = Vec3::new(0.3, 0.8, -0.2).normalize();
        for x in [-0.9_f32, -0.3, 0.0, 0.4, 0.7] {
            let hidden = |y: f32| world.occluded(world.leave(Vec3::new(x, y, 0.3), Vec3::Y), direction, 100.0);
            assert!(hidden(0.0) && !hidden(gap), "{x}");
        }
    }

    /// A sphere on a floor, and a wall with a corner beside them; f32 has the planes and the edges near the sphere exactly, whatever their size.
    fn airfield(size: f32) -> Scene {
        let quad = |corners: [Vec3; 4]| Mesh {
            positions: corners.to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        };
        let (s, v) = (size, Vec3::new);
        let floor = quad([v(-0.9 * s, 0.0, -0.7 * s), v(s, 0.0, -0.6 * s), v(0.8 * s, 0.0, s), v(-s, 0.0, 0.9 * s)]);
        let wall = quad([v(-s, 0.5, -1.0), v(0.25, 0.5, -1.0), v(0.25, s, -1.0), v(-s, s, -1.0)]);
        let mut scene = floor_and_sphere();
        (scene.camera.eye, scene.camera.target) = (v(1.0, 2.0, 4.0), v(0.0, 0.4, 0.0));
        let globe = test_scenes::globe(40, v(0.0, 0.5, 0.0), 0.5, false);
        let objects = [("floor", floor), ("wall", wall), ("globe", globe)];
        let object = |(name, mesh)| scene::Object::mesh(name, mesh, 0, scene::Proxy::None);
        scene.objects = objects.into_iter().map(object).collect();
        scene
    }

    /// The visible surface, and the points that see two lights, do not depend on how far floor and wall reach.
    #[test]
    fn giants_are_met_where_they_are() {
        let look = |size: f32| {
            let scene = airfield(size);
            let world = World::new(&scene);
            let g = GBuffer::new(&world, 90, 60, 1);
            let hidden = |r: &lobe_core::Receiver, light: Vec3| {
                let from = world.leave(r.position, r.face);
                let is_below = r.face.dot(light - from) <= 0.0;
                is_below || world.occluded(from, (light - from).normalize(), light.distance(from))
            };
            // One before the wall, and one behind it.
            let lights = [Vec3::new(2.0, 3.0, 1.0), Vec3::new(-0.6, 1.1, -2.5)];
            let points = g.points.receivers.iter().map(|r| (r.object, lights.map(|l| hidden(r, l)), r.position));
            g.pixels.iter().copied().zip(points).collect::<std::collections::HashMap<_, _>>()
        };
        let (near, eye) = (look(50.0), airfield(50.0).camera.eye);
        let counts = [0, 1, 2].map(|o| near.values().filter(|p| p.0 == o).count());
        assert!(counts.iter().all(|n| *n > 100), "{counts:?}");
        let hidden = [0, 1].map(|k| near.values().filter(|p| p.1[k]).count());
        assert!(hidden.iter().all(|n| *n > 50 && *n < near.len() - 50), "{hidden:?} of {}", near.len());
        for size in [1e3, 1e4, 1e5, 1e6, 1e7] {
            let far = look(size);
            let is_same = |(pixel, a): (&u32, &(u32, [bool; 2], Vec3))| {
                far.get(pixel).is_some_and(|b| (a.0, a.1) == (b.0, b.1) && a.2.distance(b.2) < 3e-4 * a.2.distance(eye))
            };
            // At 50 the floor ends within the picture.
            let within = |p: &(&u32, &(u32, [bool; 2], Vec3))| p.1.2.abs().max_element() < 20.0;
            let different = near.iter().filter(within).filter(|p| !is_same(*p)).count();
            // At edges: those that are not giants yet reach 1e-6 of their length too far.
            assert!(different <= 10, "{size}: {different} of {}", near.len());
        }
    }

    /// Points, their faces, and which of them see a point above the scene, to the bit at any scale.
    #[test]
    fn the_unit_of_length_does_not_matter() {
        let look = |exponent: i32| {
            let s = 2.0_f32.powi(exponent);
            let scene = scaled(s);
            let world = World::new(&scene);
            let g = GBuffer::new(&world, 50, 30, 1);
            let one = |r: &lobe_core::Receiver| {
                let from = world.leave(r.position, r.face);
                let to = Vec3::new(1.0, 5.0, 0.5) * s - from;
                (r.position / s, r.face, world.occluded(from, to.normalize(), to.length()))
            };
            g.points.receivers.iter().map(one).collect::<Vec<_>>()
        };
        let unit = look(0);
        assert!(unit.len() > 500);
        assert!(unit.iter().any(|(.., hidden)| *hidden) && unit.iter().any(|(.., hidden)| !hidden));
        for exponent in [-40, -27, -13, 20] {
            let other = look(exponent);
            let different = other.iter().zip(&unit).find(|(a, b)| a != b);
            assert!(other.len() == unit.len() && different.is_none(), "2^{exponent}: {different:?}");
        }
    }
}
