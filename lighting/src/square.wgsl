// The unit square (Fig. 8): the window in the plane facing the light on which visibility is rasterised. Coordinates are
// those of the plane at distance 1 along `axis`. Needs geometry.wgsl and lobe.wgsl of lobe-core.

struct UnitSquare {
    // World directions of +x and +y, and toward the light.
    right: vec3f,
    up: vec3f,
    axis: vec3f,
    // Centre of the window, half its side, and the radius tan θ of the light's disc.
    center: vec2f,
    half: f32,
    disc: f32,
}

// Half-angles above this (85°) are treated as if the light were seen up to it.
const WIDEST_TAN = 11.43;
// A window is not made smaller than for this exponent.
const NARROWEST = 1e8;

// The window that covers the whole light, turned so that `across` lies between right and axis.
fn square_facing(cone: Cone, across: vec3f) -> UnitSquare {
    let aside = across - cone.axis * dot(across, cone.axis);
    let square = dot(aside, aside);
    let all = dot(across, across);
    var right = orthonormal_basis_u(cone.axis);
    if (square > 1e-12 * all && square > 1e-37) {
        right = aside * (1.0 / sqrt(square));
        if (square <= 0.5 * all) {
            // A small rest of a long vector: its rounding errors need not be at right angles to the axis.
            right = unit(right - cone.axis * dot(right, cone.axis));
        }
    }
    var disc = WIDEST_TAN;
    if (cone.one_minus_cos < 1.0) {
        disc = min(cone_tan(cone), WIDEST_TAN);
    }
    return UnitSquare(right, cross(cone.axis, right), cone.axis, vec2f(0.0), disc, disc);
}

// The window that a reflectance lobe needs: `sigmas` standard deviations 1/√e of the lobe about its axis.
fn square_zoomed(square: UnitSquare, lobe: Lobe, normal: vec3f, sigmas: f32) -> UnitSquare {
    let along = dot(square.axis, lobe.axis);
    let local = vec2f(dot(square.right, lobe.axis), dot(square.up, lobe.axis));
    // The lobe's axis on the plane, or the point of the emitting disc next to it.
    var point = plane_point(local, along);
    let n = square_local(square, normal);
    for (var k = 0u; k < 3u; k++) {
        let below = n.x * point.x + n.y * point.y + n.z;
        if (below < 0.0) {
            point -= n.xy * (below / max(dot(n.xy, n.xy), 1e-12));
        }
        point = shortened(point, square.disc);
    }
    // A cone of directions is stretched by 1/cos² across the plane. A mirror still needs a window.
    let width = sigmas * (1.0 / sqrt(clamp(lobe.exponent, 1e-6, NARROWEST)));
    let half = min(width * (1.0 + dot(point, point)), square.disc);
    let room = vec2f(square.disc - half);
    return UnitSquare(square.right, square.up, square.axis, clamp(point, -room, room), half, square.disc);
}

// About the directions that the window shows, as a cone.
fn square_cone(square: UnitSquare, distance: f32) -> Cone {
    let tan = square.half / (1.0 + dot(square.center, square.center));
    let root = sqrt(1.0 + tan * tan);
    return Cone(unit(square_world(square, vec3f(square.center, 1.0))), tan * tan / (root * (1.0 + root)), distance);
}

// A world vector in the square's frame.
fn square_local(square: UnitSquare, v: vec3f) -> vec3f {
    return vec3f(dot(square.right, v), dot(square.up, v), dot(square.axis, v));
}

// A vector of the square's frame in the world.
fn square_world(square: UnitSquare, v: vec3f) -> vec3f {
    return square.right * v.x + square.up * v.y + square.axis * v.z;
}

// Where a direction of the square's frame meets the plane, or a point far away in that direction.
fn plane_point(aside: vec2f, along: f32) -> vec2f {
    if (along > 1e-3) {
        return aside / along;
    }
    let square = dot(aside, aside);
    return select(vec2f(0.0), aside * (1.0 / sqrt(square)) * 1e3, square > 1e-37);
}

fn shortened(v: vec2f, longest: f32) -> vec2f {
    let square = dot(v, v);
    return select(v, longest * (v / sqrt(square)), square > longest * longest);
}

fn unit(v: vec3f) -> vec3f { return v * (1.0 / sqrt(dot(v, v))); }
