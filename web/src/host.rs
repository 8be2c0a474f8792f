//! Functions that the page lends.

use std::sync::Once;

#[cfg(feature = "gpu")]
pub(crate) use crate::gpu::backend;
#[cfg(not(feature = "gpu"))]
pub(crate) use page::progress;

#[cfg(not(feature = "gpu"))]
mod page {
    // SAFETY: the page gives them when it instantiates the module. They take numbers alone; two read the text that they are given.
    #[link(wasm_import_module = "page")]
    unsafe extern "C" {
        /// Seconds since any moment.
        pub(super) safe fn now() -> f64;
        #[link_name = "complain"]
        safe fn complain_of(text: *const u8, length: usize);
        /// Whether the work is to stop.
        #[link_name = "progress"]
        safe fn progress_of(stage: *const u8, length: usize, done: f64) -> bool;
    }

    /// Passes a line of text on.
    pub(super) fn complain(text: &str) {
        complain_of(text.as_ptr(), text.len());
    }

    /// Reports the part of a stage that is done, in [0, 1]; whether the work goes on.
    pub(crate) fn progress(stage: &str, done: f64) -> bool {
        !progress_of(stage.as_ptr(), stage.len(), done)
    }
}

#[cfg(feature = "gpu")]
mod page {
    use wasm_bindgen::prelude::wasm_bindgen;

    #[wasm_bindgen(js_namespace = globalThis)]
    extern "C" {
        /// Passes a line of text on: the worker has such a function.
        pub(super) fn complain(text: &str);
    }

    #[wasm_bindgen(js_namespace = performance)]
    extern "C" {
        #[wasm_bindgen(js_name = now)]
        fn milliseconds() -> f64;
    }

    /// Seconds since any moment.
    pub(super) fn now() -> f64 {
        1e-3 * milliseconds()
    }
}

/// Seconds since any moment.
pub(crate) fn clock() -> f64 {
    page::now()
}

/// Sets the clock, and lets panics say why, once.
pub(crate) fn hear_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        scene::set_clock(clock);
        std::panic::set_hook(Box::new(|panic| page::complain(&panic.to_string())));
    });
}

/// The device of new scenes.
#[cfg(not(feature = "gpu"))]
pub(crate) fn backend() -> Result<renderer::Backend, renderer::RenderError> {
    Ok(renderer::Backend::Cpu)
}
