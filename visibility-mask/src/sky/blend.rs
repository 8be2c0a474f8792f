use super::{SkyHighlight, SkyResolution};
use fearless_simd::{Level, Simd, dispatch, f32x8, prelude::*};
use glam::Vec3;
use lobe_core::vec3x8::{LANES, Vec3x8};

/// A window about a lobe that samples do not resolve is so many of their steps wide, to each side.
const STEPS: f32 = 6.0;
/// The widest.
const WIDEST: f32 = 1.2;

/// The part of a lobe that one of several tables sums: finer ones what is nearer to its axis, or, with a grain, to its streak.
///
/// A table of larger steps takes what lies outside of a cone, a table of smaller ones what lies inside. Between half of the cone and all of it
/// it falls smoothly, so that both have smooth functions to sum, and all parts come to one. Cones about streaks are as long as these.
///
/// ```
/// use glam::Vec3;
/// use visibility_mask::sky::{SkyBlend, SkyHighlight, SkyResolution};
/// let axis = SkyHighlight::round(Vec3::Z);
/// let steps = [SkyResolution::new(64, 64), SkyResolution::new(256, 128)];
/// let [wide, narrow] = [SkyBlend::of_level(&steps, 0, axis), SkyBlend::of_level(&steps, 1, axis)];
/// for angle in [0.0_f32, 0.3, 0.45, 1.0] {
///     let v = Vec3::new(angle.sin(), 0.0, angle.cos());
///     assert!((wide.at(v) + narrow.at(v) - 1.0).abs() < 1e-6);
/// }
/// assert_eq!([wide.at(Vec3::Z), narrow.at(Vec3::Z)], [0.0, 1.0]);
/// // A lobe that the first table resolves is all that table's, whatever its axis.
/// assert_eq!(SkyBlend::of_level(&steps[..1], 0, axis), SkyBlend::ALL);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkyBlend {
    highlight: SkyHighlight,
    /// Half the angle of the cone outside of which it is nothing, if there is one.
    angle: Option<f32>,
    /// Squares of chords between which it rises, and between which it falls.
    rise: Option<[f32; 2]>,
    fall: Option<[f32; 2]>,
}

impl SkyBlend {
    /// All of a lobe.
    pub const ALL: Self = Self { highlight: SkyHighlight::round(Vec3::Z), angle: None, rise: None, fall: None };

    /// The part of one of some tables, of which each has smaller steps than the one before, of a lobe that only the last of them resolves.
    #[must_use]
    pub fn of_level(tables: &[SkyResolution], level: usize, highlight: SkyHighlight) -> Self {
        let angle = |table: &SkyResolution| (STEPS * table.pitch()).min(WIDEST);
        let angle_of = |level: usize| tables.get(level).map(angle);
        let outer = level.checked_sub(1).and_then(angle_of);
        let inner = if level + 1 < tables.len() { angle_of(level) } else { None };
        if outer.is_none() && inner.is_none() {
            return Self::ALL;
        }
        Self { highlight, angle: outer, rise: inner.map(chords), fall: outer.map(chords) }
    }

    /// The axis, and half the angle of the cone outside of which it is nothing; none where it is something everywhere.
    #[must_use]
    pub fn cone(&self) -> Option<(Vec3, f32)> {
        self.angle.map(|angle| (self.highlight.axis(), self.highlight.reach(angle)))
    }

    /// Whether it is nothing in all directions within chords of a length from any of eight, and surely so.
    #[inline(always)]
    pub(super) fn is_nothing<S: Simd>(&self, simd: S, v: Vec3x8<S>, chord: f32) -> bool {
        let Some([_, last]) = self.fall else { return false };
        self.highlight.are_beyond(simd, v, last.sqrt(), chord)
    }

    /// The angle to the axis from which on it is something, as a table of smaller steps sums what is nearer: 0 without one.
    pub(super) fn begin(&self) -> f32 {
        self.rise.map_or(0.0, |[first, _]| first.sqrt())
    }

    /// In a unit direction.
    #[must_use]
    pub fn at(&self, v: Vec3) -> f32 {
        let parts = dispatch!(Level::new(), simd => {
            self.of_eight(simd, Vec3x8::splat(simd, v)).map(<[f32; LANES]>::from)
        });
        parts.map_or(1.0, |parts| parts[0])
    }

    /// In eight unit directions; none for all of a lobe.
    #[inline(always)]
    pub(super) fn of_eight<S: Simd>(&self, simd: S, v: Vec3x8<S>) -> Option<f32x8<S>> {
        if self.rise.is_none() && self.fall.is_none() {
            return None;
        }
        let square = self.highlight.square(simd, v);
        let mut all = f32x8::splat(simd, 1.0);
        if let Some(range) = self.fall {
            all = inside(simd, square, range);
        }
        if let Some(range) = self.rise {
            all -= inside(simd, square, range);
        }
        Some(all)
    }
}

/// 1 below a range, 0 above it, and smooth between.
#[inline(always)]
fn inside<S: Simd>(simd: S, square: f32x8<S>, [first, last]: [f32; 2]) -> f32x8<S> {
    let [zero, one] = [0.0, 1.0].map(|x| f32x8::splat(simd, x));
    let t = ((square - first) * (1.0 / (last - first))).max(zero).min(one);
    one - t * t * (t * -2.0 + 3.0)
}

/// The squares of the chords of half an angle, and of it.
fn chords(angle: f32) -> [f32; 2] {
    [0.5 * angle, angle].map(|angle| {
        let chord = 2.0 * (0.5 * angle).sin();
        chord * chord
    })
}
