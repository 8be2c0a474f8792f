use core::ops::ControlFlow;
use sphere_sets::{BindError, BuildError, MisfitError, SetFileError};
use std::path::PathBuf;

/// Why the blockers of a scene could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BlockersError {
    /// No spheres could be built for an object.
    #[error("blocker spheres of object \"{object}\": {source}")]
    Build {
        /// The object's name.
        object: String,
        /// The reason.
        source: BuildError,
    },
    /// A sphere-set file could not be read.
    #[error("{path}: cannot read: {source}", path = path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// A sphere-set file was made for another mesh.
    #[error("{path}: object \"{object}\": {source}", path = path.display())]
    Misfit {
        /// The file.
        path: PathBuf,
        /// The object that it is given for.
        object: String,
        /// The difference.
        source: MisfitError,
    },
    /// The spheres of a moving object cannot follow it.
    #[error("blocker spheres of object \"{object}\": {source}")]
    Bind {
        /// The object's name.
        object: String,
        /// The reason.
        source: BindError,
    },
    /// A sphere-set file is wrong.
    #[error("{path}: {source}", path = path.display())]
    Set {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: SetFileError,
    },
}

/// Hears of an object's name and how much of its spheres is done, in [0, 1], and may stop the work.
pub type BlockersProgress<'a> = dyn FnMut(&str, f32) -> ControlFlow<()> + 'a;
