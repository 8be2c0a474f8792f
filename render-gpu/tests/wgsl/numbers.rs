//! Numbers that Rust has come from Rust.

use std::fs;
use std::path::{Path, PathBuf};

/// Numbers of f32 on another path than the CPU's, which has none for them.
const OWN: [&str; 6] =
    ["MAP_EMPTY", "SILHOUETTES_ROUNDING", "SHAFT_SLACK", "SHAFT_NEARLY", "BOUNDS_EVERYTHING", "NEVER"];

fn texts(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()) {
        if entry.is_dir() {
            texts(&entry, found);
        } else if entry.extension().is_some_and(|extension| extension == "wgsl") {
            found.push(entry);
        }
    }
}

/// A text declares no real number and no table: [`wgsl_numbers!`](lobe_core::wgsl_numbers) does, by the constants of Rust.
#[test]
fn no_text_declares_a_real_number_of_its_own() {
    let workspace = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    let mut files = Vec::new();
    for entry in fs::read_dir(workspace).expect("a folder").map(|entry| entry.expect("an entry").path().join("src")) {
        if entry.is_dir() {
            texts(&entry, &mut files);
        }
    }
    assert!(files.len() > 60, "{} texts", files.len());
    let mut own = Vec::new();
    for file in &files {
        let text = fs::read_to_string(file).expect("a text");
        let constants = text.lines().filter_map(|line| line.trim().strip_prefix("const ")?.split_once(" = "));
        let is_number = |value: &str| value.starts_with(|c: char| c.is_ascii_digit() || c == '-');
        let is_real = |value: &str| is_number(value) && !value.starts_with("0x") && value.contains(['.', 'e', 'f']);
        let declared = constants.filter(|(_, value)| value.starts_with("array") || is_real(value));
        own.extend(declared.map(|(name, _)| name.to_owned()));
    }
    own.sort_unstable();
    let mut known = OWN.map(str::to_owned);
    known.sort_unstable();
    assert_eq!(own, known);
}
