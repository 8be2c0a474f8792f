// The ellipse of cap/microfacets.rs.

struct Ellipse {
    view: vec3f,
    one_minus_cos: f32,
    light: vec3f,
    alpha_sq: f32,
    width: f32,
    middle: f32,
    half: f32,
    shadowing: f32,
    is_cut: bool,
}

fn ellipse_of(at: Receiver, lobe: Lobe, light: Seen) -> Ellipse {
    let n = at.normal;
    let seen = seen_from(n, lobe.axis);
    let ahead = tangent_toward(n, lobe.axis);
    let c = vec3f(dot(ahead, light.axis), dot(cross(n, ahead), light.axis), dot(n, light.axis));
    let alpha_sq = microfacets_alpha_sq(lobe.exponent);
    let e = ellipse_chords(ellipse_moments(vec3f(seen.y, 0.0, seen.x), c, light.one_minus_cos), !light.above);
    let view = vec3f(seen.y * e.x, -seen.y * e.y, seen.x);
    let toward = vec3f(c.x * e.x + c.y * e.y, c.y * e.x - c.x * e.y, c.z);
    let width_sq = alpha_sq + e.z * e.z;
    let places = ellipse_places(view, toward, dot(c.xy, c.xy), width_sq, light);
    let shadowing = sqrt(seen.x * seen.x * (1.0 - alpha_sq) + alpha_sq);
    let width = sqrt(width_sq / alpha_sq);
    return Ellipse(view, light.one_minus_cos, toward, alpha_sq, width, places.x, places.y, shadowing, !light.above);
}

// α along the chords.
fn ellipse_along(ellipse: Ellipse) -> f32 { return sqrt(ellipse.alpha_sq); }

fn ellipse_shift(ellipse: Ellipse, place: f32) -> f32 { return 0.0; }

fn ellipse_slopes(at: vec4f, x: f32) -> vec2f { return vec2f(at.x * at.y * x, at.z); }

fn ellipse_masking(ellipse: Ellipse, light: vec3f) -> f32 {
    return masking(light.z, ellipse.view.z, ellipse.alpha_sq, ellipse.shadowing);
}
