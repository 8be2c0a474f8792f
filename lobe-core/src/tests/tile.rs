//! Tiles give what the calls for one receiver give, at every level of SIMD.

use super::cap::irradiance_error;
use super::{EXTREME, levels, receiver};
use crate::lanes::{WIDTH, set_row};
use crate::oracle::Random;
use crate::*;
use core::f64::consts::PI;
use glam::{DVec3, Vec3};

/// The integrator's tile takes the same formula in columns.
#[test]
fn small_lights_at_the_horizon_of_a_tile() {
    let mut random = Random::new(6);
    let (mut at, mut centers) = (Vec::new(), Vec::new());
    for _ in 0..1024 {
        // A horizontal receiver, the light's centre at a height that f32 keeps: n·l is that height over the distance.
        let radius = random.log_uniform(1e-8, 0.5) as f32;
        let height = random.between(-0.99, 0.99) as f32 * radius;
        at.push(Receiver { position: Vec3::new(-1.0, 0.0, -height), ..receiver(DVec3::Z) });
        centers.push((radius, height));
    }
    let (mut tile, mut light, mut lobes, mut out) =
        (Tile::default(), TileLight::default(), TileLobes::default(), Vec::new());
    for (at, (radius, _)) in at.iter().zip(&centers) {
        tile.set(core::slice::from_ref(at));
        light.sphere(&tile, Sphere { center: Vec3::ZERO, radius: *radius }, Vec3::ONE);
        lobes.reset(&tile, 1);
        set_row(lobes.block_mut(0, 0), 0, &bytemuck::cast(PackedLobe::from(Lobe::new(Vec3::Z, 1.0, Vec3::ONE))));
        cap_integrals(&light, &lobes, &mut out);
        let cone = light.cone(0);
        let seen = (at.normal.dot(cone.axis), cone.sin_sq());
        let (error, value) = irradiance_error(out[0] * core::f32::consts::PI, seen);
        assert!(error <= 1e-5, "radius {radius}: {error:.1e} of {value} s³");
    }
}

#[test]
fn many_at_once_are_the_single_ones_on_every_machine() {
    let mut random = Random::new(24);
    let (mut at, mut cones, mut rows) = (Vec::new(), Vec::new(), [Vec::new(), Vec::new()]);
    for k in 0..3000_u32 {
        let normal = random.axis();
        let theta = random.log_uniform(0.05, 40.0).to_radians();
        let beta = random.between(0.0, 0.5 * PI + theta);
        let light = random.axis_at(normal, beta);
        let one_minus_cos = if k % 97 == 0 { 2.0 } else { (2.0 * (0.5 * theta).sin().powi(2)) as f32 };
        at.push(receiver(normal));
        cones.push(Cone { axis: light.as_vec3().normalize(), one_minus_cos, distance: 1.0 });
        rows[0].push(Lobe::new(normal.as_vec3(), 1.0, Vec3::ONE));
        // Some blocks of one kind, most of all.
        let gloss = if k / 16 % 5 == 0 { 30.0 * f64::from(1 + k / 16 % 3 * 20) } else { random.exponent(1e6) };
        let e = if k % 31 == 0 { EXTREME[(k / 31 % 12) as usize] } else { gloss as f32 };
        let off = random.uniform() * (theta + 4.0 / f64::from(e + 0.1).sqrt());
        let axis = random.axis_at(light, off.min(PI)).as_vec3().normalize();
        let flux = if k % 11 == 0 { Vec3::ZERO } else { Vec3::ONE };
        rows[1].push(Lobe { has_cosine: k % 2 == 1, ..Lobe::with_flux(axis, e, flux) });
    }
    let (mut tile, mut lobes, mut out) = (Tile::default(), TileLobes::default(), Vec::new());
    tile.set(&at);
    lobes.reset(&tile, 2);
    for (place, rows) in rows.iter().enumerate() {
        for (block, rows) in rows.chunks(WIDTH).enumerate() {
            rows.iter()
                .enumerate()
                .for_each(|(j, l)| set_row(lobes.block_mut(place, block), j, &bytemuck::cast(PackedLobe::from(*l))));
        }
    }
    let mut light = TileLight::default();
    light.one_by_one(&tile, cones.iter().map(|cone| SeenLight::of_cone(*cone, Vec3::ONE)));
    for level in levels() {
        crate::cap::integrals_at(level, &light, &lobes, &mut out);
        for (i, (at, cone)) in at.iter().zip(&cones).enumerate() {
            for (k, lobe) in lobes.of(i) {
                let single = cap_integral(at, lobe, cone);
                assert_eq!(out[k].to_bits(), single.to_bits(), "{level:?}: {} {single} {lobe:?}", out[k]);
            }
            let empty = rows[1][i].flux == Vec3::ZERO;
            assert!(lobes.of(i).count() == if empty { 1 } else { 2 } && (!empty || out[3008 + i] == 0.0));
        }
    }
}

/// With their edges beside them, alone, apart, and beside edges of other microfacets.
#[test]
fn pairs_of_microfacets_are_the_single_ones_on_every_machine() {
    let mut random = Random::new(25);
    let (mut at, mut cones, mut rows) = (Vec::new(), Vec::new(), Vec::new());
    for k in 0..1000_u32 {
        let normal = random.axis();
        let theta = random.log_uniform(0.5, 30.0).to_radians();
        let beta = random.between(0.0, 0.5 * PI + 0.5 * theta);
        let axis = random.axis_at(normal, beta).as_vec3().normalize();
        at.push(receiver(normal));
        // Some are inside the light.
        let one_minus_cos = if k % 10 == 0 { 2.0 } else { (1.0 - theta.cos()) as f32 };
        cones.push(Cone { axis, one_minus_cos, distance: 1.0 });
        let tilt = random.between(0.0, 1.5);
        let view = random.axis_at(normal, tilt).as_vec3().normalize();
        let alpha = random.log_uniform(0.01, 1.0) as f32;
        let [base, edge] = Microfacets::new(view, alpha, [Vec3::ONE; 2]).map(PackedLobe::from);
        let [_, other] = Microfacets::new(view, 0.5 * alpha, [Vec3::ONE; 2]).map(PackedLobe::from);
        let none = PackedLobe::default();
        let black = PackedLobe { flux: Vec3::ZERO, ..edge };
        let orders =
            [[none, base, edge], [base, edge, none], [base, none, edge], [edge, base, none], [base, base, edge]];
        let rest = [[base, black, other], [base, other, edge], [none, none, base], [edge, none, none]];
        rows.push(if k % 3 == 0 { rest[(k / 3 % 4) as usize] } else { orders[(k / 3 % 5) as usize] });
    }
    let (mut tile, mut lobes, mut out) = (Tile::default(), TileLobes::default(), Vec::new());
    tile.set(&at);
    lobes.reset(&tile, 3);
    for (i, row) in rows.iter().enumerate() {
        for (place, lobe) in row.iter().enumerate() {
            set_row(lobes.block_mut(place, i / WIDTH), i % WIDTH, &bytemuck::cast(*lobe));
        }
    }
    let mut light = TileLight::default();
    light.one_by_one(&tile, cones.iter().map(|cone| SeenLight::of_cone(*cone, Vec3::ONE)));
    for level in levels() {
        out.fill(f32::NAN);
        crate::cap::integrals_at(level, &light, &lobes, &mut out);
        for (i, (at, cone)) in at.iter().zip(&cones).enumerate() {
            for (k, lobe) in lobes.of(i) {
                let single = cap_integral(at, lobe, cone);
                assert_eq!(out[k].to_bits(), single.to_bits(), "{level:?} {i}: {} {single} {lobe:?}", out[k]);
            }
        }
    }
}

#[test]
fn cones_and_spheres_of_tiles_are_the_single_ones() {
    let mut random = Random::new(26);
    for count in [0, 1, 16, 63, 64, 200] {
        let mut point = || random.axis().as_vec3() * random.log_uniform(1e-3, 1e3) as f32;
        let at: Vec<Receiver> = (0..count).map(|_| Receiver { position: point(), ..receiver(DVec3::Z) }).collect();
        let mut tile = Tile::default();
        tile.set(&at);
        let (sphere, half_extent) = tile.bounds();
        let is_in_box = |p: Vec3| (p - sphere.center).abs().cmple(half_extent).all();
        assert!(at.iter().all(|at| at.position.distance(sphere.center) <= sphere.radius && is_in_box(at.position)));
        let mut spheres = vec![Sphere { center: point(), radius: 0.5 }, Sphere { center: point(), radius: 0.0 }];
        spheres.extend(at.first().map(|at| Sphere { center: at.position, radius: 0.3 }));
        spheres.extend(at.first().map(|at| Sphere { center: at.position, radius: 0.0 }));
        for sphere in spheres {
            let mut light = TileLight::default();
            light.sphere(&tile, sphere, Vec3::ONE);
            for (i, at) in at.iter().enumerate() {
                assert_eq!(light.cone(i), Cone::of_sphere(at.position, sphere));
            }
        }
    }
}
