// Inputs and output of the kernels that shade, by either method.
@group(0) @binding(1) var<storage, read> points: array<Receiver>;
@group(0) @binding(2) var<storage, read> materials: array<u32>;
@group(0) @binding(3) var<storage, read_write> radiance: array<vec4f>;
