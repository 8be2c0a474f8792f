use crate::normals::{angle_at, is_usable, same_places};
use crate::{Bounds, SceneError};
use foldhash::fast::RandomState;
use glam::{DVec3, Mat3, Mat4, Vec2, Vec3};
use std::collections::HashSet;

/// Triangles in world space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// One unit normal a vertex, or empty: then each triangle has its face's normal.
    pub normals: Vec<Vec3>,
    /// Three vertex numbers a triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Sets of texture coordinates, v downward, one pair a vertex each.
    pub uv_sets: Vec<Vec<Vec2>>,
    /// One linear colour in [0, 1] a vertex, a factor of the material's, or empty.
    pub colors: Vec<Vec3>,
}

/// Larger coordinates are refused: single precision resolves 64 there, and squares of differences are far
/// from overflow.
pub const MAX_COORDINATE: f32 = lobe_core::Sphere::LARGEST;

impl Mesh {
    /// The smallest box that holds all vertices that a triangle uses.
    #[must_use]
    pub fn bounds(&self) -> Bounds {
        self.triangles
            .iter()
            .flatten()
            .filter_map(|&i| self.positions.get(i as usize))
            .fold(Bounds::EMPTY, |b, &p| b.with_point(p))
    }

    /// The smallest box that holds all vertices that a triangle uses, moved by an affine matrix, each rounded as
    /// [`Mat4::transform_point3`] rounds it. Linear in the triangles.
    ///
    /// ```
    /// use scene::{Mesh, glam::{Mat4, Vec3}};
    /// let cube = Mesh::cuboid(Vec3::ZERO, Vec3::ONE);
    /// assert_eq!(cube.bounds_at(&Mat4::from_scale(Vec3::splat(-2.0))).min, Vec3::splat(-1.0));
    /// ```
    #[must_use]
    pub fn bounds_at(&self, matrix: &Mat4) -> Bounds {
        let vertices = self.triangles.iter().flatten().filter_map(|&i| self.positions.get(i as usize));
        vertices.fold(Bounds::EMPTY, |b, &p| b.with_point(matrix.transform_point3(p)))
    }

    /// Sum of the triangles' areas.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.triangles.iter().map(|&t| 0.5 * self.face_cross(t).length()).sum()
    }

    /// Checks that there is a triangle, that all positions are finite and within ±1e9, that normals are unit vectors,
    /// one a vertex or none at all, as texture coordinates and colours are, and that the triangles refer to vertices that exist.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] that names the first fault.
    pub fn validate(&self) -> Result<(), SceneError> {
        if self.triangles.is_empty() {
            return Err(SceneError::invalid("mesh has no triangles"));
        }
        if let Some(i) = self.positions.iter().position(|p| p.is_nan() || p.abs().max_element() > MAX_COORDINATE) {
            let [x, y, z] = self.positions[i].to_array();
            return Err(SceneError::invalid(format!(
                "vertex {i} is [{x:e}, {y:e}, {z:e}]: coordinates must lie within ±1e9"
            )));
        }
        if !self.normals.is_empty() && self.normals.len() != self.positions.len() {
            let (n, p) = (self.normals.len(), self.positions.len());
            return Err(SceneError::invalid(format!("mesh has {n} normals for {p} vertices")));
        }
        if let Some(i) = self.normals.iter().position(|n| n.is_nan() || (n.length() - 1.0).abs() > 1e-3) {
            return Err(SceneError::invalid(format!("normal {i} is {}: expected a unit vector", self.normals[i])));
        }
        let vertices = self.positions.len();
        if let Some(set) = self.uv_sets.iter().position(|set| set.len() != vertices) {
            let n = self.uv_sets[set].len();
            return Err(SceneError::invalid(format!("set {set} has {n} texture coordinates for {vertices} vertices")));
        }
        if !self.colors.is_empty() && self.colors.len() != vertices {
            let n = self.colors.len();
            return Err(SceneError::invalid(format!("mesh has {n} colours for {vertices} vertices")));
        }
        if let Some(i) = self.colors.iter().position(|c| !(c.min_element() >= 0.0 && c.max_element() <= 1.0)) {
            return Err(SceneError::invalid(format!("colour {i} is {}: expected [0, 1]", self.colors[i])));
        }
        for (i, t) in self.triangles.iter().enumerate() {
            if let Some(v) = t.iter().find(|&&v| v as usize >= vertices) {
                return Err(SceneError::invalid(format!("triangle {i} uses vertex {v} of {vertices}")));
            }
        }
        Ok(())
    }

    /// Twice the area times the face normal, in f64: exact enough for needles and far away meshes.
    ///
    /// # Panics
    /// When a corner does not exist.
    #[must_use]
    #[inline]
    pub fn face_cross(&self, [a, b, c]: [u32; 3]) -> DVec3 {
        let p = |i: u32| self.positions[i as usize].as_dvec3();
        (p(b) - p(a)).cross(p(c) - p(a))
    }

    /// Removes the triangles without an area (equal or collinear corners, below 1e-36) and returns their number.
    ///
    /// # Panics
    /// When a triangle refers to a vertex that does not exist.
    pub fn remove_degenerate(&mut self) -> usize {
        let before = self.triangles.len();
        let mut triangles = std::mem::take(&mut self.triangles);
        triangles.retain(|&t| self.face_cross(t).length() > 1e-36);
        self.triangles = triangles;
        before - self.triangles.len()
    }

    /// Removes the triangles that use a vertex twice and returns their number.
    pub fn remove_repeated(&mut self) -> usize {
        let before = self.triangles.len();
        self.triangles.retain(|&[a, b, c]| a != b && b != c && c != a);
        before - self.triangles.len()
    }

    /// Removes the triangles that lie in the place of an earlier one, turned either way, and returns their number: surfaces
    /// have two sides, so only the first one is seen, and a hierarchy cannot separate triangles in one place. Compares
    /// vertex numbers instead of positions if `moves`, because triangles in one place may separate later.
    ///
    /// # Panics
    /// When a triangle refers to a vertex that does not exist.
    pub fn remove_doubles(&mut self, moves: bool) -> usize {
        let before = self.triangles.len();
        let places = if moves { Vec::new() } else { same_places(&self.positions) };
        let sorted = |t: &[u32; 3]| {
            let mut key = if moves { *t } else { t.map(|i| places[i as usize]) };
            key.sort_unstable();
            key
        };
        if !has_doubles(&self.triangles, self.positions.len(), sorted) {
            return 0;
        }
        let mut seen = HashSet::with_capacity_and_hasher(before, RandomState::default());
        self.triangles.retain(|t| seen.insert(sorted(t)));
        before - self.triangles.len()
    }

    /// Replaces the normals by smooth ones: at each position the mean of the adjoining faces' normals, weighted by their
    /// angles there. Vertices with the same position (texture seams) get the same normal. Triangles that wind against the most of
    /// those around them are turned round first.
    ///
    /// A vertex whose normals cancel, or that no triangle uses, gets the normal of one of its faces, or +y.
    ///
    /// # Panics
    /// When a triangle refers to a vertex that does not exist.
    pub fn smooth_normals(&mut self) {
        let places = same_places(&self.positions);
        self.align_windings(&places);
        self.smooth_normals_in(&places);
    }

    /// As [`smooth_normals`](Self::smooth_normals), but not across edges where faces meet at more than `crease` degrees: vertices on
    /// these are split.
    ///
    /// # Panics
    /// When a triangle refers to a vertex that does not exist.
    ///
    /// ```
    /// use scene::{Mesh, glam::Vec3};
    /// let mut cube = Mesh::cuboid(Vec3::ZERO, Vec3::ONE);
    /// cube.smooth_normals_within(60.0);
    /// assert!(cube.normals.iter().all(|n| n.abs().max_element() == 1.0));
    /// ```
    pub fn smooth_normals_within(&mut self, crease: f32) {
        if crease >= 180.0 {
            self.smooth_normals();
        } else {
            let groups = self.split_at_creases(crease).groups;
            self.smooth_normals_of(&groups);
        }
    }

    /// Smooth normals, shared by the vertices of a group: numbers from 0, each less than the number of vertices.
    ///
    /// # Panics
    /// When a vertex has no group.
    pub fn smooth_normals_in(&mut self, groups: &[u32]) {
        let groups: Vec<(u32, bool)> = groups.iter().map(|&group| (group, false)).collect();
        self.smooth_normals_of(&groups);
    }

    /// The same, where some vertices of a group have the opposite normal.
    ///
    /// # Panics
    /// When a vertex has no group.
    pub fn smooth_normals_of(&mut self, groups: &[(u32, bool)]) {
        let mut sums = vec![DVec3::ZERO; groups.iter().map(|&(g, _)| g as usize + 1).max().unwrap_or(0)];
        let mut some_face = vec![DVec3::Y; sums.len()];
        for &t in &self.triangles {
            let normal = self.face_cross(t).normalize_or_zero();
            if normal == DVec3::ZERO {
                continue;
            }
            let corners = t.map(|i| self.positions[i as usize].as_dvec3());
            for k in 0..3 {
                let (g, is_opposite) = groups[t[k] as usize];
                let normal = if is_opposite { -normal } else { normal };
                sums[g as usize] += angle_at(k, &corners) * normal;
                some_face[g as usize] = normal;
            }
        }
        let normal = |&(g, is_opposite): &(u32, bool)| {
            let (sum, face) = (sums[g as usize], some_face[g as usize]);
            // Below 1e-6 the sum is the rounding error of normals that cancel.
            let normal = if sum.length() > 1e-6 { sum.normalize().as_vec3() } else { face.as_vec3() };
            if is_opposite { -normal.normalize() } else { normal.normalize() }
        };
        self.normals.clear();
        self.normals.extend(groups.iter().map(normal));
    }

    /// Makes given normals unit vectors; normals of length 0 or not finite become smooth normals. Returns their number.
    pub fn repair_normals(&mut self) -> usize {
        let broken = self.normals.iter().filter(|n| !is_usable(n)).count();
        if broken == 0 {
            self.normals.iter_mut().for_each(|n| *n = n.normalize());
            return 0;
        }
        let given = std::mem::take(&mut self.normals);
        self.smooth_normals();
        for (n, given) in self.normals.iter_mut().zip(given) {
            if is_usable(&given) {
                *n = given.normalize();
            }
        }
        broken
    }

    /// Moves the mesh; the last row of the matrix is taken as (0, 0, 0, 1). Normals go with the inverse transpose (the
    /// cofactors, which exist for singular matrices as well), a mirroring matrix also turns the winding round.
    pub fn transform(&mut self, matrix: &Mat4) {
        let linear = Mat3::from_mat4(*matrix);
        for p in &mut self.positions {
            *p = matrix.transform_point3(*p);
        }
        let mirrored = linear.determinant() < 0.0;
        if !self.normals.is_empty() {
            let cofactors = normals_matrix(&linear);
            for n in &mut self.normals {
                *n = cofactors * *n;
            }
            self.repair_normals();
        }
        if mirrored {
            self.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
    }

    /// Appends another mesh. Normals, texture coordinates and colours are kept only when both have them.
    pub fn append(&mut self, other: &Self) {
        let (offset, count) = (self.positions.len() as u32, other.positions.len());
        let join = |own: &mut Vec<Vec3>, others: &[Vec3]| {
            if own.len() == offset as usize && others.len() == count {
                own.extend(others);
            } else {
                own.clear();
            }
        };
        join(&mut self.normals, &other.normals);
        join(&mut self.colors, &other.colors);
        if self.positions.is_empty() {
            self.uv_sets.clone_from(&other.uv_sets);
        } else {
            self.uv_sets.truncate(other.uv_sets.len());
            self.uv_sets.iter_mut().zip(&other.uv_sets).for_each(|(own, others)| own.extend(others));
        }
        self.positions.extend(&other.positions);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| i + offset)));
    }
}

/// Whether two triangles have the same key, of whose numbers the first one is less than `count`: by the first one by counting, then the few
/// of each by comparison.
fn has_doubles(triangles: &[[u32; 3]], count: usize, key: impl Fn(&[u32; 3]) -> [u32; 3]) -> bool {
    let mut ends = vec![0_u32; count];
    triangles.iter().for_each(|t| ends[key(t)[0] as usize] += 1);
    for k in 1..count {
        ends[k] += ends[k - 1];
    }
    let mut rest = vec![0; triangles.len()];
    for t in triangles {
        let [first, b, c] = key(t);
        let place = &mut ends[first as usize];
        *place -= 1;
        rest[*place as usize] = u64::from(b) << 32 | u64::from(c);
    }
    // They begin where they ended.
    ends.push(triangles.len() as u32);
    ends.windows(2).any(|range| {
        let own = &mut rest[range[0] as usize..range[1] as usize];
        own.sort_unstable();
        own.windows(2).any(|two| two[0] == two[1])
    })
}

/// A matrix that maps the directions of normals as `linear` maps points: its cofactors, the largest made 1.
pub(crate) fn normals_matrix(linear: &Mat3) -> Mat3 {
    let (x, y, z) = (linear.x_axis, linear.y_axis, linear.z_axis);
    let sign = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
    let cofactors = Mat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign;
    let largest = cofactors.to_cols_array().iter().fold(0.0_f32, |m, v| m.max(v.abs()));
    if largest > 0.0 && largest.is_finite() { cofactors * (1.0 / largest) } else { cofactors }
}
