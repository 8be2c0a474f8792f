//! The linker's arguments for a module whose Python symbols come from the program that loads it.

fn main() {
    pyo3_build_config::add_extension_module_link_args();
}
