//! WGSL as naga reads it, for the tests of this crate.

use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};

/// Validates a text against the limits of every device.
#[track_caller]
pub(crate) fn module(text: &str) -> naga::Module {
    with_info("pieces", text, Capabilities::default()).0
}

/// Validates a text; also returns naga's analysis of it.
#[track_caller]
pub(crate) fn with_info(name: &str, text: &str, capabilities: Capabilities) -> (naga::Module, ModuleInfo) {
    let module = naga::front::wgsl::parse_str(text).unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string(text)));
    let checked = Validator::new(ValidationFlags::all(), capabilities).validate(&module);
    let info = checked.unwrap_or_else(|e| panic!("{name}: {}", e.emit_to_string(text)));
    (module, info)
}
