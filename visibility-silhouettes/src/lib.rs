//! Exact visibility of triangle meshes from their silhouette edges.
//!
//! A [`SilhouetteMesh`] is prepared once and refitted as it moves; [`SilhouetteBlockers`] fills a receiver's mask from the
//! outlines of all meshes, the same mask that every strategy fills, with one shadow ray a mask ([`AnyHit`]).

mod blockers;
mod count;
mod edge_list;
mod hull;
mod lanes;
mod mesh;
mod project;
mod select;
mod topology;
mod tree;

pub use crate::blockers::{AnyHit, SilhouetteBlockers, SilhouetteScratch};
pub use crate::mesh::SilhouetteMesh;
