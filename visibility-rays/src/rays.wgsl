// The `rays` strategy: what coverage and masks share. `RayBlockers` of render-cpu. Calls the functions `any_hit…` of
// `GpuBlockers`.

// How much of the light the receiver's own facet hides.
fn rays_facet(at: Receiver, cone: Cone) -> u32 {
    if !any_hit_has(at.object) {
        return LIT;
    }
    return facet_coverage(at, cone);
}
