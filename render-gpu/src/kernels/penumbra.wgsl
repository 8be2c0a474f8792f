// One queued point, one workgroup: its mask of one light, and what each of its reflectance lobes sees of it. As
// `MaskVisibility` and `Integrator::by_moments`. Needs frame.wgsl, queue.wgsl, lighting's pieces, brdf's lobes, one of
// penumbra_whole.wgsl and penumbra_window.wgsl, and of the strategies that there are
// `blockers_edges(lane, tile, at, light, window) -> vec2f` (a thread's part of the sum of edges) and
// `blockers_splat(lane, tile, at, light, mask)`.
@group(0) @binding(1) var<storage, read> points: array<Receiver>;
@group(0) @binding(2) var<storage, read> materials: array<u32>;
@group(0) @binding(3) var<storage, read_write> radiance: array<vec4f>;

// Decisions that all threads take alike, stated by the first one.
var<workgroup> decision: bool;

fn decide(lane: u32, what: bool) -> bool {
    if (lane == 0u) {
        decision = what;
    }
    return workgroupUniformLoad(&decision);
}

// The direction across which most edges run that cross a window: those of blockers and of the horizon.
fn across(lane: u32, tile: u32, at: Receiver, light: Cone, window: Cone) -> vec3f {
    let basis = edges_frame(window.axis);
    let edges = total(lane, vec4f(blockers_edges(lane, tile, at, light, window), 0.0, 0.0)).xy;
    return edges_across(basis, EDGES_NOTHING + edges + horizon_edge(basis, at.normal, window));
}

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
    let point = queue_point(item);
    let tile = point / 64u;
    let at = points[point];
    let light = cone_of_sphere(at.position, frame.light);
    let mask = mask_reset(square_facing(light, across(lane, tile, at, light, light)), lane, at.normal);
    blockers_splat(lane, tile, at, light, mask);

    let areas = total(lane, vec4f(f32(row_count(lit)), f32(emitting.y - min(emitting.x, emitting.y)), 0.0, 0.0));
    let is_lit = areas.x == areas.y;
    let is_partial = !is_lit && areas.x > 0.0;
    var sum = vec3f(0.0);
    for (var k = 0u; k + 1u < frame.queue_stride; k++) {
        let lobe = brdf_lobe(at.material, at, k);
        let unshadowed = lobe.flux * frame.radiance * queue_integral(item, k);
        let brightest = max(max(unshadowed.x, unshadowed.y), unshadowed.z);
        let is_seen = k < brdf_lobe_count(at.material) && brightest > frame.threshold;
        if (decide(lane, is_seen && is_partial)) {
            sum += unshadowed * seen(lane, tile, at, light, mask, lobe);
        } else if (is_seen && is_lit) {
            sum += unshadowed;
        }
    }
    if (lane == 0u) {
        radiance[point] += vec4f(sum, 0.0);
        if (!is_partial) {
            // Counted as queued.
            atomicSub(&queue.counters[PENUMBRA_POINTS], 1u);
            atomicAdd(&queue.counters[select(DARK_POINTS, LIT_POINTS, is_lit)], 1u);
        }
    }
}
