// Sums an environment at once: a workgroup a point, as `SkyShader` of render-cpu. Blockers draw their outlines once, one ray says whether
// the fewest surfaces are none, each reflectance lobe is summed over the sky's table. Lobes that its samples do not resolve, and points that
// see little of the sky, are left to the patches. Calls brdf's functions and the blockers'.

// Whether the fewest surfaces hide all.
var<workgroup> sky_is_dark: u32;

// Sums the first `count` lobes over what is seen if the fewest surfaces are none, and returns the fewest. Requires uniform control flow.
fn sky_sum(lane: u32, at: Receiver, count: u32) -> i32 {
    var part = SKY_LISTS;
    var rows = LANES;
    var is_crowd = false;
    var is_drawn = true;
    // Mostly some sample has as many surfaces before it as the pole, and none has fewer.
    var fewest = 0;
    loop {
        let lists = part == SKY_LISTS || (is_crowd && part % SKY_ALONG == 0u);
        sky_begin_part(lane, part, rows, is_crowd);
        workgroupBarrier();
        if (lists || is_drawn) {
            blockers_sky(lane, at);
        } else if (!is_crowd) {
            sky_draw_list(lane);
        }
        workgroupBarrier();
        if (lists) {
            let found = sky_found(lane);
            if (part == SKY_LISTS) {
                is_crowd = sky_is_crowd_of(found);
                is_drawn = !is_crowd && found > SKY_ROOM;
                rows = select(LANES, SKY_CROWD_ROWS, is_crowd);
                part = 0u;
                continue;
            }
            if (found > SKY_LINKS) {
                // Fewer rows, or, of more than are listed of one, no crowd.
                is_crowd = rows > 1u;
                is_drawn = !is_crowd;
                part = select(0u, 2u * part, is_crowd);
                rows = select(LANES, rows / 2u, is_crowd);
                continue;
            }
        }
        if (is_crowd) {
            sky_count_crowd(lane, fewest);
        } else {
            sky_count(lane, fewest);
        }
        for (var k = 0u; k < count; k++) {
            sky_add(lane, at, k);
        }
        part += 1u;
        if (part >= SKY_ALONG * ((SKY_ROWS + rows - 1u) / rows)) {
            let found = sky_fewest(lane);
            if (found == fewest) {
                break;
            }
            fewest = found;
            part = 0u;
        }
        workgroupBarrier();
    }
    return fewest;
}

// Leaves lobes, as bits, to the patches.
fn sky_leave(point: u32, lobes: u32) {
    queue.items[sky_left_place(point)] = lobes;
    if (lobes != 0u) {
        atomicAdd(&queue.counters[SKY_LEFT], 1u);
    }
}

fn sky_point(lane: u32, point: u32) {
    let at = points[point];
    if (at.material == NO_MATERIAL) {
        return;
    }
    let count = min(brdf_lobe_count(at.material), SKY_LOBES);
    if (lane < count) {
        sky_lobes[lane] = brdf_lobe(at.material, at, lane);
    }
    sky_set_horizon(at, blockers_sky_have_facet(at));
    sky_begin(lane);
    let resolved = sky_choose(lane, at, count);
    let all_lobes = (1u << count) - 1u;
    if (resolved == 0u) {
        if (lane == 0u) {
            sky_leave(point, all_lobes);
        }
        return;
    }
    let fewest = sky_sum(lane, at, count);
    if (lane == 0u) {
        sky_is_dark = select(0u, 1u, blockers_sky_hide(at, sky_witness(fewest)));
    }
    let is_dark = workgroupUniformLoad(&sky_is_dark) != 0u;
    var lit = vec3f(0.0);
    var unshadowed = vec3f(0.0);
    var pruned = 0u;
    // Of a uniform sky: all, and what is seen.
    var open = vec2f(0.0);
    for (var k = 0u; k < count; k++) {
        let sum_seen = total(lane, vec4f(sky_sums_seen[k], sky_open_seen));
        let sum_all = total(lane, vec4f(sky_sums_all[k], sky_open_all));
        open = vec2f(sum_all.w, sum_seen.w);
        let seen = sum_seen.xyz;
        let all = sky_lobes[k].flux * sum_all.xyz;
        if ((resolved & (1u << k)) == 0u) {
            continue;
        }
        unshadowed += all;
        let brightest = max(max(all.x, all.y), all.z);
        if (brightest > frame.threshold) {
            lit += select(sky_lobes[k].flux * seen, vec3f(0.0), is_dark);
        } else if (brightest > 0.0) {
            pruned += 1u;
        }
    }
    if (lane > 0u) {
        return;
    }
    let little = select(SKY_LITTLE, SKY_CROWD_LITTLE, sky_is_crowd);
    let is_little = max(max(lit.x, lit.y), lit.z) < little * max(max(unshadowed.x, unshadowed.y), unshadowed.z);
    // Little of the sky itself, whatever light that gives.
    let is_small = open.y < little * open.x && any(lit < SKY_MUCH * unshadowed);
    if ((is_little || is_small) && !(is_dark && sky_is_empty())) {
        sky_leave(point, all_lobes);
        return;
    }
    sky_leave(point, all_lobes & ~resolved);
    radiance[point] += vec4f(lit, 0.0);
    atomicAdd(&queue.counters[INTEGRALS], countOneBits(resolved));
    atomicAdd(&queue.counters[PRUNED], pruned);
    let is_lit = sky_is_empty() && !sky_horizon.is_facet;
    atomicAdd(&queue.counters[select(select(PENUMBRA_POINTS, LIT_POINTS, is_lit), DARK_POINTS, is_dark)], 1u);
}

@compute @workgroup_size(LANES)
fn sky(
    @builtin(workgroup_id) group: vec3u,
    @builtin(num_workgroups) groups: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let point = group.y * groups.x + group.x;
    if (point < frame.point_count) {
        sky_point(lane, point);
        note_cut_loops();
    }
}
