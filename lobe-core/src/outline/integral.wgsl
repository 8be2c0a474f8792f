// `outline_integral` of outline/integral.rs, over what outline.wgsl holds.

// Gauss–Legendre rules on [−1, 1] of 2, 4, 8 and 16 nodes: node and weight, one half; then those of 8 and 16 for what begins and ends
// like a root.
var<private> outline_rules: array<vec2f, 27> = OUTLINE_RULES;

// Where in the rules one begins, and half its nodes.
const OUTLINE_TWO = vec2u(0u, 1u);
const OUTLINE_FOUR = vec2u(1u, 2u);
const OUTLINE_EIGHT = vec2u(3u, 4u);
const OUTLINE_SIXTEEN = vec2u(7u, 8u);

// The rule for a length in places.
fn outline_rule(length: f32) -> vec2u {
    if (length < 0.5) {
        return select(OUTLINE_FOUR, OUTLINE_TWO, length < 0.08);
    }
    return select(OUTLINE_SIXTEEN, OUTLINE_EIGHT, length < 1.1);
}

fn outline_turned_rule(length: f32) -> vec2u { return select(vec2u(19u, 8u), vec2u(15u, 4u), length < 0.5); }

// The `k`-th node of a rule.
fn outline_node(rule: vec2u, k: u32) -> vec2f {
    let place = select(k - rule.y, rule.y - 1u - k, k < rule.y);
    let node = outline_rules[rule.x + place];
    return vec2f(select(node.x, -node.x, k < rule.y), node.y);
}

// Where an integrand is largest on the light's plane, and how wide about there.
struct OutlinePeak {
    point: vec2f,
    width: vec2f,
}

const OUTLINE_COSINE = 0u;
const OUTLINE_POWER = 1u;
const OUTLINE_FACETS = 2u;

// A reflectance, in a frame of the light's plane.
struct OutlineValue {
    kind: u32,
    has_cosine: bool,
    half_exponent: f32,
    normal: vec3f,
    axis: vec3f,
}

fn outline_local(right: vec3f, v: vec3f) -> vec3f {
    return vec3f(dot(right, v), dot(cross(outline.axis, right), v), dot(outline.axis, v));
}

// A term of the sum: `factor` times the reflectance over the outline; nothing where that is 0.
struct OutlineTerm {
    factor: f32,
    peak: OutlinePeak,
    value: OutlineValue,
}

// The integral of a lobe of flux 1 over the outline. One cubature for all kinds: drivers compile a function again for each call of it.
fn outline_integral(at: Receiver, lobe: Lobe) -> OutlineSum {
    let is_diffuse = is_lambert(at, lobe);
    let is_facets = lobe.kind >= LOBE_MICROFACETS_F0;
    if (is_diffuse) {
        let closed = outline_closed(at.normal);
        let is_cut_disc = outline.is_clipped && outline.radius > 0.0;
        if (!OUTLINE_SHOWS && (!is_cut_disc || closed.y > OUTLINE_WIDE)) {
            return OutlineSum(closed.x);
        }
    }
    var toward = select(lobe.axis, at.normal, is_diffuse);
    if (is_facets) {
        toward = outline_facets_turn(at.normal, lobe);
    }
    let right = outline_frame(toward);
    outline_project(right);
    var term: OutlineTerm;
    if (is_diffuse) {
        term = outline_lambert(right, at.normal);
    } else if (is_facets) {
        term = outline_microfacets(right, at.normal, lobe);
    } else {
        term = outline_power(right, at.normal, lobe);
    }
    if (term.factor == 0.0) {
        return OutlineSum();
    }
    let is_smooth = is_facets || lobe.exponent >= OUTLINE_STEEP;
    // Discs as polygons where rows of them are too few.
    let is_polygon = outline.radius == 0.0 || (is_facets && (outline.is_clipped || lobe.kind >= LOBE_MICROFACETS_GRAIN));
    if (!OUTLINE_SHOWS && !is_diffuse && is_smooth && is_polygon) {
        outline_as_polygon(right);
        return OutlineSum(term.factor * outline_in_parts(term.value));
    }
    return term.factor * outline_cubature(right, term.peak, term.value);
}

// The corners around a disc become those of a polygon of the same area.
fn outline_as_polygon(right: vec3f) {
    let circle = outline_circle(right);
    for (var i = 0u; i < outline_point_count && outline.radius > 0.0; i++) {
        let away = outline_points[i] - circle.xy;
        if (sqrt(dot(away, away)) > OUTLINE_AT_CORNER * circle.z) {
            outline_points[i] = circle.xy + away * OUTLINE_AS_LARGE;
        }
    }
}

// Lambert's formula in the form of lambert.rs, which does not cancel, and the angles of the edges together.
fn outline_closed(normal: vec3f) -> vec2f {
    let axis = outline.axis;
    let height = outline.height;
    let square = height * height;
    let cos = dot(normal, axis);
    let across = cross(normal, axis);
    let first = outline_in_plane(normal, outline_corners[0]);
    let of_first = square + dot(first, first);
    var sum = 0.0;
    var area = 0.0;
    var around = 0.0;
    for (var i = 0u; i < outline.count; i++) {
        let p = outline_in_plane(normal, outline_corners[i]);
        let q = outline_in_plane(normal, outline_corners[select(i + 1u, 0u, i + 1u == outline.count)]);
        let side = q - p;
        let both = sqrt((square + dot(p, p)) * (square + dot(q, q)));
        let inverse = 1.0 / max(both, 1.1754944e-38);
        // The cross product of the two corners: beside the axis and along it.
        let along = dot(axis, cross(p, side));
        let crossed = height * dot(across, side) + along * cos;
        let length = sqrt(square * dot(side, side) + along * along);
        let sin = length * inverse;
        let z = sin * sin;
        let toward = square + dot(p, q);
        let angle = atan2_f32(length, toward);
        around += angle;
        let series = z * (1.0 / 6.0 + z * (3.0 / 40.0 + z * (15.0 / 336.0 + z * (105.0 / 3456.0))));
        let beyond = select(angle / max(sin, 1.1754944e-38) - 1.0, series, z < OUTLINE_SHORT && toward > 0.0);
        // From the differences of the squares.
        let from_p = dot(p - first, p + first);
        let from_q = dot(q - first, q + first);
        let excess = (of_first * (from_p + from_q) + from_p * from_q) / (of_first * (of_first + both));
        sum += crossed * ((beyond - excess) * inverse);
        area += dot(axis, cross(p - first, q - first));
    }
    return vec2f((area * cos / of_first + sum) / TAU, around);
}

// From the foot of the receiver's perpendicular on the light's plane to a corner.
fn outline_in_plane(normal: vec3f, corner: vec3f) -> vec3f {
    let p = outline_equal(normal, corner);
    return p - outline.axis * dot(outline.axis, p);
}

// From the corner of the polygon around a disc to that of one of the disc's area; a corner that the horizon has made stays.
fn outline_equal(normal: vec3f, p: vec3f) -> vec3f {
    let is_inside = outline.radius > 0.0 && dot(normal, p) > OUTLINE_CUT * sqrt(dot(p, p));
    return select(p, outline.center + (p - outline.center) * OUTLINE_EQUAL, is_inside);
}

fn outline_lambert(right: vec3f, normal: vec3f) -> OutlineTerm {
    let point = outline_nearest(vec2f(0.0));
    let width = vec2f(sqrt(1.0 + dot(point, point)));
    let value = OutlineValue(OUTLINE_COSINE, true, 0.0, outline_local(right, normal), vec3f(0.0));
    return OutlineTerm(1.0, OutlinePeak(point, width), value);
}

fn outline_power(right: vec3f, normal: vec3f, lobe: Lobe) -> OutlineTerm {
    let axis = outline_local(right, lobe.axis);
    // A lobe has a kink at its own horizon.
    if (lobe.exponent < OUTLINE_STEEP) {
        outline_cut(axis);
        if (outline_point_count == 0u) {
            return OutlineTerm();
        }
    }
    let e = min(lobe.exponent, 1e8);
    let length = sqrt(dot(axis.xy, axis.xy));
    let place = select(vec2f(0.0), axis.xy / length, length > 0.0) * outline_largest_at(length, axis.z, e);
    let point = outline_nearest(place);
    let stretch = 1.0 + dot(point, point);
    let along = dot(axis.xy, point) + axis.z;
    let aside = cross(axis, vec3f(point, 1.0));
    let sin_sq = dot(aside, aside) / stretch;
    // Of a light that ends at the lobe's horizon the point may be there.
    let is_steep = lobe.exponent >= OUTLINE_STEEP;
    if (is_steep && (!(along > 0.0) || exp_f32(0.5 * e * ln_of(along * along / stretch, -sin_sq)) < OUTLINE_NOTHING)) {
        return OutlineTerm();
    }
    // How it falls from there: by its own width, or with the slope that it has beside its axis.
    var slope = axis.xy * (e / max(along, 1e-3 / (1.0 + e))) - point * ((e + 3.0) / stretch);
    if (!is_steep) {
        slope = vec2f(0.0);
    }
    let sigma = 1.0 / sqrt(e + 3.0);
    let sigmas = vec2f(stretch, sqrt(stretch)) * sigma;
    let width = 1.5 * sigmas / max(0.5 * abs(slope) * sigmas, vec2f(1.0));
    let value = OutlineValue(OUTLINE_POWER, lobe.kind == LOBE_COSINE, 0.5 * e, outline_local(right, normal), axis);
    return OutlineTerm((e + 1.0) / TAU, OutlinePeak(point, width), value);
}

// How far from the foot of the receiver's perpendicular on the plane at distance 1, toward a lobe's axis, the lobe times the light's
// `1/r³` is largest.
fn outline_largest_at(s: f32, c: f32, e: f32) -> f32 {
    let b = (e + 3.0) * c;
    let root = sqrt(b * b + 12.0 * e * s * s);
    if (c > 0.0) {
        return 2.0 * e * s / (b + root);
    }
    return (root - b) / max(6.0 * s, 1e-6);
}

// Leaves of the projected outline where `n·(x, y, 1)` is not below 0.
fn outline_cut(n: vec3f) {
    let points = outline_points;
    let count = outline_point_count;
    var is_above = true;
    for (var i = 0u; i < count; i++) {
        is_above = is_above && dot(n, vec3f(points[i], 1.0)) >= 0.0;
    }
    if (is_above) {
        return;
    }
    outline_point_count = 0u;
    for (var i = 0u; i < count; i++) {
        let p = points[i];
        let q = points[select(i + 1u, 0u, i + 1u == count)];
        let h = dot(n, vec3f(p, 1.0));
        let g = dot(n, vec3f(q, 1.0));
        if (h >= 0.0) {
            outline_push_point(p);
        }
        if ((h >= 0.0) != (g >= 0.0)) {
            outline_push_point(p + (q - p) * (h / (h - g)));
        }
    }
    if (outline_point_count < 3u) {
        outline_point_count = 0u;
    }
}

fn outline_push_point(p: vec2f) {
    let apart = outline_points[max(outline_point_count, 1u) - 1u] - p;
    let is_last = outline_point_count > 0u && dot(apart, apart) <= 1e-11 * (1.0 + dot(p, p));
    if (outline_point_count < OUTLINE_ROOM && !is_last) {
        outline_points[outline_point_count] = p;
        outline_point_count += 1u;
    }
}

// A place in widths from the peak, as nodes are even in it.
fn outline_place(t: f32) -> f32 { return t / sqrt(1.0 + t * t); }

// The reflectance at the point p of the plane at distance 1; `inverse` is one over its squared length.
fn outline_value(value: OutlineValue, p: vec3f, inverse: f32) -> f32 {
    let cos = dot(value.normal, p) * sqrt(inverse);
    if (value.kind == OUTLINE_COSINE) {
        return FRAC_1_PI * cos;
    }
    if (value.kind == OUTLINE_FACETS) {
        return outline_facets(p * sqrt(inverse));
    }
    let along = dot(value.axis, p);
    let aside = cross(value.axis, p);
    let power = exp_f32(value.half_exponent * ln_of(along * along * inverse, -dot(aside, aside) * inverse));
    return select(0.0, power * select(1.0, cos, value.has_cosine), along > 0.0);
}

var<private> outline_sum: f32;

// Over the projected outline: rows between its corners, or over a disc, as far as its sides let them.
fn outline_cubature(right: vec3f, peak: OutlinePeak, value: OutlineValue) -> OutlineSum {
    outline_begin(right);
    outline_sum = 0.0;
    let count = outline_point_count;
    var corners: array<vec2f, OUTLINE_ROOM>;
    var cuts: array<f32, OUTLINE_ROOM>;
    for (var i = 0u; i < count; i++) {
        corners[i] = (outline_points[i] - peak.point) / peak.width;
        // In order.
        var k = i;
        while (k > 0u && cuts[k - 1u] > corners[i].y) {
            cuts[k] = cuts[k - 1u];
            k -= 1u;
        }
        cuts[k] = corners[i].y;
    }
    // A circle in widths is an ellipse, of which the horizon may leave a part.
    let is_round = outline.radius > 0.0;
    let circle = outline_circle(right);
    let middle = (circle.xy - peak.point) / peak.width;
    let half = vec2f(circle.z) / peak.width;
    let horizon = vec3f(value.normal.xy * peak.width, value.normal.z + dot(value.normal.xy, peak.point));
    var used = count;
    if (is_round) {
        let ends = vec2f(max(cuts[0], middle.y - half.y), min(cuts[count - 1u], middle.y + half.y));
        cuts[0] = ends.x;
        cuts[1] = ends.y;
        used = 2u;
    } else {
        // Without those that only divide what is small.
        let small = OUTLINE_SMALL * (outline_place(cuts[count - 1u]) - outline_place(cuts[0]));
        used = 1u;
        for (var i = 1u; i < count; i++) {
            if (used >= 2u && outline_place(cuts[i]) - outline_place(cuts[used - 2u]) < small) {
                used -= 1u;
            }
            cuts[used] = cuts[i];
            used += 1u;
        }
    }
    for (var piece = 0u; piece + 1u < used; piece++) {
        let low_cut = outline_place(cuts[piece]);
        let high_cut = outline_place(cuts[piece + 1u]);
        let length = high_cut - low_cut;
        if (!(length > 1e-6 * (abs(cuts[piece + 1u]) + 1e-6))) {
            continue;
        }
        var rule = outline_rule(length);
        if (is_round) {
            rule = outline_turned_rule(length);
        }
        for (var k = 0u; k < 2u * rule.y; k++) {
            let node = outline_node(rule, k);
            let u = 0.5 * ((low_cut + high_cut) + length * node.x);
            let rest = 1.0 / max((1.0 - u) * (1.0 + u), 1e-12);
            let y = u * sqrt(rest);
            let weight = 0.5 * length * node.y * rest * sqrt(rest);
            var ends = vec2f(-3e38, 3e38);
            if (is_round) {
                let away = (y - middle.y) / half.y;
                let reach = half.x * sqrt(max((1.0 - away) * (1.0 + away), 0.0));
                ends = outline_within(vec2f(middle.x - reach, middle.x + reach), horizon, y);
                if (horizon.x == 0.0 && horizon.y * y + horizon.z <= 0.0) {
                    ends.y = ends.x;
                }
            } else {
                var p = corners[count - 1u];
                for (var i = 0u; i < count; i++) {
                    let q = corners[i];
                    let edge = q - p;
                    ends = outline_within(ends, vec3f(-edge.y, edge.x, edge.y * p.x - edge.x * p.y), y);
                    p = q;
                }
            }
            if (ends.x < ends.y && ends.y - ends.x < 3e38) {
                outline_row(ends, peak.point.y + peak.width.y * y, weight, peak, value);
            }
        }
    }
    return outline_end(peak, value);
}

// The part of a row where `side·(x, y, 1)` is above 0.
fn outline_within(ends: vec2f, side: vec3f, y: f32) -> vec2f {
    let cut = -(side.y * y + side.z) / side.x;
    return vec2f(select(ends.x, max(ends.x, cut), side.x > 0.0), select(ends.y, min(ends.y, cut), side.x < 0.0));
}

fn outline_row(ends: vec2f, y: f32, row_weight: f32, peak: OutlinePeak, value: OutlineValue) {
    let low = outline_place(ends.x);
    let high = outline_place(ends.y);
    let rule = outline_rule(high - low);
    for (var k = 0u; k < 2u * rule.y; k++) {
        let node = outline_node(rule, k);
        let u = 0.5 * (low + high) + 0.5 * (high - low) * node.x;
        let rest = 1.0 / max((1.0 - u) * (1.0 + u), 1e-12);
        let p = vec3f(peak.point.x + peak.width.x * u * sqrt(rest), y, 1.0);
        let inverse = 1.0 / dot(p, p);
        let area = row_weight * 0.5 * (high - low) * node.y * rest * sqrt(rest) * peak.width.x * peak.width.y;
        outline_sum += area * inverse * sqrt(inverse) * outline_value(value, p, inverse);
    }
}
