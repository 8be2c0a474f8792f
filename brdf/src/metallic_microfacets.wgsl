// A diffuse base under microfacets, which come last.
fn metallic_microfacets_lobe(offset: u32, at: Receiver, k: u32) -> Lobe {
    let has_base = materials[offset + 13u];
    if (k < has_base) {
        return metallic_base_lobe(offset, at);
    }
    let alpha = material_f32(offset + 11u);
    let exponent = 2.0 / (alpha * alpha) - 2.0;
    if (k == has_base) {
        return Lobe(at.view, exponent, material_vec3(offset + 3u), LOBE_MICROFACETS_F0);
    }
    return Lobe(at.view, exponent, vec3f(material_f32(offset + 6u)), LOBE_MICROFACETS_F90);
}
