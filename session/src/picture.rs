use crate::Snapshot;
use glam::Vec3;
use renderer::{ImageStats, Layers, Upkeep};
use std::sync::Arc;

/// A picture of a session.
#[derive(Clone, Debug, Default)]
pub struct Picture {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Linear radiance toward the eye, W·m⁻²·sr⁻¹ per channel, row by row.
    pub radiance: Vec<Vec3>,
    /// The layers that were [requested](crate::Session::set_layers).
    pub layers: Layers,
    /// By how much its sides are shorter than those of the whole picture, rounded up: 1 is the whole one; 0 where none was made.
    pub divisor: u32,
    /// The number of changes that it shows: edits, refused ones included, and steps back and forth.
    pub edits: u64,
    /// The latest of these changes that a [reference](crate::Session::reference) shows: one with as many or more is of this picture.
    pub seen: u64,
    /// Seconds from the first edit that no earlier picture shows until this picture was there; 0 where there is no new one.
    pub latency: f64,
    /// Seconds that it took.
    pub seconds: f64,
    /// How it was made.
    pub stats: ImageStats,
    /// How often what is kept between pictures was made or followed so far.
    pub upkeep: Upkeep,
    /// The scene that it shows.
    pub scene: Arc<Snapshot>,
}
