// MaskVisibility for blockers, by a workgroup. Calls the strategies' `blockers_edges(lane, tile, at, light, window) -> vec4f` (a
// thread's part of the sums of edges) and `blockers_splat(lane, tile, at, light, mask)`. LOOKS_AGAIN says whether masks are ever looked at again,
// BLOCKERS_ARE_SEVERAL whether more than one strategy blocks.

// Numbers of masks across and upward, computed by the first thread: for broad lobes, then for narrow ones. They include the bands
// of a mask, which are one above the other.
var<workgroup> grid_counts: vec4u;
// Bands of a mask; whether broad lobes have fine masks; whether narrow lobes have finer ones; whether the masks of the whole light
// are too many to be stored, and are drawn for each lobe.
var<workgroup> grid_forms: vec4u;

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

// The masks of a lobe, and those of the whole light that count for it.
struct Masks {
    // The window of its own masks.
    window: UnitSquare,
    is_own: bool,
    // Whether the masks of the whole light count, except for their samples between `low` and `high`.
    is_broad: bool,
    low: vec2f,
    high: vec2f,
    // Whether the window is a part of the light, and whether it is turned by the edges in `turn`.
    is_part: bool,
    is_turned: bool,
    turn: Cone,
}

// Lit samples and emitting samples of all its masks.
var<private> visibility_areas: vec2f;
// `is_own`, `is_broad` and `is_turned` of the first thread, and the number of masks around the lit part that count.
var<workgroup> visibility_plan: vec4u;

// All masks are drawn here, in one place: drivers compile a function again for each call of it, and blockers are most of a kernel.
// First draws the masks of the whole light, if `is_whole`; then, for each lobe, returns the visible fraction of the light, with
// masks of its own where it needs these. Requires uniform control flow.
fn visible_fraction(
    lane: u32, tile: u32, at: Receiver, light: Cone, tolerance: f32, is_whole: bool, lobe: Lobe
) -> Fraction {
    var masks: Masks;
    if (lane == 0u && is_whole) {
        visibility_fineness(light, tolerance);
    }
    let counts = workgroupUniformLoad(&grid_counts);
    let forms = workgroupUniformLoad(&grid_forms);
    if (is_whole) {
        masks.is_own = true;
        masks.is_turned = true;
        masks.turn = light_turn(light);
    } else {
        masks = masks_of_lobe(at, light, tolerance, lobe, forms.z > 0u);
    }
    if (lane == 0u) {
        let near = select(0u, near_count, LOOKS_AGAIN && !is_whole && masks.is_broad);
        visibility_plan = vec4u(u32(masks.is_own), u32(masks.is_broad), u32(masks.is_turned), near);
    }
    let plan = workgroupUniformLoad(&visibility_plan);
    if (plan.z > 0u) {
        masks.window = light_window(light, visibility_across(lane, tile, at, light, masks.turn), at.normal);
    }
    if (is_whole) {
        places_whole = masks.window;
    } else if (masks.is_part) {
        masks.window = masks_window(masks.window, at, tolerance, lobe);
    }
    var counts_of_whole = vec4u(0u);
    if (LOOKS_AGAIN && is_whole) {
        near_begin(lane);
    }
    let own_grid = select(counts.zw, counts.xy, is_whole);
    let own = plan.x * own_grid.x * own_grid.y;
    let count = own + plan.y * counts.x * counts.y;
    // Windows around the lit part: those that are stored, or those that are tried. The first of the latter may be the whole light's, for its
    // lit part with exact areas.
    var more = select(0u, plan.w, LOOKS_AGAIN);
    var cells = 0u;
    var first = count;
    for (var k = 0u; k < count + more; k++) {
        let is_near = LOOKS_AGAIN && k >= count;
        let is_own = k < own;
        let part = select(k - own, k, is_own);
        let grid = select(counts.xy, own_grid, is_own);
        var window = places_whole;
        if (is_own) {
            window = masks.window;
        }
        row_refine((is_own && !is_whole) || forms.y > 0u);
        let seeks_area = is_near && is_whole && k < first;
        let is_area = is_near && !is_whole && near_is_area;
        var square = near_square;
        near_index = 0u;
        if (!is_near) {
            square = square_part(window, part, grid);
        } else if (seeks_area || is_area) {
            square = places_whole;
        } else if (cells + plan.w > 0u) {
            near_index = k - first;
            square = near_window(places_whole, near_index);
        }
        near_scale = near_scale_of(square, counts.xy);
        let mask = mask_of(square);
        area_is_found = false;
        if (is_own || is_whole || forms.w > 0u) {
            row_bands = forms.x;
            row_first = SIDE * (part / grid.x % forms.x);
            _ = mask_reset(square, lane, at.normal);
            area_wish = select(AREA_UNWANTED, AREA_BESIDE, LOOKS_AGAIN && is_own && near_is_area);
            area_wish = select(area_wish, AREA_ALONE, seeks_area);
            blockers_splat(lane, tile, at, light, mask);
            row_bands = 1u;
            row_first = 0u;
        } else {
            masks_load(part, is_near, plan.w > 0u);
        }
        area_counts = area_is_found || is_area;
        var stays = true;
        if (is_whole) {
            let samples = vec2u(row_count(lit), emitting.y - min(emitting.x, emitting.y));
            let column = part % grid.x;
            if (LOOKS_AGAIN && decide(lane, seeks_area)) {
                area_counts = true;
                let area = total(lane, vec4f(open_count(), f32(samples.y - samples.x), 0.0, 0.0)).xy;
                // Of several strategies' blockers, those that have found it are all that hide any; and nothing is lit if no sample is.
                let is_sure = select(visibility_areas.x == 0.0, !BLOCKERS_ARE_SEVERAL || area.y == 0.0, area.x > 0.0);
                stays = decide(lane, area_is_found && is_sure);
                area_counts = stays;
                near_is_area = stays;
                if (stays) {
                    visibility_areas.x = area.x * near_scale;
                    near_keep(lane, square);
                    more = 1u;
                }
            } else if (LOOKS_AGAIN && decide(lane, is_near)) {
                _ = near_add(lane, mask, vec2<bool>(false));
                let lit_samples = total(lane, vec4f(f32(samples.x), 0.0, 0.0, 0.0)).x;
                let fits = near_stays(lane, places_whole, lit_samples);
                stays = decide(lane, cells > 0u || fits || k + 1u - first == NEAR_MOST);
                more += u32(!stays);
                // An opening that is not found again is as large as the whole light's masks show.
                stays = stays && (cells > 0u || lit_samples > 0.0);
                if (stays && cells == 0u) {
                    near_keep(lane, square);
                }
                if (stays) {
                    visibility_areas.x = select(visibility_areas.x, 0.0, near_index == 0u) + lit_samples * near_scale;
                }
            } else {
                counts_of_whole += vec4u(samples, near_add(lane, mask, vec2(column > 0u, column + 1u < grid.x)));
                if (decide(lane, k + 1u == count)) {
                    let all = total(lane, vec4f(counts_of_whole));
                    visibility_areas = all.xy;
                    if (LOOKS_AGAIN && decide(lane, forms.w == 0u && frame.look_again > 0u)) {
                        let again = near_plan(lane, all, SIDE * count, count == 1u, light);
                        first += again.x;
                        cells = again.y;
                        more = again.x + again.z;
                    }
                }
            }
        }
        if (decide(lane, stays)) {
            masks_use(lane, part, mask, window, masks, is_own, is_whole, is_near, at, lobe);
        }
    }
    row_refine(forms.y > 0u);
    return masks_fraction(lobe);
}

// Coverage of the emitting region by all masks of the whole light.
fn visibility_coverage() -> u32 {
    if (visibility_areas.x == visibility_areas.y) {
        return LIT;
    }
    return select(PARTIAL, DARK, visibility_areas.x == 0.0);
}

// The lit part of the light if every sample counts alike.
fn visibility_alike() -> f32 { return select(0.0, visibility_areas.x / visibility_areas.y, visibility_areas.y > 0.0); }

// The direction across most edges in a window: those of blockers and, if it cuts the light, the horizon.
fn visibility_across(lane: u32, tile: u32, at: Receiver, light: Cone, window: Cone) -> vec3f {
    let basis = edges_frame_of(window);
    let edges = total(lane, blockers_edges(lane, tile, at, light, window));
    let sum = edges + edges_add_plane(basis, at.normal, window);
    return edges_across(basis, EDGES_NOTHING + sum.xy, sum.zw);
}
