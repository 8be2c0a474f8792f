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
    alpha: f32,
}

impl VisibleNormals {
    pub(crate) fn new(normal: Vec3, view: Vec3, alpha: f32) -> Self {
        let (t, b) = orthonormal_basis(normal);
        let local = Vec3::new(t.dot(view), b.dot(view), normal.dot(view).max(Microfacets::GRAZING)).normalize();
        Self { frame: [t, b, normal], view: local, alpha }
    }

    /// The mirrored eye about a microfacet; it may be below the horizon.
    pub(crate) fn draw(&self, [u, azimuth]: [f32; 2]) -> Vec3 {
        let stretched = Vec3::new(self.alpha * self.view.x, self.alpha * self.view.y, self.view.z).normalize();
        // A point of the disc, of which the half that is turned away is foreshortened.
        let radius = u.sqrt();
        let (sin, cos) = (TAU * azimuth).sin_cos();
        let (x, y) = (radius * cos, radius * sin);
        let share = 0.5 * (1.0 + stretched.z);
        let y = (1.0 - share) * (1.0 - x * x).max(0.0).sqrt() + share * y;
        // Its second axis points up, toward the normal.
        let (x_axis, y_axis) = up(stretched);
        let microfacet = x_axis * x + y_axis * y + stretched * (1.0 - x * x - y * y).max(0.0).sqrt();
        let microfacet =
            Vec3::new(self.alpha * microfacet.x, self.alpha * microfacet.y, microfacet.z.max(1e-7)).normalize();
        let mirrored = 2.0 * self.view.dot(microfacet) * microfacet - self.view;
        (self.frame[0] * mirrored.x + self.frame[1] * mirrored.y + self.frame[2] * mirrored.z).normalize()
    }

    /// Density of [`draw`](Self::draw): `G₁·D/(4 n·ω_o)`.
    pub(crate) fn density(&self, v: Vec3) -> f32 {
        let local = Vec3::new(self.frame[0].dot(v), self.frame[1].dot(v), self.frame[2].dot(v));
        let h = self.view + local;
        let a2 = self.alpha * self.alpha;
        let spread = (a2 * h.z * h.z + h.x * h.x + h.y * h.y).max(1e-30);
        let d = a2 * FRAC_1_PI * (h.length_squared() / spread).powi(2);
        let z = self.view.z;
        let masking = 2.0 / (z + (a2 + (1.0 - a2) * z * z).sqrt());
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
