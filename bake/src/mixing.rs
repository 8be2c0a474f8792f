//! The points of one texel: which of them count.

use glam::Vec3;
use lobe_core::Receiver;
use ray_tracing::World;
use renderer::Renderer;

/// From this difference on, as a part of the largest value, the points of a texel may be on two sides of a wall.
const APART: f32 = 0.05;

/// Texels of more points have many small triangles, each beside the next.
const MOST: usize = 24;

/// A point of a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spot {
    pub(crate) at: Receiver,
    pub(crate) weight: f64,
    /// Whether it is on the back of a surface, which is the inside of bodies.
    pub(crate) is_back: bool,
}

/// The point is inside of a body: rays along the normal and at 60° to it on four sides all meet backs of surfaces.
fn is_buried(world: &World<'_>, at: &Receiver) -> bool {
    let from = world.leave(at.position, at.face);
    let (x, y) = at.face.any_orthonormal_pair();
    let tilted = [x, -x, y, -y].map(|side| (0.5 * at.face + 0.866_025_4 * side).normalize());
    core::iter::once(at.face).chain(tilted).all(|direction| world.meets_back(from, direction) == Some(true))
}

/// Whether nothing stands between two points of a surface: on a line as high above it as they are apart, which clears the surface's own
/// edges and curvature.
fn see_each_other(world: &World<'_>, a: &Receiver, b: &Receiver) -> bool {
    let apart = a.position.distance(b.position);
    let [from, to] = [a, b].map(|at| at.position + at.face * apart);
    let length = from.distance(to);
    length == 0.0 || !world.occluded(from, (to - from) / length, length)
}

/// The weights of a texel's points after those are taken out that do not belong to it; `None` if none is left.
///
/// Points inside of bodies, as under the feet of furniture, would make dark rims. Of points on two sides of a wall those count that
/// cover more, so that no light leaks through it.
fn kept(world: &World<'_>, points: &[Spot], irradiance: &[Vec3]) -> Option<Vec<f64>> {
    let mut weights: Vec<f64> = points.iter().map(|point| point.weight).collect();
    for (point, (weight, value)) in points.iter().zip(weights.iter_mut().zip(irradiance)) {
        if *value == Vec3::ZERO && !point.is_back && is_buried(world, &point.at) {
            *weight = 0.0;
        }
    }
    let left: Vec<usize> = (0..points.len()).filter(|k| weights[*k] > 0.0).collect();
    let ends = |f: fn(f32, f32) -> f32, start| left.iter().map(|k| irradiance[*k].element_sum()).fold(start, f);
    let (low, high) = (ends(f32::min, f32::INFINITY), ends(f32::max, 0.0));
    if left.is_empty() {
        return None;
    }
    if left.len() > MOST || high - low <= APART * high {
        return Some(weights);
    }
    // Each point's group, by its first point.
    let mut group: Vec<usize> = (0..points.len()).collect();
    for (n, &i) in left.iter().enumerate() {
        for &j in &left[..n] {
            if group[i] != group[j] && see_each_other(world, &points[i].at, &points[j].at) {
                let (old, new) = (group[i].max(group[j]), group[i].min(group[j]));
                group.iter_mut().filter(|g| **g == old).for_each(|g| *g = new);
            }
        }
    }
    let size = |g: usize| left.iter().filter(|k| group[**k] == g).map(|k| weights[*k]).sum::<f64>();
    let largest = left.iter().map(|k| group[*k]).fold(None, |best: Option<(usize, f64)>, g| match best {
        Some((_, most)) if most >= size(g) => best,
        _ => Some((g, size(g))),
    })?;
    (0..points.len()).filter(|k| group[*k] != largest.0).for_each(|k| weights[k] = 0.0);
    Some(weights)
}

/// The weights of the points of each texel; `None` for texels none of whose points count. `ends` are where the points of each end.
pub(crate) fn weights(
    renderer: &mut Renderer,
    points: &[Spot],
    irradiance: &[Vec3],
    ends: &[usize],
) -> Vec<Option<Vec<f64>>> {
    renderer.with_world(|world| {
        let mut first = 0;
        let each = ends.iter().map(|&end| {
            let range = core::mem::replace(&mut first, end)..end;
            kept(world, &points[range.clone()], &irradiance[range])
        });
        each.collect()
    })
}
