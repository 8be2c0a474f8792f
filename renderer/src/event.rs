use crate::{MapReduction, RenderError};
use core::ops::ControlFlow;
use scene::Cancel;
use shading::Accuracy;
use std::path::Path;
use visibility_shadowmap::MapAdvice;

/// An event during the work of a [`Renderer`](crate::Renderer).
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Event<'a> {
    /// Spheres are being fitted to an object; `done` is in [0, 1].
    Fitting {
        /// The object's name.
        object: &'a str,
        /// Number of spheres.
        spheres: usize,
        /// The fraction that is done.
        done: f32,
    },
    /// The spheres are fitted.
    Fitted {
        /// The object's name.
        object: &'a str,
        /// Number of spheres.
        spheres: usize,
        /// Seconds that fitting took.
        seconds: f64,
    },
    /// A file of an earlier run is damaged; its contents are computed again.
    Damaged {
        /// Its file.
        path: &'a Path,
    },
    /// An object's spheres fit it badly.
    PoorFit {
        /// The object's name.
        object: &'a str,
        /// The fraction of its silhouette that they miss.
        error: f32,
    },
    /// The paper's tables are being computed.
    Tables {
        /// The fraction that is done, in [0, 1].
        done: f32,
    },
    /// There is no room for shadow maps as fine as the lights need.
    MapsReduced(MapReduction),
    /// How well the shadow map of a light suits the receivers.
    Map {
        /// Number of the light.
        light: usize,
        /// Whether the map is fine enough, in words.
        advice: MapAdvice,
    },
    /// A time budget has chosen an accuracy.
    Chosen {
        /// The chosen accuracy.
        accuracy: Accuracy,
        /// The time of a frame.
        milliseconds: f64,
        /// Whether that is within the budget. If not, this is the fastest setting.
        is_within: bool,
    },
    /// Pixels of the picture, or of its requested parts, that are shaded.
    Pixels {
        /// Number of pixels that are shaded.
        done: u64,
        /// Number of all pixels to be shaded.
        of: u64,
    },
}

/// Receives events, and may stop the work.
pub type Listener<'a> = dyn FnMut(Event<'_>) -> ControlFlow<()> + 'a;

/// Returns an error if a stop is requested.
pub(crate) fn check(cancel: &Cancel) -> Result<(), RenderError> {
    if cancel.is_cancelled() { Err(RenderError::Cancelled) } else { Ok(()) }
}

/// Sends an event to a listener; returns an error if the listener stops the work.
pub(crate) fn tell(listener: &mut Listener<'_>, event: Event<'_>) -> Result<(), RenderError> {
    match listener(event) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(RenderError::Cancelled),
    }
}
