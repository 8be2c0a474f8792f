//! Scenes as data: meshes, materials, lights, camera, and their motion.
//!
//! - [`Scene`] and its parts: [`Camera`], [`Object`] ([`Shape`], [`Proxy`], [`Strategy`]), [`Mesh`], materials of `brdf`,
//!   textures and emission ([`Surface`]), lights of `lighting`. [`Scene::validate`] checks all that renderers rely on. [`builtin`]: a scene.
//! - [`Animation`]: its motion; [`motion`]: the parts of that. [`Animation::validate`] checks these.
//! - The inputs and results of renderers, the same for CPU and GPU: [`Shade`], [`ShadingPoints`], [`Frame`], [`BlockerSet`], [`Cancel`].
//!
//! ```
//! let scene = scene::builtin();
//! scene.validate()?;
//! assert_eq!(scene.lights.len(), 2);
//! # Ok::<(), scene::SceneError>(())
//! ```
//!
//! # Conventions
//! Right-handed world space, linear RGB. Meshes of a scene are in world space; sphere sets in files are in the coordinates of their
//! mesh's file and placed with it. Surfaces are two-sided: renderers turn normals to the viewer. Fields of view are full, vertical, and in
//! radians. Coordinates may be as large as ±1e9 ([`MAX_COORDINATE`]); NaN and infinity are refused. A scene that lies far from the origin of its file
//! is relative to a point nearby ([`Animation::origin`]).
//!
//! # Scope
//! Out of scope here: files (crate `scene-files`), pictures as output, sphere-set construction, threads.

mod animation;
mod animation_check;
#[cfg(test)]
mod animation_check_tests;
mod animation_edits;
mod bounds;
mod builtin;
mod camera;
mod camera_keys;
mod cancel;
mod check;
mod clock;
mod creases;
pub mod cut_out;
#[cfg(test)]
mod cut_out_tests;
mod deformer;
mod duplicates;
mod edges;
mod error;
mod instances;
mod joined;
mod mesh;
#[cfg(test)]
mod mesh_tests;
pub mod motion;
pub mod normals;
mod origins;
mod placement;
pub mod rounding;
mod scene;
mod shapes;
mod skeleton;
mod strategy;
mod surface;
mod texture;
mod texture_level;
#[cfg(test)]
mod texture_tests;
mod track;
mod windings;

pub use crate::animation::{Animation, Pose, Rig};
pub use crate::animation_edits::{KeyFrame, KeyFrames};
pub use crate::bounds::Bounds;
pub use crate::builtin::builtin;
pub use crate::camera::{Camera, Projection};
pub use crate::cancel::Cancel;
pub use crate::clock::{Stopwatch, set_clock};
pub use crate::duplicates::Duplicates;
pub use crate::error::SceneError;
pub use crate::instances::Instances;
pub use crate::mesh::{MAX_COORDINATE, Mesh};
pub use crate::scene::{Object, Proxy, Scene, Shape, Terminator};
pub use crate::strategy::Strategy;
pub use crate::surface::{Channel, Surface, TextureMap, TexturePlace};
pub use crate::texture::{Encoding, Texture};
pub use crate::texture_level::Wrap;
pub use glam;
pub use shading::{BlockerSet, Counts, GROUP, Shade, ShadeStats, ShadingPoints, StageSeconds};

/// The constants of a frame, of the built-in materials and lights or of own types.
pub type Frame<'a, M = brdf::Material, L = lighting::Light> = shading::Frame<'a, M, L>;
