// Microfacets of a clear coat over those of a metal, whose numbers come first.
fn clearcoat_microfacets_lobe(offset: u32, at: Receiver, k: u32) -> Lobe {
    let coat = offset + 14u;
    let seen = clearcoat_seen(coat, at);
    let below = materials[offset + 13u] + 2u;
    if (k < below) {
        var lobe = metallic_microfacets_lobe(offset, at, k);
        lobe.flux *= 1.0 - seen.w;
        return lobe;
    }
    let kind = select(LOBE_MICROFACETS_F0, LOBE_MICROFACETS_F90, k > below);
    return Lobe(seen.xyz, material_f32(coat + 1u), clearcoat_flux(coat, at, seen), kind);
}
