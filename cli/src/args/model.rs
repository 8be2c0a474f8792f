use super::values::crease;
use crate::failure::Failure;
use clap::{Args, ValueEnum};
use cosine_lobes::scene::{self, LoadOptions};

/// The choices in how models are read.
#[derive(Args, Clone, Debug, Default, PartialEq)]
pub(crate) struct ModelArgs {
    /// Normals of models; of those in a scene file where it names none
    #[arg(long, value_enum, default_value_t = Normals::File)]
    normals: Normals,

    /// Degrees between two faces beyond which --normals smooth leaves their edge sharp; when left out, none stays sharp
    #[arg(long, value_name = "DEGREES", value_parser = crease)]
    crease: Option<f32>,

    /// Where light ends on smooth meshes; on those of a scene file where it does not say it
    #[arg(long, value_enum, default_value_t = Terminator::Exact)]
    terminator: Terminator,

    /// Objects whose material emits
    #[arg(long, value_enum, default_value_t = Emission::Lights)]
    emission: Emission,

    /// Lights of a model that brings none, soft unless given; given, also of one in which objects emit
    #[arg(long, value_enum)]
    studio: Option<Studio>,
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

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Terminator {
    /// At their faces: the truth of the triangles, in steps where these are large
    #[default]
    Exact,
    /// As on the rounded surface that their normals describe
    Smooth,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Emission {
    /// They light the others, where lights stand for them within 2 %; a warning names those that do not
    #[default]
    Lights,
    /// They are seen only
    Seen,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Studio {
    /// A key light, a fill and ambient light, which metals mirror
    Soft,
    /// One light, as --method paper needs it
    Key,
}

impl ModelArgs {
    /// How a file is loaded, with the clip that is requested.
    pub(crate) fn options(&self, clip: Option<&str>) -> Result<LoadOptions, Failure> {
        let normals = match (self.normals, self.crease) {
            (Normals::Smooth, None) => scene::Normals::SMOOTH,
            (Normals::Smooth, Some(crease)) => scene::Normals::Smooth { crease },
            (_, Some(_)) => return Err(Failure::new("--crease is for --normals smooth")),
            (Normals::File, None) => scene::Normals::File,
            (Normals::Face, None) => scene::Normals::Face,
        };
        let terminator = match self.terminator {
            Terminator::Exact => scene::Terminator::Exact,
            Terminator::Smooth => scene::Terminator::Smooth,
        };
        let emission = match self.emission {
            Emission::Lights => scene::Emission::Lights,
            Emission::Seen => scene::Emission::Seen,
        };
        let studio = self.studio.map(|studio| match studio {
            Studio::Soft => scene::Studio::Soft,
            Studio::Key => scene::Studio::Key,
        });
        let options = LoadOptions::new().with_clip(clip).with_normals(normals).with_terminator(terminator);
        Ok(options.with_emission(emission).with_studio(studio))
    }
}
