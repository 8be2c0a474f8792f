// In place of microfacets.wgsl where there are none.

fn outline_facets(v: vec3f) -> f32 { return 0.0; }

fn outline_microfacets(normal: vec3f, lobe: Lobe) -> OutlineSum { return OutlineSum(); }
