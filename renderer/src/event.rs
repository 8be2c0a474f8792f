use crate::{MapReduction, RenderError};
use core::ops::ControlFlow;
use lobe_core::Accuracy;
use scene::Cancel;
use std::path::Path;
use visibility_shadowmap::MapAdvice;

/// What a [`Renderer`](crate::Renderer) tells while it works.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Event<'a> {
    /// Spheres are being fitted to an object; `done` is in [0, 1].
    Fitting {
        /// The object's name.
        object: &'a str,
        /// How many.
        spheres: usize,
        /// How much of it is done.
        done: f32,
    },
    /// They are fitted.
    Fitted {
        /// The object's name.
        object: &'a str,
        /// How many.
        spheres: usize,
        /// How long it took.
        seconds: f64,
    },
    /// What an earlier run has kept was not what it should be, and is made anew.
    Damaged {
        /// Its file.
        path: &'a Path,
    },
    /// An object's spheres stand badly for it.
    PoorFit {
        /// The object's name.
        object: &'a str,
        /// The share of its silhouette that they miss.
        error: f32,
    },
    /// The paper's tables are being made.
    Tables {
        /// How much of it is done, in [0, 1].
        done: f32,
    },
    /// The device has no room for maps as fine as the lights want.
    MapsReduced(MapReduction),
    /// How the map of a light suits the receivers.
    Map {
        /// Number of the light.
        light: usize,
        /// Whether it is fine enough, in words.
        advice: MapAdvice,
    },
    /// A time budget has chosen.
    Chosen {
        /// What.
        accuracy: Accuracy,
        /// What a frame takes.
        milliseconds: f64,
        /// Whether that is within the budget; nothing is faster if not.
        is_within: bool,
    },
    /// Pixels of the picture, or of its requested parts, that are shaded.
    Pixels {
        /// So many.
        done: u64,
        /// Of so many.
        of: u64,
    },
}

/// Hears what goes on, and may stop it.
pub type Listener<'a> = dyn FnMut(Event<'_>) -> ControlFlow<()> + 'a;

/// Ends the work where it is to stop.
pub(crate) fn check(cancel: &Cancel) -> Result<(), RenderError> {
    if cancel.is_cancelled() { Err(RenderError::Cancelled) } else { Ok(()) }
}

/// Tells a listener, and ends where that says so.
pub(crate) fn tell(listener: &mut Listener<'_>, event: Event<'_>) -> Result<(), RenderError> {
    match listener(event) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(RenderError::Cancelled),
    }
}
