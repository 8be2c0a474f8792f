// The types of geometry.rs, and what visibility.rs calls `Coverage`.

const LIT = 0u;
const PARTIAL = 1u;
const DARK = 2u;

// 64 bytes.
struct Receiver {
    position: vec3f,
    object: u32,
    normal: vec3f,
    material: u32,
    face: vec3f,
    pad0: u32,
    view: vec3f,
    pad1: u32,
}

struct Cone {
    axis: vec3f,
    one_minus_cos: f32,
    distance: f32,
}

// `Cone::of_sphere`; `sphere` is centre and radius.
fn cone_of_sphere(x: vec3f, sphere: vec4f) -> Cone {
    let to = sphere.xyz - x;
    // Scaled by a power of two, so that the square of no length overflows or vanishes.
    let largest = max(max(abs(to.x), abs(to.y)), abs(to.z));
    let size = clamp(bitcast<u32>(largest) & 0x7f800000u, 1u << 23u, 253u << 23u);
    let unit = to * bitcast<f32>((254u << 23u) - size);
    let length = sqrt(dot(unit, unit));
    let distance = length * bitcast<f32>(size);
    let radius = sphere.w;
    if distance <= CONE_INSIDE * radius || distance <= 0.0 {
        // A point at the receiver is still a point.
        let one_minus_cos = select(0.0, 2.0, radius > 0.0);
        if length > 0.0 {
            return Cone(unit / length, one_minus_cos, distance);
        }
        return Cone(vec3f(0.0, 0.0, 1.0), one_minus_cos, distance);
    }
    let sine = min(radius / distance, 1.0);
    let cosine = sqrt((1.0 - sine) * (1.0 + sine));
    return Cone(unit / length, sine * sine / (1.0 + cosine), distance);
}

fn cone_cos(cone: Cone) -> f32 {
    return 1.0 - cone.one_minus_cos;
}

fn cone_sin_sq(cone: Cone) -> f32 {
    return cone.one_minus_cos * (2.0 - cone.one_minus_cos);
}

fn cone_solid_angle(cone: Cone) -> f32 {
    return 6.28318530717959 * cone.one_minus_cos;
}

fn cone_tan(cone: Cone) -> f32 {
    return sqrt(cone_sin_sq(cone)) / cone_cos(cone);
}

// The two vectors of `orthonormal_basis`.
fn orthonormal_basis_u(axis: vec3f) -> vec3f {
    let turn = basis_turn(axis);
    let b = axis.x * axis.y * turn.y;
    return vec3f(1.0 + turn.x * axis.x * axis.x * turn.y, turn.x * b, -turn.x * axis.x);
}

fn orthonormal_basis_v(axis: vec3f) -> vec3f {
    let turn = basis_turn(axis);
    return vec3f(axis.x * axis.y * turn.y, turn.x + axis.y * axis.y * turn.y, -axis.y);
}

fn basis_turn(axis: vec3f) -> vec2f {
    // A negative zero is negative.
    let side = select(1.0, -1.0, (bitcast<u32>(axis.z) & 0x80000000u) != 0u);
    return vec2f(side, -1.0 / (side + axis.z));
}
