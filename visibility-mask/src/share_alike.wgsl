// The fraction of a light that a lobe sees, of one that is as bright everywhere: in place of share_image.wgsl. Only where all threads come
// by.
fn visible_fraction(lane: u32, tile: u32, at: Receiver, light: Cone, tolerance: f32, whole: UnitSquare, lobe: Lobe) -> f32 {
    return visible_share(lane, tile, at, light, tolerance, whole, lobe);
}
