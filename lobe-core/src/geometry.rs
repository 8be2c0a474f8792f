use glam::Vec3;

/// The object number of a receiver that belongs to no object with blockers of its own.
pub const OWN_NONE: u32 = u32::MAX;

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
    /// Number of the object that the point lies on, or [`OWN_NONE`]: a visibility strategy must not let an object's
    /// own proxy blacken its skin.
    pub object: u32,
}

/// A ball.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sphere {
    /// Centre.
    pub center: Vec3,
    /// Radius, ≥ 0.
    pub radius: f32,
}

/// How a blocker sphere is seen by receivers of its own object, in units of its radius, so that it follows a sphere that
/// grows: smaller, and blocking a direction only if the ray leaves it farther than `distance` from the receiver.
///
/// A set of spheres bulges out of the mesh that it stands for; what bulges must not blacken the skin around it. From afar
/// it is the silhouette that counts, which the whole sphere has: [`radius_at`](Self::radius_at).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelfShadow {
    /// Radius for receivers of the sphere's own object that are no farther from its centre than its surface, in `[0, 1]`.
    pub radius: f32,
    /// τ: how far from the receiver a ray must leave that ball to be blocked, ≥ 0.
    pub distance: f32,
}

impl SelfShadow {
    /// The radius r(d) for a receiver of the own object at a distance d from the centre, of a ball of radius `whole` that
    /// is `near` for those inside it: `r(d) = R − (R − ρ) R / max(d, R)`, R the whole radius and ρ the near one.
    ///
    /// Lengths ≥ 0 with `near ≤ whole`. The result is between the two, continuous in d, and never NaN.
    #[inline(always)]
    #[must_use]
    pub fn radius_at(whole: f32, near: f32, distance: f32) -> f32 {
        whole - (whole - near) * (whole / distance.max(whole).max(f32::MIN_POSITIVE))
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
    /// The cone in which a ball is seen from `x`: `sin θ = r/d`, `1 − cos θ = sin²θ/(1 + cos θ)`.
    ///
    /// The whole sphere of directions when `x` is inside the ball.
    #[inline(always)]
    #[must_use]
    pub fn of_sphere(x: Vec3, ball: Sphere) -> Self {
        // Choices and no branches: it is taken of many receivers at once.
        let to = ball.center - x;
        let distance = to.length();
        let inside = distance <= ball.radius || distance <= 0.0;
        let axis = if distance > 0.0 { to / distance } else { Vec3::Z };
        let sin = if inside { 0.0 } else { ball.radius / distance };
        let cos = ((1.0 - sin) * (1.0 + sin)).sqrt();
        // A point at the receiver is still a point.
        let all = if ball.radius > 0.0 { 2.0 } else { 0.0 };
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

/// All the segments from a ball of receivers to a ball of light: what a tile of receivers asks its blockers for.
#[derive(Clone, Copy, Debug)]
pub struct Shaft {
    /// Bounds the receivers.
    pub receivers: Sphere,
    /// Bounds the light; an infinite light has a far away centre.
    pub light: Sphere,
}

/// Two unit vectors that make a right-handed orthonormal basis `(u, v, axis)`, without a singular direction
/// (T. Duff et al., *Building an Orthonormal Basis, Revisited*, JCGT 6 (1), 2017).
#[inline]
#[must_use]
pub fn orthonormal_basis(axis: Vec3) -> (Vec3, Vec3) {
    axis.any_orthonormal_pair()
}
