//! The colour of diffuse reflection, and a surface's own light.

use crate::target::Face;
use brdf::Material;
use core::f32::consts::PI;
use glam::{Mat2, Vec2, Vec3};
use scene::{Scene, Surface, TexturePlace};
use scene_files::GltfPart;

/// The look of a part.
pub(crate) struct Look<'a> {
    albedo: Vec3,
    metallic: f32,
    surface: Option<&'a Surface>,
}

impl<'a> Look<'a> {
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
        let place = |set: usize| {
            let sides = face.uv_sides(set);
            let footprint = [texel.x_axis, texel.y_axis].map(|side| sides[0] * side.x + sides[1] * side.y);
            TexturePlace { uv: face.uv(set, at), footprint }
        };
        let factors = surface.factors(&place);
        let emission = if surface.emits() { surface.emission(&place) } else { Vec3::ZERO };
        [albedo * factors.color * (1.0 - self.metallic * factors.metallic), emission]
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
