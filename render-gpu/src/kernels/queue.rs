//! The counters of `queue.wgsl`: the same names and numbers.

/// Words before the items: the number of items, then the counters.
pub(crate) const QUEUE_HEADER: usize = 16;

/// Point–light pairs that see all of the light.
pub(crate) const LIT_POINTS: usize = 0;
/// Pairs that see nothing of it.
pub(crate) const DARK_POINTS: usize = 1;
/// Pairs that see a part of it.
pub(crate) const PENUMBRA_POINTS: usize = 2;
/// Integrals of reflectance lobes.
pub(crate) const INTEGRALS: usize = 3;
/// Reflectance lobes dropped below the threshold.
pub(crate) const PRUNED: usize = 4;
/// Threads whose loops the driver ended early.
pub(crate) const CUT: usize = 5;
/// Points of which a sky leaves lobes to its patches.
pub(crate) const SKY_LEFT: usize = 6;
