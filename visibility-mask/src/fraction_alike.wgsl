// The visible fraction of a light for a lobe, if the light has the same radiance everywhere: used instead of fraction_image.wgsl.
// Requires uniform control flow.
fn visible_fraction(lane: u32, tile: u32, at: Receiver, light: Cone, tolerance: f32, whole: UnitSquare, lobe: Lobe) -> f32 {
    return lobe_fraction(lane, tile, at, light, tolerance, whole, lobe);
}
