use cosine_lobes::render_gpu::Gpu;
use cosine_lobes::renderer::{Backend, Device, PixelSamples, RenderError, Renderer, Settings};
use cosine_lobes::scene::{self, Animation};
use cosine_lobes::session::Session;
use eframe::egui::Context;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver, TryRecvError};
use std::thread;

/// A scene that is open.
#[derive(Debug)]
pub(crate) struct Opened {
    pub(crate) session: Session,
    /// None: the built-in scene.
    pub(crate) path: Option<PathBuf>,
    /// The exposure, in stops, that shows it well.
    pub(crate) exposure: f32,
    /// The first warning, and how many there are.
    pub(crate) warning: Option<String>,
}

/// The devices that may shade.
#[derive(Clone, Debug, Default)]
pub(crate) struct Devices {
    /// The window's GPU, where it can.
    pub(crate) gpu: Option<Gpu>,
    /// The one that does at first.
    pub(crate) first: Device,
}

impl Devices {
    fn open(&self) -> Result<Backend, RenderError> {
        match (self.first, &self.gpu) {
            (Device::Gpu, Some(gpu)) => Backend::on(gpu),
            (first, _) => Backend::open(first),
        }
    }
}

/// A file that is being opened on a thread of its own.
#[derive(Debug)]
pub(crate) struct Opening {
    name: String,
    received: Receiver<Result<Opened, String>>,
}

impl Opening {
    /// Begins to open a file, or the built-in scene.
    pub(crate) fn new(path: Option<PathBuf>, context: &Context, devices: Devices) -> Self {
        let name = path.as_deref().map_or_else(|| "the built-in scene".to_owned(), name_of);
        let (send, received) = mpsc::channel();
        let context = context.clone();
        thread::spawn(move || {
            // Who no longer waits needs no scene.
            let _ = send.send(open(path, &context, &devices));
            context.request_repaint();
        });
        Self { name, received }
    }

    /// Its name, for people.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// The scene, once it is there.
    pub(crate) fn take(&self) -> Option<Result<Opened, String>> {
        match self.received.try_recv() {
            Ok(opened) => Some(opened),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Err(format!("{}: reading it failed", self.name))),
        }
    }
}

/// The name of a file without its folder.
pub(crate) fn name_of(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned())
}

fn open(path: Option<PathBuf>, context: &Context, devices: &Devices) -> Result<Opened, String> {
    let (scene, animation, warnings) = match &path {
        None => (scene::builtin(), Animation::default(), Vec::new()),
        Some(path) => scene::load_animated(path).map_err(|error| error.to_string())?,
    };
    let cache = dirs::cache_dir().map(|folder| folder.join("cosine-lobes"));
    // As `lobes render` draws it.
    let settings = Settings { cache, samples: PixelSamples::Edges(8), ..Settings::default() };
    let made = devices.open().and_then(|backend| Renderer::with_backend(scene, animation, settings, backend));
    let mut renderer = made.map_err(|error| error.to_string())?;
    renderer.use_gpu(devices.gpu.clone());
    let exposure = renderer.exposure();
    let session = Session::new(renderer);
    session.set_on_gpu(devices.gpu.is_some());
    let waker = context.clone();
    session.set_listener(move || waker.request_repaint());
    let more = warnings.len().saturating_sub(1);
    let warning = warnings.into_iter().next();
    let warning = warning.map(|line| if more > 0 { format!("{line} (and {more} more)") } else { line });
    Ok(Opened { session, path, exposure, warning })
}
