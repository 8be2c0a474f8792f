// The spheres that a tile of 64 points has to look at for one light: those that meet the shaft from the points to the light. One
// workgroup a tile. Reads `frame`, `points` and the buffers of gpu.rs.

const TILE = 64u;

var<workgroup> lows: array<vec3f, TILE>;
var<workgroup> highs: array<vec3f, TILE>;
// Bits of what the threads found; three by turns, so that one can be cleared while another is still read.
var<workgroup> found: array<atomic<u32>, 6>;
var<workgroup> dark: atomic<u32>;
// The blocks of this round that meet the shaft.
var<workgroup> blocks: array<u32, TILE>;
// How many they are, and whether the search is over. Browsers want proof that all threads meet at a barrier: all load this at once.
var<workgroup> plan: vec2u;

var<private> turn: u32;

// Where the thread is among those for which `here` holds, and how many they are. All threads call it.
fn place(lane: u32, here: bool) -> vec2u {
    if (here) {
        atomicOr(&found[2u * turn + lane / 32u], 1u << (lane % 32u));
    }
    let next = (turn + 1u) % 3u;
    if (lane < 2u) {
        atomicStore(&found[2u * next + lane], 0u);
    }
    workgroupBarrier();
    let low = atomicLoad(&found[2u * turn]);
    let high = atomicLoad(&found[2u * turn + 1u]);
    turn = next;
    let below = (1u << (lane % 32u)) - 1u;
    let before = select(countOneBits(low & below), countOneBits(low) + countOneBits(high & below), lane >= 32u);
    return vec2u(before, countOneBits(low) + countOneBits(high));
}

// `bounding_sphere` of the points that are shaded; of radius −1 where there are none.
fn tile_sphere(lane: u32, position: vec3f, here: bool) -> vec4f {
    lows[lane] = select(vec3f(3e38), position, here);
    highs[lane] = select(vec3f(-3e38), position, here);
    for (var step = TILE / 2u; step > 0u; step /= 2u) {
        workgroupBarrier();
        if (lane < step) {
            lows[lane] = min(lows[lane], lows[lane + step]);
            highs[lane] = max(highs[lane], highs[lane + step]);
        }
    }
    workgroupBarrier();
    let center = 0.5 * (lows[0] + highs[0]);
    let none = lows[0].x > highs[0].x;
    workgroupBarrier();
    let d = position - center;
    lows[lane].x = select(0.0, sqrt(dot(d, d)), here);
    for (var step = TILE / 2u; step > 0u; step /= 2u) {
        workgroupBarrier();
        if (lane < step) {
            lows[lane].x = max(lows[lane].x, lows[lane + step].x);
        }
    }
    workgroupBarrier();
    return vec4f(center, select(lows[0].x * 1.00001, -1.0, none));
}

@compute @workgroup_size(64)
fn cull(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let tile = group.x;
    let list = tile * LIST_WORDS;
    let point = tile * TILE + lane;
    var position = vec3f(0.0);
    var here = point < frame.point_count;
    if (here) {
        position = points[point].position;
        // A receiver that is not finite gets no light, but must not take it from its neighbours.
        here = points[point].material != NO_MATERIAL && all(abs(position) < vec3f(1e18));
    }
    let tile_bounds = tile_sphere(lane, position, here);
    let test = shaft_test(tile_bounds, frame.light);
    var count = 0u;
    let rounds = (arrayLength(&spheres_bounds) + (TILE - 1u)) / TILE;
    for (var round = 0u; round < rounds; round++) {
        let block = round * TILE + lane;
        var meets = block < arrayLength(&spheres_bounds);
        if (meets) {
            let bounds = spheres_bounds[block];
            meets = shaft_meets(test, bounds.xyz, bounds.w);
        }
        let slot = place(lane, meets);
        if (meets) {
            blocks[slot.x] = block;
        }
        if (lane == 0u) {
            // Where no point is there is nothing to look at, and one sphere that hides the light from all is enough.
            plan = vec2u(slot.y, select(0u, 1u, tile_bounds.w < 0.0 || atomicLoad(&dark) != 0u));
        }
        let now = workgroupUniformLoad(&plan);
        if (now.y != 0u) {
            break;
        }
        // Two blocks at a time.
        for (var first = 0u; first < now.x; first += 2u) {
            let half = first + lane / SPHERE_BLOCK;
            var index = arrayLength(&spheres);
            if (half < now.x) {
                index = blocks[half] * SPHERE_BLOCK + lane % SPHERE_BLOCK;
            }
            var hit = index < arrayLength(&spheres);
            if (hit) {
                let sphere = spheres[index];
                // One that makes the light visible hides others.
                let off = sphere.center - frame.light.xyz;
                let slack = SHOWS * frame.light.w;
                let shows = abs(frame.light.w - sphere.radius) <= slack && dot(off, off) <= slack * slack;
                hit = !shows && shaft_meets(test, sphere.center, sphere.radius);
                // Whose receivers they are is not known: what the smallest sphere hides, larger ones hide too.
                if (hit && shaft_darkens(test, sphere.center + sphere.own_offset, sphere.own_radius, sphere.own_distance)) {
                    atomicStore(&dark, 1u);
                }
            }
            let entry = place(lane, hit);
            if (hit && count + entry.x < LIST_ROOM) {
                spheres_lists[list + 2u + count + entry.x] = index;
            }
            count += entry.y;
        }
    }
    workgroupBarrier();
    if (lane == 0u) {
        let full = select(0u, LIST_FULL, count > LIST_ROOM);
        spheres_lists[list] = min(count, LIST_ROOM);
        spheres_lists[list + 1u] = full | select(0u, LIST_DARK, atomicLoad(&dark) != 0u);
    }
}
