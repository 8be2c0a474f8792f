//! The WGSL of masks without a GPU: every variant validates.

use lighting::wgsl;
use lobe_core::wgsl::{GEOMETRY, LOBE, SPECIAL};
use naga::valid::{Capabilities, ValidationFlags, Validator};

/// Parses and validates pieces joined.
fn validate(pieces: &[&str]) {
    let text = pieces.join("\n");
    let module = naga::front::wgsl::parse_str(&text).unwrap_or_else(|error| panic!("{}", error.emit_to_string(&text)));
    if let Err(error) = Validator::new(ValidationFlags::all(), Capabilities::default()).validate(&module) {
        panic!("{}", error.emit_to_string(&text));
    }
}

/// All depths and widths.
fn headers() -> impl Iterator<Item = String> {
    (1..=lighting::MAX_DEPTH).flat_map(|depth| [false, true].map(|coarse| wgsl::header(depth, coarse)))
}

#[test]
fn pieces_validate() {
    validate(&[wgsl::SQUARE, GEOMETRY, LOBE, SPECIAL]);
    validate(&[wgsl::EDGES, GEOMETRY]);
    for header in headers() {
        validate(&[&header, wgsl::MASK, wgsl::SQUARE, GEOMETRY, LOBE, SPECIAL]);
    }
}
