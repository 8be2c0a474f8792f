//! The rays of a camera, and where points are seen.

use fearless_simd::Level;
use glam::{Vec2, Vec3};
use scene::Camera;

/// Side of a tile, and how many rays are tested at once.
pub(crate) const SIDE: usize = 8;
pub(super) type Row = [f32; SIDE];

/// [`Camera::direction`] with everything that is constant over the picture computed once.
pub(crate) struct Rays {
    pub(crate) eye: Vec3,
    pub(crate) forward: Vec3,
    /// Direction through the corner (0, 0) of the image and its change a pixel to the right and down.
    corner: Vec3,
    right: Vec3,
    down: Vec3,
    /// A direction's product with this, over its product with `forward`, is its column in pixels from the middle; `to_row` likewise.
    pub(super) to_column: Vec3,
    pub(super) to_row: Vec3,
    pub(super) middle: Vec2,
    /// More than rounding moves a projected point, in pixels.
    pub(super) margin: f32,
    pub(crate) level: Level,
}

impl Rays {
    pub(crate) fn new(camera: &Camera, width: u32, height: u32) -> Self {
        let forward = (camera.target - camera.eye).normalize();
        let right = forward.cross(camera.up).normalize();
        let up = right.cross(forward);
        let half = (0.5 * camera.vertical_fov).tan();
        let (w, h) = (width as f32, height as f32);
        let pixels = h / (2.0 * half);
        Self {
            eye: camera.eye,
            forward,
            corner: forward - right * (w / h * half) + up * half,
            right: right * (2.0 * half / h),
            down: up * (-2.0 * half / h),
            to_column: right * pixels,
            to_row: up * -pixels,
            middle: 0.5 * Vec2::new(w, h),
            margin: 0.01 + 2e-6 * (w + h + pixels),
            level: Level::new(),
        }
    }

    #[inline(always)]
    pub(crate) fn direction(&self, x: f32, y: f32) -> Vec3 {
        self.toward(x, y).normalize()
    }

    #[inline(always)]
    pub(super) fn toward(&self, x: f32, y: f32) -> Vec3 {
        self.corner + self.right * x + self.down * y
    }
}
