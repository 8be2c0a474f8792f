use super::{Hierarchy, Update, World};
use glam::{Quat, Vec3};
use lobe_core::Sphere;
use scene::{Mesh, Object, Proxy, Scene, Shape};
use std::sync::Arc;
use test_scenes::floor_and_sphere;

struct Rng(u64);

impl Rng {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }

    fn vec3(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next()) * 2.0 - 1.0
    }
}

/// Small triangles and spheres all over a box.
fn soup(rng: &mut Rng) -> Scene {
    let mut scene = floor_and_sphere();
    let mut positions = Vec::new();
    for _ in 0..700 {
        let place = rng.vec3() * 3.0;
        positions.extend((0..3).map(|_| place + rng.vec3() * 0.2));
    }
    let triangles = (0..700).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mesh = Mesh { positions, triangles, ..Mesh::default() };
    scene.objects.push(Object::mesh("soup", mesh, 0, Proxy::Count(1)));
    let spheres = (0..60).map(|_| Sphere { center: rng.vec3() * 3.0, radius: 0.1 * rng.next() + 0.01 }).collect();
    scene.objects.push(Object::spheres("spheres", spheres, 0));
    scene
}

fn bend(scene: &mut Scene, by: f32) {
    for object in &mut scene.objects[1..] {
        let bend = |p: Vec3| Quat::from_rotation_y(by * p.y) * p + Vec3::X * by;
        match &mut object.shape {
            Shape::Mesh(mesh) => mesh.positions.iter_mut().for_each(|p| *p = bend(*p)),
            Shape::Instances(_) => {}
            Shape::Spheres(spheres) => spheres.iter_mut().for_each(|b| b.center = bend(b.center)),
        }
    }
}

/// Through twenty poses, with and without need for a new hierarchy, and a triangle that loses its area for a while: rays
/// have the hits of a world made anew.
#[test]
fn a_refitted_world_is_the_new_one() {
    let mut rng = Rng(3);
    let mut scene = soup(&mut rng);
    let mut hierarchy = Arc::new(Hierarchy::new(&scene));
    let (mut hits, mut refits) = (0, 0);
    for pose in 0..20 {
        let by = if pose == 12 { 3.0 } else { 0.02 };
        bend(&mut scene, by);
        if let (Shape::Mesh(mesh), 5 | 8) = (&mut scene.objects[2].shape, pose) {
            let (a, b) = (mesh.positions[0], mesh.positions[1]);
            mesh.positions[1] = if pose == 5 { a } else { b + Vec3::Y * 0.1 };
        }
        let done = Arc::get_mut(&mut hierarchy).expect("no world has it").update(&scene);
        let world = World::with_hierarchy(&scene, Arc::clone(&hierarchy));
        let anew = World::new(&scene);
        assert_eq!(world.triangle_count(), anew.triangle_count());
        for _ in 0..500 {
            let (origin, direction) = (rng.vec3() * 4.0, rng.vec3().normalize());
            let (a, b) = (world.hit(origin, direction), anew.hit(origin, direction));
            assert_eq!(a, b, "pose {pose}");
            let reach = 4.0 * rng.next();
            assert_eq!(world.occluded(origin, direction, reach), anew.occluded(origin, direction, reach));
            hits += usize::from(a.is_some());
        }
        refits += usize::from(done == Update::Refitted);
    }
    assert!(hits > 1000, "{hits}");
    // Those where a triangle vanishes or comes back, or everything is wound up, are built anew.
    assert!((16..20).contains(&refits), "{refits}");
}

/// A resting object is kept; another visibility marks it; a moved object is refitted; a new object is built.
#[test]
fn an_update_does_no_more_than_it_must() {
    let mut scene = soup(&mut Rng(4));
    let mut hierarchy = Hierarchy::new(&scene);
    assert_eq!(hierarchy.update(&scene), Update::Kept);
    let light = scene.lights[0].sphere().expect("a sphere");
    scene.lights.clear();
    assert!(!hierarchy.update_lights(&scene));
    scene.objects[2].visible = false;
    assert_eq!(hierarchy.update(&scene), Update::Marked);
    bend(&mut scene, 0.01);
    assert_eq!(hierarchy.update(&scene), Update::Refitted);
    scene.objects.push(Object::spheres("lamp", vec![light], 0));
    assert_eq!(hierarchy.update(&scene), Update::Built);
    scene.lights = floor_and_sphere().lights;
    assert!(hierarchy.update_lights(&scene));
    assert_eq!(hierarchy.update(&scene), Update::Kept);
    let world = World::with_hierarchy(&scene, Arc::new(hierarchy));
    // As far as the light's surface.
    assert!(!world.occluded(light.center - Vec3::Y * (light.radius + 0.1), Vec3::Y, 0.1001));
}
