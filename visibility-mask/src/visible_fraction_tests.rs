use super::*;
use glam::DVec3;
use lobe_core::Cone;
use lobe_core::oracle::Random;

fn share_at(level: Level, mask: &Mask, at: &Receiver, lobe: &Lobe) -> f32 {
    let lobe = Lobe { exponent: lobe.exponent.min(narrowest(mask)), ..*lobe };
    sums_at(level, mask, mask.square(), at, &lobe, &mut Counts::default())
        .ratio(|| mask.lit_count() as f32 / mask.emitting_count().max(1) as f32)
}

/// The definition in f64, sample by sample, and the fraction of the lobe that covers the light.
fn exact(mask: &Mask, at: &Receiver, lobe: &Lobe) -> Option<(f64, f64)> {
    let square = *mask.square();
    let [right, up, toward] = [square.right, square.up, square.axis].map(Vec3::as_dvec3);
    let (half, side) = (square.half.as_dvec2(), mask.side());
    let (mut lit, mut all) = (0.0, 0.0);
    for j in 0..side {
        let y = f64::from(square.center.y) + half.y * ((2 * j + 1) as f64 / side as f64 - 1.0);
        let (from, to) = mask.emitting(j);
        for k in from..to {
            let x = f64::from(square.center.x) + half.x * (f64::from(2 * k + 1) / mask.width() as f64 - 1.0);
            let p: DVec3 = right * x + up * y + toward;
            let v = p.normalize();
            let along = lobe.axis.as_dvec3().dot(v).max(0.0);
            let cosine = if lobe.has_cosine { at.normal.as_dvec3().dot(v) } else { 1.0 };
            let w = along.powf(f64::from(lobe.exponent)) * cosine.max(0.0) / p.length().powi(3);
            all += w;
            let k = k as usize;
            lit += w * (mask.lit(j).0[k / 64] >> (k % 64) & 1) as f64;
        }
    }
    let sample = 4.0 * half.x * half.y / (mask.width() * side) as f64;
    let part = all * sample * (f64::from(lobe.exponent) + 1.0) / core::f64::consts::TAU;
    (all > 0.0).then(|| (lit / all, part))
}

/// Any vector instructions give the same bits.
#[test]
fn shares_do_not_depend_on_the_registers() {
    let mut random = Random::new(12);
    let best = Level::new();
    let mut levels = vec![Level::baseline()];
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    levels.extend([best.as_sse4_2().map(Simd::level), best.as_avx2().map(Simd::level)].into_iter().flatten());
    for case in 0..300 {
        let theta = random.log_uniform(0.003, 1.2);
        let axis = random.axis();
        let (tilt, aside) = (random.between(0.0, 1.6), theta * random.uniform());
        let normal = random.axis_at(axis, tilt).as_vec3().normalize();
        let at = Receiver::on_surface(Vec3::ZERO, normal, normal);
        let off = random.axis_at(axis, aside).as_vec3().normalize();
        let lobe = match case % 3 {
            0 => Lobe::new(normal, 1.0, Vec3::ONE),
            _ => Lobe::new(off, random.log_uniform(0.5, 1e4) as f32, Vec3::ONE).times_cosine(),
        };
        let cone = Cone {
            axis: axis.as_vec3().normalize(),
            one_minus_cos: (1.0 - theta.cos()) as f32,
            distance: f32::INFINITY,
        };
        let mut mask = Mask::default();
        mask.set_coarse(case % 2 == 0);
        mask.reset(&UnitSquare::facing(&cone, Vec3::X), 3 + case % 4, normal);
        for j in 0..mask.side() {
            let from = (random.between(-1.0, 0.5) * f64::from(mask.square().half.x)) as f32;
            mask.block_span(j, from, from + 0.7 * mask.square().half.x);
        }
        let want = share_at(best, &mask, &at, &lobe);
        for &level in &levels {
            let got = share_at(level, &mask, &at, &lobe);
            assert_eq!(got.to_bits(), want.to_bits(), "case {case}: {got} {want} at {level:?}");
        }
    }
}

/// Every form against the definition, over all angles and exponents for which it is chosen.
#[test]
fn shares_are_the_sums_over_samples() {
    let mut random = Random::new(11);
    for theta in [0.001_f64, 0.05, 0.14, 0.3, 0.6, 1.2] {
        for exponent in [1.0, 0.3, 2.0, 10.0, 60.0, 400.0, 5e3, 1e5] {
            let (mut mean, mut worst) = (0.0, 0.0_f64);
            const CASES: usize = 40;
            for case in 0..CASES {
                let axis = random.axis();
                let quarter = core::f64::consts::FRAC_PI_2;
                let tilt = random.between(0.0, if case % 3 == 0 { quarter } else { (quarter - theta).max(0.0) });
                let normal = random.axis_at(axis, tilt).as_vec3().normalize();
                let at = Receiver::on_surface(Vec3::ZERO, normal, normal);
                let off = random.between(0.0, (theta + 2.0 / f64::sqrt(exponent)).min(1.5));
                let lobe = Lobe::new(random.axis_at(axis, off).as_vec3().normalize(), exponent as f32, Vec3::ONE);
                let lobe = match case % 2 {
                    _ if exponent == 1.0 => Lobe::new(normal, 1.0, Vec3::ONE),
                    0 => lobe,
                    _ => lobe.times_cosine(),
                };
                let cone = Cone {
                    axis: axis.as_vec3().normalize(),
                    one_minus_cos: (1.0 - theta.cos()) as f32,
                    distance: f32::INFINITY,
                };
                let square = UnitSquare::facing(&cone, random.axis().as_vec3()).zoomed(&lobe, normal, 3.6);
                let mut mask = Mask::default();
                mask.set_coarse(case % 4 == 3);
                mask.reset(&square, 4 + case as u32 % 3, normal);
                for j in 0..mask.side() {
                    let at = |x: f64| square.center.x + square.half.x * x as f32;
                    let from = random.between(-1.0, 0.6);
                    mask.block_span(j, at(from), at(from + random.uniform()));
                }
                let Some((exact, part)) = exact(&mask, &at, &lobe) else { continue };
                // Weighted by the lobe's radiance: an error where there is almost none does not matter.
                let shows = (100.0 * part).min(1.0);
                let error = (f64::from(share_at(Level::new(), &mask, &at, &lobe)) - exact).abs() * shows;
                mean += error / CASES as f64;
                worst = worst.max(error);
            }
            println!("θ {theta} e {exponent}: mean {mean:.1e}, worst {worst:.1e}");
            // Eight samples share one weight, of a coarse mask four of sixteen columns.
            assert!(mean < 8e-4 && worst < 8e-3, "θ {theta} e {exponent}: mean {mean:.1e}, worst {worst:.1e}");
        }
    }
}
