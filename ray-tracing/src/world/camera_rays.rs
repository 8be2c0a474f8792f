//! The rays of a camera, and where points are seen.

use core::f32::consts::{PI, TAU};
use fearless_simd::Level;
use glam::{Vec2, Vec3};
use lobe_core::Receiver;
use scene::{Bounds, Camera, Projection};

/// Side of a tile, and how many rays are tested at once.
pub(crate) const SIDE: usize = 8;
pub(super) type Row = [f32; SIDE];

/// How rays differ from each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bundle {
    /// By directions that reach evenly spaced points of a plane, all from the eye.
    Plane,
    /// By their starts, in one direction.
    Parallel,
    /// By longitude and latitude, all from the eye.
    Sphere,
}

/// [`Camera::direction`] and [`Camera::start`] with everything that is constant over the picture computed once.
pub(crate) struct Rays {
    pub(crate) eye: Vec3,
    pub(crate) forward: Vec3,
    pub(crate) bundle: Bundle,
    /// Direction through the corner (0, 0) of the image and its change a pixel to the right and down; the starts of parallel rays. Of a
    /// sphere the unit vectors forward, to the right and down.
    corner: Vec3,
    right: Vec3,
    down: Vec3,
    /// A direction's product with this, over its product with `forward`, is its column in pixels from the middle; `to_row` likewise.
    /// Of parallel rays a position's product is its column.
    pub(super) to_column: Vec3,
    pub(super) to_row: Vec3,
    pub(super) middle: Vec2,
    /// More than rounding moves a projected point, in pixels.
    pub(super) margin: f32,
    pub(crate) level: Level,
}

impl Rays {
    /// The rays of a camera; parallel ones may start just before a box around all that they may meet.
    pub(crate) fn new(camera: &Camera, width: u32, height: u32, bounds: &Bounds) -> Self {
        let [right, up, forward] = camera.axes();
        let (w, h) = (width as f32, height as f32);
        let (middle, level) = (0.5 * Vec2::new(w, h), Level::new());
        match camera.projection {
            Projection::Perspective { vertical_fov } => {
                let half = (0.5 * vertical_fov).tan();
                let pixels = h / (2.0 * half);
                Self {
                    eye: camera.eye,
                    forward,
                    bundle: Bundle::Plane,
                    corner: forward - right * (w / h * half) + up * half,
                    right: right * (2.0 * half / h),
                    down: up * (-2.0 * half / h),
                    to_column: right * pixels,
                    to_row: up * -pixels,
                    middle,
                    margin: 0.01 + 2e-6 * (w + h + pixels),
                    level,
                }
            }
            Projection::Orthographic { height: units } => {
                let (half, pixels) = (0.5 * units, h / units);
                Self {
                    eye: camera.eye,
                    forward,
                    bundle: Bundle::Parallel,
                    corner: camera.eye_before(bounds) - right * (w / h * half) + up * half,
                    right: right * (units / h),
                    down: up * (-units / h),
                    to_column: right * pixels,
                    to_row: up * -pixels,
                    middle,
                    margin: 0.01 + 2e-6 * (w + h),
                    level,
                }
            }
            Projection::Panoramic => Self {
                eye: camera.eye,
                forward,
                bundle: Bundle::Sphere,
                corner: forward,
                right,
                down: -up,
                to_column: Vec3::ZERO,
                to_row: Vec3::ZERO,
                middle,
                margin: 0.0,
                level,
            },
        }
    }

    /// Unit direction of the ray through an image point.
    #[inline(always)]
    pub(crate) fn direction(&self, x: f32, y: f32) -> Vec3 {
        match self.bundle {
            Bundle::Plane => self.toward(x, y).normalize(),
            Bundle::Parallel => self.forward,
            Bundle::Sphere => self.around(self.longitude(x), self.latitude(y)),
        }
    }

    /// Where the ray through an image point starts.
    #[inline(always)]
    pub(crate) fn start(&self, x: f32, y: f32) -> Vec3 {
        if self.bundle == Bundle::Parallel { self.toward(x, y) } else { self.eye }
    }

    #[inline(always)]
    pub(super) fn toward(&self, x: f32, y: f32) -> Vec3 {
        self.corner + self.right * x + self.down * y
    }

    /// Sine and cosine of a column's longitude.
    #[inline(always)]
    pub(super) fn longitude(&self, x: f32) -> (f32, f32) {
        ((x - self.middle.x) * (0.5 * TAU / self.middle.x)).sin_cos()
    }

    /// Sine and cosine of a row's latitude, downward.
    #[inline(always)]
    pub(super) fn latitude(&self, y: f32) -> (f32, f32) {
        ((y - self.middle.y) * (0.5 * PI / self.middle.y)).sin_cos()
    }

    /// The direction of a longitude and a latitude.
    #[inline(always)]
    pub(super) fn around(&self, (aside, ahead): (f32, f32), (fall, along): (f32, f32)) -> Vec3 {
        ((self.corner * ahead + self.right * aside) * along + self.down * fall).normalize()
    }

    /// How deep a point is: its distance from the plane of the eye along the view direction, in a panorama that from the eye.
    #[inline(always)]
    pub(crate) fn depth(&self, point: Vec3) -> f32 {
        let to = point - self.eye;
        if self.bundle == Bundle::Sphere { to.length() } else { to.dot(self.forward) }
    }

    /// From a point to where the ray through an image point meets its plane: not farther than the point is from the eye, four times; of
    /// parallel rays not deeper by more than four pictures.
    pub(crate) fn side(&self, x: f32, y: f32, at: &Receiver) -> Vec3 {
        if self.bundle != Bundle::Parallel {
            return side(self.eye, at, self.direction(x, y));
        }
        let (start, direction) = (self.toward(x, y), self.forward);
        let to = at.position - start;
        let (own, reach) = (to.dot(direction), 8.0 * self.middle.y * self.down.length());
        let along = at.face.dot(to) / at.face.dot(direction);
        let along = if along.is_finite() { along.clamp(own - reach, own + reach) } else { own + reach };
        direction * along - to
    }
}

/// From a point to where another ray from the eye meets its plane.
fn side(eye: Vec3, at: &Receiver, direction: Vec3) -> Vec3 {
    let to = at.position - eye;
    let distance = to.length();
    let along = at.face.dot(to) / at.face.dot(direction);
    let along = if along > 0.0 { along.min(4.0 * distance) } else { 4.0 * distance };
    direction * along - to
}
