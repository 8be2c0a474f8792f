//! Meshes carried by joints.

use crate::Mesh;
use crate::creases::{Split, picked};
use crate::mesh::MAX_COORDINATE;
use crate::normals::same_places;
use glam::{Mat3, Mat4, Vec3};
use lobe_core::Sphere;

/// A mesh in bind space, with the joints and weights that carry its vertices.
#[derive(Clone, Debug, Default)]
pub struct Deformer {
    /// In bind space.
    pub positions: Vec<Vec3>,
    /// One a vertex; none where the mesh has none or they are `smooth`.
    pub normals: Vec<Vec3>,
    /// The four joints of each vertex.
    pub joints: Vec<[u16; 4]>,
    /// Not negative, of sum 1.
    pub weights: Vec<[f32; 4]>,
    /// Displacements at weight 1, one a vertex.
    pub targets: Vec<Vec<Vec3>>,
    /// The same of the normals; empty for targets without.
    pub normal_targets: Vec<Vec<Vec3>>,
    /// The groups of vertices with a common normal or its opposite, where normals follow from the triangles in every pose.
    pub smooth: Option<Vec<(u32, bool)>>,
}

impl Deformer {
    /// All of a mesh on joint 0.
    #[must_use]
    pub fn rigid(mesh: &Mesh) -> Self {
        let n = mesh.positions.len();
        Self {
            positions: mesh.positions.clone(),
            normals: mesh.normals.clone(),
            joints: vec![[0; 4]; n],
            weights: vec![[1.0, 0.0, 0.0, 0.0]; n],
            ..Self::default()
        }
    }

    /// Leaves the mesh without normals of its own.
    pub fn drop_normals(&mut self) {
        self.normals.clear();
        self.normal_targets.clear();
    }

    /// Takes smooth normals instead of those of the file; `mesh` has the triangles.
    pub fn smooth_normals(&mut self, mesh: &Mesh) {
        self.drop_normals();
        let triangles = mesh.triangles.clone();
        let mut bind = Mesh { positions: self.positions.clone(), triangles, ..Mesh::default() };
        if self.is_rigid() && self.targets.is_empty() {
            bind.smooth_normals();
            self.normals = bind.normals;
        } else {
            self.smooth = Some(same_places(&bind.positions).into_iter().map(|place| (place, false)).collect());
        }
    }

    /// Takes the vertices of a mesh that was split, `mesh`, and smooth normals within its creases.
    pub fn split(&mut self, split: &Split, mesh: &Mesh) {
        self.drop_normals();
        let sources = &split.sources;
        self.positions = picked(&self.positions, sources);
        self.joints = picked(&self.joints, sources);
        self.weights = picked(&self.weights, sources);
        self.targets.iter_mut().for_each(|target| *target = picked(target, sources));
        if self.is_rigid() && self.targets.is_empty() {
            let triangles = mesh.triangles.clone();
            let mut bind = Mesh { positions: self.positions.clone(), triangles, ..Mesh::default() };
            bind.smooth_normals_of(&split.groups);
            self.normals = bind.normals;
        } else {
            self.smooth = Some(split.groups.clone());
        }
    }

    /// Whether one matrix carries all vertices.
    pub(crate) fn is_rigid(&self) -> bool {
        self.joints.iter().flatten().all(|&j| j == 0)
    }

    /// The blended matrix of a vertex: Σ w·J.
    fn blended(&self, vertex: usize, joints: &[Mat4]) -> Mat4 {
        blend(self.joints[vertex], self.weights[vertex], joints)
    }

    /// Poses the mesh, which has this one's vertices: `p = Σ_j w_j J_j (p_bind + Σ_k m_k Δ_k)`. Normals go with the
    /// inverse transpose of the blended matrix. Nothing is allocated, but for `smooth` normals one vector a vertex.
    pub fn pose(&self, joints: &[Mat4], morph: &[f32], mesh: &mut Mesh) {
        mesh.positions.copy_from_slice(&self.positions);
        if self.smooth.is_none() {
            mesh.normals.clone_from(&self.normals);
        }
        for (k, &amount) in morph.iter().enumerate().filter(|&(_, &m)| m != 0.0) {
            let add = |to: &mut [Vec3], by: &[Vec3]| to.iter_mut().zip(by).for_each(|(p, d)| *p += amount * *d);
            add(&mut mesh.positions, &self.targets[k]);
            if let (None, Some(normals)) = (&self.smooth, self.normal_targets.get(k)) {
                add(&mut mesh.normals, normals);
            }
        }
        let limit = Vec3::splat(MAX_COORDINATE);
        let place = |matrix: &Mat4, p: Vec3| matrix.transform_point3(p.clamp(-limit, limit)).clamp(-limit, limit);
        let turn = |cofactors: &Mat3, n: Vec3| (*cofactors * n).try_normalize().unwrap_or(Vec3::Y);
        let rigid = self.is_rigid();
        if rigid {
            let (matrix, cofactors) = (joints[0], cofactors(&joints[0]));
            mesh.positions.iter_mut().for_each(|p| *p = place(&matrix, *p));
            if self.smooth.is_none() {
                mesh.normals.iter_mut().for_each(|n| *n = turn(&cofactors, *n));
            }
        } else if self.smooth.is_some() || mesh.normals.is_empty() {
            for (i, p) in mesh.positions.iter_mut().enumerate() {
                *p = place(&self.blended(i, joints), *p);
            }
        } else {
            for (i, (p, n)) in mesh.positions.iter_mut().zip(&mut mesh.normals).enumerate() {
                let matrix = self.blended(i, joints);
                *p = place(&matrix, *p);
                *n = turn(&cofactors(&matrix), *n);
            }
        }
        if let Some(groups) = &self.smooth {
            mesh.smooth_normals_of(groups);
        }
    }

    /// Whether the first pose turns most vertices inside out.
    #[must_use]
    pub fn mirrors(&self, joints: &[Mat4]) -> bool {
        let inside_out = |i: usize| Mat3::from_mat4(self.blended(i, joints)).determinant() < 0.0;
        2 * (0..self.positions.len()).filter(|&i| inside_out(i)).count() > self.positions.len()
    }

    /// A sphere of the posed mesh, bound to the vertex nearest to its centre.
    #[must_use]
    pub fn bind_sphere(&self, sphere: Sphere, posed: &[Vec3], joints: &[Mat4]) -> BoundSphere {
        let far = |&i: &usize| posed[i].as_dvec3().distance_squared(sphere.center.as_dvec3());
        let nearest = (0..posed.len()).min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(0);
        BoundSphere::new(sphere, self.joints[nearest], self.weights[nearest], joints)
    }
}

/// A sphere that joints carry; its radius goes with the cube root of the determinant.
#[derive(Clone, Copy, Debug)]
pub struct BoundSphere {
    bind: Sphere,
    joints: [u16; 4],
    weights: [f32; 4],
}

impl BoundSphere {
    /// Binds a sphere of the posed scene to four joints.
    #[must_use]
    pub fn new(sphere: Sphere, on: [u16; 4], weights: [f32; 4], joints: &[Mat4]) -> Self {
        let matrix = blend(on, weights, joints);
        let inverse = matrix.inverse();
        // Joints that flatten space have no inverse. Then the sphere keeps its size and moves as a point.
        let bind = if inverse.is_finite() { scaled(sphere, &inverse) } else { sphere };
        Self { bind, joints: on, weights }
    }

    /// The joints that carry it.
    pub(crate) fn joints(&self) -> impl Iterator<Item = u16> {
        joints_in_use(self.joints, self.weights)
    }

    pub(crate) fn at(&self, joints: &[Mat4]) -> Sphere {
        scaled(self.bind, &blend(self.joints, self.weights, joints))
    }
}

/// A sphere moved by a matrix; the radius is never 0.
pub(crate) fn scaled(sphere: Sphere, matrix: &Mat4) -> Sphere {
    let limit = Vec3::splat(MAX_COORDINATE);
    let center = matrix.transform_point3(sphere.center).clamp(-limit, limit);
    let size = Mat3::from_mat4(*matrix).determinant().abs().cbrt();
    Sphere { center, radius: (sphere.radius * size).clamp(f32::MIN_POSITIVE, MAX_COORDINATE) }
}

/// The joints that [`blend`] looks at: the first one and those that have a weight.
pub(crate) fn joints_in_use(on: [u16; 4], weights: [f32; 4]) -> impl Iterator<Item = u16> {
    (0..4).filter(move |&k| k == 0 || weights[k] > 0.0).map(move |k| on[k])
}

fn blend(on: [u16; 4], weights: [f32; 4], joints: &[Mat4]) -> Mat4 {
    let mut sum = joints[usize::from(on[0])] * weights[0];
    for k in 1..4 {
        if weights[k] > 0.0 {
            sum += joints[usize::from(on[k])] * weights[k];
        }
    }
    sum
}

/// The inverse transpose but for a positive factor, for singular matrices as well; largest entry about 1.
fn cofactors(matrix: &Mat4) -> Mat3 {
    let linear = Mat3::from_mat4(*matrix);
    let largest = linear.x_axis.abs().max(linear.y_axis.abs()).max(linear.z_axis.abs()).max_element();
    if largest <= 0.0 || !largest.is_finite() {
        return Mat3::IDENTITY;
    }
    let linear = linear * (1.0 / largest.max(f32::MIN_POSITIVE));
    let (x, y, z) = (linear.x_axis, linear.y_axis, linear.z_axis);
    let sign = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
    Mat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign
}
