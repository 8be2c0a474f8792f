// Diffuse flux, 1 if there is none, then exponent and both reflectances of each pair.
fn half_vector_microfacets_lobe(offset: u32, at: Receiver, k: u32) -> Lobe {
    let which = k + materials[offset + 3u];
    if which == 0u {
        return diffuse_lobe(at, material_vec3(offset));
    }
    let pair = offset + 4u + 7u * ((which - 1u) / 2u);
    let is_edge = which % 2u == 0u;
    let reflectance = material_vec3(pair + select(1u, 4u, is_edge));
    return Lobe(at.view, material_f32(pair), reflectance, select(LOBE_MICROFACETS_F0, LOBE_MICROFACETS_F90, is_edge));
}
