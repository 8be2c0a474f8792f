// Only Lambert lobes: all are seen through the mask of the whole light. Needs share.wgsl.
fn visible_share(lane: u32, tile: u32, at: Receiver, light: Cone, tolerance: f32, whole: Mask, lobe: Lobe) -> f32 {
    return share(lane, whole, at, lobe);
}
