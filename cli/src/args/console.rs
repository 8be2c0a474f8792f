use super::values::whole;
use clap::Args;

/// Options of commands that compute for long and print a summary.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct ConsoleArgs {
    /// Threads to use, instead of one a core
    #[arg(long, value_name = "N", value_parser = whole(1..=1024))]
    pub(crate) threads: Option<u32>,

    /// No progress, no summary, no warnings
    #[arg(long, short)]
    pub(crate) quiet: bool,

    /// Print the summary as JSON
    #[arg(long)]
    pub(crate) json: bool,
}
