//! The camera as the kernel reads it: its rays, and the tiles of a window of its image.

use bytemuck::{Pod, Zeroable};
use core::ops::Range;
use scene::{Bounds, Camera, Projection};

/// Side in pixels of the tiles in whose order points lie: [`GpuPoints::pixel`](crate::GpuPoints::pixel).
pub const TILE: u32 = 8;

/// Kinds of rays that differ by their starts, and by longitude and latitude, as trace.wgsl knows them.
pub(crate) const PARALLEL: u32 = 1;
pub(crate) const PANORAMIC: u32 = 2;

/// `View` of trace.wgsl: the rays of a camera, and a window of its image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct GpuView {
    eye: [f32; 3],
    unit: f32,
    corner: [f32; 3],
    across: u32,
    right: [f32; 3],
    left: u32,
    down: [f32; 3],
    top: u32,
    columns: [u32; 2],
    rows: [u32; 2],
    turns: [f32; 2],
    bundle: u32,
    padding: u32,
}

impl GpuView {
    /// Rays as in `render_cpu`; `bounds` are around all that they may meet. Lengths are in units of the hierarchy: `scale` of them are one
    /// world unit.
    pub(super) fn new(
        camera: &Camera,
        [width, height]: [u32; 2],
        [columns, rows]: [&Range<u32>; 2],
        bounds: &Bounds,
        scale: f32,
    ) -> Self {
        let [right, up, forward] = camera.axes();
        let (w, h) = (width as f32, height as f32);
        let first = |range: &Range<u32>| range.start / TILE * TILE;
        let view = Self {
            eye: (camera.eye * scale).into(),
            unit: 1.0 / scale,
            across: (columns.end - first(columns)).div_ceil(TILE),
            left: first(columns),
            top: first(rows),
            columns: [columns.start, columns.end],
            rows: [rows.start, rows.end],
            ..Self::default()
        };
        match camera.projection {
            Projection::Perspective { vertical_fov } => {
                let half = (0.5 * vertical_fov).tan();
                Self {
                    corner: (forward - right * (w / h * half) + up * half).into(),
                    right: (right * (2.0 * half / h)).into(),
                    down: (up * (-2.0 * half / h)).into(),
                    ..view
                }
            }
            Projection::Orthographic { height: units } => {
                let half = 0.5 * units;
                let corner = camera.eye_before(bounds) - right * (w / h * half) + up * half;
                Self {
                    eye: (corner * scale).into(),
                    corner: forward.into(),
                    right: (right * (units / h * scale)).into(),
                    down: (up * (-units / h * scale)).into(),
                    bundle: PARALLEL,
                    ..view
                }
            }
            Projection::Panoramic => Self {
                corner: forward.into(),
                right: right.into(),
                down: (-up).into(),
                turns: [4.0 / w, 2.0 / h],
                bundle: PANORAMIC,
                ..view
            },
        }
    }

    /// Columns and rows of tiles.
    pub(super) const fn tiles(&self) -> [u32; 2] {
        let down = (self.rows[1] - self.top).div_ceil(TILE);
        if self.columns[0] == self.columns[1] || self.rows[0] == self.rows[1] { [0; 2] } else { [self.across, down] }
    }

    /// The number of a place's pixel in the window; `None` outside the window.
    pub(super) fn pixel(&self, place: u32) -> Option<u32> {
        let ([across, down], area) = (self.tiles(), TILE * TILE);
        if place / area >= across * down {
            return None;
        }
        let (tile, lane) = (place / area, place % area);
        let x = self.left + tile % across * TILE + lane % TILE;
        let y = self.top + tile / across * TILE + lane / TILE;
        let ([left, right], [top, bottom]) = (self.columns, self.rows);
        let inside = (left..right).contains(&x) && (top..bottom).contains(&y);
        inside.then(|| (y - top) * (right - left) + (x - left))
    }

    #[cfg(test)]
    pub(super) const OFFSETS: [usize; 12] = {
        use core::mem::offset_of;
        [
            offset_of!(Self, eye),
            offset_of!(Self, unit),
            offset_of!(Self, corner),
            offset_of!(Self, across),
            offset_of!(Self, right),
            offset_of!(Self, left),
            offset_of!(Self, down),
            offset_of!(Self, top),
            offset_of!(Self, columns),
            offset_of!(Self, rows),
            offset_of!(Self, turns),
            offset_of!(Self, bundle),
        ]
    };
}
