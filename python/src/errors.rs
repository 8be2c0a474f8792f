//! Exceptions: the one-line messages of the library, by the kind of fault.

use cosine_lobes::renderer;
use cosine_lobes::scene;
use pyo3::exceptions::{PyException, PyUserWarning, PyValueError};
use pyo3::{PyErr, create_exception};

create_exception!(cosine_lobes, LobesError, PyException, "Any error of the library.");
create_exception!(cosine_lobes, SceneError, LobesError, "A scene, a file of one, or a part of it is refused.");
create_exception!(cosine_lobes, EditError, LobesError, "An edit is refused; the renderer stays the same.");
create_exception!(cosine_lobes, RenderError, LobesError, "A picture could not be made.");
create_exception!(cosine_lobes, LobesWarning, PyUserWarning, "Something was left out, replaced, or fits badly.");

/// A fault of the library as an exception.
pub(crate) trait OrRaise<T> {
    fn or_raise(self) -> Result<T, PyErr>;
}

impl<T, E: Fault> OrRaise<T> for Result<T, E> {
    fn or_raise(self) -> Result<T, PyErr> {
        self.map_err(Fault::exception)
    }
}

/// An error of the library.
pub(crate) trait Fault {
    fn exception(self) -> PyErr;
}

impl Fault for scene::SceneError {
    fn exception(self) -> PyErr {
        SceneError::new_err(self.to_string())
    }
}

impl Fault for renderer::RenderError {
    fn exception(self) -> PyErr {
        use renderer::RenderError as Error;
        match self {
            Error::Scene(error) => error.exception(),
            Error::Edit(error) => EditError::new_err(error.to_string()),
            Error::Setting { .. } => PyValueError::new_err(self.to_string()),
            error => RenderError::new_err(error.to_string()),
        }
    }
}

impl Fault for bake::BakeError {
    fn exception(self) -> PyErr {
        use bake::BakeError as Error;
        match self {
            Error::Scene(error) => error.exception(),
            Error::Render(error) => error.exception(),
            Error::File { .. } => SceneError::new_err(self.to_string()),
            Error::Setting { .. } => PyValueError::new_err(self.to_string()),
            error => LobesError::new_err(error.to_string()),
        }
    }
}

/// Those that say all in their message.
macro_rules! faults {
    ($($error:ty => $exception:ident),* $(,)?) => {
        $(impl Fault for $error {
            fn exception(self) -> PyErr {
                $exception::new_err(self.to_string())
            }
        })*
    };
}

faults! {
    cosine_lobes::ImageFileError => LobesError,
    cosine_lobes::SizesDiffer => PyValueError,
    cosine_lobes::sphere_sets::BuildError => LobesError,
    cosine_lobes::sphere_sets::SetFileError => LobesError,
    cosine_lobes::render_cpu::BlockersError => RenderError,
    cosine_lobes::brdf::MaterialError => PyValueError,
    cosine_lobes::lighting::FlatLightError => PyValueError,
    cosine_lobes::lighting::EnvironmentError => PyValueError,
}
