// Integrals in the queue, for lights that show an image: one a colour channel.

alias Integral = vec3f;

// Lobes that an item has room for.
fn queue_lobes() -> u32 { return (frame.queue_stride - 1u) / 3u; }

fn queue_keep(start: u32, lobe: u32, integral: vec3f) {
    let words = bitcast<vec3u>(integral);
    queue.items[start + 1u + 3u * lobe] = words.x;
    queue.items[start + 2u + 3u * lobe] = words.y;
    queue.items[start + 3u + 3u * lobe] = words.z;
}

fn queue_integral(item: u32, lobe: u32) -> vec3f {
    let start = item * frame.queue_stride + 1u + 3u * lobe;
    return bitcast<vec3f>(vec3u(queue.items[start], queue.items[start + 1u], queue.items[start + 2u]));
}
