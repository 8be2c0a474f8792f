// Lobes of directions of a clear coat over those of a metal, whose numbers come first; then how many of these there are, the coat's numbers, where its
// rows begin, and a slot for each of its lobes.
fn clearcoat_directions_lobe(offset: u32, at: Receiver, k: u32) -> Lobe {
    let coat = offset + 24u;
    let seen = clearcoat_seen(coat, at);
    let below = materials[offset + 23u];
    if (k < below) {
        var lobe = metallic_roughness_lobe(offset, at, k);
        lobe.flux *= 1.0 - seen.w;
        return lobe;
    }
    var mirroring = at;
    mirroring.view = seen.xyz;
    let flux = clearcoat_flux(coat, at, seen);
    return row_lobe(materials[coat + 5u], materials[coat + 6u + k - below], flux, flux, mirroring);
}
