//! New hierarchies: the steps of obvhs's own builders, which read a clock that not every target has.

use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
use obvhs::ploc::PlocBuilder;
use obvhs::{Boundable, BvhBuildParams};

/// A hierarchy over primitives, of which there is one at least.
pub(crate) fn build<T: Boundable>(primitives: &[T]) -> CwBvh {
    let of = BvhBuildParams::medium_build();
    let numbers = (0..primitives.len() as u32).collect();
    let mut binary = PlocBuilder::with_capacity(primitives.len()).build(
        of.ploc_search_distance,
        primitives,
        numbers,
        of.sort_precision,
        of.search_depth_threshold,
    );
    ReinsertionOptimizer::default().run(&mut binary, of.reinsertion_batch_ratio, None);
    bvh2_to_cwbvh(&binary, of.max_prims_per_leaf.clamp(1, 3), true, false)
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
}
