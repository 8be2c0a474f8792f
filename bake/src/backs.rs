//! The backs of double-sided surfaces, as surfaces of their own.

use crate::json::Json;
use crate::rows::{INDICES, Rows, VERTICES};
use crate::target::{material, primitive};
use glam::Vec3;
use scene_files::{GltfDocument, GltfPart};
use serde_json::{Value, json};
use std::collections::{HashMap, HashSet};

/// Whether a part's material is drawn on both sides, and the part is no sphere.
pub(crate) fn is_sheet(json: &Value, part: &GltfPart) -> bool {
    part.radii.is_empty()
        && material(json, part).is_some_and(|number| json["materials"][number]["doubleSided"] == json!(true))
}

/// Whether a surface has a border: an edge of one triangle alone.
pub(crate) fn has_border(part: &GltfPart) -> bool {
    let mesh = &part.geometry;
    let place = |i: u32| (mesh.positions[i as usize] + 0.0).to_array().map(f32::to_bits);
    let mut open = HashSet::new();
    for [a, b, c] in mesh.triangles.iter().map(|t| t.map(place)).filter(|[a, b, c]| a != b && b != c && c != a) {
        for (p, q) in [(a, b), (b, c), (c, a)] {
            if !open.remove(&(q, p)) {
                open.insert((p, q));
            }
        }
    }
    !open.is_empty()
}

/// Adds the backs of parts to a document: each as one more primitive of the mesh with the same vertices, opposite normals and tangents, and
/// triangles that go round the other way. Returns the places of the new parts, in the order of `parts`.
pub(crate) fn add(file: &mut GltfDocument, parts: &[usize]) -> Result<Vec<usize>, serde_json::Error> {
    let before: Value = serde_json::from_str(&file.json)?;
    let mut made = Backs { before, json: Json::parse(&file.json)?, bytes: Vec::new(), buffer: file.buffers.len() };
    let mut known: HashMap<(usize, usize), usize> = HashMap::new();
    let mut places = Vec::new();
    for &place in parts {
        let part = &file.parts[place];
        let number = match known.get(&(part.mesh, part.primitive)) {
            Some(number) => *number,
            None => made.primitive(file, part),
        };
        known.insert((part.mesh, part.primitive), number);
        let mut back = GltfPart { primitive: number, is_back: true, ..part.clone() };
        back.geometry.normals.iter_mut().for_each(|normal: &mut Vec3| *normal = -*normal);
        back.geometry.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        places.push(file.parts.len());
        file.parts.push(back);
    }
    if !made.bytes.is_empty() {
        made.json.field("buffers").push(json!({"byteLength": made.bytes.len()}));
        file.buffers.push(made.bytes);
    }
    file.json = made.json.text();
    Ok(places)
}

/// Backs in the making.
struct Backs {
    before: Value,
    json: Json,
    bytes: Vec<u8>,
    /// The number of the buffer that `bytes` will be.
    buffer: usize,
}

impl Backs {
    fn accessor(&mut self, bytes: &[u8], target: u32, mut accessor: Value) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let (start, length) = (self.bytes.len(), bytes.len());
        let view = json!({"buffer": self.buffer, "byteOffset": start, "byteLength": length, "target": target});
        accessor["bufferView"] = json!(self.json.field("bufferViews").push(view));
        self.bytes.extend_from_slice(bytes);
        self.json.field("accessors").push(accessor)
    }

    /// The opposite of directions, as floats.
    fn opposite(&mut self, file: &GltfDocument, accessor: &Value) -> Option<usize> {
        let rows = Rows::read(file, &self.before, accessor.as_u64()? as usize)?;
        let numbers = rows.numbers();
        // Not −0.
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| (0.0 - *x as f32).to_le_bytes()).collect();
        let kind = if rows.width() == 4 { "VEC4" } else { "VEC3" };
        let accessor = json!({"componentType": 5126, "count": numbers.len() / rows.width(), "type": kind});
        Some(self.accessor(&bytes, VERTICES, accessor))
    }

    /// Adds the back of a part's primitive to its mesh; returns its place there.
    fn primitive(&mut self, file: &GltfDocument, part: &GltfPart) -> usize {
        let mut new = primitive(&self.before, part).clone();
        let directions = ["NORMAL", "TANGENT"];
        let flip = |own: &mut Self, list: &mut Value| {
            for name in directions {
                if let Some(accessor) = list.get_mut(name)
                    && let Some(number) = own.opposite(file, accessor)
                {
                    *accessor = json!(number);
                }
            }
        };
        flip(self, &mut new["attributes"]);
        if let Some(morphs) = new.get_mut("targets").and_then(Value::as_array_mut) {
            morphs.iter_mut().for_each(|morph| flip(self, morph));
        }
        // In the mesh's own space.
        let turned = |t: &[u32; 3]| if part.is_turned { *t } else { [t[0], t[2], t[1]] };
        let indices: Vec<u8> =
            part.geometry.triangles.iter().flat_map(turned).flat_map(|index| index.to_le_bytes()).collect();
        let count = 3 * part.geometry.triangles.len();
        let accessor = json!({"componentType": 5125, "count": count, "type": "SCALAR"});
        new["indices"] = json!(self.accessor(&indices, INDICES, accessor));
        if let Some(new) = new.as_object_mut() {
            new.remove("mode");
            if let Some(extensions) = new.get_mut("extensions").and_then(Value::as_object_mut) {
                extensions.remove("KHR_draco_mesh_compression");
            }
        }
        match self.json.field("meshes").item(part.mesh) {
            Some(mesh) => mesh.field("primitives").push(new),
            None => part.primitive,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::Mesh;

    #[test]
    fn borders_are_found() {
        let positions: Vec<Vec3> =
            [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]].map(Vec3::from_array).to_vec();
        let part = |triangles: &[[u32; 3]]| GltfPart {
            geometry: Mesh { positions: positions.clone(), triangles: triangles.to_vec(), ..Mesh::default() },
            ..GltfPart::default()
        };
        // A vertex of its own at a place that is there already makes no border, nor does a triangle without an area.
        let closed = [[0, 2, 1], [4, 1, 3], [0, 3, 2], [1, 2, 3]];
        assert!(!has_border(&part(&closed)));
        assert!(!has_border(&part(&[&closed[..], &[[0, 4, 1]]].concat())));
        assert!(has_border(&part(&closed[..3])));
    }
}
