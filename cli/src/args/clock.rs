use super::values::{fps, time, whole};
use clap::Args;

/// Options that name moments of an animation.
#[derive(Args, Clone, Copy, Debug, Default)]
pub(crate) struct ClockArgs {
    /// The animation's frame N: the moment N / fps, from 0 (its state as loaded)
    #[arg(long, value_name = "N", value_parser = whole(0..=u32::MAX))]
    pub(crate) frame: Option<u32>,

    /// The animation's moment in seconds, from 0
    #[arg(long, value_name = "T", conflicts_with_all = ["frame", "fps"], value_parser = time)]
    pub(crate) time: Option<f32>,

    /// Frames a second for --frame and --frames, instead of the file's (24 where it does not say)
    #[arg(long, value_name = "F", value_parser = fps)]
    pub(crate) fps: Option<f32>,
}
