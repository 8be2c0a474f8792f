use crate::{LightHandle, MaterialHandle, ObjectHandle};

/// Why an edit is refused; the renderer then stays the same.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EditError {
    /// The object has been removed.
    #[error("object {n} is not in the scene", n = .0.0)]
    NoObject(ObjectHandle),
    /// The light has been removed.
    #[error("light {n} is not in the scene", n = .0.0)]
    NoLight(LightHandle),
    /// The material has been removed.
    #[error("material {n} is not in the scene", n = .0.0)]
    NoMaterial(MaterialHandle),
    /// The item that is to come back is there.
    #[error("{0} is in the scene")]
    Present(String),
    /// A light that goes with its environment alone.
    #[error("light {0} is a patch of the environment")]
    Patch(usize),
    /// The animation moves this item and would undo the edit.
    #[error("{0} is moved by the animation")]
    Animated(String),
    /// An object has the material that is to be removed.
    #[error("object \"{0}\" has this material")]
    MaterialInUse(String),
    /// A matrix that the object cannot follow.
    #[error("object \"{object}\": transform {fault}")]
    Transform {
        /// The object's name.
        object: String,
        /// The fault of the matrix.
        fault: &'static str,
    },
}
