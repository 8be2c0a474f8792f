//! Meshes of files that several objects of a scene file show: read once, and stored once where that is worth it.

use crate::budget::Budget;
use crate::context::Context;
use crate::gltf_shared::is_worth_sharing;
use crate::mesh_file::mesh_parts;
use crate::part::Part;
use glam::{DVec3, Mat4};
use scene::{Instances, SceneError};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Files by the number of objects that show them, and the parts of those that several show.
#[derive(Default)]
pub(crate) struct KeptMeshes {
    shown: HashMap<PathBuf, usize>,
    read: HashMap<PathBuf, (DVec3, Vec<Part>)>,
}

impl KeptMeshes {
    /// An object shows a file.
    pub(crate) fn count(&mut self, file: PathBuf) {
        *self.shown.entry(file).or_default() += 1;
    }
}

/// The meshes of a file, as [`mesh_parts`] reads them. Where other objects show the file as well, large parts are
/// [instances](Part::instances) at the mesh's own place. Files with motion are read for each object.
pub(crate) fn kept_parts(file: &Path, clip: Option<&str>, context: &mut Context) -> Result<Vec<Part>, SceneError> {
    if let (None, Some((origin, parts))) = (clip, context.kept.read.get(file)) {
        context.origin = *origin;
        parts.iter().try_for_each(|part| take(&context.files.budget, part)).map_err(|e| SceneError::file(file, e))?;
        return Ok(parts.clone());
    }
    let before = (context.skeletons.len(), context.clips.len());
    let mut parts = mesh_parts(file, clip, context)?;
    let copies = context.kept.shown.get(file).copied().unwrap_or_default();
    let moves = before != (context.skeletons.len(), context.clips.len()) || parts.iter().any(|part| part.rig.is_some());
    if clip.is_some() || moves || copies < 2 || context.document.is_some() {
        return Ok(parts);
    }
    for part in &mut parts {
        if part.instances.is_none() && is_worth_sharing(part.mesh.triangles.len(), copies) {
            let mesh = Arc::new(core::mem::take(&mut part.mesh));
            let instances = Instances::of_valid(mesh, vec![Mat4::IDENTITY]);
            part.instances = Some(instances.map_err(|e| SceneError::file(file, e.to_string()))?);
        }
    }
    context.kept.read.insert(file.to_owned(), (context.origin, parts.clone()));
    Ok(parts)
}

/// Takes the memory of one more object of a part.
fn take(budget: &Budget, part: &Part) -> Result<(), String> {
    match &part.instances {
        Some(instances) => budget.take_places(instances.places().len(), &part.name),
        None => budget.take_mesh(&part.mesh, 1, &part.name),
    }
}

#[cfg(test)]
mod tests {
    use crate::load_from;
    use scene::{Animation, Scene, Shape};
    use std::collections::BTreeMap;
    use std::fmt::Write;
    use std::path::PathBuf;
    use std::sync::Arc;

    /// A sheet of `2 n²` triangles.
    fn sheet(n: usize) -> String {
        let mut text = String::new();
        for k in 0..(n + 1) * (n + 1) {
            let [x, z] = [k % (n + 1), k / (n + 1)].map(|i| i as f32 / n as f32);
            writeln!(text, "v {x} {} {z}", 0.1 * (9.0 * x + 5.0 * z).sin()).expect("a text");
        }
        for (i, k) in (0..n).flat_map(|i| (0..n).map(move |k| (i, k))) {
            let a = i * (n + 1) + k + 1;
            let [b, c, d] = [a + 1, a + n + 1, a + n + 2];
            writeln!(text, "f {a} {c} {b}\nf {b} {c} {d}").expect("a text");
        }
        text
    }

    const OBJECTS: [&str; 5] = [
        "",
        "translate = [3, 0.1, 0]\nscale = [1, 2, 0.7]\nrotate = { axis = [1, 2, 3], degrees = 40 }",
        "scale = [-1, 1, 1]",
        "normals = \"smooth\"\ntranslate = [0, 0, 3]",
        "keys = [{ time = 0 }, { time = 1, translate = [0, 1, 0] }]",
    ];

    fn load(objects: &[&str], n: usize) -> (Scene, Animation) {
        let all: String = objects.iter().map(|keys| format!("[[objects]]\nmesh = \"a.obj\"\n{keys}\n")).collect();
        let files: BTreeMap<PathBuf, Vec<u8>> =
            BTreeMap::from([("a.toml".into(), all.into_bytes()), ("a.obj".into(), sheet(n).into_bytes())]);
        let (scene, animation, warnings) = load_from(Arc::new(files), "a.toml", None).expect("a scene");
        assert!(warnings.is_empty(), "{warnings:?}");
        (scene, animation)
    }

    #[test]
    fn a_file_that_objects_show_is_stored_once() {
        let (scene, animation) = load(&OBJECTS, 120);
        let shared = scene.objects.iter().map(|object| match &object.shape {
            Shape::Instances(all) => Some(all.mesh()),
            _ => None,
        });
        let shared: Vec<Option<_>> = shared.collect();
        // An object that moves, or has other normals, has triangles of its own.
        assert_eq!(shared.iter().map(Option::is_some).collect::<Vec<_>>(), [true, true, true, false, false]);
        let first = shared[0].expect("is shared");
        assert!(shared.iter().flatten().all(|mesh| Arc::ptr_eq(mesh, first)));
        assert!(animation.movers[4].is_some() && animation.movers[3].is_none());
        for (object, keys) in scene.objects.iter().zip(OBJECTS) {
            let (alone, _) = load(&[keys], 120);
            let [have, want] = [&object.shape, &alone.objects[0].shape].map(|shape| shape.mesh().expect("triangles"));
            assert_eq!(have, want, "{keys}");
        }
    }

    #[test]
    fn small_meshes_are_copied() {
        let (scene, _) = load(&OBJECTS, 20);
        assert!(scene.objects.iter().all(|object| matches!(object.shape, Shape::Mesh(_))));
        let (alone, _) = load(&OBJECTS[1..2], 20);
        assert_eq!(scene.objects[1].shape, alone.objects[0].shape);
    }
}
