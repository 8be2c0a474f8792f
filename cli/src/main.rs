//! The `lobes` command.

mod advice;
mod args;
mod baking;
mod check;
mod checkpoint;
mod compare;
mod console;
mod device;
mod drawing;
mod environment;
mod failure;
mod figures;
mod files;
mod fingerprint;
mod input;
mod journal;
mod merge;
mod moment;
mod open;
mod prices;
mod quality;
mod reference;
mod render;
mod spheres;
mod stamp;
mod stats;
mod teller;
mod trade;
mod whole_mesh;

use crate::args::{Command, parse};
use crate::failure::Failure;
use std::process::ExitCode;

fn run() -> Result<(), Failure> {
    let Some(command) = parse()? else { return Ok(()) };
    environment::prepare(&command);
    console::catch_interrupts()?;
    match command {
        Command::Render(args) => render::run(&args),
        Command::View(args) => open::run(&args),
        Command::Reference(args) => reference::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Merge(args) => merge::run(&args),
        Command::Bake(args) => baking::run(&args),
        Command::Spheres(args) => spheres::run(&args),
        Command::Trade(args) => trade::run(&args),
        Command::Figures(args) => figures::run(&args),
    }
}

fn main() -> ExitCode {
    match run().and_then(|()| console::all_said()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
