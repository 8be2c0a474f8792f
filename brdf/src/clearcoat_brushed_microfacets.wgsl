// Microfacets of a clear coat, which has no grain, over those of a brushed metal; the grain's numbers come last.
fn clearcoat_brushed_microfacets_lobe(offset: u32, at: Receiver, k: u32) -> Lobe {
    let lobe = clearcoat_microfacets_lobe(offset, at, k);
    if (k >= materials[offset + 13u] + 2u) {
        return lobe;
    }
    return brushed_lobe(offset + 19u, at, lobe);
}
