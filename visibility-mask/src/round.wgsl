// Lights that are seen as discs: in place of flat.wgsl. Needs square.wgsl.

// The window around what of the light is above the horizon of `normal`, turned so that `across` lies between right and axis.
fn light_window(light: Cone, across: vec3f, normal: vec3f) -> UnitSquare {
    return square_above(square_facing(light, across), normal);
}

// What the turn of a window follows.
fn light_turn(light: Cone) -> Cone { return light; }

// Half the size of what emits.
fn light_size(square: UnitSquare) -> f32 { return square.disc; }

// The emitting point next to another one; `n` is the horizon's normal in the square's frame.
fn light_nearest(square: UnitSquare, start: vec2f, n: vec3f) -> vec2f {
    return disc_nearest(square, start, n);
}

// The disc of light in the plane: middle and radius.
fn light_disc(square: UnitSquare) -> vec3f { return vec3f(0.0, 0.0, square.disc); }

// What of a row from `ends.x` to `ends.y` emits, but for the horizon.
fn light_row(ends: vec2f, y: f32) -> vec2f { return ends; }
