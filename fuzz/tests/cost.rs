//! No small file takes much time or memory.

use std::process::Command;

/// A few inputs of each kind by the program, which measures each in a process of its own.
#[test]
fn small_files_take_little() {
    let output = Command::new(env!("CARGO_BIN_EXE_fuzz"))
        .args(["--costs", "2", "--seed", "5"])
        .output()
        .expect("the program runs");
    println!("{}", String::from_utf8_lossy(&output.stdout));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
}
