//! Sphere sets of earlier runs: building one takes seconds, and `render` and `reference` of a scene want the same.

use crate::console;
use crate::failure::Failure;
use crate::fingerprint::Fingerprint;
use crate::strategy::Plan;
use cosine_lobes::render_cpu::{BlockersError, SphereSource};
use cosine_lobes::scene::{Mesh, Object, Proxy, Scene, Shape};
use cosine_lobes::visibility_spheres::{BuildOptions, SphereSet};
use cosine_lobes::{ImageFileError, Output};
use glam::Mat4;
use std::fs;
use std::io::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Builds the sphere sets that the scene's objects ask for, or finds them among those of earlier runs, and lets the
/// objects refer to their files. Where nothing can be stored the scene is left as it is.
pub(crate) fn fill(scene: &mut Scene, plan: &Plan, quiet: bool) -> Result<(), Failure> {
    let built = |o: &Object| matches!((&o.proxy, &o.shape), (Proxy::Count(_), Shape::Mesh(_)));
    let by_proxy = |number: usize| plan.spheres(scene, number) == SphereSource::Proxy;
    let wanted: Vec<usize> = (0..scene.objects.len()).filter(|n| by_proxy(*n) && built(&scene.objects[*n])).collect();
    if wanted.is_empty() {
        return Ok(());
    }
    let Some(folder) = folder() else { return Ok(()) };
    for number in wanted {
        let object = &mut scene.objects[number];
        let (Proxy::Count(count), Shape::Mesh(mesh)) = (&object.proxy, &object.shape) else { continue };
        let path = folder.join(name(mesh, *count));
        if read(&path).is_none() {
            let set = build(&object.name, mesh, *count, quiet)?;
            if store(&path, &set).is_err() {
                // A full disk: the set is built a second time where blockers are made.
                return Ok(());
            }
        }
        // Made for the mesh as it stands.
        object.proxy = Proxy::File { path, placement: Mat4::IDENTITY };
    }
    Ok(())
}

/// The set of an earlier run, if there is one.
pub(crate) fn known(mesh: &Mesh, count: usize) -> Option<SphereSet> {
    read(&folder()?.join(name(mesh, count)))
}

fn read(path: &Path) -> Option<SphereSet> {
    SphereSet::from_json(&fs::read_to_string(path).ok()?).ok()
}

/// Of all that decides the set: the builder's version, the mesh and the count.
fn name(mesh: &Mesh, count: usize) -> String {
    let positions = mesh.positions.iter().flat_map(|p| p.to_array()).flat_map(|x| x.to_bits().to_le_bytes());
    let triangles = mesh.triangles.iter().flatten().flat_map(|i| i.to_le_bytes());
    let all = Fingerprint::new().debug(&(SphereSet::BUILDER, count));
    let all = all.bytes(&positions.collect::<Vec<u8>>()).bytes(&triangles.collect::<Vec<u8>>());
    format!("{:016x}.json", all.value())
}

/// `$XDG_CACHE_HOME/cosine-lobes`, or the system's equivalent, whether or not it is there.
fn folder() -> Option<PathBuf> {
    let variable = |name| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let home = || variable("HOME").map(|h| h.join(".cache"));
    let base =
        variable("XDG_CACHE_HOME").filter(|p| p.is_absolute()).or_else(|| variable("LOCALAPPDATA")).or_else(home)?;
    Some(base.join("cosine-lobes"))
}

fn build(object: &str, mesh: &Mesh, count: usize, quiet: bool) -> Result<SphereSet, Failure> {
    let progress = console::Fit::new(&format!("object \"{object}\": {}", console::counted(count, "sphere")), quiet);
    let options = BuildOptions::new(count);
    let set = SphereSet::build_with_progress(&mesh.positions, &mesh.triangles, &options, &mut |done| {
        progress.report(done);
        ControlFlow::Continue(())
    });
    let set = set.map_err(|source| BlockersError::Build { object: object.to_owned(), source })?;
    progress.end();
    Ok(set)
}

fn store(path: &Path, set: &SphereSet) -> Result<(), ImageFileError> {
    let failed = |source| ImageFileError::Io { path: path.to_owned(), source };
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(failed)?;
    }
    Output::create(path)?.finish(|file| file.write_all(set.to_json().as_bytes()).map_err(failed))
}
