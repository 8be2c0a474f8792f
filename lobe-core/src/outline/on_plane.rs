//! An outline on the plane at distance 1.

use super::{Outline, sides};
use crate::lanes::Lane;
use glam::{Vec2, Vec3};

/// The corners of an outline on the plane at distance 1 along its axis.
pub(super) struct OnPlane<'a> {
    pub(super) outline: &'a Outline,
    /// The plane's two directions.
    pub(super) frame: [Vec3; 2],
    corners: [Vec2; Outline::ROOM],
}

impl<'a> OnPlane<'a> {
    pub(super) fn new(outline: &'a Outline, frame: [Vec3; 2]) -> Self {
        let mut corners = [Vec2::ZERO; Outline::ROOM];
        corners.iter_mut().zip(outline.on_plane(frame)).for_each(|(corner, p)| *corner = p);
        Self { outline, frame, corners }
    }

    pub(super) fn corners(&self) -> &[Vec2] {
        &self.corners[..self.outline.count]
    }

    /// A vector in the plane's directions and along the axis.
    pub(super) fn local(&self, v: Vec3) -> Vec3 {
        let [right, up] = self.frame;
        Vec3::new(right.dot(v), up.dot(v), self.outline.axis.dot(v))
    }

    /// The point next to a place.
    pub(super) fn nearest(&self, place: Vec2) -> Vec2 {
        let (mut nearest, mut least, mut is_inside) = (place, f32::INFINITY, true);
        sides::each(&Nearest { place }, self.corners(), |[x, y, square, is_before]| {
            is_inside &= is_before > 0.0;
            if square < least {
                (nearest, least) = (Vec2::new(x, y), square);
            }
        });
        if is_inside { place } else { nearest }
    }
}

/// The point of a side next to a place, its squared distance, and 1 where the place is not outside of the side's line.
struct Nearest {
    place: Vec2,
}

impl Lane<2, 2, 4> for Nearest {
    #[inline(always)]
    fn value(&self, from: [f32; 2], to: [f32; 2]) -> [f32; 4] {
        let from = Vec2::from_array(from);
        let (side, here) = (Vec2::from_array(to) - from, self.place - from);
        let square = side.length_squared();
        let along = side.dot(here) / if square > 0.0 { square } else { 1.0 };
        let along = if along > 0.0 { along } else { 0.0 };
        let nearest = from + side * if along < 1.0 { along } else { 1.0 };
        let is_before = if side.perp_dot(here) < 0.0 { 0.0 } else { 1.0 };
        [nearest.x, nearest.y, nearest.distance_squared(self.place), is_before]
    }
}
