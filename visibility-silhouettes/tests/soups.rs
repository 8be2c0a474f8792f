//! Masks from silhouettes, sample by sample, against f64 rays to every sample.

use crate::common::soups::{soup, vec};
use crate::common::{Compared, LitParts, Rays, Soup, globe, turn};
use glam::{DVec3, Vec3};
use lobe_core::oracle::Random;
use lobe_core::{Cone, Receiver, Sphere};
use shading::{Accuracy, Coverage, LightId, Shaft, VisibilityQuery};
use visibility_mask::{Blockers, Raster, UnitSquare, hooks};
use visibility_silhouettes::{AnyHit, SilhouetteBlockers, SilhouetteMesh};

/// The distance of a point from a triangle.
fn distance_to(p: DVec3, corners: [Vec3; 3]) -> f64 {
    let [a, b, c] = corners.map(|q| q.as_dvec3());
    let n = (b - a).cross(c - a).normalize_or_zero();
    let sides = [(a, b), (b, c), (c, a)];
    if n != DVec3::ZERO && sides.iter().all(|(a, b)| (*b - *a).cross(p - *a).dot(n) >= 0.0) {
        return n.dot(p - a).abs();
    }
    let to_side = |(a, b): (DVec3, DVec3)| {
        let t = ((p - a).dot(b - a) / (b - a).length_squared().max(1e-300)).clamp(0.0, 1.0);
        p.distance(a + (b - a) * t)
    };
    sides.map(to_side).into_iter().fold(f64::INFINITY, f64::min)
}

fn compare(case: usize, random: &mut Random) -> Option<Compared> {
    let soup = soup(case % 6, random);
    if soup.triangles.is_empty() {
        return None;
    }
    let light = Sphere {
        center: vec(random, 1.0) * 0.3
            + Vec3::Y * random.between(if case.is_multiple_of(4) { -0.5 } else { 1.0 }, 4.0) as f32,
        radius: 0.0,
    };
    let light = Sphere { radius: random.log_uniform(0.01, 1.5) as f32, ..light };
    let mut normal = random.axis().as_vec3().normalize();
    let position = match case % 5 {
        // Receivers on a triangle, on either side.
        0 => {
            let corners: Vec<_> = soup.corners().collect();
            let [a, b, c] = corners[random.between(0.0, corners.len() as f64) as usize % corners.len()];
            let (u, v) = (random.between(0.0, 0.5) as f32, random.between(0.0, 0.5) as f32);
            let side = (b - a).cross(c - a).normalize_or_zero();
            normal = if side.dot(normal) < 0.0 { -side } else { side };
            a + (b - a) * u + (c - a) * v
        }
        _ => vec(random, 1.0) - Vec3::Y * random.between(0.0, 3.0) as f32,
    };
    let at = Receiver::on_surface(position, normal, normal);
    let cone = Cone::of_sphere(position, light);
    if cone.one_minus_cos > 0.9 {
        return None;
    }
    let rays = Rays(&soup);
    let meshes = [SilhouetteMesh::new(0, &soup.positions, &soup.triangles)];
    let blockers = SilhouetteBlockers::new(&meshes, rays);
    let mut scratch = blockers.scratch();
    if !case.is_multiple_of(3) {
        let center = position + vec(random, 0.1);
        blockers.enter(
            &Shaft::new(Sphere { center, radius: position.distance(center) * 1.001 }, light, LightId(0)),
            &mut scratch,
        );
    }
    let query = VisibilityQuery::new(&at, LightId(0), &cone, Accuracy::new(0.003));
    let coverage = blockers.select(&query, &mut scratch);
    let square = UnitSquare::facing(&cone, blockers.across(&query, &scratch)).above(normal);
    let (depth, coarse) = (1 + (case as u32 / 7) % 6, case.is_multiple_of(2));
    let mut mask = hooks::mask(&square, depth, coarse, normal);
    let emitting: Vec<_> = (0..mask.side()).map(|j| mask.emitting(j)).collect();
    match coverage {
        Coverage::Lit => {}
        Coverage::Dark => mask.block_all(),
        Coverage::Partial => blockers.splat(&query, &mut scratch, &mut mask),
    }
    let origin = rays.leave(position, normal).as_dvec3();
    let raster = mask.raster();
    // The distance at which a direction meets the light.
    let to_light = light.center.as_dvec3() - origin;
    let distance = |d: DVec3| {
        let (along, square) = (d.dot(to_light), d.length_squared());
        let root = along * along - square * (to_light.length_squared() - f64::from(light.radius).powi(2));
        (along - root.max(0.0).sqrt()) / square
    };
    // The parts of triangles inside the light have arcs as outlines, which are drawn as chords.
    let touches = soup.corners().any(|t| distance_to(light.center.as_dvec3(), t) < f64::from(light.radius) * 1.01);
    let [mut different, mut all, mut wrong] = [0; 3];
    let mut open = 0;
    for (j, (from, to)) in emitting.into_iter().enumerate() {
        let row = hooks::row(&mask, j);
        for i in from..to {
            let truth = |aside: f64, up: f64| {
                let x = f64::from(raster.left)
                    + (f64::from(i) + 0.5 + f64::from(Raster::shift(j)) + aside) / f64::from(raster.samples);
                let y = f64::from(raster.bottom) + (j as f64 + 0.5 + up) / f64::from(raster.rows);
                let [r, u, a] = [square.right, square.up, square.axis].map(|v| v.as_dvec3());
                let d: DVec3 = r * x + u * y + a;
                soup.hits(origin, d, distance(d))
            };
            let dark = row[i as usize / 64] >> (i % 64) & 1 == 0;
            all += 1;
            let hidden = truth(0.0, 0.0);
            open += u32::from(!hidden);
            if dark != hidden {
                different += 1;
                // Next to an edge either answer is right.
                let near = if touches { 0.3 } else { 2e-3 };
                let around = [(near, 0.0), (-near, 0.0), (0.0, near), (0.0, -near)];
                wrong += u32::from(around.iter().all(|(x, y)| truth(*x, *y) != dark));
            }
        }
    }
    let is_partial = coverage == Coverage::Partial;
    let lit = is_partial.then(|| LitParts::of(&blockers, &query, &mut scratch, &mask, [open, all])).flatten();
    Some(Compared { samples: [different, all, wrong], touches, lit })
}

#[test]
fn every_sample_is_that_of_a_ray() {
    let mut random = Random::new(77);
    // Lights apart from all triangles, and lights that triangles reach into.
    let (mut sums, mut worst, mut cases) = ([[0_u64; 3]; 2], [[0; 2]; 2], [0; 2]);
    let mut known = LitParts::default();
    for case in 0..10_000 {
        let Some(Compared { samples: [different, all, wrong], touches, lit }) = compare(case, &mut random) else {
            continue;
        };
        known.add(lit);
        let kind = usize::from(touches);
        cases[kind] += 1;
        for (sum, x) in sums[kind].iter_mut().zip([different, all, wrong]) {
            *sum += u64::from(x);
        }
        if wrong > worst[kind][0] {
            worst[kind] = [wrong, case as u32];
            println!("case {case} (kind {}): {different} of {all} differ, {wrong} of them are wrong", case % 6);
        }
    }
    for ([different, all, wrong], (cases, light)) in sums.iter().zip(cases.iter().zip(["apart", "touching"])) {
        println!("{cases} cases, light {light}: {different} of {all} samples differ, {wrong} are wrong");
    }
    known.check();
    assert!(cases[0] > 5000 && cases[1] > 800);
    // On needles as thin as the rounding of their corners a few samples differ.
    let part = |k: usize| sums[k][0] as f64 / sums[k][1] as f64;
    assert!(worst[0][0] <= 2 && sums[0][2] <= 4 && part(0) < 1e-6);
    assert!(worst[1][0] <= 2 && sums[1][2] <= 4 && part(1) < 2e-4);
}

/// A refitted mesh gives the masks of a new one to the bit, whatever hierarchy it was built with.
#[test]
fn masks_do_not_depend_on_the_hierarchy() {
    let mut random = Random::new(5);
    let mut partly = 0;
    for case in 0..300 {
        let old = globe(Vec3::ZERO, 0.5, 9);
        let mut new = old.clone();
        let (turn, stretch) = (turn(&mut random), vec(&mut random, 0.4) + Vec3::ONE);
        for p in &mut new.positions {
            // Equal corners stay equal.
            *p = turn
                * (*p * stretch + 0.2 * (7.0 * p.y).sin() + 0.03 * (19.0 * Vec3::new(p.z, p.x, p.y)).map(f32::sin));
        }
        let fresh = [SilhouetteMesh::new(0, &new.positions, &new.triangles)];
        let mut kept = [SilhouetteMesh::new(0, &old.positions, &old.triangles)];
        assert!(kept[0].refit(&new.positions));
        let light = Sphere { center: Vec3::new(0.0, 3.0, 0.0), radius: random.log_uniform(0.05, 1.5) as f32 };
        let position = vec(&mut random, 0.6) - Vec3::Y * 1.5;
        let at = Receiver::on_surface(position, Vec3::Y, Vec3::Y);
        let cone = Cone::of_sphere(position, light);
        let query = VisibilityQuery::new(&at, LightId(0), &cone, Accuracy::new(0.003));
        let [a, b] = [&fresh, &kept].map(|meshes| {
            let blockers = SilhouetteBlockers::new(meshes, Rays(&new));
            let mut scratch = blockers.scratch();
            let coverage = blockers.select(&query, &mut scratch);
            let square = UnitSquare::facing(&cone, blockers.across(&query, &scratch));
            let mut mask = hooks::mask(&square, 5, case % 2 == 0, Vec3::Y);
            if coverage == Coverage::Partial {
                blockers.splat(&query, &mut scratch, &mut mask);
            }
            (coverage, square, (0..32).map(|j| hooks::row(&mask, j)).collect::<Vec<_>>())
        });
        partly += u32::from(a.0 == Coverage::Partial);
        assert!(a == b, "case {case}");
    }
    assert!(partly > 50, "{partly}");
}

/// Triangles without area block as soon as they have one.
#[test]
fn what_was_flat_may_grow() {
    let grown = globe(Vec3::ZERO, 0.5, 9);
    let mut line = grown.clone();
    line.positions.iter_mut().for_each(|p| *p *= Vec3::Y);
    // Equal corners of rings stay equal: spread them along the line.
    for (k, p) in line.positions.iter_mut().enumerate() {
        p.y += 1e-3 * k as f32;
    }
    let fresh = [SilhouetteMesh::new(0, &grown.positions, &grown.triangles)];
    let mut kept = [SilhouetteMesh::new(0, &line.positions, &line.triangles)];
    let light = Sphere { center: Vec3::new(0.0, 3.0, 0.0), radius: 0.8 };
    let at = |x: f32| {
        let position = Vec3::new(x, -1.0, 0.1);
        Receiver::on_surface(position, Vec3::Y, Vec3::Y)
    };
    let look = |meshes: &[SilhouetteMesh; 1], soup: &Soup| -> Vec<_> {
        let blockers = SilhouetteBlockers::new(meshes, Rays(soup));
        let mut scratch = blockers.scratch();
        let mut one = |k: u32| {
            let at = at(k as f32 * 0.05);
            let cone = Cone::of_sphere(at.position, light);
            let query = VisibilityQuery::new(&at, LightId(0), &cone, Accuracy::new(0.003));
            let mut mask = hooks::mask(&UnitSquare::facing(&cone, Vec3::X), 5, true, Vec3::Y);
            match blockers.select(&query, &mut scratch) {
                Coverage::Lit => {}
                Coverage::Dark => mask.block_all(),
                Coverage::Partial => blockers.splat(&query, &mut scratch, &mut mask),
            }
            (0..32).map(|j| hooks::row(&mask, j)[0].count_ones()).sum::<u32>()
        };
        (0..30).map(&mut one).collect()
    };
    let before = look(&kept, &line);
    assert!(before.iter().all(|lit| *lit == before[29]), "a line hides nothing: {before:?}");
    assert!(kept[0].refit(&grown.positions));
    let after = look(&kept, &grown);
    assert_eq!(after, look(&fresh, &grown));
    assert!(after.iter().any(|lit| *lit > 0 && *lit < before[29]));
}

/// A mask and its rotation are the same to the bit, whichever receivers share a list, or none.
#[test]
fn masks_do_not_depend_on_the_group() {
    let mut random = Random::new(19);
    let mut partly = 0;
    for case in 0..120 {
        let soup = if case % 3 == 0 { globe(Vec3::ZERO, 0.6, 20) } else { soup(case % 6, &mut random) };
        if soup.triangles.is_empty() {
            continue;
        }
        let meshes = [SilhouetteMesh::new(0, &soup.positions, &soup.triangles)];
        let blockers = SilhouetteBlockers::new(&meshes, Rays(&soup));
        let radius = random.log_uniform(0.05, 0.6) as f32;
        // In front of a part of the soup, or inside it.
        let light = Sphere { center: vec(&mut random, 0.5) + Vec3::Y * random.between(0.5, 3.0) as f32, radius };
        let (middle, spread) = (vec(&mut random, 1.0) - Vec3::Y, random.log_uniform(1e-3, 1.0));
        // A patch, and a second one behind it: a step in depth.
        let at = |k: usize| {
            let (x, z) = (k % 8, k / 8 % 8);
            let step = if x > 4 { 2.0 } else { 0.0 };
            let offset = Vec3::new(x as f32 / 8.0, step, z as f32 / 8.0) * spread as f32;
            Receiver::on_surface(middle + offset, Vec3::Y, Vec3::Y)
        };
        let receivers: Vec<_> = (0..64).map(at).collect();
        let reach = receivers.iter().map(|r| r.position.distance(middle)).fold(0.0, f32::max);
        let mut seen = |receivers: &[Receiver], entered: bool| -> Vec<_> {
            let mut scratch = blockers.scratch();
            if entered {
                let shaft = Shaft::new(Sphere { center: middle, radius: reach * 1.001 }, light, LightId(0));
                blockers.enter(&shaft, &mut scratch);
            }
            let mut look = |at: &Receiver| {
                let cone = Cone::of_sphere(at.position, light);
                if cone.one_minus_cos > 0.9 {
                    return None;
                }
                let query = VisibilityQuery::new(at, LightId(0), &cone, Accuracy::new(0.003));
                if blockers.select(&query, &mut scratch) != Coverage::Partial {
                    return None;
                }
                let across = blockers.across(&query, &scratch);
                let square = UnitSquare::facing(&cone, across);
                let mut mask = hooks::mask(&square, 5, true, at.normal);
                blockers.splat(&query, &mut scratch, &mut mask);
                let rows: Vec<_> = (0..mask.side()).map(|j| hooks::row(&mask, j)[0]).collect();
                partly += 1;
                Some((across, rows))
            };
            receivers.iter().map(&mut look).collect()
        };
        let group = seen(&receivers, true);
        assert!(group == seen(&receivers, false), "case {case}: alone");
        let backward: Vec<_> = receivers.iter().rev().copied().collect();
        assert!(group.iter().rev().eq(&seen(&backward, true)), "case {case}: backward");
        assert!(group[..29] == seen(&receivers[..29], true), "case {case}: a part");
    }
    assert!(partly > 3000, "{partly}");
}
