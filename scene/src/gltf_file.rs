//! glTF 2.0: triangle meshes of the shown scene in their rest pose, base materials, perspective camera.

use crate::animation::CameraMover;
use crate::gltf_buffers::Buffers;
use crate::load::{Context, Part};
use crate::{Camera, Mesh, SceneError};
use brdf::{Material, ModifiedPhong};
use glam::{Mat4, Quat, Vec3};
use gltf::json::accessor::Type;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Index, Node, Root};
use std::path::Path;

/// Extensions that may be required: their data is either read or only changes how a surface looks.
const KNOWN_EXTENSIONS: [&str; 6] = [
    "KHR_mesh_quantization",
    "KHR_texture_transform",
    "KHR_materials_unlit",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_lights_punctual",
];

/// The meshes of a file, its camera, and what moves that.
type Read = (Vec<Part>, Option<Camera>, Option<CameraMover>);

pub(crate) fn parse(path: &Path, bytes: &[u8], clip: Option<&str>, context: &mut Context) -> Result<Read, SceneError> {
    let is_glb = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("glb"));
    let (json, chunk) = if is_glb || bytes.starts_with(b"glTF") {
        chunks(bytes).map_err(|message| SceneError::file(path, message))?
    } else {
        (bytes, None)
    };
    let root = match gltf::json::deserialize::from_slice::<Root>(json) {
        Ok(root) => root,
        Err(e) => without_animations(json).ok_or_else(|| {
            // In a binary file a line means nothing.
            if is_glb { SceneError::file(path, e.to_string()) } else { json_error(path, &e) }
        })?,
    };
    document(path, &root, chunk, context).map_err(|message| SceneError::file(path, message))
}

/// The document read again without its animations: nothing here uses them, so a fault in them is none.
fn without_animations(json: &[u8]) -> Option<Root> {
    let mut value: gltf::json::Value = gltf::json::deserialize::from_slice(json).ok()?;
    value.as_object_mut()?.remove("animations")?;
    gltf::json::deserialize::from_value(value).ok()
}

fn json_error(path: &Path, e: &gltf::json::Error) -> SceneError {
    let message = e.to_string();
    let message = message.rsplit_once(" at line ").map_or(&*message, |(head, _)| head).to_owned();
    SceneError::Parse { path: path.to_owned(), line: e.line().max(1), column: e.column(), message }
}

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
    let json = chunk(12, 0x4e4f_534a, "JSON")?;
    // Chunks begin at multiples of four.
    let next = 20 + json.len().next_multiple_of(4);
    let binary = if next + 8 <= length.min(bytes.len()) { Some(chunk(next, 0x004e_4942, "BIN")?) } else { None };
    Ok((json, binary))
}

fn document(path: &Path, root: &Root, chunk: Option<&[u8]>, context: &mut Context) -> Result<Read, String> {
    let asset = &root.asset;
    if !asset.version.starts_with("2.") || asset.min_version.as_deref().is_some_and(|v| v != "2.0") {
        let version = asset.min_version.as_deref().unwrap_or(&asset.version);
        return Err(format!("glTF {version}: only glTF 2.0 is read"));
    }
    if let Some(name) = root.extensions_required.iter().find(|e| !KNOWN_EXTENSIONS.contains(&e.as_str())) {
        return Err(format!("requires the extension {name}, which is not supported"));
    }
    let buffers = Buffers::load(path, root, chunk)?;
    let worlds = world_matrices(root)?;
    let shown = shown_nodes(root)?;

    let (mut parts, mut camera, mut skipped) = (Vec::new(), None, 0);
    for &n in &shown {
        let node = &root.nodes[n];
        if let Some(index) = node.camera {
            let read = read_camera(root, index.value(), &worlds[n])?;
            match read {
                Some(found) => camera = camera.or(Some(found)),
                None => context.warn(path, "orthographic cameras are not supported"),
            }
        }
        let Some(index) = node.mesh else { continue };
        let m = index.value();
        let mesh = root.meshes.get(m).ok_or_else(|| format!("node {n}: there is no mesh {m}"))?;
        let pose = match node.skin {
            Some(skin) => Some(joint_matrices(root, &buffers, skin.value(), &worlds)?),
            None => None,
        };
        let name = node.name.clone().or_else(|| mesh.name.clone()).unwrap_or_else(|| format!("node {n}"));
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let fault = |e: String| format!("mesh {m}, primitive {p}: {e}");
            let Some(mut triangles) = read_primitive(&buffers, primitive).map_err(fault)? else {
                skipped += 1;
                continue;
            };
            let skinned = match &pose {
                Some(pose) => skin(&buffers, primitive, pose, &mut triangles).map_err(fault)?,
                None => false,
            };
            if !skinned {
                triangles.transform(&worlds[n]);
            }
            let material = match primitive.material {
                None => None,
                Some(index) => Some((index.value(), read_material(root, index.value())?)),
            };
            let name = if mesh.primitives.len() == 1 { name.clone() } else { format!("{name} {p}") };
            parts.push(Part::fixed(name, triangles, material));
        }
    }
    if skipped > 0 {
        context.warn(path, format!("{skipped} primitives that are points or lines were left out"));
    }
    if !root.textures.is_empty() {
        context.warn(path, "textures are not read: materials have their base factors");
    }
    if !root.animations.is_empty() {
        context.warn(path, "animations are not read: the rest pose is shown");
    }
    if root.materials.iter().any(|m| m.emissive_factor.0 != [0.0; 3]) {
        context.warn(path, "emissive materials are not lights yet");
    }
    if root.extensions_used.iter().any(|e| e == "KHR_lights_punctual") {
        context.warn(path, "punctual lights are not read: a default light is used");
    }
    Ok((parts, camera, None))
}

/// World matrices of all nodes.
fn world_matrices(root: &Root) -> Result<Vec<Mat4>, String> {
    let n = root.nodes.len();
    let mut has_parent = vec![false; n];
    for (i, node) in root.nodes.iter().enumerate() {
        for child in node.children.iter().flatten().map(Index::value) {
            let slot = has_parent.get_mut(child).ok_or_else(|| format!("node {i}: there is no node {child}"))?;
            if std::mem::replace(slot, true) {
                return Err(format!("node {child} has two parents: nodes must form a tree"));
            }
        }
    }
    let mut worlds = vec![Mat4::NAN; n];
    let mut open: Vec<(usize, Mat4)> = (0..n).filter(|&i| !has_parent[i]).map(|i| (i, Mat4::IDENTITY)).collect();
    let mut reached = 0;
    while let Some((i, parent)) = open.pop() {
        let world = parent * local_matrix(&root.nodes[i]);
        if !world.is_finite() {
            return Err(format!("node {i}: the transform is not finite in single precision"));
        }
        worlds[i] = world;
        reached += 1;
        open.extend(root.nodes[i].children.iter().flatten().map(|c| (c.value(), world)));
    }
    // With at most one parent each, what no root reaches hangs on a cycle.
    if reached < n {
        let lost = worlds.iter().position(|w| w.is_nan()).unwrap_or(0);
        return Err(format!("node cycle at node {lost}"));
    }
    Ok(worlds)
}

fn local_matrix(node: &Node) -> Mat4 {
    if let Some(m) = &node.matrix {
        let mut m = Mat4::from_cols_array(m);
        // Affine: the last row is (0, 0, 0, 1).
        (m.x_axis.w, m.y_axis.w, m.z_axis.w, m.w_axis.w) = (0.0, 0.0, 0.0, 1.0);
        return m;
    }
    let q = Quat::from_array(node.rotation.map_or([0.0, 0.0, 0.0, 1.0], |r| r.0));
    let rotation = if q.length() > 1e-10 { q.normalize() } else { Quat::IDENTITY };
    let scale = Vec3::from_array(node.scale.unwrap_or([1.0; 3]));
    Mat4::from_scale_rotation_translation(scale, rotation, Vec3::from_array(node.translation.unwrap_or([0.0; 3])))
}

/// Nodes of the default scene, of the first one where none is named, or all where there is no scene; in document order.
fn shown_nodes(root: &Root) -> Result<Vec<usize>, String> {
    let scene = match root.scene {
        Some(index) => {
            let i = index.value();
            Some(root.scenes.get(i).ok_or_else(|| format!("there is no scene {i}"))?)
        }
        None => root.scenes.first(),
    };
    let Some(scene) = scene else { return Ok((0..root.nodes.len()).collect()) };
    let mut shown = vec![false; root.nodes.len()];
    let mut open: Vec<usize> = scene.nodes.iter().map(Index::value).collect();
    while let Some(i) = open.pop() {
        let slot = shown.get_mut(i).ok_or_else(|| format!("the scene names node {i}, which does not exist"))?;
        if !std::mem::replace(slot, true) {
            open.extend(root.nodes[i].children.iter().flatten().map(Index::value));
        }
    }
    Ok((0..shown.len()).filter(|&i| shown[i]).collect())
}

/// The triangles of a primitive; none for points, lines and primitives without positions.
fn read_primitive(buffers: &Buffers<'_>, primitive: &Primitive) -> Result<Option<Mesh>, String> {
    let Checked::Valid(mode) = primitive.mode else { return Err("unknown mode".to_owned()) };
    let attribute = |s| primitive.attributes.get(&Checked::Valid(s)).copied();
    let Some(positions) = attribute(Semantic::Positions) else { return Ok(None) };
    if matches!(mode, Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
        return Ok(None);
    }
    let vectors = |v: Vec<f32>| v.chunks_exact(3).map(Vec3::from_slice).collect::<Vec<_>>();
    let positions = vectors(buffers.floats(positions, Type::Vec3)?);
    let vertices = positions.len();
    let normals = match attribute(Semantic::Normals) {
        Some(index) => vectors(buffers.floats(index, Type::Vec3)?),
        None => Vec::new(),
    };
    if !normals.is_empty() && normals.len() != vertices {
        return Err(format!("{} normals for {vertices} positions", normals.len()));
    }
    for target in primitive.targets.iter().flatten() {
        if let Some(moved) = target.positions {
            let moved = buffers.floats(moved, Type::Vec3)?.len() / 3;
            if moved != vertices {
                return Err(format!("morph target of {moved} positions for {vertices}"));
            }
        }
    }
    let indices = match primitive.indices {
        Some(index) => buffers.integers(index, Type::Scalar)?,
        None => (0..vertices as u32).collect(),
    };
    if let Some(i) = indices.iter().find(|&&i| i as usize >= vertices) {
        return Err(format!("uses vertex {i} of {vertices}"));
    }
    let triangles = match mode {
        Mode::TriangleStrip => indices
            .windows(3)
            .enumerate()
            .map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] })
            .collect(),
        Mode::TriangleFan => indices.get(1..).unwrap_or(&[]).windows(2).map(|w| [indices[0], w[0], w[1]]).collect(),
        _ => indices.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
    };
    let mut mesh = Mesh { positions, normals, triangles };
    if let Some(bad) = mesh.positions.iter().position(|p| !p.is_finite()) {
        return Err(format!("position {bad} is not finite"));
    }
    if !mesh.normals.is_empty() {
        mesh.repair_normals();
    }
    Ok(Some(mesh))
}

/// Joint world matrices times inverse bind matrices, in the rest pose.
fn joint_matrices(root: &Root, buffers: &Buffers<'_>, skin: usize, worlds: &[Mat4]) -> Result<Vec<Mat4>, String> {
    let fault = |e: String| format!("skin {skin}: {e}");
    let data = root.skins.get(skin).ok_or_else(|| format!("there is no skin {skin}"))?;
    if data.joints.is_empty() {
        return Err(fault("has no joints".to_owned()));
    }
    let inverse = match data.inverse_bind_matrices {
        None => vec![Mat4::IDENTITY; data.joints.len()],
        Some(index) => {
            let values = buffers.floats(index, Type::Mat4).map_err(fault)?;
            values.chunks_exact(16).map(Mat4::from_cols_slice).collect()
        }
    };
    if inverse.len() < data.joints.len() {
        return Err(fault(format!("{} inverse bind matrices for {} joints", inverse.len(), data.joints.len())));
    }
    let pose = |(joint, inverse): (&Index<Node>, Mat4)| {
        let j = joint.value();
        let world = *worlds.get(j).ok_or_else(|| fault(format!("there is no node {j}")))?;
        let matrix = world * inverse;
        if matrix.is_finite() { Ok(matrix) } else { Err(fault(format!("the matrix of joint {j} is not finite"))) }
    };
    data.joints.iter().zip(inverse).map(pose).collect()
}

/// Poses a mesh by its joints; tells whether it has weights at all. Vertices without usable weights stay where they are.
fn skin(buffers: &Buffers<'_>, primitive: &Primitive, pose: &[Mat4], mesh: &mut Mesh) -> Result<bool, String> {
    let attribute = |s| primitive.attributes.get(&Checked::Valid(s)).copied();
    let n = mesh.positions.len();
    let mut blended = vec![Mat4::ZERO; n];
    let mut sums = vec![0.0_f32; n];
    let mut any = false;
    for set in 0.. {
        let pair = (attribute(Semantic::Joints(set)), attribute(Semantic::Weights(set)));
        let (Some(joints), Some(weights)) = pair else { break };
        let (joints, weights) = (buffers.integers(joints, Type::Vec4)?, buffers.floats(weights, Type::Vec4)?);
        if joints.len() != 4 * n || weights.len() != 4 * n {
            return Err(format!("{} joints and {} weights for {n} positions", joints.len() / 4, weights.len() / 4));
        }
        any = true;
        for (i, (&joint, &weight)) in joints.iter().zip(&weights).enumerate() {
            if !weight.is_finite() || weight < 0.0 {
                return Err(format!("vertex {} has the joint weight {weight}", i / 4));
            }
            if weight > 0.0 {
                let matrix = pose.get(joint as usize);
                let matrix = matrix.ok_or_else(|| format!("vertex {} uses joint {joint} of {}", i / 4, pose.len()))?;
                blended[i / 4] += *matrix * weight;
                sums[i / 4] += weight;
            }
        }
    }
    if !any {
        return Ok(false);
    }
    for i in 0..n {
        if sums[i] <= 0.0 {
            continue;
        }
        let matrix = blended[i] * (1.0 / sums[i]);
        mesh.positions[i] = matrix.transform_point3(mesh.positions[i]);
        if let Some(normal) = mesh.normals.get_mut(i) {
            // Joints turn and scale evenly in all but odd cases: no inverse transpose a vertex.
            *normal = matrix.transform_vector3(*normal);
        }
    }
    mesh.repair_normals();
    Ok(true)
}

/// Base colour, metalness and roughness as a diffuse and a modified Phong term: an approximation. Schlick's normal
/// reflectance `F0 = lerp(0.04, base, metallic)` goes into the highlight, whose exponent has the curvature that a
/// Beckmann half-vector lobe of width `roughness²` has about the mirror direction: `e = (2/α² − 2)/4`.
fn read_material(root: &Root, index: usize) -> Result<Material, String> {
    let material = root.materials.get(index).ok_or_else(|| format!("there is no material {index}"))?;
    if matches!(material.alpha_mode, Checked::Invalid) {
        return Err(format!("material {index}: unknown alphaMode"));
    }
    let pbr = &material.pbr_metallic_roughness;
    let [r, g, b, _] = pbr.base_color_factor.0;
    let unit = |x: f32| if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) };
    let base = Vec3::new(unit(r), unit(g), unit(b));
    let (metallic, roughness) = (unit(pbr.metallic_factor.0), unit(pbr.roughness_factor.0));
    let f0 = Vec3::splat(0.04).lerp(base, metallic);
    let alpha = (roughness * roughness).max(1e-3);
    let exponent = (0.5 / (alpha * alpha) - 0.5).max(0.0);
    Ok(ModifiedPhong { kd: base * (1.0 - metallic) * (1.0 - f0), ks: f0, exponent }.into())
}

fn read_camera(root: &Root, index: usize, world: &Mat4) -> Result<Option<Camera>, String> {
    let camera = root.cameras.get(index).ok_or_else(|| format!("there is no camera {index}"))?;
    let Some(p) = &camera.perspective else { return Ok(None) };
    let planes_fit = p.znear > 0.0 && p.zfar.is_none_or(|far| far > p.znear);
    if !planes_fit || p.aspect_ratio.is_some_and(|a| a.is_nan() || a <= 0.0) {
        return Err(format!("camera {index}: planes and aspect ratio must be positive, and far beyond near"));
    }
    let eye = world.transform_point3(Vec3::ZERO);
    let forward = world.transform_vector3(Vec3::NEG_Z).normalize_or_zero();
    let up = world.transform_vector3(Vec3::Y).normalize_or_zero();
    // Far enough for the direction to survive f32.
    let target = eye + forward * eye.length().max(1.0);
    let camera = Camera { eye, target, up, vertical_fov: p.yfov };
    camera.validate().map_err(|e| format!("camera {index}: {e}"))?;
    Ok(Some(camera))
}
