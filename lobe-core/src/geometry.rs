use glam::{Mat3, Mat4, Vec3};

/// The object number of a receiver that belongs to no object with blockers of its own.
pub const NO_OBJECT: u32 = u32::MAX;

/// The shaded point: where it is, how it faces, from where it is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// World position.
    pub position: Vec3,
    /// Shading normal, unit, on the viewer's side of the surface.
    pub normal: Vec3,
    /// Geometric normal of the surface, unit, on the viewer's side: where light can come from at all. The shading normal
    /// of a curved surface, else of a smoothed mesh its face's.
    pub face: Vec3,
    /// Unit direction toward the eye (ω_o of the paper).
    pub view: Vec3,
    /// Number of the object that the point lies on, or [`NO_OBJECT`]: a visibility strategy must not let an object's
    /// own proxy blacken its surface.
    pub object: u32,
}

impl Receiver {
    /// A point of a surface whose shading normal is that of its face, on no object with blockers of its own.
    #[must_use]
    #[inline]
    pub const fn on_surface(position: Vec3, normal: Vec3, view: Vec3) -> Self {
        Self { position, normal, face: normal, view, object: NO_OBJECT }
    }

    /// The same point on an object.
    #[must_use]
    pub const fn on_object(self, object: u32) -> Self {
        Self { object, ..self }
    }
}

/// A sphere.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sphere {
    /// Centre.
    pub center: Vec3,
    /// Radius, ≥ 0.
    pub radius: f32,
}

impl Sphere {
    /// The largest coordinate and radius of a sphere in a scene.
    pub const LARGEST: f32 = 1e9;

    /// Checks that it is finite, not beyond [`LARGEST`](Self::LARGEST), and has a radius above 0.
    ///
    /// # Errors
    /// The fault, in a sentence.
    pub fn validate(&self) -> Result<(), String> {
        let Self { center, radius } = self;
        if center.is_nan() || center.abs().max_element() > Self::LARGEST {
            return Err(format!("sphere has centre {center}: coordinates must lie within ±1e9"));
        }
        if !(*radius > 0.0 && *radius <= Self::LARGEST) {
            return Err(format!("sphere has radius {radius}: expected a positive number up to 1e9"));
        }
        Ok(())
    }
}

/// Whether a matrix scales all directions by `scale` and keeps right angles, so that spheres stay spheres: it turns, mirrors and moves.
///
/// For its columns `a` within the relative tolerance t: `||aᵢ| − s| ≤ t·s` and `|aᵢ·aₖ| ≤ t·s²`, in f64. False where a number is missing.
///
/// ```
/// use glam::{Mat4, Quat, Vec3};
/// use lobe_core::scales_evenly;
/// let turned = Mat4::from_scale_rotation_translation(Vec3::splat(2.0), Quat::from_rotation_x(1.0), Vec3::ONE);
/// assert!(scales_evenly(&turned, 2.0, 1e-4));
/// assert!(!scales_evenly(&Mat4::from_scale(Vec3::new(2.0, 2.0, 2.1)), 2.0, 1e-4));
/// ```
#[must_use]
pub fn scales_evenly(matrix: &Mat4, scale: f64, tolerance: f64) -> bool {
    let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.truncate().as_dvec3());
    axes.iter().all(|axis| (axis.length() - scale).abs() <= tolerance * scale)
        && [(0, 1), (1, 2), (2, 0)].iter().all(|&(i, k)| axes[i].dot(axes[k]).abs() <= tolerance * scale * scale)
}

/// How a blocker sphere is seen by receivers of its own object that are near it, in units of its radius R, so that it follows
/// a sphere that moves and grows: as a smaller sphere inside it, which blocks a direction only if the ray leaves it farther than
/// `distance` from the receiver.
///
/// A set of spheres bulges out of the mesh that it stands for; what bulges must not blacken the skin around it. From afar
/// it is the silhouette that counts, which the whole sphere has: [`seen`](Self::seen).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelfShadow {
    /// From the sphere's centre to that of the near sphere, no longer than `1 − radius`: the sphere is inside the sphere. It
    /// turns with the object.
    pub offset: Vec3,
    /// Radius of the near sphere, in `[0, 1]`.
    pub radius: f32,
    /// τ: how far from the receiver a ray must leave the sphere to be blocked, ≥ 0.
    pub distance: f32,
}

impl SelfShadow {
    /// The sphere itself, with a distance of its own.
    #[must_use]
    pub const fn whole(distance: f32) -> Self {
        Self { offset: Vec3::ZERO, radius: 1.0, distance }
    }

    /// The nearest that fulfils what its fields promise; the whole sphere where numbers are missing.
    #[must_use]
    pub fn sound(self) -> Self {
        let radius = if self.radius >= 0.0 { self.radius.min(1.0) } else { 1.0 };
        let offset = if self.offset.is_finite() { self.offset.clamp_length_max(1.0 - radius) } else { Vec3::ZERO };
        Self { offset, radius, distance: self.distance.max(0.0) }
    }

    /// The same of an object that is moved by a matrix, as far as it keeps angles: what is stretched is cut off.
    #[must_use]
    pub fn turned(self, matrix: Mat3) -> Self {
        let offset = (matrix * self.offset).normalize_or_zero() * self.offset.length();
        Self { offset, ..self }
    }

    /// The near sphere of a sphere of a radius, its centre as seen from the sphere's.
    #[inline(always)]
    #[must_use]
    pub fn near(&self, radius: f32) -> Sphere {
        Sphere { center: self.offset * radius, radius: self.radius * radius }
    }

    /// How much a receiver of the own object at a distance d from the centre sees of the near sphere instead of the whole
    /// sphere: `w(d) = R / max(d, R)`.
    ///
    /// Lengths ≥ 0. In `[0, 1]`, continuous in d, and never NaN.
    #[inline(always)]
    #[must_use]
    pub fn nearness(radius: f32, distance: f32) -> f32 {
        radius / distance.max(radius).max(f32::MIN_POSITIVE)
    }

    /// The sphere that a receiver of the own object sees of a sphere and its [near](Self::near) sphere: centre and radius go from
    /// the near sphere's, seen from inside the sphere, to the sphere's, seen from afar, by [`nearness`](Self::nearness).
    ///
    /// Contains the near sphere, and is inside the whole one as long as the near sphere is. Continuous in `x`.
    #[must_use]
    pub fn seen(whole: Sphere, near: Sphere, x: Vec3) -> Sphere {
        let w = Self::nearness(whole.radius, whole.center.distance(x));
        Sphere { center: whole.center + near.center * w, radius: whole.radius - (whole.radius - near.radius) * w }
    }
}

/// The directions in which a light is seen from a receiver: all `v` with `axis·v ≥ cos θ`.
///
/// Carries `1 − cos θ` and never `cos θ`, which for a small light has lost all its digits.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Cone {
    /// Unit direction toward the light's centre.
    pub axis: Vec3,
    /// `1 − cos θ` of the half-angle θ: 0 a point light, 1 a hemisphere, 2 the whole sphere (receiver inside).
    pub one_minus_cos: f32,
    /// Distance to the light's centre; infinite for a light at infinity.
    pub distance: f32,
}

impl Cone {
    /// Receivers are inside a sphere up to this part of its radius. Above, as the points of its own surface are but for rounding, they see
    /// a hemisphere of it.
    pub const INSIDE: f32 = 0.999;

    /// The cone in which a sphere is seen from `x`: `sin θ = r/d`, `1 − cos θ = sin²θ/(1 + cos θ)`.
    ///
    /// The whole sphere of directions when `x` is [inside](Self::INSIDE) the sphere. Any finite sphere and point whose difference is finite.
    #[inline(always)]
    #[must_use]
    pub fn of_sphere(x: Vec3, sphere: Sphere) -> Self {
        // Choices and no branches: it is taken of many receivers at once.
        let to = sphere.center - x;
        // Scaled by a power of two, so that the square of no length overflows or vanishes.
        let larger = |a: f32, b: f32| if a > b { a } else { b };
        let size = larger(larger(to.x.abs(), to.y.abs()), to.z.abs()).to_bits() & 0x7f80_0000;
        let size = size.clamp(1 << 23, 253 << 23);
        let unit = to * f32::from_bits((254 << 23) - size);
        let length = unit.length();
        let distance = length * f32::from_bits(size);
        let inside = distance <= Self::INSIDE * sphere.radius || distance <= 0.0;
        let axis = if length > 0.0 { unit / length } else { Vec3::Z };
        let sin = sphere.radius / distance;
        let sin = if inside {
            0.0
        } else if sin < 1.0 {
            sin
        } else {
            1.0
        };
        let cos = ((1.0 - sin) * (1.0 + sin)).sqrt();
        // A point at the receiver is still a point.
        let all = if sphere.radius > 0.0 { 2.0 } else { 0.0 };
        Self { axis, one_minus_cos: if inside { all } else { sin * sin / (1.0 + cos) }, distance }
    }

    /// `cos θ`.
    #[must_use]
    pub fn cos(&self) -> f32 {
        1.0 - self.one_minus_cos
    }

    /// `sin²θ = (1 − cos θ)(1 + cos θ)`.
    #[must_use]
    pub fn sin_sq(&self) -> f32 {
        self.one_minus_cos * (2.0 - self.one_minus_cos)
    }

    /// Solid angle `2π(1 − cos θ)` in steradians.
    #[must_use]
    pub fn solid_angle(&self) -> f32 {
        core::f32::consts::TAU * self.one_minus_cos
    }

    /// `tan θ`; meaningful for half-angles below 90°.
    #[must_use]
    pub fn tan(&self) -> f32 {
        self.sin_sq().sqrt() / self.cos()
    }
}

/// Two unit vectors that make a right-handed orthonormal basis `(u, v, axis)`, without a singular direction
/// (T. Duff et al., *Building an Orthonormal Basis, Revisited*, JCGT 6 (1), 2017).
#[inline]
#[must_use]
pub fn orthonormal_basis(axis: Vec3) -> (Vec3, Vec3) {
    axis.any_orthonormal_pair()
}
