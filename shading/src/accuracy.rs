/// The error that a frame may have, and how finely masks look for that: the only place of either.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Requested mean error of the shadowed radiance, as a fraction of the unshadowed radiance.
    pub tolerance: f32,
    /// Depth of the visibility mask's quad-tree, `2^depth` cells a side.
    pub depth: u32,
}

impl Accuracy {
    /// Tolerance below which masks are deepest and finest.
    pub const FINEST: f32 = 0.002;

    /// A tolerance, and the depth that it requires: the mask's own error stays below it.
    ///
    /// Mean error over penumbrae, random blockers, light wholly above the horizon: 0.13 % of the unshadowed radiance at
    /// depth 4 (64 samples a row), 0.06 % at 5 and 0.03 % at 6 (256).
    ///
    /// ```
    /// use shading::Accuracy;
    /// assert_eq!([0.01, 0.003, 0.001].map(|tolerance| Accuracy::new(tolerance).depth), [4, 5, 6]);
    /// ```
    #[must_use]
    pub fn new(tolerance: f32) -> Self {
        let depth = if tolerance >= 0.008 {
            4
        } else if tolerance >= Self::FINEST {
            5
        } else {
            6
        };
        Self { tolerance, depth }
    }

    /// The same tolerance with masks of another depth.
    #[must_use]
    pub fn with_depth(self, depth: u32) -> Self {
        Self { depth, ..self }
    }
}

impl Default for Accuracy {
    /// A mean error of half a percent.
    fn default() -> Self {
        Self::new(0.005)
    }
}
