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

/// From this number of primitives on, boxes that each fill this part of all space in the mean are crowded: none is nearer to one than to the others, so
/// that each pass over all of them joins a few, and none has a better place elsewhere.
const MANY: usize = 8192;
const CROWDED: f32 = 1.0 / 32.0;

/// A hierarchy over primitives, of which there is one at least.
pub(crate) fn build<T: Boundable>(primitives: &[T]) -> CwBvh {
    let of = BvhBuildParams::medium_build();
    let binary = if is_crowded(primitives) {
        halved(primitives)
    } else {
        let numbers = (0..primitives.len() as u32).collect();
        let mut binary = PlocBuilder::with_capacity(primitives.len()).build(
            of.ploc_search_distance,
            primitives,
            numbers,
            of.sort_precision,
            of.search_depth_threshold,
        );
        ReinsertionOptimizer::default().run(&mut binary, of.reinsertion_batch_ratio, None);
        binary
    };
    bvh2_to_cwbvh(&binary, of.max_prims_per_leaf.clamp(1, 3), true, false)
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
        let around = part.iter().fold(Aabb::empty(), |all, i| {
            let p = middles[*i as usize];
            all.union(&Aabb::new(p, p))
        });
        let (axis, half) = (around.diagonal().max_position(), part.len() / 2);
        let along = |i: &u32| middles[*i as usize][axis];
        part.select_nth_unstable_by(half, |a, b| along(a).total_cmp(&along(b)).then(a.cmp(b)));
        tree.nodes[node].make_inner(next as u32);
        open.extend([(next, range.start..range.start + half), (next + 1, range.start + half..range.end)]);
        next += 2;
    }
    tree.primitive_indices = order;
    tree.refit_all();
    tree
}

/// Without those that are far larger than most: a floor.
fn is_crowded<T: Boundable>(primitives: &[T]) -> bool {
    if primitives.len() < MANY {
        return false;
    }
    let areas = || primitives.iter().map(|p| p.aabb().half_area());
    let most = 16.0 * areas().map(f64::from).sum::<f64>() / primitives.len() as f64;
    let (mut all, mut sum, mut count) = (Aabb::empty(), 0.0, 0.0);
    for bounds in primitives.iter().map(Boundable::aabb).filter(|bounds| f64::from(bounds.half_area()) <= most) {
        all = all.union(&bounds);
        (sum, count) = (sum + f64::from(bounds.half_area()), count + 1.0);
    }
    sum > f64::from(CROWDED * all.half_area()) * count
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

    /// Boxes that begin in one point, of which each pass of obvhs's own builder would join two, on a floor.
    #[test]
    fn a_fan_is_built_at_once() {
        let mut boxes: Vec<Aabb> =
            (0..100_000).map(|i| Aabb::new(Vec3A::ZERO, Vec3A::new(1.0, 1e-5 * i as f32, 1e-3))).collect();
        boxes.push(Aabb::new(Vec3A::splat(-60.0), Vec3A::new(60.0, -60.0, 60.0)));
        let before = Instant::now();
        assert_eq!(build(&boxes).primitive_indices.len(), boxes.len());
        assert!(before.elapsed() < Duration::from_mins(1));
    }
}
