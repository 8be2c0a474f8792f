use glam::{Vec2, Vec3};
use lobe_core::{Cone, Lobe, orthonormal_basis};

/// Half-angles above this (85°) are treated as if the light were seen up to it: the square faces one hemisphere.
pub(crate) const WIDEST_TAN: f32 = 11.43;

/// A window is not made smaller than for this exponent: plane coordinates in f32 resolve no more.
pub(crate) const NARROWEST: f32 = 1e8;

/// The unit square (Fig. 8): the window in the plane facing the light on which visibility is rasterised.
///
/// Coordinates are those of the plane at distance 1 along `axis`: the direction of a point `(x, y)` is
/// `(x·right + y·up + axis)/√(1+x²+y²)`. The paper scales the same square to side 1 and moves it to
/// `dist = 1/(2 tan θ)`. The light is the disc of radius `tan θ` about the origin; the window covers all of it, or, for
/// a narrow reflectance lobe, the part that the lobe sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnitSquare {
    /// World direction of +x.
    pub right: Vec3,
    /// World direction of +y.
    pub up: Vec3,
    /// World direction of the square's origin: toward the light.
    pub axis: Vec3,
    /// Centre of the window.
    pub center: Vec2,
    /// Half the side of the window.
    pub half: f32,
    /// Radius `tan θ` of the light's disc.
    pub disc: f32,
}

impl Default for UnitSquare {
    fn default() -> Self {
        Self { right: Vec3::X, up: Vec3::Y, axis: Vec3::Z, center: Vec2::ZERO, half: 1.0, disc: 1.0 }
    }
}

impl UnitSquare {
    /// The window that covers the whole light, turned so that `across` (world space, any length) lies between right and
    /// axis: edges across it are exact in a [`Mask`](crate::Mask). Without a component across the axis, any turn.
    #[must_use]
    pub fn facing(cone: &Cone, across: Vec3) -> Self {
        let aside = across - cone.axis * across.dot(cone.axis);
        let (square, all) = (aside.length_squared(), across.length_squared());
        let right = if square > 0.5 * all && (1e-30..f32::INFINITY).contains(&square) {
            aside / square.sqrt()
        } else if square > 1e-12 * all {
            // A small rest of a long vector: its rounding errors need not be at right angles to the axis.
            let r = aside.normalize_or_zero();
            (r - cone.axis * r.dot(cone.axis)).normalize_or_zero()
        } else {
            Vec3::ZERO
        };
        let right = if right == Vec3::ZERO { orthonormal_basis(cone.axis).0 } else { right };
        let disc = if cone.one_minus_cos < 1.0 { cone.tan().min(WIDEST_TAN) } else { WIDEST_TAN };
        Self { right, up: cone.axis.cross(right), axis: cone.axis, center: Vec2::ZERO, half: disc, disc }
    }

    /// The window that a reflectance lobe needs: `sigmas` standard deviations `1/√e` of the lobe about its axis, moved
    /// into the square around the light and above the horizon of `normal`. Moves and grows continuously with lobe and
    /// light and becomes the whole window for a lobe broader than the light.
    #[must_use]
    pub fn zoomed(&self, lobe: &Lobe, normal: Vec3, sigmas: f32) -> Self {
        let along = self.axis.dot(lobe.axis);
        let local = Vec2::new(self.right.dot(lobe.axis), self.up.dot(lobe.axis));
        // The lobe's axis on the plane, or the point of the emitting disc next to it.
        let mut point = if along > 1e-3 { local / along } else { local.normalize_or_zero() * 1e3 };
        let n = self.local(normal);
        for _ in 0..3 {
            let below = n.x * point.x + n.y * point.y + n.z;
            if below < 0.0 {
                point -= n.truncate() * (below / n.truncate().length_squared().max(1e-12));
            }
            point = point.clamp_length_max(self.disc);
        }
        // A cone of directions is stretched by 1/cos² across the plane. A mirror still needs a window.
        let half = (sigmas * lobe.exponent.clamp(1e-6, NARROWEST).sqrt().recip() * (1.0 + point.length_squared()))
            .min(self.disc);
        let room = Vec2::splat(self.disc - half);
        Self { center: point.clamp(-room, room), half, ..*self }
    }

    /// About the directions that the window shows, as a cone.
    pub(crate) fn cone(&self, distance: f32) -> Cone {
        let tan = self.half / (1.0 + self.center.length_squared());
        let root = (1.0 + tan * tan).sqrt();
        let axis = self.world(self.center.extend(1.0)).normalize();
        Cone { axis, one_minus_cos: tan * tan / (root * (1.0 + root)), distance }
    }

    /// A world vector in the square's frame.
    #[must_use]
    pub fn local(&self, v: Vec3) -> Vec3 {
        Vec3::new(self.right.dot(v), self.up.dot(v), self.axis.dot(v))
    }

    /// A vector of the square's frame in the world.
    #[must_use]
    pub fn world(&self, v: Vec3) -> Vec3 {
        self.right * v.x + self.up * v.y + self.axis * v.z
    }
}
