//! Every target for two seconds, and all of the corpus.

use fuzz::{Source, TARGETS};
use std::time::{Duration, Instant};

#[test]
fn no_input_is_a_fault() {
    let mut counts = Vec::new();
    for target in TARGETS {
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
        counts.push((target.name, count));
    }
    println!("{counts:?}");
}
