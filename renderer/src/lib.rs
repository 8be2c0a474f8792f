//! The whole of it as one type: a scene goes in, radiance comes out.
//!
//! - [`Renderer`]: scene, strategies, spheres, frames, device and method; [`Settings`] say how, an [`Image`] comes of it.
//! - [`Event`] and [`Listener`]: what is told while it works. Nothing is printed here, nothing exits.
//! - Its parts, for those who put them together in another way: [`Plan`] (which strategy each object takes), [`scene_spheres`],
//!   [`KeptSpheres`], [`FrameBlockers`], [`Backend`].
//!
//! Everything that a picture is made of is open: a [`Material`](brdf::Material::Custom), a [`Light`](lighting::Light::Custom) and a
//! [`Strategy`](scene::Strategy::Custom) of one's own are put into a scene like the built-in ones, on both devices.
//!
//! The command `lobes` is a thin shell over it.
//!
//! ```
//! use renderer::{Renderer, Settings};
//! use scene::Animation;
//! let mut scene = scene::builtin();
//! (scene.width, scene.height) = (32, 18);
//! let mut renderer = Renderer::new(scene, Animation::default(), Settings::default())?;
//! let image = renderer.render()?;
//! assert_eq!(image.radiance.len(), 32 * 18);
//! # Ok::<(), renderer::RenderError>(())
//! ```
//!
//! # Features
//! `gpu`: shading on a GPU through wgpu. Without it nothing of wgpu is compiled.

mod backend;
mod bands;
mod budget;
mod cache;
mod clocks;
mod custom_strategy;
mod edit;
mod edit_error;
mod error;
mod event;
mod exposure;
mod frame_blockers;
mod handles;
mod image;
mod job;
mod kept;
mod kept_maps;
mod kept_points;
mod kept_sky;
mod kept_spheres;
mod layers;
mod on_objects;
mod pick;
mod plan;
mod renderer;
mod rows;
mod settings;
mod sphere_cache;
mod stale;
mod tables;

pub use crate::backend::{Backend, Shader};
pub use crate::bands::{BAND_RAYS, seconds};
pub use crate::budget::LADDER;
pub use crate::clocks::{Clocks, FrameClocks};
pub use crate::custom_strategy::CustomStrategy;
pub use crate::edit_error::EditError;
pub use crate::error::RenderError;
pub use crate::event::{Event, Listener};
pub use crate::exposure::exposure;
pub use crate::frame_blockers::{FrameBlockers, ShaderTask};
pub use crate::handles::{LightHandle, MaterialHandle, ObjectHandle};
pub use crate::image::{Band, Image, ImageStats, Sink};
pub use crate::kept_sky::{KeptSky, SkyFrame};
pub use crate::kept_spheres::KeptSpheres;
pub use crate::layers::{LayerSet, Layers};
pub use crate::pick::Pick;
pub use crate::plan::{MapReduction, Plan};
pub use crate::renderer::Renderer;
pub use crate::settings::{Device, Method, Settings};
pub use crate::sphere_cache::{known_set, scene_spheres};
pub use crate::stale::{Stale, Upkeep};
pub use crate::tables::paper_tables;
pub use glam;
pub use pictures::Window;
pub use scene::{Cancel, set_clock};
