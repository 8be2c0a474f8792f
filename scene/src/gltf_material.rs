//! Materials of a glTF document.

use brdf::{Material, MetallicRoughness};
use glam::Vec3;
use gltf::json::Root;
use gltf::json::validation::Checked;

/// The base factors; what is out of range is taken as the nearest that is not.
pub(crate) fn read_material(root: &Root, index: usize) -> Result<Material, String> {
    let material = root.materials.get(index).ok_or_else(|| format!("there is no material {index}"))?;
    let fault = |e: String| format!("material {index}: {e}");
    if matches!(material.alpha_mode, Checked::Invalid) {
        return Err(fault("unknown alphaMode".to_owned()));
    }
    let pbr = &material.pbr_metallic_roughness;
    // Textures are not read, but a document that names one that it does not have is broken.
    let textures = [
        pbr.base_color_texture.as_ref().map(|t| t.index),
        pbr.metallic_roughness_texture.as_ref().map(|t| t.index),
        material.normal_texture.as_ref().map(|t| t.index),
        material.occlusion_texture.as_ref().map(|t| t.index),
        material.emissive_texture.as_ref().map(|t| t.index),
    ];
    for index in textures.into_iter().flatten().map(|index| index.value()) {
        let texture = root.textures.get(index).ok_or_else(|| fault(format!("there is no texture {index}")))?;
        let image = texture.source.value();
        // The document reader takes this number for a source that is not named.
        if image != u32::MAX as usize && image >= root.images.len() {
            return Err(fault(format!("texture {index}: there is no image {image}")));
        }
    }
    let [r, g, b, _] = pbr.base_color_factor.0;
    let unit = |x: f32| if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) };
    let base = Vec3::new(unit(r), unit(g), unit(b));
    let (metallic, roughness) = (unit(pbr.metallic_factor.0), unit(pbr.roughness_factor.0));
    Ok(MetallicRoughness::new(base, metallic, roughness).map_err(|e| fault(e.to_string()))?.into())
}
