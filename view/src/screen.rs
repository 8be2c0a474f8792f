//! The window's own GPU: pictures that it makes are shown without a copy.

use cosine_lobes::Display;
use cosine_lobes::render_gpu::{Gpu, GpuDisplay, GpuPicture};
use cosine_lobes::renderer::Backend;
use eframe::NativeOptions;
use eframe::egui::{Context, TextureId};
use eframe::egui_wgpu::{RenderState, SurfaceConfig, WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use eframe::wgpu;
use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Storage buffers of a kernel that shading needs.
const BUFFERS: u32 = 8;

/// A device for the window on which pictures can be shaded as well, where its adapter has what that takes.
pub(crate) fn configuration() -> WgpuConfiguration {
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    let for_windows = Arc::clone(&setup.device_descriptor);
    setup.device_descriptor = Arc::new(move |adapter| {
        let own = for_windows(adapter);
        let can_compute = adapter.get_downlevel_capabilities().flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS);
        let (required_features, required_limits) = Gpu::requirements(adapter);
        if !can_compute || required_limits.max_storage_buffers_per_shader_stage < BUFFERS {
            return own;
        }
        wgpu::DeviceDescriptor { required_features, required_limits, ..own }
    });
    WgpuConfiguration { wgpu_setup: WgpuSetup::CreateNew(setup), ..NativeOptions::default().wgpu_options }
}

/// The window's GPU.
pub(crate) struct Screen {
    state: RenderState,
    gpu: Gpu,
    display: Arc<GpuDisplay>,
    /// The texture that the picture on the GPU has in the window.
    id: Option<TextureId>,
    /// Whether a change of the window's size was refused.
    is_refused: Arc<AtomicBool>,
}

impl Screen {
    /// The GPU of the window; none where it is a software driver, unless that is wanted: such a driver compiles kernels in the queue in which
    /// the frames of the window wait. Pictures of a GPU come from a device of their own then, and are copied, and so they do after an error,
    /// which is a line.
    pub(crate) fn new(state: &RenderState, context: &Context, takes_software: bool) -> Result<Option<Self>, String> {
        let gpu = Gpu::from_device(state.device.clone(), state.queue.clone());
        if gpu.is_software() && !takes_software {
            return Ok(None);
        }
        let line = |fault: String| format!("pictures of a GPU are copied: the window's device does not shade: {fault}");
        Backend::on(&gpu).map_err(|error| line(error.to_string()))?;
        let display = GpuDisplay::new(&gpu).map_err(|error| line(error.to_string()))?;
        let is_refused = Arc::new(AtomicBool::new(false));
        let (seen, waker) = (Arc::clone(&is_refused), context.clone());
        state.device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            if is_refusal(&error) {
                seen.store(true, Ordering::Release);
                waker.request_repaint();
            } else if !seen.load(Ordering::Acquire) {
                // As without a handler. After a refusal a frame may have the wrong size.
                panic!("wgpu error: {error}");
            }
        }));
        Ok(Some(Self { state: state.clone(), gpu, display: Arc::new(display), id: None, is_refused }))
    }

    /// Lets the window take its new size again if that was refused: wgpu refuses it where the session submits work at that moment. Another
    /// latency makes eframe do it before it draws.
    pub(crate) fn retry_size(&self, frame: &mut eframe::Frame) {
        if !self.is_refused.swap(false, Ordering::AcqRel) {
            return;
        }
        if let Some(config) = frame.wgpu_surface_config() {
            let latency = if config.desired_maximum_frame_latency == Some(1) { 2 } else { 1 };
            frame.set_wgpu_surface_config(SurfaceConfig { desired_maximum_frame_latency: Some(latency), ..config });
        }
    }

    pub(crate) const fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Makes textures of pictures.
    pub(crate) fn enlarger(&self) -> Enlarger {
        Enlarger(Arc::clone(&self.display))
    }

    /// The texture as the window draws it from now on.
    pub(crate) fn put(&mut self, texture: &wgpu::Texture) -> TextureId {
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let (mut renderer, filter) = (self.state.renderer.write(), wgpu::FilterMode::Linear);
        match self.id {
            Some(id) => {
                renderer.update_egui_texture_from_wgpu_texture(&self.state.device, &view, filter, id);
                id
            }
            None => *self.id.insert(renderer.register_native_texture(&self.state.device, &view, filter)),
        }
    }
}

/// Whether it refuses a size of the window because the queue does not come to rest.
fn is_refusal(error: &wgpu::Error) -> bool {
    use wgpu::wgc::present::ConfigureSurfaceError::GpuWaitTimeout;
    let mut cause = error.source();
    while let Some(error) = cause {
        if matches!(error.downcast_ref(), Some(GpuWaitTimeout)) {
            return true;
        }
        cause = error.source();
    }
    false
}

/// Turns pictures on the window's GPU into textures, on any thread.
#[derive(Clone, Debug)]
pub(crate) struct Enlarger(Arc<GpuDisplay>);

impl Enlarger {
    /// None for a picture of another device, and where the device refuses.
    pub(crate) fn show(&self, picture: &GpuPicture, display: &Display) -> Option<wgpu::Texture> {
        let is_own = picture.gpu().device() == self.0.gpu().device();
        is_own.then(|| self.0.show(picture, display).ok()).flatten()
    }
}
