use crate::event::tell;
use crate::{Event, Listener, Plan, RenderError, cache};
use core::ops::ControlFlow;
use glam::Mat4;
use render_cpu::{BlockersError, Revision, SceneSpheres, SphereSource};
use scene::{Animation, Mesh, Object, Proxy, Scene, Stopwatch};
use sphere_sets::{BuildOptions, SetQuality, SphereSet};
use std::path::{Path, PathBuf};
use xxhash_rust::xxh3::Xxh3;

/// The extension of the files of sets.
const ENDING: &str = "json";

/// The blocker spheres of the objects that the plan gives any; the scene is at its first moment. Sets are read from the `cache`,
/// and written to it.
///
/// # Errors
/// [`RenderError::Blockers`], [`RenderError::Cancelled`].
pub fn scene_spheres(
    scene: &mut Scene,
    animation: &Animation,
    plan: &Plan,
    cache: Option<&Path>,
    listener: &mut Listener<'_>,
) -> Result<SceneSpheres, RenderError> {
    let (mut spheres, revisions) = (SceneSpheres::default(), Revision::unedited(scene.objects.len()));
    let scope = Scope { animation, plan, cache, revisions: &revisions };
    follow_spheres(&mut spheres, scene, &scope, listener)?;
    Ok(spheres)
}

/// The inputs of sphere sets beside the scene.
pub(crate) struct Scope<'a> {
    pub(crate) animation: &'a Animation,
    pub(crate) plan: &'a Plan,
    pub(crate) cache: Option<&'a Path>,
    pub(crate) revisions: &'a [Revision],
}

/// Fits or reads the spheres that are missing, for objects at their initial places. Returns how many objects have new ones.
pub(crate) fn follow_spheres(
    spheres: &mut SceneSpheres,
    scene: &mut Scene,
    scope: &Scope<'_>,
    listener: &mut Listener<'_>,
) -> Result<usize, RenderError> {
    let Scope { animation, plan, cache, revisions } = *scope;
    if let Some(folder) = cache {
        fill(scene, plan, folder, listener)?;
    }
    let source = |object| plan.spheres(scene, object);
    // `fill` has done the slow work, unless the set could not be stored.
    let count = |name: &str| match scene.objects.iter().find(|o| o.name == name).map(|o| &o.proxy) {
        Some(Proxy::Count(count)) => *count,
        _ => 0,
    };
    let mut progress = |object: &str, done| listener(Event::Fitting { object, spheres: count(object), done });
    let made = spheres.update(scene, Some(animation), source, revisions, &mut progress)?;
    for (object, error) in spheres.silhouette_errors().filter(|_| made > 0).filter(|(_, e)| *e > SetQuality::UNSUITABLE)
    {
        tell(listener, Event::PoorFit { object: &scene.objects[object].name, error })?;
    }
    Ok(made)
}

/// Builds the sphere sets that the scene's objects need, or finds them among those of earlier runs, and lets the objects refer to
/// their files. If a set cannot be stored, the scene stays the same.
fn fill(scene: &mut Scene, plan: &Plan, folder: &Path, listener: &mut Listener<'_>) -> Result<(), RenderError> {
    let built = |o: &Object| matches!(o.proxy, Proxy::Count(_)) && o.shape.has_triangles();
    let by_proxy = |number: usize| plan.spheres(scene, number) == SphereSource::Proxy;
    let wanted: Vec<usize> = (0..scene.objects.len()).filter(|n| by_proxy(*n) && built(&scene.objects[*n])).collect();
    if wanted.is_empty() {
        return Ok(());
    }
    for number in wanted {
        let object = &mut scene.objects[number];
        let (Proxy::Count(count), Some(mesh)) = (&object.proxy, object.shape.mesh()) else { continue };
        let (mesh, key) = (&*mesh, key(&mesh, *count));
        let path = match find(folder, &key, listener)? {
            Some((path, _)) => path,
            None => {
                let set = build(&object.name, mesh, *count, listener)?;
                // The disk may be full: the set is then built a second time with the blockers.
                let Ok(path) = cache::store(folder, &key, ENDING, set.to_json().as_bytes()) else { return Ok(()) };
                path
            }
        };
        // The set was built for the mesh at its present place.
        object.proxy = Proxy::File { path, placement: Mat4::IDENTITY };
    }
    Ok(())
}

/// The set of an earlier run in a folder, if there is one.
#[must_use]
pub fn known_set(mesh: &Mesh, count: usize, cache: &Path) -> Option<SphereSet> {
    find(cache, &key(mesh, count), &mut |_| ControlFlow::Continue(())).ok()?.map(|(_, set)| set)
}

/// Finds the file of a set, and the set.
fn find(folder: &Path, key: &str, listener: &mut Listener<'_>) -> Result<Option<(PathBuf, SphereSet)>, RenderError> {
    let read = |bytes| SphereSet::from_json(&String::from_utf8(bytes).ok()?).ok();
    cache::find(folder, key, ENDING, read, listener)
}

/// A hash of all inputs of the set: the builder's version, the mesh and the count. The same on every machine.
fn key(mesh: &Mesh, count: usize) -> String {
    let mut hash = Xxh3::new();
    hash.update(&(SphereSet::BUILDER as u64).to_le_bytes());
    hash.update(&(count as u64).to_le_bytes());
    hash.update(&(mesh.positions.len() as u64).to_le_bytes());
    for position in &mesh.positions {
        position.to_array().iter().for_each(|x| hash.update(&x.to_bits().to_le_bytes()));
    }
    mesh.triangles.iter().flatten().for_each(|i| hash.update(&i.to_le_bytes()));
    format!("{:016x}", hash.digest())
}

fn build(object: &str, mesh: &Mesh, spheres: usize, listener: &mut Listener<'_>) -> Result<SphereSet, RenderError> {
    let watch = Stopwatch::start();
    let options = BuildOptions::new(spheres);
    let set = SphereSet::build_with_progress(&mesh.positions, &mesh.triangles, &options, &mut |done| {
        listener(Event::Fitting { object, spheres, done })
    });
    let set = set.map_err(|source| BlockersError::Build { object: object.to_owned(), source })?;
    tell(listener, Event::Fitted { object, spheres, seconds: watch.seconds() })?;
    Ok(set)
}
