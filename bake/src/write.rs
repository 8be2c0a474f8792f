//! Baked light written into a document.

use crate::blend::{Blended, Named};
use crate::division::Blend;
use crate::glb::Document;
use crate::json::Json;
use crate::materials::{Light, Materials};
use crate::rows::{Rows, add_floats, add_indices};
use crate::target::{Target, primitive};
use glam::Vec3;
use scene::Scene;
use scene_files::{GltfDocument, GltfPart};
use serde_json::{Value, json};
use std::collections::HashMap;

/// A document, and its meshes that nodes have for themselves.
pub(crate) struct Writer<'a> {
    file: &'a GltfDocument,
    scene: &'a Scene,
    pub(crate) document: Document,
    materials: Materials,
    /// Of each node whose mesh was changed: the mesh.
    meshes: HashMap<usize, usize>,
}

impl<'a> Writer<'a> {
    pub(crate) fn new(file: &'a GltfDocument, scene: &'a Scene, document: Document, both_sides: bool) -> Self {
        Self { file, scene, document, materials: Materials::new(both_sides), meshes: HashMap::new() }
    }

    /// The mesh of a part's node, of which no other node shows anything: the mesh itself, or else a copy.
    fn own_mesh(&mut self, part: &GltfPart) -> usize {
        if let Some(known) = self.meshes.get(&part.node) {
            return *known;
        }
        let nodes = self.document.before["nodes"].as_array();
        let uses = nodes.into_iter().flatten().filter(|node| node["mesh"] == json!(part.mesh)).count();
        let mut mesh = part.mesh;
        if uses > 1 {
            let meshes = self.document.json.field("meshes");
            let copy = meshes.item(part.mesh).cloned().unwrap_or_else(|| json!({}).into());
            mesh = meshes.push(copy);
            if let Some(node) = self.document.json.field("nodes").item(part.node) {
                *node.field("mesh") = json!(mesh).into();
            }
        }
        self.meshes.insert(part.node, mesh);
        mesh
    }

    fn edit(&mut self, mesh: usize, part: &GltfPart, edit: impl FnOnce(&mut Json)) {
        let mesh = self.document.json.field("meshes").item(mesh);
        if let Some(primitive) = mesh.and_then(|mesh| mesh.field("primitives").item(part.primitive)) {
            edit(primitive);
        }
    }

    /// A copy of an accessor with a row for each of some vertices.
    fn copied(&mut self, accessor: &Value, origins: &[u32]) -> Option<usize> {
        let rows = Rows::read(self.file, &self.document.before, accessor.as_u64()? as usize)?;
        Some(rows.write(&mut self.document, origins))
    }

    /// Gives a surface its vertices and coordinates on a page, and a texture of light.
    pub(crate) fn texture(&mut self, target: &Target, light: Light) {
        let file = self.file;
        let part = &file.parts[target.part];
        let mesh = self.own_mesh(part);
        if let Some(origins) = &target.origins {
            self.vertices(mesh, part, target, origins);
        }
        let number = self.materials.with(&mut self.document, self.scene, part, light);
        self.edit(mesh, part, |primitive| *primitive.field("material") = json!(number).into());
    }

    /// Writes a surface's vertices again: those on the seams of charts are several now.
    fn vertices(&mut self, mesh: usize, part: &GltfPart, target: &Target, origins: &[u32]) {
        let before = primitive(&self.document.before, part).clone();
        let copies = |own: &mut Self, list: &Value| -> Named {
            let attributes = list.as_object().into_iter().flatten();
            attributes.filter_map(|(name, value)| Some((name.clone(), own.copied(value, origins)?))).collect()
        };
        let attributes = copies(self, &before["attributes"]);
        let morphs = before["targets"].as_array().cloned().unwrap_or_default();
        let morphs: Vec<Named> = morphs.iter().map(|morph| copies(self, morph)).collect();
        self.replace(mesh, part, (attributes, morphs), &target.triangles);
        let uvs: Vec<f32> = target.coordinates.iter().flat_map(|uv| uv.to_array()).collect();
        let uvs = add_floats(&mut self.document, "VEC2", &uvs);
        let has_first = before["attributes"].get("TEXCOORD_0").is_some();
        self.edit(mesh, part, |primitive| {
            let set = |set: usize| format!("TEXCOORD_{set}");
            // Sets are counted from 0 without a gap.
            if !has_first {
                *primitive.field("attributes").field(&set(0)) = json!(uvs).into();
            }
            *primitive.field("attributes").field(&set(target.set)) = json!(uvs).into();
        });
    }

    /// Gives a surface other vertices and triangles: attributes, those of its morph targets, and the triangles as they go round in the world.
    fn replace(
        &mut self,
        mesh: usize,
        part: &GltfPart,
        (attributes, morphs): (Named, Vec<Named>),
        triangles: &[[u32; 3]],
    ) {
        let turned = |t: &[u32; 3]| if part.is_turned { [t[0], t[2], t[1]] } else { *t };
        let indices: Vec<u32> = triangles.iter().flat_map(turned).collect();
        let indices = add_indices(&mut self.document, &indices);
        self.edit(mesh, part, |primitive| {
            for (name, accessor) in attributes {
                *primitive.field("attributes").field(&name) = json!(accessor).into();
            }
            for (place, morph) in morphs.into_iter().enumerate() {
                let Some(to) = primitive.field("targets").item(place) else { continue };
                morph.into_iter().for_each(|(name, accessor)| *to.field(&name) = json!(accessor).into());
            }
            *primitive.field("indices") = json!(indices).into();
            primitive.remove("mode");
            // Compressed copies of the old vertices.
            if primitive.has("extensions") {
                primitive.field("extensions").remove("KHR_draco_mesh_compression");
            }
        });
    }

    /// Gives a surface the vertices of a division, and its triangles.
    pub(crate) fn divided(&mut self, part: &GltfPart, vertices: &[Blend], triangles: &[[u32; 3]]) {
        let mesh = self.own_mesh(part);
        let before = core::mem::take(&mut self.document.before);
        let mut primitive = primitive(&before, part).clone();
        // They are written beside the light.
        if let Some(attributes) = primitive["attributes"].as_object_mut() {
            attributes.remove("COLOR_0");
        }
        let blended = Blended { file: self.file, before: &before, vertices };
        let made = blended.primitive(&mut self.document, &primitive);
        self.document.before = before;
        self.replace(mesh, part, made, triangles);
    }

    /// Gives a surface colours of its vertices: irradiance over π and over a scale, times the colours that it has. `vertices` are those of a
    /// division, if there is one.
    pub(crate) fn colors(&mut self, part: &GltfPart, vertices: Option<&[Blend]>, irradiance: &[Vec3], scale: f32) {
        let mesh = self.own_mesh(part);
        let before = primitive(&self.document.before, part);
        let alphas = before["attributes"]["COLOR_0"].as_u64().and_then(|color| self.alphas(color as usize));
        let own = &part.geometry.colors;
        let mut values = Vec::new();
        for (place, light) in irradiance.iter().enumerate() {
            let blend = vertices.map_or(Blend::one(place as u32), |vertices| vertices[place]);
            let color = if own.is_empty() { Vec3::ONE } else { blend.of(own) };
            let color = *light * (core::f32::consts::FRAC_1_PI / scale) * color;
            values.extend(color.min(Vec3::ONE).to_array());
            values.extend(alphas.as_ref().map(|alphas| {
                let each = blend
                    .parts()
                    .map(|(vertex, weight)| f64::from(alphas.get(vertex as usize).copied().unwrap_or(1.0)) * weight);
                each.sum::<f64>() as f32
            }));
        }
        let kind = if alphas.is_some() { "VEC4" } else { "VEC3" };
        let colors = add_floats(&mut self.document, kind, &values);
        let number = self.materials.with(&mut self.document, self.scene, part, Light::Vertices);
        self.edit(mesh, part, |primitive| {
            *primitive.field("attributes").field("COLOR_0") = json!(colors).into();
            *primitive.field("material") = json!(number).into();
        });
    }

    /// The alphas of colours, where these have some.
    fn alphas(&self, accessor: usize) -> Option<Vec<f32>> {
        (self.document.before["accessors"][accessor]["type"] == "VEC4").then_some(())?;
        let rows = Rows::read(self.file, &self.document.before, accessor)?;
        Some(rows.last_components())
    }
}
