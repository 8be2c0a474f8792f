use super::values::whole;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Redo the paper's figures, each beside the paper's own statement
///
/// Draws and measures Fig. 2 to 6, Fig. 8 to 22 and Table 1 of Meunier et al., Cosine lobes for interactive direct lighting in dynamic scenes
/// (Computers & Graphics 34, 2010). Writes a PNG of each, for curves and drawings an SVG as well, and figures.md: the content of each
/// figure, the paper's statement, the result measured here, and the reasons where the two cannot be compared. Needs no other file: the
/// program makes the scenes. Spheres are fitted once and kept for later runs. All take about two minutes; sections of other figures
/// stay in figures.md. Times are those of the machine that runs it.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  lobes figures -o figures                 all of them
  lobes figures 4 12 table1 -o figures     two figures and the table")]
pub(crate) struct FiguresArgs {
    /// Figures to redo; all when left out
    #[arg(value_enum, value_name = "FIGURE")]
    pub(crate) figures: Vec<Figure>,

    /// Folder to write to; made where there is none
    #[arg(long, short, value_name = "DIR")]
    pub(crate) output: PathBuf,

    /// Threads to use, instead of one a core
    #[arg(long, value_name = "N", value_parser = whole(1..=1024))]
    pub(crate) threads: Option<u32>,

    /// No progress, no summary
    #[arg(long, short)]
    pub(crate) quiet: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub(crate) enum Figure {
    /// Integral of a lobe by its exponent
    #[value(name = "2")]
    F2,
    /// Error of a product of two lobes
    #[value(name = "3")]
    F3,
    /// Products above a threshold
    #[value(name = "4")]
    F4,
    /// A scene with several thresholds
    #[value(name = "5")]
    F5,
    /// Exponent of a product
    #[value(name = "6")]
    F6,
    /// Blockers on the unit square
    #[value(name = "8")]
    F8,
    /// The quad-tree of the visibility mask
    #[value(name = "9")]
    F9,
    /// Lobes of shadow nodes
    #[value(name = "10")]
    F10,
    /// Overlap of these lobes by distance
    #[value(name = "11")]
    F11,
    /// Reference and both methods
    #[value(name = "12")]
    F12,
    /// Spatially varying Lafortune, timed
    #[value(name = "13")]
    F13,
    /// Integrals of lobe sums, by Monte Carlo and by products
    #[value(name = "14")]
    F14,
    /// The saving of the threshold
    #[value(name = "15")]
    F15,
    /// 3578 spheres, timed
    #[value(name = "16")]
    F16,
    /// Time by area of the light
    #[value(name = "17")]
    F17,
    /// Self-shadowing under two lights, timed
    #[value(name = "18")]
    F18,
    /// A square light, as spheres and as itself
    #[value(name = "19")]
    F19,
    /// Time by number of lights
    #[value(name = "20")]
    F20,
    /// A cube under several lights
    #[value(name = "21")]
    F21,
    /// Shadows that soften with distance, timed
    #[value(name = "22")]
    F22,
    /// Time by stage
    #[value(name = "table1")]
    Table1,
}
