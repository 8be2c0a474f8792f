//! The visible fraction of microfacets' light behind an edge: against the sum over the light in f64, and without pops.

use glam::{DVec3, Vec3};
use lobe_core::oracle::{CapMicrofacets, Random};
use lobe_core::{BrdfLobe, Cone, Grain, Microfacets, Receiver, SeenLight, orthonormal_basis};
use shading::{
    Accuracy, Coverage, FractionIntegrator, Integrator, Interaction, LightId, LightVisibility, Visibility,
    VisibilityQuery,
};
use visibility_mask::{Blockers, Edges, Mask, MaskVisibility};

/// Hides all directions on one side of a plane through the receiver.
struct Edge {
    hidden: Vec3,
}

impl Blockers for Edge {
    type Scratch = ();
    fn scratch(&self) {}
    fn select(&self, _: &VisibilityQuery<'_>, (): &mut ()) -> Coverage {
        Coverage::Partial
    }
    fn edges(&self, query: &VisibilityQuery<'_>, (): &(), edges: &mut Edges) {
        edges.add_plane(self.hidden, query.cone);
    }
    fn splat(&self, _: &VisibilityQuery<'_>, (): &mut (), mask: &mut Mask) {
        let plane = mask.square().local(self.hidden);
        for row in 0..mask.side() {
            let end = -(plane.y * mask.row_y(row) + plane.z) / plane.x;
            let (from, to) = if plane.x > 0.0 { (end, f32::INFINITY) } else { (f32::NEG_INFINITY, end) };
            mask.block_span(row, from, to);
        }
    }
}

/// A view, a light and an edge.
#[derive(Clone, Copy, Debug)]
struct Case {
    view: DVec3,
    alpha: f64,
    axis: DVec3,
    half_angle: f64,
    hidden: DVec3,
}

impl Case {
    fn random(random: &mut Random) -> Self {
        let (tilt, half_angle, alpha) =
            (random.between(0.0, 1.2), random.log_uniform(0.02, 0.4), random.log_uniform(0.01, 0.6));
        let view = DVec3::new(f64::sin(tilt), 0.0, f64::cos(tilt));
        let mirror = DVec3::new(-view.x, 0.0, view.z);
        // Above the horizon, so that the light's own integral is the oracle's.
        let aside = random.uniform() * half_angle;
        let mut axis = random.axis_at(mirror, aside);
        while axis.z < half_angle.sin() + 0.01 {
            axis = (axis + 0.1 * DVec3::Z).normalize();
        }
        Self { view, alpha, axis, half_angle, hidden: axis }.with_edge(random.between(-0.7, 0.7), random.uniform())
    }

    /// An edge between the light's rims, at a place from −1 to 1, with a direction in turns.
    fn with_edge(self, place: f64, turn: f64) -> Self {
        let (right, up) = orthonormal_basis(self.axis.as_vec3());
        let (sin, cos) = (turn * core::f64::consts::TAU).sin_cos();
        let across = right.as_dvec3() * cos + up.as_dvec3() * sin;
        let (s, c) = (place * self.half_angle).sin_cos();
        Self { hidden: (across * c - self.axis * s).normalize(), ..self }
    }

    /// The visible fraction of both lobes, from masks.
    fn seen(&self, tolerance: f32) -> f64 {
        self.seen_with(tolerance, None)
    }

    /// The same of microfacets with a grain.
    fn seen_with(&self, tolerance: f32, grain: Option<Grain>) -> f64 {
        let view = self.view.as_vec3();
        let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, view);
        let one_minus_cos = (2.0 * (0.5 * self.half_angle).sin().powi(2)) as f32;
        let cone = Cone { axis: self.axis.as_vec3().normalize(), one_minus_cos, distance: f32::INFINITY };
        let strategy = MaskVisibility::new(Edge { hidden: self.hidden.as_vec3() });
        let (accuracy, mut scratch) = (Accuracy::new(tolerance), strategy.scratch());
        let both = Microfacets::new(view, self.alpha as f32, [Vec3::splat(0.8), Vec3::ONE]);
        let both = both.map(|facets| BrdfLobe::Microfacets(facets.with_grain(grain)));
        let light = SeenLight::of_cone(cone, Vec3::ONE);
        let call = Interaction { at: &at, brdf: &both, light: &light, threshold: 0.0 };
        let mut visit = LightVisibility::alone(&strategy, LightId(0), accuracy, &mut scratch);
        let lit = FractionIntegrator.radiance(&call, &mut visit, &mut (), &mut ());
        f64::from(lit.radiance.x / lit.unshadowed.x)
    }

    /// The same in f64, summed over the half vectors' slopes in steps for which the cosine lobe is even.
    fn exact(&self) -> f64 {
        let model = CapMicrofacets { view: self.view, alpha: self.alpha };
        let (mut lit, mut all) = (0.0, 0.0);
        const SIDE: u32 = 1200;
        for i in 0..SIDE {
            // |σ|² = t/(1 − t) has t uniform over the lobe.
            let t = (f64::from(i) + 0.5) / f64::from(SIDE);
            let slope = self.alpha * (t / (1.0 - t)).sqrt();
            for j in 0..SIDE {
                let turn = (f64::from(j) + 0.5) / f64::from(SIDE) * core::f64::consts::TAU;
                let h = DVec3::new(slope * turn.cos(), slope * turn.sin(), 1.0).normalize();
                let vh = self.view.dot(h);
                let v = 2.0 * vh * h - self.view;
                if vh <= 0.0 || v.z <= 0.0 || v.dot(self.axis) < self.half_angle.cos() {
                    continue;
                }
                let [base, edge] = model.value(v);
                // D·(n·h) dω_h is uniform; the rest of the reflectance is its weight.
                let a2 = self.alpha * self.alpha;
                let d = a2 / (core::f64::consts::PI * (1.0 - h.z * h.z * (1.0 - a2)).powi(2));
                let weight = (0.8 * base + edge) / d * vh / h.z;
                all += weight;
                if v.dot(self.hidden) < 0.0 {
                    lit += weight;
                }
            }
        }
        lit / all
    }

    /// The same of microfacets that are rougher along a direction.
    fn exact_along(&self, along: DVec3, rough: f64) -> f64 {
        let (beside, mut lit, mut all) = (DVec3::Z.cross(along), 0.0, 0.0);
        let smith =
            |v: DVec3| ((rough * v.dot(along)).powi(2) + (self.alpha * v.dot(beside)).powi(2) + v.z * v.z).sqrt();
        const SIDE: u32 = 1600;
        for i in 0..SIDE {
            let t = (f64::from(i) + 0.5) / f64::from(SIDE);
            let slope = (t / (1.0 - t)).sqrt();
            for j in 0..SIDE {
                let (sin, cos) = ((f64::from(j) + 0.5) / f64::from(SIDE) * core::f64::consts::TAU).sin_cos();
                let h = (along * (rough * slope * cos) + beside * (self.alpha * slope * sin) + DVec3::Z).normalize();
                let vh = self.view.dot(h);
                let v = 2.0 * vh * h - self.view;
                if vh <= 0.0 || v.z <= 0.0 || v.dot(self.axis) < self.half_angle.cos() {
                    continue;
                }
                let masking = 0.5 * v.z / (v.z * smith(self.view) + self.view.z * smith(v));
                let s = (1.0 - vh).powi(5);
                let weight = masking * (0.8 * (1.0 - s) + s) * vh / h.z;
                all += weight;
                if v.dot(self.hidden) < 0.0 {
                    lit += weight;
                }
            }
        }
        lit / all
    }
}

#[test]
fn fractions_with_a_grain_are_those_of_quadrature() {
    let mut random = Random::new(23);
    let (mut sum, mut worst, count) = (0.0, 0.0_f64, 24);
    for _ in 0..count {
        let case = Case { alpha: random.log_uniform(0.05, 0.4), ..Case::random(&mut random) };
        let tangent = DVec3::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0), 0.0).as_vec3();
        let view = case.view.as_vec3();
        let grain = Grain::new(Vec3::Z, view, tangent, random.between(0.2, 0.9) as f32);
        let along = grain.direction(Vec3::Z, view).as_dvec3().normalize();
        let want = case.exact_along(along, f64::from(grain.alpha(case.alpha as f32)));
        let error = (case.seen_with(0.003, Some(grain)) - want).abs();
        sum += error / f64::from(count);
        worst = worst.max(error);
    }
    println!("with a grain: mean {sum:.1e}, worst {worst:.1e}");
    assert!(sum < 0.003 && worst < 0.02, "{sum} {worst}");
}

#[test]
fn fractions_are_those_of_quadrature() {
    let mut random = Random::new(21);
    let cases: Vec<Case> = (0..60).map(|_| Case::random(&mut random)).collect();
    let wants: Vec<f64> = cases.iter().map(Case::exact).collect();
    for (tolerance, mean_limit, worst_limit) in [(0.01, 0.003, 0.02), (0.003, 0.001, 0.008), (0.001, 0.0008, 0.006)] {
        let errors: Vec<f64> =
            cases.iter().zip(&wants).map(|(case, want)| (case.seen(tolerance) - want).abs()).collect();
        let (mean, worst) = (errors.iter().sum::<f64>() / 60.0, errors.iter().fold(0.0_f64, |a, b| a.max(*b)));
        println!("tolerance {tolerance}: mean {mean:.1e}, worst {worst:.1e}");
        assert!(mean < mean_limit && worst < worst_limit, "{tolerance}: {mean} {worst}");
    }
}

/// Edges, lights and views that move in small steps: the change of the error between pictures.
#[test]
fn nothing_pops() {
    for (tolerance, most, often) in [(0.01_f32, 0.01, 0.004), (0.003, 0.006, 0.002), (0.001, 0.006, 0.0005)] {
        let mut random = Random::new(22);
        let mut jumps = Vec::new();
        for sweep in 0..40 {
            let start = Case::random(&mut random);
            let (turn, aside) = (random.uniform(), random.axis());
            let error = |step: u32| {
                let x = f64::from(step) / 200.0;
                let moved = match sweep % 3 {
                    0 => start.with_edge(1.4 * x - 0.7, turn),
                    1 => Case { axis: (start.axis + aside * (0.3 * x * start.half_angle)).normalize(), ..start },
                    _ => Case { view: (start.view + aside * (0.6 * x * start.half_angle)).normalize(), ..start },
                };
                moved.seen(tolerance) - moved.seen(1e-5)
            };
            let errors: Vec<f64> = (0..200).map(error).collect();
            jumps.push(errors.windows(2).map(|e| (e[1] - e[0]).abs()).fold(0.0, f64::max));
        }
        jumps.sort_by(f64::total_cmp);
        println!("tolerance {tolerance}: largest jump {:.1e}, 95 % below {:.1e}", jumps[39], jumps[37]);
        assert!(jumps[39] < most && jumps[20] < often, "{tolerance}: {jumps:?}");
    }
}
