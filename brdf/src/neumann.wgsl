// Diffuse flux, 1 if there is none, ks·(e+2), exponent. Two lobes with the receiver's cosine, and one without.
fn neumann_lobe(offset: u32, at: Receiver, k: u32) -> Lobe {
    let which = k + materials[offset + 3u];
    if which == 0u {
        return diffuse_lobe(at, material_vec3(offset));
    }
    let n = at.normal;
    let e = material_f32(offset + 7u);
    // Views below the horizon, which smooth normals have, are taken as at it.
    let along = n * dot(n, at.view) - at.view;
    let length = sqrt(dot(along, along));
    var forward = along / max(length, 1e-12);
    if length <= 1e-12 {
        forward = orthonormal_basis_u(n);
    }
    let sine = min(length, 1.0);
    let sigma = 1.0 / sqrt(e + 1.0);
    let cosine = clamp(dot(n, at.view), 0.0, 1.0);
    let divisor = max(cosine, sine * sigma * (1.0 / NEUMANN_STEEPEST));

    let place = NEUMANN_STEEPEST * (sine * sigma / (divisor + sine * sigma)) * (16.0 / 15.0);
    let first = min(u32(place), u32(NEUMANN_STEEPEST) - 1u);
    let t = place - f32(first);
    let is_plain = which == 3u;
    // One copy of the table, read twice: drivers copy it for each place that reads it, and take minutes for twenty of them.
    var shapes = NEUMANN_SHAPES;
    let low = shapes[first];
    let high = shapes[first + 1u];
    // Weight, tilt, ratio and spread of the pair; of the third lobe weight, tilt and ratio, and a correction of the pair's weight.
    let pair = low[0] + (high[0] - low[0]) * t;
    let plain = low[1] + (high[1] - low[1]) * t;
    let tilt = select(pair.y, plain.y, is_plain);
    let ratio = select(pair.z, plain.z, is_plain);
    let beside = sqrt(pair.w);
    let aside = select(select(-beside, beside, which == 1u), 0.0, is_plain);
    var weight = 0.5 * pair.x * (1.0 + plain.w / (e + 5.0)) / divisor;
    if is_plain {
        weight = plain.x;
    }
    let up = cos_sin(tilt * sigma);
    let across = cos_sin(aside * sigma);
    let middle = (n * cosine + forward * sine) * up.x + (forward * cosine - n * sine) * up.y;
    let axis = unit_or(middle * across.x + cross(n, forward) * across.y, n);
    let exponent = e * ratio;
    let flux = material_vec3(offset + 4u) * (weight / (exponent + 1.0));
    return Lobe(axis, exponent, flux, select(LOBE_COSINE, LOBE_PLAIN, is_plain));
}
