//! The Python module `cosine_lobes._native`: the library's front door for Python.
//!
//! Each class stands in a file of its own. Work that takes long goes through [`work::run`], which releases the GIL, hears Ctrl-C and
//! reports progress; arrays and numbers come in through [`args`], which names the argument that is wrong.
// `cargo test --lib` links a program of the library's tests, though there are none: without Python's symbols it must be empty.
#![cfg(not(test))]

mod args;
mod baking;
mod camera;
mod edits;
mod environment;
mod errors;
mod handles;
mod images;
mod lamp;
mod light;
mod load;
mod material;
mod mesh;
mod mesh_map;
mod pictures;
mod points;
mod principled;
mod reference;
mod renderer;
mod scene;
mod settings;
mod shared;
mod spheres;
mod values;
mod work;

/// The classes and functions of the package.
#[pyo3::pymodule(name = "_native")]
mod native {
    #[pymodule_export]
    use crate::baking::bake;
    #[pymodule_export]
    use crate::camera::Camera;
    #[pymodule_export]
    use crate::environment::Environment;
    #[pymodule_export]
    use crate::errors::{EditError, LobesError, LobesWarning, RenderError, SceneError};
    #[pymodule_export]
    use crate::handles::{LightHandle, MaterialHandle, ObjectHandle};
    #[pymodule_export]
    use crate::light::Light;
    #[pymodule_export]
    use crate::material::Material;
    #[pymodule_export]
    use crate::mesh::cut_out;
    #[pymodule_export]
    use crate::pictures::{compare, exposed, read_exr, write_exr, write_png};
    #[pymodule_export]
    use crate::reference::reference;
    #[pymodule_export]
    use crate::renderer::{Pick, Renderer};
    #[pymodule_export]
    use crate::scene::Scene;
    #[pymodule_export]
    use crate::settings::Settings;
    #[pymodule_export]
    use crate::spheres::SphereSet;
}
