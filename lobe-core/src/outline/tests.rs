use super::{FlatShape, LightImage, Outline, image_integral, outline_integral};
use crate::oracle::{CapMicrofacets, Random};
use crate::{Lobe, Microfacets, Receiver, Sphere};
use core::f64::consts::{PI, TAU};
use glam::{DVec3, UVec2, Vec2, Vec3};

/// Largest errors, relative to what the light gives along the axis of a lobe of its size.
const WORST: f64 = 0.02;

/// A rectangle with a receiver at the origin, its normal up.
pub(super) struct Case {
    pub(super) corners: [DVec3; 4],
    pub(super) axis: DVec3,
}

impl Case {
    pub(super) fn random(random: &mut Random, size: f64, aspect: f64, crosses: bool) -> Option<Self> {
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

    pub(super) fn outline(&self) -> Outline {
        Outline::new(&self.corners.map(DVec3::as_vec3), self.axis.as_vec3()).expect("before its plane")
    }

    /// By Gauss's rule of three by three points, dividing what its quarters say otherwise of.
    pub(super) fn integral(&self, f: &dyn Fn(DVec3) -> f64, finest: f64) -> f64 {
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
    Receiver::on_surface(Vec3::ZERO, Vec3::Z, view.as_vec3())
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
                let got = outline_integral(&receiver(DVec3::Z), lobe, &case.outline());
                worst = worst.max((f64::from(got) - want).abs() / want.max(0.01 * size * size));
                count += 1;
            }
            println!("size {size}, crosses {crosses}: {count} cases, worst {worst:.1e}");
            assert!(worst < 3e-4, "{worst}");
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
                        let got = outline_integral(&receiver(DVec3::Z), lobe, &case.outline());
                        let error = (f64::from(got) - want).abs() / scale.max(1e-6);
                        worst = worst.max(error);
                        mean += error;
                        count += 1;
                    }
                    println!(
                        "e {e}, size {size}, aspect {aspect}, crosses {crosses}: {count} cases, mean {:.1e}, worst {worst:.1e}",
                        mean / f64::from(count.max(1))
                    );
                    assert!(mean <= 8e-4 * f64::from(count) && worst < WORST, "{mean} {worst}");
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
                    let lobes = Microfacets::new(view.as_vec3(), alpha as f32, [Vec3::ONE; 2]);
                    let scale = (mirror * solid).min(1.0);
                    let mut error = 0.0;
                    for (k, lobe) in lobes.into_iter().enumerate() {
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
                assert!(mean <= 2.5e-3 * f64::from(count) && worst < 0.016, "{mean} {worst}");
            }
        }
    }
}

/// The oracle's microfacets look from the x–z plane.
pub(super) struct Turned(CapMicrofacets);

impl Turned {
    pub(super) fn new(view: DVec3, alpha: f64) -> Self {
        Self(CapMicrofacets { view, alpha })
    }
    pub(super) fn value(&self, v: DVec3) -> [f64; 2] {
        self.0.value(v)
    }
}

/// A bright and a dark side, waves, and small grain.
fn picture(random: &mut Random) -> LightImage {
    const SIDE: u32 = 64;
    let [tilt, phase] = [random.between(0.0, TAU), random.between(0.0, TAU)];
    let texels: Vec<Vec3> = (0..SIDE * SIDE)
        .map(|k| {
            let [x, y] = [k % SIDE, k / SIDE].map(|k| f64::from(2 * k + 1) / f64::from(SIDE) - 1.0);
            let along = x * tilt.cos() + y * tilt.sin();
            let wave = 1.0 + 0.5 * (5.0 * x + phase).sin() * (4.0 * y).cos();
            DVec3::new(1.5 + along, wave, 0.5 + random.uniform()).as_vec3()
        })
        .collect();
    LightImage::new(UVec2::splat(SIDE), &texels).expect("an image").0
}

#[test]
fn images_are_those_of_quadrature() {
    const N: i32 = 160;
    let mut random = Random::new(11);
    for crosses in [false, true] {
        for size in [1.0, 0.3, 0.05] {
            for exponent in [1.0, 5.0, 50.0, 500.0] {
                let (mut worst, mut mean, mut count) = (0.0_f64, 0.0, 0);
                for _ in 0..40 {
                    let Some(case) = Case::random(&mut random, size, 1.0, crosses) else { continue };
                    let [a, b, c, d] = case.corners;
                    let aim = (a + (c - a) * random.between(0.0, 1.0)).normalize();
                    let lobe = match exponent {
                        1.0 => Lobe::new(Vec3::Z, 1.0, Vec3::ONE),
                        e => Lobe::new(aim.as_vec3().normalize(), e as f32, Vec3::ONE),
                    };
                    let image = picture(&mut random);
                    let (u, v) = (0.5 * (b - a), 0.5 * (d - a));
                    let outline = case.outline().with_sides([u, v].map(DVec3::as_vec3));
                    let axis = lobe.axis.as_dvec3();
                    let (mut want, mut alone, mut solid) = (DVec3::ZERO, 0.0, 0.0);
                    for k in 0..N * N {
                        let [s, t] = [k % N, k / N].map(|k| f64::from(2 * k + 1) / f64::from(N) - 1.0);
                        let p = 0.5 * (a + c) + u * s + v * t;
                        let r = p.length();
                        solid += case.axis.dot(p) / (r * r * r);
                        if p.z > 0.0 {
                            let w = (axis.dot(p) / r).max(0.0).powf(exponent) * case.axis.dot(p) / (r * r * r);
                            want += w * image.at(Vec2::new(s as f32, t as f32), 0.0).as_dvec3();
                            alone += w;
                        }
                    }
                    let norm = (exponent + 1.0) / TAU * 4.0 * u.cross(v).length() / f64::from(N * N);
                    let got = image_integral(&receiver(DVec3::Z), lobe, &outline, &image).as_dvec3();
                    let scale = norm * alone.max(0.1 * solid);
                    let error = (got - want * norm).abs().max_element() / scale;
                    worst = worst.max(error);
                    mean += error;
                    count += 1;
                }
                println!(
                    "e {exponent}, size {size}, crosses {crosses}: {count} cases, mean {:.1e}, worst {worst:.1e}",
                    mean / f64::from(count.max(1))
                );
                let most = if crosses { 5e-3 } else { 1.2e-3 };
                assert!(mean <= most * f64::from(count) && worst < WORST, "{mean} {worst}");
            }
        }
    }
}

/// A dark screen with a bright window, in a glossy floor: most of what a place beside the window's reflection receives is from the highlight's tail.
#[test]
fn microfacets_see_what_is_bright_beside_the_mirror() {
    const SIDE: u32 = 64;
    let texels = (0..SIDE * SIDE).map(|k| {
        let is_bright = (15..35).contains(&(k % SIDE)) && (20..45).contains(&(k / SIDE));
        Vec3::splat(if is_bright { 6.0 } else { 0.01 })
    });
    let (image, _) = LightImage::new(UVec2::splat(SIDE), &texels.collect::<Vec<_>>()).expect("an image");
    let mut random = Random::new(29);
    for roughness in [0.2, 0.4] {
        let alpha: f64 = roughness * roughness;
        let (mut worst, mut mean, mut count) = (0.0_f64, 0.0, 0);
        for _ in 0..240 {
            let Some(case) = Case::random(&mut random, 1.0, 1.0, false) else { continue };
            let [a, b, c, d] = case.corners;
            let (middle, u, v) = (0.5 * (a + c), 0.5 * (b - a), 0.5 * (d - a));
            let aim = middle + u * random.between(-1.0, 1.0) + v * random.between(-1.0, 1.0);
            let axis = aim.normalize();
            let view = DVec3::new(-axis.x, -axis.y, axis.z);
            if view.z < 0.1 {
                continue;
            }
            let shape = Turned::new(view, alpha);
            let shown = |to: DVec3| {
                let away = to * (case.axis.dot(middle) / case.axis.dot(to)) - middle;
                let place = DVec3::new(away.dot(u) / u.length_squared(), away.dot(v) / v.length_squared(), 0.0);
                f64::from(image.at(place.truncate().as_vec2(), 0.0).x)
            };
            let finest = 1e-6 * shape.value(axis)[0].min(1.0);
            let want = case.integral(&|to| shape.value(to)[0] * shown(to), finest);
            let [lobe, _] = Microfacets::new(view.as_vec3(), alpha as f32, [Vec3::ONE; 2]);
            let outline = case.outline().with_sides([u, v].map(DVec3::as_vec3));
            let got = f64::from(image_integral(&receiver(view), lobe, &outline, &image).x);
            let error = (got / want - 1.0).abs();
            worst = worst.max(error);
            mean += error;
            count += 1;
        }
        println!("roughness {roughness}: {count} cases, mean {:.1e}, worst {worst:.1e}", mean / f64::from(count));
        assert!(count > 30 && mean <= 0.025 * f64::from(count) && worst < 0.12, "{mean} {worst}");
    }
}

/// Cut by the same horizon twice: rounding may leave two corners in one place, and no side between them.
#[test]
fn a_horizon_through_a_corner_takes_nothing_else() {
    let corners = [[-34.0, 34.0, 34.0], [34.0, 34.0, 34.0], [34.0, 34.0, -34.0], [-34.0, 34.0, -34.0]];
    let light = Outline::new(&corners.map(Vec3::from_array), Vec3::Y).expect("before its plane");
    let view = Vec3::new(0.258_452_4, 0.072_847_46, 0.963_273_4);
    let [lobe, _] = Microfacets::new(view, 0.01, [Vec3::ONE; 2]);
    let mut random = Random::new(17);
    for k in 0..2000 {
        let normal = (DVec3::new(0.15, 0.62, 0.77) + random.axis() * 0.1).as_vec3().normalize();
        let at = Receiver::on_surface(Vec3::ZERO, normal, view);
        let once = outline_integral(&at, lobe, &light);
        let twice = light.above(normal).map_or(0.0, |light| outline_integral(&at, lobe, &light));
        assert!((once - twice).abs() < 1e-3, "{k}: {once} {twice}, {normal}");
    }
}

/// Places on a light, as rounding leaves them before its plane or behind it, see nothing of the light.
#[test]
fn a_light_on_both_sides_does_not_light_itself() {
    let mut random = Random::new(5);
    for _ in 0..300 {
        let (center, u) =
            (random.axis() * random.log_uniform(0.1, 1e3), random.axis() * random.log_uniform(0.1, 100.0));
        let v = u.cross(random.axis());
        let corners = [center - u - v, center + u - v, center + u + v, center - u + v].map(DVec3::as_vec3);
        let normal = u.cross(v).normalize();
        let radius = (u.length() + v.length()) as f32;
        let light = FlatShape::polygon(&corners, normal.as_vec3(), Sphere { center: center.as_vec3(), radius }, 0.5);
        for _ in 0..20 {
            let place = center + u * random.between(-1.0, 1.0) + v * random.between(-1.0, 1.0);
            assert!(light.seen_from(place.as_vec3(), true, Vec3::ONE).outline.is_none(), "{corners:?} {place}");
            for side in [-1e-3, 1e-3] {
                let before = (place + normal * (side * (center.length() + u.length() + v.length()))).as_vec3();
                assert!(light.seen_from(before, true, Vec3::ONE).outline.is_some(), "{corners:?} {before}");
            }
        }
    }
}

/// Ramps, an edge and stripes on a screen. A floor near their plane sees little of what is bright at the top.
#[test]
fn screens_beside_a_floor_are_those_of_quadrature() {
    const SIDE: u32 = 64;
    const N: i32 = 256;
    type Picture = fn(f64, f64) -> f64;
    let pictures: [(&str, Picture); 6] = [
        ("bright above", |_, y| (0.5 + 0.5 * y).powf(2.2)),
        ("bright below", |_, y| (0.5 - 0.5 * y).powf(2.2)),
        ("bright to the right", |x, _| (0.5 + 0.5 * x).powf(2.2)),
        ("a bar", |_, y| f64::from(y > 0.5)),
        ("an edge", |x, _| f64::from(x > 0.0)),
        ("stripes", |x, _| f64::from((x * 8.0).rem_euclid(2.0) < 1.0)),
    ];
    let (u, v, toward) = (DVec3::X * 1.2, DVec3::NEG_Z * 0.65, DVec3::Y);
    for (name, picture) in pictures {
        let texels = (0..SIDE * SIDE).map(|k| {
            let [x, y] = [k % SIDE, k / SIDE].map(|k| f64::from(2 * k + 1) / f64::from(SIDE) - 1.0);
            Vec3::splat(picture(x, -y) as f32)
        });
        let (image, _) = LightImage::new(UVec2::splat(SIDE), &texels.collect::<Vec<_>>()).expect("an image");
        for exponent in [0.5, 1.0, 3.0] {
            let mut random = Random::new(5);
            let (mut worst, mut mean, mut count) = (0.0_f64, 0.0, 0);
            for _ in 0..40 {
                let middle = DVec3::new(random.between(-1.5, 1.5), random.between(0.05, 3.0), 0.7);
                let corners = [-u - v, u - v, u + v, v - u].map(|p| (middle + p).as_vec3());
                let sides = [u, v].map(DVec3::as_vec3);
                let outline = Outline::new(&corners, toward.as_vec3()).expect("before its plane").with_sides(sides);
                let aside = random.axis() * if exponent == 1.0 { 0.0 } else { 0.5 };
                let axis = (DVec3::Z + aside).normalize();
                let lobe = Lobe::new(axis.as_vec3().normalize(), exponent as f32, Vec3::ONE);
                let (mut want, mut all) = (0.0, 0.0);
                for k in 0..N * N {
                    let [s, t] = [k % N, k / N].map(|k| f64::from(2 * k + 1) / f64::from(N) - 1.0);
                    let p = middle + u * s + v * t;
                    let r = p.length();
                    if p.z > 0.0 {
                        let w = (axis.dot(p) / r).max(0.0).powf(exponent) * toward.dot(p) / (r * r * r);
                        want += w * f64::from(image.at(Vec2::new(s as f32, t as f32), 0.0).x);
                        all += w;
                    }
                }
                if want < 0.05 * all {
                    continue;
                }
                let norm = (exponent + 1.0) / TAU * 4.0 * u.cross(v).length() / f64::from(N * N);
                let got = f64::from(image_integral(&receiver(DVec3::Z), lobe, &outline, &image).x);
                let error = (got / (want * norm) - 1.0).abs();
                worst = worst.max(error);
                mean += error;
                count += 1;
            }
            println!("{name}, e {exponent}: {count} cases, mean {:.1e}, worst {worst:.1e}", mean / f64::from(count));
            let limit = if exponent == 1.0 { 0.015 } else { 0.07 };
            let is_near = mean < 0.004 * f64::from(count) && worst < limit;
            assert!(count > 20 && is_near, "{name} {exponent}: {mean} {worst}");
        }
    }
}
