// Pictures as screens show them, one pixel a thread: exposure, a tone map, sRGB, eight bits with dither, as `pictures::Display` has them.
struct Display {
    gain: f32,
    // The number of the tone map.
    tone: u32,
}
@group(0) @binding(0) var<uniform> display: Display;
@group(0) @binding(1) var source: texture_2d<f32>;
@group(0) @binding(2) var shown: texture_storage_2d<rgba8unorm, write>;

fn srgb(linear: f32) -> f32 {
    return select(1.055 * pow(linear, 1.0 / 2.4) - 0.055, 12.92 * linear, linear <= 0.0031308);
}

fn srgb_of(linear: vec3f) -> vec3f {
    let cut = clamp(linear, vec3f(0.0), vec3f(1.0));
    return vec3f(srgb(cut.x), srgb(cut.y), srgb(cut.z));
}

// In [0, 1e9]; not a number is 0.
fn in_range(x: f32) -> f32 {
    let is_nan = (bitcast<u32>(x) & 0x7fffffffu) > 0x7f800000u;
    return select(clamp(x, 0.0, 1e9), 0.0, is_nan);
}

// Khronos PBR Neutral, but for the reflectance that it takes off.
fn neutral(linear: vec3f, f0: f32) -> vec3f {
    let start = 0.8 - f0;
    let least = min(linear.x, min(linear.y, linear.z));
    var offset = f0;
    if least < 2.0 * f0 {
        offset = least - least * least / (4.0 * f0);
    }
    let color = linear - vec3f(offset);
    let peak = max(color.x, max(color.y, color.z));
    if peak < start {
        return color;
    }
    let room = 1.0 - start;
    let mapped = 1.0 - room * room / (peak + room - start);
    let white = 1.0 - 1.0 / (0.15 * (peak - mapped) + 1.0);
    let scaled = color * (mapped / peak);
    return scaled + (vec3f(mapped) - scaled) * white;
}

fn sigmoid(x: f32) -> f32 {
    let pivot = 10.0 / 16.5;
    let is_above = x >= pivot;
    let width = select(pivot, 1.0 - pivot, is_above);
    let power = select(3.0, 3.25, is_above);
    let reach = 2.0 * width;
    let scale = reach * pow(pow(reach / 0.5, power) - 1.0, -1.0 / power);
    let t = 2.0 * abs(x - pivot) / scale;
    let y = scale * t / pow(1.0 + pow(t, power), 1.0 / power);
    return 0.5 + select(-y, y, is_above);
}

fn agx_log(x: f32) -> f32 {
    return (clamp(log2(max(x, 1e-10)), -12.47393, 4.026069) + 12.47393) / (4.026069 + 12.47393);
}

fn agx(linear: vec3f) -> vec3f {
    let inset = mat3x3f(
        0.84247906, 0.042328242, 0.042375654,
        0.0784336, 0.87846864, 0.0784336,
        0.079223745, 0.07916613, 0.879143,
    );
    let outset = mat3x3f(
        1.196879, -0.05289685, -0.052971635,
        -0.09802088, 1.1519031, -0.09804345,
        -0.09902974, -0.09896118, 1.1510737,
    );
    let drawn = inset * linear;
    return outset * vec3f(sigmoid(agx_log(drawn.x)), sigmoid(agx_log(drawn.y)), sigmoid(agx_log(drawn.z)));
}

@compute @workgroup_size(8, 8)
fn display_pixels(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(shown);
    if id.x >= size.x || id.y >= size.y {
        return;
    }
    let radiance = textureLoad(source, id.xy, 0).xyz * display.gain;
    let linear = vec3f(in_range(radiance.x), in_range(radiance.y), in_range(radiance.z));
    var encoded = vec3f(0.0);
    switch display.tone {
        case LINEAR: { encoded = srgb_of(linear); }
        case NEUTRAL: { encoded = srgb_of(neutral(linear, 0.04)); }
        case AGX: { encoded = agx(linear); }
        default: { encoded = srgb_of(neutral(linear, 0.0)); }
    }
    encoded = clamp(encoded, vec3f(0.0), vec3f(1.0));
    // The R2 sequence in whole numbers, as on the CPU.
    let noise = (f32((id.x * 0xC13FA9A9u + id.y * 0x91E10DA5u) >> 22u) + 0.5) / 1024.0;
    textureStore(shown, id.xy, vec4f(floor(encoded * 255.0 + noise) / 255.0, 1.0));
}
