//! The rows of accessors as bytes, to be written again in another order.

use crate::glb::Document;
use scene_files::GltfDocument;
use serde_json::{Map, Value, json};

/// Targets of a GPU for buffer views (glTF 2.0, §5.11.5).
pub(crate) const VERTICES: u32 = 34962;
pub(crate) const INDICES: u32 = 34963;

/// Bytes of a component.
fn size(component: u64) -> usize {
    match component {
        5120 | 5121 => 1,
        5122 | 5123 => 2,
        _ => 4,
    }
}

fn width(kind: &str) -> usize {
    match kind {
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" | "MAT2" => 4,
        "MAT3" => 9,
        "MAT4" => 16,
        _ => 1,
    }
}

fn number(value: &Value) -> usize {
    value.as_u64().unwrap_or(0) as usize
}

/// The rows of an accessor.
#[derive(Clone, Debug)]
pub(crate) struct Rows {
    /// The accessor as it is, without what says where its data are.
    fields: Map<String, Value>,
    row: usize,
    bytes: Vec<u8>,
}

impl Rows {
    /// Those of an accessor of a document that was read without a fault; `None` where it cannot be.
    pub(crate) fn read(file: &GltfDocument, json: &Value, accessor: usize) -> Option<Self> {
        let mut fields = json["accessors"][accessor].as_object()?.clone();
        let (count, component) = (number(&fields["count"]), fields["componentType"].as_u64()?);
        let row = size(component) * width(fields["type"].as_str()?);
        let mut bytes = vec![0; count.checked_mul(row)?];
        if let Some(view) = fields.get("bufferView").and_then(Value::as_u64) {
            let view = &json["bufferViews"][view as usize];
            let start = number(&view["byteOffset"]) + number(fields.get("byteOffset").unwrap_or(&Value::Null));
            let stride = view["byteStride"].as_u64().map_or(row, |stride| stride as usize);
            let data = file.buffers.get(number(&view["buffer"]))?;
            for (k, to) in bytes.chunks_exact_mut(row).enumerate() {
                let at = start + k * stride;
                to.copy_from_slice(data.get(at..at + row)?);
            }
        }
        if let Some(sparse) = fields.get("sparse") {
            let part = |name: &str, each: usize| -> Option<Vec<u8>> {
                let part = &sparse[name];
                let view = &json["bufferViews"][number(&part["bufferView"])];
                let start = number(&view["byteOffset"]) + number(&part["byteOffset"]);
                let data = file.buffers.get(number(&view["buffer"]))?;
                Some(data.get(start..start + each * number(&sparse["count"]))?.to_vec())
            };
            let index_size = size(sparse["indices"]["componentType"].as_u64()?);
            let (indices, values) = (part("indices", index_size)?, part("values", row)?);
            for (at, value) in indices.chunks_exact(index_size).zip(values.chunks_exact(row)) {
                let at = at.iter().rev().fold(0, |sum, byte| sum << 8 | usize::from(*byte));
                bytes.get_mut(at * row..(at + 1) * row)?.copy_from_slice(value);
            }
        }
        ["bufferView", "byteOffset", "sparse"].into_iter().for_each(|name| {
            fields.remove(name);
        });
        Some(Self { fields, row, bytes })
    }

    /// As vertices, of which each is a copy of the row that `origins` names. Returns the accessor.
    pub(crate) fn write(mut self, document: &mut Document, origins: &[u32]) -> usize {
        // Rows of vertices begin at multiples of four.
        let stride = self.row.next_multiple_of(4);
        let mut bytes = vec![0; stride * origins.len()];
        for (to, origin) in bytes.chunks_exact_mut(stride).zip(origins) {
            let at = *origin as usize * self.row;
            to[..self.row].copy_from_slice(&self.bytes[at..at + self.row]);
        }
        let view = document.add_view(&bytes, Some(VERTICES));
        if stride != self.row
            && let Some(view) = document.json.field("bufferViews").item(view)
        {
            *view.field("byteStride") = json!(stride).into();
        }
        self.fields.insert("bufferView".to_owned(), json!(view));
        self.fields.insert("count".to_owned(), json!(origins.len()));
        document.json.field("accessors").push(Value::Object(self.fields))
    }
}

/// Adds floats as vertices of a kind such as `VEC2`. Returns the accessor.
pub(crate) fn add_floats(document: &mut Document, kind: &str, values: &[f32]) -> usize {
    let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
    let view = document.add_view(&bytes, Some(VERTICES));
    let count = values.len() / width(kind);
    let accessor = json!({"bufferView": view, "componentType": 5126, "count": count, "type": kind});
    document.json.field("accessors").push(accessor)
}

/// Adds floats as vertices in the place of an accessor with these fields. Returns the accessor.
pub(crate) fn add_rows(document: &mut Document, fields: &Map<String, Value>, width: usize, values: &[f32]) -> usize {
    let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
    let view = document.add_view(&bytes, Some(VERTICES));
    let mut fields = fields.clone();
    fields.remove("normalized");
    fields.insert("bufferView".to_owned(), json!(view));
    fields.insert("componentType".to_owned(), json!(5126));
    fields.insert("count".to_owned(), json!(values.len() / width));
    if fields.contains_key("min") || fields.contains_key("max") {
        let end = |pick: fn(f32, f32) -> f32, start: f32| -> Vec<f32> {
            (0..width).map(|axis| values.iter().skip(axis).step_by(width).copied().fold(start, pick)).collect()
        };
        fields.insert("min".to_owned(), json!(end(f32::min, f32::INFINITY)));
        fields.insert("max".to_owned(), json!(end(f32::max, f32::NEG_INFINITY)));
    }
    document.json.field("accessors").push(Value::Object(fields))
}

/// Adds numbers of joints, four a vertex, as bytes or as words of two. Returns the accessor.
pub(crate) fn add_joints(document: &mut Document, component: u64, joints: &[u32]) -> usize {
    let bytes: Vec<u8> = match component {
        5121 => joints.iter().map(|joint| *joint as u8).collect(),
        _ => joints.iter().flat_map(|joint| (*joint as u16).to_le_bytes()).collect(),
    };
    let component = if component == 5121 { 5121 } else { 5123 };
    let view = document.add_view(&bytes, Some(VERTICES));
    let accessor = json!({"bufferView": view, "componentType": component, "count": joints.len() / 4, "type": "VEC4"});
    document.json.field("accessors").push(accessor)
}

/// Adds indices of vertices. Returns the accessor.
pub(crate) fn add_indices(document: &mut Document, indices: &[u32]) -> usize {
    let is_short = indices.iter().all(|i| *i < u32::from(u16::MAX));
    let bytes: Vec<u8> = match is_short {
        true => indices.iter().flat_map(|i| (*i as u16).to_le_bytes()).collect(),
        false => indices.iter().flat_map(|i| i.to_le_bytes()).collect(),
    };
    let view = document.add_view(&bytes, Some(INDICES));
    let component = if is_short { 5123 } else { 5125 };
    let accessor = json!({"bufferView": view, "componentType": component, "count": indices.len(), "type": "SCALAR"});
    document.json.field("accessors").push(accessor)
}

impl Rows {
    /// The accessor as it is, without what says where its data are.
    pub(crate) const fn fields(&self) -> &Map<String, Value> {
        &self.fields
    }

    /// The kind of a component, as glTF numbers them.
    pub(crate) fn component(&self) -> u64 {
        self.fields["componentType"].as_u64().unwrap_or(0)
    }

    /// Components of a row.
    pub(crate) fn width(&self) -> usize {
        (self.row / size(self.component())).max(1)
    }

    /// Whether components are floats, or integers that stand for parts of their largest.
    pub(crate) fn is_fraction(&self) -> bool {
        self.component() == 5126 || self.is_normalized()
    }

    fn is_normalized(&self) -> bool {
        self.fields.get("normalized").and_then(Value::as_bool) == Some(true)
    }

    /// All components, row by row, as the numbers that they stand for (glTF 2.0, §3.6.2.2).
    pub(crate) fn numbers(&self) -> Vec<f64> {
        let (component, is_normalized) = (self.component(), self.is_normalized());
        let part = |x: f64, most: f64| if is_normalized { (x / most).max(-1.0) } else { x };
        let number = |bytes: &[u8]| match (component, bytes) {
            (5120, [x]) => part(f64::from(*x as i8), 127.0),
            (5121, [x]) => part(f64::from(*x), 255.0),
            (5122, [x, y]) => part(f64::from(i16::from_le_bytes([*x, *y])), 32767.0),
            (5123, [x, y]) => part(f64::from(u16::from_le_bytes([*x, *y])), 65535.0),
            (5125, [a, b, c, d]) => f64::from(u32::from_le_bytes([*a, *b, *c, *d])),
            (5126, [a, b, c, d]) => f64::from(f32::from_le_bytes([*a, *b, *c, *d])),
            _ => 0.0,
        };
        self.bytes.chunks_exact(size(component)).map(number).collect()
    }

    /// The last component of each row, of colours: floats, or integers as parts of their largest.
    pub(crate) fn last_components(&self) -> Vec<f32> {
        let component = self.fields["componentType"].as_u64().unwrap_or(0);
        let each = size(component);
        let last = |row: &[u8]| match (component, &row[row.len() - each..]) {
            (5121, [x]) => f32::from(*x) / 255.0,
            (5123, [x, y]) => f32::from(u16::from_le_bytes([*x, *y])) / 65535.0,
            (5126, [a, b, c, d]) => f32::from_le_bytes([*a, *b, *c, *d]),
            _ => 1.0,
        };
        self.bytes.chunks_exact(self.row).map(last).collect()
    }
}
