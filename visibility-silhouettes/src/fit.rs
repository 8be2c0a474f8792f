//! Planes, simplified corners and patches, from the positions of a mesh.

use crate::mesh::Patch;
use crate::topology::normal;
use glam::{Vec3, Vec4};
use rayon::prelude::*;

pub(crate) fn corners(positions: &[Vec4], triangles: &[[u32; 3]], triangle: u32) -> [Vec3; 3] {
    triangles[triangle as usize].map(|i| positions[i as usize].truncate())
}

/// The least height of a triangle.
pub(crate) fn least_height([a, b, c]: [Vec3; 3]) -> f32 {
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    normal([a, b, c]).length() as f32 / longest.max(f32::MIN_POSITIVE)
}

/// The plane of a triangle: its unit normal `n` and `−n·a`, from f64.
pub(crate) fn plane(corners: [Vec3; 3]) -> [f32; 4] {
    let n = normal(corners).normalize_or_zero();
    let d = -n.dot(corners[0].as_dvec3());
    [n.x as f32, n.y as f32, n.z as f32, d as f32]
}

/// The fraction by which corners of simplified forms make up for the offsets of left-out corners: outlines then neither shrink nor
/// grow.
pub(crate) const SETTLE: f32 = 0.65;

pub(crate) fn fit_planes(
    planes: &mut [[f32; 4]],
    triangles: &[[u32; 3]],
    positions: &[Vec4],
    wanted: impl Fn(&[u32; 3]) -> bool + Sync,
) {
    let all = planes.par_iter_mut().with_min_len(1024).zip(triangles);
    all.filter(|(_, corners)| wanted(corners)).for_each(|(plane, corners)| {
        *plane = self::plane(corners.map(|i| positions[i as usize].truncate()));
    });
}

/// Moves the corners of simplified forms by the mean offset of the left-out corners from their planes; otherwise round shapes would
/// shrink.
pub(crate) fn settle(
    own: &[u32],
    left_out: &[[u32; 2]],
    triangles: &[[u32; 3]],
    planes: &[[f32; 4]],
    positions: &mut [Vec4],
) {
    let mut sums = vec![Vec4::ZERO; positions.len()];
    for [corner, near] in left_out {
        let plane = Vec4::from_array(planes[*near as usize]);
        let away = plane.dot(positions[*corner as usize].truncate().extend(1.0));
        for i in triangles[*near as usize] {
            sums[i as usize] += (plane.truncate() * away).extend(1.0);
        }
    }
    for i in own {
        let sum = sums[*i as usize];
        positions[*i as usize] += (sum.truncate() * (SETTLE / sum.w.max(1.0))).extend(0.0);
    }
}

/// Spheres around patches, and the root mean square of the distances of left-out corners from the planes next to them.
pub(crate) fn fit_patches(
    patches: &mut [Patch],
    triangle_patches: &[u16],
    left_out: &[[u32; 2]],
    triangles: &[[u32; 3]],
    positions: &[Vec4],
    planes: &[[f32; 4]],
) {
    let mut bounds = vec![[Vec3::INFINITY, Vec3::NEG_INFINITY]; patches.len()];
    for (corners, patch) in triangles.iter().zip(triangle_patches) {
        if let Some([low, high]) = bounds.get_mut(usize::from(*patch)) {
            for p in corners.map(|i| positions[i as usize].truncate()) {
                (*low, *high) = (low.min(p), high.max(p));
            }
        }
    }
    let mut sums = vec![(0.0_f64, 0_u32); patches.len()];
    for [corner, near] in left_out {
        let p = positions[*corner as usize];
        let away = f64::from(p.truncate().extend(1.0).dot(Vec4::from_array(planes[*near as usize])));
        let (sum, count) = &mut sums[usize::from(triangle_patches[*near as usize])];
        *sum += away * away;
        *count += 1;
    }
    for ((patch, [low, high]), (sum, count)) in patches.iter_mut().zip(bounds).zip(sums) {
        let detail = (sum / f64::from(count.max(1))).sqrt() as f32;
        *patch = Patch { center: 0.5 * (low + high), radius: 0.5 * low.distance(high), detail };
    }
}

/// 1 if a point is in front of a triangle's plane, −1 behind it, 0 in it.
pub(crate) fn side(corners: [Vec3; 3], x: Vec3) -> f32 {
    let along = normal(corners).dot(x.as_dvec3() - corners[0].as_dvec3());
    if along > 0.0 {
        1.0
    } else if along < 0.0 {
        -1.0
    } else {
        0.0
    }
}

/// Whether two triangles lie in one plane and face the same way, so that no point is between their planes.
pub(crate) fn is_flat(one: [Vec3; 3], other: [Vec3; 3]) -> bool {
    let [m, n] = [normal(one), normal(other)];
    m.dot(n) > 0.0 && m.cross(n) == glam::DVec3::ZERO && other.iter().all(|p| side(one, *p) == 0.0)
}
