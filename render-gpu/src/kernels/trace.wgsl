// The visible points of a window of the image: one ray through each pixel's centre. STACK is at least the depth of the hierarchy.

// The same struct as `gbuffer::GpuView`. Lengths are in the hierarchy's units.
struct View {
    // Of parallel rays the start of the one through the image's corner.
    eye: vec3f,
    // World units per unit of the hierarchy.
    unit: f32,
    // Direction through the image's corner, and its change per pixel to the right and down. Parallel rays have this direction, and their
    // starts change. In a panorama three unit vectors: forward, to the right and down.
    corner: vec3f,
    // Tiles in a row of the window.
    across: u32,
    right: vec3f,
    // First column and row of the first tile.
    left: u32,
    down: vec3f,
    top: u32,
    // First column and row, and the ones after the last.
    columns: vec2u,
    rows: vec2u,
    // Quarter turns per pixel of a panorama to the right and down.
    turns: vec2f,
    // 0, PARALLEL or PANORAMIC.
    bundle: u32,
}

const NOTHING = 0xffffffffu;

// A workgroup is a tile of 8 × 8 pixels.
@compute @workgroup_size(64)
fn trace(@builtin(workgroup_id) tile: vec3u, @builtin(local_invocation_index) lane: u32) {
    let pixel = vec2u(view.left + tile.x * 8u + lane % 8u, view.top + tile.y * 8u + lane / 8u);
    var out: Receiver;
    out.normal = vec3f(0.0, 0.0, 1.0);
    out.face = out.normal;
    out.view = out.normal;
    out.material = NO_MATERIAL;
    let first = vec2u(view.columns.x, view.rows.x);
    let end = vec2u(view.columns.y, view.rows.y);
    if all(pixel >= first) && all(pixel < end) {
        let at = vec2f(pixel) + 0.5;
        var origin = view.eye;
        var toward = view.corner;
        if view.bundle == PARALLEL {
            origin += view.right * at.x + view.down * at.y;
        } else if view.bundle == PANORAMIC {
            toward = around(at);
        } else {
            toward += view.right * at.x + view.down * at.y;
        }
        let direction = toward * (1.0 / sqrt(dot(toward, toward)));
        let found = nearest(origin, direction);
        if found != NOTHING {
            out = surface(found, origin, direction);
        }
    }
    points[(tile.y * view.across + tile.x) * 64u + lane] = out;
}

// The direction through a point of a panorama: longitude by column, latitude by row.
fn around(at: vec2f) -> vec3f {
    let longitude = quarter_turns(at.x * view.turns.x - 2.0);
    let latitude = quarter_turns(at.y * view.turns.y - 1.0);
    return (view.corner * longitude.y + view.right * longitude.x) * latitude.y + view.down * latitude.x;
}

// Sine and cosine of so many quarter turns. Those of WGSL may be off by 5e-4.
fn quarter_turns(x: f32) -> vec2f {
    let whole = round(x);
    let angle = (x - whole) * FRAC_PI_2;
    let sine = sin_of_octant(angle);
    let half = sin_of_octant(0.5 * angle);
    let cosine = 1.0 - 2.0 * half * half;
    switch u32(i32(whole) & 3) {
        case 0u: { return vec2f(sine, cosine); }
        case 1u: { return vec2f(cosine, -sine); }
        case 2u: { return vec2f(-sine, -cosine); }
        default: { return vec2f(-cosine, sine); }
    }
}

// The nearest visible primitive on a ray, or NOTHING.
fn nearest(origin: vec3f, direction: vec3f) -> u32 {
    let ray = slabs(origin, direction);
    var limit = NEVER;
    var found = NOTHING;
    // At each level one sibling waits.
    var stack: array<u32, STACK>;
    var waiting = 0u;
    var current = ROOT;
    loop {
        let count = nodes[current].count;
        let first = nodes[current].first;
        var next = NOTHING;
        if count > 0u {
            for (var i = first; i < first + count; i++) {
                let t = meet(i, origin, direction);
                if t < limit {
                    limit = t;
                    found = i;
                }
            }
        } else {
            let a = enter(ray, nodes[first].low, nodes[first].high, limit);
            let b = enter(ray, nodes[first + 1u].low, nodes[first + 1u].high, limit);
            let swapped = b < a;
            if min(a, b) < NEVER {
                next = select(first, first + 1u, swapped);
                if max(a, b) < NEVER && waiting < STACK {
                    stack[waiting] = select(first + 1u, first, swapped);
                    waiting += 1u;
                }
            }
        }
        if next == NOTHING {
            if waiting == 0u {
                break;
            }
            waiting -= 1u;
            next = stack[waiting];
        }
        current = next;
    }
    return found;
}

fn meet(number: u32, origin: vec3f, direction: vec3f) -> f32 {
    let p = primitives[number];
    if (p.object & VISIBLE) == 0u {
        return NEVER;
    }
    if (p.object & SPHERE) != 0u {
        return meet_sphere(p.a, p.b.x, origin, direction);
    }
    return meet_triangle(p, origin, direction, 1.5e-7);
}

// The receiver at which a ray meets a primitive. The position is computed from the primitive, not along the ray, and then moved
// onto the surface: only its own rounding is left.
fn surface(number: u32, origin: vec3f, direction: vec3f) -> Receiver {
    let p = primitives[number];
    var out: Receiver;
    out.object = p.object & OBJECT;
    out.material = p.material;
    var position: vec3f;
    if (p.object & SPHERE) != 0u {
        let to = p.a - origin;
        let along = dot(to, direction);
        let aside = to - direction * along;
        let half = sqrt(max(p.b.x * p.b.x - dot(aside, aside), 0.0));
        let inside = along < half;
        let outward = unit_or(direction * select(-half, half, inside) - aside, -direction);
        position = p.a + outward * p.b.x;
        position -= outward * (0.5 * off_sphere(p.a, p.b.x, position) / p.b.x);
        out.normal = select(outward, -outward, dot(outward, direction) > 0.0);
        out.face = out.normal;
    } else {
        let s = origin - p.a;
        let e1 = p.b - p.a;
        let e2 = p.c - p.a;
        let across = cross(direction, e2);
        let inverse = 1.0 / dot(e1, across);
        let u = clamp(dot(s, across) * inverse, 0.0, 1.0);
        let v = clamp(dot(direction, cross(s, e1)) * inverse, 0.0, 1.0 - u);
        position = p.a + e1 * u + e2 * v;
        // Moves the position onto the plane: rounding of a far corner puts it beside.
        let plane = plane_of(p, position);
        let size = max(max(abs(plane.x), abs(plane.y)), abs(plane.z));
        let across_plane = plane.xyz / max(size, 1e-37);
        position -= across_plane * (plane.w / (max(size, 1e-37) * dot(across_plane, across_plane)));
        let n = unit_or(plane.xyz, -direction);
        out.face = select(n, -n, dot(n, direction) > 0.0);
        out.normal = out.face;
        if p.corners != NO_CORNERS {
            let mean = corner(p.corners) * (1.0 - u - v) + corner(p.corners + 3u) * u + corner(p.corners + 6u) * v;
            let smoothed = unit_or(mean, vec3f(0.0));
            // Turned to the visible side of the face; a normal that still faces away from the viewer is replaced by the face's.
            let turned = select(smoothed, -smoothed, dot(smoothed, out.face) < 0.0);
            out.normal = select(out.face, turned, dot(turned, direction) < 0.0);
        }
    }
    out.position = position * view.unit;
    out.view = select(unit_or(origin - position, -direction), -direction, view.bundle == PARALLEL);
    return out;
}

fn corner(first: u32) -> vec3f {
    return vec3f(normals[first], normals[first + 1u], normals[first + 2u]);
}

fn unit_or(v: vec3f, otherwise: vec3f) -> vec3f {
    // Scales first: squares of tiny lengths would underflow.
    let size = max(max(abs(v.x), abs(v.y)), abs(v.z));
    if size < 1e-37 {
        return otherwise;
    }
    let w = v / size;
    return w * (1.0 / sqrt(dot(w, w)));
}
