use super::{Outline, outline_integral};
use crate::oracle::{CapMicrofacets, Random};
use crate::{Lobe, OWN_NONE, Receiver};
use core::f64::consts::{PI, TAU};
use glam::{DVec3, Vec3};

/// Largest errors, relative to what the light gives along the axis of a lobe of its size.
const WORST: f64 = 0.02;

/// A rectangle with a receiver at the origin, its normal up.
struct Case {
    corners: [DVec3; 4],
    axis: DVec3,
}

impl Case {
    fn random(random: &mut Random, size: f64, aspect: f64, crosses: bool) -> Option<Self> {
        let toward = random.axis();
        let normal = random.axis();
        let u = normal.any_orthonormal_vector();
        let v = normal.cross(u);
        let center = toward * random.between(1.0, 2.0);
        let [a, b] = [u * size, v * (size / aspect)];
        let corners = [center - a - b, center + a - b, center + a + b, center - a + b];
        let axis = if normal.dot(center) > 0.0 { normal } else { -normal };
        let [low, high] = corners.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], p| [l.min(p.z), h.max(p.z)]);
        let height = axis.dot(center);
        (height > 0.1 && high > 0.05 && (low < 0.0) == crosses).then_some(Self { corners, axis })
    }

    fn outline(&self) -> Outline {
        Outline::new(&self.corners.map(DVec3::as_vec3), self.axis.as_vec3()).expect("before its plane")
    }

    /// By Gauss's rule of three by three points, dividing what its quarters say otherwise of.
    fn integral(&self, f: &dyn Fn(DVec3) -> f64, finest: f64) -> f64 {
        let [a, b, _, d] = self.corners;
        self.divided(f, [a, b - a, d - a], finest, 0)
    }

    fn divided(&self, f: &dyn Fn(DVec3) -> f64, [from, u, v]: [DVec3; 3], finest: f64, depth: u32) -> f64 {
        let area = u.cross(v).length();
        let value = |s: f64, t: f64| {
            let p = from + u * s + v * t;
            let r = p.length();
            if p.z <= 0.0 { 0.0 } else { f(p / r) * self.axis.dot(p) / (r * r * r) * area }
        };
        // Gauss of three by three, and of its quarters.
        let rule = [(0.5 - 0.15f64.sqrt(), 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.5 + 0.15f64.sqrt(), 5.0 / 18.0)];
        let over = |s0: f64, t0: f64, side: f64| {
            rule.iter()
                .flat_map(|a| rule.iter().map(move |b| (a, b)))
                .map(|((s, ws), (t, wt))| ws * wt * value(s0 + side * s, t0 + side * t) * side * side)
                .sum::<f64>()
        };
        let whole = over(0.0, 0.0, 1.0);
        let parts: f64 = [(0.0, 0.0), (0.5, 0.0), (0.0, 0.5), (0.5, 0.5)].map(|(s, t)| over(s, t, 0.5)).iter().sum();
        if depth > 2 && (whole - parts).abs() < finest || depth > 12 {
            return parts;
        }
        let (u, v) = (0.5 * u, 0.5 * v);
        [from, from + u, from + v, from + u + v]
            .map(|from| self.divided(f, [from, u, v], finest, depth + 1))
            .iter()
            .sum()
    }
}

fn receiver(view: DVec3) -> Receiver {
    Receiver { position: Vec3::ZERO, normal: Vec3::Z, face: Vec3::Z, view: view.as_vec3(), object: OWN_NONE }
}

#[test]
fn irradiance_is_that_of_quadrature() {
    let mut random = Random::new(3);
    for crosses in [false, true] {
        for size in [2.0, 0.5, 0.1, 0.01, 1e-3] {
            let (mut worst, mut count) = (0.0_f64, 0);
            for _ in 0..400 {
                let Some(case) = Case::random(&mut random, size, 2.0, crosses) else { continue };
                let want = case.integral(&|v| v.z / PI, 1e-9 * size * size);
                let lobe = Lobe::new(Vec3::Z, 1.0, Vec3::ONE);
                let got = outline_integral(&receiver(DVec3::Z), &lobe, &case.outline());
                worst = worst.max((f64::from(got) - want).abs() / want.max(0.01 * size * size));
                count += 1;
            }
            println!("size {size}, crosses {crosses}: {count} cases, worst {worst:.1e}");
            assert!(worst < 4e-4, "{worst}");
        }
    }
}

#[test]
fn gloss_is_that_of_quadrature() {
    let mut random = Random::new(5);
    for crosses in [false, true] {
        for aspect in [1.0, 20.0] {
            for size in [1.0, 0.2, 0.02] {
                for e in [0.3, 5.0, 50.0, 500.0, 2e4] {
                    let (mut worst, mut mean, mut count) = (0.0_f64, 0.0, 0);
                    for k in 0..60 {
                        let Some(case) = Case::random(&mut random, size, aspect, crosses) else { continue };
                        // On the light, or beside it by a few widths.
                        let [a, _, c, _] = case.corners;
                        let aim = (a + (c - a) * random.between(0.0, 1.0)).normalize();
                        let beside = random.between(0.0, 2.0) / f64::sqrt(e + 1.0);
                        let axis = random.axis_at(aim, beside).normalize();
                        let lobe = Lobe::new(axis.as_vec3(), e as f32, Vec3::ONE);
                        let lobe = if k % 2 == 0 { lobe.times_cosine() } else { lobe };
                        let norm = (e + 1.0) / TAU;
                        let f = |v: DVec3| {
                            let cos = if k % 2 == 0 { v.z } else { 1.0 };
                            norm * axis.dot(v).max(0.0).powf(e) * cos
                        };
                        let solid = case.integral(&|_| 1.0, 1e-6 * size * size);
                        let scale = (solid * norm).min(1.0);
                        let want = case.integral(&f, 1e-6 * scale);
                        let got = outline_integral(&receiver(DVec3::Z), &lobe, &case.outline());
                        let error = (f64::from(got) - want).abs() / scale.max(1e-6);
                        worst = worst.max(error);
                        mean += error;
                        count += 1;
                    }
                    println!(
                        "e {e}, size {size}, aspect {aspect}, crosses {crosses}: {count} cases, mean {:.1e}, worst {worst:.1e}",
                        mean / f64::from(count.max(1))
                    );
                    assert!(worst < WORST, "{worst}");
                }
            }
        }
    }
}

#[test]
fn microfacets_are_those_of_quadrature() {
    let mut random = Random::new(7);
    for crosses in [false, true] {
        for size in [1.0, 0.2, 0.02] {
            for roughness in [0.1, 0.3, 0.6, 1.0] {
                let alpha: f64 = roughness * roughness;
                let (mut worst, mut mean, mut count) = (0.0_f64, 0.0, 0);
                for _ in 0..40 {
                    let Some(case) = Case::random(&mut random, size, 2.0, crosses) else { continue };
                    let [a, _, c, _] = case.corners;
                    let aim = (a + (c - a) * random.between(0.0, 1.0)).normalize();
                    let beside = random.between(0.0, 2.0) * alpha;
                    let axis = random.axis_at(aim, beside).normalize();
                    let view = DVec3::new(-axis.x, -axis.y, axis.z);
                    if view.z < 0.1 {
                        continue;
                    }
                    let shape = Turned::new(view, alpha);
                    let mirror = shape.value(axis)[0];
                    let solid = case.integral(&|_| 1.0, 1e-6 * size * size);
                    let lobes = Lobe::microfacets(view.as_vec3(), alpha as f32, [Vec3::ONE; 2]);
                    let scale = (mirror * solid).min(1.0);
                    let mut error = 0.0;
                    for (k, lobe) in lobes.iter().enumerate() {
                        let want = case.integral(&|v| shape.value(v)[k], 1e-6 * scale);
                        let got = outline_integral(&receiver(view), lobe, &case.outline());
                        error += (f64::from(got) - want).abs() / scale;
                    }
                    worst = worst.max(error);
                    mean += error;
                    count += 1;
                }
                println!(
                    "roughness {roughness}, size {size}, crosses {crosses}: {count} cases, mean {:.1e}, worst {worst:.1e}",
                    mean / f64::from(count.max(1))
                );
                assert!(worst < WORST, "{worst}");
            }
        }
    }
}

/// The oracle's microfacets look from the x–z plane.
struct Turned(CapMicrofacets);

impl Turned {
    fn new(view: DVec3, alpha: f64) -> Self {
        Self(CapMicrofacets { view, alpha })
    }
    fn value(&self, v: DVec3) -> [f64; 2] {
        self.0.value(v)
    }
}
