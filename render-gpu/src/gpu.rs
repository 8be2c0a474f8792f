use crate::kernel::KernelCache;
use crate::mail::Mail;
use crate::scopes::Scopes;
use crate::{GpuError, KernelLog};
use core::ops::Range;
use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;
use shading::gpu::GpuPages;
use std::sync::{Arc, Mutex};

/// Storage buffers that a kernel may have on every adapter.
const STORAGE_BUFFERS: u32 = 8;

/// The most storage buffers that a kernel has beside one in pages: 4 of points and results, 3 of another strategy, 2 of rays, the
/// paper's tables, and on software devices the light's.
const BESIDE_PAGES: u32 = 11;

/// The shortest and the longest time between two looks at a device that other threads use.
const NAPS: Range<Duration> = Duration::from_micros(25)..Duration::from_micros(400);
/// How long it may nap beside a device that has nothing to do.
const MOST_IDLE: Duration = Duration::from_secs(2);

/// Features that are used where they are there. A browser's clock is too coarse for stages, and reading it takes another turn.
const FEATURES: wgpu::Features =
    if cfg!(target_arch = "wasm32") { wgpu::Features::empty() } else { wgpu::Features::TIMESTAMP_QUERY };

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
    /// Whether other threads may use the device.
    is_lent: bool,
    lost: Arc<Mutex<Option<String>>>,
    kernels: KernelLog,
    compiled: KernelCache,
    scopes: Scopes,
}

impl Gpu {
    /// Opens the strongest adapter. The environment variable `WGPU_BACKEND` chooses the backend; in a browser it is WebGPU.
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
        // All that the adapter has: each frame's needs are checked against it.
        let (required_features, required_limits) = Self::requirements(&adapter);
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("render-gpu"),
            required_features,
            required_limits,
            ..Default::default()
        };
        let (device, queue) = adapter
            .request_device(&descriptor)
            .await
            .map_err(|error| GpuError::NoDevice { adapter: adapter.get_info().name, reason: error.to_string() })?;
        let gpu = Self { is_lent: false, ..Self::from_device(device, queue) };
        let lost = Arc::clone(&gpu.lost);
        gpu.device.set_device_lost_callback(move |reason, message| {
            if let Ok(mut lost) = lost.lock() {
                *lost = Some(if message.is_empty() { format!("{reason:?}") } else { message });
            }
        });
        Ok(gpu)
    }

    /// As [`new`](Self::new), but waits. Not for browsers, where nothing may wait.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn blocking(options: &GpuOptions) -> Result<Self, GpuError> {
        pollster::block_on(Self::new(options))
    }

    /// Uses a caller's device and queue. No feature beyond compute shaders is needed; with `TIMESTAMP_QUERY` stages are timed. The
    /// caller keeps its own callbacks for a lost device. Other threads may submit to the queue at the same time, and present: no call of this
    /// crate keeps them waiting.
    #[must_use]
    pub fn from_device(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        Self {
            device,
            queue,
            is_lent: true,
            lost: Arc::default(),
            kernels: KernelLog::default(),
            compiled: KernelCache::default(),
            scopes: Scopes::default(),
        }
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

    /// Whether it may be Mesa's software driver, which needs kernels of a form of its own. A browser's software device is not.
    pub(crate) fn is_mesa_software(&self) -> bool {
        !cfg!(target_arch = "wasm32") && self.is_software()
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
    /// read it. Assumes that a kernel's other buffers are as many as they can be. A device with few buffers, as browsers have them, has
    /// room for one page; a kernel that needs more buffers is refused.
    #[must_use]
    pub fn room_for_pages(&self) -> u64 {
        let limits = self.device.limits();
        GpuPages::room(pages(limits.max_storage_buffers_per_shader_stage), limits.max_storage_buffer_binding_size)
            .min(limits.max_buffer_size)
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

    /// Runs `work`, and returns the device's errors as a result. In a browser they come later: from the next call, or from
    /// [`settle`](Self::settle).
    pub(crate) fn scoped<T>(&self, what: &'static str, work: impl FnOnce() -> T) -> Result<T, GpuError> {
        self.scopes.run(&self.device, what, work).map_err(|(what, error)| self.explain(what, &error))
    }

    /// Waits until it is known whether all work so far was accepted. Natively each call has returned its own errors, and this one
    /// returns at once. In a browser errors come in a later turn: who only submits awaits this now and then.
    ///
    /// # Errors
    /// That of the first refused piece of work.
    pub async fn settle(&self) -> Result<(), GpuError> {
        self.scopes.settle().await.map_err(|(what, error)| self.explain(what, &error))?;
        self.lost().map_or(Ok(()), |reason| Err(GpuError::Lost { reason }))
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

    /// The limits that kernels need of a device, and the features that are used where they are there: for programs that open a device for
    /// [`from_device`](Self::from_device).
    #[must_use]
    pub fn requirements(adapter: &wgpu::Adapter) -> (wgpu::Features, wgpu::Limits) {
        (adapter.features() & FEATURES, adapter.limits())
    }

    /// Waits until all submitted work is done. In a browser, which polls devices itself, returns at once.
    pub(crate) fn wait(&self) -> Result<(), GpuError> {
        if !self.is_lent {
            return self.wait_until(|| false);
        }
        let is_done = Arc::new(AtomicBool::new(false));
        let done = Arc::clone(&is_done);
        self.queue.on_submitted_work_done(move || done.store(true, Ordering::Release));
        self.wait_until(|| is_done.load(Ordering::Acquire))
    }

    /// Waits until all submitted work is done; on a caller's device until a callback has said so. wgpu keeps a lock while it waits, without
    /// which a window of the same device shows nothing, so that this thread sleeps instead. (With a timeout wgpu 30 panics where another
    /// thread polls at the same time.)
    fn wait_until(&self, is_done: impl Fn() -> bool) -> Result<(), GpuError> {
        let in_turns = self.is_lent && !cfg!(target_arch = "wasm32");
        let how = || if in_turns { wgpu::PollType::Poll } else { wgpu::PollType::wait_indefinitely() };
        let lost = |error: wgpu::PollError| GpuError::Lost { reason: self.lost().unwrap_or(error.to_string()) };
        let mut nap = NAPS.start;
        let mut idle = Duration::ZERO;
        loop {
            let status = self.device.poll(how()).map_err(lost)?;
            if !in_turns || is_done() {
                return Ok(());
            }
            // A device that is given up, as when its window closes, may never call back.
            idle = if status.is_queue_empty() { idle + nap } else { Duration::ZERO };
            if idle > MOST_IDLE {
                let reason = "all its work is done, and it does not say so".to_owned();
                return Err(GpuError::Lost { reason: self.lost().unwrap_or(reason) });
            }
            std::thread::sleep(nap);
            nap = (2 * nap).min(NAPS.end);
        }
    }

    /// The known cause of the device's loss, if it is lost.
    pub(crate) fn lost(&self) -> Option<String> {
        self.lost.lock().ok().and_then(|lost| lost.clone())
    }

    /// Waits for the bytes that were copied to a read-back buffer. Natively the thread waits, and the future is ready at its first
    /// poll; in a browser it is ready in a later turn.
    pub(crate) async fn read(
        &self,
        staging: &wgpu::Buffer,
        bytes: u64,
        take: impl FnOnce(&[u8]),
    ) -> Result<(), GpuError> {
        let lost = |reason: String| GpuError::Lost { reason: self.lost().unwrap_or(reason) };
        let mail = Mail::default();
        let sender = mail.clone();
        self.scoped("a read-back", || {
            staging.slice(..bytes).map_async(wgpu::MapMode::Read, move |result| sender.send(result));
        })?;
        self.wait_until(|| mail.is_there())?;
        let mapped = mail.received().await;
        // A refused command leaves old bytes.
        self.settle().await?;
        match mapped {
            Some(Ok(())) => {}
            Some(Err(error)) => return Err(lost(error.to_string())),
            None => return Err(lost("the device does not answer".to_owned())),
        }
        let view = staging.slice(..bytes).get_mapped_range().map_err(|error| lost(error.to_string()))?;
        take(&view);
        drop(view);
        staging.unmap();
        Ok(())
    }
}

/// The pages that a kernel may have on a device that allows so many storage buffers.
const fn pages(buffers: u32) -> u32 {
    let rest = buffers.saturating_sub(BESIDE_PAGES);
    if rest == 0 { 1 } else { rest }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn devices_with_few_buffers_have_a_page() {
        // The least that there is, browsers, desktop drivers, Mesa.
        assert_eq!([8, 10, 16, 32].map(pages), [1, 1, 5, 21]);
    }
}
