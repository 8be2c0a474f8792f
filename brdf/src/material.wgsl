// Materials as packed.rs packs them: for each what it is and where its numbers begin, then the numbers. `materials`, an
// array of u32, is the kernel's binding.

// Lobes of a material: as many as it can have. One that a receiver does not have has a flux of 0.
fn brdf_lobe_count(material: u32) -> u32 {
    return materials[2u * material] >> 8u;
}

fn material_model(material: u32) -> u32 {
    return materials[2u * material] & 0xffu;
}

fn material_offset(material: u32) -> u32 {
    return materials[2u * material + 1u];
}

fn material_f32(word: u32) -> f32 {
    return bitcast<f32>(materials[word]);
}

fn material_vec3(word: u32) -> vec3f {
    return vec3f(material_f32(word), material_f32(word + 1u), material_f32(word + 2u));
}

// `Lambert::lobes`: exactly the normal.
fn diffuse_lobe(at: Receiver, flux: vec3f) -> Lobe {
    return Lobe(at.normal, 1.0, flux, LOBE_PLAIN);
}
