// `BoundSet::pose` on the GPU: `spheres` follow the bones that carry them, one sphere a thread.
//
// `rig` is `SphereRig::words`: the number of spheres, then RIG_WORDS for each, then the morph targets' offsets.
// `bones` is `SphereRig::bones`: for each set its joints, three rows of four a joint, and the weights of its morph targets.

fn rig_f32(word: u32) -> f32 {
    return bitcast<f32>(rig[word]);
}

fn rig_vec3(word: u32) -> vec3f {
    return vec3f(rig_f32(word), rig_f32(word + 1u), rig_f32(word + 2u));
}

@compute @workgroup_size(64)
fn pose_spheres(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= rig[0] {
        return;
    }
    // Its index among the blockers, where its joints begin, where the weights of targets do and how many, its own morphs.
    let sphere = 1u + RIG_WORDS * id.x;
    let joints = rig[sphere + 1u];
    let morph = rig[sphere + 2u];
    let targets = rig[sphere + 3u];
    let morphs = rig[sphere + 4u];

    var radius = rig_f32(sphere + 23u);
    for (var k = 0u; k < targets; k++) {
        radius += bones[morph + k] * rig_f32(morphs + MORPH_WORDS * k + 12u);
    }
    var center = vec3f(0.0);
    var x = vec3f(0.0);
    var y = vec3f(0.0);
    var z = vec3f(0.0);
    for (var j = 0u; j < CARRIERS; j++) {
        let weight = rig_f32(sphere + 7u + j);
        if weight <= 0.0 {
            continue;
        }
        var point = rig_vec3(sphere + 11u + 3u * j);
        for (var k = 0u; k < targets; k++) {
            point += bones[morph + k] * rig_vec3(morphs + MORPH_WORDS * k + 3u * j);
        }
        let pair = rig[sphere + 5u + j / 2u];
        let joint = joints + 12u * (select(pair, pair >> 16u, (j & 1u) != 0u) & 0xffffu);
        let column_x = vec3f(bones[joint], bones[joint + 4u], bones[joint + 8u]);
        let column_y = vec3f(bones[joint + 1u], bones[joint + 5u], bones[joint + 9u]);
        let column_z = vec3f(bones[joint + 2u], bones[joint + 6u], bones[joint + 10u]);
        let offset = vec3f(bones[joint + 3u], bones[joint + 7u], bones[joint + 11u]);
        center += weight * (column_x * point.x + column_y * point.y + column_z * point.z + offset);
        x += column_x * weight;
        y += column_y * weight;
        z += column_z * weight;
    }
    radius = max(radius, 0.0) * stretch(x, y, z);
    if !(is_finite(center.x) && is_finite(center.y) && is_finite(center.z) && is_finite(radius)) {
        center = vec3f(0.0);
        radius = 0.0;
    }
    let slot = rig[sphere];
    spheres[slot].center = center;
    spheres[slot].radius = radius;
    spheres[slot].own_offset = radius * turned(rig_vec3(sphere + 27u), x, y, z);
    spheres[slot].own_radius = radius * rig_f32(sphere + 24u);
    spheres[slot].own_distance = radius * rig_f32(sphere + 25u) + rig_f32(sphere + 26u);
}

// A vector as the matrix turns it, as long as before.
fn turned(v: vec3f, x: vec3f, y: vec3f, z: vec3f) -> vec3f {
    let moved = x * v.x + y * v.y + z * v.z;
    let size = length(moved);
    if !(size >= MIN_POSITIVE && is_finite(size)) {
        return vec3f(0.0);
    }
    return moved * (length(v) / size);
}

// By the bits: a comparison with NaN may be taken for one of numbers.
fn is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}

// The cube root of a matrix's change of volume, of the matrix made about 1 first.
fn stretch(x: vec3f, y: vec3f, z: vec3f) -> f32 {
    let largest = max(max(abs(x), abs(y)), abs(z));
    let size = max(max(largest.x, largest.y), largest.z);
    if !(size >= MIN_POSITIVE && is_finite(size)) {
        return size;
    }
    let volume = abs(dot(x / size, cross(y / size, z / size)));
    if volume < 1e-30 {
        return 0.0;
    }
    // The logarithm of a small volume is rounded more than the volume: a step of Newton's method.
    let root = exp_f32(ln_of(volume, volume - 1.0) * (1.0 / 3.0));
    return size * (root - (root - volume / (root * root)) * (1.0 / 3.0));
}
