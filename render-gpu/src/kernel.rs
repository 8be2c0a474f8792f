//! Compiled kernels, and the cache of them that each device has.

mod compile;

use crate::GpuError;
use crate::binding::{Binding, Slot};
use crate::module::Text;
use crate::pipeline::Pipeline;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// The compiled kernels of a device, by their sources. Clones share them.
#[derive(Clone, Debug, Default)]
pub(crate) struct KernelCache {
    kernels: Arc<Mutex<HashMap<Source, Entry>>>,
}

/// Entry point, text and bindings.
type Source = (&'static str, String, Vec<Binding>);
/// Locked while it is compiled, so that other threads wait instead of compiling the kernel again.
type Entry = Arc<Mutex<Option<Kernel>>>;

impl KernelCache {
    /// Returns the kernel of this text; compiles it if it is new. Errors are not kept.
    fn get(&self, text: &Text, compile: impl FnOnce() -> Result<Kernel, GpuError>) -> Result<Kernel, GpuError> {
        let source = (text.entry, text.text.clone(), text.bindings.clone());
        let entry = {
            let mut kernels = self.kernels.lock().unwrap_or_else(PoisonError::into_inner);
            Arc::clone(kernels.entry(source).or_default())
        };
        let mut kernel = entry.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = &*kernel {
            return Ok(known.clone());
        }
        Ok(kernel.insert(compile()?).clone())
    }
}

/// One compiled entry point and its list of buffers. Clones are the same kernel.
#[derive(Clone, Debug)]
pub(crate) struct Kernel {
    pipeline: Pipeline,
    slots: Vec<Slot>,
}

impl Kernel {
    /// Whether the kernel reads the frame, whose slot is chosen for each dispatch.
    pub(crate) fn has_frame(&self) -> bool {
        self.slots.contains(&Slot::Frame)
    }

    pub(crate) const fn pipeline(&self) -> &wgpu::ComputePipeline {
        self.pipeline.pipeline()
    }

    pub(crate) const fn label(&self) -> &'static str {
        self.pipeline.label()
    }
}
