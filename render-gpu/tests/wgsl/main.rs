//! The WGSL without a GPU: every variant validates, layouts and constants are the same as in Rust.

mod brdf;
mod lobes;
mod maps;
mod masks;
mod numbers;
mod pose;
mod rays;
mod spheres;
#[path = "../../src/validated.rs"]
mod validated;

/// The buffers of kernels that shade, as they declare them.
const FRAMED: &str = "@group(0) @binding(0) var<uniform> frame: Frame;\n";
const QUEUED: &str = "@group(0) @binding(4) var<storage, read_write> queue: Queue;\n";
const SHADED: &str = "@group(0) @binding(1) var<storage, read> points: array<Receiver>;
    @group(0) @binding(2) var<storage, read> materials: array<u32>;
    @group(0) @binding(3) var<storage, read_write> radiance: array<vec4f>;\n";

/// A constant of a module.
fn constant(module: &naga::Module, name: &str) -> u32 {
    let found = module.constants.iter().find(|(_, c)| c.name.as_deref() == Some(name));
    let (_, constant) = found.unwrap_or_else(|| panic!("no constant {name}"));
    match module.global_expressions[constant.init] {
        naga::Expression::Literal(naga::Literal::U32(value)) => value,
        ref other => panic!("{name} is {other:?}"),
    }
}
