//! glTF 2.0: triangle meshes of the shown scene, moved by a clip, with base materials and a camera.

use crate::context::Context;
use crate::gltf_animation::{clip_name, find_clip, key_bytes, play};
use crate::gltf_buffers::{Buffers, data_of, read_uri};
use crate::gltf_extensions::Extensions;
use crate::gltf_light::{PlacedLight, read_light};
use crate::gltf_nodes::{fine_locals, read_camera, shown_nodes, skeleton, transform_notes};
use crate::gltf_reader::Reader;
use crate::gltf_texture::Images;
use crate::part::Part;
use gltf::json::validation::Checked;
use gltf::json::{Root, Value};
use scene::motion::{CameraMover, Skeleton};
use scene::{Camera, SceneError};
use std::path::Path;

/// The contents of a file.
#[derive(Default)]
pub(crate) struct Read {
    pub(crate) parts: Vec<Part>,
    pub(crate) camera: Option<Camera>,
    pub(crate) moving_camera: Option<CameraMover>,
    pub(crate) lights: Vec<PlacedLight>,
}

impl Read {
    /// Whether anything follows the file's nodes.
    fn moves(&self) -> bool {
        self.moving_camera.is_some()
            || self.lights.iter().any(|light| light.mover.is_some())
            || self.parts.iter().any(|part| part.rig.is_some())
    }
}

pub(crate) fn parse(path: &Path, bytes: &[u8], clip: Option<&str>, context: &mut Context) -> Result<Read, SceneError> {
    let is_glb = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("glb"));
    let (json, chunk) = if is_glb || bytes.starts_with(b"glTF") {
        chunks(bytes).map_err(|message| SceneError::file(path, message))?
    } else {
        (bytes, None)
    };
    let json = without_mark(json);
    let root = match gltf::json::deserialize::from_slice::<Root>(json) {
        Ok(root) => root,
        Err(e) => {
            let value: Option<Value> = gltf::json::deserialize::from_slice(json).ok();
            // The fields of another version have other types.
            let version = value.as_ref().and_then(|v| v.pointer("/asset/version")).and_then(|v| v.as_str());
            if let Some(other) = version.filter(|v| !v.starts_with("2.")) {
                return Err(SceneError::file(path, wrong_version(other)));
            }
            // In a binary file a line means nothing.
            let fault = || if is_glb { SceneError::file(path, e.to_string()) } else { json_error(path, &e) };
            value.and_then(|value| completed(path, value, context)).ok_or_else(fault)?
        }
    };
    document(path, &root, json, chunk, clip, context).map_err(|message| SceneError::file(path, message))
}

/// The text without a byte order mark before it, and without zeros behind it, with which some programs pad chunks.
fn without_mark(json: &[u8]) -> &[u8] {
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    let end = json.iter().rposition(|b| *b != 0).map_or(0, |last| last + 1);
    &json[..end]
}

fn wrong_version(version: &str) -> String {
    format!("glTF {version}: only glTF 2.0 is read")
}

/// The document read again where its typed form demands more than the format: channels of animations that aim at no node are left out,
/// and scenes that list no nodes, which programs write for empty ones, list none.
fn completed(path: &Path, mut value: Value, context: &mut Context) -> Option<Root> {
    let (mut pruned, mut added) = (0, 0);
    for animation in list(&mut value, "animations") {
        if let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) {
            let before = channels.len();
            channels.retain(|channel| channel.pointer("/target/node").is_some());
            pruned += before - channels.len();
        }
    }
    for scene in
        list(&mut value, "scenes").filter_map(Value::as_object_mut).filter(|scene| !scene.contains_key("nodes"))
    {
        scene.insert("nodes".to_owned(), Value::Array(Vec::new()));
        added += 1;
    }
    if pruned + added == 0 {
        return None;
    }
    let root = gltf::json::deserialize::from_value(value).ok()?;
    if pruned > 0 {
        context.warn(path, format!("{pruned} animation channels without a node were left out"));
    }
    Some(root)
}

fn list<'v>(value: &'v mut Value, name: &str) -> impl Iterator<Item = &'v mut Value> + use<'v> {
    value.get_mut(name).and_then(Value::as_array_mut).into_iter().flatten()
}

fn json_error(path: &Path, e: &gltf::json::Error) -> SceneError {
    let message = e.to_string();
    let message = message.rsplit_once(" at line ").map_or(&*message, |(head, _)| head).to_owned();
    SceneError::Parse { path: path.to_owned(), line: e.line().max(1), column: e.column(), message }
}

/// The kind of a GLB's binary chunk, "BIN".
const BINARY: u32 = 0x004e_4942;

/// The JSON and binary chunks of a GLB container.
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    let word = |at: usize| -> Result<u32, String> {
        let four = bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).ok_or("file ends early")?;
        Ok(u32::from_le_bytes(four))
    };
    if !bytes.starts_with(b"glTF") {
        return Err("not a GLB file".to_owned());
    }
    let (version, length) = (word(4)?, word(8)? as usize);
    if version != 2 {
        return Err(format!("GLB version {version}: only glTF 2.0 is read"));
    }
    if length > bytes.len() {
        return Err(format!("file ends early: {} bytes of {length}", bytes.len()));
    }
    let chunk = |at: usize, kind: u32, name: &str| -> Result<&[u8], String> {
        let size = word(at)? as usize;
        if word(at + 4)? != kind {
            return Err(format!("expected a {name} chunk at byte {at}"));
        }
        let end = (at + 8).checked_add(size).ok_or("file ends early")?;
        bytes.get(at + 8..end).ok_or_else(|| format!("the {name} chunk of {size} bytes is longer than the file"))
    };
    let fits = |end: usize| match end > length {
        true => Err(format!("the header says that the file has {length} bytes, its chunks end at byte {end}")),
        false => Ok(()),
    };
    let json = chunk(12, 0x4e4f_534a, "JSON")?;
    fits(20 + json.len())?;
    // Chunks begin at multiples of four.
    let next = 20 + json.len().next_multiple_of(4);
    let follows = next + 8 <= length.min(bytes.len()) || word(next + 4) == Ok(BINARY);
    let binary = if follows { Some(chunk(next, BINARY, "BIN")?) } else { None };
    fits(binary.map_or(0, |binary| next + 8 + binary.len()))?;
    Ok((json, binary))
}

fn document(
    path: &Path,
    root: &Root,
    json: &[u8],
    chunk: Option<&[u8]>,
    wanted: Option<&str>,
    context: &mut Context,
) -> Result<Read, String> {
    check_needs(root)?;
    let buffers = Buffers::load(&context.files, path, root, chunk)?;
    // The tree comes first, so that a wrong reference of a node is reported as that node's fault.
    let mut skeleton = animated(path, root, json, &buffers, wanted, context)?;
    skeleton.origin = context.origin;
    skeleton.refine(|| fine_locals(json));
    let extensions = Extensions::read(root, json);
    let shown = shown_nodes(root, &extensions)?;
    let images = Images::new(&context.files, path, root);
    let mut reader = Reader::new(root, buffers, skeleton, extensions, images, &shown);
    let index = context.skeletons.len();
    let (mut read, mut notes, mut cameras) = (Read::default(), Vec::new(), 0);
    for &(n, is_visible) in &shown {
        if let Some(which) = root.nodes[n].camera {
            match read_camera(root, which.value(), &reader.worlds[n])? {
                Some(found) => {
                    cameras += 1;
                    reader.see(found, n, index, &mut read);
                }
                None => context.warn(path, "a camera that is neither perspective nor orthographic was left out"),
            }
        }
        if !is_visible {
            continue;
        }
        if let Some(light) = read_light(root, n, &mut notes)? {
            let mover = reader.moving[n].then_some((index, n));
            read.lights.push(PlacedLight { light, world: reader.worlds[n], mover });
        }
        reader.parts_of(n, index, &mut read.parts, context)?;
    }
    if read.parts.is_empty() && shown.iter().any(|&(n, is_visible)| !is_visible && root.nodes[n].mesh.is_some()) {
        return Err("no triangles: its meshes are in nodes that are not visible".to_owned());
    }
    let cameras = (cameras > 1).then(|| format!("of its {cameras} cameras the first is taken"));
    notes.into_iter().chain(transform_notes(root)).chain(cameras).for_each(|note| reader.note(note));
    reader.tell(path, context);
    keep_document(path, root, json, reader.buffers, context);
    if read.moves() {
        context.skeletons.push(reader.skeleton);
    }
    Ok(read)
}

/// Keeps the file itself and the images beside it, if the document is kept.
fn keep_document(path: &Path, root: &Root, json: &[u8], buffers: Buffers<'_>, context: &mut Context) {
    let Some(document) = &mut context.document else { return };
    let external = |uri: &&String| data_of(uri).is_none();
    let image = |uri: &String| read_uri(&context.files, path, uri).ok();
    document.images = root.images.iter().map(|i| i.uri.as_ref().filter(external).and_then(image)).collect();
    document.json = String::from_utf8_lossy(json).into_owned();
    document.buffers = buffers.into_data();
}

/// Refuses files of other versions, and those that require unknown extensions.
fn check_needs(root: &Root) -> Result<(), String> {
    let asset = &root.asset;
    if !asset.version.starts_with("2.") || asset.min_version.as_deref().is_some_and(|v| v != "2.0") {
        let version = asset.min_version.as_deref().unwrap_or(&asset.version);
        return Err(wrong_version(version));
    }
    Extensions::missing(root)
        .map_or(Ok(()), |name| Err(format!("requires the extension {name}, which is not supported")))
}

/// The nodes with the requested clip, else with the first one that moves anything. A fault in this clip is a fault of the
/// file. Other broken clips are not listed and give a warning.
fn animated(
    path: &Path,
    root: &Root,
    json: &[u8],
    buffers: &Buffers<'_>,
    wanted: Option<&str>,
    context: &mut Context,
) -> Result<Skeleton, String> {
    let rest = skeleton(root)?;
    let mut chosen = wanted.map(|name| find_clip(root, name)).transpose()?;
    let mut shown = None;
    // All are read, one after the other.
    let keys = root.animations.iter().map(|clip| key_bytes(root, clip)).fold(0, u64::saturating_add);
    context.files.budget.take(0, keys, &format!("{} animations", root.animations.len()))?;
    let mut moved = rest.clone();
    for clip in 0..root.animations.len() {
        match play(root, buffers, clip, &mut moved) {
            Err(fault) if chosen.unwrap_or(clip) == clip => return Err(fault + &spelling(json, root, clip)),
            Err(fault) => context.warn(path, format!("a clip is left out: {fault}{}", spelling(json, root, clip))),
            Ok(played) => {
                if chosen == Some(clip) && !played.usable {
                    return Err(format!("animation {clip} moves nothing: expected a channel that can be played"));
                }
                // Warnings about other clips appear when those are played.
                if chosen.unwrap_or(clip) == clip {
                    played.notes.iter().for_each(|note| context.warn(path, note));
                }
                if played.usable {
                    context.clips.push(clip_name(root, clip));
                    if *chosen.get_or_insert(clip) == clip {
                        context.files.budget.take(key_bytes(root, &root.animations[clip]), 0, "its animation")?;
                        shown = Some(moved.clone());
                    }
                } else if root.animations[clip].channels.is_empty() {
                    context.warn(path, format!("animation {clip} has no channels: it is left out"));
                }
            }
        }
        // The nodes of this clip alone are put back: a file may have as many clips as nodes.
        for node in root.animations[clip].channels.iter().map(|channel| channel.target.node.value()) {
            if let (Some(bone), Some(at_rest)) = (moved.bones.get_mut(node), rest.bones.get(node)) {
                bone.clone_from(at_rest);
            }
        }
    }
    Ok(shown.unwrap_or(rest))
}

/// The unknown interpolations of a clip as the file spells them, which the typed document does not keep.
fn spelling(json: &[u8], root: &Root, clip: usize) -> String {
    let samplers = &root.animations[clip].samplers;
    let Some(s) = samplers.iter().position(|s| matches!(s.interpolation, Checked::Invalid)) else {
        return String::new();
    };
    let value: Option<Value> = gltf::json::deserialize::from_slice(json).ok();
    let place = format!("/animations/{clip}/samplers/{s}/interpolation");
    let found = value.as_ref().and_then(|v| v.pointer(&place));
    found.map_or_else(String::new, |found| format!(", found {found} in sampler {s}"))
}
