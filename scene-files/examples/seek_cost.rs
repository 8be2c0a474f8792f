//! Cost of posing: microseconds for 1000 vertices of each animated file that is given.
//! Without arguments it measures the animated files and scenes of `scenes`.
//!
//! `cargo run --release -p cosine-lobes-scene --example seek_cost [-- FILE…]` prints a table in Markdown; medians of 101 moments.

use scene::SceneError;

use scene_files::load_animated;
use std::path::{Path, PathBuf};
use std::time::Instant;

const ASSETS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes");

fn main() -> Result<(), SceneError> {
    let mut files: Vec<PathBuf> = std::env::args().skip(1).map(PathBuf::from).collect();
    if files.is_empty() {
        files = ["assets/tentacle.glb", "assets/fox.glb", "walk.toml", "toys.toml", "tentacles.toml"]
            .iter()
            .map(|name| Path::new(ASSETS).join(name))
            .collect();
    }
    println!("| file | moving vertices | joints | morph targets | µs a pose | µs for 1000 vertices |");
    println!("|---|---|---|---|---|---|");
    for file in files {
        let (mut scene, animation, _) = load_animated(&file)?;
        let (mut vertices, mut joints, mut targets) = (0, 0, 0);
        for i in 0..scene.objects.len() {
            if let Some(rig) = animation.rig(i) {
                vertices += rig.joints.len();
                joints += animation.pose(i, 0.0).joints.len();
                targets = targets.max(rig.targets.len());
            }
        }
        let mut times: Vec<f64> = (0..101)
            .map(|k| {
                let time = animation.duration() * k as f32 / 101.0;
                let start = Instant::now();
                animation.seek(time, &mut scene);
                start.elapsed().as_secs_f64() * 1e6
            })
            .collect();
        times.sort_by(f64::total_cmp);
        let median = times[50];
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let each = 1000.0 * median / vertices.max(1) as f64;
        println!("| {name} | {vertices} | {joints} | {targets} | {median:.0} | {each:.1} |");
    }
    Ok(())
}
