/// Why no sphere set could be built from a mesh.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// No spheres were asked for.
    #[error("a sphere set needs at least one sphere")]
    NoSpheres,
    /// The mesh has no triangles.
    #[error("the mesh has no triangles")]
    EmptyMesh,
    /// A triangle names a vertex that does not exist.
    #[error("triangle {triangle} refers to vertex {vertex}, but the mesh has {vertices} vertices")]
    VertexOutOfRange {
        /// Number of the triangle.
        triangle: usize,
        /// The vertex it asks for.
        vertex: u32,
        /// Vertices in the mesh.
        vertices: usize,
    },
    /// A vertex used by a triangle is infinite or not a number.
    #[error("vertex {vertex} of the mesh is not finite")]
    NonFiniteVertex {
        /// Number of the vertex.
        vertex: u32,
    },
    /// All triangles together have no area.
    #[error("the mesh has no area")]
    NoArea,
    /// The mesh is larger or smaller than single precision can hold.
    #[error("the mesh's extent is outside the range of single precision")]
    ExtentOutOfRange,
    /// The progress callback asked to stop.
    #[error("the sphere set was cancelled")]
    Cancelled,
}

/// Why a sphere-set file was refused; the message is one line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("sphere set: {message}")]
pub struct SetFileError {
    pub(crate) message: String,
}
