// The size of the penumbra kernel's dispatch: one workgroup a queued point.
@compute @workgroup_size(1)
fn args_of_queue() {
    let size = queue_size(atomicLoad(&queue.count));
    args[0] = size.x;
    args[1] = size.y;
    args[2] = 1u;
}
