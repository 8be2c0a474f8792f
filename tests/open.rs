//! The suites of the crate outside of the workspace, with what the workspace's tests have built. `.ci/run` checks that it stands
//! alone as well.
#![allow(clippy::unwrap_used, reason = "in a test")]

#[path = "../examples/open/tests/suites.rs"]
mod suites;

fn main() {
    suites::main();
}
