use clap::Args;
use std::path::PathBuf;

/// Open a scene in a window: drag lights and objects, and see their shadows follow
///
/// The window is a program of its own, lobes-view, which stands beside this one or on the path: `cargo build --release -p
/// cosine-lobes-view` makes it. docs/view.md shows it.
#[derive(Args, Debug)]
pub(crate) struct OpenArgs {
    /// Scene (.toml), model (.gltf, .glb, .obj, .ply); the built-in scene when left out
    pub(crate) file: Option<PathBuf>,
}
