use crate::oracle::Random;
use crate::outline::tests::{Case, Turned};
use crate::{BrdfLobe, FlatShape, Grain, Lobe, Microfacets, Outline, PackedLobe, Receiver, Sphere};
use crate::{Tile, TileLight, TileLobes, cap_integrals, lanes::set_row, outline_integral};
use core::f64::consts::TAU;
use glam::{DVec3, Vec3};

/// Sides' ratio and size of rectangles at a distance of 1 to 2.
const RECTANGLES: [(f64, f64); 5] = [(1.0, 1.0), (1.0, 0.3), (4.0, 0.5), (20.0, 0.5), (2.0, 0.02)];

/// The integrals of lobes of one receiver at the origin, its normal up, by a tile.
fn by_tile(shape: &FlatShape, lobes: &[BrdfLobe]) -> Vec<f32> {
    let (mut tile, mut light, mut all, mut out) =
        (Tile::default(), TileLight::default(), TileLobes::default(), Vec::new());
    tile.set(&[Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::Z)]);
    light.flat(&tile, shape, true, Vec3::ONE);
    all.reset(&tile, lobes.len());
    for (place, lobe) in lobes.iter().enumerate() {
        let row = bytemuck::cast(PackedLobe::from(*lobe));
        (0..16).for_each(|j| set_row(all.block_mut(place, 0), j, &row));
    }
    cap_integrals(&light, &all, &mut out);
    out.into_iter().step_by(16).collect()
}

fn shape(case: &Case) -> FlatShape {
    let corners = case.corners.map(DVec3::as_vec3);
    let center = 0.25 * corners.iter().sum::<Vec3>();
    FlatShape::polygon(&corners, -case.axis.as_vec3(), Sphere { center, radius: corners[0].distance(center) }, 0.5)
}

/// Errors of own values, of those that are at least a thousandth of what the light gives where the lobe is largest.
#[derive(Default)]
struct Errors {
    all: Vec<f64>,
    by_grid: usize,
}

impl Errors {
    fn add(&mut self, by_tile: f32, alone: f32, want: f64, scale: f64) {
        self.by_grid += usize::from(by_tile != alone);
        self.all.extend([by_tile, alone].map(|got| (f64::from(got) - want).abs() / want.max(1e-3 * scale)));
    }

    fn check(&self, of: &str, limits: [f64; 2]) {
        let (count, worst) = (self.all.len(), self.all.iter().fold(0.0_f64, |worst, error| worst.max(*error)));
        let mean = self.all.iter().sum::<f64>() / count as f64;
        println!("{of}: {} cases, {} by a grid, mean {mean:.1e}, worst {worst:.1e}", count / 2, self.by_grid);
        assert!(mean < limits[0] && worst < limits[1], "{of}: {mean} {worst}");
    }
}

#[test]
fn powers_are_those_of_quadrature() {
    let mut random = Random::new(31);
    for (aspect, size) in RECTANGLES {
        for e in [0.3, 2.0, 5.0, 50.0, 500.0, 2e4] {
            let mut errors = Errors::default();
            for k in 0..100 {
                let Some(case) = Case::random(&mut random, size, aspect, false) else { continue };
                let [a, _, c, _] = case.corners;
                let aim = (a + (c - a) * random.uniform()).normalize();
                let beside = random.between(0.0, 4.0) / f64::sqrt(e + 1.0);
                let axis = random.axis_at(aim, beside).normalize();
                let lobe = Lobe::new(axis.as_vec3(), e as f32, Vec3::ONE);
                let lobe = if k % 2 == 0 { lobe.times_cosine() } else { lobe };
                let norm = (e + 1.0) / TAU;
                let cos = |v: DVec3| if k % 2 == 0 { v.z } else { 1.0 };
                let f = |v: DVec3| norm * axis.dot(v).max(0.0).powf(e) * cos(v);
                let scale = (case.integral(&|_| 1.0, 1e-6 * size * size) * norm).min(1.0);
                let want = case.integral(&f, 1e-8 * scale);
                let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::Z);
                let alone = outline_integral(&at, lobe, &case.outline());
                errors.add(by_tile(&shape(&case), &[lobe.into()])[0], alone, want, scale);
            }
            // Those that end at their horizon there are less smooth.
            let limits = if e <= 5.0 { [1e-3, 0.03] } else { [2e-4, 4e-3] };
            errors.check(&format!("aspect {aspect}, size {size}, exponent {e}"), limits);
        }
    }
}

#[test]
fn microfacets_are_those_of_quadrature() {
    let mut random = Random::new(32);
    for (aspect, size) in RECTANGLES {
        for roughness in [0.1, 0.3, 0.5, 1.0] {
            let alpha: f64 = roughness * roughness;
            let mut errors = Errors::default();
            for _ in 0..100 {
                let Some(case) = Case::random(&mut random, size, aspect, false) else { continue };
                let [a, _, c, _] = case.corners;
                let aim = (a + (c - a) * random.uniform()).normalize();
                let beside = random.between(0.0, 8.0) * alpha;
                let axis = random.axis_at(aim, beside).normalize();
                let view = DVec3::new(-axis.x, -axis.y, axis.z);
                if view.z < 0.05 {
                    continue;
                }
                let facets = Turned::new(view, alpha);
                let solid = case.integral(&|_| 1.0, 1e-6 * size * size);
                let lobes = Microfacets::new(view.as_vec3(), alpha as f32, [Vec3::ONE; 2]);
                let scale = (facets.value(axis)[0] * solid).min(1.0);
                let want = [0, 1].map(|k| case.integral(&|v| facets.value(v)[k], 1e-8 * scale));
                let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, view.as_vec3());
                let alone = lobes.map(|lobe| outline_integral(&at, lobe, &case.outline()));
                let got = by_tile(&shape(&case), &lobes.map(BrdfLobe::from));
                errors.add(got[0], alone[0], want[0], scale);
                errors.add(got[0] + got[1], alone[0] + alone[1], want[0] + want[1], scale);
            }
            errors.check(&format!("aspect {aspect}, size {size}, roughness {roughness}"), [5e-5, 1e-3]);
        }
    }
}

/// Microfacets with a grain, against sums of their own values.
#[test]
fn brushed_microfacets_are_those_of_quadrature() {
    let mut random = Random::new(35);
    for (aspect, size) in [(1.0, 0.3), (4.0, 0.5)] {
        let mut errors = Errors::default();
        for _ in 0..200 {
            let Some(case) = Case::random(&mut random, size, aspect, false) else { continue };
            let [a, _, c, _] = case.corners;
            let aim = (a + (c - a) * random.uniform()).normalize();
            let beside = random.between(0.0, 0.5);
            let axis = random.axis_at(aim, beside).normalize();
            let view = DVec3::new(-axis.x, -axis.y, axis.z).as_vec3();
            if view.z < 0.05 {
                continue;
            }
            let grain = Grain::new(Vec3::Z, view, random.axis().as_vec3(), random.uniform() as f32);
            let alpha = random.log_uniform(0.04, 0.5) as f32;
            let lobe = Microfacets::new(view, alpha, [Vec3::ONE; 2])[0].with_grain(Some(grain));
            let value = |v: DVec3| f64::from(lobe.value(Vec3::Z, v.as_vec3()));
            let scale = (value(axis) * case.integral(&|_| 1.0, 1e-6 * size * size)).min(1.0);
            let want = case.integral(&value, 1e-7 * scale);
            let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, view);
            let alone = outline_integral(&at, lobe, &case.outline());
            errors.add(by_tile(&shape(&case), &[lobe.into()])[0], alone, want, scale);
        }
        errors.check(&format!("brushed, aspect {aspect}, size {size}"), [1e-4, 2e-3]);
    }
}

/// Discs are as large as the polygons of 24 corners with the same area, and of nearly the same shape.
#[test]
fn discs_are_those_of_polygons() {
    let mut random = Random::new(33);
    let mut errors = Errors::default();
    for k in 0..300 {
        let size = [1.0, 0.3, 0.02][k % 3];
        let Some(case) = Case::random(&mut random, size, 1.0, false) else { continue };
        let square = case.corners.map(DVec3::as_vec3);
        let (center, axis) = (0.5 * (square[0] + square[2]), case.axis.as_vec3());
        let [u, v] = [0.5 * (square[1] - square[0]), 0.5 * (square[3] - square[0])];
        let bounds = Sphere { center, radius: u.length() };
        let disc = FlatShape::polygon(&square, -axis, bounds, 0.5).with_disc(bounds, -axis);
        let angle = core::f32::consts::PI / Outline::MOST as f32;
        let reach = (angle / (angle.sin() * angle.cos())).sqrt();
        let corners: [Vec3; Outline::MOST] = core::array::from_fn(|k| {
            let (sin, cos) = (2.0 * angle * k as f32).sin_cos();
            center + (u * cos + v * sin) * reach
        });
        let polygon = Outline::new(&corners, axis).expect("before its plane");
        let aim = center.as_dvec3().normalize();
        let beside = random.between(0.0, 0.5);
        let mirror = random.axis_at(aim, beside).normalize().as_vec3();
        let view = Vec3::new(-mirror.x, -mirror.y, mirror.z);
        if view.z < 0.1 {
            continue;
        }
        let [base, _] = Microfacets::new(view, 0.25, [Vec3::ONE; 2]);
        let power = Lobe::new(mirror, 20.0, Vec3::ONE).times_cosine();
        let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, view);
        for lobe in [BrdfLobe::from(base), power.into()] {
            let want = f64::from(outline_integral(&at, lobe, &polygon));
            let got = by_tile(&disc, &[lobe])[0];
            errors.add(got, got, want, 0.0);
        }
    }
    errors.check("discs", [1e-3, 5e-3]);
}

/// Corners along the sides of a rectangle change nothing.
#[test]
fn polygons_of_many_corners_are_those_of_few() {
    let mut random = Random::new(34);
    for _ in 0..100 {
        let Some(case) = Case::random(&mut random, 0.4, 3.0, false) else { continue };
        let mut corners = Vec::new();
        for k in 0..4 {
            let (from, to) = (case.corners[k], case.corners[(k + 1) % 4]);
            let more = random.bits() % 6;
            corners.extend((0..=more).map(|j| from.lerp(to, j as f64 / (more + 1) as f64).as_vec3()));
        }
        let many = Outline::new(&corners, case.axis.as_vec3()).expect("before its plane");
        let mirror = (case.corners[0] + case.corners[1] + case.corners[2]).normalize().as_vec3();
        let view = Vec3::new(-mirror.x, -mirror.y, mirror.z.max(0.1)).normalize();
        let [base, _] = Microfacets::new(view, 0.02, [Vec3::ONE; 2]);
        let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, view);
        for lobe in [BrdfLobe::from(base), Lobe::new(mirror, 300.0, Vec3::ONE).into()] {
            let (got, want) = (outline_integral(&at, lobe, &many), outline_integral(&at, lobe, &case.outline()));
            assert!((got - want).abs() < 1e-3 * want.max(1e-4), "{got} for {want}, {} corners", corners.len());
        }
    }
}
