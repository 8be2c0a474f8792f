//! Builds a sphere set for the triangles of an OBJ file and prints its quality.
//!
//! ```text
//! cargo run --release -p cosine-lobes-sphere-sets --example build_set -- bunny.obj 64 [set.json [preview.rgba]]
//! ```
use std::{error::Error, time::Instant};

use glam::Vec3;
use sphere_sets::{BuildOptions, SphereSet, preview};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [mesh, count, outputs @ ..] = arguments.as_slice() else {
        return Err("usage: build_set MESH.obj COUNT [SET.json [PREVIEW.rgba]]".into());
    };
    let options = tobj::LoadOptions { triangulate: true, single_index: false, ..Default::default() };
    let (models, _) = tobj::load_obj(mesh, &options)?;
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for model in models {
        let first = positions.len() as u32;
        positions.extend(model.mesh.positions.chunks_exact(3).map(Vec3::from_slice));
        triangles.extend(model.mesh.indices.chunks_exact(3).map(|t| [t[0] + first, t[1] + first, t[2] + first]));
    }

    let build = BuildOptions::new(count.parse()?);
    let start = Instant::now();
    let set = SphereSet::build(&positions, &triangles, &build)?;
    let diagonal = set.mesh_bounds[0].distance(set.mesh_bounds[1]);
    println!("{} spheres in {:.2} s: {:?}", set.spheres.len(), start.elapsed().as_secs_f32(), set.quality);
    println!("self-distance {:.4} D", set.self_distance / diagonal);
    if let Some(path) = outputs.first() {
        std::fs::write(path, set.to_json())?;
    }
    if let Some(path) = outputs.get(1) {
        let picture = preview(&set, &positions, &triangles, 480)?;
        std::fs::write(path, picture.data())?;
        println!("{}×{} pixels of RGBA in {path}", picture.width(), picture.height());
    }
    Ok(())
}
