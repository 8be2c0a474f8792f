use renderer::{EditError, RenderError};
use scene::SceneError;

/// Why a command is refused: the class of the exception, and its one line.
#[derive(Debug)]
pub(crate) struct Fault {
    pub(crate) class: &'static str,
    pub(crate) line: String,
}

impl Fault {
    /// An argument that is out of its range.
    pub(crate) fn range(line: impl Into<String>) -> Self {
        Self { class: "RangeError", line: line.into() }
    }

    /// A key that nothing has.
    pub(crate) fn edit(line: impl Into<String>) -> Self {
        Self { class: "EditError", line: line.into() }
    }
}

impl From<SceneError> for Fault {
    fn from(error: SceneError) -> Self {
        Self { class: "SceneError", line: error.to_string() }
    }
}

impl From<EditError> for Fault {
    fn from(error: EditError) -> Self {
        Self::edit(error.to_string())
    }
}

impl From<RenderError> for Fault {
    fn from(error: RenderError) -> Self {
        let class = match &error {
            RenderError::Scene(_) => "SceneError",
            RenderError::Edit(_) => "EditError",
            RenderError::Setting { .. } => "RangeError",
            _ => "RenderError",
        };
        Self { class, line: error.to_string() }
    }
}

/// Faults of numbers that were given.
macro_rules! of_arguments {
    ($($error:ty),*) => {
        $(impl From<$error> for Fault {
            fn from(error: $error) -> Self {
                Self::range(error.to_string())
            }
        })*
    };
}

of_arguments!(brdf::MaterialError, lighting::FlatLightError, lighting::EnvironmentError);
