//! Scenes: meshes, materials, lights, camera and their loading.

mod bounds;
mod builtin;
mod camera;
mod error;
mod gltf_buffers;
mod gltf_file;
mod load;
mod mesh;
mod obj;
mod ply;
mod scene;
mod scene_file;
#[cfg(test)]
mod scene_file_tests;
mod scene_object;
mod shade;
mod shapes;
mod toml_reader;

pub use crate::bounds::Bounds;
pub use crate::builtin::builtin;
pub use crate::camera::Camera;
pub use crate::error::SceneError;
pub use crate::load::{load, load_with_warnings};
pub use crate::mesh::Mesh;
pub use crate::scene::{Object, Proxy, Scene, Shape};
pub use crate::scene_file::SCHEMA_EXAMPLE;
pub use crate::shade::{BlockerSet, Counts, Frame, Shade, ShadeStats, ShadingPoints, StageSeconds};
