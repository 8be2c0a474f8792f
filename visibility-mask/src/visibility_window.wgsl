// Masks of the whole light are stored for the lobes; narrow lobes have masks of their own, with 256 samples a row.

// Emitting and lit samples of this thread's row in each part of the whole light, if the parts are few enough to be stored.
var<private> broad_emitting: array<vec2u, BROAD_COUNT>;
var<private> broad_lit: array<Row, BROAD_COUNT>;
const BROAD_COUNT = BROAD_GRID.x * BROAD_GRID.y;

// The reach of a lobe's own window, in its standard deviations: √(2 ln(2/τ)).
fn zoom_sigmas(tolerance: f32) -> f32 { return sqrt(2.0 * ln_1p(2.0 / clamp(tolerance, 1e-6, 0.5) - 1.0)); }

fn is_microfacets(lobe: Lobe) -> bool { return HAS_MICROFACETS && lobe.kind >= LOBE_MICROFACETS_F0; }

// The masks of a lobe of cosines, which replace those of the whole light.
fn masks_of_cosines(at: Receiver, light: Cone, tolerance: f32, lobe: Lobe, is_narrow_finer: bool) -> Masks {
    var masks: Masks;
    let whole = places_whole;
    let peak = square_peak(whole, lobe, at.normal);
    masks.window = whole;
    let square = square_around(whole, peak, zoom_sigmas(tolerance));
    let is_narrow = any(square.half < whole.half);
    let is_steep = is_narrow_finer && peak_fall(peak, whole) > STEEP;
    masks.is_own = !is_lambert(at, lobe) && (is_narrow || is_steep);
    masks.is_broad = !masks.is_own;
    masks.low = vec2f(1e30);
    masks.high = vec2f(-1e30);
    masks.is_part = masks.is_own && is_narrow;
    // All windows on a flat light are turned alike.
    masks.is_turned = masks.is_part && !light_is_flat();
    masks.turn = square_cone(square, light.distance);
    return masks;
}

// Masks of a highlight's window, if that is a part of the light or the highlight is narrow (`is_finer`). The masks of the whole light
// count beside a part, without its window.
fn masks_of_highlight(square: UnitSquare, is_finer: bool) -> Masks {
    var masks: Masks;
    masks.window = square;
    let is_part = any(square.half < places_whole.half);
    masks.is_broad = !(is_finer && !is_part);
    masks.is_own = is_part || !masks.is_broad;
    masks.low = select(vec2f(1e30), square.center - square.half, is_part);
    masks.high = select(vec2f(-1e30), square.center + square.half, is_part);
    return masks;
}

fn masks_window(window: UnitSquare, at: Receiver, tolerance: f32, lobe: Lobe) -> UnitSquare {
    return square_zoomed(window, lobe, at.normal, zoom_sigmas(tolerance));
}

// The same in the masks around the lit part.
var<private> near_lit: array<Row, PLACES_CELLS>;
// The lit part of the whole light with its area, where that is known.
var<private> near_area: LitRow;

// Reads the samples of a stored mask. If there are some around the lit part, their lit samples count instead.
fn masks_load(part: u32, is_near: bool, has_near: bool) {
    if (is_near) {
        emitting = vec2u(0u, row_width);
        lit = near_lit[near_index];
        area_row = near_area;
        return;
    }
    emitting = broad_emitting[part];
    lit = broad_lit[part];
    if (has_near) {
        lit = row_none();
    }
}

fn masks_use(
    lane: u32, part: u32, mask: Mask, window: UnitSquare, masks: Masks, is_own: bool, is_whole: bool, is_near: bool,
    at: Receiver, lobe: Lobe
) {
    if (!is_whole) {
        masks_add(lane, mask, window, masks, is_own, is_near, at, lobe);
    } else if (is_near) {
        near_lit[near_index] = lit;
        near_area = area_row;
    } else if (part < BROAD_COUNT) {
        broad_emitting[part] = emitting;
        broad_lit[part] = lit;
    }
}
