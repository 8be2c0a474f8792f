use glam::{Vec2, Vec3, Vec4};

use crate::bits::BitImage;

/// Side of a cell in pixels.
pub(crate) const CELL: usize = 4;

/// A parallel projection of unit space onto a square image.
#[derive(Clone, Copy)]
pub(crate) struct Frame {
    u: Vec3,
    v: Vec3,
    low: Vec2,
    /// Pixels a unit of length.
    pub(crate) scale: f32,
}

impl Frame {
    /// Looks along `direction` at everything in `points`, grown by `margin`.
    pub(crate) fn new(direction: Vec3, points: impl Iterator<Item = (Vec3, f32)>, margin: f32, size: usize) -> Self {
        let (u, v) = direction.any_orthonormal_pair();
        Self::with_axes(u, v, points, margin, size)
    }

    pub(crate) fn with_axes(
        u: Vec3,
        v: Vec3,
        points: impl Iterator<Item = (Vec3, f32)>,
        margin: f32,
        size: usize,
    ) -> Self {
        let (mut lo, mut hi) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for (p, radius) in points {
            let q = Vec2::new(u.dot(p), v.dot(p));
            (lo, hi) = (lo.min(q - radius), hi.max(q + radius));
        }
        let extent = (hi - lo).max_element() + 2.0 * margin;
        Self { u, v, low: (lo + hi) * 0.5 - extent * 0.5, scale: size as f32 / extent }
    }

    /// The same projection onto an image with `factor` times as many pixels a side.
    pub(crate) fn finer(self, factor: f32) -> Self {
        Self { scale: self.scale * factor, ..self }
    }

    /// Pixel coordinates of a point.
    pub(crate) fn project(&self, p: Vec3) -> Vec2 {
        (Vec2::new(self.u.dot(p), self.v.dot(p)) - self.low) * self.scale
    }

    /// Pixel coordinates and radius of a sphere's disc.
    pub(crate) fn disc(&self, sphere: Vec4) -> (Vec2, f32) {
        (self.project(sphere.truncate()), sphere.w * self.scale)
    }

    /// The vector in space that a vector in the image came from.
    pub(crate) fn lift(&self, image: Vec2) -> Vec3 {
        self.u * image.x + self.v * image.y
    }

    /// Silhouette of triangles.
    pub(crate) fn draw_mesh(&self, triangles: &[[Vec3; 3]], image: &mut BitImage) {
        for triangle in triangles {
            image.triangle(triangle.map(|p| self.project(p)));
        }
    }

    /// Silhouette of spheres.
    pub(crate) fn draw_spheres(&self, spheres: &[Vec4], image: &mut BitImage) {
        for sphere in spheres {
            let (center, radius) = self.disc(*sphere);
            image.disc(center, radius);
        }
    }
}

/// The mesh's silhouette from one direction, in the forms that the descent needs.
pub(crate) struct View {
    pub(crate) frame: Frame,
    /// Pixels a side.
    pub(crate) size: usize,
    /// 1 / silhouette area, in pixels; the weight of a pixel of this view.
    pub(crate) inverse_area: f32,
    /// The silhouette at twice the resolution.
    fine: BitImage,
    /// The fraction of each cell of [`CELL`]² pixels that is in the silhouette.
    pub(crate) cells: Vec<f32>,
    /// Per pixel: subpixels (of 4) outside the silhouette minus those inside.
    pub(crate) outside: Vec<i8>,
    /// `outside`, smoothed over 3×3 pixels and scaled to −64 … 64: the sign that a moving boundary feels.
    soft: Vec<i8>,
}

impl View {
    pub(crate) fn new(direction: Vec3, triangles: &[[Vec3; 3]], margin: f32, size: usize) -> Self {
        let frame = Frame::new(direction, triangles.iter().flatten().map(|p| (*p, 0.0)), margin, size);
        let mut fine = BitImage::new(2 * size);
        frame.finer(2.0).draw_mesh(triangles, &mut fine);
        let mut outside = vec![0_i8; size * size];
        for y in 0..size {
            for x in 0..size {
                let bit = |dx, dy| i8::from(fine.get(2 * x + dx, 2 * y + dy));
                outside[y * size + x] = 4 - 2 * (bit(0, 0) + bit(0, 1) + bit(1, 0) + bit(1, 1));
            }
        }
        let soft = smooth(&outside, size);
        let area = fine.count().max(1) as f32 * 0.25;
        let side = size / CELL;
        let mut cells = vec![0.0; side * side];
        for (i, outside) in outside.iter().enumerate() {
            let inside = (4 - i32::from(*outside)) as f32 / 8.0;
            cells[i / size / CELL * side + i % size / CELL] += inside / (CELL * CELL) as f32;
        }
        Self { frame, size, inverse_area: 1.0 / area, fine, cells, outside, soft }
    }

    /// Weighs the views by at least `share` of their mean silhouette area: a sheet seen from its edge, where any sphere
    /// is an error of many times the silhouette, must not keep the spheres from covering it face on.
    pub(crate) fn limit_weights(views: &mut [Self], share: f32) {
        let least = share * Self::mean_area(views);
        for view in views {
            view.inverse_area /= (least / view.area()).max(1.0);
        }
    }

    /// Area of the silhouette in units of D², or the minimum from [`Self::limit_weights`].
    fn area(&self) -> f32 {
        1.0 / (self.inverse_area * self.frame.scale * self.frame.scale)
    }

    pub(crate) fn mean_area(views: &[Self]) -> f32 {
        views.iter().map(Self::area).sum::<f32>() / views.len().max(1) as f32
    }

    /// Half-way smooth sign at a point of the image: −1 well inside the silhouette, 1 well outside.
    pub(crate) fn sign(&self, p: Vec2) -> f32 {
        let last = (self.size - 2) as f32;
        let q = p - 0.5;
        if !(q.x >= 0.0 && q.y >= 0.0 && q.x <= last && q.y <= last) {
            return 1.0;
        }
        let (x, y) = (q.x as usize, q.y as usize);
        let (fx, fy) = (q.x - x as f32, q.y - y as f32);
        let at = y * self.size + x;
        let row = |at: usize| {
            let (a, b) = (f32::from(self.soft[at]), f32::from(self.soft[at + 1]));
            a + (b - a) * fx
        };
        let (top, bottom) = (row(at), row(at + self.size));
        (top + (bottom - top) * fy) * (1.0 / 64.0)
    }

    /// Area of the difference of the two silhouettes in pixels; `scratch` has twice the view's side.
    pub(crate) fn difference(&self, spheres: &[Vec4], scratch: &mut BitImage) -> f32 {
        scratch.clear();
        self.frame.finer(2.0).draw_spheres(spheres, scratch);
        self.fine.differences(scratch) as f32 * 0.25
    }
}

/// 16 × the (1 2 1)/4 tent in both directions.
fn smooth(image: &[i8], size: usize) -> Vec<i8> {
    let mut out = vec![64_i8; size * size];
    for y in 1..size - 1 {
        for x in 1..size - 1 {
            let mut sum = 0_i32;
            for (dy, wy) in [(0, 1), (1, 2), (2, 1)] {
                let row = (y + dy - 1) * size + x - 1;
                sum += wy * (i32::from(image[row]) + 2 * i32::from(image[row + 1]) + i32::from(image[row + 2]));
            }
            out[y * size + x] = sum as i8;
        }
    }
    out
}
