// MaskVisibility for blockers, by a workgroup. Needs mask.wgsl, edges.wgsl, total.wgsl, fraction.wgsl; from the strategies
// `blockers_edges(lane, tile, at, light, window) -> vec4f` (a thread's part of the sums of edges) and
// `blockers_splat(lane, tile, at, light, mask)`; and one of visibility_whole.wgsl and visibility_window.wgsl.

// Numbers of masks across and upward, computed by the first thread: for broad lobes, then for narrow ones. They include the bands
// of a mask, which are one above the other.
var<workgroup> grid_counts: vec4u;
// Bands of a mask; whether broad lobes have fine masks; whether narrow lobes have finer ones; whether the masks of the whole light
// are too many to be stored, and are drawn for each lobe.
var<workgroup> grid_forms: vec4u;
// Samples of all masks of the whole light, in this thread's rows: lit samples, and emitting samples.
var<private> broad_areas: vec2u;

// The crowding from which on there are more samples: lights of 65° and more.
const CROWDED = 4.0;
// The tolerances from which on masks are coarse, and in one piece.
const COARSE = 0.005;
const FINEST = 0.002;

// As `MaskVisibility::depth`, and the tolerance of its masks. A deeper mask is here several bands of SIDE rows.
fn visibility_fineness(light: Cone, tolerance: f32) {
    grid_counts = vec4u(BROAD_GRID, NARROW_GRID);
    grid_forms = vec4u(1u, 0u, u32(IS_NARROW_FINER), 0u);
    let cos = max(1.0 - light.one_minus_cos, 1.0 / WIDEST_TAN);
    let crowding = (1.0 + cos) / (2.0 * cos * cos);
    if (light_is_flat() || crowding < CROWDED) {
        return;
    }
    let bands = min(select(2u, 4u, crowding >= 4.0 * CROWDED), MOST_BANDS);
    let finer = tolerance * min(2.0 * CROWDED / crowding, 1.0);
    let is_fine = finer < COARSE;
    let is_finest = finer < FINEST;
    let broad = select(vec2u(1u), vec2u(2u), is_finest);
    let narrow = select(select(vec2u(1u), vec2u(2u), is_fine), vec2u(3u, 2u), is_finest);
    // If all rows have 64 samples, four masks side by side have 256.
    row_refine(is_fine);
    let parts = select(1u, 256u / row_width, is_fine);
    grid_counts = vec4u(broad * vec2u(parts, bands), narrow * vec2u(1u, bands));
    grid_forms = vec4u(bands, u32(is_fine), u32(!is_fine || any(broad != narrow)), 1u);
}

// Draws the mask of part `k` of `grid`. This function and the following ones require uniform control flow.
fn visibility_draw(
    lane: u32, tile: u32, at: Receiver, light: Cone, window: UnitSquare, k: u32, grid: vec2u, bands: u32
) -> Mask {
    row_bands = bands;
    row_first = SIDE * (k / grid.x % bands);
    let mask = mask_reset(square_part(window, k, grid), lane, at.normal);
    blockers_splat(lane, tile, at, light, mask);
    row_bands = 1u;
    row_first = 0u;
    return mask;
}

// Draws the masks of the whole light, and returns its window.
fn visibility_window(lane: u32, tile: u32, at: Receiver, light: Cone, tolerance: f32) -> UnitSquare {
    if (lane == 0u) {
        visibility_fineness(light, tolerance);
    }
    let window = light_window(light, visibility_across(lane, tile, at, light, light_turn(light)), at.normal);
    let grid = workgroupUniformLoad(&grid_counts).xy;
    let forms = workgroupUniformLoad(&grid_forms);
    row_refine(forms.y > 0u);
    broad_areas = vec2u(0u);
    for (var k = 0u; k < grid.x * grid.y; k++) {
        let mask = visibility_draw(lane, tile, at, light, window, k, grid, forms.x);
        broad_areas += vec2u(row_count(lit), emitting.y - min(emitting.x, emitting.y));
        visibility_drawn(lane, k, mask, window, at);
    }
    return window;
}

// Lit and emitting samples of all masks.
fn visibility_areas(lane: u32) -> vec2f { return total(lane, vec4f(vec2f(broad_areas), 0.0, 0.0)).xy; }

// Coverage of the emitting region by all masks.
fn visibility_coverage(lane: u32) -> u32 {
    let areas = visibility_areas(lane);
    if (areas.x == areas.y) {
        return LIT;
    }
    return select(PARTIAL, DARK, areas.x == 0.0);
}

// The direction across most edges in a window: those of blockers and, if it cuts the light, the horizon.
fn visibility_across(lane: u32, tile: u32, at: Receiver, light: Cone, window: Cone) -> vec3f {
    let basis = edges_frame(window.axis);
    let edges = total(lane, blockers_edges(lane, tile, at, light, window));
    let sum = EDGES_NOTHING + edges.xy + edges_add_plane(basis, at.normal, window);
    return edges_across(basis, sum, edges.zw);
}
