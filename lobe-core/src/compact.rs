use glam::Vec3;

/// Orders numbered points so that each aligned run of `run`, `8·run`, `64·run` … of them is compact: medians across the
/// longest side of their box. Ties go by number, so the order is unique.
///
/// # Cost
/// O(n log n).
///
/// # Panics
/// When `run` is zero.
///
/// ```
/// use glam::Vec3;
/// let mut points: Vec<_> = (0..16).map(|i| (Vec3::X * (i * 7 % 16) as f32, i)).collect();
/// lobe_core::compact_runs(&mut points, 8);
/// assert!(points[..8].iter().all(|p| p.0.x < 8.0));
/// ```
pub fn compact_runs(points: &mut [(Vec3, u32)], run: usize) {
    assert!(run > 0, "a run of no points");
    if points.len() <= run {
        return;
    }
    let mut child = run;
    while child.saturating_mul(8) < points.len() {
        child *= 8;
    }
    let middle = points.len().div_ceil(child) / 2 * child;
    let (low, high) =
        points.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(p.0), high.max(p.0)));
    let axis = (high - low).max_position();
    points.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1)));
    let (left, right) = points.split_at_mut(middle);
    compact_runs(left, run);
    compact_runs(right, run);
}
