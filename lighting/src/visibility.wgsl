// What MaskVisibility makes of blockers, by a workgroup. Needs mask.wgsl, edges.wgsl, total.wgsl, and of the strategies that
// there are `blockers_edges(lane, tile, at, light, window) -> vec2f` (a thread's part of the sum of edges) and
// `blockers_splat(lane, tile, at, light, mask)`.

// How much more the horizon's direction matters than a blocker's: what emits is cut by rows only.
const HORIZON = 4.0;

// The mask of the whole light. This and what follows only where all threads come by.
fn visibility_mask(lane: u32, tile: u32, at: Receiver, light: Cone) -> Mask {
    let across = visibility_across(lane, tile, at, light, light);
    let mask = mask_reset(square_above(square_facing(light, across), at.normal), lane, at.normal);
    blockers_splat(lane, tile, at, light, mask);
    return mask;
}

// How much of what emits the mask leaves.
fn visibility_coverage(lane: u32) -> u32 {
    let emits = emitting.y - min(emitting.x, emitting.y);
    let areas = total(lane, vec4f(f32(row_count(lit)), f32(emits), 0.0, 0.0));
    if (areas.x == areas.y) {
        return LIT;
    }
    return select(PARTIAL, DARK, areas.x == 0.0);
}

// Across most edges that cross a window: those of blockers and, where it cuts the light, the horizon.
fn visibility_across(lane: u32, tile: u32, at: Receiver, light: Cone, window: Cone) -> vec3f {
    let basis = edges_frame(window.axis);
    let edges = total(lane, vec4f(blockers_edges(lane, tile, at, light, window), 0.0, 0.0)).xy;
    return edges_across(basis, EDGES_NOTHING + edges + horizon_edge(basis, at.normal, window));
}

fn horizon_edge(basis: EdgeFrame, normal: vec3f, cone: Cone) -> vec2f {
    let cos = dot(normal, cone.axis);
    // The horizon's chord: its distance from the middle is cos β/(sin β tan θ).
    let tan = cone_tan(cone);
    let off_sq = cos * cos / (max(1.0 - cos * cos, 0.0) * (tan * tan));
    if (off_sq < 1.0) {
        return edges_add(basis, normal, HORIZON * 2.0 * sqrt(1.0 - off_sq));
    }
    return vec2f(0.0);
}
