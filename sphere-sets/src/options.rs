use core::ops::ControlFlow;

/// Settings for building a sphere set.
///
/// ```
/// use sphere_sets::BuildOptions;
/// let draft = BuildOptions::draft(64);
/// let default = BuildOptions::new(64);
/// assert!(draft.rounds < default.rounds);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BuildOptions {
    /// Spheres requested, ≥ 1. The set has fewer where more would not change it (a sphere needs one).
    pub count: usize,
    /// Chooses the random directions of the descent: the same seed gives the same set on any number of threads.
    pub seed: u64,
    /// Rounds of taking out the least useful spheres, putting them where they help most, and descending again.
    /// With 0 the set is the greedy cover alone, which never follows the silhouette.
    pub rounds: u32,
    /// Whether the spheres must hold every point of the surface: a bound of the mesh, whose shadow is somewhat too large.
    pub bounding: bool,
}

impl BuildOptions {
    /// The full silhouette descent.
    #[must_use]
    pub const fn new(count: usize) -> Self {
        // Few spheres settle badly more often, and are cheap.
        let rounds = match count {
            0..=23 => 80,
            24..=48 => 60,
            _ => 40,
        };
        Self { count, seed: 0, rounds, bounding: false }
    }

    /// The greedy cover by inner spheres alone: several times faster, about three times the silhouette error.
    #[must_use]
    pub const fn draft(count: usize) -> Self {
        Self { count, seed: 0, rounds: 0, bounding: false }
    }
}

/// Hears how much of the work is done, in `[0, 1]`, and may stop it.
pub type Progress<'a> = dyn FnMut(f32) -> ControlFlow<()> + 'a;
