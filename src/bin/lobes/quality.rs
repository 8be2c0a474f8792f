//! Settings picked from the measured front of error against time.

use clap::ValueEnum;
use cosine_lobes::lobe_core::Accuracy;

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
    pub(crate) const fn accuracy(self) -> Accuracy {
        match self {
            Self::Draft => Accuracy { tolerance: 0.1, depth: 2 },
            Self::Interactive => Accuracy { tolerance: 0.01, depth: 4 },
            Self::High => Accuracy { tolerance: 0.001, depth: 6 },
        }
    }
}

/// Settings along the front, from the fastest to the best: what a time budget chooses from.
pub(crate) const LADDER: [Accuracy; 5] = [
    Quality::Draft.accuracy(),
    Accuracy { tolerance: 0.03, depth: 3 },
    Quality::Interactive.accuracy(),
    Accuracy { tolerance: 0.003, depth: 5 },
    Quality::High.accuracy(),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ladder_rises() {
        assert!(LADDER.windows(2).all(|w| w[1].tolerance < w[0].tolerance && w[1].depth >= w[0].depth));
    }
}
