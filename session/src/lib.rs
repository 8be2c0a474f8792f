//! A renderer on a thread of its own, for programs that change a scene while it is looked at.
//!
//! - [`Session`]: takes an [`Edit`] at any time and never waits; gives the newest [`Picture`]. After an edit a coarse picture comes
//!   first where the whole one would take too long; the whole one follows when nothing changes any more, with the same bits as
//!   [`Renderer::render`](renderer::Renderer::render).
//! - [`Edit`]: one change of a scene, with its inverse: [`Session::undo`], [`Session::redo`].
//! - [`Probe`]: one pixel taken apart by lights, beside the Monte Carlo reference.
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

mod edit;
mod history;
mod picture;
mod probe;
mod session;
mod worker;

pub use crate::edit::Edit;
pub use crate::picture::Picture;
pub use crate::probe::{LightPart, Probe};
pub use crate::session::Session;
pub use glam;
