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
    let tilt = neumann_number(first, select(1u, 5u, is_plain), t);
    let ratio = neumann_number(first, select(2u, 6u, is_plain), t);
    let beside = sqrt(neumann_number(first, 3u, t));
    let aside = select(select(-beside, beside, which == 1u), 0.0, is_plain);
    var weight = 0.5 * neumann_number(first, 0u, t) * (1.0 + neumann_number(first, 7u, t) / (e + 5.0)) / divisor;
    if is_plain {
        weight = neumann_number(first, 4u, t);
    }
    let up = cos_sin(tilt * sigma);
    let across = cos_sin(aside * sigma);
    let middle = (n * cosine + forward * sine) * up.x + (forward * cosine - n * sine) * up.y;
    let axis = unit_or(middle * across.x + cross(n, forward) * across.y, n);
    let exponent = e * ratio;
    let flux = material_vec3(offset + 4u) * (weight / (exponent + 1.0));
    return Lobe(axis, exponent, flux, select(1.0, 0.0, is_plain));
}

fn neumann_number(first: u32, k: u32, t: f32) -> f32 {
    let low = NEUMANN_SHAPES[8u * first + k];
    return low + (NEUMANN_SHAPES[8u * first + 8u + k] - low) * t;
}
