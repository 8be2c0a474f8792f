//! Meshes, and the visible fraction of a light from rays in f64.
#![allow(dead_code, reason = "each test uses a part")]

use glam::{DVec3, Vec3};
use lobe_core::{Cone, Receiver, Sphere};
use shading::{Accuracy, Coverage, LightId, VisibilityQuery};
use visibility_mask::{Blockers, Mask, UnitSquare};
use visibility_shadowmap::{MapOptions, ShadowMap, ShadowMapBlockers, ShadowMapScratch};

#[derive(Clone, Debug, Default)]
pub(crate) struct Mesh {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Mesh {
    pub(crate) fn quad(mut self, corners: [Vec3; 4]) -> Self {
        let first = self.positions.len() as u32;
        self.positions.extend(corners);
        self.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        self
    }

    pub(crate) fn cuboid(mut self, low: Vec3, high: Vec3) -> Self {
        let first = self.positions.len() as u32;
        self.positions
            .extend((0..8).map(|k| Vec3::select(glam::BVec3::new(k & 1 == 1, k & 2 == 2, k & 4 == 4), high, low)));
        for [a, b, c, d] in [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]] {
            self.triangles.extend([[first + a, first + b, first + c], [first + a, first + c, first + d]]);
        }
        self
    }

    /// A closed sphere of `2 n²` quadrilaterals.
    pub(crate) fn sphere(mut self, center: Vec3, radius: f32, n: u32) -> Self {
        let first = self.positions.len() as u32;
        for j in 0..=n {
            for i in 0..2 * n {
                let (polar, around) =
                    (std::f32::consts::PI * j as f32 / n as f32, std::f32::consts::PI * i as f32 / n as f32);
                let (sin, cos) = polar.sin_cos();
                self.positions.push(center + radius * Vec3::new(sin * around.cos(), cos, sin * around.sin()));
            }
        }
        for j in 0..n {
            for i in 0..2 * n {
                let at = |i: u32, j: u32| first + j * 2 * n + i % (2 * n);
                self.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                self.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        self
    }

    /// 31 thin pickets and two rails: `picket_fence.obj` of the shared test meshes, in code.
    pub(crate) fn fence() -> Self {
        let mut mesh = Self::default();
        for k in 0..31_i16 {
            let x = -1.5 + 0.1 * f32::from(k);
            mesh = mesh.cuboid(Vec3::new(x - 0.025, 0.0, -0.01), Vec3::new(x + 0.025, 1.0, 0.01));
        }
        for y in [0.3, 0.7] {
            mesh = mesh.cuboid(Vec3::new(-1.525, y - 0.03, 0.01), Vec3::new(1.525, y + 0.03, 0.03));
        }
        mesh
    }

    pub(crate) fn map(&self, light: Sphere, options: &MapOptions) -> ShadowMap {
        ShadowMap::build(&self.positions, &self.triangles, light, options).expect("a good mesh")
    }

    fn hit(&self, triangle: [u32; 3], origin: DVec3, direction: DVec3, far: f64) -> bool {
        let [a, b, c] = triangle.map(|v| self.positions[v as usize].as_dvec3());
        let (e1, e2) = (b - a, c - a);
        let p = direction.cross(e2);
        let determinant = e1.dot(p);
        if determinant == 0.0 {
            return false;
        }
        let s = (origin - a) / determinant;
        let (u, q) = (s.dot(p), s.cross(e1));
        let (v, t) = (direction.dot(q), e2.dot(q));
        u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 1e-6 && t < far
    }

    /// The visible fraction of the light's disc above the horizon from a point, by `side²` rays in its square.
    pub(crate) fn seen(&self, at: &Receiver, light: Sphere, side: usize) -> f64 {
        self.seen_by(at, light, side, |_| 1.0)
    }

    /// The same, weighted by a function of the direction.
    pub(crate) fn seen_by(&self, at: &Receiver, light: Sphere, side: usize, weight: impl Fn(DVec3) -> f64) -> f64 {
        let cone = Cone::of_sphere(at.position, light);
        let square = UnitSquare::facing(&cone, Vec3::new(0.3, 0.5, -0.8));
        let (origin, normal) = (at.position.as_dvec3(), at.normal.as_dvec3());
        let (radius, center) = (f64::from(light.radius), light.center.as_dvec3() - origin);
        // Keeps only triangles whose bounding sphere meets the cone.
        let candidates: Vec<_> = self
            .triangles
            .iter()
            .copied()
            .filter(|t| {
                let [a, b, c] = t.map(|v| self.positions[v as usize].as_dvec3() - origin);
                let middle = (a + b + c) / 3.0;
                let size = [a, b, c].map(|p| p.distance(middle)).into_iter().fold(0.0, f64::max);
                let along = middle.dot(center) / center.length_squared();
                let off = middle.distance(center * along);
                off <= size + radius * 1.1 * (along.max(0.0) + size / center.length())
                    && along > -size / center.length()
            })
            .collect();
        let (mut all, mut seen) = (0.0, 0.0);
        for k in 0..side * side {
            let cell = |k: usize| ((k as f64 + 0.5) / side as f64 * 2.0 - 1.0) * f64::from(square.half.x);
            let (x, y) = (cell(k % side), cell(k / side));
            let direction =
                (square.right.as_dvec3() * x + square.up.as_dvec3() * y + square.axis.as_dvec3()).normalize();
            if x * x + y * y > f64::from(square.disc).powi(2) || direction.dot(normal) <= 0.0 {
                continue;
            }
            let weight = weight(direction);
            all += weight;
            let along = center.dot(direction);
            let far = along - (radius * radius - (center - direction * along).length_squared()).max(0.0).sqrt();
            if weight > 0.0 && !candidates.iter().any(|t| self.hit(*t, origin, direction, far)) {
                seen += weight;
            }
        }
        if all > 0.0 { seen / all } else { 0.0 }
    }
}

/// A receiver that faces along `normal`.
pub(crate) fn receiver(position: Vec3, normal: Vec3) -> Receiver {
    Receiver::on_surface(position, normal, normal).on_object(0)
}

/// The visible fraction of the light's disc by the strategy.
pub(crate) fn share(blockers: &ShadowMapBlockers, scratch: &mut ShadowMapScratch, at: &Receiver, light: Sphere) -> f64 {
    let cone = Cone::of_sphere(at.position, light);
    let query = VisibilityQuery::new(at, LightId(0), &cone, Accuracy::new(0.003));
    if blockers.select(&query, scratch) == Coverage::Lit {
        return 1.0;
    }
    let mut mask = Mask::default();
    mask.reset(&UnitSquare::facing(&cone, blockers.across(&query, scratch)), 5, at.normal);
    blockers.splat(&query, scratch, &mut mask);
    let (all, seen) = mask.areas();
    // Both are rounded sums; NaN if nothing is above the horizon.
    f64::from(if seen >= all { 1.0_f32.min(seen / all) } else { seen / all })
}

/// Errors of the visible fraction over some receivers.
#[derive(Debug, Default)]
pub(crate) struct Errors {
    pub(crate) penumbra: Vec<f64>,
    pub(crate) umbra: Vec<f64>,
    pub(crate) lit: Vec<f64>,
}

impl Errors {
    pub(crate) fn of(mesh: &Mesh, receivers: &[Receiver], light: Sphere, options: &MapOptions) -> Self {
        let blockers = ShadowMapBlockers::new(vec![mesh.map(light, options)]);
        let (mut scratch, mut errors) = (blockers.scratch(), Self::default());
        for at in receivers {
            let (truth, value) = (mesh.seen(at, light, 40), share(&blockers, &mut scratch, at, light));
            if truth > 0.99 {
                errors.lit.push((truth - value).abs());
            } else if truth < 0.01 {
                errors.umbra.push(value);
            } else {
                errors.penumbra.push((truth - value).abs());
            }
        }
        errors
    }

    pub(crate) fn means(&self) -> [f64; 3] {
        let mean = |v: &[f64]| 100.0 * v.iter().sum::<f64>() / v.len().max(1) as f64;
        [mean(&self.penumbra), mean(&self.umbra), mean(&self.lit)]
    }

    /// Asserts the three means in percent, and that each class has receivers.
    #[track_caller]
    pub(crate) fn below(&self, what: &str, penumbra: f64, umbra: f64, lit: f64) {
        let [p, u, l] = self.means();
        let counts = [self.penumbra.len(), self.umbra.len(), self.lit.len()];
        println!("{what}: penumbra {p:.2} %, umbra {u:.3} %, lit {l:.3} % of {counts:?}");
        assert!(counts[0] >= 20, "{what}: {counts:?}");
        assert!(p <= penumbra && u <= umbra && l <= lit, "{what}: {p} {u} {l}");
    }
}
