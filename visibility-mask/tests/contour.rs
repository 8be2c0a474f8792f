//! Masks from tests of "is the light hidden in this direction?" against known areas.

use conformance::{Limits, Setting, check};
use glam::{DVec2, Vec2, Vec3};
use lobe_core::oracle::Random;
use lobe_core::{Cone, Sphere};
use shading::{Coverage, VisibilityQuery};
use visibility_mask::{Blockers, Contour, Mask, MaskVisibility, UnitSquare};

fn square(half_angle: f32) -> UnitSquare {
    let one_minus_cos = 2.0 * (0.5 * half_angle).sin().powi(2);
    UnitSquare::facing(&Cone { axis: Vec3::Z, one_minus_cos, distance: 10.0 }, Vec3::X)
}

/// Blocks the directions whose points on the plane are in a shape; returns the hidden fraction and the number of tests.
fn dark(square: &UnitSquare, depth: u32, shape: impl Fn(Vec2) -> bool) -> (f64, usize) {
    let mut mask = Mask::default();
    mask.reset(square, depth, Vec3::Z);
    let mut contour = Contour::default();
    let asked = contour.block(&mut mask, |v| {
        let v = square.local(v);
        assert!(v.truncate().length() <= 1.000_01 * square.disc * v.z, "asked outside of the light");
        shape(v.truncate() / (v.z * square.disc))
    });
    let (whole, lit) = mask.areas();
    (1.0 - f64::from(lit) / f64::from(whole), asked)
}

#[test]
fn nothing_and_everything() {
    for depth in 1..=6 {
        let (share, asked) = dark(&square(0.1), depth, |_| false);
        assert_eq!(share, 0.0);
        assert!(asked <= 140, "{asked} questions about nothing");
        assert_eq!(dark(&square(0.1), depth, |_| true).0, 1.0);
    }
}

/// A wide light through an opening that the coarse grid misses; a narrow one is left dark there.
#[test]
fn wide_lights_are_seen_through_small_openings() {
    let mut random = Random::new(5);
    for radius in [0.03, 0.05, 0.1] {
        let (mut sum, mut missed) = (0.0, 0);
        for _ in 0..200 {
            let middle = DVec2::from_angle(random.uniform() * core::f64::consts::TAU) * (0.8 * random.uniform().sqrt());
            let (share, asked) = dark(&square(0.8), 5, |p| p.as_dvec2().distance(middle) > radius);
            assert!(asked < 1000, "{asked}");
            sum += (1.0 - share) / 200.0;
            missed += usize::from(share == 1.0);
        }
        let want = radius * radius;
        println!("{radius}: lit {sum:.5} for {want:.5}, missed {missed}");
        // An opening of less than a cell may lie between four of them.
        assert!(if radius > 0.04 { missed == 0 } else { missed < 60 });
        assert!((sum / want - 1.0).abs() < if radius > 0.04 { 0.1 } else { 0.5 }, "{radius}: {sum} for {want}");
    }
}

/// Half-planes at all angles and offsets; the segment of a disc beyond `c` radii is (acos c − c√(1 − c²))/π of it.
#[test]
fn half_planes() {
    let mut random = Random::new(3);
    for (depth, mean_limit, worst_limit) in [(4, 0.002, 0.012), (5, 0.0008, 0.006), (6, 0.0004, 0.003)] {
        let (mut mean, mut worst, mut questions) = (0.0, 0.0_f64, 0);
        for i in 0..400 {
            // One in four runs along the rows or columns.
            let angle = if i % 4 == 0 { (random.bits() % 4) as f64 * 0.25 } else { random.uniform() };
            let (sin, cos) = (angle * core::f64::consts::TAU).sin_cos();
            let n = Vec2::new(cos as f32, sin as f32);
            let c = random.between(-1.0, 1.0);
            let want = (c.acos() - c * (1.0 - c * c).sqrt()) / core::f64::consts::PI;
            let (got, asked) = dark(&square(0.05), depth, |p| n.dot(p) > c as f32);
            mean += (got - want).abs() / 400.0;
            worst = worst.max((got - want).abs());
            questions += asked;
        }
        println!("depth {depth}: mean {mean:.5}, worst {worst:.5}, {} questions", questions / 400);
        assert!(mean < mean_limit && worst < worst_limit, "depth {depth}: mean {mean}, worst {worst}");
        assert!(questions / 400 < 80 << (depth - 3), "{}", questions / 400);
    }
}

/// The fraction of a disc of radius 1 that another disc, whose centre is `d` away, covers.
fn overlap(r: f64, d: f64) -> f64 {
    if d >= 1.0 + r {
        return 0.0;
    }
    if d <= (1.0 - r).abs() {
        return r.min(1.0).powi(2);
    }
    let a = ((d * d + 1.0 - r * r) / (2.0 * d)).clamp(-1.0, 1.0).acos();
    let b = ((d * d + r * r - 1.0) / (2.0 * d * r)).clamp(-1.0, 1.0).acos();
    (a - a.sin() * a.cos() + r * r * (b - b.sin() * b.cos())) / core::f64::consts::PI
}

/// Discs in front of the light that move by a hundredth of its radius, 40 times: from a third of its size to nearly straight edges,
/// and rings and crescents about as large as it.
#[test]
fn discs_that_move() {
    for (depth, limits) in [(4, [0.0025, 0.015, 0.016]), (5, [0.001, 0.006, 0.005]), (6, [0.0005, 0.003, 0.003])] {
        for [low, high] in [[0.3, 0.8], [0.95, 1.05], [0.8, 1.25], [1.25, 3.0], [10.0, 100.0]] {
            let mut random = Random::new(11);
            let (mut mean, mut count, mut worst, mut jump, mut questions) = (0.0, 0.0, 0.0_f64, 0.0_f64, 0);
            for _ in 0..50 {
                let r = random.between(low, high);
                let axis = |angle: f64| DVec2::from_angle(angle * core::f64::consts::TAU);
                let (start, along) = (axis(random.uniform()), axis(random.uniform()));
                let away = if high == 1.05 { 0.0..0.15 } else { f64::max(r - 1.0, 0.0)..r + 1.0 };
                let start = start * random.between(away.start, away.end);
                let mut last = None;
                for step in 0..40 {
                    let center = start + along * (0.01 * f64::from(step));
                    let want = overlap(r, center.length());
                    let (got, asked) = dark(&square(0.05), depth, |p| p.as_dvec2().distance_squared(center) < r * r);
                    let error = got - want;
                    mean += error.abs();
                    worst = worst.max(error.abs());
                    jump = jump.max(last.map_or(0.0, |last: f64| (error - last).abs()));
                    (count, questions, last) = (count + 1.0, questions + asked, Some(error));
                }
            }
            mean /= count;
            let said = format!("depth {depth}, radii {low}..{high}: mean {mean:.5}, worst {worst:.5}, jump {jump:.5}");
            println!("{said}, {:.0} questions", questions as f64 / count);
            assert!(mean < limits[0] && worst < limits[1] && jump < limits[2], "{said}");
        }
    }
}

/// Bars of a few cells, also if the coarse grid hits them only in places.
#[test]
fn thin_bars() {
    let mut random = Random::new(8);
    let mut mean = 0.0;
    for _ in 0..200 {
        let (sin, cos) = (random.uniform() * core::f64::consts::TAU).sin_cos();
        let n = Vec2::new(cos as f32, sin as f32);
        let segment = |c: f64| (c.acos() - c * (1.0 - c * c).sqrt()) / core::f64::consts::PI;
        let (c, width) = (random.between(-0.8, 0.6), random.between(0.07, 0.3));
        let want = segment(c) - segment((c + width).min(1.0));
        let (got, _) = dark(&square(0.05), 5, |p| (c as f32..(c + width) as f32).contains(&n.dot(p)));
        mean += (got - want).abs() / 200.0;
        assert!((got - want).abs() < 0.02, "a bar {width} wide at {c}, {n}: {got} for {want}");
    }
    assert!(mean < 0.003, "{mean}");
}

/// A strategy as a user would write it: spheres that only test whether they hide a direction.
struct Spheres(Vec<Sphere>);

impl Blockers for Spheres {
    type Scratch = Contour;

    fn scratch(&self) -> Contour {
        Contour::default()
    }

    fn select(&self, _: &VisibilityQuery<'_>, _: &mut Contour) -> Coverage {
        if self.0.is_empty() { Coverage::Lit } else { Coverage::Partial }
    }

    fn splat(&self, query: &VisibilityQuery<'_>, contour: &mut Contour, mask: &mut Mask) {
        let light = query.cone.distance * query.cone.cos();
        contour.block(mask, |v| {
            self.0.iter().any(|sphere| {
                let to = sphere.center - query.at.position;
                let along = to.dot(v);
                let half_sq = sphere.radius * sphere.radius - (to - v * along).length_squared();
                half_sq > 0.0 && along > 0.0 && along - half_sq.sqrt() < light
            })
        });
    }
}

#[test]
fn a_strategy_of_questions_conforms() {
    let subject = |s: &Setting<'_>| MaskVisibility::new(Spheres(s.spheres.to_vec()));
    let limits = Limits { several_mean: 0.001, several: 0.01, turn: 0.005, jump: 0.0035, ..Limits::default() };
    let measured = check(&subject, &limits).unwrap_or_else(|e| panic!("{e}"));
    println!("{measured:?}");
}
