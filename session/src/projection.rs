use core::f32::consts::{FRAC_1_PI, PI, TAU};
use glam::{Vec2, Vec3};
use scene::Camera;
use scene::Projection as Kind;

/// A camera and the size of its picture, on a screen of any fineness: from points to pixels and back.
///
/// Pixels are as in [`Camera::direction`]: row 0 at the top, the centre of the first pixel at (0.5, 0.5).
///
/// ```
/// use glam::{Vec2, Vec3};
/// let projection = session::Projection::new(scene::Camera::default(), Vec2::new(640.0, 360.0));
/// let pixel = projection.pixel(Vec3::ZERO).expect("before the eye");
/// assert!(pixel.distance(Vec2::new(320.0, 180.0)) < 1e-3);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Projection {
    camera: Camera,
    size: Vec2,
    forward: Vec3,
    right: Vec3,
    up: Vec3,
    /// Pixels a unit: in perspective at distance 1, of a panorama at distance 1 in its middle.
    focal: f32,
}

impl Projection {
    /// The projection of a [valid](Camera::validate) camera.
    #[must_use]
    pub fn new(camera: Camera, size: Vec2) -> Self {
        let forward = (camera.target - camera.eye).normalize_or(Vec3::NEG_Z);
        let right = forward.cross(camera.up).normalize_or(Vec3::X);
        let up = right.cross(forward);
        let focal = match camera.projection {
            Kind::Perspective { vertical_fov } => 0.5 * size.y / (0.5 * vertical_fov).tan(),
            Kind::Orthographic { height } => size.y / height,
            Kind::Panoramic => size.y * FRAC_1_PI,
        };
        Self { camera, size, forward, right, up, focal }
    }

    /// The camera.
    #[must_use]
    pub const fn camera(&self) -> &Camera {
        &self.camera
    }

    /// Unit vectors to the right, upward and forward.
    #[must_use]
    pub const fn axes(&self) -> [Vec3; 3] {
        [self.right, self.up, self.forward]
    }

    /// Width and height of the picture.
    #[must_use]
    pub const fn size(&self) -> Vec2 {
        self.size
    }

    /// The outline of a sphere in the picture, as so many places in a circle: the points where rays from the eye touch the sphere,
    ///
    /// ```text
    /// c − r²/d · n + r √(1 − r²/d²) · (unit vectors across n)
    /// ```
    ///
    /// of its distance `d` from the eye, in the direction `n`; a circle where rays are parallel. Empty where the eye is inside, where a
    /// part of it is not before the eye, and where the edges of a panorama cut it.
    #[must_use]
    pub fn sphere_outline(&self, center: Vec3, radius: f32, count: usize) -> Vec<Vec2> {
        let angles = (0..count).map(|k| core::f32::consts::TAU * k as f32 / count as f32);
        if self.is_orthographic() {
            let depth = (center - self.camera.eye).dot(self.forward);
            let Some(middle) = self.pixel(center).filter(|_| radius > 0.0 && depth > radius) else { return Vec::new() };
            return angles.map(|angle| middle + radius * self.focal * Vec2::from_angle(angle)).collect();
        }
        let (toward, distance) = (center - self.camera.eye, center.distance(self.camera.eye));
        if !(radius > 0.0 && distance > radius) {
            return Vec::new();
        }
        let along = toward / distance;
        let (across, beside) = along.any_orthonormal_pair();
        let (back, round) = (radius * radius / distance, radius * (1.0 - (radius / distance).powi(2)).sqrt());
        let place = |angle: f32| {
            let (sin, cos) = angle.sin_cos();
            self.pixel(center - back * along + round * (cos * across + sin * beside))
        };
        let outline: Vec<Vec2> = angles.map(place).collect::<Option<_>>().unwrap_or_default();
        let is_torn = |pair: &[Vec2]| (pair[0].x - pair[1].x).abs() > 0.5 * self.size.x;
        let is_panoramic = self.camera.projection == Kind::Panoramic;
        if is_panoramic && outline.windows(2).any(is_torn) { Vec::new() } else { outline }
    }

    fn is_orthographic(&self) -> bool {
        matches!(self.camera.projection, Kind::Orthographic { .. })
    }

    /// The place of a point in the picture, which may be outside of it; none for points behind the eye.
    #[must_use]
    pub fn pixel(&self, point: Vec3) -> Option<Vec2> {
        let v = point - self.camera.eye;
        let (depth, across) = (v.dot(self.forward), Vec2::new(v.dot(self.right), -v.dot(self.up)));
        let from_middle = match self.camera.projection {
            Kind::Perspective { .. } => across * (self.focal / depth),
            Kind::Orthographic { .. } => across * self.focal,
            Kind::Panoramic => {
                let fall = across.y.atan2(depth.hypot(across.x));
                Vec2::new(across.x.atan2(depth) / TAU, fall / PI) * self.size
            }
        };
        let is_before = depth > 0.0 || self.camera.projection == Kind::Panoramic && v != Vec3::ZERO;
        let place = from_middle + 0.5 * self.size;
        (is_before && place.is_finite()).then_some(place)
    }

    /// Unit direction of the ray through a pixel.
    #[must_use]
    pub fn direction(&self, pixel: Vec2) -> Vec3 {
        let from_middle = pixel - 0.5 * self.size;
        match self.camera.projection {
            Kind::Perspective { .. } => {
                let v = from_middle / self.focal;
                (self.forward + v.x * self.right - v.y * self.up).normalize()
            }
            Kind::Orthographic { .. } => self.forward,
            Kind::Panoramic => {
                let [longitude, fall] = (from_middle / self.size * Vec2::new(TAU, PI)).to_array();
                let ahead = longitude.cos() * self.forward + longitude.sin() * self.right;
                (fall.cos() * ahead - fall.sin() * self.up).normalize()
            }
        }
    }

    /// Where the ray through a pixel starts: the eye, or a point of the plane through the eye where rays are parallel.
    #[must_use]
    pub fn start(&self, pixel: Vec2) -> Vec3 {
        if !self.is_orthographic() {
            return self.camera.eye;
        }
        let v = (pixel - 0.5 * self.size) / self.focal;
        self.camera.eye + v.x * self.right - v.y * self.up
    }

    /// A direction from a point against the ray that comes to it.
    #[must_use]
    pub fn toward_eye(&self, point: Vec3) -> Vec3 {
        if self.is_orthographic() { -self.forward } else { self.camera.eye - point }
    }

    /// The length that a pixel has at a point; at the target for points behind the eye.
    #[must_use]
    pub fn pixel_size(&self, point: Vec3) -> f32 {
        let v = point - self.camera.eye;
        let depth = match self.camera.projection {
            Kind::Perspective { .. } => v.dot(self.forward),
            Kind::Orthographic { .. } => return 1.0 / self.focal,
            Kind::Panoramic => v.length(),
        };
        let usual = self.camera.eye.distance(self.camera.target);
        (if depth > 1e-6 * usual { depth } else { usual }) / self.focal
    }

    /// The point under a pixel in the plane through `anchor` that faces the camera.
    #[must_use]
    pub fn in_view_plane(&self, pixel: Vec2, anchor: Vec3) -> Option<Vec3> {
        self.in_plane(pixel, anchor, self.forward)
    }

    /// The point under a pixel in a plane; none where it is seen edge-on or lies behind the eye.
    #[must_use]
    pub fn in_plane(&self, pixel: Vec2, anchor: Vec3, normal: Vec3) -> Option<Vec3> {
        let (start, ray) = (self.start(pixel), self.direction(pixel));
        let t = (anchor - start).dot(normal) / ray.dot(normal);
        (t > 0.0 && t.is_finite()).then(|| start + t * ray)
    }

    /// How far along an axis through `anchor` (a unit vector) the point is that is nearest to the ray through a pixel; none where the
    /// axis points at the eye.
    #[must_use]
    pub fn along(&self, pixel: Vec2, anchor: Vec3, axis: Vec3) -> Option<f32> {
        let ray = self.direction(pixel);
        let (w, b) = (anchor - self.start(pixel), axis.dot(ray));
        let denominator = 1.0 - b * b;
        // |w + t·axis − s·ray|² is least in t and s.
        let t = (b * w.dot(ray) - w.dot(axis)) / denominator;
        (denominator > 1e-4 && t.is_finite()).then_some(t)
    }

    /// The point of a sphere that is nearest to the eye on the ray through a pixel; of a ray that misses it the sphere's nearest one.
    #[must_use]
    pub fn on_sphere(&self, pixel: Vec2, center: Vec3, radius: f32) -> Vec3 {
        let ray = self.direction(pixel);
        let w = self.start(pixel) - center;
        let b = w.dot(ray);
        let root = b * b - (w.length_squared() - radius * radius);
        let nearest = w - b * ray;
        if root <= 0.0 {
            return center + radius * nearest.normalize_or(self.up);
        }
        center + (w + (-b - root.sqrt()) * ray)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Vec2 = Vec2::new(640.0, 360.0);

    fn projection() -> Projection {
        let camera = Camera { eye: Vec3::new(1.0, 2.0, 5.0), target: Vec3::new(0.2, 0.5, 0.0), ..Camera::default() };
        Projection::new(camera, Vec2::new(640.0, 360.0))
    }

    /// The same camera by all projections.
    fn all() -> [Projection; 3] {
        let of = |kind| Projection::new(Camera { projection: kind, ..*projection().camera() }, SIZE);
        [Kind::perspective(0.7), Kind::Orthographic { height: 3.0 }, Kind::Panoramic].map(of)
    }

    #[test]
    fn pixels_are_those_of_the_camera() {
        for p in all() {
            for pixel in [Vec2::new(3.5, 7.5), Vec2::new(320.0, 180.0), Vec2::new(600.0, 20.0)] {
                let direction = p.camera.direction(pixel.x, pixel.y, 640, 360);
                let start = p.camera.start(pixel.x, pixel.y, 640, 360);
                assert!((p.direction(pixel) - direction).length() < 1e-6);
                assert!((p.start(pixel) - start).length() < 1e-5);
                let back = p.pixel(start + 7.0 * direction).unwrap();
                assert!(back.distance(pixel) < 1e-2, "{back} {pixel}");
            }
            let behind = p.pixel(2.0 * p.camera.eye - p.camera.target);
            assert_eq!(behind.is_some(), p.camera.projection == Kind::Panoramic);
        }
    }

    #[test]
    fn a_pixel_has_its_size() {
        for p in all() {
            // Near the middle, where those of a panorama are square.
            let point = p.camera.target + Vec3::new(-0.03, 0.08, 0.04);
            let size = p.pixel_size(point);
            let [_, up, _] = p.axes();
            let moved = p.pixel(point + 10.0 * size * up).unwrap() - p.pixel(point).unwrap();
            assert!((moved.length() - 10.0).abs() < 1e-1, "{moved}");
        }
    }

    #[test]
    fn points_under_pixels_are_in_their_planes() {
        let p = projection();
        let (anchor, pixel) = (Vec3::new(0.1, 0.3, 0.4), Vec2::new(400.0, 100.0));
        for p in all() {
            for normal in [p.axes()[2], Vec3::Y, Vec3::Z] {
                let Some(point) = p.in_plane(pixel, anchor, normal) else { continue };
                assert!((point - anchor).dot(normal).abs() < 1e-4);
                assert!(p.pixel(point).unwrap().distance(pixel) < 1e-2);
            }
            assert!(p.in_view_plane(pixel, anchor).is_some());
        }
        // The plane of the horizon is above this pixel's ray.
        assert_eq!(p.in_plane(Vec2::new(320.0, 350.0), Vec3::Y * 10.0, Vec3::Y), None);
    }

    #[test]
    fn the_nearest_point_of_an_axis() {
        let (anchor, axis) = (Vec3::new(0.3, 0.1, 0.2), Vec3::X);
        for p in all() {
            for want in [-1.5_f32, 0.0, 0.7] {
                let pixel = p.pixel(anchor + want * axis).unwrap();
                assert!((p.along(pixel, anchor, axis).unwrap() - want).abs() < 1e-3);
            }
        }
        let p = projection();
        assert_eq!(p.along(Vec2::new(320.0, 180.0), p.camera.target, p.axes()[2]), None);
    }

    #[test]
    fn points_of_a_sphere() {
        for p in all() {
            let center = p.camera.target;
            let seen = p.on_sphere(Vec2::new(320.0, 180.0), center, 0.5);
            assert!((seen - (center - 0.5 * p.axes()[2])).length() < 1e-3);
            assert!(p.toward_eye(center).normalize().dot(p.axes()[2]) < -0.999);
            let beside = p.on_sphere(Vec2::new(500.0, 180.0), center, 0.5);
            assert!((beside.distance(center) - 0.5).abs() < 1e-4);
        }
    }

    #[test]
    fn outlines_by_parallel_rays_are_circles() {
        let [_, p, panorama] = all();
        let outline = p.sphere_outline(p.camera.target, 0.5, 16);
        // 360 pixels are 3 units.
        assert!(outline.len() == 16 && outline.iter().all(|pixel| (pixel.distance(0.5 * SIZE) - 60.0).abs() < 0.01));
        assert!(p.sphere_outline(2.0 * p.camera.eye - p.camera.target, 0.5, 16).is_empty(), "behind the eye");
        let around = panorama.sphere_outline(panorama.camera.target, 0.5, 16);
        assert!(around.len() == 16 && around.iter().all(|pixel| pixel.distance(0.5 * SIZE) < 30.0));
        // A panorama's edges cut what is behind.
        assert!(panorama.sphere_outline(2.0 * p.camera.eye - p.camera.target, 0.5, 16).is_empty());
    }

    #[test]
    fn rays_through_the_outline_of_a_sphere_touch_it() {
        let camera = Camera { eye: Vec3::new(1.0, 2.0, 6.0), target: Vec3::new(0.0, 0.5, 0.0), ..Camera::default() };
        let projection = Projection::new(camera, Vec2::new(640.0, 360.0));
        for (center, radius) in [(Vec3::new(0.5, 0.2, -1.0), 0.7), (Vec3::new(-1.5, 0.0, 4.0), 1.2)] {
            let outline = projection.sphere_outline(center, radius, 32);
            assert_eq!(outline.len(), 32);
            for pixel in outline {
                let ray = projection.direction(pixel);
                let nearest = camera.eye + ray * (center - camera.eye).dot(ray);
                assert!((nearest.distance(center) / radius - 1.0).abs() < 1e-3, "{pixel}");
            }
        }
        assert!(projection.sphere_outline(camera.eye, 1.0, 8).is_empty(), "the eye is inside");
        assert!(projection.sphere_outline(Vec3::new(2.0, 4.0, 20.0), 1.0, 8).is_empty(), "behind the eye");
    }
}
