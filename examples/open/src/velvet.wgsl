// `Velvet`: diffuse colour, flux of the lobe about the view, exponent.

fn velvet_number(material: u32, k: u32) -> f32 { return bitcast<f32>(materials[7u * material + k]); }

fn velvet_color(material: u32, k: u32) -> vec3f {
    return vec3f(velvet_number(material, k), velvet_number(material, k + 1u), velvet_number(material, k + 2u));
}

fn brdf_lobe_count(material: u32) -> u32 { return 2u; }

fn brdf_lobe(material: u32, at: Receiver, k: u32) -> Lobe {
    if k == 0u {
        return Lobe(at.normal, 1.0, velvet_color(material, 0u), LOBE_PLAIN);
    }
    return Lobe(at.view, velvet_number(material, 6u), velvet_color(material, 3u), LOBE_COSINE);
}
