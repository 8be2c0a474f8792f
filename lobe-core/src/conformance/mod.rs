//! What every visibility strategy has to keep, as a suite that anyone can run on their own (feature `oracle`).
//!
//! [`check`] asks a [`Subject`] for strategies whose blockers are given balls and tries them:
//! - no blocker, and blockers beside the light, behind it or behind the receiver: [`Coverage::Lit`](crate::Coverage) or
//!   V = 1 exactly; a blocker that hides the light: V = 0 exactly; V in [0, 1] always;
//! - one ball before the light, from a dot to a straight edge, against the closed overlap of two caps;
//! - a further blocker never brightens; the order of blockers does not matter; nor does turning everything;
//! - nothing pops while blocker, light or receiver moves by small steps;
//! - an overflowing buffer is an error value; used scratch, `enter` and `dyn` change no bit.
//!
//! ```
//! use lobe_core::conformance::{Limits, Setting, check};
//! use lobe_core::Unshadowed;
//! // A strategy without shadows breaks the suite.
//! let broken = check(&|_: &Setting<'_>| Unshadowed, &Limits::default()).unwrap_err();
//! assert_eq!(broken.property, "full cover is dark");
//! ```

mod case;
mod properties;

pub use self::properties::check;

use crate::{Sphere, VisibilityLobes};
use glam::Vec3;

/// What a strategy is to be built for.
#[derive(Clone, Copy, Debug)]
pub struct Setting<'a> {
    /// What blocks.
    pub balls: &'a [Sphere],
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

/// What is done with a strategy under test.
pub trait Visitor {
    /// What comes of it.
    type Answer;

    /// Uses the strategy.
    fn visit<V>(self, strategy: &V) -> Self::Answer
    where
        V: VisibilityLobes,
        V::Scratch: 'static;
}

impl<F, V> Subject for F
where
    F: Fn(&Setting<'_>) -> V,
    V: VisibilityLobes,
    V::Scratch: 'static,
{
    fn visit<Q: Visitor>(&self, setting: &Setting<'_>, visitor: Q) -> Q::Answer {
        visitor.visit(&self(setting))
    }
}

/// How far a strategy may be off; all in units of V. The defaults suit exact balls in masks of depth 5.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Mean error against closed overlaps.
    pub overlap_mean: f64,
    /// Largest error against closed overlaps.
    pub overlap: f64,
    /// How much a further blocker may brighten.
    pub brighter: f64,
    /// Largest change when the order of the blockers changes.
    pub order: f64,
    /// Largest change when everything is turned.
    pub turn: f64,
    /// Largest change in a small step that the closed overlap does not make.
    pub jump: f64,
    /// Tries of each random kind.
    pub cases: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self { overlap_mean: 0.002, overlap: 0.01, brighter: 0.01, order: 0.002, turn: 0.02, jump: 0.005, cases: 60 }
    }
}

/// What [`check`] measured; the fields are those of [`Limits`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// See [`Limits::overlap_mean`].
    pub overlap_mean: f64,
    /// See [`Limits::overlap`].
    pub overlap: f64,
    /// See [`Limits::brighter`].
    pub brighter: f64,
    /// See [`Limits::order`].
    pub order: f64,
    /// See [`Limits::turn`].
    pub turn: f64,
    /// See [`Limits::jump`].
    pub jump: f64,
}

/// The first property that a strategy does not keep.
#[derive(Clone, Debug)]
pub struct Broken {
    /// Which one.
    pub property: &'static str,
    /// The case, and what came out.
    pub case: String,
}

impl core::fmt::Display for Broken {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}: {}", self.property, self.case)
    }
}

impl core::error::Error for Broken {}
