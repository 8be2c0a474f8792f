//! The parts of an [`Animation`], for readers of files.
//!
//! Each moving object has a [`Mover`]: its [`Placement`] in the world, fixed or by key frames, and its [`Body`]. The body of a mesh
//! is a [`Deformer`], the mesh in bind space with the joints of its vertices. The joints are nodes of a [`Skeleton`], which the clip of
//! a glTF file moves, or, without a [`Carrier`], the placement alone. Lights and the camera follow key frames or nodes. Values over
//! time are [`Track`]s.
//!
//! The skeletons, nodes and joints that parts refer to must exist, and tracks must have the widths that are stated:
//! [`Animation::validate`] checks that, and renderers refuse animations for which it does not hold. [`Animation::seek`] panics for some of these.
//!
//! Numbers are relative to [`Origins`] where geometry is far from the origin of its file.

#[cfg(doc)]
use crate::Animation;

pub use crate::animation::{Body, CameraMover, LightMover, LightPlace, Mover, node_camera};
pub use crate::camera_keys::{CameraKeys, MAX_SECONDS, ProjectionKeys};
pub use crate::creases::Split;
pub use crate::deformer::{BoundSphere, Deformer};
pub use crate::origins::Origins;
pub use crate::placement::{Clock, Keyed, Placement, Turn, fine_rotation, rotation};
pub use crate::skeleton::{Bone, Carrier, FineLocal, Local, Skeleton};
pub use crate::track::{Interpolation, Meaning, Track};
