// Words of a grain: strength, 1 if there is an own tangent, that tangent.

// Gives a lobe of microfacets the grain, as `Anisotropy::grain`.
fn brushed_lobe(words: u32, at: Receiver, lobe: Lobe) -> Lobe {
    let strength = material_f32(words);
    if (lobe.kind < LOBE_MICROFACETS_F0 || strength <= 0.0) {
        return lobe;
    }
    var tangent = orthonormal_basis_u(at.normal);
    if (materials[words + 1u] != 0u) {
        tangent = material_vec3(words + 2u);
    }
    var brushed = lobe;
    brushed.kind = grain_kind(at, tangent, strength, lobe.kind == LOBE_MICROFACETS_F90);
    return brushed;
}
