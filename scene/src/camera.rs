use crate::mesh::MAX_COORDINATE;
use crate::{Bounds, SceneError};
use core::f32::consts::{PI, TAU};
use glam::Vec3;

/// How a camera maps the scene to its picture.
///
/// For the point (`x`, `y`) of a picture of `w` × `h` pixels, row 0 at the top, and the unit vectors right, up and forward of the
/// camera, rays start at `o` and have the direction `d`:
///
/// ```text
/// perspective:   o = eye                                d ∝ forward + tan(fov/2)/h · ((2x − w) right + (h − 2y) up)
/// orthographic:  o = eye + height/h · ((x − w/2) right + (h/2 − y) up)             d = forward
/// panoramic:     o = eye    d = cos φ (cos λ forward + sin λ right) + sin φ up,    λ = 2π (x/w − ½), φ = π (½ − y/h)
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// As a pinhole sees: straight lines stay straight, and what is farther away is smaller.
    Perspective {
        /// Full vertical field of view in radians.
        vertical_fov: f32,
    },
    /// By parallel rays: the size of things does not depend on their distance. The picture begins at the plane through the eye.
    Orthographic {
        /// Height of the picture in units of the scene.
        height: f32,
    },
    /// All directions around the eye by longitude and latitude (equirectangular): the view direction is in the middle, and pixels are
    /// square in pictures twice as wide as high.
    Panoramic,
}

impl Projection {
    /// The least and the largest height of an orthographic picture.
    const HEIGHTS: core::ops::RangeInclusive<f32> = 1e-9..=MAX_COORDINATE;

    /// The perspective projection of a full vertical field of view in radians.
    #[must_use]
    pub const fn perspective(vertical_fov: f32) -> Self {
        Self::Perspective { vertical_fov }
    }

    /// Its name in scene files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Perspective { .. } => "perspective",
            Self::Orthographic { .. } => "orthographic",
            Self::Panoramic => "panoramic",
        }
    }

    /// Checks that its number is usable: a field of view in (0°, 180°), a finite height above 0.
    ///
    /// # Errors
    /// [`SceneError::Invalid`].
    pub fn validate(self) -> Result<(), SceneError> {
        match self {
            Self::Perspective { vertical_fov } => {
                let degrees = vertical_fov.to_degrees();
                if (1e-3..=179.9).contains(&degrees) {
                    return Ok(());
                }
                Err(SceneError::invalid(format!(
                    "camera field of view is {degrees}°: expected more than 0 and less than 180 (0.001…179.9)"
                )))
            }
            Self::Orthographic { height } if Self::HEIGHTS.contains(&height) => Ok(()),
            Self::Orthographic { height } => {
                let (least, most) = (Self::HEIGHTS.start(), Self::HEIGHTS.end());
                Err(SceneError::invalid(format!(
                    "camera height is {height}: expected more than 0 units and a finite number ({least:e}…{most:e})"
                )))
            }
            Self::Panoramic => Ok(()),
        }
    }
}

/// A camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The position of the eye.
    pub eye: Vec3,
    /// The point that it looks at.
    pub target: Vec3,
    /// Roughly up; not parallel to the view direction.
    pub up: Vec3,
    /// How it maps the scene to its picture.
    pub projection: Projection,
}

impl Default for Camera {
    /// Five units before the origin, and up by one; a perspective camera.
    fn default() -> Self {
        let projection = Projection::perspective(0.7);
        Self { eye: Vec3::new(0.0, 1.0, 5.0), target: Vec3::ZERO, up: Vec3::Y, projection }
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
        let projection = Projection::perspective(vertical_fov);
        Self { eye: target + 1.125 * distance * toward, target, up: Vec3::Y, projection }
    }

    /// Checks that the eye differs from the target, that `up` is not parallel to the view, that the [projection](Projection::validate)
    /// has usable numbers, and that all numbers are finite.
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
        self.projection.validate()
    }

    /// Unit vectors to the right, upward and forward.
    #[must_use]
    pub fn axes(&self) -> [Vec3; 3] {
        let forward = (self.target - self.eye).normalize();
        let right = forward.cross(self.up).normalize();
        [right, right.cross(forward), forward]
    }

    /// Unit direction of the ray through the image point (`x`, `y`) in pixels, row 0 at the top; the centre of the
    /// first pixel is (0.5, 0.5).
    #[must_use]
    pub fn direction(&self, x: f32, y: f32, width: u32, height: u32) -> Vec3 {
        let [right, up, forward] = self.axes();
        let (w, h) = (width as f32, height as f32);
        match self.projection {
            Projection::Perspective { vertical_fov } => {
                let half = (0.5 * vertical_fov).tan();
                let sx = (2.0 * x - w) / h * half;
                let sy = (1.0 - 2.0 * y / h) * half;
                (forward + right * sx + up * sy).normalize()
            }
            Projection::Orthographic { .. } => forward,
            Projection::Panoramic => {
                let (sin, cos) = ((x / w - 0.5) * TAU).sin_cos();
                let (rise, along) = ((0.5 - y / h) * PI).sin_cos();
                ((forward * cos + right * sin) * along + up * rise).normalize()
            }
        }
    }

    /// Where the ray through an image point in pixels starts: the eye, but for an orthographic camera a point of the plane through
    /// the eye.
    ///
    /// ```
    /// use glam::Vec3;
    /// use scene::{Camera, Projection};
    /// let projection = Projection::Orthographic { height: 4.0 };
    /// let camera = Camera { eye: Vec3::Z, target: Vec3::ZERO, up: Vec3::Y, projection };
    /// assert_eq!(camera.start(0.0, 0.0, 200, 100), Vec3::new(-4.0, 2.0, 1.0));
    /// assert_eq!(camera.direction(0.0, 0.0, 200, 100), Vec3::NEG_Z);
    /// ```
    #[must_use]
    pub fn start(&self, x: f32, y: f32, width: u32, height: u32) -> Vec3 {
        let Projection::Orthographic { height: units } = self.projection else { return self.eye };
        let ([right, up, _], pixel) = (self.axes(), units / height as f32);
        self.eye + right * ((x - 0.5 * width as f32) * pixel) + up * ((0.5 * height as f32 - y) * pixel)
    }

    /// The eye, of an orthographic camera moved forward to just before a box: rays that start there meet the same things in the box, and
    /// an eye far away takes no digits of them.
    #[must_use]
    pub fn eye_before(&self, bounds: &Bounds) -> Vec3 {
        if bounds.is_empty() || !matches!(self.projection, Projection::Orthographic { .. }) {
            return self.eye;
        }
        let eye = self.eye.as_dvec3();
        // Along a rounded direction it would come out beside: by 0.06 from a million away.
        let forward = (self.target.as_dvec3() - eye).normalize();
        let (center, half) = (bounds.center().as_dvec3(), 0.5 * bounds.size().as_dvec3());
        let near = (center - eye).dot(forward) - forward.abs().dot(half);
        let room = 1e-3 * half.length() + 1e-6 * center.length();
        (eye + forward * (near - room).max(0.0)).as_vec3()
    }

    /// The length of the ray from its [start](Self::start) to a point: the distance from the eye, or from the plane of an orthographic
    /// one.
    #[must_use]
    pub fn distance(&self, point: Vec3) -> f32 {
        match self.projection {
            Projection::Orthographic { .. } => (point - self.eye).dot(self.axes()[2]),
            _ => point.distance(self.eye),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera {
            eye: Vec3::new(1.0, 2.0, 5.0),
            target: Vec3::ZERO,
            up: Vec3::Y,
            projection: Projection::perspective(0.8),
        }
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
    fn orthographic_rays_are_parallel_and_spread_evenly() {
        let c = Camera { projection: Projection::Orthographic { height: 3.0 }, ..camera() };
        let [right, up, forward] = c.axes();
        for (x, y) in [(0.0, 0.0), (0.5, 0.5), (320.0, 180.0), (600.5, 10.25)] {
            assert_eq!(c.direction(x, y, 640, 360), forward);
            let from = c.start(x, y, 640, 360) - c.eye;
            let want = Vec3::new((x - 320.0) / 120.0, (180.0 - y) / 120.0, 0.0);
            let is = Vec3::new(from.dot(right), from.dot(up), from.dot(forward));
            assert!((is - want).length() < 2e-6, "{is} {want}");
            assert!((c.distance(c.eye + from + forward * 2.0) - 2.0).abs() < 2e-6);
        }
    }

    #[test]
    fn an_orthographic_eye_comes_near_to_a_box() {
        let bounds = Bounds { min: Vec3::new(-1.0, 0.0, -2.0), max: Vec3::new(3.0, 1.0, 2.0) };
        let eye = Vec3::new(4e5, 3e5, 5e5);
        let far = Camera { eye, target: Vec3::X, up: Vec3::Y, projection: Projection::Orthographic { height: 3.0 } };
        let near = far.eye_before(&bounds);
        let forward = far.axes()[2];
        assert!((near - eye).normalize().dot(forward) > 1.0 - 1e-6);
        assert!(near.length() < 8.0 && Camera { eye: near, ..far }.eye_before(&bounds).distance(near) < 0.1);
        for corner in [bounds.min, bounds.max, Vec3::new(3.0, 1.0, -2.0)] {
            assert!((corner - near).dot(forward) > 0.0);
        }
        // It is on the line through eye and target to the rounding of near numbers, not of far ones.
        let farther = Camera { eye: eye * 20.0, target: Vec3::ZERO, ..far };
        let near = farther.eye_before(&bounds).as_dvec3();
        assert!(near.length() < 8.0 && near.cross(eye.as_dvec3().normalize()).length() < 1e-5, "{near}");
        // One inside stays there, and so does that of another camera.
        let inside = Camera { eye: Vec3::ZERO, ..far };
        assert_eq!(inside.eye_before(&bounds), Vec3::ZERO);
        let panoramic = Camera { projection: Projection::Panoramic, ..far };
        assert_eq!(panoramic.eye_before(&bounds), eye);
        assert_eq!(far.eye_before(&Bounds::EMPTY), eye);
    }

    #[test]
    fn a_panorama_holds_all_directions_and_has_finite_poles() {
        let c = Camera { projection: Projection::Panoramic, ..camera() };
        let [right, up, forward] = c.axes();
        let at = |x, y| c.direction(x, y, 400, 200);
        let wanted = [
            (200.0, 100.0, forward),
            (300.0, 100.0, right),
            (100.0, 100.0, -right),
            (0.0, 100.0, -forward),
            (70.0, 0.0, up),
        ];
        for (x, y, want) in wanted {
            assert!((at(x, y) - want).length() < 1e-6, "{x} {y}");
        }
        assert!((at(400.0, 100.0) + forward).length() < 1e-6 && (at(13.0, 200.0) + up).length() < 1e-6);
        // Latitude by row, longitude by column.
        let d = at(250.0, 50.0);
        assert!((d.dot(up) - (PI / 4.0).sin()).abs() < 1e-6);
        assert!((d.dot(right).atan2(d.dot(forward)) - PI / 4.0).abs() < 1e-6);
        assert_eq!(c.start(3.0, 4.0, 400, 200), c.eye);
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
                let z = d.dot(forward) * 0.3_f32.tan();
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
        let perspective = |fov| fault(&|c| c.projection = Projection::perspective(fov));
        assert!(perspective(core::f32::consts::PI).contains("180"));
        assert!(perspective(0.0).contains("field of view"));
        assert!(perspective(f32::NAN).contains("field of view"));
        for height in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-30, 1e10] {
            let refused = fault(&|c| c.projection = Projection::Orthographic { height });
            assert!(refused.contains("camera height is") && refused.contains("more than 0"), "{refused}");
        }
        for projection in [Projection::Orthographic { height: 3.0 }, Projection::Panoramic] {
            Camera { projection, ..camera() }.validate().unwrap();
        }
    }
}
