//! The extensions of a glTF document: those that are read, those that change no picture, and the others, each of which gives a warning.

use crate::context::Context;
use gltf::json::{Root, Value};
use std::collections::BTreeSet;
use std::path::Path;

/// Extensions that are read, or whose unread parts are named in a warning.
const READ: [&str; 11] = [
    "EXT_mesh_gpu_instancing",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_transform",
];

/// Compressed copies of data that a document which does not require them has plain as well.
const COMPRESSED: [&str; 3] = ["EXT_meshopt_compression", "KHR_draco_mesh_compression", "KHR_meshopt_compression"];

/// Extensions without which a picture is the same, required or not: metadata, sound, physics, and choices of which the document's own is
/// shown.
const HARMLESS: [&str; 27] = [
    "AGI_articulations",
    "AGI_stk_metadata",
    "ALCM_blend_shape_names",
    "EXT_feature_metadata",
    "EXT_instance_features",
    "EXT_mesh_features",
    "EXT_mesh_manifold",
    "EXT_structural_metadata",
    "FB_geometry_metadata",
    "GODOT_single_root",
    "KHR_audio_emitter",
    "KHR_interactivity",
    "KHR_materials_variants",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_physics_rigid_bodies",
    "KHR_implicit_shapes",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MSFT_audio_emitter",
    "MSFT_collision_primitives",
    "MSFT_lod",
    "MSFT_packing_normalRoughnessMetallic",
    "MSFT_packing_occlusionRoughnessMetallic",
    "MSFT_screencoverage",
    "OMI_physics_body",
    "OMI_physics_shape",
];

/// The parts of a document that its typed form leaves out.
pub(crate) struct Extensions {
    /// All names that the document lists or uses.
    names: BTreeSet<String>,
    /// For each node whether it says that it and all below it are not shown.
    hidden: Vec<bool>,
    /// For each node that has them: the accessors of its instances by name.
    instances: Vec<Option<Value>>,
    /// The materials as they are written; none in a document without extensions.
    materials: Vec<Option<Value>>,
    /// Attributes of morph targets that are not read.
    morphed: BTreeSet<String>,
}

impl Extensions {
    /// Those of a document, whose text is parsed again where there are any.
    pub(crate) fn read(root: &Root, json: &[u8]) -> Self {
        let (n, m) = (root.nodes.len(), root.materials.len());
        let listed = root.extensions_used.iter().chain(&root.extensions_required).cloned();
        let (names, hidden) = (listed.collect(), vec![false; n]);
        let (instances, materials, morphed) = (vec![None; n], vec![None; m], BTreeSet::new());
        let mut own = Self { names, hidden, instances, materials, morphed };
        if !has(json, b"\"extensions\"") && !has(json, b"\"targets\"") {
            return own;
        }
        let Ok(value) = gltf::json::deserialize::from_slice::<Value>(json) else { return own };
        own.gather(&value);
        own.morphed = unread_targets(&value);
        for (i, node) in list(&value, "nodes").enumerate().take(n) {
            let visible = node.pointer("/extensions/KHR_node_visibility/visible").and_then(Value::as_bool);
            own.hidden[i] = visible == Some(false);
            own.instances[i] = node.pointer("/extensions/EXT_mesh_gpu_instancing/attributes").cloned();
        }
        for (own, material) in own.materials.iter_mut().zip(list(&value, "materials")) {
            *own = Some(material.clone());
        }
        own
    }

    /// The names of all extension objects below a value: some documents do not list them. JSON is as deep as its parser allows, 128.
    fn gather(&mut self, value: &Value) {
        match value {
            Value::Array(items) => items.iter().for_each(|item| self.gather(item)),
            Value::Object(fields) => {
                for (key, field) in fields.iter().filter(|(key, _)| *key != "extras") {
                    if key == "extensions" {
                        self.names.extend(field.as_object().into_iter().flat_map(|all| all.keys().cloned()));
                    }
                    self.gather(field);
                }
            }
            _ => {}
        }
    }

    /// A required extension that is not read and is needed, if there is one.
    pub(crate) fn missing(root: &Root) -> Option<&str> {
        let is_needed = |name: &&str| !READ.contains(name) && !HARMLESS.contains(name);
        root.extensions_required.iter().map(String::as_str).find(is_needed)
    }

    /// Warns of each extension that may change the picture and is not read.
    pub(crate) fn tell(&self, path: &Path, context: &mut Context) {
        let unread = |name: &&str| ![&READ[..], &HARMLESS, &COMPRESSED].iter().any(|known| known.contains(name));
        for name in self.names.iter().map(String::as_str).filter(unread) {
            let without = if is_of_surfaces(name) { "surfaces are" } else { "the picture is" };
            context.warn(path, format!("the extension {name} is not read: {without} as without it"));
        }
        for name in &self.morphed {
            context.warn(path, format!("morph targets of {name} are not read"));
        }
    }

    /// Whether a node and all below it are not shown; cameras are not affected.
    pub(crate) fn hides(&self, node: usize) -> bool {
        self.hidden[node]
    }

    /// The attributes of a node's instances, if it has them.
    pub(crate) fn instances(&self, node: usize) -> Option<&Value> {
        self.instances[node].as_ref()
    }

    /// A material as it is written, with what its typed form leaves out.
    pub(crate) fn of_material(&self, material: usize) -> Option<&Value> {
        self.materials.get(material)?.as_ref()
    }
}

/// The attributes that morph targets of a document move and that stay as they are.
fn unread_targets(value: &Value) -> BTreeSet<String> {
    let targets = list(value, "meshes").flat_map(|mesh| list(mesh, "primitives")).flat_map(|p| list(p, "targets"));
    let names = targets.filter_map(Value::as_object).flat_map(|target| target.keys());
    names.filter(|name| name.starts_with("COLOR_") || name.starts_with("TEXCOORD_")).cloned().collect()
}

fn list<'v>(value: &'v Value, name: &str) -> impl Iterator<Item = &'v Value> + use<'v> {
    value.get(name).and_then(Value::as_array).into_iter().flatten()
}

fn is_of_surfaces(name: &str) -> bool {
    name.contains("_materials_") || name.contains("_texture_")
}

fn has(text: &[u8], word: &[u8]) -> bool {
    text.windows(word.len()).any(|window| window == word)
}
