//! Cones that spheres block, and their bits on the mask, against rays in f64.

use crate::block::{LANES, half_of};
use crate::blocked_cones::{cones, whole_cones};
use crate::cone_list::ConeList;
use crate::splat::{BlockedCone, Front, PartBefore, order_by_ray};
use core::f64::consts::PI;
use fearless_simd::{Level, Simd, dispatch, f32x8, prelude::*};
use glam::{DVec3, Vec2, Vec3};
use lobe_core::Cone;
use lobe_core::oracle::Random;
use visibility_mask::{Mask, UnitSquare};

/// The cone that one sphere blocks under the self-distance τ; `None` if it is empty.
fn blocked_cone(to: Vec3, radius: f32, tau: f32) -> Option<BlockedCone> {
    dispatch!(Level::new(), simd => {
        let [x, y, z] = to.to_array().map(|x| f32x8::splat(simd, x));
        let [radius, tau, half] = [radius, tau, half_of(tau)].map(|x| f32x8::splat(simd, x));
        let (tangent_radius, wide, exists) = cones(simd, [x, y, z], radius, tau, half);
        exists.all_true().then(|| BlockedCone::new(to, tangent_radius[3], wide[3], 0.0))
    })
}

/// Blocks what is in cones that don't meet the light.
fn splat(cones: &[BlockedCone], level: Level, mask: &mut Mask) {
    let mut list = ConeList::default();
    cones.iter().for_each(|cone| list.push(cone));
    let cone = Cone { axis: mask.square().axis, one_minus_cos: 0.1, distance: f32::INFINITY };
    dispatch!(level, simd => list.splat(simd, &Front::of_cone(&cone), mask));
}

/// Entry and exit of a ray from the origin into a sphere, both possibly negative.
pub(crate) fn chord(v: DVec3, center: DVec3, radius: f64) -> Option<(f64, f64)> {
    let along = center.dot(v);
    let half_sq = radius * radius - (center - v * along).length_squared();
    (half_sq > 0.0).then(|| (along - half_sq.sqrt(), along + half_sq.sqrt()))
}

/// How far outside of a sphere's silhouette, seen from the origin, a direction passes, in radians; negative inside.
fn silhouette_distance(v: DVec3, center: DVec3, cos: f64) -> f64 {
    let d = center.normalize();
    v.cross(d).length().atan2(v.dot(d)) - cos.clamp(-1.0, 1.0).acos()
}

/// Blocked under the rule with τ, and the cosine of the cone that says so, from the definition.
fn exact_cos(to: DVec3, r: f64, tau: f64) -> Option<f64> {
    let d = to.length();
    let k = d * d - r * r;
    if k > 0.0 && tau * tau <= k {
        return Some((k / (d * d)).sqrt());
    }
    if tau <= 0.0 {
        return Some(-1.0);
    }
    let cos = (tau * tau + k) / (2.0 * tau * d);
    (cos < 1.0).then_some(cos.max(-1.0))
}

#[test]
fn self_distance_is_the_exit_of_the_ray() {
    let mut random = Random::new(1);
    let mut compared = 0;
    for _ in 0..4000 {
        let r = random.log_uniform(0.01, 2.0);
        let d = r * random.log_uniform(0.05, 3.0);
        let tau = random.log_uniform(0.01, 2.0) * r;
        let center = random.axis() * d;
        let cone = blocked_cone(center.as_vec3(), r as f32, tau as f32);
        for _ in 0..20 {
            let v = random.axis();
            let Some(entry_exit) = chord(v, center, r) else {
                if let Some(cone) = cone {
                    let near = silhouette_distance(v, center, exact_cos(center, r, tau).unwrap_or(1.0)).abs() < 2e-3;
                    assert!(near || !cone.contains(v.as_vec3()), "blocked without a hit");
                }
                continue;
            };
            let blocked = entry_exit.1 > 0.0 && entry_exit.1 > tau;
            // Directions on the edge are decided by rounding.
            let edge = exact_cos(center, r, tau).is_some_and(|cos| silhouette_distance(v, center, cos).abs() < 2e-3);
            if edge || (entry_exit.1 / tau - 1.0).abs() < 1e-4 {
                continue;
            }
            compared += 1;
            let got = cone.is_some_and(|c| c.contains(v.as_vec3()));
            assert_eq!(got, blocked, "r {r} d {d} τ {tau} exit {}", entry_exit.1);
        }
    }
    assert!(compared > 10_000);
}

#[test]
fn self_distance_is_continuous_through_the_surface() {
    for tau in [1e-3_f32, 0.05, 0.5, 1.5] {
        let mut last: Option<f32> = None;
        let mut largest = 0.0_f32;
        for k in 0..40_000 {
            let d = 0.2 + 2.0 * k as f32 / 40_000.0;
            let angle = blocked_cone(Vec3::new(0.0, 0.0, d), 1.0, tau)
                .map_or(0.0, |c| (1.0 - c.one_minus_cos()).clamp(-1.0, 1.0).acos());
            if let Some(last) = last {
                largest = largest.max((angle - last).abs());
            }
            last = Some(angle);
        }
        // The angle opens like √(2δ/(τd)) within δ of d = r + τ and of d = r − τ.
        let (step, d) = (2.0 / 40_000.0, (1.0 - tau).abs().max(0.2));
        println!("τ {tau}: largest step {largest:.4} rad");
        assert!(largest < 1.1 * (2.0 * step / (tau * d)).sqrt() + 10.0 * step, "τ {tau}: {largest}");
    }
}

#[test]
fn ellipse_rows_and_rays_agree() {
    let mut random = Random::new(2);
    let (mut wrong, mut cells, mut far) = (0, 0, 0.0_f64);
    for case in 0..3000 {
        let theta = [1e-3_f64, 0.02, 0.3, 1.0, 1.4][case % 5];
        let axis = random.axis();
        let cone = Cone {
            axis: axis.as_vec3().normalize(),
            one_minus_cos: (2.0 * (0.5 * theta).sin().powi(2)) as f32,
            distance: f32::INFINITY,
        };
        let mut square = UnitSquare::facing(&cone, random.axis().as_vec3());
        if case % 4 == 3 {
            // A window as lobes beside the light have it.
            (square.center, square.half) = (Vec2::new(0.6, 0.1) * square.disc, Vec2::new(0.2, 0.8) * square.disc);
        }
        let mut mask = Mask::default();
        mask.reset(&square, 5, cone.axis);
        // Angular radius from far below the light to beyond a hemisphere, touching the light's cone or not.
        let d = random.log_uniform(0.01, 100.0);
        let beta = (theta * random.log_uniform(0.05, 30.0)).min(1.56);
        let off = random.between((beta - theta).max(0.0), beta + theta).min(PI);
        let mut center = random.axis_at(axis, off) * d;
        let mut r = d * beta.sin();
        match case % 10 {
            0 => r = 1.2 * d,
            1 => center = -center,
            2 => center = random.axis_at(axis, (beta + theta).min(PI)) * d,
            3 => center = axis * d,
            // About the plane through the receiver: H = r, H < r.
            4 => r = center.dot(axis).abs().min(0.99 * d),
            5 => r = (1.02 * center.dot(axis).abs()).min(0.999 * d),
            _ => {}
        }
        let tau = if case % 3 == 0 { 0.4 * r } else { 0.0 };
        let (to, r) = (center.as_vec3(), r as f32);
        let Some(blocked) = blocked_cone(to, r, tau as f32) else { continue };
        let Some(cos) = exact_cos(to.as_dvec3(), f64::from(r), f64::from(tau as f32)) else { continue };
        splat(&[blocked], Level::new(), &mut mask);
        for j in 0..mask.side() {
            for i in 0..mask.side() {
                let p = mask.cell_center(i, j);
                if p.length() > square.disc {
                    continue;
                }
                let v = square.world(p.extend(1.0)).as_dvec3().normalize();
                let outside = if cos <= -1.0 { -1.0 } else { silhouette_distance(v, to.as_dvec3(), cos) };
                // The larger side of a cell in radians.
                let cell = f64::from(mask.cell().max_element()) / (1.0 + f64::from(p.length_squared()));
                let bit = mask.lit_cells(j) >> i & 1 == 0;
                cells += 1;
                if cos <= -1.0 {
                    assert!(bit);
                // A bit says blocked from end to end.
                } else if (outside < -1.6 * f64::from(mask.cell().max_element()) - 1e-6 && !bit)
                    || (outside > 1e-6 + 0.14 * cell && bit)
                {
                    wrong += 1;
                    far = far.max(outside.abs() / cell);
                    if wrong < 12 {
                        println!(
                            "case {case}: r/d {} cos {cos} θ {theta} off {off} cell {i} {j} bit {bit} outside {outside:.3e} = {:.2} cells",
                            r / to.length(),
                            outside / cell
                        );
                    }
                }
            }
        }
    }
    println!("{wrong} of {cells} cells wrong, by up to {far:.2} cells");
    assert_eq!(wrong, 0);
}

/// The span of a row, exact in f64, against what the mask holds: lit length per row.
#[test]
fn row_spans_are_exact() {
    let mut random = Random::new(3);
    for theta in [1e-5_f64, 1e-4, 1e-3, 0.02, 0.3, 1.0] {
        let (mut worst, mut mean, mut bias, mut n, mut flat, mut worst_at) =
            (0.0_f64, 0.0, 0.0, 0.0, 0.0, String::new());
        for _ in 0..150 {
            let axis = random.axis();
            let cone = Cone {
                axis: axis.as_vec3().normalize(),
                one_minus_cos: (2.0 * (0.5 * theta).sin().powi(2)) as f32,
                distance: f32::INFINITY,
            };
            let d = random.log_uniform(0.01, 100.0);
            let beta = random.log_uniform(0.3 * theta, 1.5);
            let off = random.between((beta - theta).max(0.0), beta + theta).min(1.57);
            let to = (random.axis_at(axis, off) * d).as_vec3();
            let r = (d * beta.sin()) as f32;
            let square = UnitSquare::facing(&cone, to);
            let mut mask = Mask::default();
            mask.reset(&square, 5, cone.axis);
            let Some(blocked) = blocked_cone(to, r, 0.0) else { continue };
            if f64::from(r) >= f64::from(to.length()) * 0.9999 {
                continue;
            }
            splat(&[blocked], Level::new(), &mut mask);
            let frame = [square.right, square.up, square.axis].map(|v| v.as_dvec3());
            let inside = |x: f64, y: f64| {
                let v = (frame[0] * x + frame[1] * y + frame[2]).normalize();
                chord(v, to.as_dvec3(), f64::from(r)).is_some_and(|c| c.1 > 0.0)
            };
            for j in 0..32 {
                let y = f64::from(mask.row_y(j));
                let half = (f64::from(square.disc).powi(2) - y * y).max(0.0).sqrt();
                let open_at = |y: f64, n: usize| {
                    let x = |k: usize| half * (2.0 * (k as f64 + 0.5) / n as f64 - 1.0);
                    let open = (0..n).filter(|k| !inside(x(*k), y)).count();
                    open as f64 / n as f64 * 2.0 * half / f64::from(mask.cell().x)
                };
                // Edges along the row, and rows in which the shape ends, are taken by area.
                let step = 0.5 * f64::from(mask.cell().x);
                let all = 2.0 * half / f64::from(mask.cell().x);
                let [above, below] = [y + step, y - step].map(|y| open_at(y, 200));
                if (above - below).abs() > 4.0 || (above > 0.99 * all) != (below > 0.99 * all) {
                    flat += 1.0;
                    continue;
                }
                let want = open_at(y, 1500);
                let lit: f64 = lit_row(&mask, j);
                let error = (lit - want).abs();
                mean += error;
                bias += lit - want;
                n += 1.0;
                if error > worst {
                    worst = error;
                    worst_at = format!("r/d {} off {off} β {beta} row {j} lit {lit} want {want}", r / to.length());
                }
            }
        }
        println!(
            "θ {theta:.0e}: rows wrong by mean {:.4}, max {worst:.3} cells, bias {:.5}; {flat} of {n} flat; {worst_at}",
            mean / n,
            bias / n
        );
        assert!(flat < 0.2 * n);
        if theta > 1e-4 {
            assert!(worst < 0.6 && mean / n < 0.06 && (bias / n).abs() < 6e-3, "{worst_at}");
        }
    }
}

/// Lit cells of a row from a copy of the mask in which all other rows are blocked.
fn lit_row(mask: &Mask, row: usize) -> f64 {
    let mut copy = mask.clone();
    for j in (0..mask.side()).filter(|j| *j != row) {
        copy.block_span(j, f32::NEG_INFINITY, f32::INFINITY);
    }
    f64::from(copy.areas().1)
}

#[test]
fn order_is_the_rays() {
    let mut random = Random::new(4);
    let mut counts = [0; 2];
    for case in 0..20_000 {
        // Light and sphere that meet, at all ratios of distance to radius.
        let light_radius = random.log_uniform(0.05, 1.0);
        let distance = light_radius * random.log_uniform(1.5, 3000.0);
        let axis = random.axis();
        let light = axis * distance;
        let sphere_radius = light_radius * random.log_uniform(0.1, 5.0);
        let apart = match case % 3 {
            0 => light_radius + sphere_radius * random.between(-1.0, 1.0),
            1 => (light_radius - sphere_radius).abs() * random.uniform(),
            _ => random.between(0.0, light_radius + sphere_radius),
        };
        let to = (light + random.axis() * apart).as_vec3();
        let r = sphere_radius as f32;
        let Some(sphere) = blocked_cone(to, r, 0.0) else { continue };
        let sphere = BlockedCone { radius: r, meets_light: true, ..sphere };
        for _ in 0..8 {
            let spread = (light_radius / distance).asin() * random.uniform().sqrt();
            let v = random.axis_at(axis, spread);
            let Some(hit) = chord(v, to.as_dvec3(), f64::from(r)) else { continue };
            let Some(shine) = chord(v, light.as_vec3().as_dvec3(), f64::from(light_radius as f32)) else { continue };
            if hit.1 < 0.0 {
                continue;
            }
            let (entry, bright) = (hit.0.max(0.0), shine.0.max(0.0));
            if (entry - bright).abs() < 1e-2 * light_radius.min(sphere_radius) {
                continue;
            }
            // Grazing rays: the ends of a chord of zero length are ill-conditioned.
            if hit.1 - hit.0 < 0.1 * sphere_radius || shine.1 - shine.0 < 0.1 * light_radius {
                continue;
            }
            let got = sphere.contains(v.as_vec3())
                && order_by_ray(v.as_vec3(), &sphere, light.as_vec3(), light_radius as f32);
            counts[usize::from(entry < bright)] += 1;
            assert_eq!(
                got,
                entry < bright,
                "distance {distance} light {light_radius} sphere {sphere_radius} at {apart}: {entry} {bright}"
            );
        }
    }
    println!("{counts:?} behind, in front");
}

/// The closed form of a sphere that a flat light's plane cuts, against rays in f64: cell centres, but for those within rounding of the
/// outline.
#[test]
fn part_before_a_plane_is_the_rays() {
    let mut random = Random::new(9);
    let (mut counts, mut cut) = ([0; 2], 0);
    for _ in 0..3000 {
        let height = random.log_uniform(0.01, 100.0);
        let half = random.log_uniform(0.02, 3.0);
        let middle = [random.between(-2.0, 2.0), random.between(-2.0, 2.0)];
        let radius = height * half * random.log_uniform(0.05, 5.0);
        let off = random.between(-1.0, 1.0) * radius;
        let place = |k: usize| (middle[k] + half * random.between(-1.5, 1.5)) * height;
        let [x, y] = [0, 1].map(place);
        let to = DVec3::new(x, y, height + off).as_vec3();
        let Some(cone) = blocked_cone(to, radius as f32, 0.0).filter(|cone| cone.cos > 0.0) else { continue };
        let cone = BlockedCone { radius: radius as f32, meets_light: true, ..cone };
        let center = Vec2::new(middle[0] as f32, middle[1] as f32);
        let half = Vec2::splat(half as f32);
        let square = UnitSquare { right: Vec3::X, up: Vec3::Y, axis: Vec3::Z, center, half, disc: 100.0 };
        let mut mask = Mask::default();
        mask.reset(&square, 5, Vec3::Z);
        let before = mask.clone();
        cone.splat_in_front(&Front::Plane(Vec3::Z, height as f32), &mut mask);
        for j in 0..mask.side() {
            for i in 0..mask.side() {
                let hides = |at: Vec2| {
                    let q = DVec3::new(f64::from(at.x), f64::from(at.y), 1.0) * f64::from(height as f32);
                    chord(q.normalize(), to.as_dvec3(), radius).is_some_and(|hit| hit.1 > 0.0 && hit.0 < q.length())
                };
                let (at, cell) = (mask.cell_center(i, j), mask.cell());
                let bit = |mask: &Mask| mask.lit_cells(j) >> i & 1 == 1;
                let around = [Vec2::X, Vec2::NEG_X, Vec2::Y, Vec2::NEG_Y].map(|d| hides(at + d * cell));
                let wanted = hides(at);
                if bit(&before) && around.iter().all(|other| *other == wanted) {
                    counts[usize::from(wanted)] += 1;
                    assert_eq!(!bit(&mask), wanted, "{to} {radius} before {height}, row {j}, cell {i}");
                }
            }
        }
        cut += usize::from(PartBefore::new(to, &cone, height as f32).is_some());
    }
    assert!(cut > 1000 && counts.iter().all(|count| *count > 100_000), "{cut} cut, {counts:?} lit and hidden");
}

/// Spheres are drawn as the same bits with any vector instructions.
#[test]
fn masks_do_not_depend_on_the_registers() {
    let mut random = Random::new(21);
    let best = Level::new();
    let mut levels = vec![Level::baseline()];
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    levels.extend([best.as_sse4_2().map(Simd::level), best.as_avx2().map(Simd::level)].into_iter().flatten());
    for case in 0..200 {
        let theta = random.log_uniform(0.003, 0.6);
        let axis = random.axis();
        let cone = Cone {
            axis: axis.as_vec3().normalize(),
            one_minus_cos: (1.0 - theta.cos()) as f32,
            distance: f32::INFINITY,
        };
        let hits: Vec<BlockedCone> = (0..12)
            .filter_map(|_| {
                let (aside, away) = (theta * 1.5 * random.uniform(), random.log_uniform(0.1, 30.0));
                let to = random.axis_at(axis, aside) * away;
                let r = (to.length() * random.log_uniform(0.1, 1.5) * theta).min(to.length() * 1.1);
                blocked_cone(to.as_vec3(), r as f32, if case % 4 == 0 { 0.3 } else { 0.0 })
            })
            .collect();
        let draw = |level: Level| {
            let mut mask = Mask::default();
            mask.reset(&UnitSquare::facing(&cone, Vec3::X), 3 + case % 4, cone.axis);
            splat(&hits, level, &mut mask);
            let cells: Vec<u64> = (0..mask.side()).map(|j| mask.lit_cells(j)).collect();
            (mask.areas(), cells)
        };
        let want = draw(best);
        for &level in &levels {
            assert_eq!(draw(level), want, "case {case} at {level:?}");
        }
    }
}

#[test]
fn whole_spheres_are_those_with_no_distance() {
    let mut random = Random::new(8);
    for case in 0..2000 {
        let scale = random.log_uniform(1e-6, 1e6);
        let direction = random.axis() * scale;
        // From far inside, through the surface, to far outside; sometimes at the centre.
        let radius = scale * random.log_uniform(1e-3, 1e3);
        let to = if case % 50 == 0 { Vec3::ZERO } else { direction.as_vec3() };
        dispatch!(Level::new(), simd => {
            let column = |x: f32| f32x8::splat(simd, x);
            let (to, radius) = ([column(to.x), column(to.y), column(to.z)], column(radius as f32));
            let lanes = |a: f32x8<_>, b: f32x8<_>| {
                let [a, b]: [[f32; LANES]; 2] = [a.into(), b.into()];
                (a.map(f32::to_bits), b.map(f32::to_bits))
            };
            let (tangent_radius, wide, exists) = cones(simd, to, radius, column(0.0), column(half_of(0.0)));
            assert!(exists.all_true(), "case {case}");
            let whole = whole_cones(simd, to, radius);
            assert_eq!(lanes(whole.0, whole.1), lanes(tangent_radius, wide), "case {case}");
        });
    }
}
