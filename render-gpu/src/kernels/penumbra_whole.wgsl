// Only Lambert lobes: all are seen through the mask of the whole light.
fn seen(lane: u32, tile: u32, at: Receiver, light: Cone, whole: Mask, lobe: Lobe) -> f32 {
    return share(lane, whole, at, lobe);
}
