//! The visible fraction of a light changes as smoothly as the scene moves.

use crate::common::moment::{EXPONENTS, Moment};
use lobe_core::oracle::Random;

const SWEEPS: [&str; 5] = ["lobe", "blocker", "light", "receiver", "normal"];

/// The largest step of a sweep beyond its neighbours' steps.
fn pop(steps: usize, at: impl Fn(f64) -> Moment) -> f64 {
    let seen: Vec<_> = (0..steps).map(|k| at(k as f64 / steps as f64).fraction()).collect();
    let changes: Vec<f64> = seen.windows(2).map(|w| w[1].0 - w[0].0).collect();
    let beyond = |k: usize| {
        let around = [k - 2, k - 1, k + 1, k + 2].map(|i| changes[i].abs()).into_iter().fold(0.0, f64::max);
        (changes[k].abs() - around) * seen[k].1
    };
    (2..changes.len() - 2).map(beyond).fold(0.0, f64::max)
}

/// Checks the largest pop, and the bound of 95 % of all sweeps, in tolerances. A narrow lobe may still see an edge along its rows
/// while other edges, at its rim, turn its window.
fn check(tolerance: f32, most: f64, usual: f64) {
    let mut random = Random::new(3);
    let mut found = Vec::new();
    for case in 0..96 {
        let (theta, exponent) = ([0.003, 0.03, 0.15, 0.43][case % 4], EXPONENTS[case / 4 % 6]);
        let moment = Moment::random(&mut random, case / 24, theta, exponent, tolerance);
        let direction = random.axis();
        for (kind, what) in SWEEPS.iter().enumerate().skip(usize::from(exponent == 1.0)) {
            let size = pop(100, |t| moment.moved(kind, direction, t));
            found.push((size / f64::from(tolerance), format!("case {case}: {what}, θ {theta}, e {exponent}")));
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let at = found[found.len() / 20].0;
    println!("{:.1} %: at most {:.2} tolerances ({}), 95 % below {at:.2}", 100.0 * tolerance, found[0].0, found[0].1);
    assert!(found[0].0 < most && at < usual);
}

#[test]
fn gentle_motion_does_not_pop() {
    check(0.01, 1.0, 0.5);
    check(0.005, 1.5, 0.7);
    check(0.003, 2.0, 0.5);
}

#[test]
fn gentle_motion_does_not_pop_within_a_thousandth() {
    check(0.001, 12.0, 0.5);
}
