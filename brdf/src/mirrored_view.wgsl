// 2(n·ω)n − ω.
fn mirrored_view(at: Receiver) -> vec3f {
    return 2.0 * dot(at.normal, at.view) * at.normal - at.view;
}
