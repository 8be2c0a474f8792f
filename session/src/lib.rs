//! A renderer on a thread of its own, for programs that change a scene while it is looked at.
//!
//! - [`Session`]: takes an [`Edit`] at any time and never waits; gives the newest [`Picture`]. After an edit a coarse picture comes
//!   first where the whole one would take too long; the whole one follows when nothing changes any more, with the same bits as
//!   [`Renderer::render`](renderer::Renderer::render).
//! - [`Driver`]: the same without a thread, in steps that the caller takes, for browsers; several share a picture by rows.
//! - [`Edit`]: one change of a scene, with its inverse: [`Session::undo`], [`Session::redo`].
//! - [`Probe`]: one pixel taken apart by lights, beside the Monte Carlo reference, and the [`Hemisphere`] of its reflectance; [`Truth`]: the reference of the whole picture, which
//!   grows while nothing else is to be done.
//! - [`Trade`]: error against time of a scene, measured beside the session.
//! - [`Snapshot`]: the scene that a picture shows, as lists; [`Editor`]: the same with all changes so far, for handles and sliders.
//! - [`orbited`], [`panned`], [`zoomed`], [`framed`], [`projected`]: cameras that follow a pointer; [`Projection`]: from points to pixels and back;
//!   [`Handles`]: where lights and objects are taken hold of, and what drags do; [`lamp`]: the same light elsewhere, larger, brighter; [`gloss`]: the
//!   same material sharper or duller; [`NewLight`], [`Primitive`]: lights and objects that a window adds.
//!
//! No window, no input, no drawing here.
//!
//! ```
//! use glam::{Mat4, Vec3};
//! use renderer::{Renderer, Settings};
//! use session::{Edit, Session};
//! let mut scene = scene::builtin();
//! (scene.width, scene.height) = (64, 36);
//! let renderer = Renderer::new(scene, scene::Animation::default(), Settings::default())?;
//! let (light, lamp) = renderer.lights().next().map(|(handle, light)| (handle, light.clone())).expect("a light");
//! let session = Session::new(renderer);
//! session.edit(Edit::Light(light, lamp.moved(Mat4::from_translation(Vec3::X)).into()));
//! let picture = session.finished();
//! assert_eq!((picture.size, picture.divisor, picture.edits), ([64, 36], 1, 1));
//! # Ok::<(), renderer::RenderError>(())
//! ```

mod crossed;
mod driver;
mod edit;
mod editor;
pub mod gloss;
mod handles;
mod hemisphere;
mod history;
pub mod lamp;
mod navigation;
mod new_light;
mod outline;
mod picture;
mod primitive;
mod probe;
mod projection;
mod rest;
#[cfg(feature = "files")]
mod saving;
mod session;
mod snapshot;
mod trade;
mod truth;
mod worker;

pub use crate::driver::{Driver, Task};
pub use crate::edit::Edit;
pub use crate::editor::Editor;
pub use crate::handles::{Drag, Dragged, Grip, Handles};
pub use crate::hemisphere::{Hemisphere, HemispherePixel};
pub use crate::navigation::{framed, orbited, panned, projected, zoomed};
pub use crate::new_light::NewLight;
pub use crate::outline::Outline;
pub use crate::picture::Picture;
pub use crate::primitive::Primitive;
pub use crate::probe::{LightPart, Probe};
pub use crate::projection::Projection;
#[cfg(feature = "files")]
pub use crate::saving::{SaveError, changed_text, save};
pub use crate::session::Session;
pub use crate::snapshot::{LightItem, MaterialItem, ObjectItem, Snapshot};
pub use crate::trade::{Trade, TradePoint};
pub use crate::truth::Truth;
pub use glam;
