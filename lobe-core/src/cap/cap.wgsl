// `cap_integral` of cap/mod.rs: a lobe of flux 1 over a light's cone, above the horizon.

fn cap_integral(at: Receiver, lobe: Lobe, cone: Cone) -> f32 {
    let light = seen_light(at, cone);
    if light.below {
        return 0.0;
    }
    if is_lambert(at, lobe) {
        return lambert_integral(light);
    }
    if lobe.kind >= LOBE_MICROFACETS_F0 {
        return microfacets_integral(at, lobe, light);
    }
    let e = lobe.exponent;
    let cosine = select(0.0, 1.0, lobe.kind > LOBE_PLAIN);
    let pair = Pair(lobe.axis, e, at.normal, cosine, light.axis, light.one_minus_cos);
    if e >= MIRROR {
        let along = dot(at.normal, lobe.axis);
        let inside = one_minus_cos_delta(pair) <= light.one_minus_cos;
        return select(0.0, select(1.0, along, cosine > 0.0), inside && along > 0.0);
    }
    let wide_open = light.one_minus_cos > ENDS;
    if light.above && !wide_open && e >= SLAB_EXPONENT && 0.5 * (e + 1.0) * light.one_minus_cos >= SLAB_WIDTH {
        return slab(pair);
    }
    return chords(pair, e < 1.0 || wide_open || !light.above);
}
