//! glTF files made for tests, and what is baked of them.

use bake::{BakeError, BakeSettings, Baked, Baker};
use core::ops::ControlFlow;
use glam::{Vec2, Vec3};
use renderer::Settings;
use scene_files::LoadOptions;
use serde_json::{Value, json};
use std::path::Path;

/// A file in the making.
pub(crate) struct File {
    pub(crate) json: Value,
    pub(crate) binary: Vec<u8>,
}

impl File {
    pub(crate) fn new() -> Self {
        let json = json!({
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": []}],
            "nodes": [], "meshes": [], "accessors": [], "bufferViews": [], "buffers": [{"byteLength": 0}],
            "materials": [{"name": "white", "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 1.0}}],
            "extensionsUsed": ["KHR_lights_punctual"],
            "extensions": {"KHR_lights_punctual": {"lights": []}},
        });
        Self { json, binary: Vec::new() }
    }

    fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.json[list].as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    fn accessor(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len()});
        let view = self.push("bufferViews", view);
        self.binary.extend_from_slice(bytes);
        let accessor = json!({"bufferView": view, "componentType": component, "count": count, "type": kind});
        self.push("accessors", accessor)
    }

    fn floats(&mut self, kind: &str, values: &[f32], count: usize) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(&bytes, 5126, kind, count)
    }

    /// A mesh of one primitive; gives its number.
    pub(crate) fn mesh(
        &mut self,
        name: &str,
        positions: &[Vec3],
        triangles: &[[u32; 3]],
        uvs: Option<&[Vec2]>,
    ) -> usize {
        let all: Vec<f32> = positions.iter().flat_map(|p| p.to_array()).collect();
        let place = self.floats("VEC3", &all, positions.len());
        let low = positions.iter().copied().reduce(Vec3::min).unwrap();
        let high = positions.iter().copied().reduce(Vec3::max).unwrap();
        self.json["accessors"][place]["min"] = json!(low.to_array());
        self.json["accessors"][place]["max"] = json!(high.to_array());
        let bytes: Vec<u8> = triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
        let indices = self.accessor(&bytes, 5125, "SCALAR", 3 * triangles.len());
        let mut attributes = json!({"POSITION": place});
        if let Some(uvs) = uvs {
            let all: Vec<f32> = uvs.iter().flat_map(|p| p.to_array()).collect();
            let uvs = self.floats("VEC2", &all, uvs.len());
            attributes["TEXCOORD_0"] = json!(uvs);
            attributes["TEXCOORD_1"] = json!(uvs);
        }
        let primitive = json!({"attributes": attributes, "indices": indices, "material": 0});
        self.push("meshes", json!({"name": name, "primitives": [primitive]}))
    }

    /// Gives the first primitive of a mesh an attribute with a number of rows as it has positions, of a kind of component that stands for parts
    /// of its largest or not.
    pub(crate) fn attribute(
        &mut self,
        mesh: usize,
        name: &str,
        bytes: &[u8],
        (component, is_part): (u32, bool),
        kind: &str,
    ) {
        let positions = &self.json["meshes"][mesh]["primitives"][0]["attributes"]["POSITION"];
        let count = self.json["accessors"][positions.as_u64().unwrap() as usize]["count"].as_u64().unwrap() as usize;
        let accessor = self.accessor(bytes, component, kind, count);
        if is_part {
            self.json["accessors"][accessor]["normalized"] = json!(true);
        }
        self.json["meshes"][mesh]["primitives"][0]["attributes"][name] = json!(accessor);
    }

    /// A node of the scene; gives its number.
    pub(crate) fn node(&mut self, node: Value) -> usize {
        let node = self.push("nodes", node);
        self.json["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(node));
        node
    }

    /// A rectangle by its middle and half its sides; its front is where they go round against the clock. Its coordinates are a square
    /// of the page, or are to be made.
    pub(crate) fn quad(&mut self, name: &str, [middle, u, v]: [Vec3; 3], square: Option<[Vec2; 2]>) -> usize {
        let positions = [middle - u - v, middle + u - v, middle + u + v, middle - u + v];
        let uvs = square.map(|[low, high]| [low, Vec2::new(high.x, low.y), high, Vec2::new(low.x, high.y)]);
        let mesh = self.mesh(name, &positions, &[[0, 1, 2], [0, 2, 3]], uvs.as_ref().map(|uvs| &uvs[..]));
        self.node(json!({"name": name, "mesh": mesh}))
    }

    /// A box with its front outward, of flat sides.
    pub(crate) fn block(&mut self, name: &str, middle: Vec3, half: Vec3) -> usize {
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for normal in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z] {
            let (a, b) = normal.any_orthonormal_pair();
            let (a, b) = if a.cross(b).dot(normal) > 0.0 { (a, b) } else { (b, a) };
            let first = positions.len() as u32;
            positions.extend([-a - b, a - b, a + b, -a + b].map(|side| middle + half * (normal + side)));
            triangles.extend([[0, 1, 2], [0, 2, 3]].map(|t: [u32; 3]| t.map(|i| i + first)));
        }
        let mesh = self.mesh(name, &positions, &triangles, None);
        self.node(json!({"name": name, "mesh": mesh}))
    }

    /// A light of the extension at a place.
    pub(crate) fn light(&mut self, light: Value, at: Vec3) -> usize {
        let lights = self.json["extensions"]["KHR_lights_punctual"]["lights"].as_array_mut().unwrap();
        lights.push(light);
        let number = lights.len() - 1;
        self.node(json!({"translation": at.to_array(), "extensions": {"KHR_lights_punctual": {"light": number}}}))
    }

    /// The file as bytes.
    pub(crate) fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        let mut binary = self.binary.clone();
        binary.resize(binary.len().next_multiple_of(4), 0);
        json["buffers"][0]["byteLength"] = json!(binary.len());
        glb(json.to_string().as_bytes(), &binary)
    }
}

/// A container of chunks.
pub(crate) fn glb(json: &[u8], binary: &[u8]) -> Vec<u8> {
    let mut json = json.to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = 12 + 8 + json.len() + 8 + binary.len();
    let mut out = b"glTF".to_vec();
    let words = |out: &mut Vec<u8>, words: &[u32]| words.iter().for_each(|w| out.extend_from_slice(&w.to_le_bytes()));
    words(&mut out, &[2, length as u32, json.len() as u32, 0x4e4f_534a]);
    out.extend_from_slice(&json);
    words(&mut out, &[binary.len() as u32, 0x004e_4942]);
    out.extend_from_slice(binary);
    out
}

/// The chunks of a container: the text of its JSON, and its bytes.
pub(crate) fn chunks(glb: &[u8]) -> (String, Vec<u8>) {
    let word = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&glb[..4], word(4), word(8)), (&b"glTF"[..], 2, glb.len()));
    let json = String::from_utf8(glb[20..20 + word(12)].to_vec()).unwrap();
    let binary = 20 + word(12);
    (json, glb[binary + 8..binary + 8 + word(binary)].to_vec())
}

/// Bakes a file that has been written.
pub(crate) fn bake_file(path: &Path, settings: BakeSettings) -> Result<Baked, BakeError> {
    Baker::open(path, &LoadOptions::new(), settings, Settings::default())?.bake(&mut |_, _| ControlFlow::Continue(()))
}

/// Bakes a file.
pub(crate) fn try_bake(file: &File, settings: BakeSettings) -> Result<Baked, BakeError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.glb");
    std::fs::write(&path, file.glb()).unwrap();
    bake_file(&path, settings)
}

pub(crate) fn bake(file: &File, settings: BakeSettings) -> Baked {
    try_bake(file, settings).unwrap_or_else(|error| panic!("{error}"))
}

/// A baked file that is read again.
pub(crate) struct Baked3 {
    pub(crate) json: Value,
    pub(crate) binary: Vec<u8>,
}

/// The first primitive of a mesh.
pub(crate) struct Mesh3 {
    pub(crate) positions: Vec<Vec3>,
    /// Without alphas.
    pub(crate) colors: Vec<Vec3>,
    pub(crate) triangles: Vec<[usize; 3]>,
}

impl Baked3 {
    pub(crate) fn new(baked: &Baked) -> Self {
        let (text, binary) = chunks(&baked.glb);
        Self { json: serde_json::from_str(&text).unwrap(), binary }
    }

    /// The rows of an accessor, as the numbers that they stand for.
    pub(crate) fn rows(&self, accessor: &Value) -> Vec<Vec<f64>> {
        let accessor = &self.json["accessors"][accessor.as_u64().unwrap() as usize];
        let view = &self.json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let start =
            view["byteOffset"].as_u64().unwrap() as usize + accessor["byteOffset"].as_u64().unwrap_or(0) as usize;
        let width = match accessor["type"].as_str().unwrap() {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            _ => 4,
        };
        let size = match accessor["componentType"].as_u64().unwrap() {
            5121 => 1,
            5123 => 2,
            _ => 4,
        };
        let stride = view["byteStride"].as_u64().map_or(width * size, |stride| stride as usize);
        let number = |at: usize| match accessor["componentType"].as_u64().unwrap() {
            5121 => f64::from(self.binary[at]),
            5123 => f64::from(u16::from_le_bytes(self.binary[at..at + 2].try_into().unwrap())),
            5125 => f64::from(u32::from_le_bytes(self.binary[at..at + 4].try_into().unwrap())),
            _ => f64::from(f32::from_le_bytes(self.binary[at..at + 4].try_into().unwrap())),
        };
        let row = |k: usize| (0..width).map(|j| number(start + k * stride + j * size)).collect();
        (0..accessor["count"].as_u64().unwrap() as usize).map(row).collect()
    }

    pub(crate) fn mesh(&self, mesh: usize) -> Mesh3 {
        let primitive = &self.json["meshes"][mesh]["primitives"][0];
        let vectors = |name: &str| -> Vec<Vec3> {
            let accessor = &primitive["attributes"][name];
            let rows = if accessor.is_null() { Vec::new() } else { self.rows(accessor) };
            rows.iter().map(|row| Vec3::new(row[0] as f32, row[1] as f32, row[2] as f32)).collect()
        };
        let indices: Vec<usize> = self.rows(&primitive["indices"]).iter().map(|row| row[0] as usize).collect();
        let triangles = indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
        Mesh3 { positions: vectors("POSITION"), colors: vectors("COLOR_0"), triangles }
    }
}

/// The whole of a page.
pub(crate) const WHOLE: Option<[Vec2; 2]> = Some([Vec2::ZERO, Vec2::ONE]);

/// The value of a map at a place, as a filter of four texels shows it.
fn filtered(map: &bake::Map, uv: Vec2) -> Vec3 {
    let size = Vec2::new(map.size[0] as f32, map.size[1] as f32);
    let at = uv * size - 0.5;
    let (low, part) = (at.floor(), at - at.floor());
    let texel = |x: f32, y: f32| {
        let clamp = |k: f32, side: u32| (k.max(0.0) as usize).min(side as usize - 1);
        map.values[clamp(y, map.size[1]) * map.size[0] as usize + clamp(x, map.size[0])]
    };
    let row = |y: f32| texel(low.x, y).lerp(texel(low.x + 1.0, y), part.x);
    row(low.y).lerp(row(low.y + 1.0), part.y)
}

/// The differences of the two sides of a mesh's seams, mean and largest, as parts of the mean light on all seams: of the first mesh of a
/// file whose coordinates were made.
pub(crate) fn seams(baked: &Baked) -> (f32, f32) {
    use std::collections::HashMap;
    let (text, binary) = chunks(&baked.glb);
    let json: Value = serde_json::from_str(&text).unwrap();
    let primitive = &json["meshes"][0]["primitives"][0];
    let bytes = |accessor: &Value| {
        let accessor = &json["accessors"][accessor.as_u64().unwrap() as usize];
        let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let start = view["byteOffset"].as_u64().unwrap() as usize;
        &binary[start..start + view["byteLength"].as_u64().unwrap() as usize]
    };
    let floats = |name: &str| -> Vec<f32> {
        let data = bytes(&primitive["attributes"][name]);
        data.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
    };
    let (positions, uvs) = (floats("POSITION"), floats("TEXCOORD_1"));
    let indices = bytes(&primitive["indices"]).chunks_exact(2);
    let indices: Vec<usize> = indices.map(|b| u16::from_le_bytes(b.try_into().unwrap()) as usize).collect();
    let place = |i: usize| [0, 1, 2].map(|k| positions[3 * i + k].to_bits());
    let uv = |i: usize| Vec2::new(uvs[2 * i], uvs[2 * i + 1]);
    let mut edges: HashMap<_, [usize; 2]> = HashMap::new();
    let (mut differences, mut light) = (Vec::new(), 0.0);
    for t in indices.chunks_exact(3) {
        for k in 0..3 {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            if let Some([c, d]) = edges.get(&(place(b), place(a))).copied() {
                if uv(d) == uv(a) && uv(c) == uv(b) {
                    continue;
                }
                for step in 0..=8 {
                    let s = step as f32 / 8.0;
                    let [one, other] =
                        [uv(a).lerp(uv(b), s), uv(d).lerp(uv(c), s)].map(|uv| filtered(&baked.maps[0], uv));
                    differences.push((one - other).abs().max_element());
                    light += one.max_element();
                }
            } else {
                edges.insert((place(a), place(b)), [a, b]);
            }
        }
    }
    assert!(differences.len() > 50, "{} points on seams", differences.len());
    let count = differences.len() as f32;
    let mean = differences.iter().sum::<f32>() / light;
    (mean, differences.into_iter().fold(0.0, f32::max) * count / light)
}
