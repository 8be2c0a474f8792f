// Only Lambert lobes: all are seen through the masks of the whole light. Needs visibility.wgsl.
fn visible_share(lane: u32, tile: u32, at: Receiver, light: Cone, tolerance: f32, window: UnitSquare, lobe: Lobe) -> f32 {
    return broad_share(lane, window, at, lobe);
}
