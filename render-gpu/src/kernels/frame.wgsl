// One light of one frame, for the points of a slice. The same struct as `layout::GpuFrame`.
struct Frame {
    // The sphere around the light, and around windows on it: centre and radius.
    light: vec4f,
    radiance: vec3f,
    tolerance: f32,
    threshold: f32,
    point_count: u32,
    // Words of a queue item: the point and the integral of each of its lobes.
    queue_stride: u32,
    // 2: what a loop that nobody ends early comes to.
    rounds: u32,
    // Where the image that the light shows begins in the buffer of images.
    image: u32,
    // Which light of the frame it is.
    number: u32,
    pad0: u32,
    pad1: u32,
    // What else the kind of light is told by.
    shape: array<vec4f, 26>,
}

@group(0) @binding(0) var<uniform> frame: Frame;
