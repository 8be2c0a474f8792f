use crate::Revision;
use glam::Mat4;
use ray_tracing::Update;
use rayon::prelude::*;
use scene::{Cancel, Instances, Mesh, Scene, Shape};
use std::collections::HashMap;
use std::sync::Arc;
use visibility_silhouettes::{SharedMesh, SilhouetteInstances, SilhouetteMesh};

/// Meshes have simplified forms from this number of triangles on, at all their places together: the outlines of smaller ones are few anyway.
const LARGE: usize = 20_000;

/// Simplified forms of a mesh take as long as they save for this number of receivers a triangle, before a light of a half-angle of 5°.
const WORTH: f64 = 2.0;

/// How many receivers look at lights: decides whether simplified forms are worth their time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Looks(f64);

impl Looks {
    /// Enough that all large meshes have simplified forms.
    pub const MANY: Self = Self(f64::INFINITY);

    /// The number that look at a light of a half-angle of 5°. One that looks at a wider light counts as several.
    #[must_use]
    pub const fn new(receivers: f64) -> Self {
        Self(receivers)
    }

    /// Whether a mesh of a number of triangles, which stands at a number of places, gets simplified forms.
    fn are_worth(self, triangles: usize, places: usize) -> bool {
        triangles.saturating_mul(places) >= LARGE && self.0 >= WORTH * triangles as f64
    }
}

impl Default for Looks {
    fn default() -> Self {
        Self::MANY
    }
}

fn prepare(object: u32, mesh: &Mesh, is_coarse: bool) -> SilhouetteMesh {
    let make = if is_coarse { SilhouetteMesh::with_coarse } else { SilhouetteMesh::new };
    make(object, &mesh.positions, &mesh.triangles)
}

/// The meshes of a scene that block light by their silhouettes, kept and refitted from frame to frame.
#[derive(Clone, Debug, Default)]
pub struct SceneSilhouettes {
    meshes: Vec<SilhouetteMesh>,
    /// The revision of each mesh's object.
    revisions: Vec<Revision>,
    instances: SilhouetteInstances,
    /// The meshes that these were prepared from, and whether with simplified forms.
    shared: Vec<(Arc<Mesh>, bool)>,
    /// Objects that the instances were made of, with their numbers.
    instanced: Vec<(u32, Revision)>,
    are_copied: bool,
    looks: Looks,
}

impl SceneSilhouettes {
    /// Prepares the meshes of the objects that `blocks` says yes to by their number.
    #[must_use]
    pub fn new(scene: &Scene, blocks: impl Fn(u32) -> bool) -> Self {
        let mut all = Self::default();
        all.update(scene, blocks, &Revision::unedited(scene.objects.len()));
        all
    }

    /// Prepares instances as meshes of their own from the next update on, or no longer: a GPU knows no shared meshes.
    pub const fn copy_instances(&mut self, are_copied: bool) {
        self.are_copied = are_copied;
    }

    /// Whether instances are meshes of their own.
    #[must_use]
    pub const fn are_copied(&self) -> bool {
        self.are_copied
    }

    /// Follows the scene, of whose objects there is a revision each: meshes that have moved are refitted, others that are new are
    /// prepared, the rest stays. How many were prepared, and how many refitted.
    pub fn update(&mut self, scene: &Scene, blocks: impl Fn(u32) -> bool, revisions: &[Revision]) -> [usize; 2] {
        self.update_until(scene, blocks, (revisions, Looks::MANY), &Cancel::new())
    }

    /// The same until the request to stop is made, which is looked at for each mesh. Meshes that were not reached then are as
    /// before: they are not to block anything until the next update.
    pub fn update_until(
        &mut self,
        scene: &Scene,
        blocks: impl Fn(u32) -> bool,
        (revisions, looks): (&[Revision], Looks),
        cancel: &Cancel,
    ) -> [usize; 2] {
        let blocking: Vec<bool> = (0..scene.objects.len() as u32).map(blocks).collect();
        self.update_blocking(scene, &blocking, (revisions, looks), cancel)
    }

    /// The same for each object's choice: compiled once, whatever chooses.
    fn update_blocking(
        &mut self,
        scene: &Scene,
        blocking: &[bool],
        (revisions, looks): (&[Revision], Looks),
        cancel: &Cancel,
    ) -> [usize; 2] {
        let before = core::mem::replace(&mut self.looks, looks);
        let old = core::mem::take(&mut self.revisions).into_iter().zip(core::mem::take(&mut self.meshes));
        let mut old: HashMap<u64, (Revision, SilhouetteMesh)> = old.map(|(r, mesh)| (r.object, (r, mesh))).collect();
        let instances_made = match cancel.is_cancelled() {
            true => 0,
            false => self.update_instances(scene, blocking, (revisions, before)),
        };
        let chosen = (0..).zip(revisions).zip(blocking).filter(|(_, blocks)| **blocks);
        let work: Vec<_> =
            chosen.map(|((object, revision), _)| (object, *revision, old.remove(&revision.object))).collect();
        let are_copied = self.are_copied;
        let follow = |(object, revision, old): (u32, Revision, Option<(Revision, SilhouetteMesh)>)| {
            if cancel.is_cancelled() {
                return old.map(|(before, kept)| (kept, (before, Update::Kept)));
            }
            let shape = &scene.objects[object as usize].shape;
            let triangles = match shape {
                Shape::Mesh(mesh) => mesh.triangles.len(),
                Shape::Instances(all) if are_copied => all.triangle_count(),
                Shape::Instances(_) | Shape::Spheres(_) => return None,
            };
            let is_worth = looks.are_worth(triangles, 1);
            let old = old.filter(|_| is_worth == before.are_worth(triangles, 1));
            let (made, done) = follow(object, shape, &revision, (old, is_worth));
            Some((made, (revision, done)))
        };
        let made: (Vec<SilhouetteMesh>, Vec<(Revision, Update)>) = work.into_par_iter().filter_map(follow).unzip();
        self.meshes = made.0;
        let (revisions, done): (Vec<Revision>, Vec<Update>) = made.1.into_iter().unzip();
        self.revisions = revisions;
        if cancel.is_cancelled() {
            // Some meshes may be as before.
            self.looks = before;
        }
        let [made, refitted] =
            [Update::Built, Update::Refitted].map(|kind| done.iter().filter(|d| **d == kind).count());
        [made + instances_made, refitted]
    }

    /// Arranges the shared meshes of instances where any of these have come, gone or moved, and prepares those that are new. How many were
    /// prepared.
    fn update_instances(
        &mut self,
        scene: &Scene,
        blocking: &[bool],
        (revisions, before): (&[Revision], Looks),
    ) -> usize {
        let looks = self.looks;
        let all =
            (0..).zip(&scene.objects).zip(revisions).filter_map(|((number, object), revision)| match &object.shape {
                Shape::Instances(instances) if !self.are_copied && blocking[number as usize] => {
                    Some((number, *revision, instances))
                }
                _ => None,
            });
        let all: Vec<(u32, Revision, &Instances)> = all.collect();
        let names = all.iter().map(|(number, revision, _)| (*number, *revision));
        if looks == before && names.eq(self.instanced.iter().copied()) {
            return 0;
        }
        let mut meshes: Vec<&Arc<Mesh>> = Vec::new();
        let mut places: Vec<Vec<(u32, Mat4)>> = Vec::new();
        let mut known: HashMap<*const Mesh, usize> = HashMap::new();
        for (number, _, instances) in &all {
            let place = *known.entry(Arc::as_ptr(instances.mesh())).or_insert_with(|| {
                meshes.push(instances.mesh());
                places.push(Vec::new());
                meshes.len() - 1
            });
            places[place].extend(instances.places().iter().map(|matrix| (*number, *matrix)));
        }
        let shared = meshes.iter().zip(&places).map(|(mesh, places)| SharedMesh {
            positions: &mesh.positions,
            triangles: &mesh.triangles,
            places,
            is_coarse: looks.are_worth(mesh.triangles.len(), places.len()),
        });
        let shared: Vec<SharedMesh<'_>> = shared.collect();
        let old = core::mem::take(&mut self.instances).into_meshes();
        let mut old: Vec<_> = core::mem::take(&mut self.shared).into_iter().zip(old).collect();
        let earlier = |number: usize| {
            let is_it = |((mesh, is_coarse), _): &((Arc<Mesh>, bool), SilhouetteMesh)| {
                Arc::ptr_eq(mesh, meshes[number]) && *is_coarse == shared[number].is_coarse
            };
            let place = old.iter().position(is_it)?;
            Some(old.swap_remove(place).1)
        };
        let (instances, made) = SilhouetteInstances::with_earlier(&shared, earlier);
        self.instances = instances;
        self.shared = meshes.iter().zip(&shared).map(|(mesh, shared)| (Arc::clone(mesh), shared.is_coarse)).collect();
        self.instanced = all.iter().map(|(number, revision, _)| (*number, *revision)).collect();
        made
    }

    /// Follows a scene whose objects have moved and are otherwise the same: every mesh is refitted.
    pub fn refit(&mut self, scene: &Scene) {
        let looks = self.looks;
        self.meshes.par_iter_mut().for_each(|kept| {
            let object = kept.object();
            if let Some(mesh) = scene.objects[object as usize].shape.mesh()
                && !kept.refit(&mesh.positions)
            {
                *kept = prepare(object, &mesh, looks.are_worth(mesh.triangles.len(), 1));
            }
        });
    }

    /// The receivers for which simplified forms were or were not made.
    #[must_use]
    pub const fn looks(&self) -> Looks {
        self.looks
    }

    /// The shared meshes at their places.
    #[must_use]
    pub const fn instances(&self) -> &SilhouetteInstances {
        &self.instances
    }

    /// The meshes that are not shared.
    #[must_use]
    pub fn meshes(&self) -> &[SilhouetteMesh] {
        &self.meshes
    }
}

/// The triangles of an object, made from what there was of them, with simplified forms or without.
fn follow(
    object: u32,
    shape: &Shape,
    revision: &Revision,
    (old, is_coarse): (Option<(Revision, SilhouetteMesh)>, bool),
) -> (SilhouetteMesh, Update) {
    let mesh = || shape.mesh().unwrap_or_default();
    let Some((before, mut kept)) = old.filter(|(before, _)| before.form == revision.form) else {
        return (prepare(object, &mesh(), is_coarse), Update::Built);
    };
    kept.set_object(object);
    if before.place == revision.place {
        return (kept, Update::Kept);
    }
    let mesh = mesh();
    match kept.refit(&mesh.positions) {
        true => (kept, Update::Refitted),
        false => (prepare(object, &mesh, is_coarse), Update::Built),
    }
}
