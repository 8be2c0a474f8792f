use glam::Vec3;

/// A pinhole camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where the eye is.
    pub eye: Vec3,
    /// What it looks at.
    pub target: Vec3,
    /// Roughly up; not parallel to the view direction.
    pub up: Vec3,
    /// Full vertical field of view in radians.
    pub vertical_fov: f32,
}

impl Camera {
    /// Unit direction of the ray through the image point (`x`, `y`) in pixels, row 0 at the top; the centre of the
    /// first pixel is (0.5, 0.5).
    #[must_use]
    pub fn direction(&self, x: f32, y: f32, width: u32, height: u32) -> Vec3 {
        let forward = (self.target - self.eye).normalize();
        let right = forward.cross(self.up).normalize();
        let up = right.cross(forward);
        let half = (0.5 * self.vertical_fov).tan();
        let (w, h) = (width as f32, height as f32);
        let sx = (2.0 * x - w) / h * half;
        let sy = (1.0 - 2.0 * y / h) * half;
        (forward + right * sx + up * sy).normalize()
    }
}
