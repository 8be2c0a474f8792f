//! The window of lobes: drag a light, see its shadow follow, and see why. `lobes view` starts it.

mod animation;
mod app;
mod args;
mod darkroom;
mod desk;
mod false_color;
mod inspector;
mod map_window;
mod opening;
mod panel;
mod reflectance;
mod screen;
mod shot;
mod smoke;
mod stage;
mod status;
mod trade;
mod viewing;

use std::process::ExitCode;

fn main() -> ExitCode {
    let args = match args::parse(std::env::args_os().skip(1)) {
        Ok(Some(args)) => args,
        Ok(None) => {
            println!("{}", args::HELP);
            return ExitCode::SUCCESS;
        }
        Err(line) => return fail(&line),
    };
    match app::run(args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(line) => fail(&line),
    }
}

fn fail(line: &str) -> ExitCode {
    // A driver's message may have several lines.
    let line = line.split_whitespace().collect::<Vec<_>>().join(" ");
    eprintln!("lobes-view: error: {line}");
    ExitCode::from(2)
}
