//! Properties that hold for all scenes: limits, monotony, continuity, invariance, dispatch, bad input.

mod common;

use common::{Mesh, receiver, share};
use glam::{Quat, Vec3};
use lobe_core::oracle::Random;
use lobe_core::{Cone, Lobe, Receiver, Sphere, cap_integral};
use shading::{Accuracy, Coverage, DynVisibility, LightId, LightVisibility, Shaft, Visibility, VisibilityQuery};
use visibility_mask::{Blockers, MaskVisibility};
use visibility_shadowmap::{MapError, MapFineness, MapOptions, ReceiverBounds, ShadowMap, ShadowMapBlockers};

const LIGHT: Sphere = Sphere { center: Vec3::new(0.0, 5.0, 0.0), radius: 0.6 };

fn options(resolution: u32) -> MapOptions {
    MapOptions { resolution, ..MapOptions::default() }
}

fn blockers(mesh: &Mesh, light: Sphere, resolution: u32) -> ShadowMapBlockers {
    ShadowMapBlockers::new(vec![mesh.map(light, &options(resolution))])
}

fn value(mesh: &Mesh, light: Sphere, resolution: u32, at: &Receiver) -> f64 {
    let blockers = blockers(mesh, light, resolution);
    share(&blockers, &mut blockers.scratch(), at, light)
}

/// A square in a plane of constant height.
fn sheet(mesh: Mesh, x: [f32; 2], y: f32, z: [f32; 2]) -> Mesh {
    mesh.quad([(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, k)| Vec3::new(x[i], y, z[k])))
}

fn floor_points(count: usize, half: f64, seed: u64) -> Vec<Receiver> {
    let mut random = Random::new(seed);
    let mut coordinate = move || random.between(-half, half) as f32;
    (0..count).map(|_| receiver(Vec3::new(coordinate(), 0.0, coordinate()), Vec3::Y)).collect()
}

/// Small triangles between floor and light.
fn soup(random: &mut Random, count: usize) -> Mesh {
    let mut mesh = Mesh::default();
    for _ in 0..count {
        let mut at = |size: f64| (random.axis() * size).as_vec3();
        let center = Vec3::new(0.0, 1.5, 0.0) + at(0.8);
        let first = mesh.positions.len() as u32;
        mesh.positions.extend([center + at(0.3), center + at(0.3), center + at(0.3)]);
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    mesh
}

#[test]
fn nothing_blocks_at_no_cost() {
    let degenerate = Mesh {
        positions: vec![Vec3::new(0.0, 1.0, 0.0), Vec3::new(1.0, 1.0, 0.0), Vec3::new(2.0, 1.0, 0.0)],
        triangles: vec![[0, 0, 1], [0, 1, 2], [1, 1, 1]],
    };
    // A lamp's bulb, inside the light.
    let inside = Mesh::default().sphere(LIGHT.center, 0.3, 6);
    for mesh in [Mesh::default(), degenerate, inside] {
        let blockers = blockers(&mesh, LIGHT, 64);
        let mut scratch = blockers.scratch();
        for at in floor_points(50, 3.0, 1) {
            blockers.enter(&Shaft::new(Sphere { center: at.position, radius: 0.1 }, LIGHT, LightId(0)), &mut scratch);
            let cone = Cone::of_sphere(at.position, LIGHT);
            let query = VisibilityQuery::new(&at, LightId(0), &cone, Accuracy::new(0.003));
            assert_eq!(blockers.select(&query, &mut scratch), Coverage::Lit);
        }
        assert_eq!(scratch.counts(), (0, 0));
        assert_eq!(blockers.maps()[0].faces(), 0);
        assert_eq!(
            blockers.maps()[0].advice(&ReceiverBounds { min: Vec3::ZERO, max: Vec3::ONE }).fineness,
            MapFineness::Fine
        );
    }
}

#[test]
fn behind_receiver_or_light_nothing_blocks() {
    let all_around = [
        // Below the floor, above the light, beside both.
        sheet(Mesh::default(), [-3.0, 3.0], -0.5, [-3.0, 3.0]),
        sheet(Mesh::default(), [-3.0, 3.0], 5.7, [-3.0, 3.0]),
        Mesh::default().cuboid(Vec3::new(3.5, -1.0, -3.0), Vec3::new(4.0, 7.0, 3.0)),
    ];
    let mut together = Mesh::default();
    for mesh in &all_around {
        let first = together.positions.len() as u32;
        together.positions.extend(&mesh.positions);
        together.triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + first)));
    }
    for mesh in all_around.iter().chain([&together]) {
        let blockers = blockers(mesh, LIGHT, 256);
        let mut scratch = blockers.scratch();
        for at in floor_points(100, 2.5, 2) {
            assert_eq!(share(&blockers, &mut scratch, &at, LIGHT), 1.0, "{at:?}");
        }
    }
    // The floor below the receiver, at any angle of the light.
    for height in [0.3, 1.0, 5.0] {
        let light = Sphere { center: Vec3::new(4.0, height, 0.0), radius: 0.2 };
        let floor = sheet(Mesh::default(), [-9.0, 9.0], 0.0, [-9.0, 9.0]);
        for resolution in [16, 128, 1024] {
            let blockers = blockers(&floor, light, resolution);
            let mut scratch = blockers.scratch();
            for at in floor_points(100, 3.0, 3) {
                assert_eq!(share(&blockers, &mut scratch, &at, light), 1.0, "{at:?} {height}");
            }
        }
    }
}

#[test]
fn full_cover_is_exactly_dark() {
    let above = |y| sheet(Mesh::default(), [-4.0, 4.0], y, [-4.0, 4.0]);
    for (y, resolution) in [(0.5, 16), (0.5, 256), (2.0, 64), (2.0, 1024), (4.0, 128)] {
        let blockers = blockers(&above(y), LIGHT, resolution);
        let mut scratch = blockers.scratch();
        for at in floor_points(100, 2.0, 4) {
            assert_eq!(share(&blockers, &mut scratch, &at, LIGHT), 0.0, "{at:?} {y} {resolution}");
        }
    }
    // A tilted, a curved and a tessellated surface: no cracks.
    let sphere = Mesh::default().sphere(Vec3::new(0.0, 2.0, 0.0), 1.5, 40);
    for resolution in [32, 128, 512, 2048] {
        let blockers = blockers(&sphere, LIGHT, resolution);
        let mut scratch = blockers.scratch();
        for at in floor_points(100, 0.8, 5) {
            assert_eq!(share(&blockers, &mut scratch, &at, LIGHT), 0.0, "{at:?} {resolution}");
        }
    }
}

/// Area of the unit disc left of `x`.
fn segment(x: f64) -> f64 {
    let x = x.clamp(-1.0, 1.0);
    (x * (1.0 - x * x).sqrt() + x.asin()) / std::f64::consts::PI + 0.5
}

#[test]
fn half_planes_against_the_closed_form() {
    let (mut sum, mut worst) = (0.0, 0.0_f64);
    for k in 0..40 {
        // An edge at height 2 across the light of tangent 0.6/√(25 − 0.36) ≈ 0.1209 seen from the origin.
        let tangent = 0.6 / (25.0_f64 - 0.36).sqrt();
        let offset = -0.9 + 1.8 * f64::from(k) / 39.0;
        let turn = Quat::from_rotation_y(0.37 * k as f32);
        let mut mesh = sheet(Mesh::default(), [-1.0, (offset * tangent * 2.0) as f32], 2.0, [-1.0, 1.0]);
        mesh.positions.iter_mut().for_each(|p| *p = turn * *p);
        let seen = value(&mesh, LIGHT, 512, &receiver(Vec3::ZERO, Vec3::Y));
        let error = (seen - (1.0 - segment(offset))).abs();
        sum += error;
        worst = worst.max(error);
    }
    println!("half-planes: mean {:.2e}, max {worst:.2e}", sum / 40.0);
    assert!(sum / 40.0 < 0.003 && worst < 0.01);
}

#[test]
fn discs_against_the_closed_form() {
    let (mut sum, mut worst) = (0.0, 0.0_f64);
    let mut random = Random::new(6);
    let tangent = 0.6 / (25.0_f64 - 0.36).sqrt();
    for _ in 0..40 {
        // A disc of relative radius ρ at distance δ of the light's: the area of the lens.
        let (rho, delta) = (random.between(0.3, 1.2), random.between(0.0, 1.5));
        let turn = random.between(0.0, 6.0);
        let scale = tangent * 2.0;
        let corner = |k: u32| {
            let (sin, cos) = (f64::from(k) / 90.0 * std::f64::consts::TAU).sin_cos();
            let (x, z) = (delta * turn.cos() + rho * cos, delta * turn.sin() + rho * sin);
            Vec3::new((x * scale) as f32, 2.0, (z * scale) as f32)
        };
        let mut mesh = Mesh { positions: (0..90).map(corner).collect(), triangles: Vec::new() };
        mesh.triangles = (2..90).map(|k| [0, k - 1, k]).collect();
        let lens = if delta >= 1.0 + rho {
            0.0
        } else if delta <= (1.0 - rho).abs() {
            rho.min(1.0).powi(2)
        } else {
            let a = ((delta * delta + 1.0 - rho * rho) / (2.0 * delta)).acos();
            let b = ((delta * delta + rho * rho - 1.0) / (2.0 * delta * rho)).acos();
            (a - 0.5 * (2.0 * a).sin() + rho * rho * (b - 0.5 * (2.0 * b).sin())) / std::f64::consts::PI
        };
        let seen = value(&mesh, LIGHT, 512, &receiver(Vec3::ZERO, Vec3::Y));
        let error = (seen - (1.0 - lens)).abs();
        sum += error;
        worst = worst.max(error);
    }
    println!("discs: mean {:.2e}, max {worst:.2e}", sum / 40.0);
    assert!(sum / 40.0 < 0.002 && worst < 0.006);
}

#[test]
fn in_range_and_one_more_blocker_never_brightens() {
    let mut random = Random::new(7);
    let mut worst = 0.0_f64;
    for case in 0..40 {
        let mut mesh = soup(&mut random, 1 + case % 3);
        // Keeps the window, so that texels stay the same.
        mesh = sheet(sheet(mesh, [-3.0, -2.9], 2.5, [-3.0, -2.9]), [2.9, 3.0], 2.5, [2.9, 3.0]);
        let mut more = mesh.clone();
        let first = more.positions.len() as u32;
        let extra = soup(&mut random, 1);
        more.positions.extend(&extra.positions);
        more.triangles.push([first, first + 1, first + 2]);
        let (a, b) = (blockers(&mesh, LIGHT, 256), blockers(&more, LIGHT, 256));
        let (mut sa, mut sb) = (a.scratch(), b.scratch());
        for at in floor_points(40, 1.0, case as u64) {
            let (before, after) = (share(&a, &mut sa, &at, LIGHT), share(&b, &mut sb, &at, LIGHT));
            assert!((0.0..=1.0).contains(&before) && (0.0..=1.0).contains(&after));
            worst = worst.max(after - before);
        }
    }
    println!("one more triangle brightens by up to {:.3} %", 100.0 * worst);
    assert!(worst < 0.01, "{worst}");
}

#[test]
fn small_moves_make_small_changes() {
    let mesh = Mesh::default()
        .sphere(Vec3::new(0.2, 1.4, 0.1), 0.4, 20)
        .cuboid(Vec3::new(-0.9, 0.9, -0.4), Vec3::new(-0.4, 1.3, 0.3));
    let steps = 120;
    // Moves the receiver, the light or the blocker in 120 steps, by 0.3 units or more.
    for kind in 0..3 {
        let values: Vec<f64> = (0..steps)
            .map(|k| {
                let t = 0.6 * (k as f32 / steps as f32 - 0.5);
                let (mut mesh, mut light, mut at) = (mesh.clone(), LIGHT, receiver(Vec3::new(-0.1, 0.0, 0.3), Vec3::Y));
                match kind {
                    0 => at.position.x += t,
                    1 => light.center.x += 2.0 * t,
                    _ => mesh.positions.iter_mut().for_each(|p| p.z += 0.5 * t),
                }
                value(&mesh, light, 256, &at)
            })
            .collect();
        let steps: Vec<f64> = values.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
        // The part of a step that exceeds its neighbours.
        let pop = |w: &[f64]| w[2] - w[0].max(w[1]).max(w[3]).max(w[4]);
        let step = steps.windows(5).map(pop).fold(0.0, f64::max);
        let range = values.iter().fold(0.0_f64, |a, v| a.max(*v)) - values.iter().fold(1.0_f64, |a, v| a.min(*v));
        println!("kind {kind}: largest pop {:.2} %, range {:.0} %", 100.0 * step, 100.0 * range);
        assert!(range > 0.2 && step < 0.005, "{kind}: {step} of {range}");
    }
}

#[test]
fn turning_scaling_and_moving_change_nothing() {
    let mesh = Mesh::default()
        .sphere(Vec3::new(0.2, 1.4, 0.1), 0.4, 20)
        .cuboid(Vec3::new(-0.9, 0.9, -0.4), Vec3::new(-0.4, 1.3, 0.3));
    let receivers = floor_points(60, 1.2, 9);
    let plain = blockers(&mesh, LIGHT, 512);
    let mut random = Random::new(10);
    for (scale, shift, mean, most) in
        [(1.0, 0.0, 2e-3, 0.03), (1e-4, 0.0, 2e-3, 0.03), (1e6, 0.0, 2e-3, 0.03), (1.0, 1e3, 3e-3, 0.05)]
    {
        let (turn, shift) = (Quat::from_axis_angle(random.axis().as_vec3(), 1.0), random.axis().as_vec3() * shift);
        let map = |p: Vec3| turn * p * scale + shift;
        let mut moved = mesh.clone();
        moved.positions.iter_mut().for_each(|p| *p = map(*p));
        let light = Sphere { center: map(LIGHT.center), radius: LIGHT.radius * scale };
        let there = blockers(&moved, light, 512);
        let (mut sum, mut worst) = (0.0, 0.0_f64);
        for at in &receivers {
            let a = share(&plain, &mut plain.scratch(), at, LIGHT);
            let b = share(&there, &mut there.scratch(), &receiver(map(at.position), turn * at.normal), light);
            sum += (a - b).abs();
            worst = worst.max((a - b).abs());
        }
        let sum = sum / receivers.len() as f64;
        println!("scale {scale:e}, shift {shift:?}: mean {sum:.1e}, max {worst:.1e}");
        assert!(sum < mean && worst < most);
    }
}

#[test]
fn a_far_light_is_as_good_as_a_near_one() {
    // Nearly the same cones from 5, 1e3 and 1e6 away: parallel shadows.
    let mesh = Mesh::default().sphere(Vec3::new(0.2, 1.4, 0.1), 0.4, 20);
    let receivers = floor_points(80, 0.9, 11);
    for distance in [1e3_f32, 1e6] {
        let light = Sphere { center: Vec3::Y * distance, radius: 0.12 * distance };
        let b = blockers(&mesh, light, 512);
        let (mut sum, mut count) = (0.0, 0);
        for at in &receivers {
            let truth = mesh.seen(at, light, 40);
            let seen = share(&b, &mut b.scratch(), at, light);
            if truth > 0.01 && truth < 0.99 {
                sum += (truth - seen).abs();
                count += 1;
            }
        }
        println!("from {distance:e}: {:.2} % of {count}", 100.0 * sum / f64::from(count));
        assert!(count > 10 && sum / f64::from(count) < 0.006);
    }
}

#[test]
fn order_and_threads_change_no_bit() {
    let mesh = Mesh::fence();
    let light = Sphere { center: Vec3::new(2.0, 4.0, 2.0), radius: 0.4 };
    let mut shuffled = mesh.clone();
    let mut random = Random::new(12);
    for k in (1..shuffled.triangles.len()).rev() {
        shuffled.triangles.swap(k, random.bits() as usize % (k + 1));
    }
    let run = |mesh: &Mesh, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let blockers = pool.install(|| blockers(mesh, light, 300));
        let mut scratch = blockers.scratch();
        floor_points(60, 1.5, 13)
            .iter()
            .map(|at| share(&blockers, &mut scratch, at, light).to_bits())
            .collect::<Vec<_>>()
    };
    let one = run(&mesh, 1);
    assert_eq!(one, run(&mesh, 3));
    assert_eq!(one, run(&shuffled, 2));
}

#[test]
fn groups_scratch_and_dispatch_change_no_bit() {
    let mesh = Mesh::fence();
    let lights = [
        Sphere { center: Vec3::new(2.0, 4.0, 2.0), radius: 0.4 },
        Sphere { center: Vec3::new(-3.0, 3.0, -1.0), radius: 0.7 },
    ];
    let maps: Vec<_> = lights.iter().map(|l| mesh.map(*l, &options(300))).collect();
    let strategy = MaskVisibility::new(ShadowMapBlockers::new(maps.clone()));
    let boxed: Box<dyn DynVisibility> = Box::new(MaskVisibility::new(ShadowMapBlockers::new(maps)));
    let (mut old, mut old_dyn) = (strategy.scratch(), boxed.scratch());
    let mut partial = 0;
    for (k, at) in floor_points(150, 1.2, 14).iter().enumerate() {
        let (light, id) = (lights[k % 2], LightId(k as u32 % 2));
        let lobe = if k % 3 == 0 {
            Lobe { exponent: 1.0, flux: Vec3::ONE, axis: Vec3::Y, has_cosine: false }
        } else {
            let axis = (light.center - at.position).normalize();
            Lobe { exponent: [20.0, 2000.0][k % 2], flux: Vec3::ONE, axis, has_cosine: false }
        };
        let radius = [0.0, 0.2, 2.0][k % 3];
        let shaft = Shaft::new(Sphere { center: at.position + Vec3::X * radius * 0.9, radius }, light, id);
        let mut fresh = strategy.scratch();
        let fresh = fraction(LightVisibility::alone(&strategy, id, ACCURACY, &mut fresh), at, light, &lobe);
        let entered = fraction(LightVisibility::enter(&strategy, &shaft, ACCURACY, &mut old), at, light, &lobe);
        assert_eq!(fresh.to_bits(), entered.to_bits(), "{k}");
        let entered = fraction(LightVisibility::enter(&boxed, &shaft, ACCURACY, &mut old_dyn), at, light, &lobe);
        assert_eq!(fresh.to_bits(), entered.to_bits(), "{k}");
        partial += u32::from(fresh > 0.0 && fresh < 1.0);
    }
    assert!(partial > 40, "{partial}");
    // A light without a map is not shadowed.
    let other = Sphere { center: Vec3::new(0.0, 3.0, 9.0), radius: 0.5 };
    let at = receiver(Vec3::new(0.0, 0.0, -0.5), Vec3::Y);
    let shaft = Shaft::new(Sphere { center: at.position, radius: 0.1 }, other, LightId(2));
    let lobe = Lobe { exponent: 1.0, flux: Vec3::ONE, axis: Vec3::Y, has_cosine: false };
    let visit = LightVisibility::enter(&strategy, &shaft, ACCURACY, &mut old);
    assert_eq!(fraction(visit, &at, other, &lobe), 1.0);
}

const ACCURACY: Accuracy = Accuracy { tolerance: 0.003, depth: 5 };

fn fraction<V: Visibility>(mut visit: LightVisibility<'_, V>, at: &Receiver, light: Sphere, lobe: &Lobe) -> f32 {
    let cone = Cone::of_sphere(at.position, light);
    visit.visible_fraction(at, &cone, lobe, cap_integral(at, lobe, &cone)).x
}

#[test]
fn point_lights_have_hard_shadows() {
    let light = Sphere { radius: 0.0, ..LIGHT };
    let mesh = sheet(Mesh::default(), [-1.0, 0.0], 2.5, [-1.0, 1.0]);
    let strategy = MaskVisibility::new(blockers(&mesh, light, 512));
    let mut scratch = strategy.scratch();
    for (x, expected) in [(-1.0, Coverage::Dark), (-0.02, Coverage::Dark), (0.02, Coverage::Lit), (2.0, Coverage::Lit)]
    {
        let at = receiver(Vec3::new(x, 0.0, 0.1), Vec3::Y);
        let cone = Cone::of_sphere(at.position, light);
        let query = VisibilityQuery::new(&at, LightId(0), &cone, Accuracy::new(0.003));
        assert_eq!(strategy.coverage(&query, &mut scratch), expected, "{x}");
    }
}

#[test]
fn grazing_and_turned_receivers_are_finite() {
    let mesh = Mesh::default().sphere(Vec3::new(0.0, 1.5, 0.0), 0.6, 12);
    let blockers = blockers(&mesh, LIGHT, 256);
    let mut random = Random::new(15);
    for k in 0..2000 {
        let position = match k % 4 {
            0 => random.axis().as_vec3() * 3.0,
            // Receivers on the mesh, in the light's plane, in the light.
            1 => mesh.positions[k % mesh.positions.len()],
            2 => Vec3::new(random.between(-3.0, 3.0) as f32, 5.0, random.between(-3.0, 3.0) as f32),
            _ => LIGHT.center + random.axis().as_vec3() * 0.601,
        };
        let at = receiver(position, random.axis().as_vec3());
        let seen = share(&blockers, &mut blockers.scratch(), &at, LIGHT);
        // NaN if nothing of the disc is above the horizon.
        assert!(seen.is_nan() || (0.0..=1.0).contains(&seen), "{at:?}: {seen}");
    }
}

/// Triangles of all sizes, lights anywhere, at any scale.
#[test]
fn any_scene_is_finite_and_a_group_changes_nothing() {
    let mut random = Random::new(77);
    let mut partial = 0;
    for case in 0..1200_u32 {
        let scale = random.log_uniform(1e-4, 1e4);
        let mut mesh = Mesh::default();
        for _ in 0..1 + case % 40 {
            let center = random.axis() * scale * random.uniform();
            let size = scale * random.log_uniform(0.01, 3.0);
            let first = mesh.positions.len() as u32;
            mesh.positions.extend((0..3).map(|_| (center + random.axis() * size).as_vec3()));
            mesh.triangles.push([first, first + 1, first + 2]);
        }
        let light = Sphere {
            center: (random.axis() * scale * random.log_uniform(0.01, 30.0)).as_vec3(),
            radius: (scale * random.log_uniform(0.001, 3.0)) as f32,
        };
        let around = ReceiverBounds { min: Vec3::splat(-scale as f32), max: Vec3::splat(scale as f32) };
        let options = MapOptions {
            resolution: 16 + (random.bits() % 100) as u32,
            layers: 1 + case % 4,
            receivers: case.is_multiple_of(3).then_some(around),
        };
        let blockers = ShadowMapBlockers::new(vec![mesh.map(light, &options)]);
        let mut scratch = blockers.scratch();
        for _ in 0..10 {
            let position = (random.axis() * scale * random.uniform()).as_vec3();
            let at = receiver(position, random.axis().as_vec3());
            if position.distance(light.center) <= light.radius * 1.0001 {
                continue;
            }
            let group = Sphere { center: position, radius: 0.1 * scale as f32 };
            blockers.enter(&Shaft::new(group, light, LightId(0)), &mut scratch);
            let seen = share(&blockers, &mut scratch, &at, light);
            let alone = share(&blockers, &mut blockers.scratch(), &at, light);
            assert!(seen.is_nan() || (0.0..=1.0).contains(&seen), "{case}: {seen}");
            // The rounding of a mask's area, if one says lit and the other draws the mask and finds nothing.
            assert!(seen.is_nan() && alone.is_nan() || (seen - alone).abs() < 1e-6, "{case}: {seen} {alone}");
            partial += u32::from(seen > 0.0 && seen < 1.0);
        }
    }
    assert!(partial > 500, "{partial}");
}

/// Texels of a coarse map reach behind a receiver that they nearly touch, in all ways that a quadrilateral can.
#[test]
fn touching_receivers_are_finite() {
    let mesh = Mesh::fence();
    let mut random = Random::new(16);
    for (resolution, radius) in [(16, 1.0), (40, 2.5), (120, 1.5), (256, 3.6)] {
        let light = Sphere { center: Vec3::new(4.0, 6.0, 8.0), radius };
        let blockers = blockers(&mesh, light, resolution);
        let mut scratch = blockers.scratch();
        for k in 0..6000 {
            let t = mesh.triangles[k % mesh.triangles.len()].map(|v| mesh.positions[v as usize]);
            let (u, v) = (random.uniform() as f32, random.uniform() as f32);
            let position = t[0] + (t[1] - t[0]) * u + (t[2] - t[0]) * (v * (1.0 - u));
            let normal = (t[1] - t[0]).cross(t[2] - t[0]).normalize();
            let seen = share(&blockers, &mut scratch, &receiver(position, normal), light);
            assert!(seen.is_nan() || (0.0..=1.0).contains(&seen), "{position}: {seen}");
        }
    }
}

#[test]
fn bad_input_is_refused() {
    let mesh = Mesh::default().sphere(Vec3::new(0.0, 1.5, 0.0), 0.6, 4);
    let build = |light, options: &MapOptions| ShadowMap::build(&mesh.positions, &mesh.triangles, light, options);
    for resolution in [0, 1, 15, 8193, 100_000] {
        let error = build(LIGHT, &options(resolution)).unwrap_err();
        assert_eq!(error, MapError::Resolution(resolution));
        assert!(error.to_string().contains(&resolution.to_string()) && !error.to_string().contains('\n'));
    }
    for layers in [0, 5] {
        assert_eq!(build(LIGHT, &MapOptions { layers, ..options(64) }).unwrap_err(), MapError::Layers(layers));
    }
    let not_finite = ReceiverBounds { min: Vec3::NAN, max: Vec3::ONE };
    assert!(build(LIGHT, &MapOptions { receivers: Some(not_finite), ..options(64) }).is_err());
    assert!(build(Sphere { center: Vec3::INFINITY, ..LIGHT }, &options(64)).is_err());
    assert_eq!(build(Sphere { radius: -1.0, ..LIGHT }, &options(64)).unwrap_err(), MapError::NegativeRadius);
    let positions = [Vec3::ZERO, Vec3::X, Vec3::NAN];
    assert!(ShadowMap::build(&positions, &[[0, 1, 2]], LIGHT, &options(64)).is_err());
    let index = ShadowMap::build(&positions[..2], &[[0, 1, 2]], LIGHT, &options(64)).unwrap_err();
    assert_eq!(index, MapError::Index { triangle: 0, vertex: 2, count: 2 });
}

#[test]
fn advice_follows_the_width_of_the_light() {
    let mesh = Mesh::default().sphere(Vec3::new(0.0, 1.5, 0.0), 0.6, 12);
    let bounds = ReceiverBounds { min: Vec3::new(-2.0, 0.0, -2.0), max: Vec3::new(2.0, 0.0, 2.0) };
    let advice = |resolution| mesh.map(LIGHT, &options(resolution)).advice(&bounds);
    // The nearest blocker is 2.9 from the light, receivers 5: w = 2·0.6·2.1/(5·2.9·t), t ≈ 2·0.175/resolution.
    let expected = |resolution: f32| 1.2 * 2.1 / (5.0 * 2.9) * resolution / 0.35;
    for resolution in [24, 48, 256] {
        let (wide, told) = (expected(resolution as f32), advice(resolution));
        // The map's border takes four texels.
        let ratio = told.shaft_texels / wide * resolution as f32 / (resolution as f32 - 4.0);
        assert!((ratio - 1.0).abs() < 0.15, "{resolution}: {} {wide}", told.shaft_texels);
        assert!(advice(told.wanted_resolution.max(16) + 4).shaft_texels > 31.0);
    }
    let fineness = |resolution| advice(resolution).fineness;
    assert_eq!([16, 48, 256].map(fineness), [MapFineness::TooCoarse, MapFineness::Coarse, MapFineness::Fine]);
    assert!(advice(16).to_string().contains("resolution"));
}
