//! The hierarchy and the cheap tests against a loop over everything.

use crate::SphereBlockers;
use glam::{DVec3, Vec3};
use lobe_core::oracle::Random;
use lobe_core::{Cone, Receiver, SelfShadow, Sphere};
use shading::{Accuracy, Coverage, LightId, Shaft, VisibilityQuery};
use visibility_mask::Blockers;

/// Spheres in clusters and strays, with all sizes, some repeated.
fn cloud(random: &mut Random, count: usize, scale: f64) -> Vec<Sphere> {
    let mut spheres: Vec<Sphere> = Vec::new();
    let mut home = DVec3::ZERO;
    for i in 0..count {
        if i % 50 == 0 {
            home = random.axis() * random.between(0.0, 6.0) * scale;
        }
        let center = match i % 7 {
            0 => random.axis() * random.between(0.0, 12.0) * scale,
            _ => home + random.axis() * random.uniform().cbrt() * scale,
        };
        let sphere = Sphere { center: center.as_vec3(), radius: (scale * random.log_uniform(0.01, 0.5)) as f32 };
        spheres.push(if i % 31 == 30 { spheres[i - 1] } else { sphere });
    }
    spheres
}

fn shaft(random: &mut Random, case: usize, scale: f64) -> Shaft {
    let mut sphere = Sphere {
        center: (random.axis() * random.between(0.0, 5.0) * scale).as_vec3(),
        radius: (scale * random.log_uniform(1e-3, 1.0)) as f32,
    };
    let mut light = Sphere {
        center: (random.axis() * random.between(4.0, 9.0) * scale).as_vec3(),
        radius: (scale * random.log_uniform(1e-3, 3.0)) as f32,
    };
    match case % 9 {
        0 => light.radius = 0.0,
        1 => sphere.radius = 0.0,
        2 => light.radius = (20.0 * scale) as f32,
        3 => light.center = sphere.center + (light.center - sphere.center) * 1e5,
        4 => sphere.radius = (light.center - sphere.center).length() - light.radius.min(1e-3 * scale as f32),
        _ => {}
    }
    Shaft::new(Sphere { radius: sphere.radius.max(0.0), ..sphere }, light, LightId(0))
}

/// Distance from a point to the convex hull of two spheres: the nearest sphere of all between them, by golden section (the
/// distance to a sphere that moves and grows along a line is convex).
fn hull_distance(shaft: &Shaft, p: DVec3) -> f64 {
    let (a, b) = (shaft.receivers, shaft.light);
    let (from, to) = (a.center.as_dvec3(), b.center.as_dvec3());
    let at = |t: f64| p.distance(from.lerp(to, t)) - (f64::from(a.radius) * (1.0 - t) + f64::from(b.radius) * t);
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..200 {
        let third = (high - low) / 3.0;
        if at(low + third) < at(high - third) { high -= third } else { low += third }
    }
    at(low).min(at(0.0)).min(at(1.0))
}

#[test]
fn candidates_are_what_meets_the_shaft() {
    let mut random = Random::new(11);
    let (mut met, mut extra, mut all) = (0, 0, 0);
    for case in 0..200 {
        let scale = [1.0, 1e-4, 1e6][case % 3];
        let spheres = cloud(&mut random, [1, 7, 8, 9, 64, 65, 300, 1000][case % 8], scale);
        let blockers = SphereBlockers::new(&spheres, &vec![0; spheres.len()], &[]);
        let shaft = shaft(&mut random, case, scale);
        let mut scratch = blockers.scratch();
        blockers.enter(&shaft, &mut scratch);
        assert!(scratch.candidates().is_sorted_by(|a, b| a < b));
        for (i, sphere) in spheres.iter().enumerate() {
            let gap = hull_distance(&shaft, sphere.center.as_dvec3()) - f64::from(sphere.radius);
            let found = scratch.candidates().binary_search(&(i as u32)).is_ok();
            all += 1;
            met += usize::from(gap <= 0.0);
            extra += usize::from(found && gap > 0.0);
            assert!(found || gap > 0.0, "case {case}: sphere {i} meets the shaft by {gap:e}");
            // A sphere that is kept for its rounding alone is next to the shaft.
            let distance = f64::from(sphere.center.distance(shaft.receivers.center));
            let slack = 1e-4 * (distance + f64::from(sphere.radius + shaft.receivers.radius + shaft.light.radius));
            assert!(!found || gap < slack, "case {case}: sphere {i} is {gap:e} away, {distance}");
        }
    }
    println!("{met} of {all} meet the shaft, {extra} more are kept");
    assert!(met > 1000 && met * 4 < all);
}

/// Of receivers in a narrow box fewer spheres are candidates: none that comes near to a segment from one of them to the light.
#[test]
fn a_narrow_box_keeps_what_may_block() {
    let mut random = Random::new(14);
    let (mut kept, mut left_out) = (0, 0);
    for case in 0..150 {
        let scale = [1.0, 1e-4, 1e6][case % 3];
        let spheres = cloud(&mut random, 500, scale);
        let blockers = SphereBlockers::new(&spheres, &vec![0; spheres.len()], &[]);
        let shaft = shaft(&mut random, case, scale);
        let radius = f64::from(shaft.receivers.radius);
        let mut half_extent = DVec3::new(random.uniform(), random.uniform(), random.uniform()) * radius;
        half_extent[case % 3] *= [0.0, 0.1, 0.5][case / 3 % 3];
        let [mut in_sphere, mut in_box] = [blockers.scratch(), blockers.scratch()];
        blockers.enter(&shaft, &mut in_sphere);
        blockers.enter(&shaft.in_box(half_extent.as_vec3()), &mut in_box);
        let middle = shaft.receivers.center.as_dvec3();
        let segments: Vec<[DVec3; 2]> = (0..200)
            .map(|_| {
                let corner = DVec3::from_array(core::array::from_fn(|_| random.between(-1.3, 1.3)))
                    .clamp(-DVec3::ONE, DVec3::ONE);
                let from = middle + (corner * half_extent).clamp_length_max(radius);
                [from, shaft.light.center.as_dvec3() + random.axis() * f64::from(shaft.light.radius)]
            })
            .collect();
        for i in in_sphere.candidates() {
            let sphere = spheres[*i as usize];
            if in_box.candidates().contains(i) {
                kept += 1;
                continue;
            }
            left_out += 1;
            let center = sphere.center.as_dvec3();
            let near = segments.iter().map(|[a, b]| {
                let t = ((center - *a).dot(*b - *a) / a.distance_squared(*b)).clamp(0.0, 1.0);
                center.distance(a.lerp(*b, t))
            });
            assert!(near.fold(f64::INFINITY, f64::min) > f64::from(sphere.radius), "case {case}: sphere {i}");
        }
    }
    println!("{kept} kept, {left_out} left out");
    assert!(left_out > 500 && kept > 500, "{kept} {left_out}");
}

#[test]
fn selection_is_that_of_the_flat_loop() {
    let mut random = Random::new(12);
    let (mut counts, mut dark) = ([0; 3], 0);
    for case in 0..900 {
        let scale = [1.0, 1e-4, 1e6][case % 3];
        let count = 1 + (random.bits() % 400) as usize;
        let spheres = cloud(&mut random, count, scale);
        let objects: Vec<u32> = (0..spheres.len() as u32).map(|i| i / 50 % 3).collect();
        let mut blockers = SphereBlockers::new(&spheres, &objects, &[(0.1 * scale) as f32, (2.0 * scale) as f32]);
        if case % 2 == 1 {
            // The same spheres by another hierarchy: fitted to other places.
            let turned: Vec<Sphere> = spheres
                .iter()
                .map(|s| Sphere { center: Vec3::new(s.center.z, s.center.x, s.center.y), ..*s })
                .collect();
            blockers = SphereBlockers::new(&turned, &objects, &[(0.1 * scale) as f32, (2.0 * scale) as f32]);
            blockers.update(&spheres);
        }
        if case % 5 < 2 {
            // Each sphere with a smaller sphere in it for its own object; what is out of range is put right.
            let own: Vec<SelfShadow> = spheres
                .iter()
                .map(|_| SelfShadow {
                    offset: (random.axis() * random.between(0.0, 1.0)).as_vec3(),
                    radius: random.between(-0.1, 1.2) as f32,
                    distance: random.log_uniform(0.01, 3.0) as f32,
                })
                .collect();
            blockers = blockers.with_self_shadows(&own);
        }
        let mut shaft = shaft(&mut random, case, scale);
        if case % 4 == 3 {
            // Small shafts, wholly hidden ones among them.
            shaft.receivers.radius *= 0.01;
            shaft.light.radius *= 0.01;
        }
        let (mut culled, mut whole) = (blockers.scratch(), blockers.scratch());
        blockers.enter(&shaft, &mut culled);
        dark += usize::from(culled.is_dark());
        for _ in 0..8 {
            let sphere = shaft.receivers;
            let offset = random.axis() * f64::from(sphere.radius) * random.uniform().cbrt() * 0.9999;
            let at = Receiver {
                position: sphere.center + offset.as_vec3(),
                normal: random.axis().as_vec3().normalize(),
                face: Vec3::Z,
                view: Vec3::Z,
                object: (case % 4) as u32,
            };
            let cone = Cone::of_sphere(at.position, shaft.light);
            if cone.one_minus_cos > 1.0 {
                continue;
            }
            let query = VisibilityQuery::new(&at, LightId(0), &cone, Accuracy::new(0.003));
            let (want, cones) = blockers.select_flat(&query);
            counts[want as usize] += 1;
            for scratch in [&mut culled, &mut whole] {
                assert_eq!(blockers.select(&query, scratch), want, "case {case}");
                assert!(want == Coverage::Dark || scratch.cones() == cones, "case {case}");
            }
        }
    }
    println!("lit, dark, partial: {counts:?}; {dark} shafts wholly dark");
    assert!(counts.iter().all(|n| *n > 200) && dark > 20);
}

/// A receiver of the sphere's own object sees the smaller sphere and its distance, others the whole one.
#[test]
fn own_receivers_see_the_smaller_sphere() {
    let sphere = Sphere { center: Vec3::Z * 3.0, radius: 1.0 };
    let light = Sphere { center: Vec3::Z * 20.0, radius: 5.0 };
    let cone = Cone::of_sphere(Vec3::ZERO, light);
    let seen = |blockers: &SphereBlockers, object| {
        let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::Z).on_object(object);
        let mut scratch = blockers.scratch();
        let coverage =
            blockers.select(&VisibilityQuery::new(&at, LightId(0), &cone, Accuracy::new(0.003)), &mut scratch);
        (coverage, scratch.cones().to_vec())
    };
    let plain = |radius| SphereBlockers::new(&[Sphere { radius, ..sphere }], &[7], &[]);
    let own = |radius, distance| plain(1.0).with_self_shadows(&[SelfShadow { radius, ..SelfShadow::whole(distance) }]);
    assert_eq!(seen(&plain(1.0), 8).0, Coverage::Dark);
    assert_eq!(seen(&own(0.5, 1.0), 8).0, Coverage::Dark, "another object's receiver");
    assert_eq!(seen(&plain(0.5), 8).0, Coverage::Partial);
    // Three radii away a third of the difference is left.
    let third = 1.0 - 0.9 * SelfShadow::nearness(1.0, 3.0);
    assert!((third - 0.7).abs() < 1e-6);
    assert_eq!(seen(&plain(third), 8).0, Coverage::Partial);
    assert_eq!(seen(&own(0.1, 1.0), 7), seen(&plain(third), 8), "farther than the distance");
    assert_eq!(seen(&own(0.1, 3.9), 7).0, Coverage::Lit, "left before the distance");
    // Half the sphere: radius and distance shrink with it.
    let mut grown = own(0.1, 3.65);
    assert_eq!(seen(&grown, 7).0, Coverage::Partial);
    grown.update(&[Sphere { radius: 0.5, ..sphere }]);
    assert_eq!(seen(&grown, 7), seen(&plain(0.5 - 0.45 * SelfShadow::nearness(0.5, 3.0)), 8));
    // Off the sphere's centre, a third of the way from here.
    let aside = SelfShadow { offset: Vec3::X * 0.9, radius: 0.1, distance: 1.0 };
    let moved = Sphere { center: sphere.center + Vec3::X * 0.9 * SelfShadow::nearness(1.0, 3.0), radius: third };
    let moved = SphereBlockers::new(&[moved], &[7], &[]);
    assert_eq!(seen(&plain(1.0).with_self_shadows(&[aside]), 7), seen(&moved, 8));
    assert_eq!(seen(&plain(1.0).with_self_shadows(&[aside]), 8), seen(&plain(1.0), 8));
}

/// A receiver that goes through its own object's spheres sees what it sees change little by little.
#[test]
fn own_spheres_move_without_pops() {
    let mut random = Random::new(5);
    let step = 1e-4;
    for _ in 0..40 {
        let whole = Sphere { center: random.axis().as_vec3(), radius: random.between(0.2, 1.5) as f32 };
        let radius = random.between(0.4, 1.0) as f32;
        let offset = random.axis().as_vec3() * (1.0 - radius);
        let near = SelfShadow { offset, radius, distance: 0.3 }.near(whole.radius);
        let way = random.axis().as_vec3();
        let mut last: Option<Sphere> = None;
        for k in -30_000..30_000 {
            let sphere = SelfShadow::seen(whole, near, way * (step * k as f32));
            if let Some(last) = last {
                let change = sphere.center.distance(last.center) + (sphere.radius - last.radius).abs();
                // w falls by at most 1/R a length, from spheres that differ by at most 2R.
                assert!(change < 2.0 * step + 1e-6, "{change}");
            }
            last = Some(sphere);
        }
    }
}

#[test]
fn light_of_more_than_a_hemisphere_keeps_everything() {
    let sphere = Sphere { center: Vec3::new(0.0, 0.0, -1.0), radius: 0.5 };
    let blockers = SphereBlockers::new(&[sphere], &[0], &[]);
    let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::Z).on_object(1);
    for one_minus_cos in [1.0, 1.5, 2.0] {
        let cone = Cone { axis: Vec3::Z, one_minus_cos, distance: f32::INFINITY };
        let query = VisibilityQuery::new(&at, LightId(0), &cone, Accuracy::new(0.003));
        let mut scratch = blockers.scratch();
        let (want, cones) = blockers.select_flat(&query);
        assert_eq!(blockers.select(&query, &mut scratch), want);
        assert_eq!(scratch.cones(), cones);
    }
}

#[test]
fn updates_follow_the_spheres_and_renew_what_is_worn() {
    let mut random = Random::new(13);
    let spheres = cloud(&mut random, 500, 1.0);
    let objects = vec![0; spheres.len()];
    let mut blockers = SphereBlockers::new(&spheres, &objects, &[]);
    let shifted: Vec<Sphere> =
        spheres.iter().map(|s| Sphere { center: s.center + Vec3::new(3.0, 0.5, 0.0), ..*s }).collect();
    assert!(!blockers.update(&shifted), "moved as a whole");
    // All mixed: every node spans everything.
    let mixed: Vec<Sphere> = (0..500).map(|i| spheres[i * 237 % 500]).collect();
    assert!(blockers.update(&mixed), "mixed");
    assert!(!blockers.update(&mixed));
    // Spheres that come and go.
    let mut gone = mixed.clone();
    gone[17].radius = 0.0;
    assert!(blockers.update(&gone));
    assert!(blockers.update(&mixed));
    let shaft = shaft(&mut random, 5, 1.0);
    let mut got = blockers.scratch();
    blockers.enter(&shaft, &mut got);
    let new = SphereBlockers::new(&mixed, &objects, &[]);
    let mut want = new.scratch();
    new.enter(&shaft, &mut want);
    assert_eq!(got.candidates(), want.candidates());
    assert_eq!(blockers.spheres(), mixed);
}

#[test]
fn what_is_not_a_sphere_blocks_nothing() {
    let good = Sphere { center: Vec3::Z * 5.0, radius: 0.1 };
    let bad = [
        Sphere { radius: f32::NAN, ..good },
        Sphere { radius: f32::INFINITY, ..good },
        Sphere { radius: 0.0, ..good },
        Sphere { radius: -1.0, ..good },
        Sphere { center: Vec3::new(f32::NAN, 0.0, 5.0), ..good },
        Sphere { center: Vec3::new(0.0, f32::NEG_INFINITY, 5.0), ..good },
    ];
    let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::Z).on_object(1);
    let light = Sphere { center: Vec3::Z * 10.0, radius: 1.0 };
    let cone = Cone::of_sphere(at.position, light);
    let query = VisibilityQuery::new(&at, LightId(0), &cone, Accuracy::new(0.003));
    let check = |blockers: &SphereBlockers, want: &[u32]| {
        let mut scratch = blockers.scratch();
        assert_eq!(scratch.candidates(), want);
        let lit = if want.is_empty() { Coverage::Lit } else { Coverage::Partial };
        assert_eq!(blockers.select(&query, &mut scratch), lit);
        blockers.enter(&Shaft::new(Sphere { center: Vec3::ZERO, radius: 0.1 }, light, LightId(0)), &mut scratch);
        assert_eq!(scratch.candidates(), want);
        assert_eq!(blockers.select(&query, &mut scratch), lit);
    };
    check(&SphereBlockers::new(&[], &[], &[]), &[]);
    check(&SphereBlockers::new(&bad, &[0; 6], &[]), &[]);
    let mut mixed = bad.to_vec();
    mixed.insert(3, good);
    check(&SphereBlockers::new(&mixed, &[0; 7], &[]), &[3]);
    let mut blockers = SphereBlockers::new(&[good; 6], &[0; 6], &[]);
    assert!(blockers.update(&bad));
    check(&blockers, &[]);
    // Numbers at the end of what f32 holds.
    let huge =
        [good, Sphere { center: Vec3::splat(3e38), radius: 3e38 }, Sphere { center: Vec3::splat(-3e38), radius: 1.0 }];
    let blockers = SphereBlockers::new(&huge, &[0; 3], &[]);
    let mut scratch = blockers.scratch();
    blockers.enter(&Shaft::new(Sphere { center: Vec3::ZERO, radius: 0.1 }, light, LightId(0)), &mut scratch);
    assert!(scratch.candidates().contains(&0));
}

/// Median time of one call in ns, over calls that together take some milliseconds.
fn nanoseconds(calls: usize, mut f: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..7)
        .map(|_| {
            let start = std::time::Instant::now();
            f();
            start.elapsed().as_secs_f64() * 1e9 / calls as f64
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[3]
}

/// A blob of as much volume whatever the count, or as many blobs of 64 as it takes, over a floor.
fn over_a_floor(count: usize, grows: bool) -> (Vec<Sphere>, f32) {
    let mut random = Random::new(21);
    let side = if grows { (count as f64 / 64.0).sqrt().ceil() } else { 1.0 };
    let each = if grows { 64.0 } else { count as f64 };
    let spheres = (0..count)
        .map(|i| {
            let blob = (i / 64) as f64;
            let home = if grows {
                DVec3::new(blob % side - 0.5 * (side - 1.0), 0.0, (blob / side).floor() - 0.5 * (side - 1.0)) * 3.0
            } else {
                DVec3::ZERO
            };
            let center = home + DVec3::Y * 1.2 + random.axis() * random.uniform().cbrt() * 0.9;
            Sphere { center: center.as_vec3(), radius: (0.9 * each.powf(-1.0 / 3.0)) as f32 }
        })
        .collect();
    (spheres, (2.0 + 1.5 * (side - 1.0)) as f32)
}

#[test]
#[ignore = "timings: in release, on a quiet machine"]
fn timings() {
    use visibility_mask::{Mask, UnitSquare};
    println!(
        "spheres       build  refit | enter a tile (flat) candidates | select a point (no enter) cones | splat | all, a point"
    );
    println!(
        "                   µs     µs |            ns                  |          ns                    |    ns |  ns"
    );
    for grows in [false, true] {
        for count in [64, 512, 3578, 100_000] {
            let (spheres, half) = over_a_floor(count, grows);
            let objects = vec![0; count];
            let rounds = (200_000 / count).max(1);
            let build = nanoseconds(rounds, || {
                (0..rounds).for_each(|_| drop(SphereBlockers::new(&spheres, &objects, &[])));
            });
            let mut blockers = SphereBlockers::new(&spheres, &objects, &[]);
            let refit = nanoseconds(rounds, || (0..rounds).for_each(|_| assert!(!blockers.update(&spheres))));
            let light = Sphere { center: Vec3::new(0.5, 8.0, 0.3), radius: 0.5 };
            // 16 × 16 tiles of 8 × 8 points, of the size of a picture of 256 points across 4 units.
            let point = |tile: usize, i: usize| {
                let corner = |k: usize| half * (2.0 * (k as f32 + 0.5) / 16.0 - 1.0) - 0.0625;
                let at = |k: usize| (k as f32 + 0.5) / 64.0;
                Vec3::new(corner(tile % 16) + at(i % 8), 0.0, corner(tile / 16) + at(i / 8))
            };
            let shafts: Vec<(Shaft, Vec<Vec3>)> = (0..256)
                .map(|tile| {
                    let points: Vec<Vec3> = (0..64).map(|i| point(tile, i)).collect();
                    let center = 0.5 * (points[0] + points[63]);
                    (
                        Shaft::new(Sphere { center, radius: 1.00001 * center.distance(points[0]) }, light, LightId(0)),
                        points,
                    )
                })
                .collect();
            let mut scratch = blockers.scratch();
            let enter = nanoseconds(256, || {
                for (shaft, _) in &shafts {
                    blockers.enter(std::hint::black_box(shaft), &mut scratch);
                }
            });
            let everything = blockers.scratch();
            let flat_enter = nanoseconds(256, || {
                for (shaft, _) in &shafts {
                    std::hint::black_box(everything.meets(&crate::shaft::ShaftTest::new(shaft)));
                }
            });
            let (mut candidates, mut cones, mut partial) = (0, 0, 0_usize);
            let mut mask = Mask::default();
            // Stage by stage: 0 enter, 1 and select, 2 and splat.
            let mut frame = |stage: usize| {
                (candidates, cones, partial) = (0, 0, 0);
                for (shaft, points) in &shafts {
                    blockers.enter(shaft, &mut scratch);
                    candidates += scratch.candidates().len();
                    for position in points.iter().filter(|_| stage > 0) {
                        let at = Receiver::on_surface(*position, Vec3::Y, Vec3::Y).on_object(1);
                        let cone = Cone::of_sphere(at.position, light);
                        let query = VisibilityQuery::new(&at, LightId(0), &cone, Accuracy::new(0.003));
                        if blockers.select(&query, &mut scratch) == Coverage::Partial {
                            cones += scratch.cones().len();
                            partial += 1;
                            if stage > 1 {
                                mask.reset(&UnitSquare::facing(&cone, blockers.across(&query, &scratch)), 5, at.normal);
                                blockers.splat(&query, &mut scratch, &mut mask);
                                std::hint::black_box(mask.is_dark());
                            }
                        }
                    }
                }
            };
            let stages = [0, 1, 2].map(|stage| nanoseconds(256 * 64, || frame(stage)));
            let mut whole = blockers.scratch();
            let few = if count > 10_000 { 64 } else { 4 };
            let flat_select = nanoseconds(256 * 64 / few, || {
                for (_, points) in &shafts {
                    for position in points.iter().step_by(few) {
                        let at = Receiver::on_surface(*position, Vec3::Y, Vec3::Y).on_object(1);
                        let cone = Cone::of_sphere(at.position, light);
                        let query = VisibilityQuery::new(&at, LightId(0), &cone, Accuracy::new(0.003));
                        std::hint::black_box(blockers.select(&query, &mut whole));
                    }
                }
            });
            println!(
                "{count:6} {} {:8.1} {:6.1} | {enter:6.0} {flat_enter:8.0} {:6.0} | {:6.0} {flat_select:8.0} {:6.1} | {:5.0} | {:5.0}",
                if grows { "spread" } else { "blob  " },
                build / 1e3,
                refit / 1e3,
                candidates as f64 / 256.0,
                stages[1] - stages[0],
                cones as f64 / partial.max(1) as f64,
                (stages[2] - stages[1]) * (256.0 * 64.0) / cones.max(1) as f64,
                stages[2],
            );
        }
    }
}
