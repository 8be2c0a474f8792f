// The directions of all edges across a light: a mask is turned by their sum. Each thread adds its own edges; the sum of all
// threads, plus EDGES_NOTHING, gives the direction.

// Two unit vectors across a cone's axis: the frame of the sum.
struct EdgeFrame { right: vec3f, up: vec3f }

// Two unit vectors that complete an axis to a basis; continuous, except if the axis points straight down.
fn edges_frame(axis: vec3f) -> EdgeFrame {
    let a = 1.0 / max(1.0 + axis.y, 1e-6);
    let right = vec3f(1.0 - axis.x * axis.x * a, -axis.x, -axis.x * axis.z * a);
    let up = vec3f(-axis.x * axis.z * a, -axis.z, 1.0 - axis.z * axis.z * a);
    return EdgeFrame(right, up);
}

// A straight edge perpendicular to `across` (world space, any length), `length` radii of the light's disc long: the sum, and the same with four times
// its angle.
fn edges_add(frame: EdgeFrame, across: vec3f, length: f32) -> vec4f {
    let d = vec2f(dot(frame.right, across), dot(frame.up, across));
    let square = dot(d, d);
    let sound = square > 0.0 && abs(length) < 3e38;
    let two = vec2f(d.x * d.x - d.y * d.y, 2.0 * d.x * d.y) / square;
    return select(vec4f(0.0), vec4f(two, mat2x2f(two, vec2f(-two.y, two.x)) * two) * length, sound);
}

// The edge of a plane through the receiver with this normal, as far as it crosses the disc of the cone.
fn edges_add_plane(frame: EdgeFrame, normal: vec3f, cone: Cone) -> vec4f {
    let cos = dot(normal, cone.axis);
    // Distance of its chord from the centre: cos β/(sin β tan θ).
    let tan = cone_tan(cone);
    let off_sq = cos * cos / (max(1.0 - cos * cos, 0.0) * (tan * tan));
    return edges_add(frame, normal, EDGES_PLANE * 2.0 * sqrt(max(1.0 - off_sq, 0.0)));
}

// The arc of a circle that lies inside the light's disc: `to` is its centre (world space, relative to the disc's; the part along
// the axis does not matter), and its radius is in radii of the disc.
fn edges_add_circle(frame: EdgeFrame, to: vec3f, radius: f32) -> vec2f {
    let d = vec2f(dot(frame.right, to), dot(frame.up, to));
    let square = dot(d, d);
    let distance = sqrt(square);
    let apart = distance - radius;
    let both = distance + radius;
    let root = sqrt(max((1.0 - apart * apart) * (both * both - 1.0), 0.0));
    let scale = (square + radius * radius - 1.0) * root / (square * square * (radius + radius));
    let adds = root > 0.0 && abs(scale) < 3e38;
    return select(vec2f(0.0), vec2f(d.x * d.x - d.y * d.y, 2.0 * d.x * d.y) * scale, adds);
}

// The unit direction, perpendicular to the light's axis, across which most edges of the sum run; no edge runs along the rows if
// `fourfold` is the sum with four times their angles.
fn edges_across(frame: EdgeFrame, sum: vec2f, fourfold: vec2f) -> vec3f {
    let square = dot(sum, sum);
    var d = select(vec2f(1.0, 0.0), sum * (1.0 / sqrt(square)), square > 1e-37);
    let one = sqrt(square);
    let two = fourfold.x * (d.x * d.x - d.y * d.y) + fourfold.y * (2.0 * d.x * d.y);
    if (one < two) {
        let lean = vec2f(one, two - one);
        d = vec2f(d.x * lean.x - d.y * lean.y, d.y * lean.x + d.x * lean.y);
        d *= 1.0 / sqrt(dot(d, d));
    }
    // Half the angle of the sum.
    var half = vec2f(sqrt((1.0 + abs(d.x)) * 0.5), 0.0);
    half.y = 0.5 * d.y / half.x;
    half = select(half.yx, half, d.x >= 0.0);
    return frame.right * half.x + frame.up * half.y;
}
