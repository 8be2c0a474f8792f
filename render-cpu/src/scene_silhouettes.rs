use crate::Revision;
use ray_tracing::Update;
use rayon::prelude::*;
use scene::{Cancel, Mesh, Scene, Shape};
use std::collections::HashMap;
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
    /// The revision of each mesh's object.
    revisions: Vec<Revision>,
}

impl SceneSilhouettes {
    /// Prepares the meshes of the objects that `blocks` says yes to by their number.
    #[must_use]
    pub fn new(scene: &Scene, blocks: impl Fn(u32) -> bool) -> Self {
        let mut all = Self::default();
        all.update(scene, blocks, &Revision::unedited(scene.objects.len()));
        all
    }

    /// Follows the scene, of whose objects there is a revision each: meshes that have moved are refitted, others that are new are
    /// prepared, the rest stays. How many were prepared, and how many refitted.
    pub fn update(&mut self, scene: &Scene, blocks: impl Fn(u32) -> bool, revisions: &[Revision]) -> [usize; 2] {
        self.update_until(scene, blocks, revisions, &Cancel::new())
    }

    /// The same until the request to stop is made, which is looked at for each mesh. Meshes that were not reached then are as
    /// before: they are not to block anything until the next update.
    pub fn update_until(
        &mut self,
        scene: &Scene,
        blocks: impl Fn(u32) -> bool,
        revisions: &[Revision],
        cancel: &Cancel,
    ) -> [usize; 2] {
        let old = core::mem::take(&mut self.revisions).into_iter().zip(core::mem::take(&mut self.meshes));
        let mut old: HashMap<u64, (Revision, SilhouetteMesh)> = old.map(|(r, mesh)| (r.object, (r, mesh))).collect();
        let chosen = (0..scene.objects.len() as u32).zip(revisions).filter(|(object, _)| blocks(*object));
        let work: Vec<_> = chosen.map(|(object, revision)| (object, *revision, old.remove(&revision.object))).collect();
        let follow = |(object, revision, old): (u32, Revision, Option<(Revision, SilhouetteMesh)>)| {
            if cancel.is_cancelled() {
                return old.map(|(before, kept)| (kept, (before, Update::Kept)));
            }
            let Shape::Mesh(mesh) = &scene.objects[object as usize].shape else { return None };
            let (made, done) = follow(object, mesh, &revision, old);
            Some((made, (revision, done)))
        };
        let made: (Vec<SilhouetteMesh>, Vec<(Revision, Update)>) = work.into_par_iter().filter_map(follow).unzip();
        self.meshes = made.0;
        let (revisions, done): (Vec<Revision>, Vec<Update>) = made.1.into_iter().unzip();
        self.revisions = revisions;
        [Update::Built, Update::Refitted].map(|kind| done.iter().filter(|done| **done == kind).count())
    }

    /// Follows a scene whose objects have moved and are otherwise the same: every mesh is refitted.
    pub fn refit(&mut self, scene: &Scene) {
        self.meshes.par_iter_mut().for_each(|kept| {
            let object = kept.object();
            if let Shape::Mesh(mesh) = &scene.objects[object as usize].shape
                && !kept.refit(&mesh.positions)
            {
                *kept = prepare(object, mesh);
            }
        });
    }

    /// The meshes.
    #[must_use]
    pub fn meshes(&self) -> &[SilhouetteMesh] {
        &self.meshes
    }
}

/// The mesh of an object, made from what there was of it.
fn follow(
    object: u32,
    mesh: &Mesh,
    revision: &Revision,
    old: Option<(Revision, SilhouetteMesh)>,
) -> (SilhouetteMesh, Update) {
    let Some((before, mut kept)) = old.filter(|(before, _)| before.form == revision.form) else {
        return (prepare(object, mesh), Update::Built);
    };
    kept.set_object(object);
    if before.place == revision.place {
        return (kept, Update::Kept);
    }
    if kept.refit(&mesh.positions) { (kept, Update::Refitted) } else { (prepare(object, mesh), Update::Built) }
}
