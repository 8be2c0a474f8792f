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

/// A constant of a module.
fn constant(module: &naga::Module, name: &str) -> u32 {
    let found = module.constants.iter().find(|(_, c)| c.name.as_deref() == Some(name));
    let (_, constant) = found.unwrap_or_else(|| panic!("no constant {name}"));
    match module.global_expressions[constant.init] {
        naga::Expression::Literal(naga::Literal::U32(value)) => value,
        ref other => panic!("{name} is {other:?}"),
    }
}
