//! The choices in how files are loaded.

use crate::args;
use crate::settings::named;
use cosine_lobes::scene::{Emission, LoadOptions, Normals, Studio, Terminator};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// The options of the command that models have.
pub(crate) struct Choices<'a> {
    pub(crate) clip: Option<String>,
    pub(crate) normals: &'a str,
    pub(crate) crease: f64,
    pub(crate) terminator: &'a str,
    pub(crate) emission: &'a str,
    pub(crate) studio: Option<&'a str>,
}

/// Where light ends on smooth meshes.
pub(crate) fn terminator(name: &str) -> PyResult<Terminator> {
    named("terminator", name, &[("exact", Terminator::Exact), ("smooth", Terminator::Smooth)])
}

impl Choices<'_> {
    pub(crate) fn options(self) -> PyResult<LoadOptions> {
        if self.crease == 0.0 {
            return Err(PyValueError::new_err("crease is 0: expected degrees above 0, at most 180"));
        }
        let crease = args::within("crease", self.crease, 0.0, 180.0)?;
        let normals = [("file", Normals::File), ("face", Normals::Face), ("smooth", Normals::Smooth { crease })];
        let emission = [("lights", Emission::Lights), ("seen", Emission::Seen)];
        let studio = [("soft", Studio::Soft), ("key", Studio::Key)];
        Ok(LoadOptions::new()
            .with_clip(self.clip)
            .with_normals(named("normals", self.normals, &normals)?)
            .with_terminator(terminator(self.terminator)?)
            .with_emission(named("emission", self.emission, &emission)?)
            .with_studio(self.studio.map(|name| named("studio", name, &studio)).transpose()?))
    }
}
