//! Values over time.

use glam::Quat;

/// The interpolation between two keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// The value of the key before.
    Step,
    /// Along a straight line; rotations along the shorter arc.
    Linear,
    /// Cubic Hermite: each key has an incoming tangent, its value and an outgoing tangent, per second.
    Cubic,
}

/// The meaning of the values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// Each for itself.
    Numbers,
    /// Unit quaternions x, y, z, w.
    Rotation,
}

/// Rows of numbers at key times. Before the first key and after the last one it stands still.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    times: Vec<f32>,
    values: Vec<f32>,
    width: usize,
    interpolation: Interpolation,
    meaning: Meaning,
}

impl Track {
    /// Whether it has one value at all times.
    #[must_use]
    pub fn is_constant(&self) -> bool {
        // Tangents stand before and behind a cubic's values.
        let is_tangent = |i: usize| self.interpolation == Interpolation::Cubic && i % 3 != 1;
        let first = self.row(0, 0);
        let mut rows = self.values.chunks_exact(self.width).enumerate();
        rows.all(|(i, row)| if is_tangent(i) { row.iter().all(|t| *t == 0.0) } else { row == first })
    }

    /// `times` don't fall and are at least one; `values` has `width` numbers a key, three times that when cubic; all finite.
    ///
    /// # Panics
    /// When there are no keys, or not as many values.
    #[must_use]
    pub fn new(
        times: Vec<f32>,
        mut values: Vec<f32>,
        width: usize,
        interpolation: Interpolation,
        meaning: Meaning,
    ) -> Self {
        let rows = if interpolation == Interpolation::Cubic { 3 } else { 1 };
        assert!(!times.is_empty() && values.len() == times.len() * width * rows, "a row of values for each key");
        if meaning == Meaning::Rotation && rows == 1 {
            values.chunks_exact_mut(4).for_each(unit_quaternion);
        }
        Self { times, values, width, interpolation, meaning }
    }

    /// A value that stays.
    #[must_use]
    pub fn constant(value: &[f32]) -> Self {
        Self::new(vec![0.0], value.to_vec(), value.len(), Interpolation::Step, Meaning::Numbers)
    }

    /// Through the keys with continuous velocity and without overshoot: harmonic means of the slopes on both sides
    /// (F. N. Fritsch, J. Butland, SIAM J. Sci. Stat. Comput. 5, 1984), 0 where they differ in sign. It starts and ends
    /// at rest; on a `closed` track the last key is followed by the first.
    ///
    /// # Panics
    /// As [`Self::new`].
    #[must_use]
    pub fn smooth(times: Vec<f32>, keys: &[f32], width: usize, closed: bool, meaning: Meaning) -> Self {
        let n = times.len();
        let step = |i: usize| f64::from(times[i + 1]) - f64::from(times[i]);
        let slope = |i: usize, k: usize| {
            let at = |i: usize| f64::from(keys[i * width + k]);
            (at(i + 1) - at(i)) / step(i)
        };
        let mut values = Vec::with_capacity(3 * keys.len());
        for i in 0..n {
            let sides = match (i, n) {
                (_, 1) => None,
                (0, _) if closed => Some((n - 2, 0)),
                (_, _) if i == n - 1 && closed => Some((n - 2, 0)),
                (0, _) => None,
                (_, _) if i == n - 1 => None,
                _ => Some((i - 1, i)),
            };
            let tangent = |k: usize| {
                let Some((before, after)) = sides else { return 0.0 };
                let (a, b) = (slope(before, k), slope(after, k));
                if a * b <= 0.0 {
                    return 0.0;
                }
                let (h0, h1) = (step(before), step(after));
                let (wa, wb) = (2.0 * h1 + h0, h1 + 2.0 * h0);
                ((wa + wb) / (wa / a + wb / b)) as f32
            };
            values.extend((0..width).map(tangent));
            values.extend(&keys[i * width..(i + 1) * width]);
            values.extend((0..width).map(tangent));
        }
        Self::new(times, values, width, Interpolation::Cubic, meaning)
    }

    /// Numbers a key.
    #[must_use]
    pub const fn width(&self) -> usize {
        self.width
    }

    /// The last key's time.
    #[must_use]
    pub fn end(&self) -> f32 {
        self.times[self.times.len() - 1]
    }

    /// The first key's time.
    #[must_use]
    pub fn start(&self) -> f32 {
        self.times[0]
    }

    /// Writes the value at a time, `width` numbers.
    ///
    /// # Panics
    /// When `out` has another length.
    pub fn sample(&self, time: f32, out: &mut [f32]) {
        let next = self.times.partition_point(|&k| k <= time);
        if next == 0 || next == self.times.len() {
            out.copy_from_slice(self.row(next.saturating_sub(1), 0));
        } else {
            // The key before is at or before the time, the next one after it: never a division by 0.
            let (start, end) = (self.times[next - 1], self.times[next]);
            let span = end - start;
            self.between(next - 1, (time - start) / span, span, out);
        }
        if self.meaning == Meaning::Rotation && self.interpolation == Interpolation::Cubic {
            unit_quaternion(out);
        }
    }

    /// The value (0), or the incoming (−1) or outgoing (1) tangent of a key.
    fn row(&self, key: usize, which: isize) -> &[f32] {
        let row = match self.interpolation {
            Interpolation::Cubic => (3 * key + 1).saturating_add_signed(which),
            _ => key,
        };
        &self.values[row * self.width..(row + 1) * self.width]
    }

    fn between(&self, key: usize, u: f32, span: f32, out: &mut [f32]) {
        let (from, to) = (self.row(key, 0), self.row(key + 1, 0));
        match (self.interpolation, self.meaning) {
            (Interpolation::Step, _) => out.copy_from_slice(from),
            (Interpolation::Linear, Meaning::Rotation) => {
                let turned = Quat::from_slice(from).slerp(Quat::from_slice(to), u);
                out.copy_from_slice(&turned.to_array());
                unit_quaternion(out);
            }
            (Interpolation::Linear, Meaning::Numbers) => {
                for ((o, a), b) in out.iter_mut().zip(from).zip(to) {
                    *o = a + (b - a) * u;
                }
            }
            (Interpolation::Cubic, _) => {
                // glTF 2.0, appendix C.
                let (u2, u3) = (u * u, u * u * u);
                let (a, b) = (2.0 * u3 - 3.0 * u2 + 1.0, span * (u3 - 2.0 * u2 + u));
                let (c, d) = (3.0 * u2 - 2.0 * u3, span * (u3 - u2));
                let (leave, arrive) = (self.row(key, 1), self.row(key + 1, -1));
                for (k, o) in out.iter_mut().enumerate() {
                    *o = a * from[k] + b * leave[k] + c * to[k] + d * arrive[k];
                }
            }
        }
    }
}

/// Of length 1; the identity where there is no direction.
fn unit_quaternion(q: &mut [f32]) {
    let quat = Quat::from_slice(q);
    let length = quat.length();
    let unit = if length.is_finite() && length > 1e-10 { quat / length } else { Quat::IDENTITY };
    q.copy_from_slice(&unit.to_array());
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(track: &Track, time: f32) -> Vec<f32> {
        let mut out = vec![0.0; track.width];
        track.sample(time, &mut out);
        out
    }

    #[test]
    fn steps_change_at_their_keys() {
        let track = Track::new(vec![1.0, 2.0, 2.0], vec![3.0, 4.0, 5.0], 1, Interpolation::Step, Meaning::Numbers);
        let got: Vec<f32> = [-1.0, 1.0, 1.999, 2.0, 9.0, f32::NAN].iter().map(|&t| at(&track, t)[0]).collect();
        assert_eq!(got, [3.0, 3.0, 3.0, 5.0, 5.0, 3.0]);
    }

    #[test]
    fn cubic_keys_follow_the_hermite_polynomial() {
        // Two numbers, two keys; the coefficients of the polynomial solved in f64 from its end conditions.
        let (p0, m0, p1, m1) = ([1.0, -2.0], [3.0, 0.5], [4.0, 7.0], [-1.5, 2.0]);
        let values: Vec<f32> = [[9.0, 9.0], p0, m0, m1, p1, [9.0, 9.0]].concat();
        let track = Track::new(vec![0.5, 2.0], values, 2, Interpolation::Cubic, Meaning::Numbers);
        let h = 1.5_f64;
        for i in 0..=30 {
            let time = 0.5 + 0.05 * i as f32;
            let x = f64::from(time) - 0.5;
            for k in 0..2 {
                let [p0, m0, p1, m1] = [p0[k], m0[k], p1[k], m1[k]].map(f64::from);
                // p(x) = p0 + m0 x + c x² + d x³ with p(h) = p1 and p'(h) = m1.
                let c = (3.0 * (p1 - p0) / h - 2.0 * m0 - m1) / h;
                let d = (m1 + m0 - 2.0 * (p1 - p0) / h) / (h * h);
                let want = p0 + x * (m0 + x * (c + x * d));
                // A dozen roundings of numbers below 10 and the time's own.
                assert!((f64::from(at(&track, time)[k]) - want).abs() < 5e-6, "{time}");
            }
        }
    }

    #[test]
    fn rotations_take_the_shorter_arc() {
        let quarter = Quat::from_rotation_z(1.0);
        let values = [Quat::IDENTITY, -quarter, quarter, Quat::from_array([0.0; 4])].map(|q| q.to_array()).concat();
        let track = Track::new(vec![0.0, 1.0, 2.0, 3.0], values, 4, Interpolation::Linear, Meaning::Rotation);
        for (time, angle) in [(0.25, 0.25_f32), (0.9, 0.9), (1.5, 1.0), (2.5, 0.5)] {
            let got = Quat::from_slice(&at(&track, time));
            let want = Quat::from_rotation_z(angle);
            assert!(got.dot(want).abs() > 1.0 - 1e-6, "{time}: {got}");
        }
    }

    #[test]
    fn smooth_tracks_meet_their_keys_and_stay_between_them() {
        let (times, keys) = (vec![0.0, 0.5, 2.0, 2.25, 4.0], [0.0, 1.0, 1.0, 5.0, -2.0]);
        for closed in [false, true] {
            let track = Track::smooth(times.clone(), &keys, 1, closed, Meaning::Numbers);
            for (&t, &k) in times.iter().zip(&keys) {
                assert_eq!(at(&track, t)[0], k);
            }
            for i in 0..400 {
                let t = 0.01 * i as f32;
                let piece = times.partition_point(|&k| k <= t).min(4) - 1;
                let (low, high) = (keys[piece].min(keys[piece + 1]), keys[piece].max(keys[piece + 1]));
                let got = at(&track, t)[0];
                assert!(got > low - 1e-5 && got < high + 1e-5, "{t}: {got}");
            }
        }
        // Through a straight line it is that line, when it goes on.
        let track = Track::smooth(vec![0.0, 1.0, 3.0], &[0.0, 90.0, 270.0], 1, true, Meaning::Numbers);
        for t in [0.2_f32, 0.5, 1.7, 2.9] {
            assert!((at(&track, t)[0] - 90.0 * t).abs() < 1e-4);
        }
        // At rest at the ends otherwise.
        let track = Track::smooth(vec![0.0, 1.0], &[0.0, 1.0], 1, false, Meaning::Numbers);
        assert!(at(&track, 0.01)[0] < 4e-4 && at(&track, 0.5)[0] == 0.5);
    }
}
