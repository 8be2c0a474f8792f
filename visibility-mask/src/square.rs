use crate::spread::Spread;
use glam::{UVec2, Vec2, Vec2Swizzles, Vec3};
use lobe_core::{Cone, Lobe, Outline, orthonormal_basis};

/// Half-angles above this (85°) count as this one: the square faces one hemisphere.
pub(crate) const WIDEST_TAN: f32 = 11.43;

/// The exponent of the smallest window: plane coordinates in f32 resolve no smaller one.
pub(crate) const NARROWEST: f32 = 1e8;

/// A lobe whose axis is beside the light by more than this many of its reaches has the window of one at that distance.
pub(crate) const FARTHEST: f32 = 8.0;

/// Half the size of the window of microfacets' highlights, in their widths `2α`, times the root of the tolerance. A fraction of
/// `1/(1 + widths²)` of a highlight is outside, and seen through the mask of the whole light.
pub(crate) const HIGHLIGHT: f32 = 0.2;

/// The smallest half side of a window, in radii of the light: smaller samples would drown in the rounding of plane coordinates.
pub(crate) const THINNEST: f32 = 1e-4;

/// The unit square (Fig. 8): the window in the plane facing the light on which visibility is rasterised.
///
/// Coordinates are those of the plane at distance 1 along `axis`: the direction of a point `(x, y)` is
/// `(x·right + y·up + axis)/√(1+x²+y²)`. The paper scales the same square to side 1 and moves it to `dist = 1/(2 tan θ)`. The light
/// is the disc of radius `tan θ` around the origin, or a polygon, in whose own plane the square then is. The window is a rectangle
/// around the whole light, around the part above the horizon, or, for a narrow reflectance lobe, around the part that the lobe
/// covers.
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
    /// Half its sides.
    pub half: Vec2,
    /// Radius `tan θ` of the light's disc; for a polygon that of a disc around the origin that contains it.
    pub disc: f32,
}

/// The largest value of a lobe over the emitting region: its position, the width `σ` of the lobe there, and `σ²g` with g the
/// gradient of the lobe's logarithm.
pub(crate) struct Peak {
    point: Vec2,
    width: f32,
    uphill: Vec2,
    /// Half the size of the emitting region.
    size: f32,
}

impl Peak {
    /// The largest fall of the lobe's logarithm over one radius of the light: `gr + r²/2σ²`.
    pub(crate) fn fall(&self) -> f32 {
        self.size * (self.uphill.length() + 0.5 * self.size) / (self.width * self.width)
    }
}

impl Default for UnitSquare {
    fn default() -> Self {
        Self { right: Vec3::X, up: Vec3::Y, axis: Vec3::Z, center: Vec2::ZERO, half: Vec2::ONE, disc: 1.0 }
    }
}

impl UnitSquare {
    /// The window of the whole light, turned so that `across` (world space, any length) lies between right and axis: edges across
    /// it are exact in a [`Mask`](crate::Mask). If `across` has no component across the axis, the rotation is arbitrary.
    #[must_use]
    pub fn facing(cone: &Cone, across: Vec3) -> Self {
        let aside = across - cone.axis * across.dot(cone.axis);
        let (square, all) = (aside.length_squared(), across.length_squared());
        let right = if square > 0.5 * all && (1e-30..f32::INFINITY).contains(&square) {
            aside / square.sqrt()
        } else if square > 1e-12 * all {
            // A small rest of a long vector: its rounding errors need not be perpendicular to the axis.
            let r = aside.normalize_or_zero();
            (r - cone.axis * r.dot(cone.axis)).normalize_or_zero()
        } else {
            Vec3::ZERO
        };
        let right = if right == Vec3::ZERO { orthonormal_basis(cone.axis).0 } else { right };
        let disc = if cone.one_minus_cos < 1.0 { cone.tan().min(WIDEST_TAN) } else { WIDEST_TAN };
        Self { right, up: cone.axis.cross(right), axis: cone.axis, center: Vec2::ZERO, half: Vec2::splat(disc), disc }
    }

    /// The window around a polygon light, in its own plane, turned so that `across` (world space, any length) lies between right
    /// and axis.
    #[must_use]
    pub fn around_outline(outline: &Outline, across: Vec3) -> Self {
        let frame = outline.frame(across);
        let corners = outline.on_plane(frame);
        let (mut low, mut high) =
            corners.clone().fold((Vec2::INFINITY, Vec2::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        if let Some((center, radius)) = outline.circle(frame) {
            (low, high) = (low.max(center - radius), high.min(center + radius));
        }
        let disc = 1.000_1 * corners.map(|p| p.length_squared()).fold(0.0, f32::max).sqrt();
        let (center, half) = (0.5 * (low + high), 0.5 * (high - low));
        let half = half.max(Vec2::splat(THINNEST * half.max_element()));
        Self { right: frame[0], up: frame[1], axis: outline.axis(), center, half, disc }
    }

    /// The window around the part of the light above the horizon of `normal`: a sliver of the light gets all samples. The whole
    /// window if the horizon leaves all or nothing.
    #[must_use]
    pub fn above(&self, normal: Vec3) -> Self {
        let n = self.local(normal);
        let aside = n.truncate().length();
        let from = -n.z / aside;
        if !(aside > 0.0 && from > -self.disc && from < self.disc) {
            return *self;
        }
        // The disc's outermost points, or the ends of the horizon's chord if those points are below.
        let m = n.truncate() / aside;
        let reach = Vec2::new(m.y, m.x).abs() * (self.disc * self.disc - from * from).max(0.0).sqrt();
        let disc = Vec2::splat(self.disc);
        let high = Vec2::select((m * self.disc).cmpge(Vec2::splat(from)), disc, from * m + reach);
        let low = Vec2::select((m * -self.disc).cmpge(Vec2::splat(from)), -disc, from * m - reach);
        self.within(low, high)
    }

    /// The point of the emitting region at which a reflectance lobe is largest, and its fall from there.
    pub(crate) fn peak(&self, lobe: &Lobe, normal: Vec3, bright: Option<&Outline>) -> Peak {
        let along = self.axis.dot(lobe.axis);
        let aside = Vec2::new(self.right.dot(lobe.axis), self.up.dot(lobe.axis));
        // The lobe's axis on the plane, or the point of the emitting disc nearest to it.
        let mut point = if along > 1e-3 { aside / along } else { aside.normalize_or_zero() * 1e3 };
        let n = self.local(normal);
        if let Some(bright) = bright {
            point = bright.nearest([self.right, self.up], point);
        } else {
            for _ in 0..3 {
                let below = n.x * point.x + n.y * point.y + n.z;
                if below < 0.0 {
                    point -= n.truncate() * (below / n.truncate().length_squared().max(1e-12));
                }
                point = point.clamp_length_max(self.disc);
            }
        }
        // A cone of directions is stretched by 1/cos² across the plane. A mirror still needs a window.
        let stretch = 1.0 + point.length_squared();
        let width = lobe.exponent.clamp(1e-6, NARROWEST).sqrt().recip() * stretch;
        let uphill = aside / (aside.dot(point) + along).max(1e-3) - point / stretch;
        let size = if bright.is_some() { self.half.max_element() } else { self.disc };
        Peak { point, width, uphill: uphill * (stretch * stretch), size }
    }

    /// The part of the window that a reflectance lobe needs: where its logarithm is within `sigmas²/2` of its largest value over
    /// the emitting region.
    ///
    /// With p the emitting point nearest to the lobe's axis, g the gradient of `ln (a·v)ᵉ` there and `σ = (1 + p²)/√e` the width of
    /// the lobe on the plane, the condition is `g·δ − δ²/2σ² ≥ −sigmas²/2`: a disc around `p + σ²g` of radius
    /// `√(σ⁴g² + sigmas²σ²)`. If the axis is on the light, g = 0. If it is beside the light, only the rim is covered, and less
    /// deeply the farther away the axis is. The window moves and grows continuously with lobe and light, and becomes the whole
    /// window for a lobe broader than the light (sigmas·σ above its radius).
    #[must_use]
    pub fn zoomed(&self, lobe: &Lobe, normal: Vec3, sigmas: f32) -> Self {
        self.around(&self.peak(lobe, normal, None), sigmas)
    }

    /// The window of a lobe with this peak.
    pub(crate) fn around(&self, peak: &Peak, sigmas: f32) -> Self {
        let reach = sigmas * peak.width;
        let uphill = peak.uphill.clamp_length_max(FARTHEST * reach);
        // A window as large as the light is not worth a mask: from four fifths on it grows to the whole window.
        let broad = (5.0 * reach / peak.size - 4.0).clamp(0.0, 1.0);
        let radius = (uphill.length_squared() + reach * reach).sqrt() + broad * (2.0 * peak.size);
        self.within(peak.point + uphill - radius, peak.point + uphill + radius)
    }

    /// The part of the window that shows the highlight of microfacets, as large as a tolerance requires, along `cells` (so many
    /// across and upward). `None` if it is most of the window.
    pub(crate) fn highlight(
        &self,
        (mirror, alpha): (Vec3, f32),
        normal: Vec3,
        cells: UVec2,
        tolerance: f32,
        bright: Option<&Outline>,
    ) -> Option<Self> {
        let peak = self.peak(&Lobe::new(mirror, 1.0, Vec3::ONE), normal, bright);
        let along = self.axis.dot(mirror);
        let aside = Vec2::new(self.right.dot(mirror), self.up.dot(mirror));
        let beside = if along > 1e-3 { (aside / along - peak.point).length() } else { f32::INFINITY };
        // Directions turn twice as far as half vectors. The highlight is broader if it is beside the light.
        let widths = (HIGHLIGHT / tolerance.max(1e-6).sqrt()).clamp(1.5, 20.0);
        let reach = widths * (2.0 * alpha * (1.0 + peak.point.length_squared())).max(0.5 * beside);
        let cell = 2.0 * self.half / cells.as_vec2();
        let origin = self.center - self.half;
        let most = cells.as_vec2();
        let low = ((peak.point - reach - origin) / cell).floor().clamp(Vec2::ZERO, most - 1.0);
        let high = ((peak.point + reach - origin) / cell).ceil().clamp(low + 1.0, most);
        let size = high - low;
        let is_small = 2.0 * size.element_product() < most.element_product();
        is_small.then(|| Self { center: origin + 0.5 * (low + high) * cell, half: 0.5 * size * cell, ..*self })
    }

    /// Where the highlight of microfacets is in the window, and how wide.
    pub(crate) fn highlight_spread(&self, (mirror, alpha): (Vec3, f32), normal: Vec3, bright: &Outline) -> Spread {
        let peak = self.peak(&Lobe::new(mirror, 1.0, Vec3::ONE), normal, Some(bright)).point;
        let stretch = 1.0 + peak.length_squared();
        Spread::about(peak, (2.0 * alpha * stretch).min(stretch.sqrt()), bright)
    }

    /// The direction of another window's right side in this one's coordinates: both are on one plane.
    pub(crate) fn turn_to(&self, other: &Self) -> Vec2 {
        if self.right == other.right {
            return Vec2::X;
        }
        Vec2::new(self.right.dot(other.right), self.up.dot(other.right)).normalize_or(Vec2::X)
    }

    /// The same window turned by a right angle: a point `(x, y)` of it is `(−y, x)` of this one.
    #[doc(hidden)]
    #[must_use]
    pub fn turned(&self) -> Self {
        let Self { right, up, center, half, .. } = *self;
        Self { right: up, up: -right, center: Vec2::new(center.y, -center.x), half: half.yx(), ..*self }
    }

    /// The part of the window between two corners; not smaller than [`THINNEST`].
    fn within(&self, low: Vec2, high: Vec2) -> Self {
        let (low, high) = (low.max(self.center - self.half), high.min(self.center + self.half));
        let half = (0.5 * (high - low)).max(Vec2::splat(THINNEST * self.disc)).min(self.half);
        let room = self.half - half;
        let center = (0.5 * (high + low)).clamp(self.center - room, self.center + room);
        Self { center, half, ..*self }
    }

    /// Half the side of the smallest window.
    pub(crate) fn smallest(&self) -> f32 {
        THINNEST * self.disc
    }

    /// Part `k` of the window, divided into `across` parts horizontally and vertically.
    pub(crate) fn part(&self, k: u32, across: UVec2) -> Self {
        if across == UVec2::ONE {
            return *self;
        }
        let half = self.half / across.as_vec2();
        let place = 2 * UVec2::new(k % across.x, k / across.x) + 1;
        Self { half, center: self.center - self.half + half * place.as_vec2(), ..*self }
    }

    /// Approximately the directions in the window, as a cone.
    pub(crate) fn cone(&self, distance: f32) -> Cone {
        let tan = self.half.max_element() / (1.0 + self.center.length_squared());
        let root = (1.0 + tan * tan).sqrt();
        let axis = self.world(self.center.extend(1.0)).normalize();
        Cone { axis, one_minus_cos: tan * tan / (root * (1.0 + root)), distance }
    }

    /// A world vector in the square's frame.
    #[must_use]
    pub fn local(&self, v: Vec3) -> Vec3 {
        Vec3::new(self.right.dot(v), self.up.dot(v), self.axis.dot(v))
    }

    /// Converts a vector of the square's frame to the world.
    #[must_use]
    pub fn world(&self, v: Vec3) -> Vec3 {
        self.right * v.x + self.up * v.y + self.axis * v.z
    }
}
