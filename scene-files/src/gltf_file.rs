//! glTF 2.0: triangle meshes of the shown scene, moved by a clip, with base materials and a camera.

use crate::context::Context;
use crate::gltf_animation::{clip_name, find_clip, play};
use crate::gltf_buffers::{Buffers, read_uri};
use crate::gltf_document::GltfPart;
use crate::gltf_extensions::Extensions;
use crate::gltf_instances::{expanded, read_instances};
use crate::gltf_light::{PlacedLight, read_light};
use crate::gltf_material::read_material;
use crate::gltf_mesh::{Influences, Shapes, read_influences, read_primitive, read_skin};
use crate::gltf_nodes::{fine_locals, read_camera, shown_nodes, skeleton};
use crate::gltf_shared::{SharedMeshes, Shown};
use crate::gltf_texture::Images;
use crate::look::Look;
use crate::part::Part;
use glam::Mat4;
use gltf::json::Root;
use gltf::json::mesh::Primitive;
use gltf::json::validation::Checked;
use scene::cut_out::CutOut;
use scene::motion::{Body, CameraMover, Carrier, Deformer, Mover, Placement, Skeleton};
use scene::{Camera, MAX_COORDINATE, Mesh, SceneError};
use std::collections::HashMap;
use std::path::Path;

/// The contents of a file.
#[derive(Default)]
pub(crate) struct Read {
    pub(crate) parts: Vec<Part>,
    pub(crate) camera: Option<Camera>,
    pub(crate) moving_camera: Option<CameraMover>,
    pub(crate) lights: Vec<PlacedLight>,
}

pub(crate) fn parse(path: &Path, bytes: &[u8], clip: Option<&str>, context: &mut Context) -> Result<Read, SceneError> {
    let is_glb = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("glb"));
    let (json, chunk) = if is_glb || bytes.starts_with(b"glTF") {
        chunks(bytes).map_err(|message| SceneError::file(path, message))?
    } else {
        (bytes, None)
    };
    let root = match gltf::json::deserialize::from_slice::<Root>(json) {
        Ok(root) => root,
        Err(e) => {
            let value: Option<gltf::json::Value> = gltf::json::deserialize::from_slice(json).ok();
            // The fields of another version have other types.
            let version = value.as_ref().and_then(|v| v.pointer("/asset/version")).and_then(|v| v.as_str());
            if let Some(other) = version.filter(|v| !v.starts_with("2.")) {
                return Err(SceneError::file(path, wrong_version(other)));
            }
            // In a binary file a line means nothing.
            let fault = || if is_glb { SceneError::file(path, e.to_string()) } else { json_error(path, &e) };
            value.and_then(|value| without_aimless_channels(path, value, context)).ok_or_else(fault)?
        }
    };
    document(path, &root, json, chunk, clip, context).map_err(|message| SceneError::file(path, message))
}

fn wrong_version(version: &str) -> String {
    format!("glTF {version}: only glTF 2.0 is read")
}

/// The document read again without those channels of its animations that aim at no node, which is no fault.
fn without_aimless_channels(path: &Path, mut value: gltf::json::Value, context: &mut Context) -> Option<Root> {
    let mut pruned = 0;
    for animation in value.get_mut("animations")?.as_array_mut().into_iter().flatten() {
        if let Some(channels) = animation.get_mut("channels").and_then(|c| c.as_array_mut()) {
            let before = channels.len();
            channels.retain(|channel| channel.pointer("/target/node").is_some());
            pruned += before - channels.len();
        }
    }
    let root = gltf::json::deserialize::from_value(value).ok()?;
    context.warn(path, format!("{pruned} animation channels without a node were left out"));
    Some(root)
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
    let mut reader = Reader {
        root,
        buffers,
        worlds: skeleton.worlds(0.0),
        moving: skeleton.moving(),
        skeleton,
        materials: HashMap::new(),
        uses: uses(root, &shown),
        cut: HashMap::new(),
        shared: SharedMeshes::default(),
        images: Images::new(&context.files, path, root),
        extensions,
        notes: Notes::default(),
    };
    let index = context.skeletons.len();

    let (mut parts, mut camera, mut moving_camera, mut lights) = (Vec::new(), None, None, Vec::new());
    for &(n, is_visible) in &shown {
        if let Some(which) = root.nodes[n].camera {
            match read_camera(root, which.value(), &reader.worlds[n])? {
                Some(found) if camera.is_none() => {
                    let projection = found.projection;
                    moving_camera =
                        reader.moving[n].then_some(CameraMover::Node { skeleton: index, node: n, projection });
                    camera = Some(found);
                }
                Some(_) => {}
                None => context.warn(path, "a camera that is neither perspective nor orthographic was left out"),
            }
        }
        if !is_visible {
            continue;
        }
        if let Some(light) = read_light(root, n)? {
            let mover = reader.moving[n].then_some((index, n));
            lights.push(PlacedLight { light, world: reader.worlds[n], mover });
        }
        reader.parts_of(n, index, &mut parts, context)?;
    }
    if parts.is_empty() && shown.iter().any(|&(n, is_visible)| !is_visible && root.nodes[n].mesh.is_some()) {
        return Err("no triangles: its meshes are in nodes that are not visible".to_owned());
    }
    reader.tell(path, context);
    if let Some(document) = &mut context.document {
        let external = |uri: &&String| !uri.starts_with("data:");
        let image = |uri: &String| read_uri(&context.files, path, uri).ok();
        document.images = root.images.iter().map(|i| i.uri.as_ref().filter(external).and_then(image)).collect();
        document.json = String::from_utf8_lossy(json).into_owned();
        document.buffers = reader.buffers.into_data();
    }
    let moves_light = lights.iter().any(|light| light.mover.is_some());
    if moving_camera.is_some() || moves_light || parts.iter().any(|p: &Part| p.rig.is_some()) {
        context.skeletons.push(reader.skeleton);
    }
    Ok(Read { parts, camera, moving_camera, lights })
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
    for clip in 0..root.animations.len() {
        let mut moved = rest.clone();
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
                        shown = Some(moved);
                    }
                } else if root.animations[clip].channels.is_empty() {
                    context.warn(path, format!("animation {clip} has no channels: it is left out"));
                }
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
    let value: Option<gltf::json::Value> = gltf::json::deserialize::from_slice(json).ok();
    let place = format!("/animations/{clip}/samplers/{s}/interpolation");
    let found = value.as_ref().and_then(|v| v.pointer(&place));
    found.map_or_else(String::new, |found| format!(", found {found} in sampler {s}"))
}

/// For each mesh how many of some nodes show it.
fn uses(root: &Root, shown: &[(usize, bool)]) -> Vec<usize> {
    let mut uses = vec![0; root.meshes.len()];
    for mesh in shown.iter().filter(|(_, is_visible)| *is_visible).filter_map(|(n, _)| root.nodes[*n].mesh) {
        if let Some(count) = uses.get_mut(mesh.value()) {
            *count += 1;
        }
    }
    uses
}

/// Counts for the warnings that appear once a file.
#[derive(Default)]
struct Notes {
    skipped: usize,
    reduced: usize,
    uneven: usize,
    broken: usize,
}

struct Reader<'a> {
    root: &'a Root,
    buffers: Buffers<'a>,
    skeleton: Skeleton,
    /// Of all nodes at the first moment.
    worlds: Vec<Mat4>,
    /// For each node whether the clip moves it.
    moving: Vec<bool>,
    /// The materials that were used so far.
    materials: HashMap<usize, Look>,
    /// For each mesh how many nodes show it.
    uses: Vec<usize>,
    /// Primitives, by mesh and number, that are cut out for all nodes.
    cut: HashMap<(usize, usize), Shapes>,
    /// Primitives that are stored once for all nodes.
    shared: SharedMeshes,
    images: Images<'a>,
    extensions: Extensions,
    notes: Notes,
}

impl Reader<'_> {
    /// Tells what was left out or changed.
    fn tell(&self, path: &Path, context: &mut Context) {
        let Notes { skipped, reduced, uneven, broken } = self.notes;
        context.tell_broken(path, broken + self.shared.broken);
        if skipped > 0 {
            context.warn(path, format!("{skipped} primitives that are points or lines were left out"));
        }
        if reduced > 0 {
            context.warn(path, format!("{reduced} vertices have more than 4 joints: those that count most are kept"));
        }
        if uneven > 0 {
            context.warn(path, format!("joint weights of {uneven} vertices do not add up to 1: they are made to"));
        }
        self.images.notes.iter().for_each(|note| context.warn(path, note));
        self.extensions.tell(path, context);
    }

    /// Appends the meshes of a node, as they are at the first moment.
    fn parts_of(
        &mut self,
        n: usize,
        skeleton: usize,
        parts: &mut Vec<Part>,
        context: &mut Context,
    ) -> Result<(), String> {
        let node = &self.root.nodes[n];
        let Some(index) = node.mesh else { return Ok(()) };
        let m = index.value();
        let mesh = self.root.meshes.get(m).ok_or_else(|| format!("node {n}: there is no mesh {m}"))?;
        let skin = node.skin.map(|skin| read_skin(self.root, &self.buffers, skin.value())).transpose()?;
        let attributes = self.extensions.instances(n);
        let instances = attributes.map(|attributes| read_instances(&self.buffers, attributes)).transpose();
        let instances = instances.map_err(|e| format!("node {n}: {e}"))?;
        if skin.is_some() && instances.is_some() {
            self.images.note("instances of a mesh with a skin are one: the skin places it".to_owned());
        }
        let name = node.name.clone().or_else(|| mesh.name.clone()).unwrap_or_else(|| format!("node {n}"));
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let fault = |e: String| format!("mesh {m}, primitive {p}: {e}");
            let material = self.material(primitive).map_err(fault)?;
            let name = if mesh.primitives.len() == 1 { name.clone() } else { format!("{name} {p}") };
            let cut_out = material.as_ref().and_then(|(_, look)| look.cut_out.as_ref());
            let copies = instances.as_deref().filter(|_| skin.is_none());
            let places = self.places(n, skin.is_none(), copies);
            if let Some(places) = places {
                let all = self.uses[m].max(places.len());
                let (path, material) = (self.images.path(), material.as_ref());
                let shown = Shown { path, name: &name, mesh: m, primitive: p, copies: all, places, material };
                if let Some(part) = self.shared.part(self.root, &self.buffers, shown, context).map_err(fault)? {
                    parts.push(part);
                    continue;
                }
            }
            // A document that is kept keeps the whole of it.
            let early = cut_out.filter(|_| context.document.is_none());
            let Some((shapes, is_cut)) = self.shapes([n, m, p], &name, early, copies, context).map_err(fault)? else {
                self.notes.skipped += 1;
                continue;
            };
            let vertices = shapes.mesh.positions.len();
            let influences = match &skin {
                Some(skin) => read_influences(&self.buffers, primitive, vertices, skin.len()).map_err(fault)?,
                None => None,
            };
            let joints = skin.as_deref().filter(|_| influences.is_some());
            let alphas = shapes.alphas.clone();
            let turn = shapes.mesh.triangles.iter().copied().enumerate().find(|(_, [_, b, c])| b != c);
            let (mut mesh, rig) = self.pose(n, skeleton, shapes, joints, influences).map_err(fault)?;
            let copies = copies.map_or(1, <[Mat4]>::len);
            let (node, name, moves) = (n, name, rig.is_some());
            let is_turned = turn.is_some_and(|(i, t)| mesh.triangles[i] != t);
            let is_kept = context.document.is_some();
            let part = GltfPart {
                node,
                mesh: m,
                primitive: p,
                name: name.clone(),
                copies,
                moves,
                mover: rig.as_ref().filter(|_| is_kept).map(|(deformer, carrier)| {
                    let body = Body::Mesh(Box::new(deformer.clone()), Some(carrier.clone()));
                    Box::new(Mover { placement: Placement::Fixed(Mat4::IDENTITY), body, proxy: Vec::new() })
                }),
                is_turned,
                ..GltfPart::default()
            };
            let source = context.keep(part, &mesh)?;
            if let Some(cut_out) = cut_out.filter(|_| !is_cut) {
                context.cut_out(self.images.path(), &name, cut_out, (&mut mesh, &alphas), rig.is_some());
            }
            let is_bare = mesh.normals.is_empty();
            parts.push(Part { rig, is_bare, source, ..Part::fixed(name, mesh, material) });
        }
        Ok(())
    }

    /// The places of a node's mesh, or of its instances, if these stand still and keep their shape.
    fn places(&self, n: usize, is_rigid: bool, instances: Option<&[Mat4]>) -> Option<Vec<Mat4>> {
        let is_still = is_rigid && !self.moving[n] && self.skeleton.bones[n].rest_weights.is_empty();
        let world = &self.worlds[n];
        is_still.then(|| instances.map_or_else(|| vec![*world], |all| all.iter().map(|i| *world * *i).collect()))
    }

    /// The material of a primitive and its number, read once.
    fn material(&mut self, primitive: &Primitive) -> Result<Option<(usize, Look)>, String> {
        let Some(index) = primitive.material else { return Ok(None) };
        let index = index.value();
        let known = match self.materials.get(&index) {
            Some(known) => known.clone(),
            None => {
                read_material(self.root, index, self.extensions.of_material(index), &self.buffers, &mut self.images)?
            }
        };
        self.materials.insert(index, known.clone());
        Ok(Some((index, known)))
    }

    /// The shapes of a node's mesh's primitive, at the node's instances if it has some, and whether they are cut out already: those that
    /// several nodes or instances show and none moves are cut once.
    fn shapes(
        &mut self,
        [n, m, p]: [usize; 3],
        name: &str,
        cut_out: Option<&CutOut>,
        instances: Option<&[Mat4]>,
        context: &mut Context,
    ) -> Result<Option<(Shapes, bool)>, String> {
        let bone = &self.skeleton.bones[n];
        let is_still = self.root.nodes[n].skin.is_none()
            && !self.moving[n]
            && bone.weights.is_none()
            && bone.rest_weights.iter().all(|weight| *weight == 0.0);
        let is_shared = self.uses[m] > 1 || instances.is_some();
        let cut_out = cut_out.filter(|_| is_still && is_shared);
        let known = self.cut.get(&(m, p)).filter(|_| cut_out.is_some()).cloned();
        let is_new = known.is_none();
        let read = || read_primitive(&self.buffers, &self.root.meshes[m].primitives[p]);
        let Some(mut shapes) = known.map_or_else(read, |known| Ok(Some(known)))? else { return Ok(None) };
        if let Some(cut_out) = cut_out.filter(|_| is_new) {
            let alphas = core::mem::take(&mut shapes.alphas);
            context.cut_out(self.images.path(), name, cut_out, (&mut shapes.mesh, &alphas), false);
            self.cut.insert((m, p), shapes.clone());
        }
        context.files.budget.take_mesh(&shapes.mesh, instances.map_or(1, <[Mat4]>::len), name)?;
        if let Some(instances) = instances {
            shapes = expanded(&shapes, instances);
        }
        Ok(Some((shapes, cut_out.is_some())))
    }

    /// A primitive at the first moment, and its motion if it moves.
    fn pose(
        &mut self,
        n: usize,
        skeleton: usize,
        shapes: Shapes,
        joints: Option<&[(usize, Mat4)]>,
        influences: Option<Influences>,
    ) -> Result<(Mesh, Option<(Deformer, Carrier)>), String> {
        let bone = &self.skeleton.bones[n];
        let Shapes { mut mesh, targets, normal_targets, broken, .. } = shapes;
        self.notes.broken += broken;
        if targets.len() != bone.rest_weights.len() {
            let (k, first) = (targets.len(), bone.rest_weights.len());
            return Err(format!("{k} morph targets, the first primitive has {first}"));
        }
        let morphing = bone.weights.as_ref().is_some_and(|w| !w.is_constant());
        let morphed = morphing || bone.weights.is_some() || bone.rest_weights.iter().any(|&w| w != 0.0);
        if influences.is_none() && !morphed && !self.moving[n] {
            mesh.transform(&self.worlds[n]);
            return Ok((mesh, None));
        }
        let mut deformer = Deformer::rigid(&mesh);
        let mut carrier = Carrier { skeleton, joints: vec![(Some(n), Mat4::IDENTITY)], morph: morphed.then_some(n) };
        if morphed {
            (deformer.targets, deformer.normal_targets) = (targets, normal_targets);
        }
        let mut moves = morphing || self.moving[n];
        if let (Some(joints), Some(influences)) = (joints, influences) {
            carrier.joints = joints.iter().map(|&(node, bind)| (Some(node), bind)).collect();
            if influences.unbound {
                let here = Mat4::from_translation((-self.skeleton.origin).as_vec3());
                carrier.joints.push((None, here));
            }
            moves = morphing || joints.iter().any(|&(node, _)| self.moving[node]);
            self.notes.reduced += influences.reduced;
            self.notes.uneven += influences.uneven;
            (deformer.joints, deformer.weights) = (influences.joints, influences.weights);
        }
        let now: Vec<Mat4> = carrier.joints(&self.worlds).collect();
        if now.iter().any(|m| !m.to_cols_array().iter().all(|v| v.abs() <= MAX_COORDINATE)) {
            return Err("the matrix of a joint leaves ±1e9".to_owned());
        }
        let mut morph = Vec::new();
        if morphed {
            self.skeleton.morph_weights(n, 0.0, &mut morph);
        }
        if deformer.mirrors(&now) {
            mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        deformer.pose(&now, &morph, &mut mesh);
        Ok((mesh, moves.then_some((deformer, carrier))))
    }
}
