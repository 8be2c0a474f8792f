use crate::MAX_DEPTH;
use shading::Accuracy;

/// The tolerance from which on rows of 64 samples suffice for broad lobes, and one mask for narrow ones.
pub(crate) const COARSE: f32 = 0.005;

/// The number of samples for a lobe's visible fraction, besides the depth of the masks.
///
/// Samples come and go as things move: if a few of them carry a lobe's visible fraction, each one is noticeable. The visible part
/// of the light is therefore divided into parts with a mask each. For gentle motion the largest pop is 0.94 % of the unshadowed
/// radiance at a tolerance of 1 %, 0.62 % at 0.5 %, 0.21 % at 0.3 % and 0.09 % at 0.1 %.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Fineness {
    /// Whether rows have 64 samples instead of 256; masks then err 1.5 times as much.
    pub coarse: bool,
    /// Masks side by side, and masks one above the other.
    pub grid: [u32; 2],
}

impl Fineness {
    /// One mask with rows of 256 samples.
    pub const FINE: Self = Self { coarse: false, grid: [1, 1] };

    /// For lobes that are broad compared with the light: all share the same masks.
    #[must_use]
    pub fn broad(tolerance: f32) -> Self {
        let grid = if tolerance >= Accuracy::FINEST { [1, 1] } else { [2, 2] };
        Self { coarse: tolerance >= COARSE, grid }
    }

    /// For lobes that see only a part of the light, or fall steeply over it. These have a window each.
    #[must_use]
    pub fn narrow(tolerance: f32) -> Self {
        let grid = if tolerance >= COARSE {
            [1, 1]
        } else if tolerance >= Accuracy::FINEST {
            [2, 2]
        } else {
            [3, 2]
        };
        Self { coarse: false, grid }
    }

    /// The next finer masks, with twice the rows, than these of a depth.
    pub(crate) fn finer(self, depth: u32) -> (Self, u32) {
        if depth < MAX_DEPTH {
            (Self { coarse: false, ..self }, depth + 1)
        } else {
            (Self { coarse: false, grid: self.grid.map(|count| 2 * count) }, depth)
        }
    }

    /// Columns of a mask, of some samples each, that have a weight of their own.
    pub(crate) const fn columns(self) -> u32 {
        if self.coarse { 16 } else { 32 }
    }

    /// Number of masks.
    #[must_use]
    pub fn count(self) -> usize {
        (self.grid[0] * self.grid[1]) as usize
    }
}
