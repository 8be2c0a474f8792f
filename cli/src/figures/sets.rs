//! The mesh that stands for the paper's models, its sphere sets, and blockers made of them.
//!
//! Shared with `examples/results_table`.

use cosine_lobes::Output;
use cosine_lobes::lobe_core::{SelfShadow, Sphere};
use cosine_lobes::scene::{BlockerSet, Mesh, obj_mesh};
use cosine_lobes::sphere_sets::{BuildOptions, SphereSet};
use glam::Mat4;
use std::ops::ControlFlow;
use std::path::Path;

/// A mesh and spheres that stand for it.
pub(crate) struct Model {
    pub(crate) mesh: Mesh,
    pub(crate) set: SphereSet,
    /// So many of the spheres are used.
    pub(crate) count: usize,
}

impl Model {
    /// Its blockers and its mesh, turned and shifted, as the object of a number.
    pub(crate) fn place(&self, matrix: &Mat4, object: u32, blockers: &mut BlockerSet) -> Mesh {
        add(blockers, object, &self.set, matrix, self.count);
        let mut mesh = self.mesh.clone();
        mesh.transform(matrix);
        mesh
    }
}

/// Spot the cow, 1.7 high, facing −z. She comes with the program.
pub(crate) fn spot() -> Result<Mesh, String> {
    let mut mesh = obj_mesh("spot.obj", include_str!("spot.obj")).map_err(|e| e.to_string())?;
    mesh.smooth_normals();
    Ok(mesh)
}

/// So many spheres for her, as this version fits them: read from the folder, or fitted and kept there where that can be.
pub(crate) fn fitted(
    mesh: &Mesh,
    count: usize,
    folder: Option<&Path>,
    report: &mut dyn FnMut(f32),
) -> Result<SphereSet, String> {
    let path = folder.map(|f| f.join(format!("spot-{count}-{}.json", SphereSet::BUILDER)));
    let kept = path.as_ref().and_then(|p| std::fs::read_to_string(p).ok());
    if let Some(set) = kept.and_then(|text| SphereSet::from_json(&text).ok()) {
        return Ok(set);
    }
    let mut hear = |done: f32| {
        report(done);
        ControlFlow::Continue(())
    };
    let set = SphereSet::build_with_progress(&mesh.positions, &mesh.triangles, &BuildOptions::new(count), &mut hear)
        .map_err(|e| e.to_string())?;
    // Kept where that can be; fitted again elsewhere.
    if let Some(path) = path {
        let _ = path.parent().map(std::fs::create_dir_all);
        let _ = Output::create(&path).and_then(|output| output.write(set.to_json().as_bytes()));
    }
    Ok(set)
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

/// Spheres that stand for themselves.
pub(crate) fn add_spheres(out: &mut BlockerSet, object: u32, spheres: &[Sphere]) {
    out.spheres.extend_from_slice(spheres);
    out.self_shadows.resize(out.spheres.len(), SelfShadow::whole(1e-3));
    out.objects.resize(out.spheres.len(), object);
    out.self_distances.resize(object as usize + 1, 0.0);
}
