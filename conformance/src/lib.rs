//! Properties that every visibility strategy has to keep, as a suite that anyone can run on their own; beside it, the same for lights
//! ([`check_light`]) and for reflectance models ([`check_brdf`]).
//!
//! [`check`] asks a [`Subject`] for strategies whose blockers are given spheres and tries them:
//! - no blocker: [`Coverage::Lit`](shading::Coverage), without a lobe; blockers behind the receiver or the light: V = 1
//!   exactly; beside the light: V = 1; a blocker that hides the light: V = 0; V in [0, 1] always;
//! - one sphere before the light, from a dot to a half-plane, against the closed overlap of two caps; several spheres anywhere
//!   between receiver and light, crowds of them, lights that fill nearly half of the sky or cross the horizon, and glossy lobes
//!   against quadrature;
//! - a further blocker never brightens; the order of blockers does not matter; nor does turning everything;
//! - nothing pops while blocker, light or receiver moves by small steps, with one sphere and with several;
//! - used scratch, `enter`, `dyn` and threads change no bit.
//!
//! Blockers are spheres, since a sphere's shadow is known. A strategy of other shapes is tested with the nearest that it has: boxes or
//! meshes around the spheres, with limits as wide as these differ.
//!
//! A strategy without shadows breaks it:
//!
//! ```
//! use conformance::{Limits, Setting, check};
//! use shading::Unshadowed;
//! let report = check(&|_: &Setting<'_>| Unshadowed, &Limits::default()).unwrap_err();
//! let broken = &report.broken[0];
//! assert_eq!(broken.property, "full cover is dark");
//! assert_eq!(broken.exceeded.map(|e| (e.field, e.value, e.limit)), Some(("cover", 1.0, 0.0)));
//! ```
//!
//! A strategy of one's own passes it, within limits that its kind allows:
//!
//! ```
//! use glam::Vec3;
//! use conformance::{Limits, Setting, check};
//! use lobe_core::*;
//! use shading::*;
//!
//! /// 1024 shadow rays a light, the same pattern always.
//! struct Rays(Vec<Sphere>);
//!
//! impl Rays {
//!     fn hides(&self, x: Vec3, v: Vec3, far: f32) -> bool {
//!         self.0.iter().any(|sphere| {
//!             let to = sphere.center - x;
//!             let along = to.dot(v);
//!             along > 0.0 && along < far && (to - v * along).length() < sphere.radius
//!         })
//!     }
//! }
//!
//! impl Visibility for Rays {
//!     /// Directions, and whether they are open.
//!     type Scratch = Vec<(Vec3, bool)>;
//!     fn scratch(&self) -> Self::Scratch {
//!         Vec::new()
//!     }
//!     fn coverage(&self, query: &VisibilityQuery<'_>, scratch: &mut Self::Scratch) -> Coverage {
//!         let (right, up) = orthonormal_basis(query.cone.axis);
//!         scratch.clear();
//!         scratch.extend((0..1024).map(|k| {
//!             // Equal solid angles along a spiral.
//!             let defect = query.cone.one_minus_cos * (k as f32 + 0.5) / 1024.0;
//!             let (sin, cos) = (2.399_963 * k as f32).sin_cos();
//!             let v = (right * cos + up * sin) * (defect * (2.0 - defect)).sqrt() + query.cone.axis * (1.0 - defect);
//!             let below = query.at.normal.dot(v) <= 0.0;
//!             (v, !below && !self.hides(query.at.position, v, query.cone.distance))
//!         }));
//!         scratch.retain(|(v, _)| query.at.normal.dot(*v) > 0.0);
//!         match scratch.iter().filter(|(_, open)| *open).count() {
//!             0 => Coverage::Dark,
//!             open if open == scratch.len() => Coverage::Lit,
//!             _ => Coverage::Partial,
//!         }
//!     }
//!     fn fraction(&self, _: &VisibilityQuery<'_>, brdf: &Lobe, _: f32, scratch: &mut Self::Scratch) -> Vec3 {
//!         let total = |rays: &mut dyn Iterator<Item = &(Vec3, bool)>| rays.map(|(v, _)| brdf.eval(*v)).sum::<Vec3>();
//!         total(&mut scratch.iter().filter(|(_, is_open)| *is_open)) / total(&mut scratch.iter())
//!     }
//! }
//!
//! // 32 rays lie across a light: edges are off by a part of the space between two.
//! let limits = Limits {
//!     overlap_mean: 0.005,
//!     overlap: 0.03,
//!     several_mean: 0.02,
//!     several: 0.2,
//!     jump: 0.03,
//!     turn: 0.15,
//!     cases: 6,
//!     ..Limits::default()
//! };
//! let measured = check(&|s: &Setting<'_>| Rays(s.spheres.to_vec()), &limits)?;
//! assert_eq!((measured.cover, measured.order), (0.0, 0.0));
//! # Ok::<(), conformance::Report>(())
//! ```

mod case;
mod exact;
mod lights;
mod materials;
mod properties;
mod run;

pub use crate::lights::{LightLimits, check_light};
pub use crate::materials::{BrdfLimits, MeasuredBrdf, check_brdf};
pub use crate::properties::check;
pub use crate::run::Run;
pub use lobe_core::oracle;

use glam::Vec3;
use lobe_core::Sphere;
use shading::Visibility;

/// The setting that a strategy is built for.
#[derive(Clone, Copy, Debug)]
pub struct Setting<'a> {
    /// The blockers.
    pub spheres: &'a [Sphere],
    /// The only light.
    pub light: Sphere,
    /// The only receiver.
    pub receiver: Vec3,
}

/// A kind of strategy under test. Every `Fn(&Setting) -> V` is one; implement it for strategies that borrow what they are
/// built from.
pub trait Subject {
    /// Builds the strategy for a setting and shows it to the visitor.
    fn visit<Q: Visitor>(&self, setting: &Setting<'_>, visitor: Q) -> Q::Answer;
}

/// A task for a strategy under test.
pub trait Visitor {
    /// Its result.
    type Answer;

    /// Uses the strategy.
    fn visit<V>(self, strategy: &V) -> Self::Answer
    where
        V: Visibility,
        V::Scratch: 'static;
}

impl<F, V> Subject for F
where
    F: Fn(&Setting<'_>) -> V,
    V: Visibility,
    V::Scratch: 'static,
{
    fn visit<Q: Visitor>(&self, setting: &Setting<'_>, visitor: Q) -> Q::Answer {
        visitor.visit(&self(setting))
    }
}

/// How far a strategy may be off; all in units of V. The defaults suit exact spheres in masks of depth 5.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// How much a blocker beside the cone of light may darken: 0 for exact shapes.
    pub beside: f64,
    /// How much light a blocker that hides all of it may let through: 0 unless blockers are discrete.
    pub cover: f64,
    /// Mean error against closed overlaps.
    pub overlap_mean: f64,
    /// Largest error against closed overlaps.
    pub overlap: f64,
    /// Mean error with several spheres, any light and lobe, against quadrature.
    pub several_mean: f64,
    /// Largest error of those.
    pub several: f64,
    /// How much a further blocker may brighten.
    pub brighter: f64,
    /// Largest change when the order of the blockers changes.
    pub order: f64,
    /// Largest change when everything is turned.
    pub turn: f64,
    /// Largest change in a small step, a hundredth of the light's half-angle or so, that the exact fraction does not make. The
    /// suite asks with a tolerance of 0.003.
    pub jump: f64,
    /// The same with several spheres, any light and lobe.
    pub jump_several: f64,
    /// Tries of each random kind; a third as many sweeps.
    pub cases: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            beside: 0.0,
            cover: 0.0,
            overlap_mean: 0.0008,
            overlap: 0.003,
            several_mean: 0.0008,
            several: 0.008,
            brighter: 0.002,
            order: 1e-6,
            turn: 0.004,
            jump: 0.003,
            jump_several: 0.004,
            cases: 60,
        }
    }
}

/// The measurements of [`check`]; the fields are those of [`Limits`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// See [`Limits::beside`].
    pub beside: f64,
    /// See [`Limits::cover`].
    pub cover: f64,
    /// See [`Limits::overlap_mean`].
    pub overlap_mean: f64,
    /// See [`Limits::overlap`].
    pub overlap: f64,
    /// See [`Limits::several_mean`].
    pub several_mean: f64,
    /// See [`Limits::several`].
    pub several: f64,
    /// See [`Limits::brighter`].
    pub brighter: f64,
    /// See [`Limits::order`].
    pub order: f64,
    /// See [`Limits::turn`].
    pub turn: f64,
    /// See [`Limits::jump`].
    pub jump: f64,
    /// See [`Limits::jump_several`].
    pub jump_several: f64,
}

/// Every property that a strategy does not keep.
#[derive(Clone, Debug)]
pub struct Report {
    /// One entry a property, in the order in which they were tried.
    pub broken: Vec<Broken>,
}

impl core::fmt::Display for Report {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        for (i, broken) in self.broken.iter().enumerate() {
            write!(f, "{}{broken}", if i == 0 { "" } else { "\n" })?;
        }
        Ok(())
    }
}

impl core::error::Error for Report {}

/// A property that a strategy does not keep.
#[derive(Clone, Debug)]
pub struct Broken {
    /// Which one.
    pub property: &'static str,
    /// The limit that was exceeded, where the property has one.
    pub exceeded: Option<Exceeded>,
    /// In how many cases.
    pub times: u32,
    /// The worst case, and what came out: all of it, of which `Display` shows the beginning.
    pub case: String,
}

/// A value above its limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exceeded {
    /// The field of [`Limits`].
    pub field: &'static str,
    /// The value.
    pub value: f64,
    /// The limit.
    pub limit: f64,
}

impl core::fmt::Display for Broken {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{} ({} times): ", self.property, self.times)?;
        if let Some(Exceeded { field, value, limit }) = self.exceeded {
            let place = if field.is_empty() { "the limit".to_owned() } else { format!("Limits::{field}") };
            write!(f, "{value:.3e} is above {place}, {limit:.3e}: ")?;
        }
        // A crowd has 64 spheres.
        match self.case.char_indices().nth(800) {
            Some((end, _)) => write!(f, "{} …", &self.case[..end]),
            None => f.write_str(&self.case),
        }
    }
}

impl core::error::Error for Broken {}
