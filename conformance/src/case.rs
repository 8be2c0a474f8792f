//! One receiver, one light, some spheres.

use crate::{Setting, Subject, Visitor};
use core::f64::consts::{PI, TAU};
use glam::{DQuat, DVec3, Vec3};
use lobe_core::oracle::Random;
use lobe_core::{Cone, Lobe, Receiver, Sphere, cap_integral};
use shading::{
    Accuracy, Coverage, DynVisibility, LightCoverage, LightId, LightVisibility, Shaft, Visibility, VisibilityQuery,
};

/// The light's distance in random cases.
pub(crate) const FAR: f64 = 10.0;

/// The accuracy of all cases.
const ACCURACY: Accuracy = Accuracy { tolerance: 0.003, depth: 5 };

/// The only light.
const LIGHT: LightId = LightId(0);

/// Half-angles of lights in random cases, radians.
const HALF_ANGLES: [f64; 3] = [0.02, 0.14, 0.44];

/// Spheres of [`Case::crowd`].
const CROWD: usize = 60;

/// Groups of receivers in [`Use::Entered`]: their radii, and whether they are in a narrow box.
const GROUPS: [(f32, bool); 4] = [(0.05, false), (0.05, true), (0.8, false), (0.8, true)];

/// Half-angle of a light that fills nearly half of the sky.
pub(crate) const WIDE: f64 = 1.0;

/// A sphere in f64.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sphere64 {
    pub(crate) center: DVec3,
    pub(crate) radius: f64,
}

impl Sphere64 {
    fn rounded(self) -> Sphere {
        Sphere { center: self.center.as_vec3(), radius: self.radius as f32 }
    }
}

/// Everything in f64, so that it can be turned before it is rounded.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    pub(crate) position: DVec3,
    pub(crate) normal: DVec3,
    pub(crate) light: Sphere64,
    pub(crate) spheres: Vec<Sphere64>,
    /// Axis and exponent of the reflectance lobe; exponent 1 is Lambert.
    pub(crate) lobe: (DVec3, f64),
}

/// In which way a strategy is used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Use {
    /// With fresh scratch.
    Fresh,
    /// With scratch that the given other case has used.
    Used,
    /// After `enter` with a small and with a large group.
    Entered,
    /// As `Box<dyn DynVisibility>`.
    Boxed,
    /// By several threads at once, each with scratch of its own.
    Threads,
}

/// Threads of [`Use::Threads`].
const THREADS: usize = 3;

impl Case {
    /// No spheres yet; the light is above the horizon or, one time in four, crosses it.
    pub(crate) fn random(random: &mut Random) -> Self {
        let theta = HALF_ANGLES[(random.bits() % 3) as usize];
        Self::lit_by(random, theta)
    }

    /// A light of half-angle `theta`.
    pub(crate) fn lit_by(random: &mut Random, theta: f64) -> Self {
        let axis = random.axis();
        let beta = if random.bits().is_multiple_of(4) {
            0.5 * PI + random.between(-0.8, 0.5) * theta
        } else {
            random.between(0.0, 0.5 * PI - 1.05 * theta)
        };
        let normal = random.axis_at(axis, beta);
        let position = random.axis();
        let light = Sphere64 { center: position + axis * FAR, radius: FAR * theta.sin() };
        let exponent = [1.0, 1.0, 20.0, 500.0][(random.bits() % 4) as usize];
        let off = random.between(0.0, theta);
        let lobe = if exponent == 1.0 { normal } else { random.axis_at(axis, off) };
        Self { position, normal, light, spheres: Vec::new(), lobe: (lobe, exponent) }
    }

    /// Direction of the light's centre, half-angle.
    pub(crate) fn cone(&self) -> (DVec3, f64) {
        let to = self.light.center - self.position;
        (to.normalize(), (self.light.radius / to.length()).asin())
    }

    /// A sphere of angular radius `size` at the angle `off` from the light's centre.
    pub(crate) fn sphere(&self, random: &mut Random, size: f64, off: f64, distance: f64) -> Sphere64 {
        let center = self.position + random.axis_at(self.cone().0, off) * distance;
        Sphere64 { center, radius: distance * size.sin() }
    }

    /// A sphere that hides some of the light.
    pub(crate) fn blocker(&self, random: &mut Random) -> Sphere64 {
        let theta = self.cone().1;
        let size = (theta * random.log_uniform(0.2, 4.0)).min(1.1);
        let off = random.between((size - theta).abs(), size + theta).min(1.4);
        let distance = random.between(1.0, 0.45 * FAR);
        self.sphere(random, size, off, distance)
    }

    /// The same, of any size and anywhere before the light, from next to the receiver to next to the light.
    pub(crate) fn blocker_anywhere(&self, random: &mut Random) -> Sphere64 {
        let theta = self.cone().1;
        let size = (theta * random.log_uniform(0.05, 4.0)).min(1.1);
        let off = random.between((size - theta).abs(), size + theta).min(1.4);
        let distance = random.between(0.3, 0.98 * (FAR - self.light.radius) / (1.0 + size.sin()));
        self.sphere(random, size, off, distance)
    }

    /// Many small spheres before the light, more than a strategy may look at one by one; about half of it is seen.
    pub(crate) fn crowd(&self, random: &mut Random) -> Vec<Sphere64> {
        let theta = self.cone().1;
        let one = |_| {
            let (size, off) = (theta * random.log_uniform(0.03, 0.3), theta * random.between(0.0, 1.2).sqrt());
            let distance = random.between(0.3, 0.9 * (FAR - self.light.radius));
            self.sphere(random, size, off, distance)
        };
        (0..CROWD).map(one).collect()
    }

    pub(crate) fn turned(&self, turn: DQuat) -> Self {
        let sphere = |b: &Sphere64| Sphere64 { center: turn * b.center, ..*b };
        Self {
            position: turn * self.position,
            normal: turn * self.normal,
            light: sphere(&self.light),
            spheres: self.spheres.iter().map(sphere).collect(),
            lobe: (turn * self.lobe.0, self.lobe.1),
        }
    }

    /// Visible fraction of the light's solid angle when the first sphere is the only one: two caps overlap (closed; E. Todhunter,
    /// *Spherical Trigonometry*, 1886, gives the sides' formulas that the segments follow from).
    pub(crate) fn closed(&self) -> f64 {
        let (axis, theta) = self.cone();
        let to = self.spheres[0].center - self.position;
        let size = (self.spheres[0].radius / to.length()).asin();
        let off = axis.cross(to / to.length()).length().atan2(axis.dot(to) / to.length());
        let whole = TAU * 2.0 * (0.5 * theta).sin().powi(2);
        let hidden = if off >= theta + size {
            0.0
        } else if off + size <= theta {
            TAU * 2.0 * (0.5 * size).sin().powi(2)
        } else if off + theta <= size {
            whole
        } else {
            let acos = |x: f64| x.clamp(-1.0, 1.0).acos();
            let ((s1, c1), (s2, c2), (s, c)) = (theta.sin_cos(), size.sin_cos(), off.sin_cos());
            let corner = acos((c - c1 * c2) / (s1 * s2));
            2.0 * (PI - corner - c1 * acos((c2 - c * c1) / (s * s1)) - c2 * acos((c1 - c * c2) / (s * s2)))
        };
        1.0 - hidden / whole
    }

    fn at(&self) -> Receiver {
        let normal = self.normal.as_vec3().normalize();
        Receiver::on_surface(self.position.as_vec3(), normal, normal)
    }

    fn brdf(&self) -> Lobe {
        let (axis, exponent) = self.lobe;
        let axis = if exponent == 1.0 { self.at().normal } else { axis.as_vec3().normalize() };
        Lobe { flux: Vec3::ONE, ..Lobe::new(axis, exponent as f32, Vec3::ONE) }
    }

    /// Coverage, and the visible fraction of the reflectance lobe. None where a receiver contradicts its group.
    fn ask<V: Visibility>(
        &self,
        strategy: &V,
        entered: Option<&Shaft>,
        scratch: &mut V::Scratch,
    ) -> Option<(Coverage, f32)> {
        let (at, brdf) = (self.at(), self.brdf());
        let cone = Cone::of_sphere(at.position, self.light.rounded());
        let mut visibility = match entered {
            Some(shaft) => LightVisibility::enter(strategy, shaft, ACCURACY, scratch),
            None => LightVisibility::alone(strategy, LIGHT, ACCURACY, scratch),
        };
        let coverage = visibility.coverage(&at, &cone, None);
        if visibility.group_coverage() == Coverage::Lit && coverage.coverage() != Coverage::Lit {
            return None;
        }
        let fraction = match &coverage {
            LightCoverage::Lit => 1.0,
            LightCoverage::Dark => 0.0,
            LightCoverage::Partial(penumbra) => visibility.fraction(penumbra, brdf, cap_integral(&at, brdf, &cone)).x,
        };
        Some((coverage.coverage(), fraction))
    }

    fn with<Q: Visitor>(&self, subject: &impl Subject, visitor: Q) -> Q::Answer {
        let spheres: Vec<Sphere> = self.spheres.iter().map(|b| b.rounded()).collect();
        let (light, receiver) = (self.light.rounded(), self.position.as_vec3());
        subject.visit(&Setting { spheres: &spheres, light, receiver }, visitor)
    }

    /// Coverage and visible fraction.
    pub(crate) fn fraction(&self, subject: &impl Subject, how: Use) -> (Coverage, f32) {
        self.with(subject, Fraction { case: self, how })
    }
}

struct Fraction<'a> {
    case: &'a Case,
    how: Use,
}

impl Visitor for Fraction<'_> {
    type Answer = (Coverage, f32);

    fn visit<V>(self, strategy: &V) -> Self::Answer
    where
        V: Visibility,
        V::Scratch: 'static,
    {
        let Self { case, how } = self;
        let mut scratch = strategy.scratch();
        let answer = match how {
            Use::Fresh => case.ask(strategy, None, &mut scratch),
            Use::Used => {
                // Another receiver, another light, another lobe.
                let mut other = case.clone();
                other.light.radius *= 1.7;
                other.position += 0.3 * case.normal;
                other.lobe = (case.normal, if case.lobe.1 == 1.0 { 100.0 } else { 1.0 });
                other.ask(strategy, None, &mut scratch).and_then(|_| case.ask(strategy, None, &mut scratch))
            }
            Use::Entered => {
                let answers = GROUPS.map(|(radius, is_boxed)| {
                    // At the group's rim.
                    let position = case.position.as_vec3();
                    let center = position + 0.99 * radius * case.at().normal.any_orthonormal_vector();
                    let mut shaft = Shaft::new(Sphere { center, radius }, case.light.rounded(), LIGHT);
                    if is_boxed {
                        shaft = shaft.in_box((position - center).abs() * 1.000_01);
                    }
                    case.ask(strategy, Some(&shaft), &mut scratch)
                });
                answers.iter().all(|answer| *answer == answers[0]).then_some(answers[0]).flatten()
            }
            Use::Boxed => {
                let boxed: Box<dyn DynVisibility + '_> = Box::new(ByReference(strategy));
                case.ask(&boxed, None, &mut boxed.scratch())
            }
            Use::Threads => std::thread::scope(|scope| {
                let one = || case.ask(strategy, None, &mut strategy.scratch());
                let all: Vec<_> = (0..THREADS).map(|_| scope.spawn(one)).collect();
                let mut answers = all.into_iter().map(|t| t.join().ok().flatten());
                // Where one differs from the first there is no answer.
                let first = answers.next().flatten();
                answers.all(|other| other == first).then_some(first).flatten()
            }),
        };
        answer.unwrap_or((Coverage::Partial, f32::NAN))
    }
}

/// A borrowed strategy, to be boxed.
struct ByReference<'v, V>(&'v V);

impl<V: Visibility> Visibility for ByReference<'_, V> {
    type Scratch = V::Scratch;

    fn scratch(&self) -> Self::Scratch {
        self.0.scratch()
    }

    fn enter(&self, shaft: &Shaft, scratch: &mut Self::Scratch) -> Coverage {
        self.0.enter(shaft, scratch)
    }

    fn coverage(&self, query: &VisibilityQuery<'_>, scratch: &mut Self::Scratch) -> Coverage {
        self.0.coverage(query, scratch)
    }

    fn fraction(&self, query: &VisibilityQuery<'_>, brdf: &Lobe, unshadowed: f32, scratch: &mut Self::Scratch) -> Vec3 {
        self.0.fraction(query, brdf, unshadowed, scratch)
    }
}
