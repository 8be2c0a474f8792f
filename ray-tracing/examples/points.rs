//! Cost of finding the visible points by each projection: of the built-in scene, and of scene files given as arguments.
//!
//! `cargo run --release -p cosine-lobes-render-cpu --example points -- scenes/bunny.toml scenes/walk.toml`

use ray_tracing::{GBuffer, World};
use scene::{Projection, Scene};
use std::time::Instant;

/// Pixels a side.
const SIZE: u32 = 256;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    all("built-in", scene::builtin());
    for file in std::env::args().skip(1) {
        all(&file, scene_files::load(&file)?);
    }
    Ok(())
}

/// The scene's own camera, an orthographic one that sees as much around the target, and a panoramic one in its place.
fn all(name: &str, mut scene: Scene) {
    run(name, &scene);
    if let Projection::Perspective { vertical_fov } = scene.camera.projection {
        let height = 2.0 * (0.5 * vertical_fov).tan() * scene.camera.eye.distance(scene.camera.target);
        for projection in [Projection::Orthographic { height }, Projection::Panoramic] {
            scene.camera.projection = projection;
            run(&format!("{name}, {}", projection.name()), &scene);
        }
    }
}

fn run(name: &str, scene: &Scene) {
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
        "{name}: {} triangles, {} spheres, hierarchy {:.1} ms; {} points in {:.2} ms (least {:.2})",
        world.triangle_count(),
        scene.spheres(),
        1e3 * built,
        g.len(),
        1e3 * times[times.len() / 2],
        1e3 * times[0],
    );
}
