// Shades one queued point with one workgroup: draws its mask of one light, and sums the visible fraction of each of its
// reflectance lobes. As `Integrator::by_moments`. Calls the light's functions and brdf's.

// The point of this workgroup. All threads load it at once, as the threads of all decisions do: browsers want proof that these meet at
// barriers.
var<workgroup> penumbra_point: u32;
// There is none for this workgroup.
const PENUMBRA_NONE = 0xffffffffu;

@compute @workgroup_size(LANES)
fn penumbra(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let item = group.y * groups.x + group.x;
    if (lane == 0u) {
        penumbra_point = PENUMBRA_NONE;
        if (item < atomicLoad(&queue.count)) {
            penumbra_point = queue_point(item);
        }
    }
    let point = workgroupUniformLoad(&penumbra_point);
    if (point == PENUMBRA_NONE) {
        return;
    }
    let tile = point / 64u;
    let at = points[point];
    let light = light_cone(at);
    let bright = light_radiance(at);
    var coverage = PARTIAL;
    var sum = vec3f(0.0);
    // Round 0 draws the masks of the whole light; each later round is a lobe's.
    for (var round = 0u; round <= queue_lobes(); round++) {
        var lobe: Lobe;
        var unshadowed = vec3f(0.0);
        var is_seen = true;
        if (round > 0u) {
            lobe = brdf_lobe(at.material, at, round - 1u);
            unshadowed = lobe.flux * bright * queue_integral(item, round - 1u);
            let brightest = max(max(unshadowed.x, unshadowed.y), unshadowed.z);
            is_seen = round <= brdf_lobe_count(at.material) && brightest > frame.threshold;
        }
        if (decide(lane, is_seen && coverage == PARTIAL)) {
            sum += unshadowed * visible_fraction(lane, tile, at, light, frame.tolerance, round == 0u, lobe);
        } else if (is_seen && coverage == LIT) {
            sum += unshadowed;
        }
        if (round == 0u) {
            coverage = visibility_coverage();
        }
    }
    if (lane == 0u) {
        radiance[point] += vec4f(sum, 0.0);
        if (coverage != PARTIAL) {
            // `classify` counted the queued point as penumbra.
            atomicSub(&queue.counters[PENUMBRA_POINTS], 1u);
            atomicAdd(&queue.counters[select(DARK_POINTS, LIT_POINTS, coverage == LIT)], 1u);
        }
    }
    note_cut_loops();
}
