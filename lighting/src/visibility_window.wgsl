// Lobes narrower than the light are seen through a mask of their own, with 256 samples a row. Needs visibility.wgsl,
// share.wgsl, and special.wgsl of lobe-core.

// The share of the light that a lobe sees. Only where all threads come by; the mask of the whole light is as before.
fn visible_share(lane: u32, tile: u32, at: Receiver, light: Cone, tolerance: f32, whole: Mask, lobe: Lobe) -> f32 {
    let sigmas = zoom_sigmas(tolerance);
    let peak = square_peak(whole.square, lobe, at.normal);
    let square = square_around(whole.square, peak, sigmas);
    let is_part = any(square.half < whole.square.half);
    let is_steep = HAS_BOTH && peak_fall(peak, whole.square) > STEEP;
    if (!decide(lane, !is_lambert(at, lobe) && (is_part || is_steep))) {
        return share(lane, whole, at, lobe);
    }
    let whole_lit = lit;
    let whole_emitting = emitting;
    var window = whole.square;
    if (decide(lane, is_part)) {
        let turn = visibility_across(lane, tile, at, light, square_cone(square, light.distance));
        window = square_zoomed(square_above(square_facing(light, turn), at.normal), lobe, at.normal, sigmas);
    }
    row_refine(true);
    let mask = mask_reset(window, lane, at.normal);
    blockers_splat(lane, tile, at, light, mask);
    let seen = share(lane, mask, at, lobe);
    lit = whole_lit;
    emitting = whole_emitting;
    row_refine(false);
    return seen;
}

// A lobe whose logarithm falls by more than this over a radius of the light is seen through fine masks.
const STEEP = 1.0;

// How far a lobe's own window reaches, in its standard deviations: √(2 ln(2/τ)).
fn zoom_sigmas(tolerance: f32) -> f32 { return sqrt(2.0 * ln_1p(2.0 / clamp(tolerance, 1e-6, 0.5) - 1.0)); }
