//! The time and the memory until the first picture of a scene or model:
//! `cargo run --release --example first_picture -- FILE`
//!
//! Processor time and memory are those of the process, so each file needs a process of its own. The picture has 256 × 256 pixels.

use cosine_lobes::glam::Vec3;
use cosine_lobes::renderer::{Renderer, Settings};
use cosine_lobes::scene::load_animated;
use std::error::Error;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args().nth(1).ok_or("expected a file")?;
    let begin = Instant::now();
    let (mut scene, animation, _) = load_animated(&file)?;
    let loaded = begin.elapsed().as_secs_f64();
    (scene.width, scene.height) = (256, 256);
    let (triangles, objects) = (scene.triangles(), scene.objects.len());
    println!("{file}: {triangles} triangles in {objects} objects");
    println!("loading {loaded:.2} s, processor {:.2} s, most memory {} MB", processor(), memory());
    let mut renderer = Renderer::new(scene, animation, Settings::default())?;
    let image = renderer.render()?;
    let clocks = image.stats.clocks;
    println!("hierarchy for rays {:.2} s, silhouettes {:.2} s", clocks.hierarchy, clocks.silhouettes);
    let first = begin.elapsed().as_secs_f64();
    println!("first picture after {first:.2} s, processor {:.2} s, most memory {} MB", processor(), memory());
    let begin = Instant::now();
    let again = renderer.render()?;
    println!("second picture {:.3} s, checksum {:016x}", begin.elapsed().as_secs_f64(), checksum(&again.radiance));
    Ok(())
}

/// A number of `/proc/self/status` in MB, or 0 where there is no such file.
fn memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let most = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let number = most.and_then(|line| line.trim().trim_end_matches(" kB").parse::<u64>().ok());
    number.unwrap_or_default() / 1000
}

/// Seconds of processor time of all threads.
fn processor() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = stat.rsplit(')').next().unwrap_or_default().split_whitespace();
    let ticks: f64 = fields.skip(11).take(2).filter_map(|field| field.parse::<f64>().ok()).sum();
    ticks / 100.0
}

/// FNV-1a of the bits.
fn checksum(radiance: &[Vec3]) -> u64 {
    let bytes = radiance.iter().flat_map(|p| p.to_array()).flat_map(f32::to_le_bytes);
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
}
