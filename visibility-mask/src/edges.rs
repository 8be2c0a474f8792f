use crate::lanes::sum;
use core::f32::consts::FRAC_1_SQRT_2;
use fearless_simd::{Level, Simd, dispatch, f32x8, i32x8, prelude::*};
use glam::{Vec2, Vec3};
use lobe_core::Cone;
use shading::VisibilityQuery;

/// The weight of an edge without direction, as a fraction of the light's radius: it turns a mask if no edge does.
pub(crate) const NOTHING: f32 = 1e-3;

/// The weight of the edge of a plane (the horizon's or a facet's) relative to a blocker's edge, since masks cut by it on rows only.
pub(crate) const PLANE: f32 = 4.0;

/// The directions of all edges across a light. A [`Mask`](crate::Mask) is turned by their sum, so that its rows run across most of
/// them.
///
/// The sum of `length·(cos 2φ, sin 2φ)` over the edges, where φ is the direction across an edge in the mask's plane:
/// an edge and its opposite are the same, and two edges at right angles cancel. Lengths are in radii of the light's disc, and
/// become zero as an edge leaves the light: the rotation therefore follows any motion without a step, except if the sum vanishes.
///
/// An edge along the rows changes a whole row at once. Straight edges at right angles, the horizon's among them, therefore make the mask
/// lean, so that none of them runs along the rows. With s the length of the first sum, 2α its angle, and c the component of the sum of
/// `length·(cos 4φ, sin 4φ)` along 4α, the mask leans by δ with `tan 2δ = (c − s)/s`: not at all for edges of one direction, by 45° for a
/// right angle between equal lengths.
///
/// ```
/// use glam::Vec3;
/// use visibility_mask::Edges;
/// let cone = lobe_core::Cone { axis: Vec3::Y, one_minus_cos: 0.01, distance: 5.0 };
/// let mut edges = Edges::new(&cone);
/// edges.add(Vec3::new(1.0, 0.3, 1.0), 2.0); // of any length; what is along the axis does not matter
/// edges.add(Vec3::new(-1.0, 0.0, -1.0), 0.5);
/// let diagonal = Vec3::new(1.0, 0.0, 1.0).normalize();
/// assert!(edges.across().dot(diagonal).abs() > 0.999);
/// edges.add(Vec3::new(-1.0, 0.0, 1.0), 0.5); // at right angles to both: the mask leans a little
/// assert!((0.9..0.999).contains(&edges.across().dot(diagonal).abs()));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Edges {
    right: Vec3,
    up: Vec3,
    sum: Vec2,
    /// That of the straight edges in it with four times their angles.
    four: Vec2,
    /// The sum of the edges that may be added in any order, in [`STEP`]s, and the sum with four times their angles.
    whole: [i64; 2],
    fourfold: [i64; 2],
}

/// Lengths that may be added in any order are rounded to this fraction of the disc's radius.
pub(crate) const STEP: f32 = 1.0 / 65_536.0;

impl Edges {
    /// No edges across this light.
    #[must_use]
    pub fn new(cone: &Cone) -> Self {
        let (right, up) = frame(cone.axis);
        Self { right, up, sum: Vec2::new(NOTHING, 0.0), four: Vec2::ZERO, whole: [0; 2], fourfold: [0; 2] }
    }

    /// No edges across the light of a query. Masks of a flat light are in its plane, and directions then are those on that plane: lines that are parallel
    /// on the light are so there, and not in the plane that faces the light's middle. Without edges such a mask is along the light's first side.
    #[must_use]
    pub fn before(query: &VisibilityQuery<'_>) -> Self {
        let edges = Self::new(query.cone);
        let Some(outline) = query.outline else { return edges };
        let [right, up] = outline.frame(outline.corners()[1] - outline.corners()[0]);
        Self { right, up, ..edges }
    }

    /// Adds an edge perpendicular to `across` (world space, any length), `length` radii of the light's disc long.
    #[inline]
    pub fn add(&mut self, across: Vec3, length: f32) {
        let d = Vec2::new(self.right.dot(across), self.up.dot(across));
        let square = d.length_squared();
        if square > 0.0 && length.is_finite() {
            let two = Vec2::new(d.x * d.x - d.y * d.y, 2.0 * d.x * d.y) / square;
            self.sum += two * length;
            self.four += two.rotate(two) * length;
        }
    }

    /// Adds eight edges as [`add`](Self::add) does; a length of zero or less adds nothing. The sum is the same to the bit for any
    /// order of the edges.
    #[doc(hidden)]
    #[inline(always)]
    pub fn add_lines<S: Simd>(&mut self, simd: S, across: [f32x8<S>; 3], length: f32x8<S>) {
        let (zero, u, v) = (f32x8::splat(simd, 0.0), self.right, self.up);
        let x = across[0] * u.x + across[1] * u.y + across[2] * u.z;
        let y = across[0] * v.x + across[1] * v.y + across[2] * v.z;
        let square = x * x + y * y;
        let scale = length / square * STEP.recip();
        let adds = square.simd_gt(zero) & length.simd_gt(zero) & (square * scale).simd_le(f32x8::splat(simd, 1e9));
        // cos 2φ and sin 2φ times the length, then those of 4φ.
        let (cos, sin) = ((x * x - y * y) * scale, (x + x) * y * scale);
        let four = [(x * x - y * y) / square, (x + x) * y / square];
        let parts = [cos, sin, cos * four[0] - sin * four[1], (cos + cos) * four[1]];
        for (whole, part) in self.whole.iter_mut().chain(&mut self.fourfold).zip(parts) {
            let steps: [i32; 8] = adds.select(part, zero).to_int::<i32x8<S>>().into();
            *whole += steps.iter().map(|s| i64::from(*s)).sum::<i64>();
        }
    }

    /// Adds the edge of a plane through the receiver with this normal, as far as it crosses the disc of the cone.
    ///
    /// It counts more than a blocker's edge, since [`Mask`](crate::Mask) cuts by a plane on the rows' lines only.
    pub fn add_plane(&mut self, normal: Vec3, cone: &Cone) {
        let cos = normal.dot(cone.axis);
        // Distance of its chord from the centre: cos β/(sin β tan θ).
        let off_sq = cos * cos / ((1.0 - cos * cos).max(0.0) * cone.tan().powi(2));
        if off_sq < 1.0 {
            self.add(normal, PLANE * 2.0 * (1.0 - off_sq).sqrt());
        }
    }

    /// Adds the arc of a circle that lies inside the disc of a light that is not flat. `to` is its centre (world space, relative to the disc's; the
    /// part along the axis does not matter), and its radius is in radii of the disc. With α half the arc and φ the direction of the
    /// centre: `∫ ρ (cos 2t, sin 2t) dt = ρ sin 2α (cos 2φ, sin 2φ)` over φ ± α.
    pub fn add_circle(&mut self, to: Vec3, radius: f32) {
        dispatch!(Level::new(), simd => {
            let one = |x: f32| f32x8::simd_from(simd, [x, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
            self.add_circles(simd, [one(to.x), one(to.y), one(to.z)], one(radius));
        });
    }

    /// Adds eight circles as [`add_circle`](Self::add_circle) does; a radius of zero adds nothing.
    #[doc(hidden)]
    #[inline(always)]
    pub fn add_circles<S: Simd>(&mut self, simd: S, to: [f32x8<S>; 3], radius: f32x8<S>) {
        let (zero, one) = (f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0));
        let (u, v) = (self.right, self.up);
        let x = to[0] * u.x + to[1] * u.y + to[2] * u.z;
        let y = to[0] * v.x + to[1] * v.y + to[2] * v.z;
        let square = x * x + y * y;
        let distance = square.sqrt();
        // cos α = n/(2ρd), sin α = √((1 − (d − ρ)²)((d + ρ)² − 1))/(2ρd), negative if the rims do not cross.
        let (apart, both) = (distance - radius, distance + radius);
        let root = ((one - apart * apart) * (both * both - one)).max(zero).sqrt();
        let scale = (square + radius * radius - one) * root / (square * square * (radius + radius));
        let adds = root.simd_gt(zero) & scale.abs().simd_le(f32x8::splat(simd, f32::MAX));
        let scale = adds.select(scale, zero);
        self.sum += Vec2::new(sum((x * x - y * y) * scale), sum((x + x) * y * scale));
    }

    /// The unit direction in that plane across which most edges run.
    #[must_use]
    pub fn across(&self) -> Vec3 {
        let [x, y] = self.whole.map(|whole| whole as f32 * STEP);
        let sum = self.sum + Vec2::new(x, y);
        let d = sum.normalize_or(Vec2::X);
        let [x, y] = self.fourfold.map(|whole| whole as f32 * STEP);
        let Vec2 { x, y } = self.four + Vec2::new(x, y);
        let c = x * (d.x * d.x - d.y * d.y) + y * (2.0 * d.x * d.y);
        let s = sum.length();
        let d = if s < c { d.rotate(Vec2::new(s, c - s)).normalize() } else { d };
        // Half the angle of the sum.
        let half = if d.x >= 0.0 {
            let cos = ((1.0 + d.x) * 0.5).sqrt();
            Vec2::new(cos, 0.5 * d.y / cos)
        } else {
            let sin = ((1.0 - d.x) * 0.5).sqrt();
            Vec2::new(0.5 * d.y / sin, sin)
        };
        debug_assert!(half.max_element() >= 0.99 * FRAC_1_SQRT_2 || half.min_element() <= -0.5);
        self.right * half.x + self.up * half.y
    }
}

/// Two unit vectors that complete an axis to a basis; continuous, except if the axis points straight down.
fn frame(axis: Vec3) -> (Vec3, Vec3) {
    let Vec3 { x, y, z } = axis;
    let a = 1.0 / (1.0 + y).max(1e-6);
    (Vec3::new(1.0 - x * x * a, -x, -x * z * a), Vec3::new(-x * z * a, -z, 1.0 - z * z * a))
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;
    use lobe_core::oracle::Random;
    use lobe_core::{Outline, Receiver};
    use shading::{Accuracy, LightId};

    /// Eight edges at once give the same sum as one by one, in any order.
    #[test]
    fn lines_add_as_single_edges_do() {
        let mut random = Random::new(8);
        let cone = Cone { axis: Vec3::new(0.6, 0.0, 0.8), one_minus_cos: 0.01, distance: 5.0 };
        for _ in 0..100 {
            let across: [Vec3; 8] = core::array::from_fn(|_| random.axis().as_vec3() * 3.0);
            let length: [f32; 8] = core::array::from_fn(|_| random.between(-0.3, 1.9) as f32);
            let [mut one, mut eight, mut turned] = [Edges::new(&cone); 3];
            for (across, length) in across.iter().zip(&length).filter(|(_, length)| **length > 0.0) {
                one.add(*across, *length);
            }
            let lanes = |k: usize, turn: usize| core::array::from_fn(|l| across[(l + turn) % 8][k]);
            for (edges, turn) in [(&mut eight, 0), (&mut turned, 3)] {
                dispatch!(Level::new(), simd => {
                    let across = [0, 1, 2].map(|k| f32x8::simd_from(simd, lanes(k, turn)));
                    let length = f32x8::simd_from(simd, core::array::from_fn(|l| length[(l + turn) % 8]));
                    edges.add_lines(simd, across, length);
                });
            }
            let sum = eight.sum + Vec2::from_array(eight.whole.map(|whole| whole as f32 * STEP));
            assert!(one.sum.distance(sum) < 1e-3, "{one:?} {eight:?}");
            let four = Vec2::from_array(eight.fourfold.map(|whole| whole as f32 * STEP));
            assert!(one.four.distance(four) < 1e-3, "{one:?} {eight:?}");
            assert_eq!((eight.whole, eight.fourfold), (turned.whole, turned.fourfold));
        }
    }

    /// Lines along a long light are so in its mask from any receiver: rows cross them at right angles from beside its end, too.
    #[test]
    fn lines_along_a_flat_light_are_so_in_its_mask() {
        for behind in [-3.0, 0.0, 0.5, 2.0] {
            let corners =
                [[0.02, -behind], [0.02, 4.0], [-0.02, 4.0], [-0.02, -behind]].map(|[x, y]| Vec3::new(x, y, 1.0));
            let light = Outline::new(&corners, Vec3::Z).expect("before the receiver");
            let (at, cone) = (Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::Z), light.cone());
            let whole = VisibilityQuery::new(&at, LightId::default(), &cone, Accuracy::default());
            let mut edges = Edges::before(&VisibilityQuery { outline: Some(&light), ..whole });
            for aside in [-0.3, 0.01, 0.8] {
                edges.add(Vec3::new(0.0, 1.0, 0.0).cross(Vec3::new(aside, 0.0, 1.0)), 1.0);
            }
            // Half the weight of what has no direction.
            assert!(edges.across().y.abs() < NOTHING, "{:?}", edges.across());
        }
    }

    /// Rows cross edges of one direction at right angles; the shorter of two perpendicular edges makes the mask lean.
    #[test]
    fn no_edge_runs_along_the_rows() {
        let cone = Cone { axis: Vec3::Y, one_minus_cos: 0.01, distance: 5.0 };
        for (part, least, most) in [(0.0, 0.0, 0.1), (0.1, 2.0, 15.0), (0.5, 20.0, 40.0), (1.0, 44.0, 46.0)] {
            let mut edges = Edges::new(&cone);
            dispatch!(Level::new(), simd => {
                let lanes = |a: f32, b: f32| f32x8::simd_from(simd, [a, b, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
                let [x, z] = [edges.right, Vec3::Y.cross(edges.right)];
                let across = [lanes(x.x, z.x), lanes(x.y, z.y), lanes(x.z, z.z)];
                edges.add_lines(simd, across, lanes(1.5, 1.5 * part));
            });
            let lean = edges.across().dot(edges.right).abs().min(1.0).acos().to_degrees();
            assert!((least..=most).contains(&lean), "a part of {part} leans by {lean}°");
        }
    }

    /// The arc's integral over the directions in which it lies on the disc, by quadrature in f64.
    #[test]
    fn circles_add_what_of_their_rims_is_on_the_disc() {
        let mut random = Random::new(5);
        let cone = Cone { axis: Vec3::Y, one_minus_cos: 0.01, distance: 5.0 };
        for case in 0..300 {
            let radius = random.log_uniform(0.02, 500.0);
            // Rims that cross the disc's, and some that do not.
            let apart = radius + random.between(-1.3, 1.3);
            let (s, c) = random.between(0.0, TAU).sin_cos();
            let mut edges = Edges::new(&cone);
            let to = edges.right * (apart * c) as f32 + edges.up * (apart * s) as f32;
            edges.add_circle(to + 3.0 * Vec3::Y, radius as f32);
            let got = edges.sum - Vec2::new(NOTHING, 0.0);
            // Fine steps around the point nearest to the disc's centre.
            const STEPS: i32 = 200_000;
            let middle = (-apart * s).atan2(-apart * c);
            let reach = (3.0 / radius).min(0.5 * TAU);
            let mut want = [0.0; 2];
            for k in 0..STEPS {
                let t = middle + reach * (2.0 * (f64::from(k) + 0.5) / f64::from(STEPS) - 1.0);
                let at = [apart * c + radius * t.cos(), apart * s + radius * t.sin()];
                if at[0] * at[0] + at[1] * at[1] < 1.0 {
                    let step = radius * 2.0 * reach / f64::from(STEPS);
                    want = [want[0] + (2.0 * t).cos() * step, want[1] + (2.0 * t).sin() * step];
                }
            }
            let error = (f64::from(got.x) - want[0]).hypot(f64::from(got.y) - want[1]);
            assert!(error < 2e-3, "case {case}: radius {radius}, {apart} away: {got}, not {want:?}");
        }
    }
}
