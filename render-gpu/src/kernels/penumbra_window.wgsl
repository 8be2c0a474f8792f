// The share of the light that a lobe sees: through the mask of the whole light or, narrower than that, its own.

fn seen(lane: u32, tile: u32, at: Receiver, light: Cone, whole: Mask, lobe: Lobe) -> f32 {
    let sigmas = zoom_sigmas(frame.tolerance);
    let square = square_zoomed(whole.square, lobe, at.normal, sigmas);
    if (!decide(lane, !is_lambert(at, lobe) && square.half < whole.square.half)) {
        return share(lane, whole, at, lobe);
    }
    // The mask of the whole light is needed again for the next lobe.
    let whole_lit = lit;
    let whole_emitting = emitting;
    let turn = across(lane, tile, at, light, square_cone(square, light.distance));
    let window = square_zoomed(square_facing(light, turn), lobe, at.normal, sigmas);
    let mask = mask_reset(window, lane, at.normal);
    blockers_splat(lane, tile, at, light, mask);
    let share = share(lane, mask, at, lobe);
    lit = whole_lit;
    emitting = whole_emitting;
    return share;
}
