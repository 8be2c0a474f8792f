//! Baked light: the irradiance of all lights and skies at the surfaces of a glTF file, with exact shadows and without noise.
//!
//! - [`Baker`] loads a file, lights its surfaces, and gives a binary glTF file ([`Baked`]): everything that it does not touch stays byte for
//!   byte.
//! - [`BakeSettings`] say how: as emission that any viewer shows, as light maps of engines (MOZ_lightmap), or as colours of vertices
//!   ([`Form`]).
//! - [`MeshMap`]: the light of one mesh on coordinates of its own, by a renderer of the program's.
//! - [`Map`]: the light of a page as OpenEXR or PNG, of all lights or of each one.
//!
//! # Texels
//! A texel's value is the mean over the part of it that lies on a surface:
//!
//! ```text
//! value = Σ area · irradiance(centroid) / Σ area
//! ```
//!
//! over the pieces into which the texel's cells and the triangles cut each other ([`BakeSettings::samples`] cells a side). No point lies
//! beyond a triangle. Points inside of bodies do not count, nor those on the other side of a wall. Texels around a chart repeat its edge.
//!
//! # Conventions
//! Irradiance is in W·m⁻² per channel, linear RGB; a surface is lit on the side from which its triangles go round against the clock, as glTF
//! draws them. The diffuse part of materials alone is baked, without normal maps.
//!
//! ```no_run
//! use bake::{BakeSettings, Baker};
//! use core::ops::ControlFlow;
//! let options = scene_files::LoadOptions::new();
//! let mut baker = Baker::open("room.glb", &options, BakeSettings::default(), renderer::Settings::default())?;
//! let baked = baker.bake(&mut |_stage, _done| ControlFlow::Continue(()))?;
//! std::fs::write("baked.glb", baked.glb)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod backs;
mod baked;
mod baker;
mod blend;
mod coverage;
mod division;
mod error;
mod from_scene;
mod glb;
mod images;
mod json;
mod layout;
mod light;
mod look;
mod materials;
mod mesh_map;
mod mixing;
mod page;
mod pieces;
mod round;
mod rows;
mod scattered;
mod seams;
mod settings;
mod stamp;
mod steps;
mod subdivide;
mod target;
mod texels;
mod vertices;
mod write;

pub use crate::baked::{Baked, beside};
pub use crate::baker::{Baker, Listener, Stage};
pub use crate::error::BakeError;
pub use crate::images::Map;
pub use crate::mesh_map::{MeshLight, MeshMap};
pub use crate::settings::{BakeSettings, Form};
pub use crate::stamp::{glb_binary, glb_stamp, stamped_glb};
pub use crate::steps::Steps;
pub use crate::subdivide::Subdivision;
