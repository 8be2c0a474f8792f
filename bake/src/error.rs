use renderer::RenderError;
use scene::SceneError;
use std::path::PathBuf;

/// Why nothing was baked: one line.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BakeError {
    /// The file could not be read.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The light could not be computed, or the work was stopped.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The file does not suit the request.
    #[error("{}: {message}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The fault, with the name of the mesh.
        message: String,
    },
    /// A setting is out of its range.
    #[error("{name} is {value}: expected {expected}")]
    Setting {
        /// The setting.
        name: &'static str,
        /// Its value.
        value: String,
        /// Its range.
        expected: &'static str,
    },
    /// Steps that were kept are not those of this bake.
    #[error("the kept steps are not of this bake: {0}")]
    Steps(String),
    /// An image could not be encoded.
    #[error("cannot encode {0}")]
    Image(String),
}

impl BakeError {
    /// Whether the work was stopped on request.
    #[must_use]
    pub const fn is_cancelled(&self) -> bool {
        matches!(self, Self::Render(RenderError::Cancelled))
    }
}
