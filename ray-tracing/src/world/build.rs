//! New hierarchies: the steps of obvhs's own builders, which read a clock that not every target has.

use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::ploc::PlocBuilder;
use obvhs::{Boundable, BvhBuildParams};

/// From this number of primitives on obvhs's builder is tried on a number of them that are near each other, in a number of places: whether their tree is not
/// much deeper than it must be. It looks for the nearest of all boxes: where most boxes have the same nearest one, as in a fan around a
/// corner, each pass over all of them joins a few.
const MANY: usize = 8192;
const TRIED: usize = 1024;
const PLACES: usize = 8;
/// Ten levels are enough for them.
const DEEP: usize = 64;

/// A hierarchy over primitives, of which there is one at least.
pub(crate) fn build<T: Boundable>(primitives: &[T]) -> CwBvh {
    let most = BvhBuildParams::medium_build().max_prims_per_leaf.clamp(1, 3);
    bvh2_to_cwbvh(&binary_hierarchy(primitives), most, true, false)
}

/// A hierarchy of two children a node over primitives, of which there is one at least.
#[doc(hidden)]
#[must_use]
pub fn binary_hierarchy<T: Boundable>(primitives: &[T]) -> Bvh2 {
    if is_crowded(primitives) {
        return halved(primitives);
    }
    let mut binary = joined(primitives);
    ReinsertionOptimizer::default().run(&mut binary, BvhBuildParams::medium_build().reinsertion_batch_ratio, None);
    binary
}

/// From the leaves up.
fn joined<T: Boundable>(primitives: &[T]) -> Bvh2 {
    let of = BvhBuildParams::medium_build();
    let numbers = (0..primitives.len() as u32).collect();
    PlocBuilder::with_capacity(primitives.len()).build(
        of.ploc_search_distance,
        primitives,
        numbers,
        of.sort_precision,
        of.search_depth_threshold,
    )
}

/// Whether the tree over those near each other is deep in some place.
fn is_crowded<T: Boundable>(primitives: &[T]) -> bool {
    if primitives.len() < MANY {
        return false;
    }
    let boxes: Vec<Aabb> = primitives.iter().map(Boundable::aabb).collect();
    let mut parts = vec![(0..primitives.len() as u32).collect::<Vec<u32>>()];
    while parts.len() < PLACES {
        parts = parts.into_iter().flat_map(|part| parted(&boxes, part)).collect();
    }
    parts.into_iter().enumerate().any(|(place, mut part)| {
        while part.len() > TRIED {
            // Another half in each place.
            let [one, other] = parted(&boxes, part);
            part = if (place + other.len()) % 2 == 0 { one } else { other };
        }
        let near: Vec<Aabb> = part.iter().map(|i| boxes[*i as usize]).collect();
        joined(&near).depth(0) > DEEP
    })
}

/// Two halves of equal numbers on both sides of a plane.
fn parted(boxes: &[Aabb], mut part: Vec<u32>) -> [Vec<u32>; 2] {
    let rest = halve(|i| boxes[i as usize].center(), &mut part);
    let rest = part.split_off(rest);
    [part, rest]
}

/// Puts those with the smaller middles, along the longest side of the box around all middles, into the first half.
fn halve(middle: impl Fn(u32) -> Vec3A, part: &mut [u32]) -> usize {
    let around = part.iter().fold(Aabb::empty(), |all, i| {
        let p = middle(*i);
        all.union(&Aabb::new(p, p))
    });
    let (axis, half) = (around.diagonal().max_position(), part.len() / 2);
    let along = |i: &u32| middle(*i)[axis];
    part.select_nth_unstable_by(half, |a, b| along(a).total_cmp(&along(b)).then(a.cmp(b)));
    half
}

/// By their middles, in halves of equal numbers.
fn halved<T: Boundable>(primitives: &[T]) -> Bvh2 {
    let middles: Vec<Vec3A> = primitives.iter().map(|p| p.aabb().center()).collect();
    let mut order: Vec<u32> = (0..primitives.len() as u32).collect();
    let mut tree = Bvh2::zeroed(primitives.len());
    tree.children_are_ordered_after_parents = true;
    let (mut open, mut next) = (vec![(0, 0..primitives.len())], 1);
    while let Some((node, range)) = open.pop() {
        let part = &mut order[range.clone()];
        if let [only] = part {
            tree.nodes[node] = Bvh2Node::new(primitives[*only as usize].aabb(), 1, range.start as u32);
            continue;
        }
        let half = halve(|i| middles[i as usize], part);
        tree.nodes[node].make_inner(next as u32);
        open.extend([(next, range.start..range.start + half), (next + 1, range.start + half..range.end)]);
        next += 2;
    }
    tree.primitive_indices = order;
    tree.refit_all();
    tree
}

#[cfg(test)]
mod tests {
    use super::build;
    use core::time::Duration;
    use glam::Vec3A;
    use lobe_core::oracle::Random;
    use obvhs::BvhBuildParams;
    use obvhs::aabb::Aabb;
    use obvhs::cwbvh::builder::build_cwbvh;
    use std::time::Instant;

    /// The same nodes as obvhs's own builder makes.
    #[test]
    fn hierarchies_are_those_of_the_library() {
        let mut random = Random::new(5);
        for count in [1, 2, 3, 50, 3000] {
            let mut at = || Vec3A::from_array(core::array::from_fn(|_| random.between(-9.0, 9.0) as f32));
            let boxes: Vec<Aabb> = (0..count).map(|_| at()).map(|p| Aabb::new(p, p + 0.5)).collect();
            let (ours, mut time) = (build(&boxes), Duration::ZERO);
            let theirs = build_cwbvh(&boxes, BvhBuildParams::medium_build(), &mut time);
            assert!(ours.nodes == theirs.nodes && ours.primitive_indices == theirs.primitive_indices, "{count}");
        }
    }

    /// Boxes that begin in one point, of which each pass of obvhs's own builder would join two: on a floor, and a small part of a scene.
    #[test]
    fn a_fan_is_built_at_once() {
        let fan = (0..100_000).map(|i| Aabb::new(Vec3A::ZERO, Vec3A::new(1.0, 1e-5 * i as f32, 1e-3)));
        let floor = Aabb::new(Vec3A::splat(-60.0), Vec3A::new(60.0, -60.0, 60.0));
        let far = [-1e3, 1e3].map(|x| Aabb::new(Vec3A::splat(x), Vec3A::splat(x + 1.0)));
        for others in [&[floor][..], &far] {
            let boxes: Vec<Aabb> = fan.clone().chain(others.iter().copied()).collect();
            let before = Instant::now();
            let built = build(&boxes);
            assert_eq!(built.primitive_indices.len(), boxes.len());
            assert!(before.elapsed() < Duration::from_mins(1));
        }
    }
}
