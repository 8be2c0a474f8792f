// Lights that appear as discs: used instead of flat.wgsl.

// The window around the part of the light above the horizon of `normal`, turned so that `across` lies between right and axis.
fn light_window(light: Cone, across: vec3f, normal: vec3f) -> UnitSquare {
    return square_above(square_facing(light, across), normal);
}

// The frame in which directions of edges are summed.
fn edges_frame_of(window: Cone) -> EdgeFrame { return edges_frame(window.axis); }

// The cone that the rotation of a window follows.
fn light_turn(light: Cone) -> Cone { return light; }

// Half the size of the emitting region.
fn light_size(square: UnitSquare) -> f32 { return square.disc; }

// The emitting point nearest to another point; `n` is the horizon's normal in the square's frame.
fn light_nearest(square: UnitSquare, start: vec2f, n: vec3f) -> vec2f {
    return disc_nearest(square, start, n);
}

// The light's disc in the plane: centre and radius.
fn light_disc(square: UnitSquare) -> vec3f { return vec3f(0.0, 0.0, square.disc); }

// The emitting part of a row from `ends.x` to `ends.y`, without regard to the horizon.
fn light_row(ends: vec2f, y: f32) -> vec2f { return ends; }

// Sides of the light besides its disc.
fn light_side_count() -> u32 { return 0u; }
fn light_side(k: u32) -> vec3f { return vec3f(0.0, 0.0, 1.0); }
