use crate::event::tell;
use crate::{Event, Listener, Plan, RenderError, cache};
use core::ops::ControlFlow;
use glam::Mat4;
use render_cpu::{BlockersError, Revision, SceneSpheres, SphereSource};
use scene::{Animation, Mesh, Object, Proxy, Scene, Shape, Stopwatch};
use sphere_sets::{BuildOptions, SetQuality, SphereSet};
use std::path::{Path, PathBuf};
use xxhash_rust::xxh3::Xxh3;

/// How the names of sets end.
const ENDING: &str = "json";

/// The blocker spheres of those objects that the plan gives some; the scene is at its first moment. Sets are read from the
/// `cache`, and kept there.
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

/// Makes the spheres that there are not yet, of a scene with its objects where they stood at first. How many objects have new ones.
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
    // What takes long was done before, but where nothing could be kept.
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

/// Builds the sphere sets that the scene's objects ask for, or finds them among those of earlier runs, and lets the
/// objects refer to their files. Where nothing can be stored the scene is left as it is.
fn fill(scene: &mut Scene, plan: &Plan, folder: &Path, listener: &mut Listener<'_>) -> Result<(), RenderError> {
    let built = |o: &Object| matches!((&o.proxy, &o.shape), (Proxy::Count(_), Shape::Mesh(_)));
    let by_proxy = |number: usize| plan.spheres(scene, number) == SphereSource::Proxy;
    let wanted: Vec<usize> = (0..scene.objects.len()).filter(|n| by_proxy(*n) && built(&scene.objects[*n])).collect();
    if wanted.is_empty() {
        return Ok(());
    }
    for number in wanted {
        let object = &mut scene.objects[number];
        let (Proxy::Count(count), Shape::Mesh(mesh)) = (&object.proxy, &object.shape) else { continue };
        let key = key(mesh, *count);
        let path = match find(folder, &key, listener)? {
            Some((path, _)) => path,
            None => {
                let set = build(&object.name, mesh, *count, listener)?;
                // A full disk: the set is built a second time where blockers are made.
                let Ok(path) = cache::store(folder, &key, ENDING, set.to_json().as_bytes()) else { return Ok(()) };
                path
            }
        };
        // Made for the mesh as it stands.
        object.proxy = Proxy::File { path, placement: Mat4::IDENTITY };
    }
    Ok(())
}

/// The set of an earlier run that is kept in a folder, if there is one.
#[must_use]
pub fn known_set(mesh: &Mesh, count: usize, cache: &Path) -> Option<SphereSet> {
    find(cache, &key(mesh, count), &mut |_| ControlFlow::Continue(())).ok()?.map(|(_, set)| set)
}

/// The file of a set and the set.
fn find(folder: &Path, key: &str, listener: &mut Listener<'_>) -> Result<Option<(PathBuf, SphereSet)>, RenderError> {
    let read = |bytes| SphereSet::from_json(&String::from_utf8(bytes).ok()?).ok();
    cache::find(folder, key, ENDING, read, listener)
}

/// Of all that decides the set: the builder's version, the mesh and the count. The same on every machine.
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
