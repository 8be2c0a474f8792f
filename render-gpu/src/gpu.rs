use crate::kernel::KernelCache;
use crate::{GpuError, KernelLog};
use shading::gpu::GpuPages;
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Storage buffers that a kernel may have on every adapter.
const STORAGE_BUFFERS: u32 = 8;

/// The most storage buffers that a kernel has beside one in pages: 4 of points and results, 3 of another strategy, 2 of rays, the
/// paper's tables, and on software devices the light's.
const BESIDE_PAGES: u32 = 11;

/// How long another thread that waits for the same device may take to pass on a result.
const TELLING: Duration = Duration::from_secs(10);

/// Which adapter to use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GpuOptions {
    /// Use only a software implementation.
    pub software: bool,
}

/// A GPU: device, queue, name and compiled kernels. Cheap to clone; several may exist at once. All shaders of a device share its
/// compiled kernels, which are kept until its last clone is dropped.
///
/// ```no_run
/// let gpu = render_gpu::Gpu::blocking(&render_gpu::GpuOptions::default())?;
/// println!("{}", gpu.name());
/// # Ok::<(), render_gpu::GpuError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    lost: Arc<Mutex<Option<String>>>,
    kernels: KernelLog,
    compiled: KernelCache,
}

impl Gpu {
    /// Opens the strongest adapter. The environment variable `WGPU_BACKEND` chooses the backend.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`], [`GpuError::NoDevice`].
    pub async fn new(options: &GpuOptions) -> Result<Self, GpuError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let wanted = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            force_fallback_adapter: options.software,
            ..Default::default()
        };
        let adapter = instance.request_adapter(&wanted).await;
        let adapter = adapter.map_err(|error| GpuError::NoAdapter { reason: error.to_string() })?;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("render-gpu"),
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            // All that the adapter has: each frame's needs are checked against it.
            required_limits: adapter.limits(),
            ..Default::default()
        };
        let (device, queue) = adapter
            .request_device(&descriptor)
            .await
            .map_err(|error| GpuError::NoDevice { adapter: adapter.get_info().name, reason: error.to_string() })?;
        let gpu = Self::from_device(device, queue);
        let lost = Arc::clone(&gpu.lost);
        gpu.device.set_device_lost_callback(move |reason, message| {
            if let Ok(mut lost) = lost.lock() {
                *lost = Some(if message.is_empty() { format!("{reason:?}") } else { message });
            }
        });
        Ok(gpu)
    }

    /// As [`new`](Self::new), but waits.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn blocking(options: &GpuOptions) -> Result<Self, GpuError> {
        pollster::block_on(Self::new(options))
    }

    /// Uses a caller's device and queue. No feature beyond compute shaders is needed; with `TIMESTAMP_QUERY` stages are timed. The
    /// caller keeps its own callbacks for a lost device.
    #[must_use]
    pub fn from_device(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        Self { device, queue, lost: Arc::default(), kernels: KernelLog::default(), compiled: KernelCache::default() }
    }

    /// The device.
    #[must_use]
    pub const fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// The queue.
    #[must_use]
    pub const fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// Name of the adapter.
    #[must_use]
    pub fn name(&self) -> String {
        self.device.adapter_info().name
    }

    /// Whether the device runs on the CPU: its pictures are right, but slower than those of the CPU's own path.
    #[must_use]
    pub fn is_software(&self) -> bool {
        self.device.adapter_info().device_type == wgpu::DeviceType::Cpu
    }

    /// The kernels that were compiled for this device, and those that are being compiled.
    #[must_use]
    pub const fn kernels(&self) -> &KernelLog {
        &self.kernels
    }

    /// The compiled kernels: a text is compiled once for all shaders of the device.
    pub(crate) const fn kernel_cache(&self) -> &KernelCache {
        &self.compiled
    }

    /// The most bytes that a buffer in [pages](shading::gpu::GpuContents::Pages), such as shadow maps, may have for kernels to
    /// read it. Assumes that a kernel's other buffers are as many as they can be.
    #[must_use]
    pub fn room_for_pages(&self) -> u64 {
        let limits = self.device.limits();
        let pages = limits.max_storage_buffers_per_shader_stage.saturating_sub(BESIDE_PAGES);
        GpuPages::room(pages, limits.max_storage_buffer_binding_size).min(limits.max_buffer_size)
    }

    /// Refuses a device that no kernel runs on.
    pub(crate) fn check(&self) -> Result<(), GpuError> {
        let allowed = self.device.limits().max_storage_buffers_per_shader_stage;
        if allowed < STORAGE_BUFFERS {
            let (needed, allowed) = (STORAGE_BUFFERS.into(), allowed.into());
            return Err(GpuError::Limits { what: "a kernel's storage buffers", needed, allowed });
        }
        Ok(())
    }

    /// Runs `work`, and returns the device's errors as a result.
    pub(crate) fn scoped<T>(&self, what: &'static str, work: impl FnOnce() -> T) -> Result<T, GpuError> {
        use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
        let scopes = [Validation, OutOfMemory, Internal].map(|filter| self.device.push_error_scope(filter));
        let value = work();
        // Innermost first.
        let [validation, memory, internal] = scopes;
        let internal = pollster::block_on(internal.pop());
        let memory = pollster::block_on(memory.pop());
        let validation = pollster::block_on(validation.pop());
        match internal.or(memory).or(validation) {
            None => Ok(value),
            Some(error) => Err(self.explain(what, &error)),
        }
    }

    fn explain(&self, what: &'static str, error: &wgpu::Error) -> GpuError {
        // The device reports a loss only when it is polled.
        let _ = self.device.poll(wgpu::PollType::Poll);
        if let Some(reason) = self.lost() {
            return GpuError::Lost { reason };
        }
        let chain = core::iter::successors(Some(error as &dyn core::error::Error), |error| error.source());
        let reason = chain.last().map_or_else(|| error.to_string(), ToString::to_string);
        match error {
            wgpu::Error::OutOfMemory { .. } => GpuError::OutOfMemory,
            // On a caller's device the callback for losses is the caller's.
            _ if reason.contains("device is lost") => GpuError::Lost { reason },
            _ => GpuError::Refused { what, reason: error.to_string() },
        }
    }

    /// Waits until all submitted work is done.
    pub(crate) fn wait(&self) -> Result<(), GpuError> {
        let lost = |error: wgpu::PollError| GpuError::Lost { reason: self.lost().unwrap_or(error.to_string()) };
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(lost)?;
        Ok(())
    }

    /// The known cause of the device's loss, if it is lost.
    pub(crate) fn lost(&self) -> Option<String> {
        self.lost.lock().ok().and_then(|lost| lost.clone())
    }

    /// Waits for the bytes that were copied to a read-back buffer.
    pub(crate) fn read(&self, staging: &wgpu::Buffer, bytes: u64, take: impl FnOnce(&[u8])) -> Result<(), GpuError> {
        let lost = |reason: String| GpuError::Lost { reason: self.lost().unwrap_or(reason) };
        let (sender, receiver) = std::sync::mpsc::channel();
        self.scoped("a read-back", || {
            staging.slice(..bytes).map_async(wgpu::MapMode::Read, move |result| {
                // The receiver is gone if waiting has failed.
                let _ = sender.send(result);
            });
        })?;
        self.wait()?;
        // Another thread that waits for this device may be the one that passes on the result.
        match receiver.recv_timeout(TELLING) {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(lost(error.to_string())),
            Err(error) => return Err(lost(error.to_string())),
        }
        let view = staging.slice(..bytes).get_mapped_range().map_err(|error| lost(error.to_string()))?;
        take(&view);
        drop(view);
        staging.unmap();
        Ok(())
    }
}
