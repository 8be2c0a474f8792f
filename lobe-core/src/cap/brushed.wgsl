// The ellipse of cap/brushed.rs. Lobes without a grain have the same roughness along and across.

struct Ellipse {
    view: vec3f,
    one_minus_cos: f32,
    light: vec3f,
    // Across the chords.
    alpha_sq: f32,
    width: f32,
    middle: f32,
    half: f32,
    shadowing: f32,
    is_cut: bool,
    along: f32,
    shear: f32,
}

fn ellipse_of(at: Receiver, lobe: Lobe, light: Seen) -> Ellipse {
    let n = at.normal;
    let seen = seen_from(n, lobe.axis);
    let ahead = tangent_toward(n, lobe.axis);
    let grain = grain_of(lobe);
    let turn = grain_turn(grain);
    let fine = sqrt(microfacets_alpha_sq(lobe.exponent));
    let rough = grain_alpha(grain, fine);
    // Along and across the grain.
    let c = vec2f(dot(ahead, light.axis), dot(cross(n, ahead), light.axis));
    let v = vec3f(seen.y * turn.x, -seen.y * turn.y, seen.x);
    let l = vec3f(c.x * turn.x + c.y * turn.y, c.y * turn.x - c.x * turn.y, dot(n, light.axis));
    let moments = ellipse_moments(v, l, light.one_minus_cos);
    let stretch = vec3f(rough * rough, fine * fine, rough * fine);
    let own = EllipseMoments(moments.middle / vec2f(rough, fine), moments.second / stretch);
    let e = ellipse_chords(own, !light.above);
    let stretched = vec2f(rough, fine) * e.xy;
    let along = sqrt(dot(stretched, stretched));
    let a = stretched / along;
    let across = rough * fine / along;
    let shear = (fine * fine - rough * rough) * e.x * e.y / (along * along);
    let view = vec3f(v.x * a.x + v.y * a.y, v.y * a.x - v.x * a.y, v.z);
    let toward = vec3f(l.x * a.x + l.y * a.y, l.y * a.x - l.x * a.y, l.z);
    let width_sq = 1.0 + e.z * e.z;
    let places = ellipse_places(view, toward, dot(c, c), width_sq * across * across, light);
    let rest = ellipse_sheared(view.xy, vec3f(along, shear, across));
    let shadowing = sqrt(view.z * view.z + dot(rest, rest));
    return Ellipse(
        view, light.one_minus_cos, toward, across * across, sqrt(width_sq), places.x, places.y, shadowing, !light.above, along, shear
    );
}

// `sheared` of brushed.rs: a direction's parts along and across the chords, each times the roughness there.
fn ellipse_sheared(v: vec2f, stretch: vec3f) -> vec2f {
    return vec2f(stretch.x * v.x, stretch.y * stretch.x * v.x + stretch.z * v.y);
}

// α along the chords.
fn ellipse_along(ellipse: Ellipse) -> f32 { return ellipse.along; }

// The shift of the stretched slopes along a chord at `place`.
fn ellipse_shift(ellipse: Ellipse, place: f32) -> f32 { return ellipse.shear * place; }

fn ellipse_slopes(at: vec4f, x: f32) -> vec2f { return vec2f(at.x * at.y * (x + at.w), at.z); }

// `masked` of brushed.rs.
fn ellipse_masking(ellipse: Ellipse, light: vec3f) -> f32 {
    let rest = ellipse_sheared(light.xy, vec3f(ellipse.along, ellipse.shear, sqrt(ellipse.alpha_sq)));
    let up = positive(light.z);
    return 0.5 * up / (up * ellipse.shadowing + ellipse.view.z * sqrt(up * up + dot(rest, rest)));
}
