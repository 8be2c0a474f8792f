// Spheres, spots, suns, spheres inside an object and ambient light, as `Light`. `frame.shape[1].w` says which. Reads `frame`.

fn light_cone(at: Receiver) -> Cone {
    if frame.shape[1].w == SUN {
        return Cone(frame.shape[0].xyz, frame.shape[1].x, frame.shape[1].y);
    }
    if frame.shape[1].w == AMBIENT {
        // From inside a light nothing is hidden.
        return Cone(at.normal, 2.0, 1.1754944e-38);
    }
    return cone_of_sphere(at.position, frame.light);
}

fn light_radiance(at: Receiver) -> vec3f {
    if frame.shape[1].w == INSIDE && f32(at.object) == frame.shape[0].x {
        return vec3f(0.0);
    }
    if frame.shape[1].w != SPOT {
        return frame.radiance;
    }
    let to = at.position - frame.light.xyz;
    let cos = dot(frame.shape[0].xyz, to) / max(length(to), 1e-30);
    let part = clamp((cos - frame.shape[1].y) / max(frame.shape[1].x - frame.shape[1].y, 1e-4), 0.0, 1.0);
    // shape[1].z: one over the range, 0 without.
    let reach = dot(to, to) * frame.shape[1].z * frame.shape[1].z;
    return frame.radiance * (part * part * max(1.0 - reach * reach, 0.0));
}
