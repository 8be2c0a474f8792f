//! Sphere sets of the committed mesh, built once.

use cosine_lobes::lobe_core::{SelfShadow, Sphere};
use cosine_lobes::scene::{BlockerSet, Mesh, Shape, load};
use cosine_lobes::sphere_sets::{BuildOptions, SphereSet};
use glam::{Mat4, Vec3};
use std::path::Path;

/// Spot, as her file has her: 1.7 high, facing −z.
pub(crate) fn spot() -> Mesh {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/assets/spot.obj");
    let scene = load(&path).expect("a committed mesh");
    let is_mesh = |shape: &Shape| matches!(shape, Shape::Mesh(mesh) if mesh.triangles.len() > 100);
    match scene.objects.into_iter().map(|o| o.shape).find(is_mesh) {
        Some(Shape::Mesh(mesh)) => mesh,
        _ => unreachable!("it has one mesh"),
    }
}

/// So many spheres for a mesh, as this version builds them: read from beside the program, or built and kept there.
pub(crate) fn set(name: &str, mesh: &Mesh, count: usize) -> SphereSet {
    let folder = std::env::current_exe().ok().and_then(|p| Some(p.parent()?.join("results_table.sets")));
    let path = folder.as_ref().map(|f| f.join(format!("{name}-{count}-{}.json", SphereSet::BUILDER)));
    let kept = path.as_ref().and_then(|p| std::fs::read_to_string(p).ok());
    if let Some(set) = kept.and_then(|text| SphereSet::from_json(&text).ok()) {
        return set;
    }
    eprintln!("fitting {count} spheres to {name}");
    let set = SphereSet::build(&mesh.positions, &mesh.triangles, &BuildOptions::new(count)).expect("a sound mesh");
    if let (Some(folder), Some(path)) = (folder, path) {
        // Kept where that can be; built again elsewhere.
        let _ = std::fs::create_dir_all(folder).and_then(|()| std::fs::write(path, set.to_json()));
    }
    set
}

/// The first `most` spheres of one object, moved by a rotation and translation.
pub(crate) fn add(out: &mut BlockerSet, object: u32, set: &SphereSet, matrix: &Mat4, most: usize) {
    let set = set.placed(matrix);
    out.spheres.extend(set.spheres.iter().take(most));
    out.self_shadows.extend(set.self_shadows.iter().take(most));
    out.objects.resize(out.spheres.len(), object);
    out.self_distances.resize(object as usize + 1, 0.0);
    out.self_distances[object as usize] = set.self_distance;
}

/// Balls that stand for themselves.
pub(crate) fn add_balls(out: &mut BlockerSet, object: u32, balls: &[Sphere]) {
    out.spheres.extend_from_slice(balls);
    out.self_shadows.resize(out.spheres.len(), SelfShadow::whole(1e-3));
    out.objects.resize(out.spheres.len(), object);
    out.self_distances.resize(object as usize + 1, 0.0);
}

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
            // Off the skin by the radius, where there is room for it.
            let room = (half - 0.8 * radius).max(0.2 * half);
            Sphere { center: center + inside * room, radius }
        })
        .collect()
}
