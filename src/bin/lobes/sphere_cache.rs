//! Sphere sets of earlier runs: building one takes seconds, and `render` and `reference` of a scene want the same.

use crate::console;
use crate::failure::Failure;
use crate::strategy::Plan;
use cosine_lobes::render_cpu::{BlockersError, SphereSource};
use cosine_lobes::scene::{Mesh, Object, Proxy, Scene, Shape};
use cosine_lobes::visibility_spheres::{BuildOptions, SphereSet};
use cosine_lobes::{ImageFileError, Output};
use std::fs;
use std::io::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

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
        let path = path(&folder, mesh, *count);
        let known = fs::read_to_string(&path).is_ok_and(|text| SphereSet::from_json(&text).is_ok());
        if !known {
            let set = build(&object.name, mesh, *count, quiet)?;
            if store(&path, &set).is_err() {
                // A full disk: the set is built a second time where blockers are made.
                return Ok(());
            }
        }
        object.proxy = Proxy::File(path);
    }
    Ok(())
}

/// The set of an earlier run, if there is one.
pub(crate) fn known(mesh: &Mesh, count: usize) -> Option<SphereSet> {
    SphereSet::from_json(&fs::read_to_string(path(&folder()?, mesh, count)).ok()?).ok()
}

fn path(folder: &Path, mesh: &Mesh, count: usize) -> PathBuf {
    folder.join(format!("{:016x}{:016x}.json", key(mesh, count, 0), key(mesh, count, 1)))
}

/// `$XDG_CACHE_HOME/cosine-lobes`, or the system's equivalent.
fn folder() -> Option<PathBuf> {
    let variable = |name| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let home = || variable("HOME").map(|h| h.join(".cache"));
    let base =
        variable("XDG_CACHE_HOME").filter(|p| p.is_absolute()).or_else(|| variable("LOCALAPPDATA")).or_else(home)?;
    let folder = base.join("cosine-lobes");
    fs::create_dir_all(&folder).ok()?;
    Some(folder)
}

/// FNV-1a of everything that decides the set: the mesh, the count and the program itself, by size and date.
fn key(mesh: &Mesh, count: usize, salt: u64) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325 ^ salt;
    let mut add = |word: u64| {
        for byte in word.to_le_bytes() {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    };
    add(count as u64);
    if let Ok(program) = std::env::current_exe().and_then(fs::metadata) {
        add(program.len());
        let date = program.modified().ok().and_then(|t| t.duration_since(UNIX_EPOCH).ok());
        add(date.map_or(0, |d| d.as_nanos() as u64));
    }
    mesh.positions.iter().flat_map(|p| p.to_array()).for_each(|x| add(u64::from(x.to_bits())));
    mesh.triangles.iter().flatten().for_each(|i| add(u64::from(*i)));
    hash
}

fn build(object: &str, mesh: &Mesh, count: usize, quiet: bool) -> Result<SphereSet, Failure> {
    let bar = console::progress("spheres", 1000, quiet);
    let options = BuildOptions::new(count);
    let set = SphereSet::build_with_progress(&mesh.positions, &mesh.triangles, &options, &mut |done| {
        bar.set_position((done * 1000.0) as u64);
        ControlFlow::Continue(())
    });
    bar.finish_and_clear();
    set.map_err(|source| BlockersError::Build { object: object.to_owned(), source }.into())
}

fn store(path: &Path, set: &SphereSet) -> Result<(), ImageFileError> {
    let failed = |source| ImageFileError::Io { path: path.to_owned(), source };
    Output::create(path)?.finish(|file| file.write_all(set.to_json().as_bytes()).map_err(failed))
}
