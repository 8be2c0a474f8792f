// The size of the dispatches of a sky's patches: a workgroup for each tile, or none if no lobe is left to them. Behind that of the
// penumbra kernel.
@compute @workgroup_size(1)
fn args_of_sky() {
    args[3] = select(0u, (frame.point_count + 63u) / 64u, atomicLoad(&queue.counters[SKY_LEFT]) > 0u);
    args[4] = 1u;
    args[5] = 1u;
}
