use fearless_simd::{Simd, f32x8, prelude::*};
use glam::Vec3;
use lobe_core::vec3x8::Vec3x8;
use lobe_core::{BrdfLobe, BrushedAt};

/// Where a reflectance lobe is narrow: about an axis, or, with a grain, all along a streak.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkyHighlight {
    axis: Vec3,
    streak: Option<Streak>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Streak {
    facets: BrushedAt,
    /// `2α` across: directions turn twice as far as half vectors.
    width: f32,
    /// By how much it is longer than wide.
    length: f32,
}

impl SkyHighlight {
    /// About a unit axis.
    #[must_use]
    pub const fn round(axis: Vec3) -> Self {
        Self { axis, streak: None }
    }

    /// Of a lobe at a receiver of this normal.
    #[must_use]
    pub fn new(lobe: &BrdfLobe, normal: Vec3) -> Self {
        let facets = match lobe {
            BrdfLobe::Cosine(lobe) => return Self::round(lobe.axis),
            BrdfLobe::Microfacets(facets) => facets,
        };
        let (axis, alpha) = facets.at(normal).highlight();
        let streak = facets.grain.map(|grain| Streak {
            facets: BrushedAt::new(facets, grain, normal),
            width: 2.0 * alpha,
            length: grain.alpha(alpha) / alpha,
        });
        Self { axis, streak }
    }

    /// The lobe's axis, or the mirrored view.
    #[must_use]
    pub const fn axis(&self) -> Vec3 {
        self.axis
    }

    /// Whether it is one of a grain.
    #[must_use]
    pub const fn is_streak(&self) -> bool {
        self.streak.is_some()
    }

    /// The angle of the cone about the axis that holds all directions within an angle of it; within that of a streak.
    pub(super) fn reach(&self, angle: f32) -> f32 {
        self.streak.map_or(angle, |streak| 2.0 * (0.5 * angle * streak.length).atan())
    }

    /// The square of the chord to the axis in eight unit directions; of a streak that of the distance at which a round highlight would be as wide.
    #[inline(always)]
    pub(super) fn square<S: Simd>(&self, simd: S, v: Vec3x8<S>) -> f32x8<S> {
        match &self.streak {
            None => v.minus(self.axis).length_squared(),
            Some(streak) => streak.facets.slope_square_of_eight(simd, v) * (streak.width * streak.width),
        }
    }

    /// Whether all directions within chords of a length from any of eight are farther than another chord from the axis, and surely so.
    #[inline(always)]
    pub(super) fn are_beyond<S: Simd>(&self, simd: S, v: Vec3x8<S>, far: f32, chord: f32) -> bool {
        match &self.streak {
            None => {
                let least = far + chord;
                v.minus(self.axis).length_squared().simd_gt(f32x8::splat(simd, least * least)).all_true()
            }
            Some(streak) => streak.facets.are_steeper(simd, v, far / streak.width, chord),
        }
    }
}
