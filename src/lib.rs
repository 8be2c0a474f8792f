//! Direct lighting from area lights without noise: soft shadows and glossy highlights of scenes whose lights and objects move.
//!
//! [`Renderer`](renderer::Renderer) turns a [`Scene`](scene::Scene) into radiance. It integrates each light in closed form and finds
//! the hidden part of it with a bit mask, so the same input gives the same bits, on any number of threads:
//!
//! ```text
//! radiance = Σ lights Σ reflectance lobes  flux · light's radiance · ∫ lobe over the light · visible fraction
//! ```
//!
//! # A scene in code
//!
//! [`scene::load_animated`] reads scene files and models ([`scene::SCHEMA_EXAMPLE`] explains every key). A program can also make
//! its own scene:
//!
//! ```
//! use cosine_lobes::brdf::Material;
//! use cosine_lobes::glam::Vec3;
//! use cosine_lobes::lighting::SphereLight;
//! use cosine_lobes::lobe_core::Sphere;
//! use cosine_lobes::renderer::{Renderer, Settings};
//! use cosine_lobes::scene::{Animation, Camera, Projection, Mesh, Object, Proxy, Scene};
//!
//! let floor = Mesh::quad(Vec3::ZERO, Vec3::X * 4.0, Vec3::Z * -4.0);
//! let sphere = Sphere { center: Vec3::new(0.0, 0.5, 0.0), radius: 0.5 };
//! let lamp = Sphere { center: Vec3::new(-2.0, 4.0, 1.0), radius: 0.4 };
//! let scene = Scene {
//!     camera: Camera {
//!         eye: Vec3::new(0.0, 2.0, 5.0),
//!         target: Vec3::new(0.0, 0.4, 0.0),
//!         up: Vec3::Y,
//!         projection: Projection::perspective(0.6),
//!     },
//!     width: 64,
//!     height: 36,
//!     background: Vec3::ZERO,
//!     materials: vec![Material::lambert(Vec3::splat(0.5)), Material::lambert(Vec3::new(0.8, 0.2, 0.1))],
//!     surfaces: Vec::new(),
//!     objects: vec![Object::mesh("floor", floor, 0, Proxy::None), Object::spheres("sphere", vec![sphere], 1)],
//!     lights: vec![SphereLight::new(lamp, Vec3::splat(60.0)).into()],
//!     environment: None,
//! };
//! scene.validate()?;
//!
//! let mut renderer = Renderer::new(scene, Animation::default(), Settings::default())?;
//! let image = renderer.render()?;
//! assert_eq!(image.size, [64, 36]);
//! assert!(image.radiance.iter().all(|radiance| radiance.is_finite()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`Settings`](renderer::Settings) choose the tolerance, the device, the method and one strategy for all objects. To write the
//! picture, use [`write_png`] or [`write_exr`].
//!
//! # Frames
//!
//! The first picture builds the hierarchies that the strategies need. Later pictures refit the moving parts only.
//! [`seek`](renderer::Renderer::seek) poses the scene at a moment of its animation:
//!
//! ```
//! use cosine_lobes::renderer::{Renderer, Settings};
//! # let folder = std::env::temp_dir().join("cosine-lobes-doc-frames");
//! # std::fs::create_dir_all(&folder)?;
//! # let file = folder.join("roll.toml");
//! # std::fs::write(&file, "[image]\nwidth = 16\nheight = 9\n[camera]\neye = [0, 2, 8]\ntarget = [0, 0, 0]\n\
//! # [[lights]]\nkind = \"sphere\"\ncenter = [0, 5, 0]\nradius = 1\nradiance = 9\n\
//! # [[objects]]\nsphere = { center = [0, 1, 0], radius = 1 }\n\
//! # keys = [{ time = 0 }, { time = 1, translate = [2, 0, 0] }]\n")?;
//! let (scene, animation, _warnings) = cosine_lobes::scene::load_animated(&file)?;
//! let mut renderer = Renderer::new(scene, animation, Settings::default())?;
//! for frame in 0..3 {
//!     renderer.seek(frame as f32 / 24.0); // seconds
//!     let image = renderer.render()?;
//!     assert_eq!(image.radiance.len(), image.size[0] * image.size[1]);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`render_bands`](renderer::Renderer::render_bands) hands on rows as they are finished, so that a large picture needs little memory.
//! Long work calls a [`Listener`](renderer::Listener), which may stop it.
//!
//! # Edits
//!
//! Between two pictures a program may change the scene by handles. Each edit is checked, and says what it made stale; the next
//! picture makes no more than that anew.
//!
//! ```
//! use cosine_lobes::glam::{Mat4, Vec3};
//! use cosine_lobes::renderer::{Renderer, Settings};
//! use cosine_lobes::scene::{Animation, builtin};
//! let mut scene = builtin();
//! (scene.width, scene.height) = (32, 18);
//! let mut renderer = Renderer::new(scene, Animation::default(), Settings::default())?;
//! renderer.render()?;
//! let (object, _) = renderer.objects().last().expect("an object");
//! renderer.set_transform(object, Mat4::from_translation(Vec3::Y * 0.2))?;
//! let (light, lamp) = renderer.lights().next().expect("a light");
//! let lamp = lamp.moved(Mat4::from_translation(Vec3::X));
//! renderer.set_light(light, lamp)?;
//! let image = renderer.render()?;
//! # assert_eq!(image.size, [32, 18]);
//! # Ok::<(), cosine_lobes::renderer::RenderError>(())
//! ```
//!
//! A window hands its edits to a [`Session`](session::Session), which renders on a thread of its own, shows a coarse picture first where the
//! whole one takes too long, and takes steps back.
//!
//! # Own parts
//!
//! A material is a [`Model`](brdf::Model), a light a [`LightKind`](lighting::LightKind), a strategy a
//! [`CustomStrategy`](renderer::CustomStrategy) with [`Blockers`](visibility_mask::Blockers). The built-in parts implement the same traits, and
//! a renderer shades both kinds in the same way: on CPU and GPU, with animation, edits and layers, and in the reference.
//!
//! ```
//! use cosine_lobes::brdf::{Brdf, Material, Model};
//! use cosine_lobes::glam::Vec3;
//! use cosine_lobes::lobe_core::{BrdfLobe, Lobe, Receiver};
//! use cosine_lobes::shading::BrdfLobes;
//! use cosine_lobes::renderer::{Renderer, Settings};
//! use cosine_lobes::scene::{Animation, builtin};
//! use std::sync::Arc;
//!
//! /// Reflects back to where the light came from, as road signs do.
//! #[derive(Debug)]
//! struct Retro(Vec3);
//!
//! impl BrdfLobes for Retro {
//!     fn brdf_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
//!         out.push(Lobe::new(at.view, 40.0, self.0).times_cosine().into());
//!     }
//! }
//!
//! impl Brdf for Retro {
//!     fn eval(&self, at: &Receiver, v: Vec3) -> Vec3 {
//!         self.0 * (at.view.dot(v).max(0.0).powi(40) * at.normal.dot(v).max(0.0))
//!     }
//! }
//!
//! impl Model for Retro {
//!     fn name(&self) -> &'static str {
//!         "retro"
//!     }
//!     fn lobe_count(&self) -> usize {
//!         1
//!     }
//! }
//!
//! let mut scene = builtin();
//! (scene.width, scene.height) = (32, 18);
//! scene.materials[1] = Material::Custom(Arc::new(Retro(Vec3::ONE)));
//! let image = Renderer::new(scene, Animation::default(), Settings::default())?.render()?;
//! # assert_eq!(image.size, [32, 18]);
//! # Ok::<(), cosine_lobes::renderer::RenderError>(())
//! ```
//!
//! `examples/open` is a crate with one of each, on both devices; the suites of the feature `oracle` test such parts
//! against f64. `examples/compose.rs` is a renderer of the traits below these in forty lines.
//!
//! # Units
//!
//! Radiance is in W·m⁻²·sr⁻¹ for each of the linear channels red, green and blue. Lengths may have any unit; it is the metre where a
//! light is given by its flux or intensity. Angles are in radians in code and in degrees in files. World space is right-handed, with
//! y up by default. Pictures hold linear radiance; [`Renderer::exposure`](renderer::Renderer::exposure) proposes the exposure for
//! [`srgb_bytes`].
//!
//! # Strategies
//!
//! A [`Strategy`](scene::Strategy) decides how an object blocks light. Each object may have its own:
//!
//! | strategy | blocks with | choose it when |
//! |---|---|---|
//! | `Silhouettes` (default for meshes) | the exact triangles, through the edges of their outlines | shadows must be right |
//! | `Spheres` | a few spheres for each mesh | speed matters most and objects are compact |
//! | `Rays` | the exact triangles, through shadow rays | checking the others |
//! | `ShadowMap` | depth maps around the light | comparing with a familiar technique |
//! | `None` | nothing | backdrops |
//!
//! # Crates
//!
//! Each crate of the workspace is a module here. [`scene`]: scenes, and their files (crates `scene` and `scene-files`). [`renderer`]: the front door; [`session`]: the same on a thread of its own. [`brdf`], [`lighting`]:
//! materials and lights as lobes; [`lobe_core`]: lobes and their integrals; [`shading`]: the traits and the integrators; [`paper`]: the paper's own method. [`visibility_mask`], [`visibility_silhouettes`],
//! [`visibility_spheres`], [`sphere_sets`], [`visibility_shadowmap`], [`visibility_rays`]: visibility. [`render_cpu`], `render_gpu`: shading. [`ray_tracing`]: rays
//! and visible points. [`reference`](mod@reference): Monte Carlo. [`pictures`]: image files and comparison.
//!
//! # Features
//!
//! - `gpu` (default): `render_gpu`, through wgpu.
//! - `files` (default): scene files, models, images: glTF, OBJ, PLY, PNG, OpenEXR and others. Without it a scene comes from code.
//! - `oracle`: f64 oracles, and suites for own materials, lights and strategies (`conformance`).
//!
//! The command `lobes` is a package of its own, `cosine-lobes-cli`. With `default-features = false` no wgpu is built.

pub use brdf;
#[cfg(feature = "oracle")]
pub use conformance;
pub use glam;
pub use lighting;
pub use lobe_core;
pub use paper;
pub use pictures;
pub use ray_tracing;
pub use reference;
pub use render_cpu;
#[cfg(feature = "gpu")]
pub use render_gpu;
pub use renderer;
pub use session;
pub use shading;
pub use sphere_sets;
pub use visibility_mask;
pub use visibility_rays;
pub use visibility_shadowmap;
pub use visibility_silhouettes;
pub use visibility_spheres;

/// Scenes (crate `scene`) and, with the feature `files`, their files (crate `scene-files`).
pub mod scene {
    #[doc(inline)]
    pub use ::scene::*;
    #[cfg(feature = "files")]
    #[doc(inline)]
    pub use scene_files::*;
}

pub use pictures::{
    Comparison, Display, FlipMap, ImageFileError, Output, Picture, PngDepth, RegionError, ShadowErrors, SizesDiffer,
    ToneMap, Window, checksum, luminance, remove_unfinished, signed_difference, srgb_bytes, sweep_unfinished,
};
#[cfg(feature = "files")]
pub use pictures::{
    ExrLayer, ExrPart, MergeError, PictureStream, merge_exr, read_exr, read_exr_layer, read_stamp, write_exr, write_png,
};
