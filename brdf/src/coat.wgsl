// The first words of a metal: colours of the base and of reflection at normal incidence, reflection at grazing views; roughness; of the coat both
// reflectances; the base's brightest channel; alpha; where the coat's table begins, whose sizes are COAT_ROUGHNESSES and COAT_VIEWS.

// `Coat::leaves`.
fn metallic_base_lobe(offset: u32, at: Receiver) -> Lobe {
    let cosine = clamp(dot(at.normal, at.view), 0.0, 1.0);
    let across = at.normal * dot(at.normal, at.view) - at.view;
    let sine = min(sqrt(dot(across, across)), 1.0);
    let column = clamp(sine / sqrt(1.0 + cosine), 0.0, 1.0) * f32(COAT_VIEWS - 1u);
    let row = clamp(material_f32(offset + 7u), 0.0, 1.0) * f32(COAT_ROUGHNESSES - 1u);
    let i = min(u32(column), COAT_VIEWS - 2u);
    let j = min(u32(row), COAT_ROUGHNESSES - 2u);
    let t = column - f32(i);
    let s = row - f32(j);
    let table = materials[offset + 12u];
    let schlick = mix(material_f32(table + i), material_f32(table + i + 1u), t);
    let rows = table + COAT_VIEWS + 2u * (j * COAT_VIEWS + i);
    let next = rows + 2u * COAT_VIEWS;
    let low = mix(coat_pair(rows), coat_pair(rows + 2u), t);
    let parts = mix(low, mix(coat_pair(next), coat_pair(next + 2u), t), s);
    let f0 = material_f32(offset + 8u);
    let f90 = material_f32(offset + 9u);
    let through = 1.0 - f0 - (f90 - f0) * schlick;
    let left = (1.0 - (f0 * parts.x + f90 * parts.y)) / max(material_f32(offset + 10u), 1e-9);
    return diffuse_lobe(at, material_vec3(offset) * max(min(through, left), 0.0));
}

fn coat_pair(word: u32) -> vec2f {
    return vec2f(material_f32(word), material_f32(word + 1u));
}
