/// Seconds that are spent once.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Clocks {
    /// Fitting and reading sphere sets.
    pub spheres: f64,
    /// The paper's tables.
    pub tables: f64,
}

/// Seconds of one frame, outside shading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameClocks {
    /// Positions, normals, lights and camera of the moment.
    pub pose: f64,
    /// Spheres carried there, and the hierarchy over them.
    pub spheres: f64,
    /// Boxes of the hierarchy over triangles and balls: built for the first frame, refitted for others.
    pub hierarchy: f64,
    /// Edges, planes and their hierarchy: as that.
    pub silhouettes: f64,
    /// Drawing shadow maps.
    pub maps: f64,
    /// Finding the visible points.
    pub gbuffer: f64,
}
