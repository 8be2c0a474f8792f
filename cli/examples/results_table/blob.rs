use cosine_lobes::lobe_core::Sphere;
use glam::Vec3;

/// Spheres that fill a blob of four ellipsoids of height 1 over the origin, radii ∝ N^(−1/3): the same coverage for every
/// N.
pub(crate) fn blob(count: usize) -> Vec<Sphere> {
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 40) as f32 / 16_777_216.0
    };
    let parts = [
        (Vec3::new(0.0, 0.35, 0.0), Vec3::new(0.36, 0.33, 0.30)),
        (Vec3::new(0.22, 0.68, 0.05), Vec3::new(0.20, 0.19, 0.18)),
        (Vec3::new(0.22, 0.92, 0.12), Vec3::new(0.06, 0.16, 0.05)),
        (Vec3::new(-0.30, 0.18, 0.12), Vec3::new(0.13, 0.13, 0.13)),
    ];
    // By volume.
    let volume = |k: usize| parts[k].1.x * parts[k].1.y * parts[k].1.z;
    let all: f32 = (0..4).map(volume).sum();
    let radius = 0.36 * (count as f32).powf(-1.0 / 3.0);
    (0..count)
        .map(|_| {
            let mut pick = random() * all;
            let k = (0..3).find(|k| {
                pick -= volume(*k);
                pick < 0.0
            });
            let (center, half) = parts[k.unwrap_or(3)];
            let inside = loop {
                let p = 2.0 * Vec3::new(random(), random(), random()) - 1.0;
                if p.length_squared() <= 1.0 {
                    break p;
                }
            };
            let radius = radius * (0.5 + 0.9 * random());
            // Away from the surface by the radius, where there is room for it.
            let room = (half - 0.8 * radius).max(0.2 * half);
            Sphere { center: center + inside * room, radius }
        })
        .collect()
}
