//! Fuzz targets: functions of bytes that panic where something is wrong.
//!
//! cargo-fuzz runs them with coverage (`cargo +nightly fuzz run obj --features libfuzzer`); the program `fuzz` runs the same ones
//! with its own random inputs, the same for the same seed, on any toolchain: `cargo run -p fuzz -- --seconds 30`. Seeds are in
//! `corpus/`.

mod bytes;
mod files;
mod mutate;
mod numbers;
mod shapes;

pub use mutate::{Kind, Source};
use std::path::{Path, PathBuf};

/// One target.
#[derive(Clone, Copy)]
pub struct Target {
    /// Its name: of the binary for cargo-fuzz and of the folder in `corpus/`.
    pub name: &'static str,
    /// The kind of its inputs.
    pub kind: Kind,
    run: fn(&[u8]),
    /// Seeds that are made instead of kept.
    made: fn() -> Vec<Vec<u8>>,
}

/// All targets.
pub const TARGETS: [Target; 16] = [
    Target { name: "obj", kind: Kind::Text, run: files::obj, made: Vec::new },
    Target { name: "ply", kind: Kind::Mixed, run: files::ply, made: Vec::new },
    Target { name: "gltf", kind: Kind::Text, run: files::gltf, made: Vec::new },
    Target { name: "glb", kind: Kind::Mixed, run: files::glb, made: Vec::new },
    Target { name: "scene_file", kind: Kind::Text, run: files::scene_file, made: files::scene_seeds },
    Target { name: "image", kind: Kind::Mixed, run: files::image, made: files::image_seeds },
    Target { name: "mtl", kind: Kind::Text, run: files::mtl, made: files::mtl_seeds },
    Target { name: "sphere_set", kind: Kind::Text, run: files::sphere_set, made: files::sphere_set_seeds },
    Target { name: "exr", kind: Kind::Mixed, run: files::exr, made: files::exr_seeds },
    Target { name: "checkpoint", kind: Kind::Mixed, run: files::checkpoint, made: files::checkpoint_seeds },
    Target { name: "product", kind: Kind::Numbers, run: numbers::product, made: Vec::new },
    Target { name: "cap", kind: Kind::Numbers, run: numbers::cap, made: Vec::new },
    Target { name: "brdf", kind: Kind::Numbers, run: numbers::brdf, made: Vec::new },
    Target { name: "mask", kind: Kind::Numbers, run: numbers::mask, made: Vec::new },
    Target { name: "visibility", kind: Kind::Numbers, run: shapes::visibility, made: Vec::new },
    Target { name: "builder", kind: Kind::Numbers, run: shapes::builder, made: Vec::new },
];

/// The folder of the kept seeds.
#[must_use]
pub fn corpus() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus")
}

/// Runs the target of that name on one input.
///
/// # Panics
/// If the target finds a fault, or if no target has that name.
pub fn run(name: &str, data: &[u8]) {
    let target = TARGETS.iter().find(|t| t.name == name);
    target.unwrap_or_else(|| panic!("there is no target {name}")).run(data);
}

impl Target {
    /// Runs it on one input.
    ///
    /// # Panics
    /// If it finds a fault.
    pub fn run(&self, data: &[u8]) {
        (self.run)(data);
    }

    /// The inputs that others are made from: the files of the corpus, by name, and generated ones.
    #[must_use]
    pub fn seeds(&self) -> Vec<Vec<u8>> {
        let mut files: Vec<PathBuf> = std::fs::read_dir(corpus().join(self.name))
            .map(|folder| folder.flatten().map(|entry| entry.path()).collect())
            .unwrap_or_default();
        files.sort();
        let mut seeds: Vec<Vec<u8>> = files.iter().filter_map(|file| std::fs::read(file).ok()).collect();
        seeds.extend((self.made)());
        if seeds.is_empty() {
            seeds.push(Vec::new());
        }
        seeds
    }
}
