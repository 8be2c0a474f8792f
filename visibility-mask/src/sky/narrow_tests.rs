//! Lobes that the first table does not resolve, as sums over several: against sums of many directions about their highlights.

use super::tests::{beside, draw_cone, random_direction};
use super::{Horizon, SkyBlend, SkyHighlight, SkyResolution, SkyTable, SkyView, SkyWindow};
use glam::{DVec3, Vec3};
use lobe_core::oracle::Random;
use lobe_core::{BrdfLobe, Grain, Lobe, Microfacets, Receiver};

/// Tables of one sky, each of smaller steps than the one before, and a view for each.
struct Tables {
    tables: Vec<SkyTable>,
    resolutions: Vec<SkyResolution>,
    views: Vec<SkyView>,
}

impl Tables {
    fn new(sky: impl Fn(Vec3) -> Vec3 + Sync) -> Self {
        let all = core::iter::successors(Some(SkyResolution::new(64, 64)), |last| last.finer());
        let tables: Vec<SkyTable> = all.map(|resolution| SkyTable::new(resolution, 256, &sky)).collect();
        let resolutions: Vec<SkyResolution> = tables.iter().map(|table| table.meridians().resolution()).collect();
        let steps = |resolution: &SkyResolution| (resolution.rows(), resolution.lines(), resolution.samples());
        let steps: Vec<_> = resolutions.iter().map(steps).collect();
        assert_eq!(steps, [(64, 1, 64), (256, 4, 128), (1024, 4, 512)]);
        let views = vec![SkyView::default(); tables.len()];
        Self { tables, resolutions, views }
    }

    /// The part of a lobe that a cone does not hide, and all of it: parts of it from the tables up to a level.
    fn sum(&mut self, level: usize, at: &Receiver, lobe: &BrdfLobe, (axis, cos): (Vec3, f32)) -> [Vec3; 2] {
        let horizon = Horizon::new(at, false);
        let highlight = SkyHighlight::new(lobe, at.normal);
        let mut sums = [Vec3::ZERO; 2];
        for (number, (table, view)) in self.tables.iter().zip(&mut self.views).enumerate().take(level + 1) {
            let resolution = self.resolutions[number];
            let blend = SkyBlend::of_level(&self.resolutions[..=level], number, highlight);
            let window = blend.cone().map_or(SkyWindow::whole(resolution), |(axis, angle)| {
                SkyWindow::around(resolution, horizon.pole().local(axis), angle)
            });
            view.begin_in(table, horizon, window);
            draw_cone(view, table, &horizon, axis, cos);
            view.settle(table, false, |v| v.dot(axis) > cos);
            let more = view.integrals_of(table, at, lobe, blend);
            sums = [sums[0] + more[0], sums[1] + more[1]];
        }
        sums
    }
}

/// A cone that hides nothing.
const NONE: (Vec3, f32) = (Vec3::Y, 1.0);

/// Parts of narrow lobes through windows of finer tables come to the whole lobe, before a cone, against sums about their axis.
#[test]
fn parts_of_narrow_lobes_come_to_them() {
    let mut random = Random::new(17);
    let sky = |v: Vec3| Vec3::new(1.0 + v.y, 1.0 + (4.0 * v.x).sin() * 0.7, 2.0 + v.z.powi(3));
    let mut tables = Tables::new(sky);
    let (mut sums, mut large, count) = ([0.0; 2], 0, 200);
    for case in 0..count {
        let normal = random.axis();
        let view = beside(&mut random, normal, 1.3);
        let at = Receiver::on_surface(Vec3::ZERO, normal.as_vec3(), view.as_vec3());
        let mirrored = 2.0 * normal.dot(view) * normal - view;
        let exponent = random.log_uniform(60.0, 9000.0) as f32;
        let alpha = (2.0 / (4.0 * exponent + 2.0)).sqrt();
        let lobe: BrdfLobe = match case % 3 {
            0 => Lobe::with_flux(mirrored.as_vec3(), exponent, Vec3::ONE).into(),
            1 => Lobe::with_flux(mirrored.as_vec3(), exponent, Vec3::ONE).times_cosine().into(),
            _ => Microfacets::new(at.view, alpha, [Vec3::ONE; 2])[case / 3 % 2].into(),
        };
        let level = tables.resolutions.iter().position(|table| SkyView::resolves(*table, &lobe)).expect("a table");
        // The edge of what is hidden is in the highlight.
        let offset = random.between(0.1, 0.6);
        let axis = random.axis_at(mirrored, offset).as_vec3();
        let cos = (offset + random.between(-1.0, 1.0) / f64::from(exponent).sqrt()).max(0.05).cos() as f32;
        let got = tables.sum(level, &at, &lobe, (axis, cos));
        let want = about_axis(&at, &lobe, mirrored, 200, |v| sky(v) * [1.0, 0.0][usize::from(v.dot(axis) > cos)]);
        let all = about_axis(&at, &lobe, mirrored, 200, sky);
        for (k, want) in [want, all].into_iter().enumerate() {
            let error = ((got[k].as_dvec3() - want) / all).abs().max_element();
            large += usize::from(error > [0.04, 0.015][k]);
            assert!(error < [0.1, 0.05][k], "case {case}, {lobe:?}: {got:?} for {want:?}");
            sums[k] += error / f64::from(count as u32);
        }
    }
    println!("mean errors of what is seen, and of all: {sums:.5?}, {large} large ones");
    assert!(sums[0] < 4e-3 && sums[1] < 1.5e-3 && large < 10, "{sums:?} {large}");
}

/// The integral of light times a lobe by rings about its axis, which lie the closer the nearer to it.
fn about_axis(at: &Receiver, lobe: &BrdfLobe, axis: DVec3, turns: u32, light: impl Fn(Vec3) -> Vec3) -> DVec3 {
    const RINGS: u32 = 700;
    let mut sum = DVec3::ZERO;
    for (ring, turn) in (0..RINGS).flat_map(|ring| (0..turns).map(move |turn| (ring, turn))) {
        let part = (f64::from(ring) + 0.5) / f64::from(RINGS);
        let theta = core::f64::consts::PI * part.powi(4);
        let size = core::f64::consts::PI * 4.0 * part.powi(3) * theta.sin() * core::f64::consts::TAU
            / f64::from(RINGS * turns);
        let v = random_direction(axis, theta.cos(), core::f64::consts::TAU * f64::from(turn) / f64::from(turns));
        if v.dot(at.normal.as_dvec3()) > 0.0 {
            let v = v.as_vec3();
            sum += (lobe.eval_at(at.normal, v) * light(v)).as_dvec3() * size;
        }
    }
    sum
}

/// From low views a highlight is narrow across: tables that resolve it from above sum it by several directions for each sample, finer ones before others.
#[test]
fn streaks_of_low_views_are_resolved() {
    let sky = |v: Vec3| Vec3::new(1.0, 1.0 + (4.0 * v.x).sin() * 0.7, 2.0 + v.z.powi(3));
    let mut tables = Tables::new(sky);
    let (mut sum, mut count, mut is_seen) = (0.0, 0.0, [false; 2]);
    for (roughness, last) in [(0.12_f32, 2), (0.16, 2), (0.2, 1), (0.3, 1), (0.45, 1)] {
        for height in [0.5, 0.25, 0.1, 0.04] {
            for (normal, turn) in [(DVec3::Y, 0.3), (DVec3::Y, 0.34), (DVec3::new(0.55, 0.6, 0.57).normalize(), 0.9)] {
                let view = random_direction(normal, height, turn);
                let at = Receiver::on_surface(Vec3::ZERO, normal.as_vec3(), view.as_vec3());
                let facets = Microfacets::new(at.view, roughness * roughness, [Vec3::ONE; 2])[0];
                let (axis, lobe) = (facets.highlight(at.normal).0, BrdfLobe::from(facets));
                let is_resolved = |table: &SkyResolution| SkyView::resolves_at(*table, &lobe, at.normal);
                let resolved = tables.resolutions[..=last].iter().position(is_resolved);
                is_seen[usize::from(resolved.is_some())] = true;
                let level = resolved.unwrap_or(last);
                let [_, got] = tables.sum(level, &at, &lobe, NONE);
                let want = about_axis(&at, &lobe, axis.as_dvec3(), 900, sky);
                let error = ((got.as_dvec3() - want) / want).abs().max_element();
                println!(
                    "roughness {roughness}, height {height}, level {level} ({resolved:?}): {:.2} %",
                    100.0 * error
                );
                assert!(error < 0.02, "roughness {roughness}, height {height}: {got:?} for {want:?}");
                sum += error;
                count += 1.0;
            }
        }
    }
    println!("mean error {:.3} %", 100.0 * sum / count);
    assert!(sum < 0.004 * count && is_seen == [true; 2], "{sum} of {count}");
}

/// Lobes with a grain are streaks from any view: parts of them through windows as long as these come to the whole lobe, before a cone whose edge is in the highlight.
#[test]
fn parts_of_brushed_lobes_come_to_them() {
    let mut random = Random::new(23);
    let sky = |v: Vec3| Vec3::new(1.0 + v.y, 1.0 + (4.0 * v.x).sin() * 0.7, 2.0 + v.z.powi(3));
    let mut tables = Tables::new(sky);
    let (mut sums, mut worst, mut levels, count) = ([0.0; 2], [0.0_f64; 2], [0; 3], 100);
    for case in 0..count {
        let normal = random.axis();
        let view = beside(&mut random, normal, 1.45);
        let at = Receiver::on_surface(Vec3::ZERO, normal.as_vec3(), view.as_vec3());
        let grain = Grain::new(at.normal, at.view, random.axis().as_vec3(), random.between(0.2, 1.0) as f32);
        let alpha = random.log_uniform(2.5e-3, 0.3) as f32;
        let parts = Microfacets::new(at.view, alpha, [Vec3::ONE; 2]).map(|part| part.with_grain(Some(grain)));
        let lobe = BrdfLobe::from(parts[0]);
        let is_resolved = |table: &SkyResolution| SkyView::resolves_at(*table, &lobe, at.normal);
        let level = tables.resolutions.iter().position(is_resolved).unwrap_or(2);
        levels[level] += 1;
        if !SkyView::resolves(tables.resolutions[level], &lobe) {
            continue;
        }
        let offset = random.between(0.1, 0.6);
        let axis = random.axis_at(2.0 * normal.dot(view) * normal - view, offset).as_vec3();
        let cos = offset.cos() as f32;
        let got = parts.map(|part| tables.sum(level, &at, &part.into(), (axis, cos)));
        let want = parts.map(|part| about_half_vectors(&at, &part, grain, |v| (sky(v), v.dot(axis) <= cos)));
        let want_all = want[0][1] + want[1][1];
        for k in 0..2 {
            let [got, want] = [got[0][k].as_dvec3() + got[1][k].as_dvec3(), want[0][k] + want[1][k]];
            let error = ((got - want) / want_all).abs().max_element();
            assert!(error < [0.1, 0.05][k], "case {case}, level {level}, {lobe:?}: {got:?} for {want:?}");
            worst[k] = worst[k].max(error);
            sums[k] += error / f64::from(count as u32);
        }
    }
    println!("mean errors of what is seen, and of all: {sums:.5?}, largest {worst:.4?}, at levels {levels:?}");
    assert!(sums[0] < 4e-3 && sums[1] < 2.5e-3 && levels.iter().all(|level| *level > 3), "{sums:?} {levels:?}");
}

/// The integrals of light times microfacets over what is seen and over all, by half vectors as often as the distribution has them.
fn about_half_vectors(
    at: &Receiver,
    facets: &Microfacets,
    grain: Grain,
    light: impl Fn(Vec3) -> (Vec3, bool),
) -> [DVec3; 2] {
    const SIDE: u32 = 400;
    let (normal, view) = (at.normal.as_dvec3(), at.view.as_dvec3());
    let across = (2.0 / (f64::from(facets.exponent) + 2.0)).sqrt();
    let along = f64::from(grain.alpha(across as f32));
    let t = grain.direction(at.normal, at.view).as_dvec3();
    let b = normal.cross(t);
    let mut sums = [DVec3::ZERO; 2];
    for (ring, turn) in (0..SIDE).flat_map(|ring| (0..SIDE).map(move |turn| (ring, turn))) {
        let part = (f64::from(ring) + 0.5) / f64::from(SIDE);
        let (sin, cos) = (core::f64::consts::TAU * (f64::from(turn) + 0.5) / f64::from(SIDE)).sin_cos();
        let slope = (part / (1.0 - part)).sqrt();
        let h = (normal + t * (along * slope * cos) + b * (across * slope * sin)).normalize();
        let v = 2.0 * view.dot(h) * h - view;
        if v.dot(normal) <= 0.0 {
            continue;
        }
        // The density of directions is D(h) n·h/(4 v·h), and D falls as (1 + slope²)⁻²/(n·h)⁴.
        let up = normal.dot(h);
        let density = (1.0 - part).powi(2) / (core::f64::consts::PI * along * across * up.powi(3) * 4.0 * v.dot(h));
        let v = v.as_vec3();
        let (light, is_seen) = light(v);
        let value = light.as_dvec3() * (f64::from(facets.value(at.normal, v)) / (density * f64::from(SIDE * SIDE)));
        sums[1] += value;
        sums[0] += if is_seen { value } else { DVec3::ZERO };
    }
    sums
}
