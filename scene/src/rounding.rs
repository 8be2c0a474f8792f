//! Errors of rounding in f32 that the hits of rays allow for, on CPUs and GPUs alike.

/// The distance outside a triangle, in barycentric units, at which a ray still hits: this closes the cracks that rounding leaves
/// along common edges.
pub const EDGE: f32 = 1e-6;

/// The most by which rounding makes a triangle larger, in barycentric units: edge-on ones would have no end.
pub const WIDEST: f32 = 0.05;

/// Relative error of a distance to a triangle: over the start's distance from the corner and the slant, which is
/// `|e1||e2|/det`. A few times what rounding loses; a start this near may be on either side of the plane.
pub const CLOSE: f32 = 2e-6;

/// The same for spheres, as a part of the squared radius.
pub const CLOSE_TO_SPHERE: f32 = 1e-5;

/// The height above the plane of a receiver's face that rounding may give a shape, over its distance: a large triangle
/// must not shade the points on it. A shape that rises less hides a sliver of 3e-7 radians.
pub const BLUR: f32 = 3e-7;
