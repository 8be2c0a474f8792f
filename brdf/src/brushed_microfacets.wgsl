// Microfacets of a metal, whose numbers come first, with a grain.
fn brushed_microfacets_lobe(offset: u32, at: Receiver, k: u32) -> Lobe {
    return brushed_lobe(offset + 14u, at, metallic_microfacets_lobe(offset, at, k));
}
