// In place of outline.wgsl where all lights are seen as cones.

fn light_is_flat() -> bool { return false; }

fn outline_has_sides() -> bool { return false; }

fn light_plane() -> vec4f { return vec4f(0.0); }

fn light_distance(direction: vec3f) -> f32 { return 0.0; }

fn light_middle() -> vec3f { return vec3f(0.0); }

fn light_corner_count() -> u32 { return 0u; }

fn light_corner(i: u32) -> vec3f { return vec3f(0.0); }
