// Diffuse flux, 1 if there is none, then two words for each lobe of directions: where its rows and reflectances begin, and its slot.
fn half_vector_lobe(offset: u32, at: Receiver, k: u32) -> Lobe {
    let which = k + materials[offset + 3u];
    if which == 0u {
        return diffuse_lobe(at, material_vec3(offset));
    }
    let lobe = materials[offset + 2u + 2u * which];
    let slot = materials[offset + 3u + 2u * which];
    return row_lobe(materials[lobe], slot, material_vec3(lobe + 1u), material_vec3(lobe + 4u), at);
}
