// In place of microfacets.wgsl where there are none.

fn outline_facets(v: vec3f) -> f32 { return 0.0; }

fn outline_facets_slope(direction: vec3f) -> vec3f { return vec3f(0.0); }

fn outline_facets_turn(normal: vec3f, lobe: Lobe) -> vec3f { return normal; }

fn outline_microfacets(right: vec3f, normal: vec3f, lobe: Lobe) -> OutlineTerm { return OutlineTerm(); }
