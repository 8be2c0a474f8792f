//! The engine with WebGPU. It follows the leader as a helper does, and shades whole tasks; nothing in it waits.

#![expect(unreachable_pub, reason = "wasm-bindgen exports public functions alone")]

use crate::{PAGE, host};
use render_gpu::{Gpu, GpuError, GpuOptions};
use renderer::{Backend, RenderError};
use std::cell::RefCell;
use wasm_bindgen::prelude::wasm_bindgen;

thread_local! {
    static GPU: RefCell<Option<Gpu>> = const { RefCell::new(None) };
}

/// Opens the browser's GPU: before all other calls. Gives its name; an error is a line for the user.
#[wasm_bindgen]
pub async fn open_gpu() -> Result<String, String> {
    host::hear_panics();
    let gpu = Gpu::new(&GpuOptions::default()).await.map_err(|error| match error {
        // The message of the library names drivers, which no page can install.
        GpuError::NoAdapter { .. } => "the browser has no adapter for WebGPU".to_owned(),
        error => error.to_string(),
    })?;
    let name = gpu.name();
    GPU.set(Some(gpu));
    Ok(name)
}

/// As [`shade`](crate::shade). An error is a line for the user. No other call may come before it is done.
#[wasm_bindgen]
pub async fn shade_on_gpu(part: usize, of: usize) -> Result<(), String> {
    let mut page = PAGE.take();
    let done = page.shade_async(part, of).await;
    PAGE.set(page);
    done
}

/// Compiles the kernels for the scene that is open, so that the first task does not wait for them. An error is a line for the user.
#[wasm_bindgen]
pub async fn warm_up_gpu() -> Result<(), String> {
    let mut page = PAGE.take();
    let done = page.warm_up().await;
    PAGE.set(page);
    done
}

/// The device of new scenes.
pub(crate) fn backend() -> Result<Backend, RenderError> {
    GPU.with_borrow(|gpu| gpu.as_ref().map_or(Ok(Backend::Cpu), Backend::on))
}
