// Only Lambert lobes: all use the masks of the whole light, with the same result.

alias Fraction = f32;
const NARROW_GRID = BROAD_GRID;
const IS_NARROW_FINER = false;

// The sums of the masks of the whole light, as `fraction_sums`.
var<private> broad_sums: vec4f;

fn masks_of_lobe(at: Receiver, light: Cone, tolerance: f32, lobe: Lobe, is_narrow_finer: bool) -> Masks {
    return Masks();
}

fn masks_window(window: UnitSquare, at: Receiver, tolerance: f32, lobe: Lobe) -> UnitSquare { return window; }

fn masks_load(part: u32, is_near: bool, has_near: bool) {}

fn masks_use(
    lane: u32, part: u32, mask: Mask, window: UnitSquare, masks: Masks, is_own: bool, is_whole: bool, is_near: bool,
    at: Receiver, lobe: Lobe
) {
    let sums = fraction_sums(lane, mask, window, at, lobe);
    if (is_near) {
        let before = select(broad_sums.xz, vec2f(0.0), near_index == 0u);
        let lit = before + sums.xz * near_scale;
        broad_sums = vec4f(lit.x, broad_sums.y, lit.y, broad_sums.w);
    } else {
        broad_sums = select(broad_sums + sums, sums, part == 0u);
    }
}

fn masks_fraction(lobe: Lobe) -> f32 { return fraction_of(broad_sums); }
