//! Cost of finding the visible points: the built-in scene, and scene files given as arguments.
//!
//! `cargo run --release -p cosine-lobes-render-cpu --example points -- scenes/bunny.toml scenes/walk.toml`

use ray_tracing::{GBuffer, World};
use std::time::Instant;

/// Pixels a side.
const SIZE: u32 = 256;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    run("built-in", &scene::builtin());
    for file in std::env::args().skip(1) {
        run(&file, &scene_files::load(&file)?);
    }
    Ok(())
}

fn run(name: &str, scene: &scene::Scene) {
    let start = Instant::now();
    let world = World::new(scene);
    let built = start.elapsed().as_secs_f64();
    let mut times: Vec<f64> = (0..31)
        .map(|_| {
            let start = Instant::now();
            let g = GBuffer::new(&world, SIZE, SIZE, 1);
            assert!(!g.is_empty());
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    let g = GBuffer::new(&world, SIZE, SIZE, 1);
    println!(
        "{name}: {} triangles, {} balls, hierarchy {:.1} ms; {} points in {:.2} ms (least {:.2})",
        world.triangle_count(),
        scene.spheres(),
        1e3 * built,
        g.len(),
        1e3 * times[times.len() / 2],
        1e3 * times[0],
    );
}
