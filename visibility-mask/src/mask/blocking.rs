//! Functions that block samples of a mask: spans, areas, half-spaces, cells, and rows found elsewhere.

use super::{Mask, below};
use crate::bits::Bits;
use crate::row::{self, EIGHT, EightRows, ROWS, Row, SUBLINES};
use fearless_simd::{Level, Simd, dispatch, prelude::*, u32x8};
use glam::Vec3;

impl Mask {
    #[inline(always)]
    fn set(&mut self, j: usize, row: Row) {
        if self.coarse {
            (self.halves[0][j], self.halves[1][j]) = (row.0[0] as u32, (row.0[0] >> 32) as u32);
        } else {
            self.lit[j] = row;
        }
    }

    #[inline(always)]
    fn block(&mut self, j: usize, row: &Row) {
        self.set(j, row::without(&self.lit(j), row));
    }

    /// Blocks row `j` between two plane coordinates x; these may be infinite; an empty or NaN interval blocks nothing.
    pub fn block_span(&mut self, j: usize, from: f32, to: f32) {
        let (from, to) = self.samples(j, from, to);
        self.block(j, &row::span(from, to));
    }

    /// Blocks the part of row `j` that a shape covers on eight lines: for shapes whose edge runs along the row and would otherwise
    /// enter or leave the whole row at once. `span` returns the shape's plane coordinates x at a height y.
    ///
    /// Each line has an eighth of the samples, so that two edges that pass through the same row combine correctly.
    pub fn block_area(&mut self, j: usize, span: impl Fn(f32) -> (f32, f32)) {
        let (y, cell) = (self.row_y(j), self.cell().y);
        let mut from = [0; SUBLINES];
        let mut to = [0; SUBLINES];
        for k in 0..SUBLINES {
            let (a, b) = span(y + cell * row::height(k));
            let (a, b) = if a < b { (a, b) } else { (self.left, self.left) };
            let at = |x: f32| self.index((x - self.left) * self.scale);
            (from[k], to[k]) = (at(a), at(b));
        }
        dispatch!(Level::new(), simd => {
            self.block_lines(simd, j, u32x8::simd_from(simd, from), u32x8::simd_from(simd, to));
        });
    }

    /// Blocks everything below the plane through the receiver with this normal (world space).
    ///
    /// Exact on the rows' lines: turn the mask across the plane's edge with [`Edges::add_plane`](crate::Edges::add_plane).
    pub fn block_below(&mut self, normal: Vec3) {
        let n = self.square.local(normal);
        for j in 0..self.side() {
            let (from, to) = below(n, self.row_y(j));
            self.block_span(j, from, to);
        }
    }

    /// Blocks every sample.
    pub fn block_all(&mut self) {
        self.lit = [row::NONE; ROWS];
        self.halves = [[0; ROWS]; 2];
    }

    /// Blocks each cell if `test` is true for its centre's unit direction (in world space): slow, for shapes without spans.
    pub fn block_where(&mut self, test: impl Fn(Vec3) -> bool) {
        // A cell of a coarse mask may be as small as a sample.
        let width = (self.width() >> self.depth) as u32;
        for j in 0..self.side() {
            for i in Bits(self.lit_cells(j)) {
                let p = self.cell_center(i, j);
                if test(self.square.world(p.extend(1.0)).normalize()) {
                    let cell = row::span(i as u32 * width, (i as u32 + 1) * width);
                    self.block(j, &cell);
                }
            }
        }
    }

    /// Blocks all other samples of the eight rows from `j` on than `samples`, 64 in each word; `j` is a multiple of eight.
    #[inline(always)]
    pub fn keep_rows(&mut self, j: usize, samples: &[EightRows]) {
        for k in 0..EIGHT.min(self.side() - j) {
            let mut kept = row::NONE;
            kept.0.iter_mut().zip(samples).for_each(|(kept, word)| *kept = word[k]);
            self.set(j + k, row::and(&self.lit(j + k), &kept));
        }
    }

    /// Blocks samples `from[k]..to[k]` of the row `j + k`, eight rows at once: for shapes that compute the ends of many rows
    /// together, with [`raster`](Self::raster). An empty interval blocks nothing; ends are at most the raster's width.
    #[doc(hidden)]
    #[inline(always)]
    pub fn block_rows<S: Simd>(&mut self, simd: S, j: usize, from: u32x8<S>, to: u32x8<S>) {
        if self.coarse {
            let blocked = row::halves(simd, from, to);
            for (rows, blocked) in self.halves.iter_mut().zip(blocked) {
                let rows = row::eight_mut(rows, j);
                (u32x8::from_slice(simd, rows) & !blocked).store_slice(rows);
            }
        } else {
            let (from, to): ([u32; EIGHT], [u32; EIGHT]) = (from.into(), to.into());
            for (row, (from, to)) in row::eight_mut(&mut self.lit, j).iter_mut().zip(from.iter().zip(&to)) {
                *row = row::without(row, &row::span(*from, *to));
            }
        }
    }

    /// As [`block_area`](Self::block_area), with the ends of the eight lines in samples, without a shift.
    #[doc(hidden)]
    #[inline(always)]
    pub fn block_lines<S: Simd>(&mut self, simd: S, j: usize, from: u32x8<S>, to: u32x8<S>) {
        if self.coarse {
            let blocked = row::of_lines(simd, j, from, to);
            self.halves[0][j] &= !blocked[0];
            self.halves[1][j] &= !blocked[1];
            return;
        }
        let (from, to): ([u32; EIGHT], [u32; EIGHT]) = (from.into(), to.into());
        let mut blocked = row::NONE;
        for k in 0..SUBLINES {
            let line = row::span(from[k], to[k]);
            blocked = row::with(&blocked, &row::of_line(&line, j, k));
        }
        self.lit[j] = row::without(&self.lit[j], &blocked);
    }
}
