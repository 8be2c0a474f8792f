//! The silhouettes that one receiver sees before its light.

use crate::edge_list::{Columns, ENDS, EdgeList, ID, PLANES};
use crate::hull::UNSURE;
use fearless_simd::{Simd, f32x8, mask32x8, prelude::*};
use glam::Vec3;
use lighting::Edges;
use lobe_core::{Cone, orthonormal_basis};

/// Numbers of a silhouette: its two ends seen from the receiver, and by how much the number of surfaces grows to its right,
/// looking from the first end to the second.
pub(crate) const NUMBERS: usize = 7;
pub(crate) const STEP: usize = 6;

pub(crate) type Silhouettes = Columns<NUMBERS>;

/// Beside the light's disc: a little more, for the rounding of its edge.
const AROUND: f32 = 1.000_01;

/// Lists the silhouettes among some edges that may lie before the light.
///
/// An edge is one where the receiver is in front of one of its triangles and behind the other, or where there is no other.
/// `sides` decides for an edge by its number what f32 cannot.
#[inline(always)]
pub(crate) fn silhouettes<S: Simd>(
    simd: S,
    x: Vec3,
    cone: &Cone,
    edges: &EdgeList,
    sides: impl Fn(u32) -> [f32; 2],
    out: &mut Silhouettes,
) {
    out.clear();
    out.reserve(edges.len());
    let splat = |x: f32| f32x8::splat(simd, x);
    let zero = splat(0.0);
    let tan = AROUND * cone.tan();
    let (u, v) = orthonormal_basis(cone.axis);
    // Inward normals of a square around the disc.
    let window = [u + cone.axis * tan, cone.axis * tan - u, v + cone.axis * tan, cone.axis * tan - v];
    // Wide lights have no such square.
    let window = if cone.one_minus_cos < 0.9 { &window[..] } else { &[] };
    let reach = UNSURE * x.abs().element_sum();
    for first in (0..edges.len()).step_by(8) {
        let at = |c: usize| edges.load(simd, c, first);
        let ends = ENDS.map(|e| [at(e) - x.x, at(e + 1) - x.y, at(e + 2) - x.z]);
        let [[ax, ay, az], [bx, by, bz]] = ends;
        let mut keep = mask32x8::from_bitmask(simd, u64::from(edges.lanes(first)));
        for n in window {
            let a = ax * n.x + ay * n.y + az * n.z;
            let b = bx * n.x + by * n.y + bz * n.z;
            keep &= a.max(b).simd_ge(zero);
        }
        if !keep.any_true() {
            continue;
        }
        let mut unsure = mask32x8::splat(simd, false);
        let [one, other] = PLANES.map(|p| {
            let [nx, ny, nz, d] = [at(p), at(p + 1), at(p + 2), at(p + 3)];
            let value = nx * x.x + ny * x.y + nz * x.z + d;
            let is_there = (nx.abs() + ny.abs() + nz.abs()).simd_gt(zero);
            unsure |= is_there & value.abs().simd_le(d.abs() * UNSURE + reach);
            let (plus, minus) = (splat(1.0), splat(-1.0));
            value.simd_gt(zero).select(plus, value.simd_lt(zero).select(minus, zero))
        });
        let mut step = one - other;
        let mut ask = (unsure & keep).to_bitmask();
        if ask != 0 {
            let mut steps: [f32; 8] = step.into();
            while ask != 0 {
                let lane = ask.trailing_zeros() as usize & 7;
                ask &= ask - 1;
                let [one, other] = sides(edges.get(ID, first + lane).to_bits());
                steps[lane] = one - other;
            }
            step = f32x8::simd_from(simd, steps);
        }
        keep &= !step.simd_eq(zero);
        if keep.any_true() {
            out.append(keep, &[ax, ay, az, bx, by, bz, step]);
        }
    }
}

/// Adds the parts of silhouettes that lie before a light to the directions that a mask is turned by.
#[inline(always)]
pub(crate) fn add_edges<S: Simd>(simd: S, cone: &Cone, silhouettes: &Silhouettes, edges: &mut Edges) {
    let tan = cone.tan();
    let zero = f32x8::splat(simd, 0.0);
    let axis = cone.axis;
    for first in (0..silhouettes.len()).step_by(8) {
        let at = |c: usize| silhouettes.load(simd, c, first);
        let [ax, ay, az] = [at(0), at(1), at(2)];
        let [ex, ey, ez] = [at(3) - ax, at(4) - ay, at(5) - az];
        // The plane through the receiver: its normal n is across the edge, and the line passes the disc's middle at
        // |n·axis|/|n − axis(n·axis)|.
        let [nx, ny, nz] = [ay * ez - az * ey, az * ex - ax * ez, ax * ey - ay * ex];
        let along = nx * axis.x + ny * axis.y + nz * axis.z;
        let [px, py, pz] = [nx - along * axis.x, ny - along * axis.y, nz - along * axis.z];
        let square = px * px + py * py + pz * pz;
        let off_sq = along * along / (square * (tan * tan));
        // Half the chord, in radii of the disc.
        let half = (f32x8::splat(simd, 1.0) - off_sq).max(zero).sqrt();
        // Direction of the line in the plane: axis × n. Where the two ends are along it, in radii.
        let [lx, ly, lz] = [axis.y * nz - axis.z * ny, axis.z * nx - axis.x * nz, axis.x * ny - axis.y * nx];
        let scale = (square.sqrt() * tan).max(f32x8::splat(simd, f32::MIN_POSITIVE));
        let place = |x: f32x8<S>, y: f32x8<S>, z: f32x8<S>| {
            let depth = x * axis.x + y * axis.y + z * axis.z;
            let place = (x * lx + y * ly + z * lz) / (scale * depth);
            // Behind the receiver: somewhere beyond the disc.
            depth.simd_gt(zero).select(place, f32x8::splat(simd, f32::INFINITY))
        };
        let (from, to) = (place(ax, ay, az), place(at(3), at(4), at(5)));
        let (from, to) = (from.min(to).max(-half), from.max(to).min(half));
        let length: [f32; 8] = (to - from).into();
        let across: [[f32; 8]; 3] = [px.into(), py.into(), pz.into()];
        for lane in 0..(silhouettes.len() - first).min(8) {
            if length[lane] > 0.0 {
                edges.add(Vec3::new(across[0][lane], across[1][lane], across[2][lane]), length[lane]);
            }
        }
    }
}
