// `in_parts` of parts.rs, on the plane at distance 1.

// A corner: its direction's place in the widths of a lobe, and how far it is.
struct OutlineCorner {
    point: vec2f,
    distance: f32,
    slope: vec3f,
}

alias OutlinePart = array<vec2f, 4>;

var<private> outline_waiting: array<OutlinePart, OUTLINE_PARTS_ROOM>;
var<private> outline_waiting_count: u32;

fn outline_wait(part: OutlinePart) {
    outline_waiting[min(outline_waiting_count, OUTLINE_PARTS_ROOM - 1u)] = part;
    outline_waiting_count += 1u;
}

fn outline_slope(value: OutlineValue, direction: vec3f) -> vec3f {
    if (value.kind == OUTLINE_FACETS) {
        return outline_facets_slope(direction);
    }
    let along = dot(value.axis, direction);
    let narrowness = sqrt(2.0 * value.half_exponent + 1.0);
    return (direction - value.axis * along) * (narrowness / sqrt(max(0.5 + 0.5 * along, 1e-4)));
}

fn outline_part_corner(value: OutlineValue, point: vec2f) -> OutlineCorner {
    let p = vec3f(point, 1.0);
    let distance = sqrt(dot(p, p));
    return OutlineCorner(point, distance, outline_slope(value, p / distance));
}

// The least distances of a pole from both ends of a line over its length, of the lines between two.
fn outline_poles(a: vec3f, b: vec3f, c: vec3f, d: vec3f, bend: f32) -> f32 {
    let lengths = sqrt(max(vec2f(dot(b - a, b - a), dot(d - c, d - c)), vec2f(1e-30)));
    let one_way = (b - a) / lengths.x;
    let other_way = (d - c) / lengths.y;
    let starts = vec2f(dot(a, one_way), dot(c, other_way));
    let ends = vec2f(dot(b, one_way), dot(d, other_way));
    let one_aside = a - one_way * starts.x;
    let other_aside = c - other_way * starts.y;
    let is_between = dot(one_aside, other_aside) <= 0.0;
    let asides = sqrt(vec2f(dot(one_aside, one_aside), dot(other_aside, other_aside)));
    let aside = select(max(asides - vec2f(bend), vec2f(0.0)), vec2f(0.0), is_between);
    let heights = vec2f(1.0) + aside * aside;
    let poles = (sqrt(heights + starts * starts) + sqrt(heights + ends * ends)) / lengths;
    return min(poles.x, poles.y);
}

// Half the length of a side in standard deviations, if all of it were as fine as where the lobe is largest.
fn outline_half_side(a: OutlineCorner, b: OutlineCorner) -> f32 {
    let turned = b.slope - a.slope;
    let square = dot(turned, turned);
    let place = clamp(-dot(a.slope, turned) / max(square, 1e-30), 0.0, 1.0);
    let part = place * a.distance / (place * a.distance + (1.0 - place) * b.distance);
    let peak = vec3f(a.point + (b.point - a.point) * part, 1.0);
    return 0.5 * sqrt(square) * a.distance * b.distance / dot(peak, peak);
}

// Whether four nodes are enough along two opposite sides, whether eight are.
fn outline_enough(value: OutlineValue, a: OutlineCorner, b: OutlineCorner, c: OutlineCorner, d: OutlineCorner, bend: f32) -> vec2<bool> {
    var near = outline_poles(vec3f(a.point, 0.0), vec3f(b.point, 0.0), vec3f(c.point, 0.0), vec3f(d.point, 0.0), 0.0);
    var half = 0.0;
    if (value.kind == OUTLINE_FACETS) {
        near = min(near, outline_poles(a.slope, b.slope, c.slope, d.slope, bend));
    } else {
        half = max(outline_half_side(a, b), outline_half_side(c, d));
    }
    let poles = OUTLINE_POLES;
    let deviations = OUTLINE_DEVIATIONS;
    return vec2f(near) >= vec2f(poles[0], poles[1]) & vec2f(half) <= vec2f(deviations[0], deviations[1]);
}

// The same along both pairs of sides.
fn outline_part_enough(value: OutlineValue, part: OutlinePart) -> array<vec2<bool>, 2> {
    let middle = outline_slope(value, normalize(vec3f(0.25 * (part[0] + part[1] + part[2] + part[3]), 1.0)));
    var points = part;
    var corners: array<OutlineCorner, 4>;
    var mean = vec3f(0.0);
    var reach = 0.0;
    for (var k = 0u; k < 4u; k++) {
        corners[k] = outline_part_corner(value, points[k]);
        mean += 0.25 * corners[k].slope;
        let away = corners[k].slope - middle;
        reach = max(reach, dot(away, away));
    }
    // Beyond seven deviations a power is nothing.
    if (value.kind != OUTLINE_FACETS && sqrt(dot(middle, middle)) - 1.5 * sqrt(reach) > 7.0) {
        return array(vec2<bool>(true), vec2<bool>(true));
    }
    let bend = 2.0 * sqrt(dot(middle - mean, middle - mean));
    return array(
        outline_enough(value, corners[0], corners[1], corners[3], corners[2], bend),
        outline_enough(value, corners[0], corners[3], corners[1], corners[2], bend),
    );
}

// Puts the part's halves along its first and third side, or along the others.
fn outline_halve(part: OutlinePart, is_turned: bool) -> array<OutlinePart, 2> {
    var at = part;
    if (is_turned) {
        at = OutlinePart(part[1], part[2], part[3], part[0]);
    }
    let low = 0.5 * (at[0] + at[1]);
    let high = 0.5 * (at[3] + at[2]);
    return array(OutlinePart(at[0], low, high, at[3]), OutlinePart(low, at[1], at[2], high));
}

fn outline_divide(part: OutlinePart, is_wide: bool, is_high: bool) {
    var halves = outline_halve(part, !is_wide);
    for (var k = 0u; k < 2u; k++) {
        if (is_wide && is_high) {
            let quarters = outline_halve(halves[k], true);
            outline_wait(quarters[0]);
            outline_wait(quarters[1]);
        } else {
            outline_wait(halves[k]);
        }
    }
}

// A polygon between two of its corners.
fn outline_fan(first: u32, last: u32) {
    let count = outline_point_count;
    for (var k = first + 1u; k < last; k += 2u) {
        let a = outline_points[first % count];
        let b = outline_points[k % count];
        let c = outline_points[(k + 1u) % count];
        let d = outline_points[min(k + 2u, last) % count];
        outline_wait(OutlinePart(a, b, c, d));
    }
}

// The quadrilateral between the two longest sides, and those of both ends.
fn outline_quadrilaterals() {
    outline_waiting_count = 0u;
    let count = outline_point_count;
    if (count <= OUTLINE_FEW) {
        outline_fan(0u, count - 1u);
        return;
    }
    var longest = 0u;
    var second = 0u;
    var squares = vec2f(0.0);
    for (var k = 0u; k < count; k++) {
        let side = outline_points[(k + 1u) % count] - outline_points[k];
        let square = dot(side, side);
        if (square > squares.x) {
            second = longest;
            longest = k;
            squares = vec2f(square, squares.x);
        } else if (square > squares.y) {
            second = k;
            squares.y = square;
        }
    }
    let one = min(longest, second);
    let other = max(longest, second);
    outline_fan(one + 1u, other);
    outline_fan(other + 1u, one + count);
    let last = outline_points[(other + 1u) % count];
    outline_wait(OutlinePart(outline_points[one], outline_points[one + 1u], outline_points[other], last));
}

// The integral over the projected outline, halved until few nodes are enough for each part.
fn outline_in_parts(value: OutlineValue) -> f32 {
    outline_quadrilaterals();
    var sum = 0.0;
    for (var seen = 0u; outline_waiting_count > 0u; seen++) {
        outline_waiting_count -= 1u;
        let part = outline_waiting[outline_waiting_count];
        let enough = outline_part_enough(value, part);
        let is_last = seen > OUTLINE_PARTS || outline_waiting_count + 4u > OUTLINE_PARTS_ROOM;
        if (!(enough[0].y && enough[1].y) && !is_last) {
            outline_divide(part, !enough[0].y, !enough[1].y);
            continue;
        }
        let middle = 0.25 * (part[0] + part[1] + part[2] + part[3]);
        let right = 0.25 * (part[1] + part[2] - part[0] - part[3]);
        let up = 0.25 * (part[2] + part[3] - part[0] - part[1]);
        let twist = 0.25 * (part[0] + part[2] - part[1] - part[3]);
        let is_few = enough[0].x && enough[1].x;
        let rule = select(OUTLINE_EIGHT, OUTLINE_FOUR, is_few);
        let side = 2u * rule.y;
        for (var k = 0u; k < side * side; k++) {
            let u = outline_node(rule, k % side);
            let v = outline_node(rule, k / side);
            let p = vec3f(middle + right * u.x + up * v.x + twist * (u.x * v.x), 1.0);
            let across = right + twist * v.x;
            let along = up + twist * u.x;
            let area = u.y * v.y * abs(across.x * along.y - across.y * along.x);
            let inverse = 1.0 / dot(p, p);
            sum += area * inverse * sqrt(inverse) * outline_value(value, p, inverse);
        }
    }
    return sum;
}
