use crate::row;
use fearless_simd::{Simd, f32x8, prelude::*, u32x8};

/// Rows and samples, from and to; a mask is dark outside of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LitBounds {
    /// Rows.
    pub rows: [u32; 2],
    /// Samples of a row.
    pub samples: [u32; 2],
}

impl LitBounds {
    /// True if nothing is lit.
    #[must_use]
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.rows[0] >= self.rows[1]
    }
}

/// The conversion from plane coordinates to rows and samples: row line `j` is at height `j + ½` of `(y − bottom)·rows`; samples are
/// counted from `(x − left)·samples`, minus the shift of the row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Raster {
    /// Plane coordinate x of the window's left side.
    pub left: f32,
    /// Plane coordinate y of its lower side.
    pub bottom: f32,
    /// Samples per unit of plane coordinates.
    pub samples: f32,
    /// Rows per unit.
    pub rows: f32,
    /// Samples in a row.
    pub width: f32,
}

impl Raster {
    /// The shift of the samples of row `j`, in samples within ±½. Subtract it from positions in samples before rounding.
    #[inline(always)]
    #[must_use]
    pub fn shift(j: usize) -> f32 {
        row::PHASE[j]
    }

    /// The shifts of eight rows from `j` on.
    #[inline(always)]
    #[must_use]
    pub fn shifts(j: usize) -> &'static [f32; 8] {
        row::phases(j)
    }

    /// The first sample at or after a position.
    #[doc(hidden)]
    #[inline(always)]
    #[must_use]
    pub fn index(&self, position: f32) -> u32 {
        row::index(position).min(self.width as u32)
    }

    /// The first sample at or after each position.
    #[doc(hidden)]
    #[inline(always)]
    pub fn indices<S: Simd>(&self, simd: S, position: f32x8<S>) -> u32x8<S> {
        let clamped = position.max(f32x8::splat(simd, 0.0)).min(f32x8::splat(simd, self.width));
        // The last bits of a float that is large enough.
        (clamped + f32x8::splat(simd, 12_582_912.0)).bitcast::<u32x8<S>>() & u32x8::splat(simd, 0x1ff)
    }

    /// Heights of the eight lines of [`Mask::block_lines`](crate::Mask::block_lines) above the row's own, in rows within ±½.
    pub const HEIGHTS: [f32; 8] = {
        let mut heights = [0.0; row::SUBLINES];
        let mut k = 0;
        while k < row::SUBLINES {
            heights[k] = row::height(k);
            k += 1;
        }
        heights
    };
}
