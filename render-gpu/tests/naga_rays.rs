//! The WGSL of rays without a GPU.

use lobe_core::wgsl::GEOMETRY;
use naga::valid::{Capabilities, ValidationFlags, Validator};
use render_gpu::wgsl::{BVH, TRACE};

fn validate(pieces: &[&str]) {
    let text = pieces.join("\n");
    let module = naga::front::wgsl::parse_str(&text).unwrap_or_else(|error| panic!("{}", error.emit_to_string(&text)));
    let checked = Validator::new(ValidationFlags::all(), Capabilities::default()).validate(&module);
    if let Err(error) = checked {
        panic!("{}", error.emit_to_string(&text));
    }
}

#[test]
fn visible_points_validate() {
    validate(&[BVH]);
    for stack in [32, 64, 1024] {
        validate(&[TRACE, &format!("const STACK = {stack}u;"), BVH, GEOMETRY]);
    }
}
