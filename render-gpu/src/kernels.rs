//! The texts of the kernels, and their counters.

pub(crate) mod queue;

use scene::Counts;

pub(crate) const FRAME: &str = include_str!("kernels/frame.wgsl");
pub(crate) const QUEUE: &str = include_str!("kernels/queue.wgsl");
pub(crate) const INTEGRALS: &str = include_str!("kernels/integrals.wgsl");
pub(crate) const INTEGRALS_BY_CHANNEL: &str = include_str!("kernels/integrals_by_channel.wgsl");
pub(crate) const POINTS: &str = include_str!("kernels/points.wgsl");
pub(crate) const TILES: &str = include_str!("kernels/tiles.wgsl");
pub(crate) const CLASSIFY: &str = include_str!("kernels/classify.wgsl");
pub(crate) const PENUMBRA: &str = include_str!("kernels/penumbra.wgsl");
pub(crate) const PAPER_CLASSIFY: &str = include_str!("kernels/paper_classify.wgsl");
pub(crate) const PAPER_PENUMBRA: &str = include_str!("kernels/paper_penumbra.wgsl");
pub(crate) const ARGS: &str = include_str!("kernels/args.wgsl");

/// A counter in the head of the queue.
pub(crate) fn count(header: &[u32], which: usize) -> u32 {
    header.get(1 + which).copied().unwrap_or(0)
}

/// The kernels' counts, from the head of the queue.
pub(crate) fn counts(header: &[u32]) -> Counts {
    let count = |which| count(header, which).into();
    Counts {
        lobes: 0,
        integrals: count(queue::INTEGRALS),
        pruned: count(queue::PRUNED),
        lit_points: count(queue::LIT_POINTS),
        dark_points: count(queue::DARK_POINTS),
        penumbra_points: count(queue::PENUMBRA_POINTS),
    }
}
