// The cells that spheres block on a mask, by a workgroup of LANES threads.

// Kinds of splats.
const ELLIPSE = 0u;
const WIDE = 1u;
const IN_FRONT = 2u;

// One sphere made ready for the rows.
struct Splat {
    kind: u32,
    ellipse: Ellipse,
    blocked: BlockedCone,
}
var<workgroup> splats: array<Splat, LANES>;
// Which of them block anything: bits of 64 for each kind; two sets by turns.
var<workgroup> splats_used: array<atomic<u32>, 12>;
const SPLATS_USED = 6u;

// How many spheres the threads take in turn: those of the list, or all of them.
fn spheres_count(tile: u32) -> u32 {
    let list = tile * LIST_WORDS;
    return select(spheres_lists[list], arrayLength(&spheres), (spheres_lists[list + 1u] & LIST_FULL) != 0u);
}

// The `k`-th of them.
fn spheres_index(tile: u32, k: u32) -> u32 {
    let list = tile * LIST_WORDS;
    if ((spheres_lists[list + 1u] & LIST_FULL) != 0u) {
        return k;
    }
    return spheres_lists[list + 2u + k];
}

// Whether the spheres from `first` on, one a thread, may hide something: of a list all do.
fn spheres_near(tile: u32, first: u32, test: ConeTest) -> bool {
    if ((spheres_lists[tile * LIST_WORDS + 1u] & LIST_FULL) == 0u) {
        return true;
    }
    var near = false;
    let end = min((first + LANES + (SPHERE_BLOCK - 1u)) / SPHERE_BLOCK, arrayLength(&spheres_bounds));
    for (var block = first / SPHERE_BLOCK; block < end; block++) {
        let bounds = spheres_bounds[block];
        near = near || cone_meets(test, bounds.xyz, bounds.w);
    }
    return near;
}

// This thread's part of the sum of edges: the rims of those spheres that meet `light`, as they cross `window`, unless the light is flat, and of the
// first thread the facet's edge.
fn spheres_edges(lane: u32, tile: u32, at: Receiver, light: Cone, window: Cone) -> vec4f {
    let sphere = light_sphere(light);
    let test = cone_test(at.position, light);
    let across = edges_frame_of(window);
    let tan = cone_tan(window);
    let count = select(spheres_count(tile), 0u, light_is_flat());
    var sum = vec4f(0.0);
    if (lane == 0u && spheres_facet(at, light) == PARTIAL) {
        sum = edges_add_plane(across, at.face, window);
    }
    for (var first = 0u; first < count; first += LANES) {
        if (first + lane >= count || !spheres_near(tile, first, test)) {
            continue;
        }
        let seen = spheres_look(spheres_index(tile, first + lane), at, light, sphere);
        if (seen.coverage != LIT) {
            sum += vec4f(blocked_add_edge(seen.blocked, across, window.axis, tan), 0.0, 0.0);
        }
    }
    return sum;
}

// Blocks what the spheres hide of the mask: each thread makes one ready, then takes all of these to its own row.
fn spheres_splat(lane: u32, tile: u32, at: Receiver, light: Cone, mask: Mask) {
    let sphere = light_sphere(light);
    let test = cone_test(at.position, light);
    let count = spheres_count(tile);
    if (lane < SIDE && spheres_facet(at, light) == PARTIAL) {
        _ = mask_block_below(mask, lane, at.face);
    }
    workgroupBarrier();
    if (lane < 2u * SPLATS_USED) {
        atomicStore(&splats_used[lane], 0u);
    }
    let is_full = (spheres_lists[tile * LIST_WORDS + 1u] & LIST_FULL) != 0u;
    var turn = 0u;
    for (var first = 0u; first < count; first += LANES) {
        if (is_full && !decide(lane, spheres_near(tile, first, test))) {
            continue;
        }
        workgroupBarrier();
        if (first + lane < count) {
            let seen = spheres_look(spheres_index(tile, first + lane), at, light, sphere);
            if (seen.coverage != LIT) {
                let splat = splat_of(seen.blocked, mask);
                splats[lane] = splat;
                atomicOr(&splats_used[turn + 2u * splat.kind + lane / 32u], 1u << (lane % 32u));
            }
        }
        let used = turn;
        // The others are not read any more.
        turn = SPLATS_USED - turn;
        if (lane < SPLATS_USED) {
            atomicStore(&splats_used[turn + lane], 0u);
        }
        workgroupBarrier();
        for (var half = 0u; half < LANES / 32u; half++) {
            splat_row(used + half, 32u * half, light, sphere, mask, lane);
        }
    }
}

// Blocks what 32 of the spheres made ready hide of the own row `j`. A loop for each kind: software devices run all branches.
fn splat_row(used: u32, first: u32, light: Cone, sphere: LightSphere, mask: Mask, j: u32) {
    let mine = select(0u, 0xffffffffu, j < SIDE);
    var bits = atomicLoad(&splats_used[used + 2u * ELLIPSE]) & mine;
    while (bits != 0u && !mask_is_row_dark()) {
        ellipse_splat(splats[first + firstTrailingBit(bits)].ellipse, j);
        bits &= bits - 1u;
    }
    bits = atomicLoad(&splats_used[used + 2u * WIDE]) & mine;
    while (bits != 0u && !mask_is_row_dark()) {
        let slot = first + firstTrailingBit(bits);
        splat_wide(splats[slot].blocked.to, splats[slot].blocked.cos, mask, j);
        bits &= bits - 1u;
    }
    bits = atomicLoad(&splats_used[used + 2u * IN_FRONT]) & mine;
    while (bits != 0u && !mask_is_row_dark()) {
        let slot = first + firstTrailingBit(bits);
        splat_in_front(splats[slot].blocked, light.axis * light.distance, sphere.radius, mask, j);
        bits &= bits - 1u;
    }
}

fn splat_of(blocked: BlockedCone, mask: Mask) -> Splat {
    var splat: Splat;
    splat.blocked = blocked;
    let local = square_local(mask.square, blocked.to);
    if (blocked.meets_light) {
        splat.kind = IN_FRONT;
    } else if (blocked.cos > 0.0 && local.z > 1.001 * blocked.tangent_radius) {
        splat.kind = ELLIPSE;
        splat.ellipse = ellipse(local, blocked.tangent_radius, mask);
    } else {
        splat.kind = WIDE;
        splat.blocked.to = local / max(sqrt(dot(local, local)), 1.1754944e-38);
    }
    return splat;
}
