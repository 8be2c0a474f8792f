// The chords of the ellipse of cap/microfacets.rs, whose numbers are those of ellipse.wgsl or brushed.wgsl.

// The integral over a light of the edge of microfacets, which has come with that of the lobe before it.
struct KnownEdge {
    axis: vec3f,
    exponent: f32,
    light: vec3f,
    integral: f32,
}

var<private> known_edge_integral: KnownEdge;

fn microfacets_integral(at: Receiver, lobe: Lobe, light: Seen) -> f32 {
    let known = known_edge_integral;
    let is_edge = microfacets_is_edge(lobe);
    if (is_edge && known.exponent == lobe.exponent && all(known.axis == lobe.axis) && all(known.light == light.axis)) {
        // Of this receiver, and no other.
        known_edge_integral.axis = vec3f(0.0);
        return known.integral;
    }
    var both = vec2f();
    if (light.one_minus_cos >= 1.0 && all(light.axis == at.normal)) {
        both = microfacets_albedo(at, lobe);
    } else {
        both = ellipse_integral(ellipse_of(at, lobe, light));
    }
    known_edge_integral = KnownEdge(select(lobe.axis, vec3f(0.0), is_edge), lobe.exponent, light.axis, both.y);
    return select(both.x, both.y, is_edge);
}

// Of both lobes.
fn ellipse_integral(ellipse: Ellipse) -> vec2f {
    var sum = vec2f(0.0);
    let count = select(5u, 16u, ellipse.is_cut);
    for (var k = 0u; k < 2u * count; k++) {
        let place = min(k, 2u * count - 1u - k);
        var node = vec2f();
        if (ellipse.is_cut) {
            node = NODES_CUT[place];
        } else {
            node = NODES_WHOLE[place];
        }
        sum += ellipse_node(ellipse, select(node.x, -node.x, k < count), node.y);
    }
    return max(sum * ellipse.half * FRAC_1_PI, vec2f(0.0));
}

fn root_of(x: f32) -> f32 { return sqrt(positive(x)); }

fn above_zero(x: f32) -> f32 { return max(x, 1e-12); }

// An ellipse by its middle and its second moment about that: xx, yy and xy.
struct EllipseMoments {
    middle: vec2f,
    second: vec3f,
}

// `moments` of ellipse.rs, in slopes.
fn ellipse_moments(view: vec3f, light: vec3f, omc: f32) -> EllipseMoments {
    let near = max(view.z + light.z, 1e-3);
    let s = (view.xy + light.xy) / near;
    let both = 1.0 + dot(view, light);
    let k = both - omc;
    let n = vec3f(k - 2.0 * view.xy * light.xy, -(view.x * light.y + view.y * light.x));
    let det = n.x * n.y - n.z * n.z;
    let inverse = select(0.0, 1.0 / det, det > 1e-9 && n.x + n.y > 0.0);
    let z = omc * inverse * vec2f(n.y * s.x - n.z * s.y, n.x * s.y - n.z * s.x);
    let size = 0.25 * inverse * (2.0 * both * omc / (near * near) + omc * dot(s, z));
    return EllipseMoments(s + z, size * vec3f(n.y, n.x, -n.z));
}

// The longer axis of a second moment, and by how much its eigenvalues differ.
fn ellipse_longer_axis(second: vec3f) -> vec3f {
    let twice = 2.0 * second.z;
    let difference = second.x - second.y;
    let root = sqrt(difference * difference + twice * twice);
    let double = select(1.0, difference / root, root > 1e-30);
    let up = root_of(0.5 * (1.0 - double));
    return vec3f(root_of(0.5 * (1.0 + double)), select(up, -up, twice < 0.0), root);
}

// `chords_of` of ellipse.rs: the direction of chords, and the gap.
fn ellipse_chords(ellipse: EllipseMoments, is_cut: bool) -> vec3f {
    let m = ellipse.middle;
    let inside = vec3f(ellipse_longer_axis(ellipse.second + vec3f(m * m, m.x * m.y)).xy, 0.0);
    let axis = ellipse_longer_axis(ellipse.second);
    let sum = ellipse.second.x + ellipse.second.y;
    let square = 2.0 * max(vec2f(sum + axis.z, sum - axis.z), vec2f(1e-30));
    let p = vec2f(dot(m, axis.xy), m.y * axis.x - m.x * axis.y);
    let scaled = square * p * p;
    var lambda = max(max(sqrt(scaled.x + scaled.y) - square.x, sqrt(scaled.y) - square.y), 0.0);
    for (var k = 0u; k < ELLIPSE_STEPS; k++) {
        let over = 1.0 / (square + lambda);
        let parts = scaled * over * over;
        lambda += max(0.5 * (parts.x + parts.y - 1.0) / dot(parts, over), 0.0);
    }
    let nearest = p / (square + lambda);
    let length = sqrt(dot(nearest, nearest));
    if (!(lambda > 0.0 && length > 0.0 && length < 1e30)) {
        return inside;
    }
    let n = nearest / length;
    let toward = vec2f(n.x * axis.x - n.y * axis.y, n.x * axis.y + n.y * axis.x);
    return vec3f(-toward.y, toward.x, select(lambda * length, 0.0, is_cut));
}

// Middle and half of the chords' places, of view and light along the chords and the square of the places' width. `flat` is the squared length of the
// light's direction along the surface.
fn ellipse_places(view: vec3f, toward: vec3f, flat: f32, width_sq: f32, light: Seen) -> vec2f {
    let omc = light.one_minus_cos;
    let sin_sq = omc * (2.0 - omc);
    // From where to where: a·z² − 2b·z − d ≤ 0 about the half vector of the light's middle.
    let height = view.z + toward.z;
    let across = view.y + toward.y;
    let y0 = across / max(height, 1e-3);
    let tilt = view.y - y0 * view.z;
    let a = height * height - 2.0 * omc * view.z * toward.z - sin_sq;
    let b = omc * tilt * (view.z - toward.z) + sin_sq * y0;
    let d = omc * ((2.0 - omc) * (1.0 + y0 * y0) - 2.0 * tilt * tilt);
    let root = root_of(b * b + a * d);
    var low = y0 + (b - root) / a;
    var high = y0 + (b + root) / a;
    if (!light.above) {
        if (height <= 0.05) {
            // About the normal: near the horizon the half vector of the middle may be below it.
            let b = omc * (view.y * toward.z + toward.y * view.z) - across * height;
            let d = across * across - 2.0 * omc * view.y * toward.y - sin_sq;
            let root = root_of(b * b - a * d);
            let q = -b - select(root, -root, b < 0.0);
            low = q / a;
            high = d / select(1e-30, q, abs(q) > 1e-30);
        }
        // Of what is above the horizon: where the rim meets it, its own ends where the light has them, and where a line of half
        // vectors touches the light above it.
        let cosine = 1.0 - omc;
        let square = max(flat, 1e-12);
        let along = cosine / square;
        let beside = root_of(1.0 - cosine * along) / sqrt(square);
        let one = (view.y + toward.y * along + toward.x * beside) / view.z;
        let other = (view.y + toward.y * along - toward.x * beside) / view.z;
        var least = select(min(one, other), (view.y - 1.0) / view.z, toward.y < -cosine);
        var most = select(max(one, other), (view.y + 1.0) / view.z, toward.y > cosine);
        let axes = vec4f(view.z, view.y, toward.z, toward.y);
        if (ellipse_touches(axes, omc, low)) {
            least = min(least, low);
            most = max(most, low);
        }
        if (ellipse_touches(axes, omc, high)) {
            least = min(least, high);
            most = max(most, high);
        }
        low = least;
        high = most;
    }
    let first = low / sqrt(width_sq + low * low);
    let last = high / sqrt(width_sq + high * high);
    return vec2f(0.5 * (first + last), positive(0.5 * (last - first)));
}

// Whether the line of half vectors at `y` touches the light in one direction above the horizon. `axes`: the eye's and the light's
// heights and parts across the chords.
fn ellipse_touches(axes: vec4f, omc: f32, y: f32) -> bool {
    let over = 1.0 / (1.0 + y * y);
    let mu = axes.y - y * axes.x;
    let nu = axes.w - y * axes.z;
    let of_view = root_of(1.0 - mu * mu * over);
    let of_light = root_of(1.0 - nu * nu * over);
    let scale = of_view / max(of_light, 1e-6);
    let up = y * over * (mu + nu * scale) + axes.z * scale;
    let inside = of_view * of_light - mu * nu * over;
    return up > 0.0 && abs(inside - (1.0 - omc)) < 1e-3 && abs(y) < ELLIPSE_FAR;
}

// The rest of the reflectance of both lobes at a half vector of these slopes.
fn ellipse_rest(ellipse: Ellipse, slopes: vec2f) -> vec2f {
    let u = positive(dot(ellipse.view.xy, slopes) + ellipse.view.z);
    let square = 1.0 + dot(slopes, slopes);
    let fifth = schlick(u / sqrt(square));
    // dω_l = 4 (ω_o·h) dω_h; the cosine lobe has taken n·h.
    let scale = 2.0 * u / square;
    let light = vec3f(scale * slopes - ellipse.view.xy, scale - ellipse.view.z);
    return u * ellipse_masking(ellipse, light) * vec2f(1.0 - fifth, fifth);
}

// One chord of both lobes, times its weight.
fn ellipse_node(ellipse: Ellipse, cosine: f32, weight: f32) -> vec2f {
    let v = ellipse.view;
    let c = ellipse.light;
    let along = ellipse_along(ellipse);
    let t = ellipse.middle + ellipse.half * cosine;
    let rest = (1.0 - t) * (1.0 + t);
    let y = ellipse.width * t / sqrt(above_zero(rest));
    let square = rest + ellipse.width * ellipse.width * (t * t);
    let own_weight = weight * ellipse.width / (square * sqrt(square));
    let slope = sqrt(ellipse.alpha_sq) * y;
    let root = sqrt(1.0 + slope * slope);

    // The plane of half vectors across m = (0, 1, −slope)/root cuts directions by l·m = −ω_o·m: an arc 2φ of the light.
    let over = 1.0 / root;
    let mu = (v.y - slope * v.z) * over;
    let nu = (c.y - slope * c.z) * over;
    let beside = ((v.y + c.y) - slope * (v.z + c.z)) * over;
    let of_view = above_zero(1.0 - mu * mu);
    let of_light = above_zero(1.0 - nu * nu);
    let product = sqrt(of_view * of_light);
    // 1 − cos φ without cancellation.
    let arc = (ellipse.one_minus_cos - beside * beside / above_zero(product + 1.0 + mu * nu)) / product;
    if (!(arc > 0.0)) {
        return vec2f(0.0);
    }
    let all = arc >= 1.9999;
    let part = min(arc, 1.9999);
    let tangent = sqrt(part / (2.0 - part));
    // Half vectors: φ/2 about the middle between eye and light, of which only the tangent counts.
    let to_view = vec2f(v.x, (slope * v.y + v.z) * over) * (1.0 / sqrt(of_view));
    let to_light = vec2f(c.x, (slope * c.y + c.z) * over) * (1.0 / sqrt(of_light));
    var middle = to_view + to_light;
    if (ellipse.is_cut && dot(middle, middle) < 1.0) {
        // Both are about opposite: what is across their difference.
        middle = vec2f(to_light.y - to_view.y, to_view.x - to_light.x);
    }
    middle *= 1.0 / sqrt(above_zero(dot(middle, middle)));

    let b = sqrt(1.0 + y * y);
    let scale = root / (along * b);
    let shift = ellipse_shift(ellipse, y / b);
    let below = middle.y + middle.x * tangent;
    let above = middle.y - middle.x * tangent;
    var p = scale * ellipse_end(middle.x - tangent * middle.y, below) - shift;
    var q = scale * ellipse_end(middle.x + tangent * middle.y, above) - shift;
    if (all) {
        p = -ELLIPSE_FAR * scale;
        q = ELLIPSE_FAR * scale;
    }
    let is_one = p < q;
    var length = scale * 2.0 * tangent / (below * above);
    if (all || below * above < 1e-9) {
        length = q - p;
    }
    let at = vec4f(along, b, slope, shift);
    if (!ellipse.is_cut) {
        return own_weight * ellipse_part(ellipse, at, p, q, select(0.0, length, is_one));
    }
    let aside = slope - v.y / v.z;
    let reach = root_of(1.0 / (v.z * v.z) - aside * aside);
    let unit = 1.0 / (along * b);
    let least = (v.x / v.z - reach) * unit - shift;
    let most = (v.x / v.z + reach) * unit - shift;
    // One range from p to q, in halves by its angle, or all but what is between q and p.
    let low = max(p, least);
    let high = min(q, most);
    let whole = select(length, high - low, least > p || most < q);
    let of_low = sqrt(1.0 + low * low);
    let before = whole * of_low / (of_low + sqrt(1.0 + high * high));
    let ends = select(vec2f(most, least), vec2f(low + before), is_one);
    let lengths = select(vec2f(most - low, high - least), vec2f(before, whole - before), is_one);
    let first = ellipse_part(ellipse, at, low, ends.x, lengths.x);
    return own_weight * (first + ellipse_part(ellipse, at, ends.y, high, lengths.y));
}

fn ellipse_end(end: f32, steep: f32) -> f32 {
    if (abs(steep) > 1e-5) {
        return end / steep;
    }
    return select(-ELLIPSE_FAR, ELLIPSE_FAR, (end < 0.0) == (steep < 0.0));
}

// A range of a chord; `at` is α along it, √(1 + y²), the slope across and the shift of the stretched slopes.
fn ellipse_part(ellipse: Ellipse, at: vec4f, p: f32, q: f32, length: f32) -> vec2f {
    if (!(length > 0.0)) {
        return vec2f(0.0);
    }
    // ∫ dX/(1+X²)² from p to q, without the difference.
    let m = 1.0 + p * q;
    let inverse_sq = 1.0 / (m * m + length * length);
    var value = 0.0;
    var angle = 0.0;
    if (length < 0.3 * m) {
        let ratio = length / m;
        let sq = ratio * ratio;
        let series = ratio * sq * (2.0 / 3.0 - sq * (0.8 - sq * (6.0 / 7.0 - sq * (8.0 / 9.0))));
        value = 0.5 * (2.0 * length * inverse_sq + series);
        angle = ratio * (1.0 - sq * (1.0 / 3.0 - sq * (0.2 - sq / 7.0)));
    } else {
        angle = atan2_f32(length, m);
        value = 0.5 * (length * (2.0 - m) * inverse_sq + angle);
    }
    if (!(value > 0.0)) {
        return vec2f(0.0);
    }
    let inverse = 1.0 / max(value, 1e-30);
    let mean = 0.5 * length * (p + q) * inverse_sq * inverse;
    let apart = root_of((angle - value) * inverse - mean * mean);
    let first = ellipse_slopes(at, max(mean - apart, p));
    let last = ellipse_slopes(at, min(mean + apart, q));
    return value * 2.0 * (ellipse_rest(ellipse, first) + ellipse_rest(ellipse, last));
}
