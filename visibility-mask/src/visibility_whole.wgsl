// Only Lambert lobes: all use the masks of the whole light, with the same result. Needs visibility.wgsl.

const NARROW_GRID = BROAD_GRID;
const IS_NARROW_FINER = false;

// The sums of the masks of the whole light, as `fraction_sums`.
var<private> broad_sums: vec4f;

// Called for each mask of the whole light.
fn visibility_drawn(lane: u32, k: u32, mask: Mask, window: UnitSquare, at: Receiver) {
    let sums = fraction_sums(lane, mask, window, at, Lobe());
    broad_sums = select(broad_sums + sums, sums, k == 0u);
}

fn lobe_fraction(lane: u32, tile: u32, at: Receiver, light: Cone, tolerance: f32, window: UnitSquare, lobe: Lobe) -> f32 {
    return fraction_of(broad_sums);
}
