// Diffuse flux, 1 if there is none, specular flux, exponent.
fn phong_lobe(offset: u32, at: Receiver, k: u32) -> Lobe {
    if k + materials[offset + 3u] == 0u {
        return diffuse_lobe(at, material_vec3(offset));
    }
    return Lobe(mirrored_view(at), material_f32(offset + 7u), material_vec3(offset + 4u), LOBE_PLAIN);
}
