use crate::edge_list::{COLUMNS, Columns, ENDS, PLANES};
use crate::mesh::SilhouetteMesh;
use crate::tree::Node;
use core::f32::consts::TAU;
use fearless_simd::{Simd, f32x8, mask32x8, prelude::*};
use glam::Vec3;
use lobe_core::{Sphere, orthonormal_basis};

/// Planes around the hull: eight along the light's path, one behind the receivers, one behind the light.
const SIDES: usize = 10;

/// Error of `n·x + d` in f32, as a part of `|d| + |x| + |y| + |z|`: below it a sign is not known.
pub(crate) const UNSURE: f32 = 6e-7;

/// All segments from some receivers to a light, bounded by planes: no edge outside of it matters to any of the receivers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Hull {
    /// Outward unit normals and the offsets along them.
    normals: [Vec3; SIDES],
    offsets: [f32; SIDES],
    /// The receivers: in a box, each side so much farther.
    center: Vec3,
    half: Vec3,
    radius: f32,
    /// The largest of |x| + |y| + |z| of a receiver.
    reach: f32,
}

impl Hull {
    /// Receivers in the box `center ± half`, or in a ball of `radius` about each of its points. `margin` is for the rounding
    /// of positions.
    pub(crate) fn new(center: Vec3, half: Vec3, radius: f32, light: Sphere, margin: f32) -> Self {
        let to = light.center - center;
        let length = to.length();
        let axis = if length > 0.0 { to / length } else { Vec3::Z };
        let (u, v) = orthonormal_basis(axis);
        let support = |n: Vec3| n.abs().dot(half) + radius;
        let mut hull = Self { center, half, radius, reach: 0.0, ..Self::default() };
        let outer = (center.abs() + half + radius).element_sum();
        hull.reach = outer + margin;
        // Offsets are differences of long numbers.
        let margin = margin + 2e-6 * (outer + light.center.abs().element_sum() + light.radius);
        for k in 0..SIDES {
            let normal = match k {
                0 => -axis,
                1 => axis,
                k => {
                    let (sin, cos) = (TAU * k as f32 / (SIDES - 2) as f32).sin_cos();
                    let beside = u * cos + v * sin;
                    // Touches the ball of receivers and the light: n·axis = (r₀ − r₁)/d.
                    let slope = ((support(beside) - light.radius) / length).clamp(-1.0, 1.0);
                    let slope = if slope.is_nan() { -1.0 } else { slope };
                    axis * slope + beside * (1.0 - slope * slope).max(0.0).sqrt()
                }
            };
            hull.normals[k] = normal;
            let (near, far) = (normal.dot(center) + support(normal), normal.dot(light.center) + light.radius);
            hull.offsets[k] = near.max(far) + margin;
        }
        hull
    }

    /// Which children of a node may have silhouettes inside, as bits.
    #[inline(always)]
    pub(crate) fn meets<S: Simd>(&self, simd: S, node: &Node) -> u32 {
        let load = |c: usize| f32x8::simd_from(simd, node.bounds[c]);
        let [mx, my, mz, ex, ey, ez] = [load(0), load(1), load(2), load(3), load(4), load(5)];
        let mut outside = mask32x8::splat(simd, false);
        for (n, offset) in self.normals.iter().zip(&self.offsets) {
            let far = n.abs();
            let middle = mx * n.x + my * n.y + mz * n.z;
            let reach = ex * far.x + ey * far.y + ez * far.z;
            outside |= (middle - reach).simd_gt(f32x8::splat(simd, *offset));
        }
        // All normals of the cone on one side for all receivers: none of its edges is a silhouette. For d from any point of
        // the box to any receiver that is axis·d > |d| sin α.
        let [ax, ay, az] = [load(6), load(7), load(8)];
        let splat = |x: f32| f32x8::splat(simd, x);
        let (vx, vy, vz) = (splat(self.center.x) - mx, splat(self.center.y) - my, splat(self.center.z) - mz);
        let wide = self.half + self.radius;
        let (wx, wy, wz) = (ex + wide.x, ey + wide.y, ez + wide.z);
        let along = (vx * ax + vy * ay + vz * az).abs();
        let spread = wx * ax.abs() + wy * ay.abs() + wz * az.abs();
        let (fx, fy, fz) = (vx.abs() + wx, vy.abs() + wy, vz.abs() + wz);
        let far = (fx * fx + fy * fy + fz * fz).sqrt();
        let unsure = splat(2.0 * UNSURE) * (self.reach + far);
        outside |= (along - spread - unsure).simd_gt(far * load(9));
        !outside.to_bitmask() as u32 & ((1 << node.len) - 1)
    }

    /// Appends those of eight edges that may be silhouettes inside of the hull; there must be room.
    #[inline(always)]
    fn sift<S: Simd>(&self, simd: S, block: &[f32x8<S>; COLUMNS], lanes: u32, out: &mut Columns<COLUMNS>) {
        let splat = |x: f32| f32x8::splat(simd, x);
        let mut outside = !mask32x8::from_bitmask(simd, u64::from(lanes));
        let [front, other] = PLANES.map(|p| self.faces(simd, [block[p], block[p + 1], block[p + 2], block[p + 3]]));
        outside |= (front[0] & other[0]) | (front[1] & other[1]);
        if outside.all_true() {
            return;
        }
        let [[ax, ay, az], [bx, by, bz]] = ENDS.map(|e| [block[e], block[e + 1], block[e + 2]]);
        for (n, offset) in self.normals.iter().zip(&self.offsets) {
            let a = ax * n.x + ay * n.y + az * n.z;
            let b = bx * n.x + by * n.y + bz * n.z;
            outside |= a.min(b).simd_gt(splat(*offset));
        }
        if !outside.all_true() {
            out.append(!outside, block);
        }
    }

    /// Whether all receivers are certainly in front of planes, and whether all are behind them.
    #[inline(always)]
    fn faces<S: Simd>(&self, simd: S, [x, y, z, d]: [f32x8<S>; 4]) -> [mask32x8<S>; 2] {
        let middle = x * self.center.x + y * self.center.y + z * self.center.z + d;
        let spread = x.abs() * self.half.x + y.abs() * self.half.y + z.abs() * self.half.z;
        let unsure = d.abs() * (2.0 * UNSURE) + (2.0 * UNSURE * self.reach + 1.000_001 * self.radius);
        let (reach, zero) = (spread + unsure, f32x8::splat(simd, 0.0));
        [(middle - reach).simd_gt(zero), (middle + reach).simd_lt(zero)]
    }

    /// Appends the edges of a mesh that may be silhouettes inside of the hull. `base` is the number of its first edge.
    #[inline(always)]
    pub(crate) fn find<S: Simd>(
        &self,
        simd: S,
        mesh: &SilhouetteMesh,
        base: u32,
        stack: &mut Vec<u32>,
        out: &mut Columns<COLUMNS>,
    ) {
        let nodes = mesh.tree().nodes();
        stack.clear();
        stack.extend((!nodes.is_empty()).then_some(0));
        let mut block = [[0.0; 8]; COLUMNS];
        while let Some(number) = stack.pop() {
            let node = &nodes[number as usize];
            let mut met = self.meets(simd, node);
            while met != 0 {
                let k = met.trailing_zeros() as usize & 7;
                met &= met - 1;
                let count = usize::from(node.count[k]);
                if count == 0 {
                    stack.push(node.first[k]);
                    continue;
                }
                let count = mesh.fetch(node.first[k] as usize, count, base, &mut block);
                out.reserve(8);
                let all = core::array::from_fn(|c| f32x8::simd_from(simd, block[c]));
                self.sift(simd, &all, (1 << count) - 1, out);
            }
        }
    }

    /// Those of a list that may be silhouettes inside of the hull.
    #[inline(always)]
    pub(crate) fn narrow<S: Simd>(&self, simd: S, list: &Columns<COLUMNS>, out: &mut Columns<COLUMNS>) {
        out.clear();
        out.reserve(list.len());
        for first in (0..list.len()).step_by(8) {
            let all = core::array::from_fn(|c| list.load(simd, c, first));
            self.sift(simd, &all, list.lanes(first), out);
        }
    }
}


