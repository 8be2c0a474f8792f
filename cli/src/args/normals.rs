use super::values::crease;
use clap::{Args, ValueEnum};
use cosine_lobes::scene;

/// The normals of models.
#[derive(Args, Clone, Debug, Default, PartialEq)]
pub(crate) struct NormalsArgs {
    /// Normals of models; of those in a scene file where it names none
    #[arg(long, value_enum, default_value_t = Normals::File)]
    normals: Normals,

    /// Degrees between two faces beyond which --normals smooth leaves their edge sharp
    #[arg(long, value_name = "DEGREES", default_value_t = 180.0, value_parser = crease)]
    crease: f32,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Normals {
    /// Those of the file; without any a glTF is flat, an OBJ smooth within its smoothing groups and flat elsewhere, a PLY smooth over
    /// the vertices that its faces share
    #[default]
    File,
    /// Those of the faces
    Face,
    /// Means of the faces around a vertex
    Smooth,
}

impl NormalsArgs {
    /// The normals that are requested.
    pub(crate) const fn wish(&self) -> scene::Normals {
        match self.normals {
            Normals::File => scene::Normals::File,
            Normals::Face => scene::Normals::Face,
            Normals::Smooth => scene::Normals::Smooth { crease: self.crease },
        }
    }
}
