//! The normals that meshes of files get.

use glam::Vec3;
use scene::Mesh;

/// The normals that meshes of files get.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Normals {
    /// Those of the file. Where it has none, its format says which: glTF has the faces' own; OBJ is smooth within its
    /// smoothing groups (`s`), and has the faces' own elsewhere; PLY is smooth over the vertices that its faces share.
    #[default]
    File,
    /// Those of the faces.
    Face,
    /// Smooth ones, weighted by angles, across edges where faces meet at no more than `crease` degrees: 180 or more
    /// smooths all that touches, vertices in one place included.
    Smooth {
        /// Degrees between the normals of two faces, above 0.
        crease: f32,
    },
}

impl Normals {
    /// Smooth everywhere.
    pub const SMOOTH: Self = Self::Smooth { crease: 180.0 };
}

/// From this angle on a smooth normal hides the face that it belongs to.
const FAR_FROM_FACE: f32 = 40.0;

/// Whether many normals are far from their faces: a twentieth of all corners by more than 40°.
pub(crate) fn hide_edges(mesh: &Mesh) -> bool {
    let cos = FAR_FROM_FACE.to_radians().cos();
    let far = |&t: &[u32; 3]| {
        let face = mesh.face_cross(t).normalize_or_zero().as_vec3();
        t.iter().filter(|&&i| mesh.normals[i as usize].dot(face).abs() < cos && face != Vec3::ZERO).count()
    };
    !mesh.normals.is_empty() && 20 * mesh.triangles.iter().map(far).sum::<usize>() > 3 * mesh.triangles.len()
}

/// How far to a side of a face a normal must point to be a fault beside one that points as far to the other side.
const AGAINST: f64 = 0.3;

/// Turns round the normals that point against all of their faces, where other corners of one of these faces have normals that point
/// along. Returns how many these are, and how many faces still have normals to both sides.
///
/// A mesh whose normals all point against its faces stays as it is: surfaces have two sides.
pub(crate) fn turn_strays(mesh: &mut Mesh) -> [usize; 2] {
    let side = |mesh: &Mesh, t: [u32; 3]| {
        let face = mesh.face_cross(t).normalize_or_zero();
        t.map(|i| mesh.normals[i as usize].as_dvec3().dot(face))
    };
    let is_mixed = |s: &[f64; 3]| s.iter().any(|s| *s < -AGAINST) && s.iter().any(|s| *s > AGAINST);
    if mesh.normals.is_empty() {
        return [0; 2];
    }
    let sides: Vec<[f64; 3]> = mesh.triangles.iter().map(|&t| side(mesh, t)).collect();
    if !sides.iter().any(is_mixed) {
        return [0; 2];
    }
    // Of each vertex: whether a face of both sides has it, and whether no face has it along.
    let (mut at_mixed, mut against) = (vec![false; mesh.normals.len()], vec![true; mesh.normals.len()]);
    for (t, s) in mesh.triangles.iter().zip(&sides) {
        for (&i, &s) in t.iter().zip(s) {
            against[i as usize] &= s < 0.0;
        }
        t.iter().filter(|_| is_mixed(s)).for_each(|&i| at_mixed[i as usize] = true);
    }
    let mut turned = 0;
    for (i, n) in mesh.normals.iter_mut().enumerate() {
        if at_mixed[i] && against[i] {
            *n = -*n;
            turned += 1;
        }
    }
    let left = mesh.triangles.iter().filter(|&&t| is_mixed(&side(mesh, t))).count();
    [turned, left]
}
