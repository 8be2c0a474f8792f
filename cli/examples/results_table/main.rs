//! The paper's scenes by count, timed: the cost of a frame, stage by stage, beside the paper's figures.
//!
//! `cargo run --release --example results_table [-- --repeats N] [--only WORD] [--pictures DIR] [-o FILE.md]`. Scenes are
//! made here, with the paper's numbers of points, spheres and lights; visible points are given, as in the paper. Sphere
//! sets are built once and kept beside the program.

mod blob;
mod counts;
#[path = "../../src/figures/measure.rs"]
mod measure;
mod models;
mod order;
mod rows;
mod scaling;
#[path = "../../src/figures/scenes.rs"]
mod scenes;
#[path = "../../src/figures/sets.rs"]
mod sets;
mod table;

use crate::models::Models;
use crate::scenes::Case;
use std::path::PathBuf;

struct Options {
    repeats: usize,
    only: String,
    pictures: Option<PathBuf>,
    output: Option<PathBuf>,
}

fn options() -> Result<Options, String> {
    let mut options = Options { repeats: 15, only: String::new(), pictures: None, output: None };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or_else(|| format!("{word}: a value is missing"));
        match word.as_str() {
            "--repeats" => options.repeats = value()?.parse().ok().filter(|n| *n > 0).ok_or("--repeats: a number")?,
            "--only" => options.only = value()?,
            "--pictures" => options.pictures = Some(value()?.into()),
            "-o" => options.output = Some(value()?.into()),
            _ => return Err(format!("{word}: expected --repeats N, --only WORD, --pictures DIR or -o FILE")),
        }
    }
    Ok(options)
}

fn run() -> Result<(), String> {
    let Options { repeats, only, pictures, output } = options()?;
    let wanted = |name: &str| name.to_lowercase().contains(&only.to_lowercase());
    let mut models = Models::new()?;
    let mut rows = Vec::new();
    for line in rows::all().into_iter().filter(|line| wanted(line.name)) {
        rows.push(rows::measure(line, &mut models, repeats, pictures.as_deref())?);
    }
    let curves: Vec<_> = scaling::all().into_iter().filter(|curve| wanted(curve.name)).collect();
    let curves = curves.into_iter().map(|curve| scaling::measure(curve, repeats)).collect::<Result<Vec<_>, _>>()?;
    let mut orders = Vec::new();
    if wanted("Order of points") {
        // Few spheres, and many.
        for (name, case) in [("Fig. 16", Case::fig16()), ("Fig. 22(a)", Case::fig22(0))] {
            orders.push(order::measure(name, &case, &mut models, repeats)?);
        }
    }
    let counts = if wanted("Sets by count") { counts::measure(&mut models, repeats)? } else { Vec::new() };
    let text = table::markdown(&rows, &curves, &orders, &counts);
    match output {
        Some(path) => std::fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display())),
        None => {
            print!("{text}");
            Ok(())
        }
    }
}

fn main() -> std::process::ExitCode {
    match run() {
        Ok(()) => std::process::ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("results_table: {message}");
            std::process::ExitCode::from(2)
        }
    }
}
