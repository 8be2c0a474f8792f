//! Settings picked from the measured front of error against time.

use clap::ValueEnum;
use cosine_lobes::shading::Accuracy;

/// The quality of a picture: points of the front that `lobes trade` measures.
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

#[cfg(test)]
mod tests {
    use super::*;
    use cosine_lobes::renderer::LADDER;

    #[test]
    fn qualities_are_on_the_ladder() {
        assert!([Quality::Draft, Quality::Interactive, Quality::High].iter().all(|q| LADDER.contains(&q.accuracy())));
    }
}
