use rayon::prelude::*;
use scene::{Mesh, Scene, Shape};
use visibility_silhouettes::SilhouetteMesh;

/// Meshes from so many triangles on have simplified forms: the outlines of smaller ones are few anyway.
const LARGE: usize = 20_000;

fn prepare(object: u32, mesh: &Mesh) -> SilhouetteMesh {
    let make = if mesh.triangles.len() < LARGE { SilhouetteMesh::new } else { SilhouetteMesh::with_coarse };
    make(object, &mesh.positions, &mesh.triangles)
}

/// The meshes of a scene that block light by their silhouettes, kept and refitted from frame to frame.
#[derive(Clone, Debug, Default)]
pub struct SceneSilhouettes {
    meshes: Vec<SilhouetteMesh>,
}

impl SceneSilhouettes {
    /// Prepares the meshes of the objects that `blocks` says yes to by their number.
    #[must_use]
    pub fn new(scene: &Scene, blocks: impl Fn(u32) -> bool) -> Self {
        let chosen: Vec<_> = (0..scene.objects.len() as u32).filter(|o| blocks(*o)).collect();
        let mesh = |object: u32| match &scene.objects[object as usize].shape {
            Shape::Mesh(mesh) => Some(prepare(object, mesh)),
            Shape::Spheres(_) => None,
        };
        Self { meshes: chosen.into_par_iter().filter_map(mesh).collect() }
    }

    /// Follows the scene to another moment: the same objects, the same triangles.
    pub fn update(&mut self, scene: &Scene) {
        for kept in &mut self.meshes {
            if let Shape::Mesh(mesh) = &scene.objects[kept.object() as usize].shape
                && !kept.refit(&mesh.positions)
            {
                *kept = SilhouetteMesh::new(kept.object(), &mesh.positions, &mesh.triangles);
            }
        }
    }

    /// The meshes.
    #[must_use]
    pub fn meshes(&self) -> &[SilhouetteMesh] {
        &self.meshes
    }
}
