//! The paper's visibility: the properties of its weights, and its error against brute force in f64.

use glam::{DVec2, DVec3, Vec2, Vec3};
use lobe_core::oracle::Random;
use lobe_core::{Cone, Lobe, Receiver, SeenLight, VisibilitySum};
use paper::{PaperIntegrator, PaperVisibility, PaperWeights, Tables};
use shading::{
    Accuracy, Contribution, Coverage, FractionIntegrator, Integrator, Interaction, LightCoverage, LightId,
    LightVisibility, Observer, Visibility, VisibilityQuery,
};
use std::sync::OnceLock;
use std::time::Instant;
use visibility_mask::{Blockers, MAX_DEPTH, Mask, MaskVisibility};

fn tables() -> &'static Tables {
    static TABLES: OnceLock<Tables> = OnceLock::new();
    TABLES.get_or_init(Tables::build)
}

/// Shapes in the plane at distance 1 along `axis`, in a frame of their own: discs and half-planes; or cells of the
/// strategy's own square.
#[derive(Clone, Default)]
struct Shapes {
    axis: DVec3,
    right: DVec3,
    up: DVec3,
    discs: Vec<(DVec2, f64)>,
    /// `normal·p > offset` is blocked.
    halves: Vec<(DVec2, f64)>,
    /// Side and (column, row).
    cells: (usize, Vec<(usize, usize)>),
    all: bool,
}

impl Shapes {
    fn at(axis: Vec3) -> Self {
        let axis = axis.as_dvec3().normalize();
        let (right, up) = axis.any_orthonormal_pair();
        Self { axis, right, up, ..Self::default() }
    }

    fn blocks(&self, p: DVec2) -> bool {
        self.discs.iter().any(|(c, r)| p.distance_squared(*c) < r * r)
            || self.halves.iter().any(|(n, offset)| n.dot(p) > *offset)
    }
}

impl Blockers for &Shapes {
    type Scratch = ();

    fn scratch(&self) {}

    fn select(&self, _: &VisibilityQuery<'_>, (): &mut ()) -> Coverage {
        match (self.all, self.discs.is_empty() && self.halves.is_empty() && self.cells.1.is_empty()) {
            (true, _) => Coverage::Dark,
            (_, true) => Coverage::Lit,
            _ => Coverage::Partial,
        }
    }

    fn splat(&self, _: &VisibilityQuery<'_>, (): &mut (), mask: &mut Mask) {
        let square = *mask.square();
        let local = |p: DVec2| {
            let v = (self.right * p.x + self.up * p.y + self.axis).as_vec3();
            Vec2::new(square.right.dot(v), square.up.dot(v))
        };
        for j in 0..mask.side() {
            let y = mask.row_y(j);
            for (c, r) in &self.discs {
                let c = local(*c);
                let half = ((*r as f32).powi(2) - (y - c.y).powi(2)).max(0.0).sqrt();
                mask.block_span(j, c.x - half, c.x + half);
            }
            for (n, offset) in &self.halves {
                let n = local(*n);
                let x = (*offset as f32 - n.y * y) / n.x;
                let (from, to) = if n.x > 0.0 { (x, f32::INFINITY) } else { (f32::NEG_INFINITY, x) };
                mask.block_span(j, from, to);
            }
            let (side, cells) = &self.cells;
            for (column, row) in cells {
                if j * side / mask.side() == *row {
                    let at = |k: usize| square.half.x * (2.0 * k as f32 / *side as f32 - 1.0);
                    mask.block_span(j, at(*column), at(column + 1));
                }
            }
        }
    }
}

fn receiver(normal: Vec3) -> Receiver {
    Receiver::on_surface(Vec3::ZERO, normal, normal)
}

fn cone(axis: Vec3, theta: f64) -> Cone {
    let one_minus_cos = 2.0 * (0.5 * theta).sin().powi(2);
    Cone { axis, one_minus_cos: one_minus_cos as f32, distance: f32::INFINITY }
}

fn unit(v: DVec3) -> Vec3 {
    v.normalize().as_vec3().normalize()
}

fn shade<V: Visibility, I: Integrator<V>>(
    integrator: &I,
    visibility: &V,
    depth: u32,
    at: &Receiver,
    f: Lobe,
    cone: &Cone,
) -> Contribution {
    let brdf = [f.into()];
    let light = SeenLight::of_cone(*cone, Vec3::ONE);
    let accuracy = Accuracy { tolerance: 0.003, depth };
    let mut scratch = visibility.scratch();
    let mut visit = LightVisibility::alone(visibility, LightId(0), accuracy, &mut scratch);
    let call = Interaction { at, brdf: &brdf, light: &light, threshold: 0.0 };
    integrator.radiance(&call, &mut visit, &mut I::Scratch::default(), &mut ())
}

/// `base + Σ ∫(f̃L)c / ∫f̃L`, not clamped.
fn visibility_sum(shapes: &Shapes, weights: &PaperWeights, at: &Receiver, f: Lobe, cone: &Cone) -> f32 {
    let strategy = PaperVisibility::new(shapes, tables()).with_weights(weights.clone());
    let accuracy = Accuracy { tolerance: 0.003, depth: weights.depth() };
    let (mut scratch, mut sum) = (strategy.scratch(), VisibilitySum::default());
    let mut visit = LightVisibility::alone(&strategy, LightId(0), accuracy, &mut scratch);
    let LightCoverage::Partial(seen) = visit.coverage(at, cone, None) else { return 1.0 };
    visit.lobes(&seen, &f, 1.0, &mut sum);
    assert!(sum.whole.lobes().is_empty());
    let seen = tables().product(&f, &tables().light_lobe(cone, Vec3::ONE));
    sum.base + sum.lobes.lobes().iter().map(|c| tables().product(&seen, &c).flux.x).sum::<f32>() / seen.flux.x
}

fn angle_of(dist: f32) -> f64 {
    (0.5 / f64::from(dist)).atan()
}

/// Full cover of a Lambert receiver that faces the light, at the distances that the weights are solved for.
#[test]
fn full_cover_is_dark() {
    let facing = receiver(unit(DVec3::new(0.3, -0.5, 0.8)));
    let lambert = Lobe::new(facing.normal, 1.0, Vec3::ONE);
    for depth in 1..=MAX_DEPTH {
        let tables = tables();
        let started = Instant::now();
        let weights = PaperWeights::solve(depth, tables);
        let seconds = started.elapsed().as_secs_f64();
        println!("depth {depth}: weights in {:.1} ms", 1e3 * seconds);
        assert!(seconds < 1.0, "{seconds} s");
        for dist in PaperWeights::DISTANCES {
            let cone = cone(facing.normal, angle_of(dist));
            let mut shapes = Shapes::at(cone.axis);
            shapes.all = true;
            let root = visibility_sum(&shapes, &weights, &facing, lambert, &cone);
            // A blocker just larger than the light, which the mask draws and no shortcut finds.
            shapes.all = false;
            shapes.discs = vec![(DVec2::ZERO, 1.02 * angle_of(dist).tan())];
            let disc = visibility_sum(&shapes, &weights, &facing, lambert, &cone);
            assert!(root.abs() <= 0.01 && disc.abs() <= 0.01, "depth {depth}, dist {dist}: {root} {disc}");
        }
    }
}

/// Weights are solved for one receiver; others keep some light in the umbra, or would have less than none.
#[test]
fn umbra_of_other_receivers() {
    let weights = PaperWeights::solve(5, tables());
    println!("V of a whole cover before clamping: Lambert at 0°, 30°, 60°, 80°; Phong 20 and 200 at 0°, 10°");
    for theta in [1.0f64, 6.0, 15.0, 35.0] {
        let cone = cone(Vec3::Z, theta.to_radians());
        let mut shapes = Shapes::at(Vec3::Z);
        shapes.all = true;
        let tilted = |degrees: f32| Vec3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos());
        let v = |exponent: f32, degrees: f32| {
            let at = receiver(if exponent == 1.0 { tilted(degrees) } else { Vec3::Z });
            visibility_sum(&shapes, &weights, &at, Lobe::new(tilted(degrees), exponent, Vec3::ONE), &cone)
        };
        let lambert = [0.0, 30.0, 60.0, 80.0].map(|d| v(1.0, d));
        let phong = [(20.0, 0.0), (20.0, 10.0), (200.0, 0.0), (200.0, 10.0)].map(|(e, d)| v(e, d));
        println!("{theta:3}°: {lambert:+.3?} {phong:+.3?}");
        assert!(lambert[..3].iter().all(|v| v.abs() < 0.06), "{theta}");
        assert!(lambert.iter().chain(&phong).all(|v| (-1.0..0.3).contains(v)), "{theta}");
    }
}

/// The light that each node of each level hides by itself, by level, row and column.
fn parts(weights: &PaperWeights, cone: &Cone) -> Vec<Vec<f32>> {
    let facing = receiver(cone.axis);
    let lambert = Lobe::new(cone.axis, 1.0, Vec3::ONE);
    let part = |level: u32, k: usize| {
        let side = 1usize << level;
        let mut shapes = Shapes::at(cone.axis);
        shapes.cells = (side, vec![(k % side, k / side)]);
        1.0 - visibility_sum(&shapes, weights, &facing, lambert, cone)
    };
    (0..=weights.depth()).map(|level| (0..1 << (2 * level)).map(|k| part(level, k)).collect()).collect()
}

/// The largest change of V when the four children of a node become that node, by the node's level.
fn largest_merge(parts: &[Vec<f32>]) -> Vec<f32> {
    let children = |level: usize, k: usize| {
        let (x, y) = (k % (1 << level), k >> level);
        [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| parts[level + 1][((2 * y + dy) << (level + 1)) + 2 * x + dx])
    };
    let change = |level: usize, k: usize| {
        let four = children(level, k);
        // Nodes on the rim have children outside the disc, and merge with fewer.
        if four.contains(&0.0) { 0.0 } else { (parts[level][k] - four.iter().sum::<f32>()).abs() }
    };
    (0..parts.len() - 1).map(|l| (0..parts[l].len()).map(|k| change(l, k)).fold(0.0, f32::max)).collect()
}

/// The nodes of one level together hide all light, by the sum of the light that each hides by itself.
#[test]
fn each_level_covers_alone() {
    let weights = PaperWeights::solve(4, tables());
    println!("whole cover by the nodes of level 0…4, and the largest change as four nodes of level 1…4 merge");
    for dist in [0.25, 0.5, 1.0, 4.0, 10.0, 28.6, 114.6] {
        let parts = parts(&weights, &cone(Vec3::Z, angle_of(dist)));
        let totals: Vec<f32> = parts.iter().map(|level| level.iter().sum()).collect();
        let merges = largest_merge(&parts);
        println!("dist {dist:5}: {totals:.3?} {merges:.4?}");
        for (level, total) in totals.iter().enumerate().filter(|_| dist <= 10.0) {
            // A node that is its parent's only one in the disc is replaced by the parent, which hides more.
            assert!((-0.01..0.04).contains(&(total - 1.0)), "level {level}, dist {dist}: {total}");
        }
        assert!(dist > 10.0 || merges.iter().all(|m| *m < 0.008), "dist {dist}");
    }
}

#[test]
fn without_blockers_nothing_is_lost() {
    let weights = PaperWeights::solve(5, tables());
    let mut random = Random::new(3);
    for _ in 0..100 {
        let normal = random.axis();
        let (at, theta) = (receiver(unit(normal)), random.log_uniform(0.001, 1.5));
        let cone = cone(unit(random.axis_at(normal, 0.5)), theta);
        let shapes = Shapes::at(cone.axis);
        let strategy = PaperVisibility::new(&shapes, tables()).with_weights(weights.clone());
        let lit = shade(
            &PaperIntegrator { tables: tables() },
            &strategy,
            5,
            &at,
            Lobe::new(at.normal, 1.0, Vec3::ONE),
            &cone,
        );
        assert_eq!(lit.radiance, lit.unshadowed);
        // A blocker beside the light.
        let beside = Shapes { discs: vec![(DVec2::new(3.0 * theta.tan(), 0.0), theta.tan())], ..shapes };
        let strategy = PaperVisibility::new(&beside, tables()).with_weights(weights.clone());
        let lit = shade(
            &PaperIntegrator { tables: tables() },
            &strategy,
            5,
            &at,
            Lobe::new(at.normal, 1.0, Vec3::ONE),
            &cone,
        );
        assert_eq!(lit.radiance, lit.unshadowed);
    }
}

/// Leaves are covered one after the other in random order; nodes merge on the way.
#[test]
fn more_cover_is_darker_but_for_merges() {
    let facing = receiver(Vec3::Z);
    let lambert = Lobe::new(Vec3::Z, 1.0, Vec3::ONE);
    let mut random = Random::new(5);
    for depth in [3, 4, 5] {
        let weights = PaperWeights::solve(depth, tables());
        let side = 1usize << depth;
        let distances: &[f32] = if depth == 5 { &[1.0, 10.0] } else { &[0.25, 0.5, 0.6, 1.0, 1.87, 5.0, 10.0, 28.6] };
        for &dist in distances {
            let cone = cone(Vec3::Z, angle_of(dist));
            let (mut worst, mut least, mut last) = (0.0f32, 1.0f32, 1.0f32);
            for _ in 0..if depth == 5 { 1 } else { 4 } {
                let mut order: Vec<_> = (0..side * side).map(|k| (k % side, k / side)).collect();
                for k in (1..order.len()).rev() {
                    order.swap(k, (random.bits() % (k as u64 + 1)) as usize);
                }
                let mut shapes = Shapes::at(Vec3::Z);
                shapes.cells = (side, Vec::new());
                last = 1.0;
                for leaf in order {
                    shapes.cells.1.push(leaf);
                    let now = visibility_sum(&shapes, &weights, &facing, lambert, &cone);
                    worst = worst.max(now - last);
                    least = least.min(now);
                    last = now;
                }
            }
            // One weight a level cannot make a node and its children equal everywhere: a merge may restore a part of the last
            // leaf's light. Beyond the last distance of the table it restores more.
            let within = PaperWeights::DISTANCES.contains(&dist);
            let rise = if depth == 3 && within {
                1e-5
            } else if within {
                0.01
            } else {
                0.03
            };
            let full = if within { 1e-3 } else { 0.05 };
            assert!(worst <= rise, "depth {depth}, dist {dist}: a leaf more brightens by {worst}");
            assert!(last.abs() <= full && least >= last.min(0.0) - rise, "depth {depth}, dist {dist}: {last} {least}");
            println!("depth {depth}, dist {dist}: largest rise {worst:.5}, least {least:.4}, full cover {last:.4}");
        }
    }
}

struct Case {
    at: Receiver,
    cone: Cone,
    shapes: Shapes,
    f: Lobe,
}

/// A light of half-angle θ above the horizon, with one to five discs of blockers or a half-plane in front of it.
fn case(random: &mut Random, theta: f64, exponent: f64) -> Case {
    let (normal, tilt) = (random.axis(), random.between(0.0, 1.2));
    let axis = random.axis_at(normal, tilt);
    let cone = cone(unit(axis), theta);
    let tan = theta.tan();
    let mut shapes = Shapes::at(cone.axis);
    let direction = |random: &mut Random| DVec2::from_angle(random.between(0.0, core::f64::consts::TAU));
    if random.bits().is_multiple_of(4) {
        shapes.halves.push((direction(random), tan * random.between(-1.0, 1.0)));
    } else {
        for _ in 0..1 + random.bits() % 5 {
            let radius = tan * random.log_uniform(0.1, 3.0);
            let offset =
                if radius > tan { random.between(radius - tan, radius + tan) } else { tan * random.uniform().sqrt() };
            shapes.discs.push((direction(random) * offset, radius));
        }
    }
    let at = receiver(unit(normal));
    let f = if exponent == 1.0 {
        Lobe::new(at.normal, 1.0, Vec3::ONE)
    } else {
        let off = random.between(0.0, theta + 1.0 / exponent.sqrt());
        Lobe::new(unit(random.axis_at(cone.axis.as_dvec3(), off)), exponent as f32, Vec3::ONE)
    };
    Case { at, cone, shapes, f }
}

/// Lit and whole integral of `f̃` over the light, midpoint rule on the plane.
fn truth(case: &Case) -> (f64, f64) {
    const N: i32 = 200;
    let Shapes { axis, right, up, .. } = case.shapes;
    let tan = f64::from(case.cone.sin_sq()).sqrt() / f64::from(case.cone.cos());
    let a = case.f.axis.as_dvec3().normalize();
    let (mut lit, mut all) = (0.0, 0.0);
    let step = 2.0 * tan / f64::from(N);
    for j in 0..N {
        for i in 0..N {
            let p = DVec2::new(f64::from(i) + 0.5, f64::from(j) + 0.5) * step - DVec2::splat(tan);
            if p.length_squared() >= tan * tan {
                continue;
            }
            let length_sq = 1.0 + p.length_squared();
            let v = (right * p.x + up * p.y + axis) / length_sq.sqrt();
            let value = a.dot(v).max(0.0).powf(f64::from(case.f.exponent)) * length_sq.powf(-1.5) * step * step;
            all += value;
            lit += if case.shapes.blocks(p) { 0.0 } else { value };
        }
    }
    (lit, all)
}

/// Mean, signed mean and largest of errors.
fn summary(errors: &[f64]) -> [f64; 3] {
    let n = errors.len() as f64;
    let mean = |f: fn(f64) -> f64| errors.iter().copied().map(f).sum::<f64>() / n;
    [mean(f64::abs), mean(|e| e), errors.iter().fold(0.0, |m: f64, e| m.max(e.abs()))]
}

#[test]
fn error_against_brute_force() {
    println!("% of the unshadowed radiance: mean (signed mean) largest; penumbrae, random blockers");
    println!("  θ    e depth | of V                  | of the radiance       | moments, radiance");
    let weights = [4, 5, 6].map(|depth| PaperWeights::solve(depth, tables()));
    for theta in [1.0f64, 6.0, 15.0] {
        for exponent in [1.0, 20.0] {
            let mut random = Random::new(23);
            let mut errors = [(); 3].map(|()| [(); 3].map(|()| Vec::new()));
            while errors[0][0].len() < 150 {
                let case = case(&mut random, theta.to_radians(), exponent);
                let (lit, all) = truth(&case);
                if !(0.02..=0.98).contains(&(lit / all)) {
                    continue;
                }
                for (weights, [visibility, radiance, moments]) in weights.iter().zip(&mut errors) {
                    let strategy = PaperVisibility::new(&case.shapes, tables()).with_weights(weights.clone());
                    let paper = shade(
                        &PaperIntegrator { tables: tables() },
                        &strategy,
                        weights.depth(),
                        &case.at,
                        case.f,
                        &case.cone,
                    );
                    let (seen, unshadowed) = (f64::from(paper.radiance.x), f64::from(paper.unshadowed.x));
                    assert!((0.0..=unshadowed).contains(&seen), "{seen} of {unshadowed}");
                    visibility.push(seen / unshadowed - lit / all);
                    radiance.push((seen - lit) / all);
                    let mask = MaskVisibility::new(&case.shapes);
                    let other = shade(&FractionIntegrator, &mask, weights.depth(), &case.at, case.f, &case.cone);
                    moments.push((f64::from(other.radiance.x) - lit) / all);
                }
            }
            if exponent == 1.0 {
                // There are fewer partly covered leaves: depth helps a diffuse receiver.
                let mean = errors.each_ref().map(|e| summary(&e[0])[0]);
                assert!(mean[2] < mean[1] && mean[1] < mean[0], "{mean:?}");
            }
            for (weights, errors) in weights.iter().zip(&errors) {
                let of_v = &errors[0];
                let [visibility, radiance, moments] = errors.each_ref().map(|e| {
                    let [mean, signed, most] = summary(e).map(|error| 100.0 * error);
                    format!("{mean:5.2} ({signed:+6.2}) {most:6.2}")
                });
                let [mean, _, most] = summary(of_v);
                assert!(mean < 0.07 && most < 0.2, "{mean} {most}");
                println!("{theta:3}° {exponent:4} {:5} | {visibility} | {radiance} | {moments}", weights.depth());
            }
        }
    }
}

/// A product of `f̃·L` with a visibility lobe is dropped below the threshold, too (t_i of §4.3).
#[test]
fn threshold_drops_visibility_products() {
    #[derive(Default)]
    struct Pruned(usize);
    impl Observer for Pruned {
        fn prune(&mut self) {
            self.0 += 1;
        }
    }
    let at = receiver(Vec3::Z);
    let cone = cone(Vec3::Z, 0.1);
    let mut shapes = Shapes::at(Vec3::Z);
    shapes.discs.push((DVec2::new(0.03, 0.02), 0.04));
    let strategy = PaperVisibility::new(&shapes, tables());
    let accuracy = Accuracy { tolerance: 0.003, depth: 5 };
    let brdf = [Lobe::new(Vec3::Z, 1.0, Vec3::ONE).into()];
    let light = SeenLight::of_cone(cone, Vec3::ONE);
    let (mut scratch, mut sum) = (strategy.scratch(), VisibilitySum::default());
    let mut before = (0, 0.0);
    for threshold in [0.0, 1e-5, 3e-5, 1e-4, 1e-3] {
        let mut observer = Pruned::default();
        let mut visit = LightVisibility::alone(&strategy, LightId(0), accuracy, &mut scratch);
        let call = Interaction { at: &at, brdf: &brdf, light: &light, threshold };
        let lit = PaperIntegrator { tables: tables() }.radiance(&call, &mut visit, &mut sum, &mut observer);
        println!("{threshold} {} of {} {}", observer.0, sum.lobes.lobes().len(), lit.radiance.x);
        // Each lost lobe makes the shadow lighter by less than the threshold.
        assert!(observer.0 >= before.0 && lit.radiance.x >= before.1);
        assert!(lit.radiance.x <= lit.unshadowed.x);
        before = (observer.0, lit.radiance.x);
    }
    assert!(before.0 > 0);
}
