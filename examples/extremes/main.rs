//! Formulas, blockers, materials and scenes at their extremes, each beside its value in f64, as tables in Markdown; ends with code 1
//! if an error is beyond its stated limit: `cargo run --release --example extremes > docs/extremes.md`.

mod blockers;
mod forms;
mod materials;
mod scenes;
mod table;

use std::error::Error;
use std::process::ExitCode;
use table::Table;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    println!(
        "# Extremes\n\nFormulas, blockers, materials and scenes beside their values in f64: \
         `cargo run --release --example extremes`."
    );
    let mut table = Table { sound: true };
    blockers::visible(&mut table);
    materials::reflected(&mut table);
    scenes::same(&mut table)?;
    forms::products(&mut table);
    forms::powers(&mut table);
    forms::irradiances(&mut table);
    forms::caps(&mut table);
    Ok(if table.sound { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
