use ray_tracing::{GBuffer, World};
use renderer::Renderer;
use scene::Cancel;

/// For each pixel of the whole picture the number of surfaces that its rays meet where an outline or a crease crosses it; 0 where none
/// was found, and everywhere with a fixed number of rays.
pub(crate) fn crossed(renderer: &mut Renderer) -> Vec<u32> {
    let (size, samples) = ([renderer.scene().width, renderer.scene().height], renderer.settings().samples);
    let find = |world: &World<'_>| GBuffer::sampled(world, size, samples, [0..size[0], 0..size[1]], &Cancel::new());
    let found = renderer.with_world(find).unwrap_or_default();
    let mut counts = vec![0; size[0] as usize * size[1] as usize];
    if found.rays.is_empty() {
        return counts;
    }
    let mut first = 0;
    for points in found.pixels.chunk_by(|a, b| a == b) {
        // Elsewhere one point stands for all rays.
        if points.len() > 1 || found.rays[first] < found.samples {
            counts[points[0] as usize] = points.len() as u32;
        }
        first += points.len();
    }
    counts
}
