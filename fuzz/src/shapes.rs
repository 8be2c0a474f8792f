//! Triangles that are no mesh, and spheres of any size, in the way of a light.

use crate::bytes::Bytes;
use cosine_lobes::brdf::Material;
use cosine_lobes::lobe_core::{Cone, Lobe, Receiver, Sphere, cap_integral};
use cosine_lobes::render_cpu::{SceneSilhouettes, SurfaceHits, World};
use cosine_lobes::scene::{Camera, Mesh, Object, Projection, Proxy, Scene};
use cosine_lobes::shading::{Accuracy, LightCoverage, LightId, LightVisibility, Visibility};
use cosine_lobes::sphere_sets::{BuildOptions, SphereSet};
use cosine_lobes::visibility_mask::{Blockers, MaskVisibility};
use cosine_lobes::visibility_rays::RayBlockers;
use cosine_lobes::visibility_shadowmap::{MapOptions, ShadowMap, ShadowMapBlockers};
use cosine_lobes::visibility_silhouettes::SilhouetteBlockers;
use cosine_lobes::visibility_spheres::SphereBlockers;
use glam::Vec3;

/// Triangles among a few corners, and triangles of their own, of one size at one place; no coordinate beyond 1e9.
fn soup(bytes: &mut Bytes<'_>) -> Mesh {
    let (size, place) = (bytes.size(-12.0, 8.0), bytes.byte());
    let middle = match place % 4 {
        0 => bytes.vector(0.9e9),
        1 => bytes.vector(100.0 * size),
        _ => Vec3::ZERO,
    };
    let flat = place & 16 != 0;
    let corner = |bytes: &mut Bytes<'_>| {
        let p = bytes.vector(size);
        (middle + if flat { p * Vec3::new(1.0, 0.0, 1.0) } else { p }).clamp(Vec3::splat(-1e9), Vec3::splat(1e9))
    };
    let count = 3 + bytes.below(20);
    let mut mesh = Mesh { positions: (0..count).map(|_| corner(bytes)).collect(), ..Mesh::default() };
    for _ in 0..1 + bytes.below(30) {
        mesh.triangles.push([bytes.below(count), bytes.below(count), bytes.below(count)]);
    }
    mesh.remove_degenerate();
    mesh
}

pub(crate) fn builder(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let mesh = soup(&mut bytes);
    let options = BuildOptions {
        count: 1 + bytes.below(6).min(bytes.below(6)) as usize,
        seed: u64::from(bytes.byte()),
        // Rounds and spheres take most of the time: fewer inputs have many.
        rounds: bytes.below(8).saturating_sub(5) as _,
        bounding: bytes.byte().is_multiple_of(2),
    };
    if let Ok(set) = SphereSet::build(&mesh.positions, &mesh.triangles, &options) {
        let sound = |s: &Sphere| s.center.is_finite() && s.radius.is_finite() && s.radius >= 0.0;
        assert!(set.spheres.iter().all(sound) && set.spheres.len() <= options.count, "{mesh:?} {options:?}: {set:?}");
        assert!(set.self_distance >= 0.0 && set.self_distance.is_finite(), "{mesh:?} {options:?}");
    }
}

pub(crate) fn visibility(data: &[u8]) {
    let mut bytes = Bytes::new(data);
    let mesh = soup(&mut bytes);
    if mesh.triangles.is_empty() {
        return;
    }
    let bounds = mesh.bounds();
    let size = bounds.radius().max(1e-20);
    let spheres: Vec<Sphere> = (0..bytes.below(10))
        .map(|_| Sphere { center: bounds.center() + bytes.vector(size), radius: size * bytes.edge() })
        .collect();
    let object = Object::mesh("soup", mesh.clone(), 0, Proxy::Count(4));
    let scene = Scene {
        camera: Camera { eye: Vec3::Z, target: Vec3::ZERO, up: Vec3::Y, projection: Projection::perspective(0.6) },
        width: 1,
        height: 1,
        materials: vec![Material::lambert(Vec3::splat(0.5))],
        objects: vec![object],
        lights: Vec::new(),
        ..Scene::default()
    };
    let world = World::new(&scene);
    let outlines = SceneSilhouettes::new(&scene, |_| true);
    for _ in 0..3 {
        let light = Sphere { center: bounds.center() + bytes.vector(4.0 * size), radius: size * bytes.size(-6.0, 0.5) };
        let normal = bytes.direction();
        let place = bytes.byte() % 3;
        let position = match place {
            0 => mesh.positions[bytes.below(mesh.positions.len() as u32) as usize],
            1 => bounds.center() + bytes.vector(size),
            _ => bounds.center() + bytes.vector(100.0 * size),
        };
        let at = Receiver::on_surface(position, normal, normal).on_object(bytes.below(2));
        let query = (at, light);
        let rays = check("rays", RayBlockers::new(&world), &query, &mut bytes);
        let exact = SilhouetteBlockers::new(outlines.meshes(), SurfaceHits::new(&world, |_| true));
        let silhouettes = check("silhouettes", exact, &query, &mut bytes);
        // Fully lit and fully dark must be found as such. On a corner of the soup rounding decides the side of its triangles.
        if place > 0 {
            let truth = seen(&mesh, &query);
            for (name, found) in [("rays", rays), ("silhouettes", silhouettes)] {
                let Some(found) = found else { continue };
                let wrong = truth == Some(0.0) && found > 0.9 || truth == Some(1.0) && found < 0.1;
                assert!(!wrong, "{name} {found}, in f64 {truth:?}: {query:?} {mesh:?}");
            }
        }
        check("spheres", SphereBlockers::new(&spheres, &vec![0; spheres.len()], &[]), &query, &mut bytes);
        let options = MapOptions { resolution: 16 + bytes.below(48), ..MapOptions::default() };
        if let Ok(map) = ShadowMap::build(&mesh.positions, &mesh.triangles, light, &options) {
            check("maps", ShadowMapBlockers::new(vec![map]), &query, &mut bytes);
        }
    }
}

/// The visible fraction of a light by rays in f64; `None` if some of them pass an edge, start so near to a triangle that single
/// precision may decide otherwise, or meet one inside the light.
fn seen(mesh: &Mesh, (at, light): &(Receiver, Sphere)) -> Option<f64> {
    const RAYS: u32 = 61;
    let (from, center) = (at.position.as_dvec3(), light.center.as_dvec3());
    let (axis, radius, distance) = ((center - from).normalize(), f64::from(light.radius), center.distance(from));
    let (right, up) = axis.any_orthonormal_pair();
    let scale = mesh.positions.iter().map(|p| p.as_dvec3().abs().max_element()).fold(0.0, f64::max);
    let scale = scale.max(from.abs().max_element()).max(center.abs().max_element());
    if distance <= 1.01 * radius || radius < 1e-6 * scale {
        return None;
    }
    let mut lit = 0;
    for k in 0..RAYS {
        // A sunflower.
        let (sin, turn) = (radius / distance * (f64::from(k) / f64::from(RAYS - 1)).sqrt(), 2.399_963 * f64::from(k));
        let to = (right * turn.cos() + up * turn.sin()) * sin + axis * (1.0 - sin * sin).sqrt();
        let middle = distance * (1.0 - sin * sin).sqrt();
        let front = middle - (radius * radius - (distance * sin).powi(2)).max(0.0).sqrt();
        let mut hidden = false;
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize].as_dvec3());
            let (e1, e2, s) = (b - a, c - a, from - a);
            let p = to.cross(e2);
            let det = e1.dot(p);
            let normal = e1.cross(e2).normalize();
            if normal.dot(s).abs() < 1e-4 * scale || normal.dot(to).abs() < 1e-3 {
                return None;
            }
            let q = s.cross(e1);
            let (u, v, w) = (s.dot(p) / det, to.dot(q) / det, e2.dot(q) / det);
            let inside = u.min(v).min(1.0 - u - v);
            let in_light = (0.999 * front..1.001 * middle).contains(&w);
            if inside.abs() < 1e-3 || inside > 0.0 && in_light {
                return None;
            }
            hidden |= inside > 0.0 && w > 0.0 && w < front;
        }
        lit += u32::from(!hidden);
    }
    Some(f64::from(lit) / f64::from(RAYS))
}

/// The visible fraction of a diffuse lobe. Checks that all fractions lie from 0 to 1. `None` if the light is not in sight.
fn check<B: Blockers>(name: &str, blockers: B, (at, light): &(Receiver, Sphere), bytes: &mut Bytes<'_>) -> Option<f32> {
    let visibility = MaskVisibility::new(blockers);
    let cone = Cone::of_sphere(at.position, *light);
    let mut scratch = visibility.scratch();
    let mut visit =
        LightVisibility::alone(&visibility, LightId(0), Accuracy { tolerance: 0.003, depth: 4 }, &mut scratch);
    let look = visit.coverage(at, &cone, None);
    let mut diffuse = None;
    let narrow = Lobe::new(bytes.direction(), bytes.size(0.0, 6.0), Vec3::ONE).times_cosine();
    for (k, lobe) in [Lobe::new(at.normal, 1.0, Vec3::ONE), narrow].into_iter().enumerate() {
        let unshadowed = cap_integral(at, lobe, &cone);
        if unshadowed <= 0.0 || unshadowed.is_nan() {
            continue;
        }
        let fraction = match &look {
            LightCoverage::Lit => 1.0,
            LightCoverage::Dark => 0.0,
            LightCoverage::Partial(seen) => visit.fraction(seen, lobe, unshadowed).x,
        };
        assert!((0.0..=1.0).contains(&fraction), "{name}: {fraction} of {lobe:?} at {at:?} from {light:?}");
        if k == 0 {
            diffuse = Some(fraction);
        }
    }
    diffuse
}
