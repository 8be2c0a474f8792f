//! The suites of the crate outside of the workspace, with what the workspace's tests have built. `.ci/run` checks that it stands
//! alone as well.

#[path = "../examples/open/tests/suites.rs"]
mod suites;

fn main() {
    suites::main();
}
