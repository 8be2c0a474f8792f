//! Data that all readers of a file collect beside its meshes: warnings, skeletons, clips.

use crate::files::{Source, extension};
use crate::gltf_document::GltfDocument;
use crate::kept_meshes::KeptMeshes;
use crate::normals::hide_edges;
use crate::part::Part;
use crate::{Emission, Normals, Studio};
use glam::{DVec3, Vec2};
use scene::cut_out::{AlphaBounds, CutOut};
use scene::motion::{Body, BoundSphere, Mover, Skeleton};
use scene::{Animation, Mesh, Pose, Proxy, SceneError, Terminator, Texture};
use std::path::Path;
use std::sync::Arc;

/// Everything in a file besides its objects.
#[derive(Default)]
pub(crate) struct Context {
    /// The files that are read.
    pub(crate) files: Source,
    /// Things that were left out or replaced, one line each.
    pub(crate) warnings: Vec<String>,
    /// The nodes of the glTF files with a clip that moves.
    pub(crate) skeletons: Vec<Skeleton>,
    /// Names of all clips.
    pub(crate) clips: Vec<String>,
    /// The origin of the coordinates of the mesh file that was read last.
    pub(crate) origin: DVec3,
    /// A corner of the mesh file that was read last, if no triangle of it has an area in single precision.
    pub(crate) collapsed: Option<DVec3>,
    /// A warning about the mesh file that was read last, for objects that get no material from elsewhere.
    pub(crate) no_library: Option<String>,
    /// Of the images that surfaces were cut along.
    pub(crate) alpha_bounds: Vec<(Texture, Arc<AlphaBounds>)>,
    /// Of mesh files that several objects show.
    pub(crate) kept: KeptMeshes,
    /// The surfaces of which alpha has left nothing.
    pub(crate) cut_away: Vec<String>,
    /// The objects of which the file says whether their emission is light.
    pub(crate) emitters: Vec<usize>,
    /// Whether it is for the others.
    pub(crate) emission: Emission,
    /// The lights of a model that brings none.
    pub(crate) studio: Option<Studio>,
    /// The normals of meshes for which the scene file names none.
    pub(crate) normals: Normals,
    /// How light ends on meshes of which the scene file does not say it.
    pub(crate) terminator: Terminator,
    /// Of a glTF file that is read as it is: what it is made of. No floor and no light is added then.
    pub(crate) document: Option<GltfDocument>,
}

impl Context {
    /// The animation of the files that were read.
    pub(crate) fn animation(&mut self) -> Animation {
        let (skeletons, clips) = (std::mem::take(&mut self.skeletons), std::mem::take(&mut self.clips));
        Animation { skeletons, clips, ..Animation::default() }
    }

    /// Binds the spheres of an explicit proxy to a mesh at its first moment.
    pub(crate) fn bind_proxy(&self, mover: &Mover, mesh: &Mesh, proxy: &Proxy) -> Vec<BoundSphere> {
        let (Proxy::Spheres(spheres), Body::Mesh(deformer, carrier)) = (proxy, &mover.body) else { return Vec::new() };
        let skeleton = carrier.as_ref().map(|c| &self.skeletons[c.skeleton]);
        let worlds = skeleton.map_or_else(Vec::new, |s| s.worlds(0.0));
        let mut pose = Pose::default();
        mover.pose(0.0, skeleton, &worlds, &mut pose);
        spheres.iter().map(|&b| deformer.bind_sphere(b, &mesh.positions, &pose.joints)).collect()
    }

    /// A context of the same files and wishes, of which nothing is read yet.
    pub(crate) fn anew(&self) -> Self {
        Self {
            files: self.files.clone(),
            normals: self.normals,
            terminator: self.terminator,
            emission: self.emission,
            ..Self::default()
        }
    }

    /// Warns of normals without a direction.
    pub(crate) fn tell_broken(&mut self, path: &Path, count: usize) {
        if count > 0 {
            self.warn(path, format!("{count} normals have no direction: smooth ones replace them"));
        }
    }

    /// Warns of texture coordinates that are not finite.
    pub(crate) fn tell_broken_uvs(&mut self, path: &Path, count: usize) {
        if count > 0 {
            self.warn(path, format!("{count} texture coordinates are NaN, infinite or too large: triangles there show the corner of their images"));
        }
    }

    /// Warns of faces that cross themselves.
    pub(crate) fn tell_tangled(&mut self, path: &Path, count: usize) {
        let covered = "parts may be covered twice, or not at all";
        match count {
            0 => {}
            1 => self.warn(path, format!("a face crosses itself: {covered}")),
            _ => self.warn(path, format!("{count} faces cross themselves: {covered}")),
        }
    }

    /// Warns of smooth normals where the file has none: those that are requested, and those that hide edges. A scene file that
    /// requests them gets a warning for hidden edges only.
    pub(crate) fn tell_smoothed(&mut self, path: &Path, parts: &[Part], wish: Normals, in_file: bool) {
        let bare = || parts.iter().filter(|part| part.is_bare);
        let hides = || bare().any(|part| hide_edges(part.shown()));
        match wish {
            Normals::Smooth { crease } if bare().next().is_some() => {
                let hides = hides();
                let edges = if hides { ", edges included: a smaller crease angle keeps these" } else { "" };
                let crease = if crease < 180.0 { format!(" within {crease}°") } else { String::new() };
                if hides || !in_file {
                    self.warn(path, format!("has no normals: they are made smooth{crease}{edges}"));
                }
            }
            Normals::File if extension(path) == "ply" && hides() => {
                self.warn(path, "has no normals: they are smooth over shared vertices, edges included");
            }
            Normals::File | Normals::Face | Normals::Smooth { .. } => {}
        }
    }

    pub(crate) fn warn(&mut self, path: &Path, message: impl std::fmt::Display) {
        self.warnings.push(SceneError::file(path, message.to_string()).to_string());
    }

    /// Cuts the transparent parts out of a mesh, whose vertices have these alphas if any.
    pub(crate) fn cut_out(
        &mut self,
        path: &Path,
        name: &str,
        cut_out: &CutOut,
        (mesh, alphas): (&mut Mesh, &[f32]),
        moves: bool,
    ) {
        if mesh.triangles.is_empty() {
            return;
        }
        // The same everywhere: it moves with the surface.
        let is_even = cut_out.map.is_none() && alphas.iter().all(|alpha| *alpha == alphas[0]);
        if moves && !is_even {
            self.warn(path, format!("\"{name}\" moves: it is opaque where its alpha would cut it out"));
            return;
        }
        let before = mesh.triangles.len();
        let bounds = cut_out.map.as_ref().map(|map| self.bounds_of(&map.texture));
        if !cut_out.cut(mesh, alphas, bounds.as_deref(), self.files.budget.triangles()) {
            self.warn(path, format!("\"{name}\" repeats its image too often to be cut out: it is opaque"));
        }
        self.files.budget.grow(mesh, before);
        if mesh.triangles.is_empty() {
            self.cut_away.push(name.to_owned());
        }
    }

    /// The bounds of an image's alpha, made once.
    fn bounds_of(&mut self, texture: &Texture) -> Arc<AlphaBounds> {
        if let Some((_, known)) = self.alpha_bounds.iter().find(|(of, _)| of.is_same(texture)) {
            return known.clone();
        }
        let bounds = Arc::new(AlphaBounds::new(texture));
        self.alpha_bounds.push((texture.clone(), bounds.clone()));
        bounds
    }

    /// The surfaces of which alpha has left nothing since the last call, as a line; empty for none.
    pub(crate) fn cut_away(&mut self) -> String {
        let names = std::mem::take(&mut self.cut_away);
        let why = "alpha is nowhere as large as the cut-off";
        match &names[..] {
            [] => String::new(),
            [name] => format!("\"{name}\" is cut away: its {why}"),
            [first, ..] => format!("{} surfaces are cut away (\"{first}\" is the first): their {why}", names.len()),
        }
    }

    /// Warns of the parts of a file that are left out, if any; an error where the file has nothing else.
    pub(crate) fn left_out(&mut self, path: &Path, is_all: bool, what: &str) -> Result<(), SceneError> {
        match (is_all, what.is_empty()) {
            (true, true) => return Err(SceneError::file(path, "no triangles")),
            (true, false) => return Err(SceneError::file(path, format!("no triangles: {what}"))),
            (false, true) => {}
            (false, false) => self.warn(path, what),
        }
        Ok(())
    }
}

/// How many texture coordinates are not finite. They stay: pictures have the corner of their images there, bakes refuse them.
pub(crate) fn broken_uvs<'a>(uvs: impl IntoIterator<Item = &'a Vec2>) -> usize {
    uvs.into_iter().filter(|uv| !uv.is_finite()).count()
}

/// The number of things that were left out, and the reason; empty for none.
pub(crate) fn counted(count: usize, noun: &str, why: &str) -> String {
    match count {
        0 => String::new(),
        1 => format!("1 {noun} left out for {why}"),
        _ => format!("{count} {noun}s left out for {why}"),
    }
}

/// Behind the name of the first of several things: how many others there are; empty for none.
pub(crate) fn and_others(count: usize) -> String {
    if count == 0 { String::new() } else { format!(" (and {count} more)") }
}
