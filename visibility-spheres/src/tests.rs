//! Selection and culling against rays in f64.

use crate::SphereBlockers;
use crate::splat_tests::chord;
use core::f64::consts::PI;
use glam::Vec3;
use lobe_core::oracle::Random;
use lobe_core::{Cone, Receiver, Sphere};
use shading::{Accuracy, Coverage, LightId, Shaft, VisibilityQuery};
use visibility_mask::{Blockers, Mask, UnitSquare};

fn receiver(position: Vec3, normal: Vec3, object: u32) -> Receiver {
    Receiver::on_surface(position, normal, normal).on_object(object)
}

/// Fraction of the light's disc that rays from the receiver see, by the definition; sampled.
fn brute_share(at: &Receiver, light: Sphere, spheres: &[(Sphere, f64)], n: usize) -> (usize, usize) {
    let position = at.position.as_dvec3();
    let to_light = light.center.as_dvec3() - position;
    let axis = to_light.normalize();
    let (right, up) = axis.any_orthonormal_pair();
    let sin = (f64::from(light.radius) / to_light.length()).min(0.996);
    let disc = sin / (1.0 - sin * sin).sqrt();
    let (mut lit, mut all) = (0, 0);
    for j in 0..n {
        for i in 0..n {
            let c = |k: usize| disc * (2.0 * (k as f64 + 0.5) / n as f64 - 1.0);
            if c(i).hypot(c(j)) >= disc {
                continue;
            }
            let v = (right * c(i) + up * c(j) + axis).normalize();
            if v.dot(at.normal.as_dvec3()) <= 0.0 {
                continue;
            }
            let Some(shine) = chord(v, to_light, f64::from(light.radius)) else { continue };
            all += 1;
            let blocked = spheres.iter().any(|(s, tau)| {
                chord(v, s.center.as_dvec3() - position, f64::from(s.radius))
                    .is_some_and(|hit| hit.1 > 0.0 && hit.1 > *tau && hit.0 < shine.0)
            });
            lit += usize::from(!blocked);
        }
    }
    (lit, all)
}

#[test]
fn shares_follow_the_order_of_blocker_and_light() {
    // Area of the mask against rays: in front, behind, half-way through, containing, inside the light.
    let mut random = Random::new(5);
    let names = [
        "in front",
        "behind",
        "half-way through",
        "containing the light",
        "inside the light",
        "containing the receiver",
        "own",
    ];
    let mut worst = [0.0_f64; 7];
    for case in 0..350 {
        let kind = case % 7;
        let axis = random.axis();
        let position = random.axis().as_vec3() * 3.0;
        let at = receiver(position, random.axis_at(axis, 0.4).as_vec3().normalize(), u32::from(kind == 6) * 7);
        let theta: f64 = random.log_uniform(0.01, 0.5);
        let distance = 10.0;
        let light = Sphere { center: position + (axis * distance).as_vec3(), radius: (distance * theta.sin()) as f32 };
        let big = f64::from(light.radius);
        let (along, r) = match kind {
            0 => (random.between(2.0, 7.0), random.between(0.3, 2.0)),
            1 => (distance + 2.5 * big + 1.0, random.between(0.3, 2.0)),
            2 => (distance + big * random.between(-0.8, 0.8), random.between(0.3, 1.2)),
            3 => (distance, 1.5),
            4 => (distance + 0.2 * big, 0.3),
            5 => (0.1, 3.0),
            _ => (1.0, 1.3),
        };
        let r = if kind == 5 || kind == 6 { 0.3 * r } else { r * big * if kind == 0 { along / distance } else { 1.0 } };
        let aside = if kind == 3 || kind == 5 { 0.0 } else { r * random.uniform() };
        let sideways = random.axis_at(axis, 0.5 * PI);
        let along = if kind == 6 { 0.3 * along } else { along };
        let sphere = Sphere { center: position + (axis * along + sideways * aside).as_vec3(), radius: r as f32 };
        let tau = if kind == 6 { 0.25 } else { 0.0 };
        let blockers = SphereBlockers::new(&[sphere], &[7], &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, tau as f32]);
        let cone = Cone::of_sphere(at.position, light);
        let query = VisibilityQuery::new(&at, LightId(0), &cone, Accuracy::new(0.003));
        let mut scratch = blockers.scratch();
        let share = match blockers.select(&query, &mut scratch) {
            Coverage::Lit => 1.0,
            Coverage::Dark => 0.0,
            Coverage::Partial => {
                let mut mask = Mask::default();
                mask.reset(&UnitSquare::facing(&cone, blockers.across(&query, &scratch)), 6, at.normal);
                blockers.splat(&query, &mut scratch, &mut mask);
                let (all, lit) = mask.areas();
                f64::from(lit / all)
            }
        };
        let (lit, all) = brute_share(&at, light, &[(sphere, tau)], 200);
        let error = (share - lit as f64 / all as f64).abs();
        worst[kind] = worst[kind].max(error);
    }
    for (name, worst) in names.iter().zip(worst) {
        println!("{name}: share wrong by up to {:.3} %", 100.0 * worst);
    }
    assert!(worst.iter().all(|w| *w < 0.02), "{worst:?}");
}

fn random_scene(random: &mut Random, scale: f64) -> (Sphere, Vec<Sphere>) {
    let light = Sphere {
        center: (random.axis() * 6.0 * scale).as_vec3(),
        radius: (scale * random.log_uniform(0.01, 3.0)) as f32,
    };
    let count = 1 + (random.bits() % 30) as usize;
    let spheres = (0..count)
        .map(|_| Sphere {
            center: (random.axis() * random.between(0.0, 8.0) * scale).as_vec3(),
            radius: (scale * random.log_uniform(0.02, 2.0)) as f32,
        })
        .collect();
    (light, spheres)
}

#[test]
fn selection_never_contradicts_the_rays() {
    let mut random = Random::new(6);
    let mut counts = [0; 3];
    for case in 0..3000 {
        let (light, spheres) = random_scene(&mut random, 1.0);
        let normal = random.axis().as_vec3().normalize();
        let at =
            receiver((random.axis() * random.between(0.0, 4.0)).as_vec3(), normal, if case % 2 == 0 { 0 } else { 1 });
        let cone = Cone::of_sphere(at.position, light);
        if cone.one_minus_cos > 1.0 {
            continue;
        }
        let objects: Vec<_> = (0..spheres.len() as u32).map(|i| i % 3).collect();
        let taus = [0.5, 0.0, 0.0];
        let blockers = SphereBlockers::new(&spheres, &objects, &taus);
        let query = VisibilityQuery::new(&at, LightId(0), &cone, Accuracy::new(0.003));
        let mut scratch = blockers.scratch();
        let selected = blockers.select(&query, &mut scratch);
        counts[selected as usize] += 1;
        let with_tau: Vec<_> = spheres
            .iter()
            .zip(&objects)
            .map(|(s, o)| (*s, if *o == at.object { f64::from(taus[*o as usize]) } else { 0.0 }))
            .collect();
        let (lit, all) = brute_share(&at, light, &with_tau, 48);
        match selected {
            Coverage::Lit => assert_eq!(lit, all, "lit, but something is blocked: case {case}"),
            Coverage::Dark => assert_eq!(lit, 0, "dark, but something is lit: case {case}"),
            Coverage::Partial => {}
        }
    }
    println!("lit, dark, partial: {counts:?}");
}

#[test]
fn culling_never_changes_a_result() {
    let mut random = Random::new(7);
    let (mut culled, mut total) = (0, 0);
    for case in 0..2000 {
        let scale = [1.0, 1e-4, 1e6][case % 3];
        let (mut light, spheres) = random_scene(&mut random, scale);
        let sphere = Sphere {
            center: (random.axis() * random.between(0.0, 4.0) * scale).as_vec3(),
            radius: (scale * random.log_uniform(1e-3, 2.0)) as f32,
        };
        match case % 5 {
            0 => light.radius = (20.0 * scale) as f32,
            // Receivers' sphere and light touch.
            1 => light.radius = (light.center - sphere.center).length() - sphere.radius,
            2 => light.center = sphere.center + (light.center - sphere.center) * 1e4,
            _ => {}
        }
        let objects = vec![0; spheres.len()];
        let blockers = SphereBlockers::new(&spheres, &objects, &[(0.3 * scale) as f32]);
        let (mut all, mut some) = (blockers.scratch(), blockers.scratch());
        blockers.enter(&Shaft::new(sphere, light, LightId(0)), &mut some);
        for _ in 0..10 {
            let position =
                sphere.center + (random.axis() * f64::from(sphere.radius) * random.uniform().cbrt() * 0.9999).as_vec3();
            let at = receiver(position, random.axis().as_vec3().normalize(), (case % 2) as u32);
            let cone = Cone::of_sphere(position, light);
            if cone.one_minus_cos > 1.0 {
                continue;
            }
            let query = VisibilityQuery::new(&at, LightId(0), &cone, Accuracy::new(0.003));
            let (a, b) = (blockers.select(&query, &mut all), blockers.select(&query, &mut some));
            assert_eq!(a, b, "case {case}");
            if a == Coverage::Partial {
                let (x, y) = (blockers.across(&query, &all), blockers.across(&query, &some));
                assert_eq!(x, y, "case {case}");
                let fill = |scratch: &mut crate::SphereScratch| {
                    let mut mask = Mask::default();
                    mask.reset(&UnitSquare::facing(&cone, x), 5, at.normal);
                    blockers.splat(&query, scratch, &mut mask);
                    mask.areas()
                };
                assert_eq!(fill(&mut all), fill(&mut some), "case {case}");
            }
            let mut none = blockers.scratch();
            let everywhere = Sphere { center: position, radius: f32::MAX };
            blockers.enter(&Shaft::new(everywhere, light, LightId(0)), &mut none);
            assert_eq!(blockers.select(&query, &mut none), a);
        }
        total += spheres.len();
        culled += spheres.len() - some.candidates().len();
    }
    println!("{culled} of {total} culled");
    assert!(culled * 4 > total);
}

#[test]
fn shafts_at_infinity_keep_what_they_meet() {
    let sphere = Sphere { center: Vec3::new(0.0, 0.0, 5.0), radius: 1.0 };
    let blockers = SphereBlockers::new(&[sphere], &[0], &[]);
    for distance in [1e3_f32, 1e8, 1e18, 1e20, 1e30] {
        let light = Sphere { center: Vec3::Z * distance, radius: 0.01 * distance };
        let mut scratch = blockers.scratch();
        blockers.enter(&Shaft::new(Sphere { center: Vec3::ZERO, radius: 1.0 }, light, LightId(0)), &mut scratch);
        assert_eq!(scratch.candidates().len(), 1, "distance {distance}");
    }
}

#[test]
fn point_lights_are_hidden_by_what_their_direction_meets() {
    // A cone wider than a hemisphere (a receiver inside its own object's sphere) does not reach backwards.
    let blockers = SphereBlockers::new(&[Sphere { center: Vec3::Z * 0.5, radius: 1.0 }], &[0], &[0.8]);
    let strategy = visibility_mask::MaskVisibility::new(blockers);
    let at = receiver(Vec3::ZERO, Vec3::NEG_Z, 0);
    for (axis, hidden) in [(Vec3::Z, true), (Vec3::NEG_Z, false)] {
        for one_minus_cos in [0.0, 1e-12, 1e-6] {
            let cone = Cone { axis, one_minus_cos, distance: 10.0 };
            let query = VisibilityQuery::new(&at, LightId(0), &cone, Accuracy::new(0.003));
            use shading::Visibility;
            let mut scratch = strategy.scratch();
            let coverage = strategy.coverage(&query, &mut scratch);
            if one_minus_cos == 0.0 {
                assert_eq!(coverage, if hidden { Coverage::Dark } else { Coverage::Lit }, "{axis}");
            } else {
                assert_ne!(coverage, if hidden { Coverage::Lit } else { Coverage::Dark }, "{axis} {one_minus_cos}");
            }
        }
    }
}

/// A facet hides what is below it from receivers whose object has a sphere, wherever that is, but for what the horizon hides.
#[test]
fn facets_cut_the_light_of_their_own_object() {
    let far = Sphere { center: Vec3::NEG_Z * 50.0, radius: 1.0 };
    let nothing = Sphere { radius: 0.0, ..far };
    let blockers = SphereBlockers::new(&[far, far, nothing], &[4, 7, 9], &[]);
    let cone = Cone { axis: Vec3::Z, one_minus_cos: 0.02, distance: 10.0 };
    let up = |elevation: f32| Vec3::new(elevation.cos(), 0.0, elevation.sin());
    let theta = cone.sin_sq().sqrt().asin();
    let select = |face: Vec3, normal: Vec3, object: u32| {
        let at = Receiver { face, ..receiver(Vec3::ZERO, normal, object) };
        let query = VisibilityQuery::new(&at, LightId(0), &cone, Accuracy::new(0.003));
        let mut scratch = blockers.scratch();
        let coverage = blockers.select(&query, &mut scratch);
        let mut mask = Mask::default();
        mask.reset(&UnitSquare::facing(&cone, blockers.across(&query, &scratch)), 5, normal);
        if coverage == Coverage::Partial {
            blockers.splat(&query, &mut scratch, &mut mask);
        }
        let (whole, lit) = mask.areas();
        (coverage, lit / whole)
    };
    for object in [4, 7] {
        assert_eq!(select(up(0.5), Vec3::Z, object).0, Coverage::Lit);
        assert_eq!(select(up(-0.5), Vec3::Z, object).0, Coverage::Dark);
        let (coverage, share) = select(up(-0.5 * theta), Vec3::Z, object);
        // The part of a disc on the far side of a chord at half its radius.
        let want = 1.0 / 3.0 - 0.75_f32.sqrt() / (2.0 * core::f32::consts::PI);
        assert!(coverage == Coverage::Partial && (share - want).abs() < 0.005, "{coverage:?} {share} {want}");
    }
    for object in [0, 5, 9, u32::MAX] {
        assert_eq!(select(up(-0.5), Vec3::Z, object).0, Coverage::Lit, "object {object}");
    }
    assert_eq!(select(up(0.0), up(0.0), 4).0, Coverage::Lit, "the horizon's own");
}
