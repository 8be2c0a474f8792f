// Of a clear coat's numbers: weight, exponent, its own normal or zero.

// `Clearcoat::eye`, and what it reflects.
fn clearcoat_seen(coat: u32, at: Receiver) -> vec4f {
    let own = material_vec3(coat + 2u);
    let has_own = any(own != vec3f(0.0));
    let normal = select(at.normal, own, has_own);
    let x = 1.0 - min(abs(dot(normal, at.view)), 1.0);
    let mirrored = 2.0 * dot(own, at.view) * own - at.view;
    let eye = select(at.view, 2.0 * dot(at.normal, mirrored) * at.normal - mirrored, has_own);
    return vec4f(eye, material_f32(coat) * (0.04 + 0.96 * x * x * x * x * x));
}

// `Clearcoat::flux`.
fn clearcoat_flux(coat: u32, at: Receiver, seen: vec4f) -> vec3f {
    let is_hidden = any(material_vec3(coat + 2u) != vec3f(0.0)) && dot(at.normal, seen.xyz) <= 0.0;
    return vec3f(select(seen.w, 0.0, is_hidden));
}
