use super::{Horizon, Meridians, SkyWindow};
use fearless_simd::{Simd, f32x8, mask32x8, prelude::*};
use lobe_core::vec3x8::{LANES, Vec3x8};

/// Numbers of an arc: the normal of its plane in the pole's frame, the first row after its beginning, how many rows it crosses (negative:
/// clockwise), and the step.
const NUMBERS: usize = 6;
pub(super) const NORMAL: usize = 0;
pub(super) const FIRST: usize = 3;
pub(super) const ROWS: usize = 4;
pub(super) const STEP: usize = 5;

/// Parts of outlines that cross meridians: great-circle arcs, eight side by side.
#[derive(Clone, Debug, Default)]
pub struct SkyArcs {
    columns: [Vec<f32>; NUMBERS],
    len: usize,
}

impl SkyArcs {
    /// Removes all arcs.
    pub fn clear(&mut self) {
        self.len = 0;
    }

    /// Their number.
    #[must_use]
    pub const fn len(&self) -> usize {
        self.len
    }

    /// True when there are none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Makes room for so many more, so that [`push`](Self::push) finds it.
    pub fn reserve(&mut self, count: usize) {
        let wanted = self.len + count + LANES;
        if self.columns[0].len() < wanted {
            let wanted = wanted.next_power_of_two();
            self.columns.iter_mut().for_each(|column| column.resize(wanted, 0.0));
        }
    }

    #[inline(always)]
    pub(super) fn load<S: Simd>(&self, simd: S, column: usize, first: usize) -> f32x8<S> {
        f32x8::from_slice(simd, &self.columns[column][first..first + LANES])
    }

    /// Which of eight arcs are there, as bits.
    #[inline(always)]
    pub(super) fn lanes(&self, first: usize) -> u32 {
        (1 << (self.len - first).min(LANES)) - 1
    }

    /// Appends the arcs in which edges from `a` to `b`, seen from the receiver, are seen: those of `keep` that cross a meridian of the window and are not
    /// wholly below the horizon. `step` is by how many half surfaces the number of surfaces grows to
    /// the right of an edge. Returns which were appended.
    ///
    /// Between which rows a point lies depends on the point alone, so that outlines stay closed whatever the rounding; on which side of the
    /// pole an edge passes is the edge's own decision, and changes all rows alike. Room is to be [reserved](Self::reserve).
    #[inline(always)]
    pub fn push<S: Simd>(
        &mut self,
        simd: S,
        meridians: &Meridians,
        (horizon, window): (&Horizon, &SkyWindow),
        [a, b]: [Vec3x8<S>; 2],
        step: f32x8<S>,
        keep: mask32x8<S>,
    ) -> mask32x8<S> {
        let zero = f32x8::splat(simd, 0.0);
        let (p, q) = (horizon.pole().local_of(a), horizon.pole().local_of(b));
        let lines = window.lines();
        let (first, last) =
            (meridians.lines_before(simd, p.x, p.y, lines), meridians.lines_before(simd, q.x, q.y, lines));
        let keep = keep & !first.simd_eq(last);
        if !keep.any_true() {
            return keep;
        }
        let normal = horizon.normal();
        let keep = keep & a.dot_one(normal).max(b.dot_one(normal)).simd_gt(zero);
        if !keep.any_true() {
            return keep;
        }
        let plane = p.cross(q);
        let all = f32x8::splat(simd, (meridians.resolution().rows() * lines) as f32);
        let half = all * 0.5;
        let rows = last - first;
        let rows = rows.simd_gt(half).select(rows - all, rows);
        let rows = rows.simd_lt(-half).select(rows + all, rows);
        // Beside the pole the edge's plane says on which side it passes.
        let is_near = rows.abs().simd_gt(half - 2.0) & (rows * plane.z).simd_lt(zero);
        let other = rows.simd_gt(zero).select(rows - all, rows + all);
        let rows = is_near.select(other, rows);
        // Nothing is crossed between the last row and the first.
        let mut keep = keep & !rows.simd_eq(zero);
        if !window.is_whole() {
            let low = first + rows.min(zero);
            keep &= window.meets(low, low + rows.abs());
        }
        let mut plane = plane;
        let is_axial = plane.z.simd_eq(zero) & keep;
        if is_axial.any_true() {
            // Through the pole, for which no plane stands, or through the opposite one, which is never seen.
            let [to_p, to_q] = [a, b].map(|v| v.length_squared().sqrt());
            keep &= !(is_axial & (p.z * to_q + q.z * to_p).simd_lt(zero));
            plane = plane.or(is_axial, Vec3x8::new(zero, zero, zero));
        }
        let len = self.len;
        for (column, value) in self.columns.iter_mut().zip([plane.x, plane.y, plane.z, first, rows, step]) {
            value.compress(keep).store_slice(&mut column[len..len + LANES]);
        }
        self.len += keep.to_bitmask().count_ones() as usize;
        keep
    }
}
