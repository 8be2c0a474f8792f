// Lobes narrower than the light are seen through masks of their own, with 256 samples a row. Needs visibility.wgsl, and
// special.wgsl of lobe-core.

// The share of the light that a lobe sees. Only where all threads come by.
fn visible_share(lane: u32, tile: u32, at: Receiver, light: Cone, tolerance: f32, whole: UnitSquare, lobe: Lobe) -> f32 {
    if (HAS_MICROFACETS && decide(lane, lobe.factor >= LOBE_MICROFACETS)) {
        return microfacet_share(lane, tile, at, light, tolerance, whole, lobe);
    }
    let sigmas = zoom_sigmas(tolerance);
    let peak = square_peak(whole, lobe, at.normal);
    let square = square_around(whole, peak, sigmas);
    let is_part = any(square.half < whole.half);
    let is_steep = IS_NARROW_FINER && peak_fall(peak, whole) > STEEP;
    if (!decide(lane, !is_lambert(at, lobe) && (is_part || is_steep))) {
        return broad_share(lane, whole, at, lobe);
    }
    var window = whole;
    if (decide(lane, is_part)) {
        // Windows on a flat light are all turned alike.
        var turned = whole;
        if (!light_is_flat()) {
            let turn = visibility_across(lane, tile, at, light, square_cone(square, light.distance));
            turned = light_window(light, turn, at.normal);
        }
        window = square_zoomed(turned, lobe, at.normal, sigmas);
    }
    row_refine(true);
    var sum = vec4f(0.0);
    for (var k = 0u; k < NARROW_PANES.x * NARROW_PANES.y; k++) {
        let mask = mask_reset(square_pane(window, k, NARROW_PANES), lane, at.normal);
        blockers_splat(lane, tile, at, light, mask);
        sum += share_sums(lane, mask, window, at, lobe);
    }
    row_refine(false);
    return share_of(sum);
}

// A lobe whose logarithm falls by more than this over a radius of the light is seen as finely as a narrow one.
const STEEP = 1.0;

// How far a lobe's own window reaches, in its standard deviations: √(2 ln(2/τ)).
fn zoom_sigmas(tolerance: f32) -> f32 { return sqrt(2.0 * ln_1p(2.0 / clamp(tolerance, 1e-6, 0.5) - 1.0)); }
