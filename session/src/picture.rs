use glam::Vec3;
use renderer::{ImageStats, Upkeep};

/// A picture of a session.
#[derive(Clone, Debug, Default)]
pub struct Picture {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Linear radiance toward the eye, W·m⁻²·sr⁻¹ per channel, row by row.
    pub radiance: Vec<Vec3>,
    /// By how much its sides are shorter than those of the whole picture, rounded up: 1 is the whole one.
    pub divisor: u32,
    /// The number of changes that it shows: edits, refused ones included, and steps back and forth.
    pub edits: u64,
    /// Seconds from the first edit that no earlier picture shows until this picture was there; 0 where there is no new one.
    pub latency: f64,
    /// How it was made.
    pub stats: ImageStats,
    /// How often what is kept between pictures was made or followed so far.
    pub upkeep: Upkeep,
}
