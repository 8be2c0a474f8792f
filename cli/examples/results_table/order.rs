//! Points in other orders than a picture's, such as the vertices of a mesh, and their cost.

use crate::measure::{How, Timing, frames};
use crate::models::Models;
use crate::scenes::Case;
use std::time::Instant;

/// One scene's points in three orders.
pub(crate) struct Orders {
    pub(crate) name: &'static str,
    /// Tile by tile, shuffled, made coherent again.
    pub(crate) timings: [Timing; 3],
    /// Seconds that it took to make them coherent.
    pub(crate) sorting: f64,
}

pub(crate) const NAMES: [&str; 3] = ["tiles of pixels", "shuffled", "made coherent again"];

pub(crate) fn measure(name: &'static str, case: &Case, models: &mut Models, repeats: usize) -> Result<Orders, String> {
    let (scene, blockers, gbuffer) = case.make(models.of(case.spheres)?);
    let time = |points: &_| frames(&scene, &blockers, points, How::default(), repeats).map(|(timing, _)| timing);
    let mut points = case.counted(gbuffer.points);
    let tiles = time(&points)?;
    points.reorder(&shuffled(points.receivers.len()));
    let without = time(&points)?;
    let start = Instant::now();
    points.make_coherent();
    let sorting = start.elapsed().as_secs_f64();
    Ok(Orders { name, timings: [tiles, without, time(&points)?], sorting })
}

/// The same order each time (Fisher and Yates, with xorshift).
fn shuffled(count: usize) -> Vec<u32> {
    let mut order: Vec<u32> = (0..count as u32).collect();
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    for i in (1..count).rev() {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        order.swap(i, (state % (i as u64 + 1)) as usize);
    }
    order
}
