// `classify` by the paper's method, as `Integrator::by_paper`: the product of reflectance and light comes from the table. A point
// is queued if any blocker may shade it, in the umbra too. Calls the light's functions, brdf's and `blockers_coverage(tile, at,
// cone)`.

fn classify_point(tile: u32, point: u32) {
    let at = points[point];
    if (at.material == NO_MATERIAL) {
        return;
    }
    let cone = light_cone(at);
    let light = paper_light_lobe(cone, light_radiance(at));
    let lobes = brdf_lobe_count(at.material);
    var sum = vec3f(0.0);
    var coverage = UNKNOWN;
    for (var k = 0u; k < lobes; k++) {
        let lobe = brdf_lobe(at.material, at, k);
        // Skips lobes without flux.
        if (all(lobe.flux == vec3f(0.0))) {
            continue;
        }
        let unshadowed = paper_reflected(at, lobe, light).flux;
        count(INTEGRALS);
        if (max(max(unshadowed.x, unshadowed.y), unshadowed.z) <= frame.threshold) {
            count(PRUNED);
            continue;
        }
        if (coverage == UNKNOWN) {
            coverage = LIT;
            // Inside the light there is no disc to cover.
            if (cone.one_minus_cos <= 1.0) {
                coverage = blockers_coverage(tile, at, cone);
            }
            // A point light has no square.
            if (coverage != LIT && cone.one_minus_cos > 0.0) {
                let item = atomicAdd(&queue.count, 1u) * frame.queue_stride;
                queue.items[item] = point | select(0u, HIDDEN, coverage == DARK);
                coverage = PARTIAL;
            } else if (coverage == PARTIAL) {
                coverage = DARK;
            }
        }
        if (coverage == LIT) {
            sum += unshadowed;
        }
    }
    finish_point(point, coverage, sum);
}
