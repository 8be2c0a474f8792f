//! Outlines of cones and triangles against closed forms of what they leave of a uniform sky, and lobes against sums over many directions.

use super::*;
use fearless_simd::{Level, dispatch, f32x8, mask32x8, prelude::*};
use glam::{DVec3, Vec3};
use lobe_core::oracle::Random;
use lobe_core::vec3x8::Vec3x8;
use lobe_core::{BrdfLobe, Lobe, Microfacets, Receiver};
use shading::Coverage;

fn uniform(resolution: SkyResolution) -> SkyTable {
    SkyTable::new(resolution, 1, |_| Vec3::ONE)
}

fn lambert(at: &Receiver) -> BrdfLobe {
    Lobe::new(at.normal, 1.0, Vec3::ONE).into()
}

/// Draws triangles, each for itself.
fn draw(table: &SkyTable, horizon: &Horizon, triangles: &[[Vec3; 3]], buffer: &mut SkyBuffer) {
    let window = *buffer.window();
    draw_arcs(table, (horizon, &window), triangles, buffer);
}

/// Draws the arcs of triangles that a window needs.
fn draw_arcs(table: &SkyTable, sight: (&Horizon, &SkyWindow), triangles: &[[Vec3; 3]], buffer: &mut SkyBuffer) {
    let mut arcs = SkyArcs::default();
    arcs.reserve(8 * 3 * triangles.len());
    for corners in triangles {
        let [a, b, c] = corners.map(|p| p.as_dvec3());
        let volume = a.cross(b).dot(c);
        // Inside is to the right, and nothing is inside where the receiver is in the plane.
        let step = if volume == 0.0 { 0.0 } else { 2.0 * volume.signum() as f32 };
        for k in 0..3 {
            let [a, b] = [corners[k], corners[(k + 1) % 3]];
            dispatch!(Level::new(), simd => {
                let ends = [a, b].map(|v| Vec3x8::splat(simd, v));
                let (step, keep) = (f32x8::splat(simd, step), mask32x8::from_bitmask(simd, 1));
                arcs.push(simd, table.meridians(), sight, ends, step, keep);
            });
        }
    }
    dispatch!(Level::new(), simd => buffer.draw(simd, table.meridians(), &arcs));
}

/// Draws the outline of a cone into a view.
pub(super) fn draw_cone(view: &mut SkyView, table: &SkyTable, horizon: &Horizon, axis: Vec3, cos: f32) {
    view.draw(table, |buffer| {
        dispatch!(Level::new(), simd => buffer.draw_cone(simd, table.meridians(), horizon, axis, cos));
        false
    });
}

/// Whether a direction meets a triangle.
fn meets(v: DVec3, corners: &[Vec3; 3]) -> bool {
    let [a, b, c] = corners.map(|p| p.as_dvec3());
    let sides = [a.cross(b).dot(v), b.cross(c).dot(v), c.cross(a).dot(v)];
    let all = a.cross(b).dot(c);
    sides.iter().all(|side| side * all > 0.0)
}

/// `∫ max(n·v, 0)/π dv` over a triangle that is above the horizon (J. H. Lambert, 1760).
fn form_factor(normal: Vec3, corners: &[Vec3; 3]) -> f64 {
    let unit = corners.map(|p| p.as_dvec3().normalize());
    let side = |k: usize| {
        let (a, b) = (unit[k], unit[(k + 1) % 3]);
        let cross = a.cross(b);
        cross.normalize_or_zero().dot(normal.as_dvec3()) * cross.length().atan2(a.dot(b))
    };
    (side(0) + side(1) + side(2)).abs() * 0.5 * core::f64::consts::FRAC_1_PI
}

/// A direction at an even angle from an axis.
pub(super) fn beside(random: &mut Random, axis: DVec3, most: f64) -> DVec3 {
    let angle = random.between(0.0, most);
    random.axis_at(axis, angle)
}

/// The visible fraction of Lambert's lobe before triangles, by a view.
fn seen(table: &SkyTable, at: &Receiver, has_facet: bool, triangles: &[[Vec3; 3]]) -> f64 {
    let mut view = SkyView::default();
    let horizon = Horizon::new(at, has_facet);
    view.begin(table, horizon);
    view.draw(table, |buffer| {
        draw(table, &horizon, triangles, buffer);
        false
    });
    view.settle(table, false, |v| triangles.iter().any(|t| meets(v.as_dvec3(), t)));
    f64::from(view.integrals(table, at, &lambert(at))[0].x)
}

#[test]
fn cones_leave_what_closed_forms_say() {
    let mut random = Random::new(7);
    for (resolution, limit) in [(SkyResolution::new(64, 64), 1.5e-3), (SkyResolution::new(128, 64), 7e-4)] {
        let table = uniform(resolution);
        let (mut sum, mut worst, mut count) = (0.0, 0.0_f64, 0);
        for _ in 0..400 {
            let normal = random.axis();
            let half = random.between(0.05, 1.2);
            let axis = beside(&mut random, normal, core::f64::consts::FRAC_PI_2);
            if axis.dot(normal).asin() < half {
                continue;
            }
            let at = Receiver::on_surface(Vec3::ZERO, normal.as_vec3(), normal.as_vec3());
            let horizon = Horizon::new(&at, false);
            let mut view = SkyView::default();
            view.begin(&table, horizon);
            let cos = half.cos() as f32;
            draw_cone(&mut view, &table, &horizon, axis.as_vec3(), cos);
            view.settle(&table, false, |v| v.dot(axis.as_vec3()) > cos);
            let [seen, all] = view.integrals(&table, &at, &lambert(&at));
            let error = (f64::from(seen.x / all.x) - (1.0 - half.sin().powi(2) * axis.dot(normal))).abs();
            (sum, worst, count) = (sum + error, worst.max(error), count + 1);
        }
        println!("{resolution:?}: mean {:.6}, worst {worst:.6} of {count}", sum / f64::from(count));
        assert!(count > 50 && sum / f64::from(count) < limit && worst < 10.0 * limit);
    }
}

/// A cone that is more than a hemisphere leaves the opposite one.
#[test]
fn wide_cones_leave_the_rest() {
    let table = uniform(SkyResolution::new(128, 64));
    let at = Receiver::on_surface(Vec3::ZERO, Vec3::Y, Vec3::Y);
    let horizon = Horizon::new(&at, false);
    let (axis, half) = (-Vec3::new(0.3, 0.9, 0.2).normalize(), 2.5_f64);
    let mut view = SkyView::default();
    view.begin(&table, horizon);
    draw_cone(&mut view, &table, &horizon, axis, half.cos() as f32);
    view.settle(&table, false, |v| v.dot(axis) > half.cos() as f32);
    let seen = f64::from(view.integrals(&table, &at, &lambert(&at))[0].x);
    let want = half.sin().powi(2) * f64::from(-axis.y);
    assert!((seen - want).abs() < 1e-3, "{seen} for {want}");
}

/// Also with corners straight above, on meridians and on the axes.
#[test]
fn triangles_leave_what_lamberts_formula_says() {
    let mut random = Random::new(9);
    let table = uniform(SkyResolution::new(128, 64));
    let (mut sum, mut worst, mut count) = (0.0, 0.0_f64, 0);
    for case in 0..600 {
        let normal = if case % 3 == 0 { DVec3::Y } else { random.axis() };
        let mut corner = |k: usize| {
            let v = beside(&mut random, normal, 1.5).as_vec3() * random.between(0.5, 3.0) as f32;
            match (case % 12, k) {
                (0, 0) => Pole::nearest(normal.as_vec3()).world(Vec3::Z),
                (3, 0) => Vec3::new(1e-7, 1.0, -1e-8),
                (6, 0) => Vec3::new(1.0, 1.0, 0.0),
                (6, 1) => Vec3::new(-1.0, 1.0, 0.0),
                _ => v,
            }
        };
        let corners = [corner(0), corner(1), corner(2)];
        let at = Receiver::on_surface(Vec3::ZERO, normal.as_vec3(), normal.as_vec3());
        let got = seen(&table, &at, false, &[corners]);
        let error = (got - (1.0 - form_factor(at.normal, &corners))).abs();
        assert!(error < 0.02, "case {case}: {got}, {corners:?}");
        (sum, worst, count) = (sum + error, worst.max(error), count + 1);
    }
    println!("mean {:.6}, worst {worst:.6}", sum / f64::from(count));
    assert!(sum / f64::from(count) < 1e-3);
}

/// Around a tower of 1 × 1 × 4 on a floor, whose edges are parallel to the floor's normal: with a pole there the mean was 4.1e-3, the worst 1.1e-2.
#[test]
fn shadows_of_upright_edges_have_no_steps() {
    let table = uniform(SkyResolution::new(64, 64));
    let (mut sum, mut worst) = (0.0, 0.0_f64);
    for degree in 0..360 {
        let (sin, cos) = (f64::from(degree)).to_radians().sin_cos();
        let from = Vec3::new(2.0 * cos as f32, 0.0, 2.0 * sin as f32);
        let side = |k: usize| {
            let out = [Vec3::X, Vec3::Z, -Vec3::X, -Vec3::Z][k];
            let (middle, half) = (0.5 * out, 0.5 * Vec3::new(out.z, 0.0, -out.x));
            let [a, b] = [middle - half, middle + half].map(|corner| corner - from);
            let [c, d] = [b, a].map(|corner| corner + 4.0 * Vec3::Y);
            (middle.dot(out) < from.dot(out)).then_some([[a, b, c], [a, c, d]])
        };
        let triangles: Vec<_> = (0..4).filter_map(side).flatten().collect();
        let at = Receiver::on_surface(Vec3::ZERO, Vec3::Y, Vec3::Y);
        let want = 1.0 - triangles.iter().map(|corners| form_factor(at.normal, corners)).sum::<f64>();
        let error = (seen(&table, &at, false, &triangles) - want).abs();
        (sum, worst) = (sum + error, worst.max(error));
    }
    println!("mean {:.6}, worst {worst:.6}", sum / 360.0);
    assert!(sum / 360.0 < 7e-4 && worst < 7e-3);
}

/// More triangles never leave more light, and a number without meaning comes from none of them, however they degenerate.
#[test]
fn blockers_only_darken_and_nothing_is_nan() {
    let mut random = Random::new(11);
    let table = uniform(SkyResolution::new(64, 64));
    for case in 0..100 {
        let normal = random.axis().as_vec3();
        let face = (normal + 0.4 * random.axis().as_vec3()).normalize();
        let at = Receiver { face, ..Receiver::on_surface(Vec3::ZERO, normal, normal) };
        let mut corner = || random.axis().as_vec3() * random.log_uniform(1e-6, 1e6) as f32;
        let mut triangles = Vec::new();
        let mut before = seen(&table, &at, true, &triangles);
        assert!(before > 0.0 && before < 1.001);
        for more in 0..6 {
            let [a, b, c] = [corner(), corner(), corner()];
            triangles.push(match (case + more) % 6 {
                0 => [a, a, b],
                1 => [a, b, 0.5 * (a + b)],
                2 => [Vec3::ZERO, a, b],
                _ => [a, b, c],
            });
            let after = seen(&table, &at, true, &triangles);
            assert!(after.is_finite() && after >= 0.0, "case {case}: {after}");
            // Two outlines that cross a sample share it otherwise than one.
            assert!(after <= before + 5e-3, "case {case}: {before}, then {after}");
            before = after;
        }
    }
}

/// The facet under a smooth normal hides what is below it.
#[test]
fn facets_are_half_spaces() {
    let mut random = Random::new(13);
    let table = uniform(SkyResolution::new(64, 64));
    for _ in 0..200 {
        let normal = random.axis();
        let tilt = random.between(0.0, 1.0);
        let face = random.axis_at(normal, tilt);
        let at =
            Receiver { face: face.as_vec3(), ..Receiver::on_surface(Vec3::ZERO, normal.as_vec3(), normal.as_vec3()) };
        // A lune of the hemisphere is (1 + cos)/2 of it, weighted by the cosine.
        let got = seen(&table, &at, true, &[]);
        assert!((got - 0.5 * (1.0 + tilt.cos())).abs() < 1.5e-3, "{got} at {tilt}");
    }
}

/// Lobes of all kinds under a sky that varies, before a cone, against sums over directions.
#[test]
fn lobes_are_integrated() {
    let mut random = Random::new(15);
    let sky = |v: Vec3| Vec3::new(1.0 + v.y, 1.0 + (4.0 * v.x).sin() * 0.7, 2.0 + v.z.powi(3));
    let table = SkyTable::new(SkyResolution::new(128, 64), 256, sky);
    let mut sums = [[0.0; 2]; 3];
    for case in 0..60 {
        let normal = random.axis();
        let view = beside(&mut random, normal, 1.3);
        let at = Receiver::on_surface(Vec3::ZERO, normal.as_vec3(), view.as_vec3());
        let mirrored = (2.0 * normal.dot(view) * normal - view).as_vec3();
        let exponent = random.log_uniform(1.0, 45.0) as f32;
        let alpha = random.log_uniform(0.15, 0.9) as f32;
        let lobe: BrdfLobe = match case % 3 {
            0 => Lobe::with_flux(mirrored, exponent, Vec3::ONE).into(),
            1 => Lobe::with_flux(mirrored, exponent, Vec3::ONE).times_cosine().into(),
            _ => Microfacets::new(at.view, alpha, [Vec3::ONE; 2])[case / 3 % 2].into(),
        };
        assert!(SkyView::resolves(table.meridians().resolution(), &lobe));
        let axis = beside(&mut random, normal, 1.2).as_vec3();
        let cos = random.between(0.6, 0.95) as f32;
        let horizon = Horizon::new(&at, false);
        let mut seen = SkyView::default();
        seen.begin(&table, horizon);
        draw_cone(&mut seen, &table, &horizon, axis, cos);
        seen.settle(&table, false, |v| v.dot(axis) > cos);
        let got = seen.integrals(&table, &at, &lobe);
        let (mut want, n) = ([DVec3::ZERO; 2], 700);
        for k in 0..n * n {
            let (z, turn) = ((f64::from(k % n) + 0.5) / f64::from(n), f64::from(k / n) / f64::from(n));
            let v = random_direction(normal, z, core::f64::consts::TAU * turn).as_vec3();
            let value = (lobe.eval_at(at.normal, v) * sky(v)).as_dvec3() * core::f64::consts::TAU / f64::from(n * n);
            want[1] += value;
            want[0] += if v.dot(axis) > cos { DVec3::ZERO } else { value };
        }
        for k in 0..2 {
            let error = ((got[k].as_dvec3() - want[k]) / want[1]).abs().max_element();
            assert!(error < [0.03, 0.01][k], "case {case}, {lobe:?}: {got:?} for {want:?}");
            sums[case % 3][k] += error / 20.0;
        }
    }
    println!("mean errors of what is seen, and of all: {sums:.5?}");
    assert!(sums.as_flattened().iter().all(|error| *error < 4e-3), "{sums:?}");
}

/// A window is as if all arcs were drawn, also those beside it.
#[test]
fn windows_need_only_the_arcs_that_meet_them() {
    let mut random = Random::new(19);
    let table = uniform(SkyResolution::new(256, 128));
    let resolution = table.meridians().resolution();
    let mut partial = 0;
    for _ in 0..60 {
        let normal = random.axis();
        let at = Receiver::on_surface(Vec3::ZERO, normal.as_vec3(), normal.as_vec3());
        let horizon = Horizon::new(&at, false);
        let axis = beside(&mut random, normal, 1.2).as_vec3();
        let mut corner = || beside(&mut random, normal, 1.5).as_vec3();
        let triangles: Vec<[Vec3; 3]> = (0..8).map(|_| [corner(), corner(), corner()]).collect();
        let window = SkyWindow::around(resolution, horizon.pole().local(axis), 0.3);
        let blend = SkyBlend::of_level(&[SkyResolution::new(128, 64), resolution], 1, SkyHighlight::round(axis));
        let lobe = Lobe::new(axis, 600.0, Vec3::ONE).into();
        let [all, own] = [SkyWindow::whole(resolution), window].map(|drawn| {
            let mut view = SkyView::default();
            view.begin_in(&table, horizon, window);
            view.draw(&table, |buffer| {
                draw_arcs(&table, (&horizon, &drawn), &triangles, buffer);
                false
            });
            view.settle(&table, false, |v| triangles.iter().any(|corners| meets(v.as_dvec3(), corners)));
            view.integrals_of(&table, &at, &lobe, blend)
        });
        assert_eq!(own, all);
        partial += usize::from(own[0] != own[1] && own[0] != Vec3::ZERO);
    }
    assert!(partial > 10, "{partial}");
}

/// A direction by its height and azimuth about an axis.
pub(super) fn random_direction(axis: DVec3, z: f64, turn: f64) -> DVec3 {
    let (u, v) = axis.any_orthonormal_pair();
    axis * z + (u * turn.cos() + v * turn.sin()) * (1.0 - z * z).sqrt()
}

/// A sheet that covers everything is dark; a hole in it is as bright as it is large.
#[test]
fn closed_in_receivers_see_nothing() {
    let table = uniform(SkyResolution::new(64, 64));
    let at = Receiver::on_surface(Vec3::ZERO, Vec3::Y, Vec3::Y);
    let far = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)].map(|(x, z)| Vec3::new(x, -0.4, z) * 9.0);
    let top = Vec3::new(0.01, 5.0, -0.02);
    let tent: Vec<[Vec3; 3]> = (0..4).map(|k| [top, far[k], far[(k + 1) % 4]]).collect();
    assert_eq!(seen(&table, &at, false, &tent), 0.0);
    let open = seen(&table, &at, false, &tent[1..]);
    let want: f64 = {
        let horizon = Horizon::new(&at, false);
        let mut view = SkyView::default();
        view.begin(&table, horizon);
        view.draw(&table, |buffer| {
            draw(&table, &horizon, &tent[..1], buffer);
            false
        });
        view.settle(&table, false, |v| meets(v.as_dvec3(), &tent[0]));
        assert_eq!(view.coverage(), Coverage::Partial);
        1.0 - f64::from(view.integrals(&table, &at, &lambert(&at))[0].x)
    };
    assert!((open - want).abs() < 5e-3, "{open} for {want}");
}

/// Leaves that hide a part of the sky, many of them in one sample and before each other, leave as much as directions say that are tested one by one.
#[test]
fn leaves_before_leaves_hide_no_more_than_all_of_them() {
    let mut random = Random::new(41);
    let at = Receiver::on_surface(Vec3::ZERO, Vec3::Y, Vec3::Y);
    for (size, count, limit) in [(0.12, 200, 0.006), (0.12, 800, 0.012), (0.06, 3000, 0.012)] {
        let leaves: Vec<[Vec3; 3]> = (0..count)
            .map(|_| {
                let middle = beside(&mut random, DVec3::Y, 1.2);
                core::array::from_fn(|_| (middle + random.axis() * size).as_vec3())
            })
            .collect();
        // Of Lambert's lobe, by as many directions in each piece of an even grid.
        const SIDE: u32 = 150;
        let mut open = 0;
        for k in 0..SIDE * SIDE {
            let height_sq = (f64::from(k % SIDE) + random.uniform()) / f64::from(SIDE);
            let (sin, cos) =
                ((f64::from(k / SIDE) + random.uniform()) / f64::from(SIDE) * core::f64::consts::TAU).sin_cos();
            let across = (1.0 - height_sq).sqrt();
            let v = DVec3::new(across * cos, height_sq.sqrt(), across * sin);
            open += u32::from(!leaves.iter().any(|leaf| meets(v, leaf)));
        }
        let want = f64::from(open) / f64::from(SIDE * SIDE);
        let got = seen(&uniform(SkyResolution::new(64, 64)), &at, false, &leaves);
        println!("{count} leaves of {size}: {got:.4} for {want:.4}");
        assert!((got - want).abs() < limit, "{count} leaves of {size}: {got} for {want}");
    }
}
