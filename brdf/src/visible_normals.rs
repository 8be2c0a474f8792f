use core::f32::consts::{FRAC_1_PI, TAU};
use glam::Vec3;
use lobe_core::{Microfacets, orthonormal_basis};

/// Microfacets of the GGX distribution as the eye sees them, to be drawn from (E. Heitz, *Sampling the GGX Distribution of Visible
/// Normals*, 2018).
#[derive(Clone, Copy, Debug)]
pub(crate) struct VisibleNormals {
    /// Tangents and normal.
    frame: [Vec3; 3],
    /// The eye in that frame, above the horizon.
    view: Vec3,
    /// Along both tangents.
    alphas: [f32; 2],
}

impl VisibleNormals {
    pub(crate) fn new(normal: Vec3, view: Vec3, alpha: f32) -> Self {
        let (t, b) = orthonormal_basis(normal);
        Self::in_frame([t, b, normal], view, [alpha; 2])
    }

    /// The same with an `α` for each of both tangents.
    pub(crate) fn in_frame(frame: [Vec3; 3], view: Vec3, alphas: [f32; 2]) -> Self {
        let [t, b, normal] = frame;
        let local = Vec3::new(t.dot(view), b.dot(view), normal.dot(view).max(Microfacets::GRAZING)).normalize();
        Self { frame, view: local, alphas }
    }

    /// The mirrored eye about a microfacet; it may be below the horizon.
    pub(crate) fn draw(&self, [u, azimuth]: [f32; 2]) -> Vec3 {
        let [along, across] = self.alphas;
        let stretched = Vec3::new(along * self.view.x, across * self.view.y, self.view.z).normalize();
        // A point of the disc, of which the half that is turned away is foreshortened.
        let radius = u.sqrt();
        let (sin, cos) = (TAU * azimuth).sin_cos();
        let (x, y) = (radius * cos, radius * sin);
        let share = 0.5 * (1.0 + stretched.z);
        let y = (1.0 - share) * (1.0 - x * x).max(0.0).sqrt() + share * y;
        // Its second axis points up, toward the normal.
        let (x_axis, y_axis) = up(stretched);
        let microfacet = x_axis * x + y_axis * y + stretched * (1.0 - x * x - y * y).max(0.0).sqrt();
        let microfacet = Vec3::new(along * microfacet.x, across * microfacet.y, microfacet.z.max(1e-7)).normalize();
        let mirrored = 2.0 * self.view.dot(microfacet) * microfacet - self.view;
        (self.frame[0] * mirrored.x + self.frame[1] * mirrored.y + self.frame[2] * mirrored.z).normalize()
    }

    /// Density of [`draw`](Self::draw): `G₁·D/(4 n·ω_o)`.
    pub(crate) fn density(&self, v: Vec3) -> f32 {
        let local = Vec3::new(self.frame[0].dot(v), self.frame[1].dot(v), self.frame[2].dot(v));
        let h = self.view + local;
        let [along, across] = self.alphas;
        let spread = (h.z * h.z + (h.x / along).powi(2) + (h.y / across).powi(2)).max(1e-30);
        let d = FRAC_1_PI / (along * across) * (h.length_squared() / spread).powi(2);
        let Vec3 { x, y, z } = self.view;
        let masking = 2.0 / (z + ((along * x).powi(2) + (across * y).powi(2) + z * z).sqrt());
        0.25 * d * masking
    }
}

/// Axes across a direction, the second in its plane with the normal.
fn up(direction: Vec3) -> (Vec3, Vec3) {
    let across = Vec3::new(-direction.y, direction.x, 0.0);
    if across.length_squared() <= 1e-12 {
        return orthonormal_basis(direction);
    }
    let across = across.normalize();
    (across, direction.cross(across))
}
