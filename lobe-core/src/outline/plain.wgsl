// Lights that are as bright everywhere. Calls `cap_integral`.

alias OutlineSum = f32;

const OUTLINE_SHOWS = false;

var<private> outline_sum: f32;

fn outline_rule(length: f32, is_beside: bool) -> vec2u {
    if (length < 0.5) {
        return select(OUTLINE_FOUR, OUTLINE_TWO, length < 0.08);
    }
    return select(OUTLINE_SIXTEEN, OUTLINE_EIGHT, length < 1.1);
}

fn outline_begin(right: vec3f, value: OutlineValue) { outline_sum = 0.0; }

fn outline_sample(p: vec3f, area: f32, angle: f32, value: f32) { outline_sum += area * angle * value; }

fn outline_end(peak: OutlinePeak, value: OutlineValue) -> f32 { return outline_sum; }

fn light_integral(at: Receiver, lobe: Lobe, cone: Cone) -> f32 {
    if (!light_is_flat()) {
        return cap_integral(at, lobe, cone);
    }
    let value = outline_integral(at, lobe);
    return select(0.0, value, value > 0.0 && value < 3e38);
}
