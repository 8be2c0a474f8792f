//! The `lobes` command on a GPU, a software one at least: shown as ignored where there is none.
#![allow(clippy::unwrap_used, reason = "in a test")]

mod extremes;
mod parity;
mod pictures;
#[path = "../cli/support.rs"]
mod support;

use cosine_lobes::render_gpu::{Gpu, GpuOptions};
use libtest_mimic::{Arguments, Trial};

/// A test that is ignored where there is no GPU, and fails where it is made to run all the same.
fn trial(name: &str, there: bool, test: fn()) -> Trial {
    let run = move || {
        if !there {
            return Err("there is no GPU adapter".into());
        }
        test();
        Ok(())
    };
    Trial::test(name, run).with_ignored_flag(!there)
}

fn main() {
    let arguments = Arguments::from_args();
    let gpu = Gpu::blocking(&GpuOptions::default());
    if let Err(error) = &gpu {
        eprintln!("GPU tests are ignored: {error}");
    }
    let there = gpu.is_ok();
    let tests = [parity::tests(), pictures::tests(), extremes::tests()].concat();
    let trials = tests.into_iter().map(|(name, test)| trial(name, there, test)).collect();
    libtest_mimic::run(&arguments, trials).exit();
}

/// The names and functions of some tests.
type Tests = Vec<(&'static str, fn())>;

/// Tests by the names of their functions.
macro_rules! tests {
    ($($test:ident),* $(,)?) => {
        pub(crate) fn tests() -> crate::Tests {
            vec![$((stringify!($test), $test as fn())),*]
        }
    };
}
pub(crate) use tests;
