//! Mesh files of all kinds (`.obj`, `.ply`, `.gltf`, `.glb`) as parts: the ending picks the reader.

use crate::context::{Context, counted};
use crate::files::extension;
use crate::gltf_document::GltfDocument;
use crate::gltf_file::Read;
use crate::normals::turn_strays;
use crate::part::{Part, Repaired};
use crate::{gltf_file, obj, ply};
use glam::DVec3;
use scene::{Bounds, SceneError};
use std::path::Path;

/// The meshes of a file, degenerate triangles taken out; of a glTF with the clip of that name or number. Relative to
/// [`Context::origin`], which is not zero where the file's meshes are far from its origin.
pub(crate) fn mesh_parts(path: &Path, clip: Option<&str>, context: &mut Context) -> Result<Vec<Part>, SceneError> {
    let file = near_parts(path, clip, context, ".obj, .ply, .gltf or .glb")?;
    if !file.lights.is_empty() {
        context.warn(path, "its lights are left out: the scene file has its own");
    }
    Ok(file.parts)
}

pub(crate) fn near_parts(
    path: &Path,
    clip: Option<&str>,
    context: &mut Context,
    endings: &str,
) -> Result<Read, SceneError> {
    let (lines, skeletons, clips) = (context.warnings.len(), context.skeletons.len(), context.clips.len());
    let mark = context.files.budget.mark();
    context.origin = DVec3::ZERO;
    context.collapsed = None;
    context.no_library = None;
    let first = file_parts(path, clip, context, endings);
    context.origin = match (&first, context.collapsed) {
        (Ok(file), _) => {
            let bounds = file.parts.iter().fold(Bounds::EMPTY, |b, part| b.union(part.bounds()));
            crate::origin::near(bounds.center().as_dvec3(), bounds.radius().into())
        }
        (Err(_), Some(place)) => place,
        (Err(_), None) => DVec3::ZERO,
    };
    if context.origin == DVec3::ZERO {
        return first;
    }
    drop(first);
    context.files.budget.back_to(mark);
    context.warnings.truncate(lines);
    context.skeletons.truncate(skeletons);
    context.clips.truncate(clips);
    if let Some(document) = &mut context.document {
        *document = GltfDocument::default();
    }
    file_parts(path, clip, context, endings)
}

/// The contents of a file by the reader for its ending, as they are.
fn read_file(path: &Path, clip: Option<&str>, context: &mut Context, endings: &str) -> Result<Read, SceneError> {
    let extension = extension(path);
    if !["obj", "ply", "gltf", "glb"].contains(&extension.as_str()) {
        context.files.read(path)?;
        return Err(SceneError::file(path, format!("unknown kind of file: expected {endings}")));
    }
    let bytes = context.files.read(path)?;
    if bytes.is_empty() {
        return Err(SceneError::file(path, "file is empty"));
    }
    let is = |magic: &[u8]| bytes.starts_with(magic);
    if clip.is_some() && ["obj", "ply"].contains(&extension.as_str()) {
        return Err(SceneError::file(path, "only glTF files have clips"));
    }
    let meshes = |parts| Read { parts, ..Read::default() };
    match extension.as_str() {
        "obj" if is(b"ply\n") || is(b"ply\r") => {
            Err(SceneError::file(path, "looks like a PLY file: expected the ending .ply"))
        }
        "obj" => Ok(meshes(obj::parse(path, &obj::obj_text(path, bytes)?, context)?)),
        "ply" => Ok(meshes(ply::parse(path, &bytes, context)?)),
        "glb" if is(b"\x89PNG") => Err(SceneError::file(path, "not a GLB file: looks like a PNG image")),
        _ => gltf_file::parse(path, &bytes, clip, context),
    }
}

/// The contents of a file: its indices are checked, triangles without area are left out, and normals agree with faces.
pub(crate) fn file_parts(
    path: &Path,
    clip: Option<&str>,
    context: &mut Context,
    endings: &str,
) -> Result<Read, SceneError> {
    let mut file = read_file(path, clip, context, endings)?;
    let (mut dropped, mut turned, mut mixed) = (0, 0, 0);
    let parts = &mut file.parts;
    for part in parts.iter_mut() {
        let Repaired { dropped: own_dropped, turned: own_turned, mixed: own_mixed } = part.repaired;
        (dropped, turned, mixed) = (dropped + own_dropped, turned + own_turned, mixed + own_mixed);
        if part.instances.is_some() {
            continue;
        }
        // Indices first: the geometry below relies on them.
        if !part.mesh.triangles.is_empty() {
            part.mesh.validate().map_err(|e| SceneError::file(path, format!("{}: {e}", part.name)))?;
        }
        dropped += part.clean();
        if part.rig.is_none() {
            let [own_turned, own_mixed] = turn_strays(&mut part.mesh);
            (turned, mixed) = (turned + own_turned, mixed + own_mixed);
        }
    }
    if turned > 0 {
        context.warn(path, format!("{turned} normals point against all of their faces: they are turned round"));
    }
    if mixed > 0 {
        context.warn(path, format!("{mixed} faces have normals to both sides: their shading changes across them"));
    }
    if dropped > 0 && parts.iter().all(Part::is_empty) {
        // Single precision may not tell corners apart that are far from the origin.
        let place = parts.iter().find_map(|part| part.mesh.positions.first());
        context.collapsed = place.filter(|p| p.is_finite()).map(|p| p.as_dvec3());
    }
    parts.retain(|part| !part.is_empty());
    let mut what = counted(dropped, "triangle", "having no area");
    if parts.is_empty() && dropped > 0 {
        what += " (corners equal or in a line, or nearer to each other than about 1e-18)";
    }
    let cut_away = context.cut_away();
    if !cut_away.is_empty() && !what.is_empty() {
        what += "; ";
    }
    what += &cut_away;
    context.left_out(path, parts.is_empty(), &what)?;
    Ok(file)
}
