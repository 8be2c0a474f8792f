use crate::mesh::MAX_COORDINATE;
use crate::{Bounds, SceneError};
use glam::Vec3;

/// A pinhole camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The position of the eye.
    pub eye: Vec3,
    /// The point that it looks at.
    pub target: Vec3,
    /// Roughly up; not parallel to the view direction.
    pub up: Vec3,
    /// Full vertical field of view in radians.
    pub vertical_fov: f32,
}

impl Default for Camera {
    /// Five units before the origin, and up by one.
    fn default() -> Self {
        Self { eye: Vec3::new(0.0, 1.0, 5.0), target: Vec3::ZERO, up: Vec3::Y, vertical_fov: 0.7 }
    }
}

impl Camera {
    /// Looks at everything in `bounds` from the direction `from` (from the middle of the box toward the eye), y up: the
    /// nearest distance at which all corners of the box are seen, and an eighth more.
    #[must_use]
    pub fn framing(bounds: Bounds, from: Vec3, vertical_fov: f32, width: u32, height: u32) -> Self {
        let toward = from.normalize_or(Vec3::Z);
        let right = Vec3::Y.cross(toward).normalize_or(Vec3::X);
        let up = toward.cross(right);
        let tan_y = (0.5 * vertical_fov).tan();
        let tan_x = tan_y * width as f32 / height as f32;
        let half = 0.5 * bounds.size();
        let corner = |i: u32| half * Vec3::from_array([0, 1, 2].map(|k| if i >> k & 1 == 0 { -1.0 } else { 1.0 }));
        let needed = |q: Vec3| q.dot(toward) + (q.dot(right).abs() / tan_x).max(q.dot(up).abs() / tan_y);
        let distance = (0..8).map(corner).map(needed).fold(f32::MIN_POSITIVE, f32::max);
        let target = bounds.center();
        Self { eye: target + 1.125 * distance * toward, target, up: Vec3::Y, vertical_fov }
    }

    /// Checks that the eye differs from the target, that `up` is not parallel to the view, that the field of view lies
    /// in (0°, 180°), and that all numbers are finite.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] that names the first fault.
    pub fn validate(&self) -> Result<(), SceneError> {
        for (name, v) in [("eye", self.eye), ("target", self.target), ("up", self.up)] {
            if v.is_nan() || v.abs().max_element() > MAX_COORDINATE {
                return Err(SceneError::invalid(format!("camera {name} is {v}: coordinates must lie within ±1e9")));
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

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera { eye: Vec3::new(1.0, 2.0, 5.0), target: Vec3::ZERO, up: Vec3::Y, vertical_fov: 0.8 }
    }

    #[test]
    fn directions_span_the_field_of_view() {
        let c = camera();
        let (w, h) = (640, 360);
        let middle = c.direction(320.0, 180.0, w, h);
        assert!((middle - (c.target - c.eye).normalize()).length() < 1e-6);
        // Top and bottom middle are the field of view apart; up is up, right is right.
        let (top, bottom) = (c.direction(320.0, 0.0, w, h), c.direction(320.0, 360.0, w, h));
        assert!((top.angle_between(bottom) - 0.8).abs() < 1e-5);
        assert!(top.y > bottom.y);
        assert!(c.direction(640.0, 180.0, w, h).x > c.direction(0.0, 180.0, w, h).x);
    }

    #[test]
    fn framing_sees_every_corner_and_little_else() {
        let bounds = Bounds { min: Vec3::new(-3.0, 0.0, -0.5), max: Vec3::new(1.0, 0.7, 2.0) };
        for (w, h) in [(960, 540), (300, 900)] {
            let c = Camera::framing(bounds, Vec3::new(0.35, 0.45, 1.0), 0.6, w, h);
            c.validate().unwrap();
            let forward = (c.target - c.eye).normalize();
            let right = forward.cross(c.up).normalize();
            let up = right.cross(forward);
            let mut extent = 0.0_f32;
            for i in 0..8 {
                let pick = |k: usize| if i >> k & 1 == 0 { bounds.min[k] } else { bounds.max[k] };
                let d = Vec3::new(pick(0), pick(1), pick(2)) - c.eye;
                let z = d.dot(forward) * (0.5 * c.vertical_fov).tan();
                let x = d.dot(right).abs() / z * h as f32 / w as f32;
                extent = extent.max(x).max(d.dot(up).abs() / z);
            }
            assert!(extent < 1.0 && extent > 0.75, "{extent}");
        }
    }

    #[test]
    fn bad_cameras_are_refused() {
        camera().validate().unwrap();
        let fault = |change: &dyn Fn(&mut Camera)| {
            let mut c = camera();
            change(&mut c);
            c.validate().unwrap_err().to_string()
        };
        assert!(fault(&|c| c.eye = c.target).contains("same point"));
        assert!(fault(&|c| c.up = Vec3::ZERO).contains("length zero"));
        assert!(fault(&|c| c.up = c.eye * -3.0).contains("parallel"));
        assert!(fault(&|c| c.eye.x = f32::NAN).contains("eye"));
        assert!(fault(&|c| c.vertical_fov = core::f32::consts::PI).contains("180"));
        assert!(fault(&|c| c.vertical_fov = 0.0).contains("field of view"));
        assert!(fault(&|c| c.vertical_fov = f32::NAN).contains("field of view"));
    }
}
