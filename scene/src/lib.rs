//! Scenes: meshes, materials, lights, camera and their loading.

mod camera;
mod mesh;
mod scene;
mod shade;

pub use crate::camera::Camera;
pub use crate::mesh::Mesh;
pub use crate::scene::{Object, Proxy, Scene, Shape};
pub use crate::shade::{BlockerSet, Counts, Frame, Shade, ShadeStats, ShadingPoints, StageSeconds};
