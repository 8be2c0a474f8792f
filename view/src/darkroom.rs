//! Turns pictures into colours for the screen, on a thread of its own.

use crate::false_color;
use crate::screen::Enlarger;
use crate::viewing::{View, Viewing};
use cosine_lobes::session::{Picture, Truth};
use cosine_lobes::{
    Comparison, Display, Picture as Pixels, ShadowErrors, Window, glam::Vec3, luminance, signed_difference,
};
use eframe::egui::{ColorImage, Context};
use eframe::wgpu;
use std::borrow::Cow;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

/// The difference has its full colour at this part of white.
const FULL_DIFFERENCE: f64 = 0.05;

/// A request for a print.
#[derive(Clone, Debug)]
pub(crate) struct Order {
    pub(crate) picture: Arc<Picture>,
    pub(crate) truth: Arc<Truth>,
    /// The pixels in which outlines were found, where they are looked at and there.
    pub(crate) crossed: Option<Arc<Vec<u32>>>,
    pub(crate) viewing: Viewing,
}

impl Order {
    fn is(&self, other: &Self) -> bool {
        let is_same = self.crossed.as_ref().map(Arc::as_ptr) == other.crossed.as_ref().map(Arc::as_ptr);
        is_same
            && Arc::ptr_eq(&self.picture, &other.picture)
            && Arc::ptr_eq(&self.truth, &other.truth)
            && self.viewing == other.viewing
    }
}

/// A picture for the screen.
#[derive(Clone, Debug)]
pub(crate) struct Print {
    /// The picture that it shows: the session may have made a newer one since.
    pub(crate) picture: Arc<Picture>,
    pub(crate) image: Sheet,
    /// The reference beside it, where that is to be seen and is there.
    pub(crate) reference: Option<Arc<ColorImage>>,
    pub(crate) figures: Option<Figures>,
}

/// Pixels for the screen.
#[derive(Clone, Debug)]
pub(crate) enum Sheet {
    /// On the CPU, for the window to upload.
    Uploaded(Arc<ColorImage>),
    /// On the window's GPU.
    OnGpu(wgpu::Texture),
}

/// How far the picture is from the reference.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Figures {
    pub(crate) samples: u32,
    pub(crate) all: Comparison,
    pub(crate) shadows: ShadowErrors,
}

#[derive(Debug, Default)]
struct State {
    order: Option<Order>,
    print: Option<Print>,
    is_over: bool,
}

#[derive(Debug, Default)]
struct Shared {
    state: Mutex<State>,
    is_newer: Condvar,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The thread.
#[derive(Debug)]
pub(crate) struct Darkroom {
    shared: Arc<Shared>,
    last: Option<Order>,
}

impl Darkroom {
    pub(crate) fn new(context: &Context, enlarger: Option<Enlarger>) -> Self {
        let shared = Arc::new(Shared::default());
        let (theirs, context) = (Arc::clone(&shared), context.clone());
        thread::spawn(move || {
            // A thread of its own: those of the renderer may be busy with a long picture.
            let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
            while let Some(order) = next(&theirs) {
                let print = match &pool {
                    Ok(pool) => pool.install(|| develop(&order, enlarger.as_ref())),
                    Err(_) => develop(&order, enlarger.as_ref()),
                };
                theirs.lock().print = Some(print);
                context.request_repaint();
            }
        });
        Self { shared, last: None }
    }

    /// Orders a print, unless it is the one that was ordered last; an older order that was not begun is dropped.
    pub(crate) fn order(&mut self, order: Order) {
        if self.last.as_ref().is_none_or(|last| !last.is(&order)) {
            self.last = Some(order.clone());
            self.shared.lock().order = Some(order);
            self.shared.is_newer.notify_one();
        }
    }

    /// The newest print, once.
    pub(crate) fn take(&self) -> Option<Print> {
        self.shared.lock().print.take()
    }
}

impl Drop for Darkroom {
    fn drop(&mut self) {
        self.shared.lock().is_over = true;
        self.shared.is_newer.notify_one();
    }
}

fn next(shared: &Shared) -> Option<Order> {
    let mut state = shared.lock();
    loop {
        if state.is_over {
            return None;
        }
        if let Some(order) = state.order.take() {
            return Some(order);
        }
        state = shared.is_newer.wait(state).unwrap_or_else(PoisonError::into_inner);
    }
}

fn develop(order: &Order, enlarger: Option<&Enlarger>) -> Print {
    let Order { picture, truth, crossed, viewing } = order;
    // One that shows an older scene, or other pixels, is none of this picture.
    let truth = (truth.edits >= picture.seen && truth.size == picture.size && truth.samples > 0).then_some(truth);
    let reference =
        truth.filter(|_| viewing.split.is_some()).map(|truth| photo(truth.size, &truth.radiance, viewing.display));
    let figures = truth.filter(|_| viewing.wants_reference()).and_then(|truth| figures(picture, truth));
    let beside = Beside { truth: truth.map(|truth| &**truth), crossed: crossed.as_deref() };
    let image = sheet(picture, &beside, viewing, enlarger);
    Print { picture: Arc::clone(picture), image, reference, figures }
}

/// All that views show beside the picture.
struct Beside<'a> {
    truth: Option<&'a Truth>,
    crossed: Option<&'a Vec<u32>>,
}

/// The pixels of a view. A picture on the window's GPU stays there where it is shown as it is.
fn sheet(picture: &Picture, beside: &Beside<'_>, viewing: &Viewing, enlarger: Option<&Enlarger>) -> Sheet {
    let on_gpu = || enlarger?.show(picture.on_gpu.as_ref()?, &viewing.display);
    match image(picture, beside, viewing) {
        Some(image) => Sheet::Uploaded(image),
        None => on_gpu()
            .map_or_else(|| Sheet::Uploaded(photo(picture.size, &radiance(picture), viewing.display)), Sheet::OnGpu),
    }
}

/// The radiance of a picture; black where its GPU is lost.
fn radiance(picture: &Picture) -> Cow<'_, [Vec3]> {
    let none = || vec![Vec3::ZERO; picture.size[0] * picture.size[1]].into();
    picture.pixels().map_or_else(|_| none(), Cow::Borrowed)
}

/// The pixels of a view; none where it shows the picture itself.
fn image(picture: &Picture, beside: &Beside<'_>, viewing: &Viewing) -> Option<Arc<ColorImage>> {
    let layers = &picture.layers;
    let whole = picture.size[0] * picture.size[1];
    let colors = match viewing.view {
        View::Reference => match beside.truth {
            Some(truth) => return Some(photo(truth.size, &truth.radiance, viewing.display)),
            None => Vec::new(),
        },
        View::Difference => return Some(difference(picture, beside.truth, viewing.display)),
        View::Unshadowed if layers.unshadowed.len() == whole => {
            return Some(photo(picture.size, &layers.unshadowed, viewing.display));
        }
        View::Light(number) => match layers.lights.get(number).filter(|light| light.len() == whole) {
            Some(light) => return Some(photo(picture.size, light, viewing.display)),
            None => Vec::new(),
        },
        View::Classes => false_color::classes(&picture.radiance, &layers.unshadowed),
        View::Normals => false_color::normals(&layers.normals),
        View::Depth => false_color::depths(&layers.depths),
        View::Objects => false_color::objects(&layers.objects),
        View::Edges => beside.crossed.map(|found| false_color::edges(found)).unwrap_or_default(),
        View::Work => false_color::counts(&layers.products),
        View::Lobes => false_color::counts(&layers.lobes),
        View::Picture | View::Unshadowed => Vec::new(),
    };
    // Layers come with the next picture.
    (colors.len() == whole).then(|| Arc::new(ColorImage::from_rgb(picture.size, colors.as_flattened())))
}

/// As PNG files show it.
fn photo(size: [usize; 2], radiance: &[Vec3], display: Display) -> Arc<ColorImage> {
    Arc::new(ColorImage::from_rgb(size, &display.bytes(radiance, &Window::whole(size[0], size[1]))))
}

fn difference(picture: &Picture, truth: Option<&Truth>, display: Display) -> Arc<ColorImage> {
    let white = f64::from(-display.exposure).exp2();
    let colors = truth.and_then(|truth| {
        signed_difference(
            &pixels(picture.size, &radiance(picture)),
            &pixels(truth.size, &truth.radiance),
            FULL_DIFFERENCE * white,
        )
        .ok()
    });
    match colors {
        Some(colors) => Arc::new(ColorImage::from_rgb(picture.size, &colors)),
        None => {
            // Paler than the picture, so that it is not taken for it.
            let pale = |p: &Vec3| Vec3::splat((0.3 * luminance(*p)) as f32);
            let grey: Vec<Vec3> = radiance(picture).iter().map(pale).collect();
            photo(picture.size, &grey, display)
        }
    }
}

fn figures(picture: &Picture, truth: &Truth) -> Option<Figures> {
    let test = pixels(picture.size, &radiance(picture));
    let (reference, unshadowed) = (pixels(truth.size, &truth.radiance), pixels(truth.size, &truth.unshadowed));
    let all = Comparison::of(&test, &reference).ok()?;
    let shadows = ShadowErrors::of(&test, &reference, &unshadowed).ok()?;
    Some(Figures { samples: truth.samples, all, shadows })
}

fn pixels(size: [usize; 2], radiance: &[Vec3]) -> Pixels {
    Pixels::new(size[0], size[1], radiance.to_vec())
}
