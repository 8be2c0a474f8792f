//! Shadow rays: where they start, when none is shot, how near to Monte Carlo they come.

use brdf::Material;
use core::sync::atomic::AtomicBool;
use glam::{Mat4, Vec3};
use lighting::SphereLight;
use lobe_core::{Cone, Receiver, Sphere};
use ray_tracing::{GBuffer, World};
use reference::{Geometry, Reference, ReferenceJob};
use render_cpu::CpuShader;
use scene::{BlockerSet, Camera, Frame, Mesh, Object, Projection, Proxy, Scene, ShadingPoints};
use shading::{Accuracy, Coverage, LightId, Shaft, Visibility, VisibilityQuery};
use test_scenes::globe;
use visibility_mask::{Blockers, Mask, MaskVisibility};
use visibility_rays::RayBlockers;

fn scene(meshes: Vec<Mesh>, light: Sphere) -> Scene {
    let object = |(i, mesh)| Object::mesh(format!("mesh {i}"), mesh, 0, Proxy::None);
    Scene {
        camera: Camera {
            eye: Vec3::new(1.0, 2.0, 4.0),
            target: Vec3::Y * 0.5,
            up: Vec3::Y,
            projection: Projection::perspective(0.6),
        },
        width: 64,
        height: 48,
        materials: vec![Material::lambert(Vec3::splat(0.5))],
        objects: meshes.into_iter().enumerate().map(object).collect(),
        lights: vec![SphereLight::new(light, Vec3::ONE).into()],
        ..Scene::default()
    }
}

fn floor(half: f32) -> Mesh {
    Mesh::quad(Vec3::ZERO, Vec3::X * half, Vec3::NEG_Z * half)
}

fn coverage(rays: &RayBlockers<'_>, at: &Receiver, light: Sphere, entered: bool) -> Coverage {
    let visibility = MaskVisibility::new(RayBlockers::new(rays.world()));
    let mut scratch = visibility.scratch();
    if entered {
        let receivers = Sphere { center: at.position, radius: 0.05 };
        visibility.enter(&Shaft::new(receivers, light, LightId(0)), &mut scratch);
    }
    let cone = Cone::of_sphere(at.position, light);
    visibility.coverage(&VisibilityQuery::new(at, LightId(0), &cone, Accuracy::new(0.003)), &mut scratch)
}

/// A convex mesh does not shadow itself where the light is above the face, whatever the scale and place.
#[test]
fn no_surface_shadows_itself() {
    for (scale, shift) in [(1.0, 0.0), (1e-3, 0.0), (1e4, 0.0), (1.0, 1e3)] {
        let place = Mat4::from_translation(Vec3::splat(shift)) * Mat4::from_scale(Vec3::splat(scale));
        let mut mesh = globe(48, Vec3::Y, 0.5, true);
        mesh.transform(&place);
        let center = place.transform_point3(Vec3::new(3.0, 6.0, 4.0));
        let light = Sphere { center, radius: 0.5 * scale };
        let mut scene = scene(vec![mesh], light);
        scene.camera.eye = place.transform_point3(scene.camera.eye);
        scene.camera.target = place.transform_point3(scene.camera.target + Vec3::Y * 0.5);
        let world = World::new(&scene);
        let rays = RayBlockers::new(&world);
        let g = GBuffer::new(&world, 64, 48, 1);
        let mut counts = [0; 2];
        for at in &g.points.receivers {
            let (face, cone) = (at.face, Cone::of_sphere(at.position, light));
            if face.dot(cone.axis) > 1.01 * cone.sin_sq().sqrt() {
                assert_eq!(coverage(&rays, at, light, counts[0] % 2 == 0), Coverage::Lit, "{at:?} × {scale}");
                counts[0] += 1;
            } else if face.dot(cone.axis) < -1.01 * cone.sin_sq().sqrt() {
                assert_eq!(coverage(&rays, at, light, counts[1] % 2 == 0), Coverage::Dark, "{at:?} × {scale}");
                counts[1] += 1;
            }
        }
        assert!(counts[0] > 200 && counts[1] > 10, "{counts:?} of {}", g.len());
    }
}

/// No light leaks under a box that stands on the floor, down to 1e-5 of its size.
#[test]
fn contact_is_dark() {
    let light = Sphere { center: Vec3::new(3.0, 3.0, 0.0), radius: 0.2 };
    let scene = scene(vec![floor(4.0), Mesh::cuboid(Vec3::Y * 0.5, Vec3::ONE)], light);
    let world = World::new(&scene);
    let rays = RayBlockers::new(&world);
    for distance in [1e-5, 1e-4, 1e-3, 1e-2] {
        let position = Vec3::new(-0.5 - distance, 0.0, 0.1);
        let at = Receiver::on_surface(position, Vec3::Y, Vec3::Y).on_object(0);
        assert_eq!(coverage(&rays, &at, light, false), Coverage::Dark, "{distance} from the box");
    }
}

/// A blocker that no ray can meet costs no ray; a point light costs one.
#[test]
fn lit_points_cost_nothing() {
    let light = Sphere { center: Vec3::new(3.0, 3.0, 0.0), radius: 0.2 };
    let scene = scene(vec![floor(4.0), Mesh::cuboid(Vec3::Y * 0.5, Vec3::ONE)], light);
    let world = World::new(&scene);
    let visibility = MaskVisibility::new(RayBlockers::new(&world));
    let mut scratch = visibility.scratch();
    let mut ask = |x: f32, sphere: Sphere, entered: bool| {
        let at = Receiver::on_surface(Vec3::new(x, 0.0, 0.3), Vec3::Y, Vec3::Y).on_object(0);
        if entered {
            let receivers = Sphere { center: at.position, radius: 0.05 };
            visibility.enter(&Shaft::new(receivers, sphere, LightId(0)), &mut scratch);
        }
        let cone = Cone::of_sphere(at.position, sphere);
        let before = visibility.blockers().rays();
        let coverage =
            visibility.coverage(&VisibilityQuery::new(&at, LightId(0), &cone, Accuracy::new(0.003)), &mut scratch);
        (coverage, visibility.blockers().rays() - before)
    };
    for entered in [false, true] {
        assert_eq!(ask(1.0, light, entered), (Coverage::Lit, 0));
        assert_eq!(ask(-3.0, light, entered), (Coverage::Lit, 0));
        let (coverage, rays) = ask(-2.25, light, entered);
        assert!(coverage == Coverage::Partial && (80..350).contains(&rays), "{coverage:?}, {rays} rays");
        let point = Sphere { radius: 0.0, ..light };
        assert_eq!(ask(1.0, point, entered).0, Coverage::Lit);
        assert_eq!(ask(-0.7, point, entered), (Coverage::Dark, 1));
    }
}

/// A large floor that no plane in f32 holds exactly does not shade the points on it, nor cost them rays.
#[test]
fn a_large_floor_is_lit() {
    let turn = Mat4::from_quat(glam::Quat::from_xyzw(0.31, -0.22, 0.17, 0.91).normalize());
    let light = Sphere { center: turn.transform_point3(Vec3::new(3.0, 3.0, 0.0)), radius: 0.2 };
    let mut floor = floor(1000.0);
    floor.transform(&turn);
    let [a, b, c] = [0, 1, 2].map(|k| floor.positions[k].as_dvec3());
    let normal = (b - a).cross(c - a).normalize();
    let scene = scene(vec![floor], light);
    let world = World::new(&scene);
    let rays = RayBlockers::new(&world);
    for k in 0..400_u16 {
        let p = turn.transform_point3(Vec3::new(f32::from(k % 20) - 9.5, 0.0, f32::from(k / 20) - 9.5)).as_dvec3();
        let (position, face) = ((p - normal * normal.dot(p - a)).as_vec3(), normal.as_vec3());
        let at = Receiver::on_surface(position, face, face).on_object(0);
        let cone = Cone::of_sphere(position, light);
        let mut scratch = rays.scratch();
        let receivers = Sphere { center: position, radius: 0.05 };
        rays.enter(&Shaft::new(receivers, light, LightId(0)), &mut scratch);
        let coverage = rays.select(&VisibilityQuery::new(&at, LightId(0), &cone, Accuracy::new(0.003)), &mut scratch);
        assert_eq!(coverage, Coverage::Lit, "{position}");
    }
}

/// The built-in scene against Monte Carlo of the true geometry, relative to the unshadowed radiance.
#[test]
fn near_monte_carlo() {
    let scene = scene::builtin();
    let world = World::new(&scene);
    let g = GBuffer::new(&world, 72, 40, 1);
    let none = BlockerSet::default();
    let job = ReferenceJob { world: &world, gbuffer: &g, blockers: &none, geometry: Geometry::Mesh, seed: 1 };
    let mut reference = Reference::new(job);
    reference.advance(1024, &AtomicBool::new(false), &|_| {});
    let truth = reference.estimate();
    let frame = Frame::new(&g.materials, &scene.lights, Accuracy::new(0.003));
    let shader = CpuShader::new(MaskVisibility::new(RayBlockers::new(&world)));
    let mut out = vec![Vec3::ZERO; g.len()];
    let (_, layers) = shader.shade_layers(&g.points, &frame, &mut out);
    let (mut errors, mut noise) = (Vec::new(), 0.0);
    for (i, out) in out.iter().enumerate() {
        let sum = |v: Vec3| f64::from(v.element_sum());
        let (want, whole) = (sum(truth.radiance[i]), sum(truth.unshadowed[i]));
        if whole > 0.0 && (0.01..=0.99).contains(&(want / whole)) {
            // The lobes' own part of the error is that of the unshadowed radiance.
            let share = sum(*out) / sum(layers.unshadowed[i]);
            errors.push((share - want / whole).abs());
            noise += sum(truth.std_error[i]) / whole;
        }
    }
    errors.sort_by(f64::total_cmp);
    let n = errors.len();
    let mean = errors.iter().sum::<f64>() / n as f64;
    println!("{n} in penumbra: mean {mean:.5}, p99 {:.5}, reference ± {:.5}", errors[n * 99 / 100], noise / n as f64);
    assert!(n > 300 && mean < 0.004 && errors[n * 99 / 100] < 0.03);
}

/// A mask with every cell traced.
struct EveryCell<'w>(&'w World<'w>);

impl Blockers for EveryCell<'_> {
    type Scratch = ();

    fn scratch(&self) {}

    fn select(&self, _: &VisibilityQuery<'_>, (): &mut ()) -> Coverage {
        Coverage::Partial
    }

    fn splat(&self, query: &VisibilityQuery<'_>, (): &mut (), mask: &mut Mask) {
        let origin = self.0.leave(query.at.position, query.at.face);
        mask.block_where(|v| self.0.occluded(origin, v, query.cone.distance * query.cone.cos()));
    }
}

/// The saving of the contour: the visible fraction against that of a mask with every cell traced, over penumbrae.
#[test]
fn near_the_full_mask() {
    let picket = |k: i16| Mesh::cuboid(Vec3::new(-1.5 + 0.1 * f32::from(k), 0.5, 0.0), Vec3::new(0.05, 1.0, 0.02));
    let mut fence = Mesh::default();
    (0..31).for_each(|k| fence.append(&picket(k)));
    let light = Sphere { center: Vec3::new(-2.0, 4.0, 3.5), radius: 0.5 };
    for (name, mesh) in [("globe", globe(48, Vec3::Y * 0.6, 0.5, true)), ("fence", fence)] {
        let scene = scene(vec![floor(10.0), mesh], light);
        let world = World::new(&scene);
        let g = GBuffer::new(&world, 192, 144, 1);
        let all = shares(MaskVisibility::new(RayBlockers::new(&world)), 5, &scene, &g.points);
        let mut points = ShadingPoints::default();
        for (k, _) in all.iter().enumerate().filter(|(_, share)| (0.01..=0.99).contains(*share)) {
            points.receivers.push(g.points.receivers[k]);
            points.materials.push(g.points.materials[k]);
        }
        let rays = RayBlockers::new(&world);
        let own = shares(MaskVisibility::new(&rays), 5, &scene, &points);
        let (count, asked) = (points.receivers.len(), rays.rays() as f64 / points.receivers.len() as f64);
        assert!(count > 500 && asked < 600.0, "{name}: {count} points, {asked} rays");
        for depth in [5, 6] {
            let full = shares(MaskVisibility::new(EveryCell(&world)), depth, &scene, &points);
            let mean = own.iter().zip(&full).map(|(a, b)| (a - b).abs()).sum::<f64>() / count as f64;
            println!("{name}: {count} points, {asked:.0} rays, {mean:.5} from all cells of depth {depth}");
            assert!(mean <= 0.002, "{name}: {mean} from all cells of depth {depth}");
        }
    }
}

/// The fraction of the light that each point sees.
fn shares<V: Visibility>(visibility: V, depth: u32, scene: &Scene, points: &ShadingPoints) -> Vec<f64> {
    let frame = Frame::new(&scene.materials, &scene.lights, Accuracy { tolerance: 0.003, depth });
    let mut out = vec![Vec3::ZERO; points.receivers.len()];
    let (_, layers) = CpuShader::new(visibility).shade_layers(points, &frame, &mut out);
    let share = |(v, whole): (&Vec3, &Vec3)| f64::from(v.x) / f64::from(whole.x).max(1e-12);
    out.iter().zip(&layers.unshadowed).map(share).collect()
}
