//! Distances of the rays of a packet from boxes of a hierarchy.

use super::super::camera_rays::{Bundle, Row, SIDE};
use super::super::instance_tree::{Boxes, Walk};
use super::super::triangle_packet::inside;
use super::RayPacket;
use fearless_simd::dispatch;
use glam::Vec3;
use obvhs::cwbvh::node::CwBvhNode;

impl RayPacket<'_> {
    /// For the boxes of a node's children, in the hierarchy's units around the base (`scale` a world unit): how near, infinite for those that no
    /// ray meets.
    pub(super) fn child_distances(&self, node: &CwBvhNode, base: Vec3, scale: f32) -> Row {
        if self.rays.bundle == Bundle::Parallel {
            return dispatch!(self.rays.level, _simd => self.depths(&own_boxes(node, base), scale));
        }
        dispatch!(self.rays.level, _simd => self.distances(&own_boxes(node, base)))
    }

    /// The same for a place of a shared mesh, in world units.
    pub(super) fn instance_distances(&self, walk: &Walk<'_>, node: &CwBvhNode) -> Row {
        if self.rays.bundle == Bundle::Parallel {
            return dispatch!(self.rays.level, _simd => self.depths(&walk.boxes(node, self.base), 1.0));
        }
        dispatch!(self.rays.level, _simd => self.placed_distances(&walk.boxes(node, self.base)))
    }

    /// Instances may be smaller than a pixel: boxes between the rays are left out, too.
    #[inline(always)]
    fn placed_distances(&self, boxes: &Boxes) -> Row {
        let mut near = self.distances(boxes);
        if self.rays.bundle == Bundle::Plane {
            self.leave_between(boxes, &mut near);
        }
        near
    }

    /// Makes infinite how near those boxes are that contain no point in which a ray meets the picture's plane.
    #[inline(always)]
    fn leave_between(&self, Boxes { centers, halves }: &Boxes, near: &mut Row) {
        let axes = [self.rays.forward, self.rays.to_column, self.rays.to_row];
        let offset = (self.rays.middle - self.first).to_array();
        let margin = 2.0 * self.rays.margin;
        let mut middles = [[0.0f32; SIDE]; 3];
        let mut sizes = [[0.0f32; SIDE]; 3];
        for (k, axis) in axes.iter().enumerate() {
            let size = axis.abs();
            for l in 0..SIDE {
                (middles[k][l], sizes[k][l]) = (dot(axis, centers, l), dot(&size, halves, l));
            }
        }
        for l in 0..SIDE {
            let (least, most) = (middles[0][l] - sizes[0][l], middles[0][l] + sizes[0][l]);
            let [inverse_least, inverse_most] = [1.0 / least, 1.0 / most];
            // As for the corners of triangles: larger pixel numbers lose precision.
            let aside = middles[1][l].abs() + sizes[1][l] + middles[2][l].abs() + sizes[2][l];
            let mut is_met = true;
            for k in 0..2 {
                let (low, high) = (middles[k + 1][l] - sizes[k + 1][l], middles[k + 1][l] + sizes[k + 1][l]);
                let low = (low * inverse_least).min(low * inverse_most) + offset[k] - margin;
                let high = (high * inverse_least).max(high * inverse_most) + offset[k] + margin;
                let (first, end) = inside(low, high);
                is_met &= first < end;
            }
            near[l] = if is_met || least * 1e5 <= aside { near[l] } else { f32::INFINITY };
        }
    }

    /// As [`distances`](Self::distances), of parallel rays: from the plane in which they start.
    #[inline(always)]
    fn depths(&self, Boxes { centers, halves }: &Boxes, scale: f32) -> Row {
        let (mut near, mut far, mut slack) = ([0.0f32; SIDE], [0.0f32; SIDE], [0.0f32; SIDE]);
        let forward = self.rays.forward.to_array();
        for ((c, h), f) in centers.iter().zip(halves).zip(forward) {
            for l in 0..SIDE {
                let (middle, half) = (f * c[l], f.abs() * h[l]);
                near[l] += middle - half;
                far[l] += middle + half;
                slack[l] += 1e-6 * (c[l].abs() + h[l]);
            }
        }
        let reach_of_planes = self.reach * scale;
        for n in &self.sides {
            let size = n.abs();
            for l in 0..SIDE {
                let reach = dot(n, centers, l) + dot(&size, halves, l);
                far[l] = if reach + reach_of_planes < -slack[l] { f32::NEG_INFINITY } else { far[l] };
            }
        }
        for l in 0..SIDE {
            near[l] = if far[l] < -slack[l] { f32::INFINITY } else { (near[l] - slack[l]).max(0.0) };
        }
        near
    }

    #[inline(always)]
    fn distances(&self, Boxes { centers, halves }: &Boxes) -> Row {
        let mut near = [0.0f32; SIDE];
        let mut slack = [0.0f32; SIDE];
        for (c, h) in centers.iter().zip(halves) {
            for l in 0..SIDE {
                let beside = (c[l].abs() - h[l]).max(0.0);
                near[l] += beside * beside;
                slack[l] += c[l].abs() + h[l];
            }
        }
        for l in 0..SIDE {
            // Far above rounding: a box too many does no harm.
            near[l] = near[l].sqrt() * 0.999_99;
            slack[l] *= -1e-6;
        }
        for n in &self.sides {
            let size = n.abs();
            for l in 0..SIDE {
                let reach = dot(n, centers, l) + dot(&size, halves, l);
                near[l] = if reach < slack[l] { f32::INFINITY } else { near[l] };
            }
        }
        near
    }
}

/// The product of a vector with one of eight.
#[inline(always)]
fn dot(n: &Vec3, v: &[Row; 3], l: usize) -> f32 {
    n.x * v[0][l] + n.y * v[1][l] + n.z * v[2][l]
}

/// The boxes of a node's children around the rays' base, in the hierarchy's units.
#[inline(always)]
fn own_boxes(node: &CwBvhNode, base: Vec3) -> Boxes {
    let step = node.e.map(|e| f32::from_bits(u32::from(e) << 23));
    let p = node.p - base;
    let bounds = [
        (&node.child_min_x, &node.child_max_x, p.x, step[0]),
        (&node.child_min_y, &node.child_max_y, p.y, step[1]),
        (&node.child_min_z, &node.child_max_z, p.z, step[2]),
    ];
    let mut boxes = Boxes { centers: [[0.0; SIDE]; 3], halves: [[0.0; SIDE]; 3] };
    for (axis, (low, high, p, step)) in bounds.into_iter().enumerate() {
        for l in 0..SIDE {
            let (low, high) = (f32::from(low[l]), f32::from(high[l]));
            boxes.centers[axis][l] = p + (low + high) * (0.5 * step);
            boxes.halves[axis][l] = (high - low) * (0.5 * step);
        }
    }
    boxes
}
