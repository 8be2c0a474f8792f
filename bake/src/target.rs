//! The surfaces that are baked.

use crate::BakeError;
use glam::{DVec3, Vec2, Vec3};
use lobe_core::{NO_OBJECT, Receiver};
use scene::Mesh;
use scene_files::{GltfDocument, GltfPart};
use serde_json::Value;
use std::path::Path;

/// The surfaces of a file that are baked: parts of its document, by their places there; and a line about each other one.
pub(crate) fn targets(path: &Path, file: &GltfDocument, json: &Value) -> Result<(Vec<usize>, Vec<String>), BakeError> {
    let (mut chosen, mut notes) = (Vec::new(), Vec::new());
    let mut moving = 0;
    for (place, part) in file.parts.iter().enumerate().filter(|(_, part)| part.object.is_some()) {
        let name = &part.name;
        if is_unlit(json, part) {
            continue;
        }
        if part.copies != 1 {
            notes.push(format!("\"{name}\" is not baked: its {} instances share their coordinates", part.copies));
            continue;
        }
        moving += usize::from(part.moves);
        chosen.push(place);
    }
    if moving > 0 {
        notes.push(format!("{moving} moving surfaces have the light of one moment"));
    }
    if chosen.is_empty() {
        let message = "has no surface that light is baked to".to_owned();
        return Err(BakeError::File { path: path.to_owned(), message });
    }
    Ok((chosen, notes))
}

/// Whether all triangles of a part have normals that point against them.
pub(crate) fn is_inverted(part: &GltfPart) -> bool {
    let mesh = &part.geometry;
    let mut faces = (0..mesh.triangles.len()).filter_map(|triangle| Face::new(part, triangle)).peekable();
    let is_against = |face: Face<'_>| face.mean(&mesh.normals, [1.0 / 3.0; 2]).dot(face.normal.as_dvec3()) < 0.0;
    !mesh.normals.is_empty() && faces.peek().is_some() && faces.all(is_against)
}

/// The primitive of a part, as the document has it.
pub(crate) fn primitive<'a>(json: &'a Value, part: &GltfPart) -> &'a Value {
    &json["meshes"][part.mesh]["primitives"][part.primitive]
}

/// The number of a part's material, if it has one.
pub(crate) fn material(json: &Value, part: &GltfPart) -> Option<usize> {
    Some(primitive(json, part)["material"].as_u64()? as usize)
}

fn is_unlit(json: &Value, part: &GltfPart) -> bool {
    let unlit = |number| !json["materials"][number]["extensions"]["KHR_materials_unlit"].is_null();
    material(json, part).is_some_and(unlit)
}

/// A surface, and the coordinates of its corners on a page.
#[derive(Clone, Debug)]
pub(crate) struct Target {
    /// Its place among the parts of the document.
    pub(crate) part: usize,
    /// Its page.
    pub(crate) page: usize,
    /// The set of coordinates on that page, by its number in the file.
    pub(crate) set: usize,
    /// Coordinates of the vertices.
    pub(crate) coordinates: Vec<Vec2>,
    /// Vertices of the triangles, as many as the part has.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// The part's vertex that each vertex is a copy of; `None`: they are the part's own.
    pub(crate) origins: Option<Vec<u32>>,
}

impl Target {
    /// The coordinates of a triangle's corners.
    pub(crate) fn corners(&self, triangle: usize) -> [Vec2; 3] {
        self.triangles[triangle].map(|i| self.coordinates[i as usize])
    }
}

/// A triangle of a part, to be interpolated on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Face<'a> {
    mesh: &'a Mesh,
    corners: [u32; 3],
    normal: Vec3,
    object: u32,
    /// The radius of the sphere that it stands for.
    radius: Option<f32>,
}

impl<'a> Face<'a> {
    /// A triangle; none if it has no area.
    pub(crate) fn new(part: &'a GltfPart, triangle: usize) -> Option<Self> {
        let mesh = &part.geometry;
        let corners = mesh.triangles[triangle];
        let [a, b, c] = corners.map(|i| mesh.positions[i as usize].as_dvec3());
        let cross = (b - a).cross(c - a);
        let normal = (cross.length() > 1e-36).then(|| cross.normalize().as_vec3().normalize())?;
        let object = part.object.map_or(NO_OBJECT, |object| object as u32);
        let radius = part.radii.get(corners[0] as usize).copied();
        Some(Self { mesh, corners, normal, object, radius })
    }

    /// The weights of the corners at a place.
    fn weights([v, w]: [f64; 2]) -> [f64; 3] {
        [1.0 - v - w, v, w]
    }

    fn mean(&self, of: &[Vec3], at: [f64; 2]) -> DVec3 {
        let each = self.corners.iter().zip(Self::weights(at));
        each.map(|(i, weight)| of[*i as usize].as_dvec3() * weight).sum()
    }

    /// The receiver at a place, on the side from which the corners go round against the clock: of a sphere on itself, outside of the
    /// triangle.
    pub(crate) fn receiver(&self, at: [f64; 2]) -> Receiver {
        let face = self.normal;
        let mut normal = face;
        if !self.mesh.normals.is_empty() {
            let smooth = self.mean(&self.mesh.normals, at).normalize_or_zero().as_vec3();
            let smooth = if smooth.dot(face) < 0.0 { -smooth } else { smooth };
            normal = smooth.try_normalize().unwrap_or(face);
        }
        let place = self.mean(&self.mesh.positions, at);
        if let Some(radius) = self.radius {
            let mean = self.mean(&self.mesh.normals, at);
            let outward = mean.normalize_or(face.as_dvec3());
            let position = (place + f64::from(radius) * (outward - mean)).as_vec3();
            let normal = outward.as_vec3().normalize();
            return Receiver { position, normal, face: normal, view: normal, object: self.object };
        }
        let position = place.as_vec3();
        Receiver { position, normal, face, view: face, object: self.object }
    }

    /// The colour of the vertices at a place; white without any.
    pub(crate) fn color(&self, at: [f64; 2]) -> Vec3 {
        if self.mesh.colors.is_empty() { Vec3::ONE } else { self.mean(&self.mesh.colors, at).as_vec3() }
    }

    /// The texture coordinates of a set at a place.
    pub(crate) fn uv(&self, set: usize, at: [f64; 2]) -> Vec2 {
        let Some(uvs) = self.mesh.uv_sets.get(set) else { return Vec2::ZERO };
        let each = self.corners.iter().zip(Self::weights(at));
        each.map(|(i, weight)| uvs[*i as usize] * weight as f32).sum()
    }

    /// The change of texture coordinates of a set from the first corner to the others.
    pub(crate) fn uv_sides(&self, set: usize) -> [Vec2; 2] {
        let Some(uvs) = self.mesh.uv_sets.get(set) else { return [Vec2::ZERO; 2] };
        let [a, b, c] = self.corners.map(|i| uvs[i as usize]);
        [b - a, c - a]
    }

    /// The gradients of u and v of a set over the triangle.
    pub(crate) fn uv_gradients(&self, set: usize) -> [Vec3; 2] {
        let [a, b, c] = self.corners.map(|i| self.mesh.positions[i as usize].as_dvec3());
        let (e1, e2) = (b - a, c - a);
        let n = e1.cross(e2);
        let inverse = 1.0 / n.length_squared();
        if !inverse.is_finite() {
            return [Vec3::ZERO; 2];
        }
        // Of the weights of the second and the third corner.
        let [g1, g2] = [e2.cross(n) * inverse, n.cross(e1) * inverse].map(|g| g.as_vec3());
        let [s1, s2] = self.uv_sides(set);
        [g1 * s1.x + g2 * s2.x, g1 * s1.y + g2 * s2.y]
    }

    /// The value of the vertices at a place; none where they have none.
    pub(crate) fn mix(&self, of: &[Vec3], at: [f64; 2]) -> Option<Vec3> {
        (!of.is_empty()).then(|| self.mean(of, at).as_vec3())
    }

    /// The angles at the corners, in radians.
    pub(crate) fn angles(&self) -> [f64; 3] {
        angles(self.corners.map(|i| self.mesh.positions[i as usize].as_dvec3()))
    }

    /// The angles, in radians, and the area of a part of the triangle, by the places of its corners.
    pub(crate) fn angles_of(&self, at: [[f64; 2]; 3]) -> ([f64; 3], f64) {
        let p = at.map(|at| self.mean(&self.mesh.positions, at));
        (angles(p), 0.5 * (p[1] - p[0]).cross(p[2] - p[0]).length())
    }
}

fn angles(p: [DVec3; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| {
        let (u, v) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
        u.cross(v).length().atan2(u.dot(v))
    })
}
