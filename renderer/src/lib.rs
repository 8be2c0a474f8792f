//! The renderer as one type: a scene goes in, radiance comes out.
//!
//! - [`Renderer`]: scene, strategies, spheres, frames, device and method; [`Settings`] control it, and the result is an [`Image`].
//! - [`Event`] and [`Listener`]: progress and warnings. The library prints nothing and never exits.
//! - Its parts, for other compositions: [`Plan`] (the strategy of each object), [`scene_spheres`], [`KeptSpheres`],
//!   [`FrameBlockers`], [`Backend`].
//!
//! Scenes take a custom [`Material`](brdf::Material::Custom), [`Light`](lighting::Light::Custom) and
//! [`Strategy`](scene::Strategy::Custom) like the built-in ones, on both devices.
//!
//! The command `lobes` is a thin shell over this crate.
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
//! `gpu`: shading on a GPU through wgpu. Without it wgpu is not compiled.

mod backdrops;
mod backend;
mod bands;
mod budget;
mod cache;
mod clocks;
mod cpu_shading;
mod custom_strategy;
mod edit;
mod edit_error;
mod error;
mod event;
mod exposure;
mod follow;
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
mod light_mask;
mod looks;
mod on_objects;
mod pick;
mod plan;
mod points;
mod reduced;
mod render;
mod renderer;
mod rows;
mod settings;
mod sphere_cache;
mod stale;
mod tables;
mod taken;
mod turn;

pub use crate::backend::{Backend, Shader};
pub use crate::bands::{BAND_RAYS, seconds};
pub use crate::budget::LADDER;
pub use crate::clocks::{Clocks, FrameClocks};
pub use crate::custom_strategy::CustomStrategy;
pub use crate::edit_error::EditError;
pub use crate::error::RenderError;
pub use crate::event::{Event, Listener};
pub use crate::exposure::{exposure, exposure_of};
pub use crate::frame_blockers::{FrameBlockers, ShaderTask};
pub use crate::handles::{LightHandle, MaterialHandle, ObjectHandle};
#[cfg(feature = "gpu")]
pub use crate::image::GpuImage;
pub use crate::image::{Band, Image, ImageStats, Sink};
pub use crate::kept_sky::{KeptSky, SkyFrame};
pub use crate::kept_spheres::KeptSpheres;
pub use crate::layers::{LayerSet, Layers};
pub use crate::light_mask::{LightMask, MaskSample};
pub use crate::pick::Pick;
pub use crate::plan::{MapReduction, Plan};
pub use crate::points::PointLight;
pub use crate::renderer::Renderer;
pub use crate::settings::{Device, Method, Settings};
pub use crate::sphere_cache::{known_set, scene_spheres};
pub use crate::stale::{Stale, Upkeep};
pub use crate::tables::paper_tables;
pub use crate::taken::{TakenLight, TakenObject};
pub use glam;
pub use pictures::Window;
pub use render_cpu::PixelSamples;
#[cfg(feature = "gpu")]
pub use render_gpu::{Gpu, GpuError, GpuPicture};
pub use scene::{Cancel, set_clock};
