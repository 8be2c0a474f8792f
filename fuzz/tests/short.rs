//! Every target for two seconds, and all of the corpus.

use fuzz::{Source, TARGETS, Target};
use std::time::{Duration, Instant};

/// One of two tests, which run side by side.
fn run<'t>(targets: impl Iterator<Item = &'t Target>) {
    for target in targets {
        let seeds = target.seeds();
        for seed in &seeds {
            target.run(seed);
        }
        let mut source = Source::new(7, target.kind, seeds);
        let (start, mut count) = (Instant::now(), 0);
        while start.elapsed() < Duration::from_secs(2) || count == 0 {
            target.run(&source.input());
            count += 1;
        }
        println!("{}: {count}", target.name);
    }
}

#[test]
fn no_input_is_a_fault_to_targets_of_even_number() {
    run(TARGETS.iter().step_by(2));
}

#[test]
fn no_input_is_a_fault_to_targets_of_odd_number() {
    run(TARGETS.iter().skip(1).step_by(2));
}
