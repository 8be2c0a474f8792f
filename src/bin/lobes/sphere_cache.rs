//! Sphere sets of earlier runs: building one takes seconds, and `render` and `reference` of a scene want the same.

use crate::console;
use crate::failure::Failure;
use crate::fingerprint::Fingerprint;
use crate::strategy::Plan;
use cosine_lobes::render_cpu::{BlockersError, SphereSource};
use cosine_lobes::scene::{Mesh, Object, Proxy, Scene, Shape};
use cosine_lobes::sphere_sets::{BuildOptions, SphereSet};
use cosine_lobes::{ImageFileError, Output, checksum};
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
        let key = key(mesh, *count);
        let path = match find(&folder, &key, quiet) {
            Some((path, _)) => path,
            None => {
                let set = build(&object.name, mesh, *count, quiet)?;
                // A full disk: the set is built a second time where blockers are made.
                let Ok(path) = store(&folder, &key, &set) else { return Ok(()) };
                path
            }
        };
        // Made for the mesh as it stands.
        object.proxy = Proxy::File { path, placement: Mat4::IDENTITY };
    }
    Ok(())
}

/// The set of an earlier run, if there is one.
pub(crate) fn known(mesh: &Mesh, count: usize) -> Option<SphereSet> {
    find(&folder()?, &key(mesh, count), true).map(|(_, set)| set)
}

/// The file of a set and the set. One whose content is not what its name says is told of, unless `quiet`, and removed.
fn find(folder: &Path, key: &str, quiet: bool) -> Option<(PathBuf, SphereSet)> {
    let begin = format!("{key}.");
    for entry in fs::read_dir(folder).ok()?.flatten() {
        let name = entry.file_name();
        let Some(sum) = name.to_str().and_then(|n| n.strip_prefix(&begin)?.strip_suffix(".json")) else { continue };
        let path = entry.path();
        let Ok(bytes) = fs::read(&path) else { continue };
        let text = (checksum(&bytes) == sum).then_some(bytes).and_then(|bytes| String::from_utf8(bytes).ok());
        match text.and_then(|text| SphereSet::from_json(&text).ok()) {
            Some(set) => return Some((path, set)),
            None => {
                if !quiet {
                    console::note(format_args!("lobes: warning: {}: damaged; made anew", path.display()));
                }
                let _ = fs::remove_file(path);
            }
        }
    }
    None
}

/// Of all that decides the set: the builder's version, the mesh and the count.
fn key(mesh: &Mesh, count: usize) -> String {
    let positions = mesh.positions.iter().flat_map(|p| p.to_array()).flat_map(|x| x.to_bits().to_le_bytes());
    let triangles = mesh.triangles.iter().flatten().flat_map(|i| i.to_le_bytes());
    let all = Fingerprint::new().debug(&(SphereSet::BUILDER, count));
    let all = all.bytes(&positions.collect::<Vec<u8>>()).bytes(&triangles.collect::<Vec<u8>>());
    format!("{:016x}", all.value())
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

/// Writes a set under a name that has its checksum.
fn store(folder: &Path, key: &str, set: &SphereSet) -> Result<PathBuf, ImageFileError> {
    let text = set.to_json();
    let path = folder.join(format!("{key}.{}.json", checksum(text.as_bytes())));
    let failed = |source| ImageFileError::Io { path: path.clone(), source };
    fs::create_dir_all(folder).map_err(failed)?;
    Output::create(&path)?.finish(|file| file.write_all(text.as_bytes()).map_err(failed))?;
    Ok(path)
}
