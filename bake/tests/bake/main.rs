//! Files that are baked, beside closed forms.

#![expect(clippy::unwrap_used, reason = "tests")]

mod backs;
mod bodies;
mod coordinates;
mod document;
mod light;
mod moments;
mod resuming;
mod spheres;
mod subdivide;
mod support;
