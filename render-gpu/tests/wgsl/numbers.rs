//! Numbers that Rust has come from Rust, those of bindings as well.

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

/// All texts of the workspace.
fn all() -> Vec<PathBuf> {
    let workspace = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    let mut files = Vec::new();
    for entry in fs::read_dir(workspace).expect("a folder").map(|entry| entry.expect("an entry").path().join("src")) {
        if entry.is_dir() {
            texts(&entry, &mut files);
        }
    }
    assert!(files.len() > 60, "{} texts", files.len());
    files
}

/// Kernels with a layout of their own: pictures that stay on the device, and the writer of textures.
const LAID_OUT: [&str; 3] = ["display.wgsl", "resolve.wgsl", "texture_writer.wgsl"];

/// The composer of a kernel declares its buffers: no text has the number of a binding.
#[test]
fn no_text_has_a_binding_of_its_own() {
    let has_binding = |file: &PathBuf| fs::read_to_string(file).expect("a text").contains("@binding");
    let found = all().into_iter().filter(has_binding);
    let mut names: Vec<_> = found.filter_map(|file| Some(file.file_name()?.to_owned())).collect();
    names.sort_unstable();
    assert_eq!(names, LAID_OUT);
}

/// A text declares no real number and no table: [`wgsl_numbers!`](lobe_core::wgsl_numbers) does, by the constants of Rust.
#[test]
fn no_text_declares_a_real_number_of_its_own() {
    let mut own = Vec::new();
    for file in &all() {
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
