//! Materials that show baked light.

use crate::glb::Document;
use crate::json::Json;
use crate::look::diffuse;
use crate::target::material;
use scene::Scene;
use scene_files::GltfPart;
use serde_json::{Value, json};
use std::collections::HashMap;

/// Baked light on a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Light {
    /// A texture of irradiance, its coordinates, and the irradiance that is white in it.
    Map { texture: usize, set: usize, scale: f32 },
    /// A texture of radiance, its coordinates, and the radiance that is white in it.
    Emission { texture: usize, set: usize, scale: f32 },
    /// Colours of vertices.
    Vertices,
}

/// A material, and the texture and set of coordinates of its light, where each is one.
type Key = (Option<usize>, Option<(usize, usize)>);

/// The materials that were made, by the material and the light that they are made of.
pub(crate) struct Materials {
    /// Whether backs are surfaces of their own, so that all materials are single-sided.
    both_sides: bool,
    made: HashMap<Key, usize>,
}

impl Materials {
    pub(crate) fn new(both_sides: bool) -> Self {
        Self { both_sides, made: HashMap::new() }
    }

    /// A part's material with baked light, by its number: one for all parts with the same.
    pub(crate) fn with(&mut self, document: &mut Document, scene: &Scene, part: &GltfPart, light: Light) -> usize {
        let own = material(&document.before, part);
        let place = match light {
            Light::Map { texture, set, .. } | Light::Emission { texture, set, .. } => Some((texture, set)),
            Light::Vertices => None,
        };
        if let Some(known) = self.made.get(&(own, place)) {
            return *known;
        }
        let there = own.and_then(|own| document.json.field("materials").item(own).cloned());
        let mut new = there.unwrap_or_else(|| bare(scene, part).into());
        dress(&mut new, document, own, light);
        if self.both_sides && new.has("doubleSided") {
            *new.field("doubleSided") = json!(false).into();
        }
        let number = document.json.field("materials").push(new);
        self.made.insert((own, place), number);
        number
    }
}

/// A material for a surface without one, whose default would be a metal: the one that pictures take.
fn bare(scene: &Scene, part: &GltfPart) -> Value {
    let color = part.object.map(|object| diffuse(&scene.materials[scene.objects[object].material]).0);
    let [r, g, b] = color.unwrap_or(glam::Vec3::ONE).to_array();
    json!({"pbrMetallicRoughness": {"baseColorFactor": [r, g, b, 1], "metallicFactor": 0}})
}

fn dress(new: &mut Json, document: &mut Document, own: Option<usize>, light: Light) {
    match light {
        Light::Map { texture, set, scale } => {
            let map = json!({"index": texture, "texCoord": set, "intensity": scale});
            *new.field("extensions").field("MOZ_lightmap") = map.into();
            document.uses("MOZ_lightmap");
        }
        Light::Emission { texture, set, scale } => {
            let before = own.map_or(Value::Null, |own| document.before["materials"][own].clone());
            let alpha = before["pbrMetallicRoughness"]["baseColorFactor"][3].as_f64().unwrap_or(1.0);
            let is_opaque = before["alphaMode"].as_str().is_none_or(|mode| mode == "OPAQUE");
            let base = new.field("pbrMetallicRoughness");
            *base.field("baseColorFactor") = json!([0, 0, 0, alpha]).into();
            *base.field("metallicFactor") = json!(0).into();
            *base.field("roughnessFactor") = json!(1).into();
            base.remove("metallicRoughnessTexture");
            if is_opaque {
                base.remove("baseColorTexture");
            }
            *new.field("emissiveFactor") = json!([1, 1, 1]).into();
            *new.field("emissiveTexture") = json!({"index": texture, "texCoord": set}).into();
            // Lights of a viewer are not to shine on it as well.
            let extensions = new.field("extensions");
            ["KHR_materials_clearcoat", "KHR_materials_sheen"].iter().for_each(|layer| extensions.remove(layer));
            *extensions.field("KHR_materials_emissive_strength") = json!({"emissiveStrength": scale}).into();
            *extensions.field("KHR_materials_specular") = json!({"specularFactor": 0}).into();
            document.uses("KHR_materials_emissive_strength");
            document.uses("KHR_materials_specular");
        }
        Light::Vertices => {
            *new.field("extensions").field("KHR_materials_unlit") = json!({}).into();
            document.uses("KHR_materials_unlit");
        }
    }
}
