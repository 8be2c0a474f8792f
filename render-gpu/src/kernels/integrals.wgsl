// Integrals in the queue, for lights with the same radiance everywhere.

alias Integral = f32;

// Lobes that an item has room for.
fn queue_lobes() -> u32 { return frame.queue_stride - 1u; }

fn queue_keep(start: u32, lobe: u32, integral: f32) { queue.items[start + 1u + lobe] = bitcast<u32>(integral); }

fn queue_integral(item: u32, lobe: u32) -> f32 {
    return bitcast<f32>(queue.items[item * frame.queue_stride + 1u + lobe]);
}
