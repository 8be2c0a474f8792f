// The part of one light that spheres hide: the list of a tile, the exact question to each sphere of it. The buffers are those of
// gpu.rs.

// The light as a sphere, and the power of the receiver with respect to it.
struct LightSphere {
    sin: f32,
    cos: f32,
    radius: f32,
    power: f32,
}

fn light_sphere(cone: Cone) -> LightSphere {
    let sin = sqrt(cone_sin_sq(cone));
    let cos = cone_cos(cone);
    return LightSphere(sin, cos, cone.distance * sin, cone.distance * cone.distance * (cos * cos));
}

struct SeenSphere {
    blocked: BlockedCone,
    // LIT where it hides nothing.
    coverage: u32,
}

// How a sphere seen at `to` lies to a plane (normal and distance): LIT behind it, DARK where all of it that hides something is before it.
fn sphere_before_plane(to: vec3f, radius: f32, plane: vec4f) -> u32 {
    let along = dot(to, plane.xyz);
    if (along - plane.w >= radius) {
        return LIT;
    }
    // The rim that is seen.
    let d_sq = dot(to, to);
    let tangent_sq = d_sq - radius * radius;
    let part = tangent_sq / d_sq;
    let aside = sqrt(max(d_sq - along * along, 0.0));
    let rim = along * part + radius * sqrt(max(part, 0.0)) * aside / sqrt(d_sq);
    let is_before = tangent_sq > 0.0 && rim <= plane.w;
    return select(DARK, PARTIAL, abs(along - plane.w) < radius && !is_before);
}

// The part of a light that one sphere hides.
fn spheres_look(index: u32, at: Receiver, cone: Cone, light: LightSphere) -> SeenSphere {
    var blocked = spheres_blocked(index, at);
    let to = blocked.to;
    let radius = blocked.radius;
    if (blocked.empty) {
        return SeenSphere(blocked, LIT);
    }
    if (light_is_flat()) {
        let order = sphere_before_plane(to, radius, light_plane());
        if (order == LIT) {
            return SeenSphere(blocked, LIT);
        }
        blocked.meets_light = order == PARTIAL;
    } else {
        let between = to - cone.axis * cone.distance;
        let both = radius + light.radius;
        if (dot(between, between) >= both * both) {
            if (dot(to, to) - radius * radius >= light.power) {
                return SeenSphere(blocked, LIT);
            }
        } else {
            blocked.meets_light = true;
        }
    }
    return SeenSphere(blocked, blocked_cover(blocked, cone.axis, light.sin, light.cos));
}

// How much of the light the receiver's own facet hides, and its horizon does not.
fn spheres_facet(at: Receiver, cone: Cone) -> u32 {
    if (all(at.face == at.normal)) {
        return LIT;
    }
    let facet = facet_coverage(at, cone);
    if (facet == LIT || !spheres_cast(at.object)) {
        return LIT;
    }
    return facet;
}

// How much of the light a receiver of a tile sees, for one thread.
fn spheres_coverage(tile: u32, at: Receiver, cone: Cone) -> u32 {
    let list = tile * LIST_WORDS;
    let flags = spheres_lists[list + 1u];
    if ((flags & LIST_DARK) != 0u) {
        return DARK;
    }
    let test = cone_test(at.position, cone);
    let light = light_sphere(cone);
    var coverage = spheres_facet(at, cone);
    if (coverage == DARK) {
        return DARK;
    }
    if ((flags & LIST_FULL) == 0u) {
        let count = spheres_lists[list];
        for (var k = 0u; k < count; k++) {
            let index = spheres_lists[list + 2u + k];
            coverage = spheres_cover(index, coverage, test, at, cone, light);
            if (coverage == DARK) {
                break;
            }
        }
        return coverage;
    }
    for (var block = 0u; block < arrayLength(&spheres_bounds); block++) {
        let bounds = spheres_bounds[block];
        if (!cone_meets(test, bounds.xyz, bounds.w)) {
            continue;
        }
        let end = min((block + 1u) * SPHERE_BLOCK, arrayLength(&spheres));
        for (var index = block * SPHERE_BLOCK; index < end; index++) {
            coverage = spheres_cover(index, coverage, test, at, cone, light);
            if (coverage == DARK) {
                return DARK;
            }
        }
    }
    return coverage;
}

// The coverage by what is before and one sphere more.
fn spheres_cover(index: u32, before: u32, test: ConeTest, at: Receiver, cone: Cone, light: LightSphere) -> u32 {
    let sphere = spheres[index];
    if (!cone_meets(test, sphere.center, sphere.radius)) {
        return before;
    }
    return max(before, spheres_look(index, at, cone, light).coverage);
}
