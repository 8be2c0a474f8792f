// What MaskVisibility does besides masks: how they are turned, how far a lobe's window reaches. Needs edges.wgsl and
// special.wgsl of lobe-core.

// How much more the horizon's direction matters than a blocker's: what emits is cut by rows only.
const HORIZON = 4.0;

// The edge of the horizon where it cuts the light.
fn horizon_edge(basis: EdgeFrame, normal: vec3f, cone: Cone) -> vec2f {
    let cos = dot(normal, cone.axis);
    // The horizon's chord: its distance from the middle is cos β/(sin β tan θ).
    let tan = cone_tan(cone);
    let off_sq = cos * cos / (max(1.0 - cos * cos, 0.0) * (tan * tan));
    if (off_sq < 1.0) {
        return edges_add(basis, normal, HORIZON * 2.0 * sqrt(1.0 - off_sq));
    }
    return vec2f(0.0);
}

// How far a lobe's own window reaches, in its standard deviations: √(2 ln(2/τ)).
fn zoom_sigmas(tolerance: f32) -> f32 { return sqrt(2.0 * ln_1p(2.0 / clamp(tolerance, 1e-6, 0.5) - 1.0)); }
