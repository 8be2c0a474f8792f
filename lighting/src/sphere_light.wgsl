// A sphere of the same radiance everywhere, as `SphereLight`. Reads `frame`.

fn light_cone(at: Receiver) -> Cone { return cone_of_sphere(at.position, frame.light); }

fn light_radiance(at: Receiver) -> vec3f { return frame.radiance; }
