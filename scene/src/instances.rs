//! One mesh at many places.

use crate::mesh::{MAX_COORDINATE, normals_matrix};
use crate::{Bounds, Mesh, SceneError};
use glam::{Mat3, Mat4, Vec3};
use std::collections::HashSet;
use std::sync::Arc;

/// One mesh at many places, stored once.
///
/// It stands for the [mesh](Self::expanded) that holds a copy for each place, one after the other: triangle `i` of place `k` has the number
/// `k · n + i`, where `n` is the number of the shared mesh's triangles. Corners and normals have the same bits as those of this mesh.
///
/// # Cost
/// The mesh, and 64 bytes for each place. Renderers build what they need for the shared mesh once.
///
/// ```
/// use scene::{Instances, Mesh, glam::{Mat4, Vec3}};
/// use std::sync::Arc;
/// let cube = Arc::new(Mesh::cuboid(Vec3::ZERO, Vec3::ONE));
/// let places = (0..100).map(|k| Mat4::from_translation(Vec3::X * 2.0 * k as f32)).collect();
/// let row = Instances::new(cube, places)?;
/// assert_eq!(row.triangle_count(), 1200);
/// assert_eq!(row.bounds().max.x, 198.5);
/// # Ok::<(), scene::SceneError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Instances {
    mesh: Arc<Mesh>,
    places: Vec<Mat4>,
    bounds: Bounds,
}

/// The same mesh, not only an equal one, at the same places.
impl PartialEq for Instances {
    fn eq(&self, other: &Self) -> bool {
        let is_same = Arc::ptr_eq(&self.mesh, &other.mesh) || self.mesh == other.mesh;
        is_same && self.places == other.places
    }
}

/// The volume of a place's axes over the cube of the longest: flatter ones have no usable normals.
const FLATTEST: f32 = 1e-4;

impl Instances {
    /// A mesh at places, each of which maps the mesh's own coordinates to the world; equal ones count once.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] for a mesh that is [not valid](Mesh::validate), for no places, for a matrix that is not affine or flattens the
    /// mesh, for places beyond ±1e9, and for more than 2³⁰ triangles.
    pub fn new(mesh: Arc<Mesh>, places: Vec<Mat4>) -> Result<Self, SceneError> {
        mesh.validate()?;
        if let Some(i) = places.iter().position(|matrix| !Self::is_place(matrix)) {
            return Err(SceneError::invalid(format!("place {i}: its matrix is not affine, or flattens the mesh")));
        }
        Self::of_valid(mesh, places)
    }

    /// Whether a mesh can stand at a place: the matrix is affine and not flat.
    #[must_use]
    pub fn is_place(matrix: &Mat4) -> bool {
        let linear = Mat3::from_mat4(*matrix);
        let longest = [linear.x_axis, linear.y_axis, linear.z_axis].map(Vec3::length).into_iter().fold(0.0, f32::max);
        let is_affine = matrix.is_finite() && matrix.row(3) == glam::Vec4::W;
        is_affine && longest > 1e-12 && longest < 1e12 && linear.determinant().abs() > FLATTEST * longest.powi(3)
    }

    /// As [`Self::new`] for a mesh that is valid and places of which [`Self::is_place`] holds, without these checks.
    ///
    /// # Errors
    /// As [`Self::new`], for no places, places beyond ±1e9 and too many triangles.
    pub fn of_valid(mesh: Arc<Mesh>, mut places: Vec<Mat4>) -> Result<Self, SceneError> {
        let mut known = HashSet::with_capacity(places.len());
        places.retain(|matrix| known.insert((*matrix + Mat4::ZERO).to_cols_array().map(f32::to_bits)));
        let all = places.len().saturating_mul(mesh.triangles.len());
        if all == 0 || all > 1 << 30 {
            return Err(SceneError::invalid(format!(
                "{} places have {all} triangles: expected 1 to 2^30",
                places.len()
            )));
        }
        let bounds = places.iter().fold(Bounds::EMPTY, |all, matrix| all.union(mesh.bounds_at(matrix)));
        if bounds.min.abs().max(bounds.max.abs()).max_element() > MAX_COORDINATE {
            return Err(SceneError::invalid("places lie beyond ±1e9"));
        }
        Ok(Self { mesh, places, bounds })
    }

    /// The shared mesh, in its own coordinates.
    #[must_use]
    pub const fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// From the mesh's own coordinates to the world.
    #[must_use]
    pub fn places(&self) -> &[Mat4] {
        &self.places
    }

    /// The smallest box that holds all of them. Costs nothing.
    #[must_use]
    pub const fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The number of triangles of all places.
    #[must_use]
    pub fn triangle_count(&self) -> usize {
        self.places.len() * self.mesh.triangles.len()
    }

    /// The place of a triangle, and its vertices in the shared mesh in the order in which they go round in the world.
    ///
    /// # Panics
    /// When there is no such triangle.
    #[must_use]
    pub fn triangle(&self, number: usize) -> (&Mat4, [u32; 3]) {
        let count = self.mesh.triangles.len();
        let matrix = &self.places[number / count];
        let [a, b, c] = self.mesh.triangles[number % count];
        (matrix, if is_mirrored(matrix) { [a, c, b] } else { [a, b, c] })
    }

    /// The corners of a triangle in the world.
    ///
    /// # Panics
    /// When there is no such triangle.
    #[must_use]
    pub fn corners(&self, number: usize) -> [Vec3; 3] {
        let (matrix, vertices) = self.triangle(number);
        vertices.map(|i| matrix.transform_point3(self.mesh.positions[i as usize]))
    }

    /// The unit normal of a vertex of the shared mesh at a place.
    ///
    /// # Panics
    /// When the mesh has no normals.
    #[must_use]
    pub fn normal(&self, matrix: &Mat4, vertex: u32) -> Vec3 {
        (normals_matrix(&Mat3::from_mat4(*matrix)) * self.mesh.normals[vertex as usize]).normalize()
    }

    /// All places as one mesh.
    ///
    /// # Cost
    /// Its memory.
    #[must_use]
    pub fn expanded(&self) -> Mesh {
        let mut all = Mesh::default();
        for matrix in &self.places {
            let mut mesh = Mesh::clone(&self.mesh);
            mesh.transform(matrix);
            all.append(&mesh);
        }
        all
    }

    /// All of it moved.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn moved(&self, matrix: &Mat4) -> Result<Self, SceneError> {
        let places: Vec<Mat4> = self.places.iter().map(|place| *matrix * *place).collect();
        if !places.iter().all(Self::is_place) {
            return Err(SceneError::invalid("the matrix flattens the mesh"));
        }
        Self::of_valid(Arc::clone(&self.mesh), places)
    }
}

/// Whether a matrix turns left hands to right ones.
#[must_use]
pub(crate) fn is_mirrored(matrix: &Mat4) -> bool {
    Mat3::from_mat4(*matrix).determinant() < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    fn places() -> Vec<Mat4> {
        let turn = Quat::from_rotation_y(0.7) * Quat::from_rotation_x(-1.1);
        let scales = [Vec3::ONE, Vec3::new(0.2, 3.0, 1.0), Vec3::new(-1.0, 1.0, 0.5), Vec3::splat(40.0)];
        let place = |(k, scale): (usize, &Vec3)| {
            Mat4::from_scale_rotation_translation(*scale, turn, Vec3::new(3.0, 0.1, -7.0) * k as f32)
        };
        scales.iter().enumerate().map(place).collect()
    }

    #[test]
    fn triangles_have_the_bits_of_the_whole_mesh() {
        let mut mesh = Mesh::cuboid(Vec3::new(0.1, 0.2, 0.3), Vec3::new(1.0, 0.7, 0.4));
        mesh.smooth_normals();
        let all = Instances::new(Arc::new(mesh), places()).expect("valid");
        let whole = all.expanded();
        assert_eq!((whole.triangles.len(), whole.bounds()), (all.triangle_count(), all.bounds()));
        let mut mirrored = 0;
        for (number, triangle) in whole.triangles.iter().enumerate() {
            let bits = |p: [Vec3; 3]| p.map(|p| p.to_array().map(f32::to_bits));
            assert_eq!(bits(all.corners(number)), bits(triangle.map(|i| whole.positions[i as usize])));
            let (matrix, vertices) = all.triangle(number);
            let normals = vertices.map(|i| all.normal(matrix, i));
            assert_eq!(bits(normals), bits(triangle.map(|i| whole.normals[i as usize])));
            mirrored += usize::from(is_mirrored(matrix));
        }
        assert_eq!(mirrored, 12);
        assert!(whole.validate().is_ok());
    }

    #[test]
    fn what_cannot_stand_is_refused() {
        let cube = Arc::new(Mesh::cuboid(Vec3::ZERO, Vec3::ONE));
        let of = |places: &[Mat4]| Instances::new(Arc::clone(&cube), places.to_vec());
        for bad in [
            Mat4::from_scale(Vec3::new(1.0, 0.0, 1.0)),
            Mat4::from_scale(Vec3::splat(f32::NAN)),
            Mat4::from_translation(Vec3::X * 2e9),
            Mat4::from_cols_array(&[1.0; 16]),
        ] {
            assert!(of(&[Mat4::IDENTITY, bad]).is_err(), "{bad}");
        }
        assert!(of(&[]).is_err());
        assert!(Instances::new(Arc::default(), vec![Mat4::IDENTITY]).is_err());
        let twice = of(&[Mat4::IDENTITY, Mat4::IDENTITY]).expect("valid");
        assert_eq!(twice.triangle_count(), 12);
        let moved = twice.moved(&Mat4::from_translation(Vec3::Y)).expect("valid");
        assert_eq!(moved.bounds().max.y, 1.5);
        assert!(twice.moved(&Mat4::ZERO).is_err());
    }
}
