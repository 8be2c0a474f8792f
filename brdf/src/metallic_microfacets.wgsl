// A diffuse base under microfacets: colours of base and normal incidence, α, whether there is a base, rows, then what the coat leaves to a
// white base at each.
fn metallic_microfacets_lobe(offset: u32, at: Receiver, k: u32) -> Lobe {
    let has_base = materials[offset + 7u];
    if (k < has_base) {
        let cosine = clamp(dot(at.normal, at.view), 0.0, 1.0);
        let across = at.normal * dot(at.normal, at.view) - at.view;
        let sine = min(sqrt(dot(across, across)), 1.0);
        let rows = materials[offset + 8u];
        let place = clamp(sine / sqrt(1.0 + cosine), 0.0, 1.0) * f32(rows - 1u);
        let first = min(u32(place), rows - 2u);
        let low = material_f32(offset + 9u + first);
        let left = low + (material_f32(offset + 10u + first) - low) * (place - f32(first));
        return diffuse_lobe(at, material_vec3(offset) * left);
    }
    let alpha = material_f32(offset + 6u);
    let exponent = 2.0 / (alpha * alpha) - 2.0;
    if (k == has_base) {
        return Lobe(at.view, exponent, material_vec3(offset + 3u), LOBE_MICROFACETS);
    }
    return Lobe(at.view, exponent, vec3f(1.0), LOBE_EDGE);
}
