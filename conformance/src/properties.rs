//! The properties, one function each.

use crate::case::{Case, FAR, Sphere64, Use, WIDE};
use crate::{Limits, Measured, Report, Run, Subject};
use core::f64::consts::PI;
use glam::{DQuat, DVec3};
use lobe_core::oracle::Random;
use shading::Coverage;

/// One case in so many has a crowd of spheres.
const CROWDED: usize = 6;

/// Runs the whole suite; deterministic.
///
/// # Errors
/// [`Report`]: every property that does not hold, each with its worst case.
pub fn check(subject: &impl Subject, limits: &Limits) -> Result<Measured, Report> {
    let mut random = Random::new(4);
    let mut run = Run::default();
    nothing_blocks(subject, limits, &mut random, &mut run);
    full_cover(subject, limits, &mut random, &mut run);
    overlaps(subject, limits, &mut random, &mut run);
    several(subject, limits, &mut random, &mut run);
    slivers(subject, limits, &mut random, &mut run);
    many_spheres(subject, limits, &mut random, &mut run);
    motion(subject, limits, &mut random, &mut run);
    motion_of_several(subject, limits, &mut random, &mut run);
    run.end()
}

/// No spheres, and spheres that no ray to the light meets.
fn nothing_blocks(subject: &impl Subject, limits: &Limits, random: &mut Random, out: &mut Run<Measured>) {
    for _ in 0..limits.cases {
        let mut case = Case::random(random);
        for how in [Use::Fresh, Use::Entered, Use::Boxed] {
            let (coverage, _) = case.fraction(subject, how);
            out.ensure(coverage == Coverage::Lit, "no blocker is lit at no cost", || {
                format!("{coverage:?} of {case:?}")
            });
        }
        let theta = case.cone().1;
        for i in 0..4 {
            let size = random.log_uniform(0.01, 1.2);
            let distance = random.log_uniform(0.3, 3.0 * FAR);
            let beside = (1.1 * size + theta + 0.02).min(PI);
            let sphere = if i < 2 {
                // Anywhere beside, then straight behind the receiver.
                let from = if i == 0 { beside } else { beside.max(0.5 * PI + size) };
                let off = random.between(from, PI);
                case.sphere(random, size, off, distance)
            } else {
                let radius = random.log_uniform(0.1, 0.5 * FAR);
                let off = random.between(0.0, theta);
                let beyond = case.sphere(random, 0.0, off, FAR + case.light.radius + 1.05 * radius);
                Sphere64 { radius, ..beyond }
            };
            case.spheres.push(sphere);
        }
        let beside = case.spheres.remove(0);
        let (_, fraction) = case.fraction(subject, Use::Fresh);
        out.ensure(fraction == 1.0, "what is behind receiver or light blocks nothing", || {
            format!("V = {fraction} in {case:?}")
        });
        case.spheres = vec![beside];
        let dark = 1.0 - f64::from(case.fraction(subject, Use::Fresh).1);
        out.within(dark, ("beside", limits.beside), "what is beside blocks nothing", || {
            format!("1 - V = {dark} in {case:?}")
        });
        out.measured.beside = out.measured.beside.max(dark);
    }
}

fn full_cover(subject: &impl Subject, limits: &Limits, random: &mut Random, out: &mut Run<Measured>) {
    for _ in 0..limits.cases {
        let mut case = Case::random(random);
        let theta = case.cone().1;
        let off = random.between(0.0, 0.5 * theta);
        let size = (theta + off) * random.between(1.1, 1.5) + 0.01;
        let distance = random.between(1.0, 0.3 * FAR);
        case.spheres.push(case.sphere(random, size, off, distance));
        for how in [Use::Fresh, Use::Entered, Use::Boxed] {
            let fraction = f64::from(case.fraction(subject, how).1);
            out.within(fraction, ("cover", limits.cover), "full cover is dark", || {
                format!("V = {fraction} in {case:?}")
            });
            out.measured.cover = out.measured.cover.max(fraction);
        }
    }
}

/// A light of half-angle `theta` straight above a diffuse receiver. A Lambert lobe varies within it by
/// less than θ²/4 of V: 3e-4 at the 2° used here.
fn straight_above(random: &mut Random, theta: f64) -> Case {
    let mut case = Case::random(random);
    let (axis, _) = case.cone();
    case.normal = axis;
    case.light.radius = FAR * theta.sin();
    case.lobe = (axis, 1.0);
    case
}

/// Angular radii of the sphere in closed cases, from a dot to a half-plane, by the light's half-angle. The last one's edge
/// is off a straight line by 0.1 % of the light's radius.
fn closed_sizes(theta: f64) -> [f64; 6] {
    [0.3 * theta, theta, 3.0 * theta, 0.5, 1.2, 1.5]
}

fn overlaps(subject: &impl Subject, limits: &Limits, random: &mut Random, out: &mut Run<Measured>) {
    let (mut sum, mut count) = (0.0, 0);
    for theta in [0.005, 0.035] {
        for size in closed_sizes(theta) {
            for _ in 0..limits.cases / 3 {
                let mut case = straight_above(random, theta);
                let off = random.between((size - theta).max(0.0), size + theta);
                let distance = random.between(0.5, 0.4 * FAR);
                case.spheres.push(case.sphere(random, size, off, distance));
                let (_, fraction) = case.fraction(subject, Use::Fresh);
                let error = (f64::from(fraction) - case.closed()).abs();
                out.within(error, ("overlap", limits.overlap), "overlap of two discs", || {
                    format!("V = {fraction}, closed {} in {case:?}", case.closed())
                });
                out.measured.overlap = out.measured.overlap.max(error);
                (sum, count) = (sum + error, count + 1);
            }
        }
    }
    out.measured.overlap_mean = sum / f64::from(count.max(1));
    let mean = out.measured.overlap_mean;
    out.within(mean, ("overlap_mean", limits.overlap_mean), "mean overlap of two discs", || format!("{mean}"));
}

/// Two to five spheres, any light, any lobe, also through the horizon; every [`CROWDED`]th time a crowd of small ones as well.
fn several(subject: &impl Subject, limits: &Limits, random: &mut Random, out: &mut Run<Measured>) {
    let mut sum = 0.0;
    for k in 0..limits.cases {
        let mut case = if k % CROWDED == 1 { Case::lit_by(random, WIDE) } else { Case::random(random) };
        if k % CROWDED == 0 {
            case.spheres = case.crowd(random);
        }
        for _ in 0..2 + random.bits() % 4 {
            case.spheres.push(case.blocker_anywhere(random));
        }
        let (fraction, exact) = (f64::from(case.fraction(subject, Use::Fresh).1), case.exact());
        let error = (fraction - exact).abs();
        out.within(error, ("several", limits.several), "several spheres against quadrature", || {
            format!("V = {fraction}, exactly {exact} in {case:?}")
        });
        out.measured.several = out.measured.several.max(error);
        sum += error;
    }
    out.measured.several_mean = sum / limits.cases.max(1) as f64;
    let mean = out.measured.several_mean;
    out.within(mean, ("several_mean", limits.several_mean), "mean of several spheres", || format!("{mean}"));
}

/// A sphere that hides next to nothing of the light, or next to all of it.
fn slivers(subject: &impl Subject, limits: &Limits, random: &mut Random, out: &mut Run<Measured>) {
    for k in 0..4 * limits.cases {
        let mut case = Case::random(random);
        let theta = case.cone().1;
        let sliver = theta * random.log_uniform(1e-3, 0.1);
        let (size, off) = if k % 2 == 0 {
            let size = theta * random.between(0.2, 2.0);
            (size, size + theta - sliver)
        } else {
            let size = theta * random.between(1.1, 2.0);
            (size, size - theta + sliver)
        };
        let distance = random.between(0.5, 0.4 * FAR);
        case.spheres.push(case.sphere(random, size, off, distance));
        let (_, fraction) = case.fraction(subject, Use::Fresh);
        out.ensure((0.0..=1.0).contains(&fraction), "V is in [0, 1] at slivers", || {
            format!("V = {fraction} in {case:?}")
        });
    }
}

/// Range, scratch, dispatch, overflow, monotony, order, rotation: one to five spheres at random, now and then before a crowd.
fn many_spheres(subject: &impl Subject, limits: &Limits, random: &mut Random, out: &mut Run<Measured>) {
    for k in 0..limits.cases {
        let mut case = Case::random(random);
        let mut last = 1.0;
        if k % CROWDED == 0 {
            case.spheres = case.crowd(random);
            last = f64::from(case.fraction(subject, Use::Fresh).1);
        }
        for _ in 0..1 + random.bits() % 5 {
            case.spheres.push(case.blocker(random));
            let (_, fraction) = case.fraction(subject, Use::Fresh);
            out.ensure((0.0..=1.0).contains(&fraction), "V is in [0, 1]", || format!("V = {fraction} in {case:?}"));
            for (how, property) in [
                (Use::Used, "used scratch changes nothing"),
                (Use::Entered, "enter changes nothing"),
                (Use::Boxed, "a boxed strategy is the same"),
                (Use::Threads, "threads change nothing"),
            ] {
                let (_, again) = case.fraction(subject, how);
                out.ensure(fraction == again, property, || format!("V = {fraction}, then {again} in {case:?}"));
            }
            let brighter = f64::from(fraction) - last;
            out.within(brighter, ("brighter", limits.brighter), "a further blocker never brightens", || {
                format!("V from {last} to {fraction} in {case:?}")
            });
            out.measured.brighter = out.measured.brighter.max(brighter);
            last = f64::from(fraction);
        }
        let mut reversed = case.clone();
        reversed.spheres.reverse();
        let (_, fraction) = reversed.fraction(subject, Use::Fresh);
        let change = (f64::from(fraction) - last).abs();
        out.within(change, ("order", limits.order), "order does not matter", || {
            format!("V = {last}, reversed {fraction} in {case:?}")
        });
        out.measured.order = out.measured.order.max(change);
        let turn = DQuat::from_axis_angle(random.axis(), random.between(0.0, PI));
        let (_, fraction) = case.turned(turn).fraction(subject, Use::Fresh);
        let change = (f64::from(fraction) - last).abs();
        out.within(change, ("turn", limits.turn), "turning everything changes nothing", || {
            format!("V = {last}, turned {fraction} in {case:?}")
        });
        out.measured.turn = out.measured.turn.max(change);
    }
}

/// The thing that moves in a sweep.
#[derive(Clone, Copy, Debug)]
enum Moves {
    Blocker,
    Light,
    Receiver,
}

/// A sweep: by `± reach` half-angles of the light, along a direction.
#[derive(Clone, Copy, Debug)]
struct Motion {
    moves: Moves,
    along: DVec3,
    reach: f64,
}

/// One sphere passes the light in small steps, or the light or the receiver moves instead.
fn motion(subject: &impl Subject, limits: &Limits, random: &mut Random, out: &mut Run<Measured>) {
    let theta = 0.035;
    for k in 0..limits.cases / 3 {
        let size = closed_sizes(theta)[k / 4 % 6];
        let mut start = straight_above(random, theta);
        let (axis, _) = start.cone();
        // Also along the directions that a mask may lie along.
        let (u, v) = axis.any_orthonormal_pair();
        let along = [u, v, random.axis_at(axis, 0.5 * PI), random.axis_at(axis, 0.5 * PI)][k % 4];
        let distance = 0.4 * FAR;
        let center = start.position + (axis * size.cos() + along * size.sin()) * distance;
        start.spheres.push(Sphere64 { center, radius: distance * size.sin() });
        let moves = [Moves::Blocker, Moves::Light, Moves::Receiver][(k / 4 + k) % 3];
        let motion = Motion { moves, along, reach: 1.2 };
        let jump = sweep(subject, &start, motion, ("jump", limits.jump), Case::closed, out);
        out.measured.jump = out.measured.jump.max(jump);
    }
}

/// The same with two or three spheres, any light and lobe: they take turns at being the largest.
fn motion_of_several(subject: &impl Subject, limits: &Limits, random: &mut Random, out: &mut Run<Measured>) {
    for k in 0..limits.cases / 3 {
        let mut start = Case::random(random);
        for _ in 0..2 + k % 2 {
            start.spheres.push(start.blocker(random));
        }
        let along = random.axis_at(start.cone().0, 0.5 * PI);
        let moves = [Moves::Blocker, Moves::Light, Moves::Receiver][k % 3];
        let motion = Motion { moves, along, reach: 0.4 };
        let jump = sweep(subject, &start, motion, ("jump_several", limits.jump_several), Case::exact, out);
        out.measured.jump_several = out.measured.jump_several.max(jump);
    }
}

/// Largest change of V in a step that the exact one does not make, while something moves in steps of a hundredth of
/// the light's half-angle.
fn sweep(
    subject: &impl Subject,
    start: &Case,
    Motion { moves, along, reach }: Motion,
    limit: (&'static str, f64),
    exact: impl Fn(&Case) -> f64,
    out: &mut Run<Measured>,
) -> f64 {
    let theta = start.cone().1;
    let distance = start.spheres[0].center.distance(start.position);
    let steps = (200.0 * reach * 2.0 / 3.0) as u32;
    let (mut last, mut largest) = (None::<(f64, f64)>, 0.0_f64);
    for step in 0..=steps {
        let way = (f64::from(step) / f64::from(steps) * 2.0 - 1.0) * reach * theta;
        let mut case = start.clone();
        let aside = along * way;
        match moves {
            Moves::Blocker => case.spheres[0].center += aside * distance,
            Moves::Light => case.light.center -= aside * FAR,
            Moves::Receiver => case.position += aside * (distance / (1.0 - distance / FAR)),
        }
        // In a sphere it is dark: entering one is no small move.
        if case.spheres.iter().any(|sphere| sphere.center.distance(case.position) <= sphere.radius) {
            last = None;
            continue;
        }
        let now = (f64::from(case.fraction(subject, Use::Fresh).1), exact(&case));
        if let Some((fraction, truth)) = last {
            let jump = ((now.0 - fraction) - (now.1 - truth)).abs();
            out.within(jump, limit, "nothing pops", || {
                format!(
                    "V from {fraction} to {}, exactly from {truth} to {} as {moves:?} moves in {case:?}",
                    now.0, now.1
                )
            });
            largest = largest.max(jump);
        }
        last = Some(now);
    }
    largest
}
