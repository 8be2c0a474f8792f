// No material has microfacets.
fn microfacets_integral(at: Receiver, lobe: Lobe, light: Seen) -> f32 { return 0.0; }
