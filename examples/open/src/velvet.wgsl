// `Velvet`: diffuse colour, flux of the lobe about the view, exponent.

fn velvet_lobe(words: u32, at: Receiver, k: u32) -> Lobe {
    if k == 0u {
        return diffuse_lobe(at, material_vec3(words));
    }
    return Lobe(at.view, material_f32(words + 6u), material_vec3(words + 3u), LOBE_COSINE);
}
