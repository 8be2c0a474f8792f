//! Tells the tests whether the shared collection of files lies beside the repository.

fn main() {
    let shared = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/assets");
    println!("cargo::rustc-check-cfg=cfg(shared_assets)");
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed={shared}");
    if std::path::Path::new(shared).is_dir() {
        println!("cargo::rustc-cfg=shared_assets");
    }
}
