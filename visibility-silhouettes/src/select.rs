//! The silhouettes of one receiver in front of its light.

use crate::beside::Beside;
use crate::edge_list::{COARSE, Columns, ENDS, EdgeList, EdgePacket, ID, MARKS, PLANES, SOMETIMES};
use crate::hull::{UNSURE, vectors};
use fearless_simd::{Simd, f32x8, mask32x8, prelude::*, u32x8};
use glam::Vec3;
use lobe_core::vec3x8::Vec3x8;
use lobe_core::{Cone, orthonormal_basis};
use visibility_mask::Edges;

/// Number of columns of a silhouette: its two ends, relative to the receiver, and the growth of the number of surfaces to its
/// right, looking from the first end to the second.
pub(crate) const NUMBERS: usize = 7;
pub(crate) const STEP: usize = 6;

pub(crate) type Silhouettes = Columns<NUMBERS>;

/// A margin around the light's disc, for the rounding of its edge.
pub(crate) const AROUND: f32 = 1.000_01;
pub(crate) const AROUND_SQ: f32 = 1.000_2;

/// Lists those edges of a list that are silhouettes and may lie in front of the light.
///
/// An edge is a silhouette if the receiver is in front of one of its triangles and behind the other, or if there is no other.
/// `sides` decides for an edge by its number if f32 cannot; `is_drawn` decides for an edge that is not always drawn. Returns
/// whether any may belong to a simplified form.
#[inline(always)]
pub(crate) fn silhouettes<S: Simd>(
    simd: S,
    x: Vec3,
    (cone, outline): (&Cone, Option<&Beside>),
    edges: &EdgeList,
    (sides, is_drawn): (impl Fn(u32) -> [f32; 2], impl Fn(u32) -> bool),
    out: &mut Silhouettes,
) -> bool {
    out.clear();
    let mut is_coarse = false;
    out.reserve(edges.len());
    let zero = f32x8::splat(simd, 0.0);
    let tan = AROUND * cone.tan();
    let (u, v) = orthonormal_basis(cone.axis);
    // Inward normals of a square around the disc.
    let window = [u + cone.axis * tan, cone.axis * tan - u, v + cone.axis * tan, cone.axis * tan - v];
    // Wide lights have no such square, flat ones have something better.
    let window = if cone.one_minus_cos < 0.9 && outline.is_none() { &window[..] } else { &[] };
    for first in (0..edges.len()).step_by(8) {
        let [a, b] = [edges.load3(simd, ENDS[0], first).minus(x), edges.load3(simd, ENDS[1], first).minus(x)];
        let mut keep = mask32x8::from_bitmask(simd, u64::from(edges.lanes(first)));
        for n in window {
            keep &= a.dot_one(*n).max(b.dot_one(*n)).simd_ge(zero);
        }
        if let Some(outline) = outline {
            keep &= !outline.misses_edges(simd, a, b);
        }
        if !keep.any_true() {
            continue;
        }
        let number = |lane: usize| edges.get(ID, first + lane).to_bits() & !MARKS;
        let step = steps(simd, &(edges, first), keep, x, |lane| sides(number(lane)));
        keep &= !step.simd_eq(zero);
        if keep.any_true() && !window.is_empty() {
            keep &= !beside(simd, cone, a, b);
        }
        if !keep.any_true() {
            continue;
        }
        let marks = edges.load(simd, ID, first).bitcast::<u32x8<S>>();
        let marked = keep & marks.simd_ge(u32x8::splat(simd, COARSE));
        let sometimes = marks.simd_ge(u32x8::splat(simd, SOMETIMES));
        keep = drawn(simd, keep, marked & sometimes, |lane| is_drawn(number(lane)));
        is_coarse |= marked.any_true();
        out.put3(0, keep, a);
        out.put3(3, keep, b);
        out.put(STEP, keep, step);
        out.end(keep);
    }
    is_coarse
}

/// Which of eight edges certainly pass beside the disc of a light, with their parts between the receiver and the light's plane.
///
/// Such an edge changes the number of surfaces of all samples alike, or of none: in all rows that both meet it is on one side of
/// the disc.
#[inline(always)]
fn beside<S: Simd>(simd: S, cone: &Cone, a: Vec3x8<S>, b: Vec3x8<S>) -> mask32x8<S> {
    let (axis, cos) = (cone.axis, cone.cos());
    let edge = b - a;
    // The plane through the edge and the receiver misses the disc: |n·axis| > |n| sin θ.
    let normal = a.cross(edge);
    let [size, reach] = [normal.dot(normal), a.dot(a) * edge.dot(edge)];
    let along = normal.dot_one(axis).abs() - reach.sqrt() * 1e-6;
    let mut beside = along.simd_gt((size * (cone.sin_sq() * AROUND_SQ)).sqrt());
    // Parts behind the light's plane do not count.
    let (mut from, mut to) = (a, b);
    let [mut depth_a, mut depth_b] = [a.dot_one(axis), b.dot_one(axis)];
    let far = f32x8::splat(simd, cone.distance * cos * cos);
    let [far_a, far_b] = [depth_a.simd_gt(far), depth_b.simd_gt(far)];
    if (far_a | far_b).any_true() {
        beside |= far_a & far_b;
        let t = (far - depth_a) / (depth_b - depth_a);
        let cut = Vec3x8::new(a.x + edge.x * t, a.y + edge.y * t, a.z + edge.z * t);
        (from, to) = (from.or(far_a, cut), to.or(far_b, cut));
        (depth_a, depth_b) = (far_a.select(far, depth_a), far_b.select(far, depth_b));
    }
    // Or the edge ends before it reaches the disc: both ends are on one side of the point of the edge that is nearest to the axis,
    // seen from the receiver, and outside the cone. An end behind the receiver is on the far side of the other one.
    let zero = f32x8::splat(simd, 0.0);
    let [front_a, front_b] = [depth_a.simd_gt(zero), depth_b.simd_gt(zero)];
    // The sign of d/dt of the squared cosine at an end tells whether the edge comes nearer from there on.
    let across = edge.dot_one(axis);
    let at_a = across * from.dot(from) - depth_a * from.dot(edge);
    let at_b = across * to.dot(to) - depth_b * to.dot(edge);
    let leaves = at_a.simd_lt(zero) & (at_b.simd_lt(zero) | !front_b);
    let comes = at_b.simd_gt(zero) & (at_a.simd_gt(zero) | !front_a);
    let limit = cos * cos * (2.0 - AROUND_SQ);
    let outside_a = (depth_a * depth_a).simd_lt(from.dot(from) * limit) | !front_a;
    let outside_b = (depth_b * depth_b).simd_lt(to.dot(to) * limit) | !front_b;
    beside | !(front_a | front_b) | ((leaves | comes) & outside_a & outside_b)
}

/// The side of its first triangle on which a point lies, less that of its second one, for each of eight edges. `exact` has both
/// sides of those of `lanes` that f32 cannot decide.
#[inline(always)]
pub(crate) fn steps<S: Simd>(
    simd: S,
    edges: &impl EdgePacket,
    lanes: mask32x8<S>,
    x: Vec3,
    exact: impl Fn(usize) -> [f32; 2],
) -> f32x8<S> {
    let reach = UNSURE * x.abs().element_sum();
    let (one, unsure_one) = side(simd, edges, PLANES[0], x, reach);
    let (other, unsure_other) = side(simd, edges, PLANES[1], x, reach);
    let step = one - other;
    let mut unsure = ((unsure_one | unsure_other) & lanes).to_bitmask();
    if unsure == 0 {
        return step;
    }
    let mut steps: [f32; 8] = step.into();
    while unsure != 0 {
        let lane = unsure.trailing_zeros() as usize & 7;
        unsure &= unsure - 1;
        let [one, other] = exact(lane);
        steps[lane] = one - other;
    }
    f32x8::simd_from(simd, steps)
}

/// Leaves out those of eight edges that are `sometimes` drawn and not for this receiver.
#[inline(always)]
pub(crate) fn drawn<S: Simd>(
    simd: S,
    keep: mask32x8<S>,
    sometimes: mask32x8<S>,
    is_drawn: impl Fn(usize) -> bool,
) -> mask32x8<S> {
    let mut open = (keep & sometimes).to_bitmask();
    if open == 0 {
        return keep;
    }
    let mut drawn = keep.to_bitmask();
    while open != 0 {
        let lane = open.trailing_zeros() as usize & 7;
        open &= open - 1;
        if !is_drawn(lane) {
            drawn &= !(1 << lane);
        }
    }
    mask32x8::from_bitmask(simd, drawn)
}

/// The sides of eight planes on which a point lies, and a mask of those that f32 cannot decide.
#[inline(always)]
fn side<S: Simd>(simd: S, edges: &impl EdgePacket, column: usize, x: Vec3, reach: f32) -> (f32x8<S>, mask32x8<S>) {
    let (normal, d) = (vectors(simd, edges, column), edges.column(simd, column + 3));
    let value = normal.dot_one(x) + d;
    let [zero, plus, minus] = [f32x8::splat(simd, 0.0), f32x8::splat(simd, 1.0), f32x8::splat(simd, -1.0)];
    let is_there = normal.abs().dot_one(Vec3::ONE).simd_gt(zero);
    let unsure = is_there & value.abs().simd_le(d.abs() * UNSURE + reach);
    (value.simd_gt(zero).select(plus, value.simd_lt(zero).select(minus, zero)), unsure)
}

/// Depths below this fraction of an edge's size are rounding errors.
pub(crate) const BESIDE: f32 = 1e-5;

/// Adds the parts of silhouettes in front of a part of a light to the directions that a mask is turned by. Only silhouettes in
/// front of the light count, since the list has only some of the others.
#[inline(always)]
pub(crate) fn add_edges<S: Simd>(simd: S, part: &Cone, light: &Cone, silhouettes: &Silhouettes, edges: &mut Edges) {
    let far = light.distance * light.cos() * light.cos();
    add_lines(simd, part, light, (silhouettes, 0, far), edges);
}

/// The same of the outlines from a number on in which a light cuts surfaces: all are known.
#[inline(always)]
pub(crate) fn add_arcs<S: Simd>(
    simd: S,
    part: &Cone,
    light: &Cone,
    (outlines, first): (&Silhouettes, usize),
    edges: &mut Edges,
) {
    add_lines(simd, part, light, (outlines, first, f32::INFINITY), edges);
}

#[inline(always)]
fn add_lines<S: Simd>(
    simd: S,
    part: &Cone,
    light: &Cone,
    (outlines, first, far): (&Silhouettes, usize, f32),
    edges: &mut Edges,
) {
    let is_finite = light.distance.is_finite();
    let nearest = 1e-6 * light.distance.min(1.0);
    let [nearest, far] = [nearest, far].map(|depth| f32x8::splat(simd, depth));
    for first in (first..outlines.len()).step_by(8) {
        let [a, b] = [outlines.load3(simd, 0, first), outlines.load3(simd, 3, first)];
        // An edge that passes beside the receiver, far outside the disc of a light at infinity, has a depth of nothing but
        // rounding.
        let near = if is_finite { nearest } else { (a.dot(a) + b.dot(b)).sqrt() * BESIDE };
        // Behind the light or the receiver only some edges are listed, so none counts.
        let [depth_a, depth_b] = [a.dot_one(light.axis), b.dot_one(light.axis)];
        let edge = b - a;
        let mut is_there = mask32x8::from_bitmask(simd, u64::from(outlines.lanes(first)));
        let (mut from, mut to) = (a, b);
        for (limit, out_a, out_b) in
            [(near, depth_a.simd_lt(near), depth_b.simd_lt(near)), (far, depth_a.simd_gt(far), depth_b.simd_gt(far))]
        {
            let t = (limit - depth_a) / (depth_b - depth_a);
            let cut = Vec3x8::new(a.x + t * edge.x, a.y + t * edge.y, a.z + t * edge.z);
            (from, to) = (from.or(out_a, cut), to.or(out_b, cut));
            is_there &= !(out_a & out_b);
        }
        let (a, b) = (from, to);
        // Across the edge: the normal of the plane through it and the receiver.
        let normal = a.cross(b - a);
        let mut length = length_before(simd, part, a, b, normal);
        if part != light {
            let zero = f32x8::splat(simd, 0.0);
            length = length_before(simd, light, a, b, normal).simd_gt(zero).select(length, zero);
        }
        let length = is_there.select(length, f32x8::splat(simd, 0.0));
        edges.add_lines(simd, [normal.x, normal.y, normal.z], length);
    }
}

/// The length of eight edges in front of the disc of a light, in its radii; not above zero if no part is.
#[inline(always)]
fn length_before<S: Simd>(simd: S, cone: &Cone, a: Vec3x8<S>, b: Vec3x8<S>, normal: Vec3x8<S>) -> f32x8<S> {
    let (tan, axis) = (cone.tan(), cone.axis);
    let along = normal.dot_one(axis);
    let across = normal - Vec3x8::new(along * axis.x, along * axis.y, along * axis.z);
    let square = across.dot(across);
    // The line passes the disc's centre at |n·axis|/|n − axis(n·axis)|; from it half the chord follows.
    let half_sq = f32x8::splat(simd, 1.0) - along * along / (square * (tan * tan));
    let half = half_sq.max(f32x8::splat(simd, 0.0)).sqrt();
    // Where the two ends are along it.
    let line = normal.turned_about(axis);
    let scale = (square.sqrt() * tan).max(f32x8::splat(simd, f32::MIN_POSITIVE));
    let (from, to) = (place(a, axis, line, scale), place(b, axis, line, scale));
    from.max(to).min(half) - from.min(to).max(-half)
}

/// Where points, in front of the receiver, are along lines on the square.
#[inline(always)]
fn place<S: Simd>(point: Vec3x8<S>, axis: Vec3, line: Vec3x8<S>, scale: f32x8<S>) -> f32x8<S> {
    point.dot(line) / (scale * point.dot_one(axis))
}
