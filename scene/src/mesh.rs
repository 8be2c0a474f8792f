use glam::Vec3;

/// Triangles in world space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// One unit normal a vertex, or empty: then each triangle has its face's normal.
    pub normals: Vec<Vec3>,
    /// Three vertex numbers a triangle.
    pub triangles: Vec<[u32; 3]>,
}
