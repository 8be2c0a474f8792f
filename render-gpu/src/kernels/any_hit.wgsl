// Ray queries of strategies against the scene's triangles and spheres, in units of the scene: `World` of ray-tracing. STACK is at
// least the depth of the hierarchy.

// All rays from a point into a cone, up to a light there: `Region` of ray-tracing. In units of the hierarchy.
struct Region {
    origin: vec3f,
    sin: f32,
    axis: vec3f,
    cos: f32,
    // All rays are on this side of a plane through the origin; 0 if there is no such plane.
    face: vec3f,
    // The largest distance of a ray along the axis.
    far: f32,
}

// The flags of the primitives that stop rays.
var<private> world_stop: u32 = BLOCKS;

// The receivers that an object hides the light from: 0 none, 1 all, 2 those whose object also has a 2 here.
fn world_stops(object: u32) -> u32 {
    if object == NO_OBJECT {
        return 0u;
    }
    if nodes[0].count != 0u {
        return 1u;
    }
    return nodes[nodes[0].first + object].count;
}

// True when a blocking triangle or sphere lies on the ray nearer than `distance`.
fn world_occludes(origin: vec3f, direction: vec3f, distance: f32) -> bool {
    let ray = slabs(origin, direction);
    // At each level one sibling waits.
    var stack: array<u32, STACK>;
    var waiting = 0u;
    var current = ROOT;
    loop {
        let count = nodes[current].count;
        let first = nodes[current].first;
        var next = 0u;
        if count > 0u {
            for (var i = first; i < first + count; i++) {
                let p = primitives[i];
                if (p.object & world_stop) == 0u {
                    continue;
                }
                var t = NEVER;
                if (p.object & SPHERE) != 0u {
                    t = meet_sphere(p.a, p.b.y, origin, direction);
                } else {
                    t = meet_triangle(p, origin, direction, 0.0);
                }
                if t <= distance {
                    return true;
                }
            }
        } else {
            let a = enter(ray, nodes[first].low, nodes[first].high, distance);
            let b = enter(ray, nodes[first + 1u].low, nodes[first + 1u].high, distance);
            let swapped = b < a;
            if min(a, b) < NEVER {
                next = select(first, first + 1u, swapped);
                if max(a, b) < NEVER && waiting < STACK {
                    stack[waiting] = select(first + 1u, first, swapped);
                    waiting += 1u;
                }
            }
        }
        if next == 0u {
            if waiting == 0u {
                break;
            }
            waiting -= 1u;
            next = stack[waiting];
        }
        current = next;
    }
    return false;
}

// False if no ray of the region meets a blocking primitive; may be true although none does.
fn world_meets(region: Region) -> bool {
    var stack: array<u32, STACK>;
    var waiting = 0u;
    var current = ROOT;
    loop {
        let count = nodes[current].count;
        let first = nodes[current].first;
        var next = 0u;
        if count > 0u {
            for (var i = first; i < first + count; i++) {
                let p = primitives[i];
                if (p.object & world_stop) != 0u && !region_misses_primitive(region, p) {
                    return true;
                }
            }
        } else {
            if !region_misses_box(region, nodes[first].low, nodes[first].high) {
                next = first;
            }
            if !region_misses_box(region, nodes[first + 1u].low, nodes[first + 1u].high) {
                if next == 0u {
                    next = first + 1u;
                } else if waiting < STACK {
                    stack[waiting] = first + 1u;
                    waiting += 1u;
                }
            }
        }
        if next == 0u {
            if waiting == 0u {
                break;
            }
            waiting -= 1u;
            next = stack[waiting];
        }
        current = next;
    }
    return false;
}

// Normal of the cone's tangent plane on the side of a point, turned toward the cone; 0 on the axis.
fn region_tangent(region: Region, point: vec3f) -> vec3f {
    // Twice, since for a point near the axis one subtraction leaves only rounding errors.
    var aside = point - region.axis * dot(point, region.axis);
    aside = aside - region.axis * dot(aside, region.axis);
    let length_sq = dot(aside, aside);
    if length_sq <= 1e-12 * dot(point, point) {
        return vec3f(0.0);
    }
    return region.axis * region.sin - aside * (region.cos / sqrt(length_sq));
}

// Each test is true if a plane separates the rays from a convex shape; it uses the shape's farthest extent along the plane's
// normal.

fn region_misses_box(region: Region, low: vec3f, high: vec3f) -> bool {
    let center = 0.5 * (low + high) - region.origin;
    // The second term exceeds the rounding of the origin.
    let half = 0.500001 * (high - low) + 1e-7 * abs(region.origin);
    let along = dot(region.axis, center);
    let size = dot(abs(region.axis), half);
    let tangent = region_tangent(region, center);
    return along + size <= 0.0
        || along - size >= region.far
        || (any(region.face != vec3f(0.0)) && dot(region.face, center) + dot(abs(region.face), half) <= 0.0)
        || dot(tangent, center) + dot(abs(tangent), half) < 0.0;
}

fn region_misses_primitive(region: Region, p: Primitive) -> bool {
    let a = p.a - region.origin;
    if (p.object & SPHERE) != 0u {
        let along = dot(region.axis, a);
        let tangent = region_tangent(region, a);
        return along + p.b.x <= 0.0
            || along - p.b.x >= region.far
            || (any(region.face != vec3f(0.0)) && dot(region.face, a) + p.b.x <= BLUR * (dot(abs(a), vec3f(1.0)) + p.b.x))
            // On the axis there is no tangent plane.
            || (any(tangent != vec3f(0.0)) && dot(tangent, a) + p.b.x < 0.0);
    }
    let b = p.b - region.origin;
    let c = p.c - region.origin;
    let blur = BLUR * dot(max(max(abs(a), abs(b)), abs(c)), vec3f(1.0));
    let along = vec3f(dot(region.axis, a), dot(region.axis, b), dot(region.axis, c));
    return max(max(along.x, along.y), along.z) <= 0.0
        || min(min(along.x, along.y), along.z) >= region.far
        || (any(region.face != vec3f(0.0)) && support(region.face, a, b, c) <= blur)
        || support(region_tangent(region, (a + b + c) * (1.0 / 3.0)), a, b, c) < 0.0
        || region_beside_edge(region, a, b, c)
        || region_beside_edge(region, b, c, a)
        || region_beside_edge(region, c, a, b)
        || region_beside_corner(region, a, a, b, c)
        || region_beside_corner(region, b, a, b, c)
        || region_beside_corner(region, c, a, b, c);
}

fn support(n: vec3f, a: vec3f, b: vec3f, c: vec3f) -> f32 {
    return max(max(dot(n, a), dot(n, b)), dot(n, c));
}

fn region_beside_edge(region: Region, p: vec3f, q: vec3f, r: vec3f) -> bool {
    let n = cross(p, q);
    let toward = dot(n, region.axis) * select(-1.0, 1.0, dot(n, r) < 0.0);
    return toward > region.sin * sqrt(dot(n, n));
}

fn region_beside_corner(region: Region, p: vec3f, a: vec3f, b: vec3f, c: vec3f) -> bool {
    let n = region_tangent(region, p);
    return any(n != vec3f(0.0)) && support(n, a, b, c) <= 0.0;
}

fn any_hit_of(object: u32) {
    world_stop = select(BLOCKS, BLOCKS | BLOCKS_ALIKE, world_stops(object) == 2u);
}

// Moves the point off the surface by 5e-7 of its largest coordinate.
fn any_hit_leave(at: Receiver) -> vec3f {
    let size = max(max(abs(at.position.x), abs(at.position.y)), abs(at.position.z));
    return at.position + at.face * (5e-7 * size);
}

fn any_hit_has(object: u32) -> bool { return world_stops(object) != 0u; }

fn any_hit(origin: vec3f, direction: vec3f, distance: f32) -> bool {
    let scale = nodes[0].low.x;
    // The distance stays finite in the hierarchy's units.
    return world_occludes(origin * scale, direction, min(distance, 1e30 / scale) * scale);
}

fn any_hit_cone(origin: vec3f, cone: Cone, face: vec3f) -> bool {
    let scale = nodes[0].low.x;
    let cosine = cone_cos(cone);
    // The tangents touch the light at d cos²θ along the axis; all of its near surface is nearer.
    let far = cone.distance * cosine * cosine * scale;
    return world_meets(Region(origin * scale, sqrt(cone_sin_sq(cone)), cone.axis, cosine, face, far));
}

fn any_hit_side(a: vec3f, b: vec3f, c: vec3f, x: vec3f) -> f32 {
    let scale = nodes[0].low.x;
    return plane_of(Primitive(a * scale, 0u, b * scale, 0u, c * scale, 0u), x * scale).w;
}
