//! Extensions of glTF materials that the document reader does not know: KHR_materials_anisotropy and KHR_materials_clearcoat.

use crate::appearance::Appearance;
use crate::gltf_buffers::Buffers;
use crate::gltf_texture::{Images, Reference};
use crate::unit::unit;
use brdf::Material;
use gltf::json::Value;
use gltf::json::deserialize::from_value;
use gltf::json::texture::Info;
use scene::{Channel, Encoding, Surface};

/// An appearance with the clear coat that an extension's object says; numbers out of range are taken as the nearest that are not.
pub(crate) fn coated(
    clearcoat: &Value,
    appearance: Appearance,
    buffers: &Buffers<'_>,
    images: &mut Images<'_>,
) -> Result<Appearance, String> {
    let fault = |e: String| format!("KHR_materials_clearcoat: {e}");
    let [weight, roughness] = [number(clearcoat, "clearcoatFactor"), number(clearcoat, "clearcoatRoughnessFactor")];
    let (weight, roughness) = (unit(weight.map_err(fault)?), unit(roughness.map_err(fault)?));
    let mut channel = |name: &str, index: usize| {
        let Some(info) = texture(clearcoat, name)? else { return Ok(None) };
        images.source(info.index.value())?;
        let map = images.map(buffers, Some(Reference::from(&info)), Encoding::Linear)?;
        Ok(map.map(|map| Channel { map, index }))
    };
    let of_weight = channel("clearcoatTexture", 0).map_err(fault)?;
    let of_roughness = channel("clearcoatRoughnessTexture", 1).map_err(fault)?;
    let normal = normal_texture(clearcoat).map_err(fault)?;
    let scale = normal.as_ref().map_or(1.0, |(_, scale)| *scale);
    let reference = normal.as_ref().map(|(info, _)| info.into());
    let of_normal = images.map(buffers, reference, Encoding::Linear).map_err(fault)?;
    let Material::MetallicRoughness(metal) = appearance.material else { return Ok(appearance) };
    let metal = metal.with_clearcoat(weight, roughness).map_err(|e| fault(e.to_string()))?;
    if metal.clearcoat().is_none() {
        return Ok(Appearance { material: metal.into(), ..appearance });
    }
    let surface = Surface {
        clearcoat: of_weight,
        clearcoat_roughness: of_roughness,
        clearcoat_normal: of_normal.map(|map| (map, scale)),
        ..appearance.surface
    };
    Ok(Appearance { material: metal.into(), surface, ..appearance })
}

/// An appearance with the anisotropy that an extension's object says, in the same way.
pub(crate) fn brushed(
    anisotropy: &Value,
    appearance: Appearance,
    buffers: &Buffers<'_>,
    images: &mut Images<'_>,
) -> Result<Appearance, String> {
    let fault = |e: String| format!("KHR_materials_anisotropy: {e}");
    let strength = unit(number(anisotropy, "anisotropyStrength").map_err(fault)?);
    let turn = number(anisotropy, "anisotropyRotation").map_err(fault)?;
    let info = texture(anisotropy, "anisotropyTexture").map_err(fault)?;
    let map = info.as_ref().map(|info| {
        images.source(info.index.value())?;
        images.map(buffers, Some(Reference::from(info)), Encoding::Linear)
    });
    let map = map.transpose().map_err(fault)?.flatten();
    let Material::MetallicRoughness(metal) = appearance.material else { return Ok(appearance) };
    let metal = metal.with_anisotropy(strength).map_err(|e| fault(e.to_string()))?;
    if metal.anisotropy() == 0.0 {
        return Ok(Appearance { material: metal.into(), ..appearance });
    }
    let surface = Surface { anisotropy: map, anisotropy_turn: turn, follows_u: true, ..appearance.surface };
    Ok(Appearance { material: metal.into(), surface, ..appearance })
}

/// A number; 0 without one.
fn number(of: &Value, name: &str) -> Result<f32, String> {
    of.get(name).map_or(Ok(0.0), |value| finite(value, name))
}

fn finite(value: &Value, name: &str) -> Result<f32, String> {
    let number = value.as_f64().ok_or_else(|| format!("{name} is {value}: expected a number"))? as f32;
    if number.is_finite() { Ok(number) } else { Err(format!("{name} is {value}: expected a finite number")) }
}

/// The texture that an object names, with its transform.
pub(crate) fn texture(of: &Value, name: &str) -> Result<Option<Info>, String> {
    let read = |value: &Value| from_value(value.clone()).map_err(|e| format!("{name}: {e}"));
    of.get(name).map(read).transpose()
}

/// The normal texture of a coat, and its scale.
fn normal_texture(clearcoat: &Value) -> Result<Option<(Info, f32)>, String> {
    let name = "clearcoatNormalTexture";
    let Some(info) = texture(clearcoat, name)? else { return Ok(None) };
    let scale = clearcoat.get(name).and_then(|normal| normal.get("scale"));
    let scale = scale.map_or(Ok(1.0), |scale| finite(scale, "scale")).map_err(|e| format!("{name}: {e}"))?;
    Ok(Some((info, scale)))
}
