fn lambert_lobe(offset: u32, at: Receiver, k: u32) -> Lobe {
    return diffuse_lobe(at, material_vec3(offset));
}
