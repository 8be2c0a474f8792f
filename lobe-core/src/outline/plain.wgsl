// Lights that are as bright everywhere. Calls `cap_integral`.

alias OutlineSum = f32;

const OUTLINE_SHOWS = false;

fn outline_begin(right: vec3f) {}

fn outline_end(peak: OutlinePeak, value: OutlineValue) -> f32 { return outline_sum; }

fn light_integral(at: Receiver, lobe: Lobe, cone: Cone) -> f32 {
    if (!light_is_flat()) {
        return cap_integral(at, lobe, cone);
    }
    let value = outline_integral(at, lobe);
    return select(0.0, value, value > 0.0 && value < 3e38);
}
