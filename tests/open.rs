//! The suites of the crate outside of the workspace, with the build of the workspace's tests. `.ci/run` checks that it also
//! builds alone.
#![allow(clippy::unwrap_used, reason = "in a test")]

#[path = "../examples/open/tests/suites.rs"]
mod suites;

fn main() {
    suites::main();
}
