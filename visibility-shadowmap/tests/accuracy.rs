//! Against rays on the mesh in f64. The reference has 40² samples: its own error is about 0.15 % a receiver.

mod common;

use common::{Errors, Mesh, receiver};
use glam::Vec3;
use lobe_core::oracle::Random;
use lobe_core::{Cone, Lobe, Receiver, Sphere, cap_integral};
use shading::{Accuracy, LightCoverage, LightId, LightVisibility, Visibility};
use visibility_mask::MaskVisibility;
use visibility_shadowmap::{MapOptions, ReceiverBounds, ShadowMap, ShadowMapBlockers};

const LIGHT: Sphere = Sphere { center: Vec3::new(2.0, 5.0, 1.5), radius: 0.6 };

fn floor(center: Vec3, half: f32, side: usize) -> Vec<Receiver> {
    (0..side * side)
        .map(|k| {
            let at = |k: usize| (k as f32 + 0.5) / side as f32 * 2.0 - 1.0;
            receiver(center + Vec3::new(at(k % side) * half, 0.0, at(k / side) * half), Vec3::Y)
        })
        .collect()
}

/// Points on a mesh that face the light, if nothing lies on them.
fn on(mesh: &Mesh, light: Sphere, count: usize) -> Vec<Receiver> {
    let mut random = Random::new(3);
    let mut all = Vec::new();
    while all.len() < count {
        let t = mesh.triangles[random.bits() as usize % mesh.triangles.len()];
        let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
        let (u, v) = (random.uniform() as f32, random.uniform() as f32);
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        let Some(normal) = (b - a).cross(c - a).try_normalize() else { continue };
        let position = a + (b - a) * u + (c - a) * v;
        if normal.dot(light.center - position) > light.radius {
            all.push(receiver(position, normal));
        }
    }
    all
}

fn options(resolution: u32) -> MapOptions {
    MapOptions { resolution, ..MapOptions::default() }
}

#[test]
fn cube_on_a_floor() {
    let cube = Mesh::default().cuboid(Vec3::new(-0.5, 0.0, -0.5), Vec3::new(0.5, 1.0, 0.5));
    let outside = |at: &Receiver| at.position.x.abs() > 0.5 || at.position.z.abs() > 0.5;
    let receivers: Vec<_> = floor(Vec3::new(-0.3, 0.0, -0.2), 1.2, 24).into_iter().filter(outside).collect();
    Errors::of(&cube, &receivers, LIGHT, &options(512)).below("cube, floor", 0.5, 0.12, 0.02);
    // The cube's lit faces do not shadow themselves.
    let [_, _, lit] = Errors::of(&cube, &on(&cube, LIGHT, 300), LIGHT, &options(512)).means();
    assert!(lit <= 0.02, "{lit}");
    // The same with a floor among the casters: it can shadow no receiver.
    let both = cube.quad([(-9, -9), (-9, 9), (9, 9), (9, -9)].map(|(x, z)| Vec3::new(x as f32, 0.0, z as f32)));
    let bounds = ReceiverBounds { min: Vec3::new(-2.0, 0.0, -2.0), max: Vec3::new(2.0, 1.0, 2.0) };
    let fitted = MapOptions { receivers: Some(bounds), ..options(512) };
    assert_eq!(both.map(LIGHT, &fitted).faces(), 1);
    Errors::of(&both, &receivers, LIGHT, &fitted).below("cube and floor, floor", 0.5, 0.12, 0.02);
    let wide = both.map(LIGHT, &options(512));
    assert!(wide.faces() > 1, "a floor all around needs a cube");
    Errors::of(&both, &receivers, LIGHT, &options(1024)).below("cube and floor, not fitted", 2.0, 0.3, 0.1);
}

#[test]
fn two_stacked_plates() {
    let plate = |mesh: Mesh, y: f32| mesh.cuboid(Vec3::new(-0.35, y, -0.35), Vec3::new(0.35, y + 0.02, 0.35));
    let plates = plate(plate(Mesh::default(), 0.35), 0.8);
    let receivers = floor(Vec3::new(-0.3, 0.0, -0.2), 0.8, 24);
    let three = Errors::of(&plates, &receivers, LIGHT, &options(512));
    three.below("plates, floor", 0.4, 0.05, 0.02);
    // Without the third layer the map misses the lower plate behind the upper one.
    let two = Errors::of(&plates, &receivers, LIGHT, &MapOptions { layers: 2, ..options(512) });
    assert!(two.means()[1] > 3.0 * three.means()[1].max(0.1), "{:?}", two.means());
    Errors::of(&plates, &on(&plates, LIGHT, 400), LIGHT, &options(512)).below("plates, self", 0.6, 0.1, 0.02);
}

#[test]
fn fence() {
    let fence = Mesh::fence();
    let receivers = floor(Vec3::new(-0.4, 0.0, -0.4), 0.7, 20);
    let clear = |at: &Receiver| at.position.z.abs() > 0.05;
    let receivers: Vec<_> = receivers.into_iter().filter(clear).collect();
    Errors::of(&fence, &receivers, LIGHT, &options(1024)).below("fence, floor", 0.6, 0.1, 0.05);
}

/// Rails shadow the pickets that carry them: a fitted map is fine enough.
#[test]
fn fence_on_itself() {
    let (fence, light) = (Mesh::fence(), Sphere { center: Vec3::new(-2.0, 4.0, 3.5), radius: 0.5 });
    let mut random = Random::new(6);
    // Below the rails, at the ends of their shadows.
    let on_picket = |k: usize| {
        let x = -1.5 + 0.1 * (k / 2 % 31) as f32 + random.between(-0.025, 0.025) as f32;
        let y = [0.27, 0.67][k % 2] - random.between(0.015, 0.03) as f32;
        receiver(Vec3::new(x, y, 0.01), Vec3::Z)
    };
    let receivers: Vec<_> = (0..620).map(on_picket).collect();
    let bounds = ReceiverBounds { min: Vec3::new(-9.0, 0.0, -9.0), max: Vec3::new(9.0, 1.0, 9.0) };
    let options = MapOptions { receivers: Some(bounds), ..options(2048) };
    let map = ShadowMap::fitted(&fence.positions, &fence.triangles, light, &options).expect("a good mesh");
    // More texels a side than a square image may have, but not more in all.
    assert!(map.resolution() > 2048 && map.bytes() < 2048 * 2048 * 32, "{} {}", map.resolution(), map.bytes());
    let at = |resolution| Errors::of(&fence, &receivers, light, &MapOptions { resolution, ..options });
    at(map.resolution()).below("fence, self", 3.0, 0.6, 0.2);
    // A coarser map is not enough.
    assert!(at(1056).means()[0] > 6.0);
}

#[test]
fn sphere_with_smooth_normals() {
    let sphere = Mesh::default().sphere(Vec3::new(0.0, 0.7, 0.0), 0.5, 24);
    let receivers = floor(Vec3::new(-0.3, 0.0, -0.2), 1.0, 20);
    Errors::of(&sphere, &receivers, LIGHT, &options(512)).below("sphere, floor", 0.5, 0.1, 0.02);
    // Lit surfaces stay lit, with the facets' normals and with the sphere's own.
    for smooth in [false, true] {
        let mut receivers = on(&sphere, LIGHT, 600);
        if smooth {
            for at in &mut receivers {
                at.normal = (at.position - Vec3::new(0.0, 0.7, 0.0)).normalize();
            }
            receivers.retain(|at| at.normal.dot((LIGHT.center - at.position).normalize()) > 0.3);
        }
        for resolution in [64, 256, 1024] {
            let [_, _, lit] = Errors::of(&sphere, &receivers, LIGHT, &options(resolution)).means();
            println!("sphere, self, smooth {smooth}, {resolution}: lit darkened by {lit:.3} %");
            assert!(lit <= 0.1, "{lit}");
        }
    }
}

#[test]
fn error_falls_with_resolution() {
    let sphere = Mesh::default().sphere(Vec3::new(0.0, 0.7, 0.0), 0.5, 24);
    let receivers = floor(Vec3::new(-0.3, 0.0, -0.2), 1.0, 18);
    let errors: Vec<f64> =
        [32, 64, 128, 512].map(|r| Errors::of(&sphere, &receivers, LIGHT, &options(r)).means()[0]).to_vec();
    println!("{errors:?}");
    assert!(errors.windows(2).all(|e| e[1] < e[0]), "{errors:?}");
}

/// Narrow lobes have masks of their own over a part of the light; the map is searched again for these.
#[test]
fn glossy_lobes_see_what_they_look_at() {
    let mesh = Mesh::default().cuboid(Vec3::new(-0.5, 0.0, -0.5), Vec3::new(0.5, 1.0, 0.5)).sphere(
        Vec3::new(0.3, 1.4, 0.2),
        0.35,
        16,
    );
    let strategy = MaskVisibility::new(ShadowMapBlockers::new(vec![mesh.map(LIGHT, &options(1024))]));
    let mut scratch = strategy.scratch();
    let mut random = Random::new(5);
    let outside = |at: &Receiver| at.position.x.abs() > 0.5 || at.position.z.abs() > 0.5;
    // The narrowest lobe is three texels wide.
    for (exponent, most) in [(20.0_f32, 0.3), (200.0, 0.3), (2000.0, 0.7), (20_000.0, 1.5)] {
        let (mut errors, mut count) = (0.0, 0);
        for at in floor(Vec3::new(-0.6, 0.0, -0.4), 1.0, 22).into_iter().filter(outside) {
            let cone = Cone::of_sphere(at.position, LIGHT);
            let off = random.between(0.0, 0.8) * f64::from(cone.tan());
            let axis = random.axis_at(cone.axis.as_dvec3(), off).as_vec3().normalize();
            let lobe = Lobe { exponent, flux: Vec3::ONE, axis, has_cosine: false };
            let truth = mesh.seen_by(&at, LIGHT, 64, |v| {
                // Converts the square's area to solid angle.
                axis.as_dvec3().dot(v).powf(f64::from(exponent)) * cone.axis.as_dvec3().dot(v).powi(3)
            });
            let mut visit = LightVisibility::alone(&strategy, LightId(0), Accuracy::new(0.003), &mut scratch);
            let LightCoverage::Partial(seen) = visit.coverage(&at, &cone, None) else { continue };
            if !(0.01..0.99).contains(&truth) {
                continue;
            }
            let unshadowed = cap_integral(&at, lobe, &cone);
            errors += (f64::from(visit.fraction(&seen, lobe, unshadowed).x) - truth).abs();
            count += 1;
        }
        let mean = 100.0 * errors / f64::from(count);
        println!("exponent {exponent}: {mean:.2} % of {count}");
        assert!(count > 20 && mean < most, "{exponent}: {mean}");
    }
}

/// Casters on all sides of the light: every edge of the cube's faces is in some shaft.
#[test]
fn seams_of_the_cube_are_invisible() {
    let light = Sphere { center: Vec3::new(0.1, -0.05, 0.07), radius: 0.4 };
    // A large plate in front of each of the twelve seams: half of every shadow comes from one face, half from another.
    let mut random = Random::new(8);
    for k in 0..12_usize {
        let (axis, signs) = (k / 4, [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)][k % 4]);
        let mut seam = Vec3::ZERO;
        seam[(axis + 1) % 3] = signs.0;
        seam[(axis + 2) % 3] = signs.1;
        let seam = seam.normalize();
        let (u, v) = seam.any_orthonormal_pair();
        let middle = light.center + seam * 2.0;
        let plate = Mesh::default()
            .quad([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| middle + u * x + v * y));
        // A caster on the other side makes the map a cube.
        let all = plate.quad(
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                .map(|(x, y)| light.center - seam * 2.0 + u * x + v * y),
        );
        let map = all.map(light, &options(256));
        assert!(map.faces() > 1);
        let receivers: Vec<_> = (0..160)
            .map(|_| {
                let (x, y) = (random.between(-3.2, 3.2) as f32, random.between(-3.2, 3.2) as f32);
                receiver(middle + seam * 2.0 + u * x + v * y, -seam)
            })
            .collect();
        Errors::of(&all, &receivers, light, &options(512)).below("seam", 0.5, 0.08, 0.02);
    }
}

#[test]
fn light_inside_a_closed_box_is_hidden() {
    let light = Sphere { center: Vec3::new(0.1, 0.2, -0.1), radius: 0.3 };
    let mesh = Mesh::default().cuboid(Vec3::splat(-1.0), Vec3::ONE);
    let mut random = Random::new(4);
    let receivers: Vec<_> = (0..400)
        .map(|_| {
            let away = random.axis().as_vec3();
            receiver(away * (random.between(1.8, 9.0) as f32), -away)
        })
        .collect();
    for resolution in [16, 64, 256] {
        let errors = Errors::of(&mesh, &receivers, light, &options(resolution));
        assert_eq!(errors.umbra.len(), receivers.len());
        // One sample of 65 536 of one receiver may leak at a seam of the cube.
        assert!(errors.umbra.iter().all(|v| *v < 1e-4), "leaks {:?}", errors.means());
    }
}

#[test]
fn light_between_two_objects() {
    let light = Sphere { center: Vec3::ZERO, radius: 0.3 };
    let mesh = Mesh::default()
        .cuboid(Vec3::new(-2.0, -0.5, -0.5), Vec3::new(-1.0, 0.6, 0.5))
        .cuboid(Vec3::new(1.0, -0.5, -0.4), Vec3::new(1.5, 0.5, 0.7));
    let mut receivers = Vec::new();
    for side in [-1.0, 1.0] {
        for k in 0..400 {
            let at = |k: i32| (k as f32 + 0.5) / 20.0 * 8.0 - 4.0;
            receivers.push(receiver(Vec3::new(4.0 * side, at(k % 20), at(k / 20)), Vec3::X * -side));
        }
    }
    Errors::of(&mesh, &receivers, light, &options(512)).below("light between", 0.5, 0.05, 0.02);
}

#[test]
fn light_that_touches_a_sphere() {
    // Next to the light a texel of the sphere spans very different depths.
    let light = Sphere { center: Vec3::new(0.45, 1.25, 0.0), radius: 0.45 };
    let mesh = Mesh::default().sphere(Vec3::Y * 0.6, 0.4, 24);
    let errors = Errors::of(&mesh, &floor(Vec3::new(-0.8, 0.0, 0.0), 1.6, 16), light, &options(256));
    errors.below("light that touches a sphere", 0.7, 0.05, 0.05);
}
