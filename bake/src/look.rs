//! The colour of diffuse reflection, a surface's own light, and its normal map.

use crate::target::Face;
use brdf::Material;
use core::f32::consts::PI;
use glam::{Mat2, Vec2, Vec3};
use lobe_core::Receiver;
use ray_tracing::{mapped_normal, vertex_tangents};
use scene::{Scene, Surface, TexturePlace};
use scene_files::GltfPart;

/// The material of a part, as far as baking needs it.
pub(crate) struct PartMaterial<'a> {
    albedo: Vec3,
    metallic: f32,
    surface: Option<&'a Surface>,
}

impl<'a> PartMaterial<'a> {
    pub(crate) fn new(scene: &'a Scene, part: &GltfPart) -> Self {
        let material = part.object.map_or(0, |object| scene.objects[object].material);
        let (albedo, metallic) = diffuse(&scene.materials[material]);
        Self { albedo, metallic, surface: scene.surface(material) }
    }

    /// The fraction of light that a place of a triangle reflects diffusely, and the radiance that it emits. `texel` are the sides of the
    /// texel that is looked up, in the weights of the second and third corner.
    ///
    /// Of metals it is the part that is none: base colour · (1 − metalness).
    pub(crate) fn at(&self, face: &Face<'_>, at: [f64; 2], texel: Mat2) -> [Vec3; 2] {
        let albedo = self.albedo * face.color(at);
        let Some(surface) = self.surface else { return [albedo * (1.0 - self.metallic), Vec3::ZERO] };
        let place = |set: usize| place(face, at, texel, set);
        let factors = surface.factors(&place);
        let emission = if surface.emits() { surface.emission(&place) } else { Vec3::ZERO };
        [albedo * factors.color * (1.0 - self.metallic * factors.metallic), emission]
    }
}

/// The place of a set of coordinates at which textures are looked up, with the sides of the texel.
fn place(face: &Face<'_>, at: [f64; 2], texel: Mat2, set: usize) -> TexturePlace {
    let sides = face.uv_sides(set);
    let footprint = [texel.x_axis, texel.y_axis].map(|side| sides[0] * side.x + sides[1] * side.y);
    TexturePlace { uv: face.uv(set, at), footprint }
}

/// The normal map of a part.
pub(crate) struct Relief {
    /// With its normal map alone.
    surface: Surface,
    /// Of the vertices; none where normals are flat.
    tangents: Vec<Vec3>,
}

impl Relief {
    /// That of a part; none where it has no such map.
    pub(crate) fn new(scene: &Scene, part: &GltfPart) -> Option<Self> {
        let material = scene.objects.get(part.object?)?.material;
        let normal = scene.surface(material)?.normal.clone()?;
        let mesh = &part.geometry;
        let uvs = mesh.uv_sets.get(normal.0.uv_set)?;
        let matrix = normal.0.transform.matrix2;
        let tangents = if mesh.normals.is_empty() { Vec::new() } else { vertex_tangents(mesh, uvs, matrix) };
        Some(Self { surface: Surface { normal: Some(normal), ..Surface::default() }, tangents })
    }

    /// The normal of a receiver at a place of a triangle, as the mean of the map over a texel.
    pub(crate) fn normal(&self, face: &Face<'_>, at: [f64; 2], texel: Mat2, receiver: &Receiver) -> Vec3 {
        let local = self.surface.normal(&|set| place(face, at, texel, set));
        let (Some(local), Some((map, _))) = (local, &self.surface.normal) else { return receiver.normal };
        mapped_normal(receiver, face.uv_gradients(map.uv_set), map, face.mix(&self.tangents, at), local)
    }
}

/// The diffuse albedo and the metalness of a material.
pub(crate) fn diffuse(material: &Material) -> (Vec3, f32) {
    match material {
        Material::MetallicRoughness(metal) => {
            let (base, metallic, _) = metal.base();
            (base, metallic)
        }
        Material::Lambert(lambert) => (lambert.albedo, 0.0),
        Material::Phong(phong) => (phong.kd * PI, 0.0),
        Material::ModifiedPhong(phong) => (phong.kd, 0.0),
        Material::Neumann(neumann) => (neumann.kd, 0.0),
        _ => (Vec3::ZERO, 0.0),
    }
}

/// The sides of a texel in the weights of the second and third corner of a triangle on a page; zero for a triangle without an area there.
pub(crate) fn texel_sides([a, b, c]: [Vec2; 3], size: [u32; 2]) -> Mat2 {
    let scale = Vec2::new(size[0] as f32, size[1] as f32);
    let to_page = Mat2::from_cols((b - a) * scale, (c - a) * scale);
    let inverse = to_page.inverse_or_zero();
    if inverse.is_finite() { inverse } else { Mat2::ZERO }
}
