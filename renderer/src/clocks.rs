/// Seconds of work that is done once.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Clocks {
    /// Seconds of fitting and reading sphere sets.
    pub spheres: f64,
    /// Seconds of computing or reading the paper's tables.
    pub tables: f64,
}

/// Seconds of one frame, outside shading. The hierarchy and the silhouettes are updated at the same time, so that their sum may be more than has
/// passed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameClocks {
    /// Updating positions, normals, lights and camera to the frame's time.
    pub pose: f64,
    /// Moving the spheres, and updating the hierarchy over them.
    pub spheres: f64,
    /// Hierarchy over triangles and exact spheres: built for the first frame, refitted for others.
    pub hierarchy: f64,
    /// Edges, planes and their hierarchy: built for the first frame, refitted for others.
    pub silhouettes: f64,
    /// Drawing shadow maps.
    pub maps: f64,
    /// Finding the visible points.
    pub gbuffer: f64,
}
