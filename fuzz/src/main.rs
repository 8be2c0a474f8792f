//! Runs the fuzz targets with random inputs, the same for the same seed.
//!
//! ```text
//! fuzz [TARGET…] [--seconds N] [--seed N]   every target, or these, for so long each (3 s)
//! fuzz --inputs TARGET FILE…                one target on files
//! fuzz --products N --oracle N              N products against their bounds, N against quadrature in f64
//! fuzz --costs N                            N small files of each kind in which one thing stands for many: time and memory
//! ```
//!
//! An input that fails is kept as `TARGET.failed` in the working folder; the exit code is 1 then.

mod cost;
mod growth;
mod products;

use fuzz::{Source, TARGETS, Target};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Longer than this for one input is a fault, on a busy machine without optimisation.
const SLOW: Duration = Duration::from_secs(120);

struct Options {
    targets: Vec<String>,
    seconds: f64,
    seed: u64,
    products: u64,
    oracle: u64,
    costs: u64,
}

fn parse() -> Result<Options, String> {
    let mut options = Options { targets: Vec::new(), seconds: 3.0, seed: 1, products: 0, oracle: 0, costs: 0 };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut number = || {
            let text = words.next().ok_or(format!("{word} needs a number"))?;
            text.parse::<f64>().map_err(|_| format!("{word}: {text} is no number"))
        };
        match word.as_str() {
            "--seconds" => options.seconds = number()?,
            "--seed" => options.seed = number()? as u64,
            "--products" => options.products = number()? as u64,
            "--oracle" => options.oracle = number()? as u64,
            "--costs" => options.costs = number()? as u64,
            name if TARGETS.iter().any(|t| t.name == name) => options.targets.push(word),
            other => {
                let all: Vec<&str> = TARGETS.iter().map(|t| t.name).collect();
                return Err(format!("{other} is no target: expected one of {}", all.join(", ")));
            }
        }
    }
    Ok(options)
}

/// Runs one target for a time; whether no input failed.
fn fuzz(target: &Target, seconds: f64, seed: u64) -> bool {
    let seeds = target.seeds();
    let mut source = Source::new(seed, target.kind, seeds.clone());
    let (start, mut count, mut slowest) = (Instant::now(), 0_u64, Duration::ZERO);
    let mut inputs = seeds.into_iter();
    while start.elapsed().as_secs_f64() < seconds || count == 0 {
        let input = inputs.next().unwrap_or_else(|| source.input());
        let begin = Instant::now();
        let sound = catch_unwind(AssertUnwindSafe(|| target.run(&input))).is_ok();
        let time = begin.elapsed();
        slowest = slowest.max(time);
        count += 1;
        if !sound || time > SLOW {
            let file = format!("{}.failed", target.name);
            let kept = if std::fs::write(&file, &input).is_ok() { file } else { "nowhere".to_owned() };
            println!("{}: input {count} failed after {time:.1?}, kept in {kept}", target.name);
            return false;
        }
    }
    println!("| {} | {count} | {:.1} ms |", target.name, slowest.as_secs_f64() * 1e3);
    true
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [word, file] = &arguments[..]
        && word == "--open"
    {
        cost::open(file);
        return ExitCode::SUCCESS;
    }
    if let [word, name, files @ ..] = &arguments[..]
        && word == "--inputs"
    {
        for file in files {
            match std::fs::read(file) {
                Ok(data) => fuzz::run(name, &data),
                Err(error) => {
                    eprintln!("{file}: {error}");
                    return ExitCode::FAILURE;
                }
            }
        }
        return ExitCode::SUCCESS;
    }
    let options = match parse() {
        Ok(options) => options,
        Err(message) => {
            eprintln!("{message}");
            return ExitCode::FAILURE;
        }
    };
    if options.products + options.oracle > 0 {
        return if products::run(options.seed, options.products, options.oracle) {
            ExitCode::SUCCESS
        } else {
            ExitCode::FAILURE
        };
    }
    if options.costs > 0 {
        let program = std::env::current_exe().unwrap_or_else(|_| "fuzz".into());
        return if cost::run(&program, options.seed, options.costs) { ExitCode::SUCCESS } else { ExitCode::FAILURE };
    }
    println!("| target | inputs | slowest |\n|---|---|---|");
    let wanted = |t: &&Target| options.targets.is_empty() || options.targets.iter().any(|name| name == t.name);
    let failed = TARGETS.iter().filter(wanted).filter(|t| !fuzz(t, options.seconds, options.seed)).count();
    if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
