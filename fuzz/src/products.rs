//! Products of lobes by the thousand million.

use core::f32::consts::TAU;
use cosine_lobes::lobe_core::oracle::{self, Random};
use cosine_lobes::lobe_core::products_of_angle;
use rayon::prelude::*;
use std::time::Instant;

const BATCH: u64 = 1 << 14;

/// Exponents and `1 − cos α`: of any size, and angles where lobes of these exponents meet, where they part, and at the ends.
fn draw(random: &mut Random) -> [f32; 3] {
    let exponent = |random: &mut Random| match random.bits() % 8 {
        0 => 0.0,
        1 => random.log_uniform(1e-8, 1.0),
        _ => random.log_uniform(1e-2, 1e7),
    };
    let (e1, e2) = (exponent(random), exponent(random));
    let width = 1.0 / (1.0 + e1.min(e2));
    let angle = match random.bits() % 8 {
        0 => 2.0 * random.uniform(),
        1 => random.log_uniform(1e-14, 2.0),
        2 => 2.0 - random.log_uniform(1e-7, 2.0),
        3 => 1.0 + random.between(-1e-5, 1e-5),
        _ => width * random.log_uniform(1e-3, 40.0),
    };
    [e1 as f32, e2 as f32, angle.clamp(0.0, 2.0) as f32]
}

/// Checks products against their bounds, and some against quadrature; prints the results.
pub(crate) fn run(seed: u64, bounded: u64, quadrature: u64) -> bool {
    let start = Instant::now();
    let bad = beyond_bounds(seed, bounded);
    if bounded > 0 {
        println!("{bounded} products against bounds: {bad} beyond, {:.0} s", start.elapsed().as_secs_f64());
    }
    let start = Instant::now();
    let [stated, elsewhere] = errors(seed, quadrature);
    if quadrature > 0 {
        let seconds = start.elapsed().as_secs_f64();
        println!(
            "{quadrature} products against quadrature: {stated:.2e} relative (stated 1e-3), {elsewhere:.2e} of the coaxial value \
             elsewhere (stated 1e-6), {seconds:.0} s"
        );
    }
    // The stated figures hold to their last digit.
    bad == 0 && stated <= 1.05e-3 && elsewhere <= 1.5e-6
}

/// The number of products beyond their bounds, each of which is printed.
fn beyond_bounds(seed: u64, bounded: u64) -> u64 {
    let batch = |batch: u64| {
        let mut random = Random::new(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ batch);
        let count = BATCH.min(bounded - batch * BATCH) as usize;
        let all: Vec<[f32; 3]> = (0..count).map(|_| draw(&mut random)).collect();
        let column = |k: usize| all.iter().map(|row| row[k]).collect::<Vec<f32>>();
        let mut out = vec![0.0; count];
        products_of_angle(&column(0), &column(1), &column(2), &mut out);
        let fault = |([e1, e2, angle], value): (&[f32; 3], &f32)| {
            let bad = !(*value >= 0.0 && *value <= 1.002 * TAU / (e1 + e2 + 1.0));
            if bad {
                println!("{e1:e} {e2:e} {angle:e}: {value:e}");
            }
            u64::from(bad)
        };
        all.iter().zip(&out).map(fault).sum::<u64>()
    };
    (0..bounded.div_ceil(BATCH)).into_par_iter().map(batch).sum()
}

/// The largest relative error where it is stated, and that of the coaxial value elsewhere.
fn errors(seed: u64, quadrature: u64) -> [f64; 2] {
    let batch = |batch: u64| {
        let mut random = Random::new(seed.wrapping_mul(0xd134_2543_de82_ef95) ^ batch);
        let mut worst = [0.0_f64; 2];
        for _ in 0..BATCH.min(quadrature - batch * BATCH) {
            let [e1, e2, one_minus_cos] = draw(&mut random);
            // The domain of the stated accuracy.
            let (e1, e2) = (e1.min(1e6), e2.min(1e6));
            let mut value = [0.0];
            products_of_angle(&[e1], &[e2], &[one_minus_cos], &mut value);
            let angle = 2.0 * (0.5 * f64::from(one_minus_cos)).sqrt().min(1.0).asin();
            let want = oracle::product(f64::from(e1), f64::from(e2), angle);
            let coaxial = core::f64::consts::TAU / (f64::from(e1) + f64::from(e2) + 1.0);
            let error = (f64::from(value[0]) - want).abs();
            if want > 1e-4 * coaxial {
                worst[0] = worst[0].max(error / want);
            } else {
                worst[1] = worst[1].max(error / coaxial);
            }
        }
        worst
    };
    let most = |a: [f64; 2], b: [f64; 2]| [a[0].max(b[0]), a[1].max(b[1])];
    (0..quadrature.div_ceil(BATCH)).into_par_iter().map(batch).reduce(|| [0.0; 2], most)
}
