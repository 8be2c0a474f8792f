//! The kernels' counters.

pub(crate) mod queue;

use scene::Counts;

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
