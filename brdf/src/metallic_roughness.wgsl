// Lobes of directions: where the rows begin, then a word for each lobe, 0 for the diffuse one, else its slot.
fn metallic_roughness_lobe(offset: u32, at: Receiver, k: u32) -> Lobe {
    let slot = materials[offset + 14u + k];
    if slot == 0u {
        return metallic_base_lobe(offset, at);
    }
    let f90 = vec3f(material_f32(offset + 6u));
    return row_lobe(materials[offset + 13u], slot, material_vec3(offset + 3u), f90, at);
}
