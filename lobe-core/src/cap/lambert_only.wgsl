// `cap_integral` where every lobe is Lambert's.

fn cap_integral(at: Receiver, lobe: Lobe, cone: Cone) -> f32 {
    let light = seen_light(at, cone);
    if light.below {
        return 0.0;
    }
    return lambert_integral(light);
}
