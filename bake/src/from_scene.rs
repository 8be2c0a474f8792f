//! Scenes that come from no glTF file, as a new document.

use crate::look::diffuse;
use crate::round;
use brdf::Material;
use glam::{Mat4, Vec2, Vec3};
use lobe_core::Sphere;
use pictures::{Picture, png_bytes, srgb_bytes};
use scene::{Bounds, Camera, Mesh, Object, Projection, Scene, Shape, Surface, TextureMap, TexturePlace, Wrap};
use scene_files::{GltfDocument, GltfPart};
use serde_json::{Map, Value, json};
use std::borrow::Cow;

/// The parts of scenes that are written: the same at all moments of an animation.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Plan {
    /// The first object.
    first: usize,
    /// Whether materials are double-sided.
    is_double_sided: bool,
    /// For each object the steps along an edge of its spheres.
    steps: Vec<u32>,
}

impl Plan {
    /// For the objects from the number `first` on, by their sizes now.
    pub(crate) fn new(scene: &Scene, first: usize, is_double_sided: bool) -> Self {
        let seen = || scene.objects.iter().skip(first).filter(|object| object.visible);
        let bounds = seen().fold(Bounds::EMPTY, |all, object| all.union(object.shape.bounds()));
        let size = (bounds.max - bounds.min).max_element();
        let count = seen().map(|object| spheres(object).len()).sum();
        let steps = |object: &Object| {
            let radius = spheres(object).iter().map(|sphere| sphere.radius).fold(0.0, f32::max);
            round::steps(radius, size, count)
        };
        Self { first, is_double_sided, steps: scene.objects.iter().map(steps).collect() }
    }
}

fn spheres(object: &Object) -> &[Sphere] {
    match &object.shape {
        Shape::Spheres(spheres) => spheres,
        _ => &[],
    }
}

/// A document of the objects of a scene that are seen, with its camera: one node an object; spheres as triangles. And a line about each thing
/// that it leaves out.
pub(crate) fn document(scene: &Scene, plan: &Plan) -> (GltfDocument, Vec<String>) {
    let is_double_sided = plan.is_double_sided;
    let mut made = Made { scene, is_double_sided, json: empty(), binary: Vec::new(), materials: Vec::new() };
    let (mut parts, mut notes) = (Vec::new(), Vec::new());
    let seen = scene.objects.iter().enumerate().skip(plan.first).filter(|(_, object)| object.visible);
    for (number, object) in seen {
        let name = &object.name;
        let mut radii = Vec::new();
        let mesh = object.shape.mesh().unwrap_or_else(|| {
            let mut mesh = Mesh::default();
            for sphere in spheres(object) {
                round::add(&mut mesh, sphere, plan.steps.get(number).copied().unwrap_or(1));
                radii.resize(mesh.positions.len(), sphere.radius);
            }
            Cow::Owned(mesh)
        });
        let place = made.mesh(name, &mesh, object.material);
        let node = made.node(json!({"name": name, "mesh": place}));
        let (name, geometry) = (name.clone(), mesh.into_owned());
        parts.push(GltfPart {
            node,
            mesh: place,
            name,
            object: Some(number),
            copies: 1,
            geometry,
            radii,
            ..GltfPart::default()
        });
    }
    for &number in &made.materials {
        let material = &scene.materials[number];
        if diffuse(material) == (Vec3::ZERO, 0.0) && !scene.surface(number).is_some_and(Surface::emits) {
            notes.push(format!("material {number} ({}) has no diffuse part: its surfaces are black", material.name()));
        }
    }
    if !made.camera(&scene.camera) {
        notes.push("the panoramic camera is left out: glTF has none".to_owned());
    }
    made.json["buffers"] = json!([{"byteLength": made.binary.len()}]);
    (GltfDocument { json: made.json.to_string(), buffers: vec![made.binary], images: Vec::new(), parts }, notes)
}

fn empty() -> Value {
    json!({"asset": {"version": "2.0", "generator": "cosine-lobes"}, "scene": 0, "scenes": [{"nodes": []}]})
}

/// A document in the making.
struct Made<'a> {
    scene: &'a Scene,
    is_double_sided: bool,
    json: Value,
    binary: Vec<u8>,
    /// Materials of the scene that are written, in order.
    materials: Vec<usize>,
}

impl Made<'_> {
    fn push(&mut self, list: &str, value: Value) -> usize {
        if self.json[list].is_null() {
            self.json[list] = json!([]);
        }
        let list = self.json[list].as_array_mut().expect("it is an array");
        list.push(value);
        list.len() - 1
    }

    fn uses(&mut self, extension: &str) {
        let is_listed = self.json["extensionsUsed"].as_array().is_some_and(|all| all.contains(&json!(extension)));
        if !is_listed {
            self.push("extensionsUsed", json!(extension));
        }
    }

    fn node(&mut self, node: Value) -> usize {
        let node = self.push("nodes", node);
        if let Some(nodes) = self.json["scenes"][0]["nodes"].as_array_mut() {
            nodes.push(json!(node));
        }
        node
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let view = json!({"buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len()});
        self.binary.extend_from_slice(bytes);
        self.push("bufferViews", view)
    }

    fn floats(&mut self, kind: &str, count: usize, values: impl Iterator<Item = f32>) -> usize {
        let bytes: Vec<u8> = values.flat_map(f32::to_le_bytes).collect();
        let view = self.view(&bytes);
        self.push("accessors", json!({"bufferView": view, "componentType": 5126, "count": count, "type": kind}))
    }

    fn vectors(&mut self, values: &[Vec3]) -> usize {
        self.floats("VEC3", values.len(), values.iter().flat_map(|v| v.to_array()))
    }

    fn mesh(&mut self, name: &str, mesh: &Mesh, material: usize) -> usize {
        let mut attributes = Map::new();
        let place = self.vectors(&mesh.positions);
        let ends = mesh.positions.iter().copied();
        let ends = [ends.clone().reduce(Vec3::min), ends.reduce(Vec3::max)].map(Option::unwrap_or_default);
        self.json["accessors"][place]["min"] = json!(ends[0].to_array());
        self.json["accessors"][place]["max"] = json!(ends[1].to_array());
        attributes.insert("POSITION".to_owned(), json!(place));
        for (name, values) in [("NORMAL", &mesh.normals), ("COLOR_0", &mesh.colors)] {
            if !values.is_empty() {
                attributes.insert(name.to_owned(), json!(self.vectors(values)));
            }
        }
        for (set, uvs) in mesh.uv_sets.iter().enumerate() {
            let uvs = self.floats("VEC2", uvs.len(), uvs.iter().flat_map(|uv| uv.to_array()));
            attributes.insert(format!("TEXCOORD_{set}"), json!(uvs));
        }
        let bytes: Vec<u8> = mesh.triangles.iter().flatten().flat_map(|i| i.to_le_bytes()).collect();
        let view = self.view(&bytes);
        let count = 3 * mesh.triangles.len();
        let indices = json!({"bufferView": view, "componentType": 5125, "count": count, "type": "SCALAR"});
        let indices = self.push("accessors", indices);
        let material = self.material(material);
        let primitive = json!({"attributes": attributes, "indices": indices, "material": material});
        self.push("meshes", json!({"name": name, "primitives": [primitive]}))
    }

    /// A material by its diffuse part, its metalness and its emission; the number in the document.
    fn material(&mut self, number: usize) -> usize {
        if let Some(known) = self.materials.iter().position(|known| *known == number) {
            return known;
        }
        self.materials.push(number);
        let material = &self.scene.materials[number];
        let (color, metallic) = diffuse(material);
        let roughness = match material {
            Material::MetallicRoughness(metal) => metal.base().2,
            _ => 1.0,
        };
        let [r, g, b] = color.min(Vec3::ONE).to_array();
        let mut base =
            json!({"baseColorFactor": [r, g, b, 1], "metallicFactor": metallic, "roughnessFactor": roughness});
        let mut new = json!({"name": format!("material {number}")});
        if let Some(surface) = self.scene.surface(number) {
            if let Some(map) = &surface.color {
                base["baseColorTexture"] = self.texture(map);
            }
            let most = surface.emission.max_element();
            if most > 0.0 && surface.emission_map.is_none() {
                new["emissiveFactor"] = json!((surface.emission / most).to_array());
                new["extensions"] = json!({"KHR_materials_emissive_strength": {"emissiveStrength": most}});
                self.uses("KHR_materials_emissive_strength");
            }
        }
        new["pbrMetallicRoughness"] = base;
        if self.is_double_sided {
            new["doubleSided"] = json!(true);
        }
        self.push("materials", new)
    }

    /// The texture of colours, texel by texel, and its reference. A transform of its coordinates is left to emission.
    fn texture(&mut self, map: &TextureMap) -> Value {
        let [width, height] = map.texture.size();
        let plain = TextureMap {
            transform: glam::Affine2::IDENTITY,
            wrap: [Wrap::Clamp; 2],
            is_pixelated: true,
            ..map.clone()
        };
        let size = Vec2::new(width as f32, height as f32);
        let texel = |k: usize| {
            let uv = (Vec2::new((k % width) as f32, (k / width) as f32) + 0.5) / size;
            let [r, g, b, _] = plain.sample(&|_| TexturePlace { uv, ..TexturePlace::default() });
            Vec3::new(r, g, b)
        };
        let colors = Picture::new(width, height, (0..width * height).map(texel).collect());
        let png = png_bytes(width, height, &srgb_bytes(&colors, 0.0)).unwrap_or_default();
        let view = self.view(&png);
        let wrap = map.wrap.map(|wrap| match wrap {
            Wrap::Repeat => 10497,
            Wrap::Mirror => 33648,
            Wrap::Clamp => 33071,
        });
        let sampler = self.push("samplers", json!({"wrapS": wrap[0], "wrapT": wrap[1]}));
        let image = self.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
        let texture = self.push("textures", json!({"sampler": sampler, "source": image}));
        let mut reference = json!({"index": texture, "texCoord": map.uv_set});
        let (scale, angle, offset) = map.transform.to_scale_angle_translation();
        if map.transform != glam::Affine2::IDENTITY {
            let transform = json!({"scale": scale.to_array(), "rotation": -angle, "offset": offset.to_array()});
            reference["extensions"] = json!({"KHR_texture_transform": transform});
            self.uses("KHR_texture_transform");
        }
        reference
    }

    /// Writes the camera; false where glTF has none of its kind.
    fn camera(&mut self, camera: &Camera) -> bool {
        // Cameras look along −z.
        let back = (camera.eye - camera.target).normalize_or_zero();
        let right = camera.up.cross(back).normalize_or_zero();
        let axes = [right, back.cross(right), back].map(|axis| axis.extend(0.0));
        let matrix = Mat4::from_cols(axes[0], axes[1], axes[2], camera.eye.extend(1.0)).to_cols_array();
        if matrix.iter().any(|x| !x.is_finite()) {
            return true;
        }
        let kind = camera.projection.name();
        let written = match camera.projection {
            Projection::Perspective { vertical_fov } => json!({"yfov": vertical_fov, "znear": 0.01}),
            Projection::Orthographic { height } => {
                let (half, aspect) = (0.5 * height, self.scene.width as f32 / self.scene.height.max(1) as f32);
                let bounds = self.scene.bounds();
                let far =
                    if bounds.is_empty() { 1.0 } else { camera.distance(bounds.center()).max(0.0) + bounds.radius() };
                json!({"xmag": half * aspect, "ymag": half, "znear": 0.0, "zfar": 1.01 * far.max(1e-3)})
            }
            Projection::Panoramic => return false,
        };
        let mut of_kind = json!({"type": kind});
        of_kind[kind] = written;
        let camera = self.push("cameras", of_kind);
        self.node(json!({"name": "camera", "camera": camera, "matrix": matrix}));
        true
    }
}
