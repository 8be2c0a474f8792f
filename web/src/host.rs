//! Functions that the page lends.

use std::sync::Once;

// SAFETY: the page gives both when it instantiates the module. They take numbers alone; `complain` reads the text that it is given.
#[link(wasm_import_module = "page")]
unsafe extern "C" {
    /// Seconds since any moment.
    safe fn now() -> f64;
    /// Passes a line of UTF-8 text on.
    safe fn complain(text: *const u8, length: usize);
}

/// Seconds since any moment.
pub(crate) fn clock() -> f64 {
    now()
}

/// Sets the clock, and lets panics say why, once.
pub(crate) fn hear_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        scene::set_clock(|| now());
        std::panic::set_hook(Box::new(|panic| {
            let text = panic.to_string();
            complain(text.as_ptr(), text.len());
        }));
    });
}
