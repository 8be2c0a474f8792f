// One light of one frame, for the points of a slice. The same struct as `layout::GpuFrame`.
struct Frame {
    // The sphere around the light, or around a window on it: centre and radius.
    light: vec4f,
    radiance: vec3f,
    tolerance: f32,
    threshold: f32,
    point_count: u32,
    // Words of a queue item: the point's index and the integrals of its lobes.
    queue_stride: u32,
    // Always 2: `note_cut_loops` counts to it, to find loops that the driver ended early.
    rounds: u32,
    // The place in the buffer of images where the light's image begins.
    image: u32,
    // The light's number in the frame.
    number: u32,
    // Cells a side of a mask.
    cells: f32,
    // Where masks are drawn again around a small lit part of a light: nowhere (0), around openings, everywhere (2).
    look_again: u32,
    // Parameters of the kind of light.
    shape: array<vec4f, 26>,
}
