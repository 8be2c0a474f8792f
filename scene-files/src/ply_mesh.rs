//! The triangles of a PLY file as parts: by image, with texture coordinates and colours that its faces have of their own.

use crate::appearance::Appearance;
use crate::context::{Context, broken_uvs, counted};
use crate::files::extension;
use crate::part::Part;
use crate::polygon::{self, Cut};
use crate::{image_file, vertex_colors};
use brdf::Lambert;
use glam::{Vec2, Vec3};
use scene::{Encoding, Mesh, Surface, TextureMap};
use std::collections::HashMap;
use std::path::Path;

/// Everything that a face says beside its corners.
#[derive(Clone, Default)]
pub(crate) struct Face {
    pub(crate) corners: Vec<u32>,
    /// Two numbers a corner, or none.
    pub(crate) uvs: Vec<f32>,
    pub(crate) image: Option<i64>,
    pub(crate) color: [Option<f32>; 3],
}

/// Elements of a file as they are read.
#[derive(Default)]
pub(crate) struct PlyMesh {
    /// Its colours are sRGB numbers of any range.
    pub(crate) mesh: Mesh,
    /// Names of images, in the order of the header.
    images: Vec<String>,
    /// Vertices and faces whose alpha is below its largest.
    pub(crate) clear: usize,
    /// Faces that are left out: for too few corners, and for infinite ones.
    short: usize,
    infinite: usize,
    /// Of triangles; empty where no face has any.
    uvs: Vec<[Vec2; 3]>,
    colors: Vec<Vec3>,
    owners: Vec<i64>,
    /// Faces that cross themselves.
    tangled: usize,
}

impl PlyMesh {
    pub(crate) fn new(images: Vec<String>) -> Self {
        Self { images, ..Self::default() }
    }

    /// The faces that were left out, and why; empty for none.
    pub(crate) fn left_out(&self) -> String {
        let infinite = "corners that are NaN, infinite or beyond single precision (3.4e38)";
        let all = [counted(self.short, "face", "fewer than three corners"), counted(self.infinite, "face", infinite)];
        all.into_iter().filter(|what| !what.is_empty()).collect::<Vec<_>>().join(", ")
    }

    /// Scanners write NaN for points that they did not see. No face has these: they take the place of another vertex.
    fn drop_infinite(&mut self) {
        let somewhere = self.mesh.triangles.first().map_or(Vec3::ZERO, |t| self.mesh.positions[t[0] as usize]);
        self.mesh.positions.iter_mut().filter(|p| !p.is_finite()).for_each(|p| *p = somewhere);
    }

    /// Adds the triangles of a face.
    pub(crate) fn face(&mut self, face: &Face) -> Result<(), String> {
        let n = face.corners.len();
        if !face.uvs.is_empty() && face.uvs.len() != 2 * n {
            return Err(format!("face has {} texture coordinates for {n} corners", face.uvs.len()));
        }
        if n < 3 {
            self.short += 1;
            return Ok(());
        }
        if face.corners.iter().any(|&i| !self.mesh.positions[i as usize].is_finite()) {
            self.infinite += 1;
            return Ok(());
        }
        let corners: Vec<_> = face.corners.iter().map(|&i| self.mesh.positions[i as usize].as_dvec3()).collect();
        let cut = polygon::fan_or_ears(&corners, &mut |triangle| {
            self.mesh.triangles.push(triangle.map(|k| face.corners[k]));
            if !face.uvs.is_empty() {
                // Faces before had none.
                self.uvs.resize(self.mesh.triangles.len() - 1, [Vec2::ZERO; 3]);
                self.uvs.push(triangle.map(|k| Vec2::new(face.uvs[2 * k], 1.0 - face.uvs[2 * k + 1])));
            }
            if let [Some(r), Some(g), Some(b)] = face.color {
                self.colors.resize(self.mesh.triangles.len() - 1, Vec3::ONE);
                self.colors.push(Vec3::new(r, g, b));
            }
            if let Some(image) = face.image {
                self.owners.resize(self.mesh.triangles.len() - 1, 0);
                self.owners.push(image);
            }
        });
        self.tangled += usize::from(cut == Cut::Tangled);
        Ok(())
    }

    /// One part for each image in use.
    pub(crate) fn parts(mut self, path: &Path, context: &mut Context) -> Result<Vec<Part>, String> {
        context.tell_tangled(path, self.tangled);
        self.drop_infinite();
        let vertices = self.mesh.positions.len();
        let is_bare = self.mesh.normals.len() != vertices;
        if is_bare {
            // Faces that share a vertex share all that it has.
            let groups: Vec<u32> = (0..vertices as u32).collect();
            let all = self.mesh.triangles.clone();
            self.mesh.remove_doubles(false);
            self.mesh.smooth_normals_in(&groups);
            self.mesh.triangles = all;
        } else {
            context.tell_broken(path, self.mesh.repair_normals());
        }
        if self.clear > 0 {
            context.warn(path, "the alpha of its colours is not read: surfaces are opaque");
        }
        if self.mesh.colors.len() != vertices {
            self.mesh.colors.clear();
        }
        for note in
            [&mut self.mesh.colors, &mut self.colors].into_iter().filter_map(|colors| vertex_colors::decode(colors))
        {
            context.warn(path, note);
        }
        self.mesh.uv_sets.retain(|set| set.len() == vertices);
        context.tell_broken_uvs(path, broken_uvs(self.mesh.uv_sets.iter().flatten()));
        let triangles = self.mesh.triangles.len();
        if !self.uvs.is_empty() {
            self.uvs.resize(triangles, [Vec2::ZERO; 3]);
        }
        if !self.mesh.colors.is_empty() {
            self.colors.clear();
        } else if !self.colors.is_empty() {
            self.colors.resize(triangles, Vec3::ONE);
        }
        self.split(path, context, is_bare)
    }

    fn split(mut self, path: &Path, context: &mut Context, is_bare: bool) -> Result<Vec<Part>, String> {
        let name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        let has_colors = !self.mesh.colors.is_empty() || !self.colors.is_empty();
        let has_own = !self.uvs.is_empty() || !self.colors.is_empty();
        let has_uvs = !self.uvs.is_empty() || !self.mesh.uv_sets.is_empty();
        if !self.images.is_empty() && !has_uvs {
            context.warn(path, "names an image and has no texture coordinates: it is not shown");
            self.images.clear();
        }
        self.owners.resize(if self.images.len() > 1 { self.mesh.triangles.len() } else { 0 }, 0);
        let mut parts = Vec::new();
        for image in 0..self.images.len().max(1) {
            let mesh = if has_own || !self.owners.is_empty() {
                self.apart((!self.owners.is_empty()).then_some(image))
            } else {
                core::mem::take(&mut self.mesh)
            };
            if mesh.triangles.is_empty() {
                continue;
            }
            let white: Appearance = Lambert { albedo: Vec3::ONE }.into();
            let color = self.images.get(image).map(|file| texture(file, path, context)).transpose()?.flatten();
            let appearance = match color {
                Some(map) => Some(Appearance { surface: Surface { color: Some(map), ..Surface::default() }, ..white }),
                None => has_colors.then_some(white),
            };
            let name = if self.owners.is_empty() { name.clone() } else { format!("{name} {image}") };
            context.files.budget.take_mesh(&mesh, 1, &name)?;
            parts.push(Part { is_bare, ..Part::fixed(name, mesh, appearance.map(|appearance| (image, appearance))) });
        }
        Ok(parts)
    }

    /// The triangles of an image, or all, with one vertex for each combination of what corners have.
    fn apart(&self, image: Option<usize>) -> Mesh {
        let mut out = Mesh::default();
        let mut uvs: Vec<Vec2> = Vec::new();
        let mut known: HashMap<(u32, [u32; 2], [u32; 3]), u32> = HashMap::new();
        let of = &self.mesh;
        for (t, triangle) in of.triangles.iter().enumerate() {
            // Numbers of images that are not there mean the first.
            let owner = self.owners.get(t).map_or(0, |n| usize::try_from(*n).unwrap_or(0));
            let owner = if owner < self.images.len() { owner } else { 0 };
            if image.is_some_and(|image| image != owner) {
                continue;
            }
            let color = self.colors.get(t).copied();
            out.triangles.push(core::array::from_fn(|k| {
                let i = triangle[k] as usize;
                let uv = self.uvs.get(t).map(|uvs| uvs[k]).or_else(|| of.uv_sets.first().map(|set| set[i]));
                let bits = |v: Vec2| v.to_array().map(f32::to_bits);
                let key =
                    (triangle[k], uv.map_or([0; 2], bits), color.map_or([0; 3], |c| c.to_array().map(f32::to_bits)));
                *known.entry(key).or_insert_with(|| {
                    out.positions.push(of.positions[i]);
                    out.normals.extend(of.normals.get(i));
                    out.colors.extend(color.or_else(|| of.colors.get(i).copied()));
                    uvs.extend(uv);
                    out.positions.len() as u32 - 1
                })
            }));
        }
        if !uvs.is_empty() {
            out.uv_sets.push(uvs);
        }
        out
    }
}

/// The image that the header names; none, with a warning, where it is missing.
fn texture(name: &str, path: &Path, context: &mut Context) -> Result<Option<TextureMap>, String> {
    let Some(file) = context.files.beside(path, name) else {
        context.warn(path, format!("image {name} is not there: its surfaces are white"));
        return Ok(None);
    };
    let bytes = context.files.read(&file).map_err(|e| e.to_string())?;
    let texture = image_file::decode(name, &extension(&file), &bytes, Encoding::Srgb, &context.files.budget)?;
    Ok(Some(TextureMap::new(texture)))
}
