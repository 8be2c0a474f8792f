//! Materials of a glTF document.

use brdf::{Material, ModifiedPhong};
use glam::Vec3;
use gltf::json::Root;
use gltf::json::validation::Checked;

/// Base colour, metalness and roughness as a diffuse and a modified Phong term: an approximation. Schlick's normal
/// reflectance `F0 = lerp(0.04, base, metallic)` goes into the highlight, whose exponent has the curvature that a
/// Beckmann half-vector lobe of width `roughness²` has about the mirror direction: `e = (2/α² − 2)/4`.
pub(crate) fn read_material(root: &Root, index: usize) -> Result<Material, String> {
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
