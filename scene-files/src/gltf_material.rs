//! Materials of a glTF document.

use crate::appearance::Appearance;
use crate::gltf_buffers::Buffers;
use crate::gltf_layers;
use crate::gltf_texture::{Images, Reference};
use crate::unit::unit;
use brdf::{Material, MaterialError, MetallicRoughness};
use glam::Vec3;
use gltf::json::material::{AlphaMode, Material as Document};
use gltf::json::validation::Checked;
use gltf::json::{Root, Value};
use scene::cut_out::CutOut;
use scene::{Channel, Encoding, Surface};

/// Reads a material, `written` with what its typed form leaves out; numbers out of range are taken as the nearest that are not.
pub(crate) fn read_material(
    root: &Root,
    index: usize,
    written: Option<&Value>,
    buffers: &Buffers<'_>,
    images: &mut Images<'_>,
) -> Result<Appearance, String> {
    let material = root.materials.get(index).ok_or_else(|| format!("there is no material {index}"))?;
    let mut of_material = || {
        let appearance = appearance(material, written, buffers, images)?;
        let extensions = written.and_then(|material| material.get("extensions"));
        // Not of surfaces that are not lit.
        let of = |name| extensions.filter(|_| !appearance.surface.is_unlit).and_then(|e| e.get(name));
        let (anisotropy, clearcoat) = (of("KHR_materials_anisotropy"), of("KHR_materials_clearcoat"));
        let appearance =
            anisotropy.map_or(Ok(appearance.clone()), |own| gltf_layers::brushed(own, appearance, buffers, images))?;
        clearcoat.map_or(Ok(appearance.clone()), |own| gltf_layers::coated(own, appearance, buffers, images))
    };
    of_material().map_err(|e: String| format!("material {index}: {e}"))
}

fn appearance(
    material: &Document,
    written: Option<&Value>,
    buffers: &Buffers<'_>,
    images: &mut Images<'_>,
) -> Result<Appearance, String> {
    let limit = alpha_limit(material, images)?;
    check_textures(material, images)?;
    if has_strange_numbers(material) {
        images.note("numbers of materials that are out of range are taken as the nearest that are not".to_owned());
    }
    let pbr = &material.pbr_metallic_roughness;
    let extensions = material.extensions.as_ref();
    let color = images.map(buffers, pbr.base_color_texture.as_ref().map(Into::into), Encoding::Srgb)?;
    let [r, g, b, factor] = pbr.base_color_factor.0;
    let cut_out = limit.map(|limit| CutOut { map: color.clone(), factor: unit(factor), limit });
    let base = Vec3::new(unit(r), unit(g), unit(b));
    if extensions.is_some_and(|e| e.unlit.is_some()) {
        let surface = Surface { emission: base, emission_map: color, is_unlit: true, ..Surface::default() };
        return Ok(Appearance { material: Material::lambert(Vec3::ZERO), surface, cut_out });
    }
    let numbers = images.map(buffers, pbr.metallic_roughness_texture.as_ref().map(Into::into), Encoding::Linear)?;
    let channel = |index| numbers.clone().map(|map| Channel { map, index });
    let normal = material.normal_texture.as_ref();
    // The typed form of a normal texture has no transform.
    let info = normal.zip(written).map(|(_, written)| gltf_layers::texture(written, "normalTexture")).transpose()?;
    let info = info.flatten();
    let reference = info.as_ref().map(Reference::from).or(normal.map(|n| Reference::new(n.index, n.tex_coord)));
    let normal_map = images.map(buffers, reference, Encoding::Linear)?;
    let scale = normal.map_or(1.0, |n| n.scale);
    if !scale.is_finite() {
        return Err(format!("normal texture has scale {scale}"));
    }
    let emission_map = images.map(buffers, material.emissive_texture.as_ref().map(Into::into), Encoding::Srgb)?;
    let metal = metal(material, base).map_err(|e| e.to_string())?;
    let specular = extensions.and_then(|e| e.specular.as_ref());
    let of_coat = specular.and_then(|s| s.specular_texture.as_ref()).map(Into::into);
    // Alpha is linear in either encoding: as the colour's, it may be one image with that.
    let of_coat = images.map(buffers, of_coat, Encoding::Srgb)?;
    let coat_color = specular.and_then(|s| s.specular_color_texture.as_ref()).map(Into::into);
    let surface = Surface {
        color,
        specular: images.map(buffers, coat_color, Encoding::Srgb)?,
        coat: of_coat.map(|map| Channel { map, index: 3 }),
        metallic: channel(2),
        roughness: channel(1),
        normal: normal_map.map(|map| (map, scale)),
        emission: emission(material),
        emission_map,
        ..Surface::default()
    };
    Ok(Appearance { material: metal.into(), surface, cut_out })
}

/// The alpha below which surfaces are cut out; `None` for opaque ones.
fn alpha_limit(material: &Document, images: &mut Images<'_>) -> Result<Option<f32>, String> {
    match material.alpha_mode {
        Checked::Invalid => Err("unknown alphaMode".to_owned()),
        Checked::Valid(AlphaMode::Opaque) => Ok(None),
        Checked::Valid(AlphaMode::Mask) => Ok(Some(cut_off(material.alpha_cutoff.map_or(0.5, |cutoff| cutoff.0)))),
        Checked::Valid(AlphaMode::Blend) => {
            images.note("surfaces that are blended are cut out where their alpha is below a half".to_owned());
            Ok(Some(0.5))
        }
    }
}

/// Refuses references to textures that do not exist, of those that mean nothing here, too.
fn check_textures(material: &Document, images: &Images<'_>) -> Result<(), String> {
    let pbr = &material.pbr_metallic_roughness;
    let specular = material.extensions.as_ref().and_then(|e| e.specular.as_ref());
    let textures = [
        specular.and_then(|s| s.specular_texture.as_ref()).map(|t| t.index),
        specular.and_then(|s| s.specular_color_texture.as_ref()).map(|t| t.index),
        pbr.base_color_texture.as_ref().map(|t| t.index),
        pbr.metallic_roughness_texture.as_ref().map(|t| t.index),
        material.normal_texture.as_ref().map(|t| t.index),
        material.occlusion_texture.as_ref().map(|t| t.index),
        material.emissive_texture.as_ref().map(|t| t.index),
    ];
    textures.into_iter().flatten().try_for_each(|index| images.source(index.value()).map(|_| ()))
}

/// Whether a factor, which the format wants in [0, 1], is not there.
fn has_strange_numbers(material: &Document) -> bool {
    let pbr = &material.pbr_metallic_roughness;
    let specular = material.extensions.as_ref().and_then(|e| e.specular.as_ref());
    let factors = [pbr.metallic_factor.0, pbr.roughness_factor.0, specular.map_or(1.0, |s| s.specular_factor.0)];
    let mut all = factors.iter().chain(&pbr.base_color_factor.0).chain(&material.emissive_factor.0);
    all.any(|x| !(0.0..=1.0).contains(x))
}

/// The emission, limited to [`MAX_EMISSION`].
fn emission(material: &Document) -> Vec3 {
    let strength = material.extensions.as_ref().and_then(|e| e.emissive_strength.as_ref());
    let strength = strength.map_or(1.0, |e| e.emissive_strength.0);
    let positive = |x: f32| if x > 0.0 { x.min(MAX_EMISSION) } else { 0.0 };
    Vec3::from_array(material.emissive_factor.0.map(unit).map(|e| positive(e * positive(strength))))
}

/// The metal or its dielectric, with the coat of `KHR_materials_ior` and `KHR_materials_specular`.
fn metal(material: &Document, base: Vec3) -> Result<MetallicRoughness, MaterialError> {
    let pbr = &material.pbr_metallic_roughness;
    let metal = MetallicRoughness::new(base, unit(pbr.metallic_factor.0), unit(pbr.roughness_factor.0))?;
    let extensions = material.extensions.as_ref();
    let ior = extensions.and_then(|e| e.ior.as_ref());
    let specular = extensions.and_then(|e| e.specular.as_ref());
    if ior.is_none() && specular.is_none() {
        return Ok(metal);
    }
    let n = ior.map_or(1.5, |ior| ior.ior.0);
    // An index below 1 is none, but 0 stands for a reflectance of 1.
    let n = if n == 0.0 { f32::INFINITY } else { n.max(1.0) };
    let normal = if n.is_finite() { ((n - 1.0) / (n + 1.0)).powi(2) } else { 1.0 };
    let weight = specular.map_or(1.0, |s| unit(s.specular_factor.0));
    let tint = specular.map_or([1.0; 3], |s| s.specular_color_factor.0);
    let f0 = Vec3::from_array(tint.map(|c| unit(normal * c.max(0.0)))) * weight;
    metal.with_coat(f0, weight)
}

fn cut_off(x: f32) -> f32 {
    if x > 0.0 { x } else { 0.0 }
}

/// The largest emission that is taken.
const MAX_EMISSION: f32 = 1e12;
