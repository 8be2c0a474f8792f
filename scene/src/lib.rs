//! Scenes: meshes, materials, lights, camera and their loading.

mod bounds;
mod builtin;
mod camera;
mod error;
mod mesh;
mod scene;
mod shade;
mod shapes;

pub use crate::bounds::Bounds;
pub use crate::builtin::builtin;
pub use crate::camera::Camera;
pub use crate::error::SceneError;
pub use crate::mesh::Mesh;
pub use crate::scene::{Object, Proxy, Scene, Shape};
pub use crate::shade::{BlockerSet, Counts, Frame, Shade, ShadeStats, ShadingPoints, StageSeconds};
