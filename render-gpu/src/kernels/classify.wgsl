// Classifies each point for one light: a lit point gets the light's radiance, a dark one nothing, and one in penumbra is queued
// with its integrals. As `Integrator::by_moments`. 64 threads, one tile. Calls the light's functions, brdf's, `light_integral`
// `blockers_coverage(tile, at, cone)`, and `lobes_left(point)`, the lobes that this light shines on, as bits.

// `MaskVisibility::coverage`, before any mask is made.
fn coverage_of(tile: u32, at: Receiver, cone: Cone) -> u32 {
    if (cone.one_minus_cos > 1.0) {
        // Inside the light there is no disc to cover.
        return LIT;
    }
    let coverage = blockers_coverage(tile, at, cone);
    // A blocker that touches the direction of a point light hides it.
    return select(coverage, DARK, coverage == PARTIAL && cone.one_minus_cos <= 0.0);
}

fn classify_point(tile: u32, point: u32) {
    let at = points[point];
    if (at.material == NO_MATERIAL) {
        return;
    }
    let left = lobes_left(point);
    if (left == 0u) {
        return;
    }
    let cone = light_cone(at);
    let bright = light_radiance(at);
    let lobes = brdf_lobe_count(at.material);
    var sum = vec3f(0.0);
    var coverage = UNKNOWN;
    var item = 0u;
    for (var k = 0u; k < lobes; k++) {
        let lobe = brdf_lobe(at.material, at, k);
        // A lobe without flux has no integral.
        var integral = Integral();
        if (any(lobe.flux != vec3f(0.0)) && ((left >> (k % 32u)) & 1u) != 0u) {
            integral = light_integral(at, lobe, cone);
            count(INTEGRALS);
        }
        let unshadowed = lobe.flux * bright * integral;
        let brightest = max(max(unshadowed.x, unshadowed.y), unshadowed.z);
        if (brightest > frame.threshold) {
            if (coverage == UNKNOWN) {
                coverage = coverage_of(tile, at, cone);
                if (coverage == PARTIAL) {
                    item = atomicAdd(&queue.count, 1u) * frame.queue_stride;
                    queue.items[item] = point;
                    // Lobes below the threshold have zero integrals in the queue.
                    for (var before = 0u; before < k; before++) {
                        queue_keep(item, before, Integral());
                    }
                }
            }
            if (coverage == LIT) {
                sum += unshadowed;
            }
        } else if (brightest > 0.0) {
            count(PRUNED);
        }
        if (coverage == PARTIAL) {
            queue_keep(item, k, integral);
        }
    }
    finish_point(point, coverage, sum);
}
