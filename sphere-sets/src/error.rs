/// Why no sphere set could be built from a mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// No spheres were requested.
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
    /// A bound was requested of a mesh that encloses nothing.
    #[error("the mesh has no inside that spheres could bound: it is open or a sheet, leave the bound out")]
    NoInside,
    /// The mesh is larger or smaller than single precision can hold.
    #[error("the mesh's extent is outside the range of single precision")]
    ExtentOutOfRange,
    /// The most spheres allowed do not bring the silhouette error down to what was requested.
    #[error(
        "{count} spheres leave a silhouette error of {:.2} %, but {:.2} % is requested: allow more spheres or a larger error",
        .reached * 100.0, .requested * 100.0
    )]
    ToleranceNotReached {
        /// Spheres that were allowed.
        count: usize,
        /// The error that they leave.
        reached: f32,
        /// The error that was requested.
        requested: f32,
    },
    /// The tolerance is not a number between 0 and 1.
    #[error("the tolerance of a sphere set should be above 0 and at most 1")]
    BadTolerance,
    /// The progress callback stopped the build.
    #[error("the sphere set was cancelled")]
    Cancelled,
}

/// Why a sphere set could not be bound to bones, or not be posed by them.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BindError {
    /// Fewer of something than needed.
    #[error("{found} {what}, but {needed} are needed")]
    Missing {
        /// The missing items.
        what: &'static str,
        /// The number found.
        found: usize,
        /// The number needed.
        needed: usize,
    },
    /// A weight is negative or not finite.
    #[error("vertex {vertex} has a joint weight that is negative or not finite")]
    BadWeight {
        /// Number of the vertex.
        vertex: usize,
    },
    /// A vertex is carried by a joint that does not exist.
    #[error("vertex {vertex} is carried by joint {joint}, but there are {joints} joints")]
    NoSuchJoint {
        /// Number of the vertex.
        vertex: usize,
        /// The joint it asks for.
        joint: u16,
        /// Joints there are.
        joints: usize,
    },
    /// The mesh is none that a set could be built from.
    #[error(transparent)]
    Mesh(#[from] BuildError),
}

/// Why a sphere set does not belong to a mesh; the message is one line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("sphere set made for another mesh: {message}")]
pub struct MisfitError {
    pub(crate) message: String,
}

/// Why a sphere-set file was refused; the message is one line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("sphere set: {message}")]
pub struct SetFileError {
    pub(crate) message: String,
}
