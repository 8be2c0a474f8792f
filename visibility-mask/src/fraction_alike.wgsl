// The visible fraction of a light for a lobe, if the light has the same radiance everywhere: used instead of fraction_image.wgsl.

alias Fraction = f32;

// Sums over the masks of the lobe: of `fraction_sums`, or of `microfacet_sums`.
var<private> lobe_sums: vec4f;

fn masks_of_lobe(at: Receiver, light: Cone, tolerance: f32, lobe: Lobe, is_narrow_finer: bool) -> Masks {
    lobe_sums = vec4f(0.0);
    if (is_microfacets(lobe)) {
        return masks_of_microfacets(at, tolerance, lobe, is_narrow_finer);
    }
    return masks_of_cosines(at, light, tolerance, lobe, is_narrow_finer);
}

// Requires uniform control flow.
fn masks_add(
    lane: u32, mask: Mask, window: UnitSquare, masks: Masks, is_own: bool, is_near: bool, at: Receiver, lobe: Lobe
) {
    if (HAS_MICROFACETS && decide(lane, is_microfacets(lobe))) {
        let sums = microfacet_sums(lane, mask, at, lobe, masks, is_own);
        lobe_sums += select(sums, vec4f(sums.xy, 0.0, 0.0), is_near);
    } else {
        let sums = fraction_sums(lane, mask, window, at, lobe);
        lobe_sums += select(sums, near_scale * vec4f(sums.x, 0.0, sums.z, 0.0), is_near);
    }
}

fn masks_fraction(lobe: Lobe) -> f32 {
    if (is_microfacets(lobe)) {
        return microfacet_fraction(lobe_sums, lobe);
    }
    return fraction_of(lobe_sums);
}
