//! The `lobes` command.
fn main() {}
