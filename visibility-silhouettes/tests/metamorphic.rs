//! Equivalent descriptions of a scene give the same light.

use crate::common::Soup;
use crate::common::moment::{EXPONENTS, Moment};
use glam::{DQuat, DVec3};
use lobe_core::oracle::Random;

const CASES: usize = 240;

fn moment(random: &mut Random, case: usize) -> Moment {
    let (theta, exponent) = ([0.003, 0.03, 0.15, 0.43][case % 4], EXPONENTS[case / 4 % 6]);
    Moment::random(random, case / 24 % 4, theta, exponent, [0.005, 0.003, 0.001][case % 3])
}

/// The same moment, rotated, scaled and moved.
fn transformed(m: &Moment, turn: DQuat, scale: f64, shift: DVec3) -> Moment {
    let mut new = m.clone();
    let point = |p: DVec3| turn * p * scale + shift;
    new.position = point(m.position);
    new.light = point(m.light);
    new.radius *= scale;
    new.normal = turn * m.normal;
    new.lobe.0 = turn * m.lobe.0;
    new.soup.positions.iter_mut().for_each(|p| *p = point(p.as_dvec3()).as_vec3());
    new
}

/// The number of cases that see a part of the light, and their differences.
fn differences(change: impl Fn(&mut Random, &Moment) -> Moment) -> Vec<f64> {
    let mut random = Random::new(41);
    let mut found = Vec::new();
    for case in 0..CASES {
        let moment = moment(&mut random, case);
        let changed = change(&mut random, &moment);
        let [(before, matters), (after, _)] = [moment.fraction(), changed.fraction()];
        if before > 0.0 && before < 1.0 {
            found.push((before - after).abs() * matters);
        } else {
            assert!((before - after).abs() * matters < 0.01, "case {case}: {before} becomes {after}");
        }
    }
    assert!(found.len() > CASES / 3, "{} see a part", found.len());
    found.sort_by(|a, b| b.total_cmp(a));
    found
}

fn assert_same(found: &[f64]) {
    assert!(found.iter().all(|d| *d == 0.0), "{:?}", &found[..4]);
}

#[test]
fn triangles_in_any_order_and_wound_either_way() {
    assert_same(&differences(|random, m| {
        let mut new = m.clone();
        let triangles = &mut new.soup.triangles;
        for k in (1..triangles.len()).rev() {
            triangles.swap(k, random.bits() as usize % (k + 1));
        }
        triangles.iter_mut().for_each(|t| t.rotate_left(1));
        new
    }));
    assert_same(&differences(|random, m| {
        let mut new = m.clone();
        new.soup.triangles.iter_mut().filter(|_| random.bits() % 2 == 0).for_each(|t| t.swap(0, 1));
        new
    }));
}

/// Edges that occur twice weigh more near the horizon when a mask is turned.
#[test]
fn triangles_that_are_there_twice() {
    let found = differences(|_, m| {
        let mut new = m.clone();
        new.soup.triangles.extend_from_slice(&m.soup.triangles);
        new
    });
    let mean = found.iter().sum::<f64>() / found.len() as f64;
    assert!(mean < 4e-4 && found[0] < 0.008, "mean {mean}, {:?}", &found[..4]);
}

#[test]
fn a_corner_listed_twice_is_one() {
    assert_same(&differences(|_, m| {
        let mut new = m.clone();
        new.soup = Soup::default();
        m.soup.corners().for_each(|corners| new.soup.add(corners));
        new
    }));
}

#[test]
fn powers_of_two_change_no_bit() {
    for scale in [2.0_f64.powi(-20), 0.5, 2.0_f64.powi(20)] {
        assert_same(&differences(|_, m| transformed(m, DQuat::IDENTITY, scale, DVec3::ZERO)));
    }
}

/// Rounding moves edges, and a turned mask has its samples elsewhere: the results differ by the mask's error.
#[test]
fn turned_scaled_and_moved() {
    for (scale, shift) in [(1.0, 0.0), (1e-6, 0.0), (1e6, 0.0), (1.0, 10.0), (1.0, 1000.0)] {
        let found = differences(|random, m| {
            let turn = DQuat::from_axis_angle(random.axis(), random.between(0.0, 6.3));
            transformed(m, turn, scale, random.axis() * shift)
        });
        let mean = found.iter().sum::<f64>() / found.len() as f64;
        println!("scale {scale:.0e}, shift {shift}: mean {:.4} %, largest {:.3} %", 100.0 * mean, 100.0 * found[0]);
        // Positions at 1000 are exact to 6e-5, the smallest light has a radius of 0.03.
        let rounding = if shift > 100.0 { 20.0 } else { 1.0 };
        assert!(mean < 4e-4 * rounding && found[0] < 0.008 * rounding);
    }
}

/// A light that is seen under the same angle from so far that one is nothing beside its distance.
#[test]
fn larger_lights_farther_away() {
    for scale in [2.0_f64.powi(10), 2.0_f64.powi(22), 2.0_f64.powi(40)] {
        let found = differences(|_, m| Moment { light: m.light * scale, radius: m.radius * scale, ..m.clone() });
        let mean = found.iter().sum::<f64>() / found.len() as f64;
        println!("scale {scale:.0e}: mean {:.4} %, largest {:.3} %", 100.0 * mean, 100.0 * found[0]);
        assert!(mean < 4e-4 && found[0] < 0.008, "scale {scale:.0e}: mean {mean}, {:?}", &found[..4]);
    }
}
