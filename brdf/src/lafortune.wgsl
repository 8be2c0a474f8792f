// Words of a lobe: M by columns, the eigenvectors of MᵀM − 1, its eigenvalues, flux without the gain, exponent.
const LAFORTUNE_WORDS = 25u;

// Diffuse flux, 1 if there is none, the lobes.
fn lafortune_lobe(offset: u32, at: Receiver, k: u32) -> Lobe {
    let term = k + materials[offset + 3u];
    if term == 0u {
        return diffuse_lobe(at, material_vec3(offset));
    }
    let lobe = offset + 4u + LAFORTUNE_WORDS * (term - 1u);
    let t = orthonormal_basis_u(at.normal);
    let b = orthonormal_basis_v(at.normal);
    let view = vec3f(dot(t, at.view), dot(b, at.view), dot(at.normal, at.view));
    let m = material_vec3(lobe) * view.x + material_vec3(lobe + 3u) * view.y + material_vec3(lobe + 6u) * view.z;
    let largest = max(max(abs(m.x), abs(m.y)), abs(m.z));
    if largest < 1e-30 {
        return diffuse_lobe(at, vec3f(0.0));
    }
    let scaled = m / largest;
    let axis = t * scaled.x + b * scaled.y + at.normal * scaled.z;
    let exponent = material_f32(lobe + 24u);
    let excess = lafortune_excess(lobe, view);
    var ln_length = 0.5 * ln_1p(excess);
    if excess <= -0.5 {
        ln_length = ln_of(largest, largest - 1.0) + 0.5 * ln_of(dot(scaled, scaled), dot(scaled, scaled) - 1.0);
    }
    let gain = min(exp_f32(exponent * ln_length), 1e12);
    return Lobe(axis / sqrt(dot(axis, axis)), exponent, material_vec3(lobe + 21u) * gain, LOBE_COSINE);
}

// |Mω|² − |ω|² = ωᵀ(MᵀM − 1)ω, which Rust computes in f64. By the eigenvectors it loses no digits: a mirror has none of
// it, and where a large exponent makes it matter all eigenvalues are negative (or the lobe would be too high).
fn lafortune_excess(lobe: u32, view: vec3f) -> f32 {
    let along = vec3f(
        dot(material_vec3(lobe + 9u), view),
        dot(material_vec3(lobe + 12u), view),
        dot(material_vec3(lobe + 15u), view),
    );
    return dot(material_vec3(lobe + 18u), along * along);
}
