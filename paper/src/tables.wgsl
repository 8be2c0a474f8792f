// The paper's tables and what is looked up in them: products (§4.1), light and occluder lobes (Eqs. 31, 35).

// `paper_tables` has pairs, as `Tables::pack` writes them: angles and exponents an interval; two for each row of the caps; the products.

// A place between two samples.
struct PaperPlace {
    index: u32,
    fraction: f32,
}

fn paper_steps() -> u32 {
    return u32(paper_tables[0].y) - 1u;
}

fn paper_exponents() -> u32 {
    return 6u * paper_steps() + 1u;
}

// Where the pairs after the tables begin.
fn paper_end() -> u32 {
    let n = paper_exponents();
    return PAPER_PRODUCTS + n * (n + 1u) / 2u * u32(paper_tables[0].x);
}

fn paper_locate_exponent(exponent: f32) -> PaperPlace {
    let e = clamp(exponent, 0.0, PAPER_LAST);
    let steps = paper_steps();
    var base = 0u;
    var start = 0.0;
    var length = 1.0;
    if e >= 1.0 {
        base = 1u;
        start = 1.0;
        length = 9.0;
        while e >= start * 10.0 && base < 5u {
            base += 1u;
            start *= 10.0;
            length *= 10.0;
        }
    }
    let position = (e - start) / length * f32(steps);
    let step = min(u32(position), steps - 1u);
    return PaperPlace(base * steps + step, position - f32(step));
}

fn paper_locate_angle(angle: f32) -> PaperPlace {
    let angles = paper_tables[0].x;
    let position = clamp(angle, 0.0, PI) * (FRAC_1_PI * (angles - 1.0));
    let step = min(u32(position), u32(angles) - 2u);
    return PaperPlace(step, position - f32(step));
}

// Along the angle, between two exponents' numbers.
fn paper_along_angle(i: u32, j: u32, angle: PaperPlace) -> vec2f {
    let low = min(i, j);
    let high = max(i, j);
    let n = paper_exponents();
    // Rows 0, 1, … hold n, n−1, … columns.
    let column = low * n - low * (max(low, 1u) - 1u) / 2u + high - low;
    let first = PAPER_PRODUCTS + column * u32(paper_tables[0].x) + angle.index;
    return paper_mix(paper_tables[first], paper_tables[first + 1u], angle.fraction);
}

fn paper_mix(a: vec2f, b: vec2f, t: f32) -> vec2f {
    return a + t * (b - a);
}

// `ProductTable::lookup`: scale and exponent.
fn paper_lookup(e1: f32, e2: f32, alpha: f32) -> vec2f {
    let i = paper_locate_exponent(e1);
    let j = paper_locate_exponent(e2);
    let k = paper_locate_angle(alpha);
    // A loop, and not four copies.
    var rows = array<vec2f, 4>();
    for (var corner = 0u; corner < 4u; corner++) {
        rows[corner] = paper_along_angle(i.index + corner / 2u, j.index + corner % 2u, k);
    }
    let near = paper_mix(rows[0], rows[1], j.fraction);
    let far = paper_mix(rows[2], rows[3], j.fraction);
    return paper_mix(near, far, i.fraction);
}

// `ProductTable::product`.
fn paper_product(c1: Lobe, c2: Lobe) -> Lobe {
    let e1 = min(c1.exponent, PAPER_LAST);
    let e2 = min(c2.exponent, PAPER_LAST);
    let apart = c1.axis - c2.axis;
    let together = c1.axis + c2.axis;
    let alpha = 2.0 * atan2_f32(sqrt(dot(apart, apart)), sqrt(dot(together, together)));
    let found = paper_lookup(e1, e2, alpha);
    let scale = (c1.flux * ((e1 + 1.0) * FRAC_1_PI * 0.5)) * (c2.flux * ((e2 + 1.0) * FRAC_1_PI * 0.5)) * found.x;
    let axis = paper_product_direction(c1.axis, e1, c2.axis, e2);
    return Lobe(axis, found.y, scale * (TAU / (found.y + 1.0)), max(c1.kind, c2.kind));
}

// The axis of Eq. 19.
fn paper_product_direction(a1: vec3f, e1: f32, a2: vec3f, e2: f32) -> vec3f {
    let across = cross(a1, a2);
    let sine = sqrt(dot(across, across));
    let cosine = dot(a1, a2);
    let largest = max(e1, e2);
    if largest <= 0.0 {
        return paper_unit(a1 + a2, a1);
    }
    // Relative to the larger, so that no square overflows or vanishes.
    let r1 = e1 / largest;
    let r2 = e2 / largest;
    let difference = (r1 - r2) * cosine;
    let root = sqrt(difference * difference + 4.0 * r1 * r2);
    let sum = (r1 + r2) * abs(cosine) + root;
    var one = vec2f(2.0 * r2 * sine, sum);
    var two = vec2f(2.0 * r1 * sine, sum);
    if cosine < 0.0 {
        one = vec2f(sum, 2.0 * r1 * sine);
        two = vec2f(sum, 2.0 * r2 * sine);
    }
    return paper_unit(a1 * (two.x / sqrt(dot(two, two))) + a2 * (one.x / sqrt(dot(one, one))), a1);
}

fn paper_unit(v: vec3f, other: vec3f) -> vec3f {
    let square = dot(v, v);
    if square > 1e-37 {
        return v * (1.0 / sqrt(square));
    }
    return other;
}

// Scale and spread of a light, spread of an occluder.
fn paper_cap(one_minus_cos: f32) -> vec3f {
    let position = clamp(one_minus_cos, 0.0, 1.0) * f32(PAPER_CAP_VALUES - 1u);
    let i = min(u32(position), PAPER_CAP_VALUES - 2u);
    let t = position - f32(i);
    let row = PAPER_CAPS + 2u * i;
    let light = paper_mix(paper_tables[row], paper_tables[row + 2u], t);
    let occluder = paper_mix(paper_tables[row + 1u], paper_tables[row + 3u], t);
    return vec3f(light, occluder.x);
}

// `exponent` of cap_table.rs; for a cone without extent as large as floats are, nearly.
fn paper_exponent(spread: f32, one_minus_cos: f32) -> f32 {
    return max(spread / max(one_minus_cos, 1e-37) - 1.0, 0.0);
}

// `CapTable::light` (Eq. 30).
fn paper_light_lobe(cone: Cone, radiance: vec3f) -> Lobe {
    let cap = paper_cap(cone.one_minus_cos);
    let q = clamp(cone.one_minus_cos, 0.0, 1.0);
    return Lobe(cone.axis, paper_exponent(cap.y, q), radiance * (TAU * cap.x * q / cap.y), LOBE_PLAIN);
}

// `CapTable::occluder` (Eq. 34).
fn paper_occluder(cone: Cone) -> Lobe {
    let cap = paper_cap(cone.one_minus_cos);
    let q = clamp(cone.one_minus_cos, 0.0, 1.0);
    return Lobe(cone.axis, paper_exponent(cap.z, q), vec3f(TAU * q / cap.z), LOBE_PLAIN);
}

// The product f̃·L of `Integrator::by_paper`: its flux is the unshadowed radiance.
fn paper_reflected(at: Receiver, lobe: Lobe, light: Lobe) -> Lobe {
    var f = lobe;
    if lobe.kind == LOBE_COSINE {
        // A receiver's cosine is one more lobe (Eq. 12).
        f = paper_product(Lobe(lobe.axis, lobe.exponent, lobe.flux, LOBE_PLAIN), Lobe(at.normal, 1.0, vec3f(PI), LOBE_PLAIN));
    }
    return paper_product(f, light);
}
