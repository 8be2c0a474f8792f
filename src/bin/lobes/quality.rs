//! Settings picked from the measured front of error against time.

use clap::ValueEnum;

/// How good a picture is to be: points of the front that `lobes trade` measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Quality {
    /// Tolerance 10 %, depth 2: to look around
    Draft,
    /// Tolerance 1 %, depth 4: nothing to be seen beside the reference
    Interactive,
    /// Tolerance 0.1 %, depth 6: to be measured with
    High,
}

impl Quality {
    /// Tolerance and depth.
    pub(crate) const fn setting(self) -> (f32, u32) {
        match self {
            Self::Draft => (0.1, 2),
            Self::Interactive => (0.01, 4),
            Self::High => (0.001, 6),
        }
    }
}

/// Settings along the front, from the fastest to the best: what a time budget chooses from.
pub(crate) const LADDER: [(f32, u32); 5] =
    [Quality::Draft.setting(), (0.03, 3), Quality::Interactive.setting(), (0.003, 5), Quality::High.setting()];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ladder_rises() {
        assert!(LADDER.windows(2).all(|w| w[1].0 < w[0].0 && w[1].1 >= w[0].1));
    }
}
