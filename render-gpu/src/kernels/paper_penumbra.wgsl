// Shades one queued point with one workgroup, by the paper's method: shadow nodes of the light's square, one lobe each. As
// `Integrator::by_paper` with `PaperVisibility`. Calls the light's functions, brdf's and `blockers_splat(lane, tile, at, light,
// mask)`.

@compute @workgroup_size(LANES)
fn penumbra(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let item = group.y * groups.x + group.x;
    if (!decide(lane, item < atomicLoad(&queue.count))) {
        return;
    }
    let queued = queue_point(item);
    let point = queued & ~HIDDEN;
    let at = points[point];
    let light = light_cone(at);
    let square = square_facing(light, vec3f(1.0, 0.0, 0.0));
    let mask = mask_reset(square, lane, square.axis);
    if (decide(lane, (queued & HIDDEN) != 0u)) {
        mask_block_all();
    } else {
        blockers_splat(lane, point / 64u, at, light, mask);
    }
    paper_tree(lane);
    let nodes = paper_count(lane);
    let light_lobe = paper_light_lobe(light, light_radiance(at));
    var sum = vec3f(0.0);
    var integrals = 0u;
    var pruned = 0u;
    for (var k = 0u; k + 1u < frame.queue_stride; k++) {
        var is_seen = k < brdf_lobe_count(at.material);
        var product = Lobe();
        if (is_seen) {
            product = paper_reflected(at, brdf_lobe(at.material, at, k), light_lobe);
            is_seen = max(max(product.flux.x, product.flux.y), product.flux.z) > frame.threshold;
        }
        if (decide(lane, is_seen)) {
            let shadow = total(lane, paper_shadow(lane, square, product, frame.threshold));
            sum += max(product.flux + shadow.xyz, vec3f(0.0));
            integrals += nodes;
            pruned += u32(shadow.w);
        }
    }
    if (lane == 0u) {
        radiance[point] += vec4f(sum, 0.0);
        atomicAdd(&queue.counters[INTEGRALS], integrals);
        atomicAdd(&queue.counters[PRUNED], pruned);
        if (nodes == 0u) {
            // `classify` counted the queued point as penumbra.
            atomicSub(&queue.counters[PENUMBRA_POINTS], 1u);
            atomicAdd(&queue.counters[LIT_POINTS], 1u);
        }
    }
    note_cut_loops();
}
