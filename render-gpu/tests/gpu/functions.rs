//! WGSL functions against the Rust ones that they mirror.

use crate::call::{call, trial};
use libtest_mimic::Trial;
use render_gpu::Gpu;

pub(crate) fn trials(gpu: Option<&Gpu>) -> Vec<Trial> {
    vec![trial("the_harness_calls", gpu, the_harness_calls)]
}

fn the_harness_calls(gpu: &Gpu) {
    let rows: Vec<f32> = (0..1000).map(|k| k as f32).collect();
    let got = call(gpu, &["fn twice(x: f32) -> f32 { return 2.0 * x; }"], "y(0, twice(x(0)) + x(1));", &rows, 2, 1);
    assert_eq!(got.len(), 500);
    assert!(got.iter().zip(rows.chunks(2)).all(|(got, row)| *got == 2.0 * row[0] + row[1]));
}
