//! Clear coats and anisotropy of glTF files.

use crate::gltf_tests::triangle;
use brdf::{Material, MetallicRoughness};
use glam::Vec3;
use scene::Surface;

/// The material of a triangle with an extension of these fields, beside an image of one colour; and the warnings.
fn read(extension: &str, color: [u8; 4], fields: &str) -> Result<(Material, Surface, Vec<String>), String> {
    let folder = tempfile::tempdir().unwrap();
    image::RgbaImage::from_pixel(2, 2, image::Rgba(color)).save(folder.path().join("c.png")).unwrap();
    let own = r#"{"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.4, 0.2, 1], "metallicFactor": 0}}"#;
    let extended = format!(r#"{}, "extensions": {{"{extension}": {{{fields}}}}}}}"#, &own[..own.len() - 1]);
    let images = r#", "textures": [{"source": 0}], "images": [{"uri": "c.png"}]"#;
    let path = folder.path().join("m.gltf");
    std::fs::write(&path, triangle(r#"[{"mesh": 0}]"#, images).replace(own, &extended)).unwrap();
    let (scene, warnings) = crate::load_with_warnings(&path).map_err(|e| e.to_string())?;
    let number = scene.objects[1].material;
    Ok((scene.materials[number].clone(), scene.surface(number).cloned().unwrap_or_default(), warnings))
}

/// KHR_materials_clearcoat: red is the weight, green the roughness, and the normal map is the coat's own.
#[test]
fn clear_coats_are_read() {
    let read = |fields: &str| {
        let (material, surface, warnings) = read("KHR_materials_clearcoat", [51, 102, 255, 255], fields)?;
        assert!(warnings.iter().all(|w| w.contains("no texture coordinates")), "{warnings:?}");
        Ok::<_, String>((material, surface))
    };
    let plain = MetallicRoughness::new(Vec3::new(0.8, 0.4, 0.2), 0.0, 1.0).unwrap();
    let coated = |weight, roughness| -> Material { plain.clone().with_clearcoat(weight, roughness).unwrap().into() };
    let (material, surface) = read(r#""clearcoatFactor": 0.5, "clearcoatRoughnessFactor": 0.25"#).unwrap();
    assert!(material == coated(0.5, 0.25) && surface.is_plain(), "{material:?}");
    // Out of range, and without a weight.
    assert_eq!(read(r#""clearcoatFactor": 2"#).unwrap().0, coated(1.0, 0.0));
    let (material, surface) = read(r#""clearcoatRoughnessFactor": 0.5, "clearcoatTexture": {"index": 0}"#).unwrap();
    assert!(material == plain.clone().into() && surface.is_plain(), "{material:?}");
    let fields = r#""clearcoatFactor": 1, "clearcoatTexture": {"index": 0}, "clearcoatRoughnessFactor": 0.5,
        "clearcoatRoughnessTexture": {"index": 0}, "clearcoatNormalTexture": {"index": 0, "scale": 0.5}"#;
    let (material, surface) = read(fields).unwrap();
    let got = material.scaled(&surface.factors(&|_| scene::TexturePlace::default()));
    let Material::MetallicRoughness(got) = got else { panic!("{got:?}") };
    let (weight, roughness) = got.clearcoat().unwrap();
    assert!((weight - 0.2).abs() < 1e-6 && (roughness - 0.2).abs() < 1e-6, "{weight} {roughness}");
    let normal = surface.clearcoat_normal(&|_| scene::TexturePlace::default()).unwrap();
    assert!((normal - Vec3::new(-0.3, -0.1, 1.0)).length() < 1e-5 && surface.normal.is_none(), "{normal}");
    for (fields, words) in [
        (r#""clearcoatFactor": "much""#, "clearcoatFactor is \"much\": expected a number"),
        (r#""clearcoatFactor": 1, "clearcoatTexture": {"index": -1}"#, "clearcoatTexture: "),
        (r#""clearcoatFactor": 1, "clearcoatNormalTexture": {}"#, "clearcoatNormalTexture: "),
    ] {
        let message = read(fields).unwrap_err();
        assert!(message.contains("material 0: KHR_materials_clearcoat: ") && message.contains(words), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
}

/// KHR_materials_anisotropy: red and green are a direction, blue is the strength.
#[test]
fn anisotropy_is_read() {
    let read = |fields: &str| {
        let (material, surface, _) = read("KHR_materials_anisotropy", [0, 255, 51, 255], fields)?;
        Ok::<_, String>((material, surface))
    };
    let plain = MetallicRoughness::new(Vec3::new(0.8, 0.4, 0.2), 0.0, 1.0).unwrap();
    let place = |_: usize| scene::TexturePlace::default();
    let (material, surface) = read(r#""anisotropyStrength": 0.5, "anisotropyRotation": 1"#).unwrap();
    assert_eq!(material, plain.clone().with_anisotropy(0.5).unwrap().into());
    assert!(surface.follows_u && (surface.grain(&place) - glam::Vec2::from_angle(1.0)).length() < 1e-6);
    let (material, surface) = read(r#""anisotropyTexture": {"index": 0}"#).unwrap();
    assert!(material == plain.into() && !surface.follows_u, "no strength");
    let (material, surface) = read(r#""anisotropyStrength": 1, "anisotropyTexture": {"index": 0}"#).unwrap();
    let Material::MetallicRoughness(got) = material.scaled(&surface.factors(&place)) else { panic!("{material:?}") };
    assert!((got.anisotropy() - 0.2).abs() < 1e-6);
    assert!((surface.grain(&place) - glam::Vec2::new(-1.0, 1.0)).length() < 1e-5, "{}", surface.grain(&place));
    for (fields, words) in [
        (r#""anisotropyStrength": []"#, "anisotropyStrength is []: expected a number"),
        (r#""anisotropyStrength": 1, "anisotropyTexture": {"index": 7}"#, "there is no texture 7"),
    ] {
        let message = read(fields).unwrap_err();
        assert!(message.contains("material 0: KHR_materials_anisotropy: ") && message.contains(words), "{message}");
    }
}

/// KHR_texture_transform of normal textures, which their typed forms leave out.
#[test]
fn transforms_of_normal_textures_are_read() {
    let transform =
        r#""extensions": {"KHR_texture_transform": {"scale": [2, 3], "offset": [0.1, 0.2], "texCoord": 1}}"#;
    let plain = r#"{"index": 0, "scale": 0.5}"#;
    let moved = format!(r#"{{"index": 0, "scale": 0.5, {transform}}}"#);
    for is_moved in [false, true] {
        let normal = if is_moved { &moved } else { plain };
        let coat =
            format!(r#""clearcoatFactor": 1, "clearcoatNormalTexture": {normal}}}}}, "normalTexture": {normal}"#);
        // The braces of the extension and of all of them are closed already.
        let coat = format!("{coat}, \"extras\": {{\"a\": {{");
        let (_, surface, _) = read("KHR_materials_clearcoat", [51, 102, 255, 255], &coat).unwrap();
        for (map, scale) in [surface.normal, surface.clearcoat_normal].map(Option::unwrap) {
            let origin = map.transform.transform_point2(glam::Vec2::ZERO);
            let unit = map.transform.transform_vector2(glam::Vec2::ONE);
            let want = if is_moved { [[0.1, 0.2], [2.0, 3.0]] } else { [[0.0; 2], [1.0; 2]] };
            assert_eq!([origin.to_array(), unit.to_array()], want);
            assert_eq!((map.uv_set, scale), (usize::from(is_moved), 0.5));
        }
    }
}
