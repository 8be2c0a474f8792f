// Lobes narrower than the light have masks of their own, with 256 samples a row. Needs visibility.wgsl, and special.wgsl of
// lobe-core.

// Emitting and lit samples of this thread's row in each part of the whole light, if the parts are few enough to be stored.
var<private> broad_emitting: array<vec2u, BROAD_COUNT>;
var<private> broad_lit: array<Row, BROAD_COUNT>;
const BROAD_COUNT = BROAD_GRID.x * BROAD_GRID.y;

// Called for each mask of the whole light.
fn visibility_drawn(lane: u32, k: u32, mask: Mask, window: UnitSquare, at: Receiver) {
    if (k < BROAD_COUNT) {
        broad_emitting[k] = emitting;
        broad_lit[k] = lit;
    }
}

// The visible fraction of the light for a lobe. Requires uniform control flow.
fn lobe_fraction(lane: u32, tile: u32, at: Receiver, light: Cone, tolerance: f32, whole: UnitSquare, lobe: Lobe) -> f32 {
    if (HAS_MICROFACETS && decide(lane, lobe.kind >= LOBE_MICROFACETS_F0)) {
        return microfacet_fraction(lane, tile, at, light, tolerance, whole, lobe);
    }
    let counts = workgroupUniformLoad(&grid_counts);
    let forms = workgroupUniformLoad(&grid_forms);
    let sigmas = zoom_sigmas(tolerance);
    let peak = square_peak(whole, lobe, at.normal);
    let square = square_around(whole, peak, sigmas);
    let is_part = any(square.half < whole.half);
    let is_steep = forms.z > 0u && peak_fall(peak, whole) > STEEP;
    let is_own = decide(lane, !is_lambert(at, lobe) && (is_part || is_steep));
    var window = whole;
    if (is_own && decide(lane, is_part)) {
        // All windows on a flat light are turned alike.
        var turned = whole;
        if (!light_is_flat()) {
            let turn = visibility_across(lane, tile, at, light, square_cone(square, light.distance));
            turned = light_window(light, turn, at.normal);
        }
        window = square_zoomed(turned, lobe, at.normal, sigmas);
    }
    let grid = select(counts.xy, counts.zw, is_own);
    row_refine(is_own || forms.y > 0u);
    var sum = vec4f(0.0);
    for (var k = 0u; k < grid.x * grid.y; k++) {
        if (is_own || forms.w > 0u) {
            visibility_draw(lane, tile, at, light, window, k, grid, forms.x);
        } else {
            emitting = broad_emitting[k];
            lit = broad_lit[k];
        }
        sum += fraction_sums(lane, mask_of(square_part(window, k, grid)), window, at, lobe);
    }
    row_refine(forms.y > 0u);
    return fraction_of(sum);
}

// A lobe whose logarithm falls by more than this over a radius of the light has masks as fine as a narrow one.
const STEEP = 1.0;

// The reach of a lobe's own window, in its standard deviations: √(2 ln(2/τ)).
fn zoom_sigmas(tolerance: f32) -> f32 { return sqrt(2.0 * ln_1p(2.0 / clamp(tolerance, 1e-6, 0.5) - 1.0)); }
