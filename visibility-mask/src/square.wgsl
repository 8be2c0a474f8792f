// The unit square (Fig. 8): the window in the plane facing the light on which visibility is rasterised. Coordinates are those of
// the plane at distance 1 along `axis`.

struct UnitSquare {
    // World directions of +x and +y, and toward the light.
    right: vec3f,
    up: vec3f,
    axis: vec3f,
    // Centre of the window, half its sides, and the radius tan θ of the light's disc.
    center: vec2f,
    half: vec2f,
    disc: f32,
}

// The window of the whole light, turned so that `across` lies between right and axis.
fn square_facing(cone: Cone, across: vec3f) -> UnitSquare {
    let aside = across - cone.axis * dot(across, cone.axis);
    let square = dot(aside, aside);
    let all = dot(across, across);
    var right = orthonormal_basis_u(cone.axis);
    if (square > 1e-12 * all && square > 1e-37) {
        right = aside * (1.0 / sqrt(square));
        if (square <= 0.5 * all) {
            // A small rest of a long vector: its rounding errors need not be perpendicular to the axis.
            right = unit(right - cone.axis * dot(right, cone.axis));
        }
    }
    var disc = WIDEST_TAN;
    if (cone.one_minus_cos < 1.0) {
        disc = min(cone_tan(cone), WIDEST_TAN);
    }
    return UnitSquare(right, cross(cone.axis, right), cone.axis, vec2f(0.0), vec2f(disc), disc);
}

// The window around the part of the light above the horizon of `normal`.
fn square_above(square: UnitSquare, normal: vec3f) -> UnitSquare {
    let n = square_local(square, normal);
    let aside = sqrt(dot(n.xy, n.xy));
    let start = -n.z / aside;
    let disc = square.disc;
    if (!(aside > 0.0 && start > -disc && start < disc)) {
        return square;
    }
    // The disc's outermost points, or the ends of the horizon's chord if those points are below.
    let m = n.xy / aside;
    let reach = abs(m.yx) * sqrt(max(disc * disc - start * start, 0.0));
    let high = select(start * m + reach, vec2f(disc), m * disc >= vec2f(start));
    let low = select(start * m - reach, vec2f(-disc), m * -disc >= vec2f(start));
    return square_within(square, low, high);
}

// The largest value of a lobe over the emitting region: its position, the width σ of the lobe there, and σ²g with g the gradient of
// the lobe's logarithm.
struct Peak { point: vec2f, width: f32, uphill: vec2f }

// The largest fall of the lobe's logarithm over one radius of the light: gr + r²/2σ².
fn peak_fall(peak: Peak, square: UnitSquare) -> f32 {
    let size = light_size(square);
    return size * (sqrt(dot(peak.uphill, peak.uphill)) + 0.5 * size) / (peak.width * peak.width);
}

// The peak of a lobe above the horizon of `normal` (world space).
fn square_peak(square: UnitSquare, lobe: Lobe, normal: vec3f) -> Peak {
    let along = dot(square.axis, lobe.axis);
    let aside = vec2f(dot(square.right, lobe.axis), dot(square.up, lobe.axis));
    // The lobe's axis on the plane, or the point of the emitting disc nearest to it.
    var point = plane_point(aside, along);
    point = light_nearest(square, point, square_local(square, normal));
    // A cone of directions is stretched by 1/cos² across the plane. A mirror still needs a window.
    let stretch = 1.0 + dot(point, point);
    let width = 1.0 / sqrt(clamp(lobe.exponent, 1e-6, NARROWEST)) * stretch;
    let slope = aside / max(dot(aside, point) + along, 1e-3) - point / stretch;
    return Peak(point, width, slope * (stretch * stretch));
}

// The point of the disc above the horizon nearest to another point.
fn disc_nearest(square: UnitSquare, start: vec2f, n: vec3f) -> vec2f {
    var point = start;
    for (var k = 0u; k < 3u; k++) {
        let below = n.x * point.x + n.y * point.y + n.z;
        if (below < 0.0) {
            point -= n.xy * (below / max(dot(n.xy, n.xy), 1e-12));
        }
        point = shortened(point, square.disc);
    }
    return point;
}

// The part of the window that a reflectance lobe needs: a disc around p + σ²g of radius √(σ⁴g² + sigmas²σ²), with p the emitting
// point nearest to the lobe's axis, g the gradient of the lobe's logarithm there, σ its width on the plane.
fn square_zoomed(square: UnitSquare, lobe: Lobe, normal: vec3f, sigmas: f32) -> UnitSquare {
    return square_around(square, square_peak(square, lobe, normal), sigmas);
}

// The window of a lobe with this peak.
fn square_around(square: UnitSquare, peak: Peak, sigmas: f32) -> UnitSquare {
    let reach = sigmas * peak.width;
    let uphill = shortened(peak.uphill, FARTHEST * reach);
    // A window as large as the light is not worth a mask: from four fifths on it grows to the whole window.
    let size = light_size(square);
    let broad = clamp(5.0 * reach / size - 4.0, 0.0, 1.0);
    let radius = sqrt(dot(uphill, uphill) + reach * reach) + broad * (2.0 * size);
    return square_within(square, peak.point + uphill - radius, peak.point + uphill + radius);
}

// The part of the window between two corners.
fn square_within(square: UnitSquare, low: vec2f, high: vec2f) -> UnitSquare {
    let start = max(low, square.center - square.half);
    let end = min(high, square.center + square.half);
    let half = min(max(0.5 * (end - start), vec2f(THINNEST * square.disc)), square.half);
    let room = square.half - half;
    let center = clamp(0.5 * (end + start), square.center - room, square.center + room);
    return UnitSquare(square.right, square.up, square.axis, center, half, square.disc);
}

// Approximately the directions in the window, as a cone.
fn square_cone(square: UnitSquare, distance: f32) -> Cone {
    let tan = max(square.half.x, square.half.y) / (1.0 + dot(square.center, square.center));
    let root = sqrt(1.0 + tan * tan);
    return Cone(unit(square_world(square, vec3f(square.center, 1.0))), tan * tan / (root * (1.0 + root)), distance);
}

// Part `k` of the window, divided into `across` parts horizontally and vertically.
fn square_part(window: UnitSquare, k: u32, across: vec2u) -> UnitSquare {
    if (all(across == vec2u(1u))) {
        return window;
    }
    let half = window.half / vec2f(across);
    let place = vec2f(2u * vec2u(k % across.x, k / across.x) + 1u);
    let center = window.center - window.half + half * place;
    return UnitSquare(window.right, window.up, window.axis, center, half, window.disc);
}

// A world vector in the square's frame.
fn square_local(square: UnitSquare, v: vec3f) -> vec3f {
    return vec3f(dot(square.right, v), dot(square.up, v), dot(square.axis, v));
}

// Converts a vector of the square's frame to the world.
fn square_world(square: UnitSquare, v: vec3f) -> vec3f {
    return square.right * v.x + square.up * v.y + square.axis * v.z;
}

// The point at which a direction of the square's frame meets the plane, or a point far away in that direction.
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
