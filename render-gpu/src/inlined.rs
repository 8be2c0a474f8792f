//! The size of a kernel as drivers compile it, for the tests of this crate.

use naga::{Block, Function, Handle, Module, Statement};
use std::collections::HashMap;

/// Expressions and statements of the first entry point with all functions inlined, as drivers do: a function counts once for each
/// call of it, and for each call of its callers.
pub(crate) fn size(module: &Module) -> usize {
    let mut sizes: HashMap<Handle<Function>, usize> = HashMap::new();
    // Callees come before their callers.
    for (handle, function) in module.functions.iter() {
        let size = of(function, &sizes);
        sizes.insert(handle, size);
    }
    of(&module.entry_points[0].function, &sizes)
}

fn of(function: &Function, known: &HashMap<Handle<Function>, usize>) -> usize {
    function.expressions.len() + of_block(&function.body, known)
}

fn of_block(block: &Block, known: &HashMap<Handle<Function>, usize>) -> usize {
    let of_statement = |statement: &Statement| match statement {
        Statement::Block(block) => of_block(block, known),
        Statement::If { accept, reject, .. } => of_block(accept, known) + of_block(reject, known),
        Statement::Switch { cases, .. } => cases.iter().map(|case| of_block(&case.body, known)).sum(),
        Statement::Loop { body, continuing, .. } => of_block(body, known) + of_block(continuing, known),
        Statement::Call { function, .. } => known[function],
        _ => 0,
    };
    block.iter().map(|statement| 1 + of_statement(statement)).sum()
}

#[test]
fn a_function_counts_for_each_call() {
    let kernel = |calls: &str| {
        let text = format!(
            "var<private> x: f32; fn leaf() {{ x = x * x + x; }} fn twice() {{ leaf(); leaf(); }} \
            @compute @workgroup_size(1) fn main() {{ {calls} }}"
        );
        size(&crate::validated::module(&text))
    };
    let [none, one, two] = ["", "leaf();", "twice();"].map(kernel);
    assert_eq!(two - none, 2 * (one - none) + 2, "a call and a return beside the two calls");
}
