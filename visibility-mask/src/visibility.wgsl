// What MaskVisibility makes of blockers, by a workgroup. Needs mask.wgsl, edges.wgsl, total.wgsl, share.wgsl, and of the
// strategies that there are `blockers_edges(lane, tile, at, light, window) -> vec4f` (a thread's part of the sums of edges)
// and `blockers_splat(lane, tile, at, light, mask)`.

// What emits and what is lit of the own row of each pane of the whole light.
var<private> broad_emitting: array<vec2u, BROAD_COUNT>;
var<private> broad_lit: array<Row, BROAD_COUNT>;
const BROAD_COUNT = BROAD_PANES.x * BROAD_PANES.y;

// Draws the masks of the whole light, whose window it returns. This and what follows only where all threads come by.
fn visibility_window(lane: u32, tile: u32, at: Receiver, light: Cone) -> UnitSquare {
    let window = light_window(light, visibility_across(lane, tile, at, light, light_turn(light)), at.normal);
    for (var k = 0u; k < BROAD_COUNT; k++) {
        let mask = mask_reset(square_pane(window, k, BROAD_PANES), lane, at.normal);
        blockers_splat(lane, tile, at, light, mask);
        broad_emitting[k] = emitting;
        broad_lit[k] = lit;
    }
    return window;
}

// Samples that are lit and samples that emit, of all masks.
fn visibility_areas(lane: u32) -> vec2f {
    var counts = vec2u(0u);
    for (var k = 0u; k < BROAD_COUNT; k++) {
        let emits = broad_emitting[k].y - min(broad_emitting[k].x, broad_emitting[k].y);
        counts += vec2u(row_count(broad_lit[k]), emits);
    }
    return total(lane, vec4f(vec2f(counts), 0.0, 0.0)).xy;
}

// How much of what emits the masks leave.
fn visibility_coverage(lane: u32) -> u32 {
    let areas = visibility_areas(lane);
    if (areas.x == areas.y) {
        return LIT;
    }
    return select(PARTIAL, DARK, areas.x == 0.0);
}

// The share of the light that a lobe sees through these masks.
fn broad_share(lane: u32, window: UnitSquare, at: Receiver, lobe: Lobe) -> f32 {
    var sum = vec4f(0.0);
    for (var k = 0u; k < BROAD_COUNT; k++) {
        emitting = broad_emitting[k];
        lit = broad_lit[k];
        sum += share_sums(lane, mask_of(square_pane(window, k, BROAD_PANES)), window, at, lobe);
    }
    return share_of(sum);
}

// Across most edges that cross a window: those of blockers and, where it cuts the light, the horizon.
fn visibility_across(lane: u32, tile: u32, at: Receiver, light: Cone, window: Cone) -> vec3f {
    let basis = edges_frame(window.axis);
    let edges = total(lane, blockers_edges(lane, tile, at, light, window));
    let sum = EDGES_NOTHING + edges.xy + edges_add_plane(basis, at.normal, window);
    return edges_across(basis, sum, edges.zw);
}
