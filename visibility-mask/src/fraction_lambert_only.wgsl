// All lobes are Lambert's.

alias Weights = LambertWeights;

fn weights_of(mask: Mask, window: UnitSquare, at: Receiver, lobe: Lobe) -> Weights { return lambert_of(window, at); }
fn weights_columns(weights: Weights, x: vec4f) -> mat3x4f { return lambert_columns(x); }
fn weights_row(weights: Weights, y: f32) -> vec3f { return lambert_row(weights, y); }
fn weights_samples(weights: Weights, x: vec4f, y: f32) -> vec4f { return lambert_samples(weights, x, y); }
