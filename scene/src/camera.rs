use crate::mesh::MAX_COORDINATE;
use crate::{Bounds, SceneError};
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
    /// Looks at everything in `bounds` from the direction `from` (from the middle of the box toward the eye), y up.
    ///
    /// The box's enclosing ball just fits the field of view, which is taken as that of the image's smaller edge.
    #[must_use]
    pub fn framing(bounds: Bounds, from: Vec3, vertical_fov: f32, width: u32, height: u32) -> Self {
        let half = (0.5 * vertical_fov).tan() * (width as f32 / height as f32).min(1.0);
        let distance = bounds.radius().max(f32::MIN_POSITIVE) / half.atan().sin();
        let target = bounds.center();
        Self { eye: target + distance * from.normalize_or(Vec3::Z), target, up: Vec3::Y, vertical_fov }
    }

    /// Checks that the eye differs from the target, that `up` is not parallel to the view, that the field of view lies
    /// in (0°, 180°), and that all numbers are finite.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] that names the first fault.
    pub fn validate(&self) -> Result<(), SceneError> {
        for (name, v) in [("eye", self.eye), ("target", self.target), ("up", self.up)] {
            if v.is_nan() || v.abs().max_element() > MAX_COORDINATE {
                return Err(SceneError::invalid(format!("camera {name} is {v}: coordinates must lie within ±1e17")));
            }
        }
        let forward = (self.target - self.eye).as_dvec3();
        let up = self.up.as_dvec3();
        // In f32 the direction would be lost below this.
        if forward.length() < 1e-18 || !(self.target - self.eye).normalize().is_finite() {
            return Err(SceneError::invalid("camera eye and target are the same point"));
        }
        if up.length() < 1e-18 {
            return Err(SceneError::invalid("camera up has length zero"));
        }
        if forward.normalize().cross(up.normalize()).length() < 1e-5 {
            return Err(SceneError::invalid("camera up is parallel to the view direction"));
        }
        let degrees = self.vertical_fov.to_degrees();
        if !(1e-3..=179.9).contains(&degrees) {
            return Err(SceneError::invalid(format!(
                "camera field of view is {degrees}°: expected more than 0 and less than 180 (0.001…179.9)"
            )));
        }
        Ok(())
    }

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
