//! The materials of a scene file.

use crate::appearance::Appearance;
use crate::context::Context;
use crate::defaults::default_material;
use crate::files::{Source, extension};
use crate::image_file;
use crate::toml_reader::{Table, Value};
use brdf::{
    HalfVector, HalfVectorLobe, Lafortune, LafortuneLobe, Lambert, MAX_FITTED, Material, Merl, MetallicRoughness,
    ModifiedPhong, Neumann, Phong, fit,
};
use glam::{Affine2, Mat2, Vec2, Vec3};
use scene::cut_out::CutOut;
use scene::{Channel, Encoding, Object, SceneError, Surface, Texture, TextureMap, Wrap};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Images that the file's materials name, each decoded once for each encoding.
pub(crate) struct ImageFiles {
    files: Source,
    known: HashMap<(PathBuf, bool), Texture>,
}

impl ImageFiles {
    pub(crate) fn new(files: &Source) -> Self {
        Self { files: files.clone(), known: HashMap::new() }
    }

    fn texture(&mut self, value: Value<'_>, path: &Path, encoding: Encoding) -> Result<Texture, SceneError> {
        let name = value.string()?;
        let file = path.with_file_name("").join(name);
        let key = (file, encoding == Encoding::Srgb);
        if let Some(known) = self.known.get(&key) {
            return Ok(known.clone());
        }
        let bytes = self.files.read(&key.0).map_err(|e| value.error(e))?;
        let texture = image_file::decode(name, &extension(&key.0), &bytes, encoding, &self.files.budget)
            .map_err(|e| value.error(e))?;
        self.known.insert(key, texture.clone());
        Ok(texture)
    }
}

/// The materials so far, by number and by name.
#[derive(Default)]
pub(crate) struct Materials {
    pub(crate) all: Vec<Appearance>,
    pub(crate) names: HashMap<String, usize>,
    default: Option<usize>,
}

impl Materials {
    pub(crate) fn push(&mut self, appearance: Appearance) -> usize {
        self.all.push(appearance);
        self.all.len() - 1
    }

    /// The number of the material that a key names.
    pub(crate) fn named(&self, key: Value<'_>) -> Result<usize, SceneError> {
        let name = key.string()?;
        self.names.get(name).copied().ok_or_else(|| key.error(format!("there is no [materials.{name}]")))
    }

    /// The alpha mask of a material's surfaces; `None` if they are opaque.
    pub(crate) fn cut_out(&self, material: usize) -> Option<&CutOut> {
        self.all[material].cut_out.as_ref()
    }

    /// Textures and emission of an object.
    pub(crate) fn surface(&self, object: &Object) -> &Surface {
        &self.all[object.material].surface
    }

    pub(crate) fn fallback(&mut self) -> usize {
        if let Some(index) = self.default {
            return index;
        }
        let index = self.push(default_material().into());
        *self.default.insert(index)
    }
}

/// Reads one of `[materials]`; `path` is the scene file, which images are looked for beside.
pub(crate) fn read_material(
    t: Table<'_>,
    path: &Path,
    images: &mut ImageFiles,
    context: &mut Context,
) -> Result<Appearance, SceneError> {
    let mut reader = Reader { t, surface: Surface::default(), maps: Maps { path, images } };
    reader.common()?;
    let model = reader.t.require("model")?;
    let material: Material = match model.string()? {
        "lambert" => Lambert { albedo: reader.base("albedo", true)? }.into(),
        name @ ("phong" | "modified-phong" | "neumann") => reader.phong(name)?,
        "lafortune" => reader.lafortune()?.into(),
        "half-vector" => reader.half_vector()?.into(),
        "merl" => {
            let file = reader.t.require("file")?;
            let lobes = reader.t.get("lobes").map_or(Ok(2), |v| v.whole(1, MAX_FITTED as u32))?;
            measured(file, lobes as usize, path, context)?
        }
        "metallic-roughness" => reader.metallic_roughness(model)?.into(),
        other => {
            return Err(model.error(format!(
                "unknown model \"{other}\": expected \"lambert\", \"phong\", \"modified-phong\", \"neumann\", \
                 \"lafortune\", \"half-vector\", \"merl\" or \"metallic-roughness\""
            )));
        }
    };
    let Reader { mut t, surface, .. } = reader;
    let cut_out = t.get("alpha_cutoff").map(|v| cut_out(v, surface.color.as_ref())).transpose()?;
    t.finish()?;
    Ok(Appearance { material, surface, cut_out })
}

/// The table of a material, and the surface that it describes so far.
struct Reader<'a, 's> {
    t: Table<'s>,
    surface: Surface,
    maps: Maps<'a>,
}

impl<'s> Reader<'_, 's> {
    /// The maps that all models have, and emission.
    fn common(&mut self) -> Result<(), SceneError> {
        self.surface.color = self.map("color_map", Encoding::Srgb)?;
        self.surface.normal = self.normal("normal_map")?;
        self.surface.emission_map = self.map("emission_map", Encoding::Srgb)?;
        let emission = self.t.get("emission").map(|v| v.color()).transpose()?;
        // Without an `emission`, the map alone gives the radiance.
        let alone = if self.surface.emission_map.is_some() { Vec3::ONE } else { Vec3::ZERO };
        self.surface.emission = emission.unwrap_or(alone);
        Ok(())
    }

    fn map(&mut self, key: &'static str, encoding: Encoding) -> Result<Option<TextureMap>, SceneError> {
        self.t.get(key).map(|v| self.maps.map(v, encoding, |_| Ok(()))).transpose()
    }

    fn channel(&mut self, key: &'static str) -> Result<Option<Channel>, SceneError> {
        self.t.get(key).map(|v| self.maps.channel(v)).transpose()
    }

    fn normal(&mut self, key: &'static str) -> Result<Option<(TextureMap, f32)>, SceneError> {
        self.t.get(key).map(|v| self.maps.normal(v)).transpose()
    }

    fn number(&mut self, key: &'static str, default: f32) -> Result<f32, SceneError> {
        self.t.get(key).map_or(Ok(default), |v| v.number())
    }

    /// The colour that the map of colours multiplies: a map alone is the colour.
    fn base(&mut self, key: &'static str, is_required: bool) -> Result<Vec3, SceneError> {
        match self.t.get(key) {
            Some(v) => v.color(),
            None if self.surface.color.is_some() => Ok(Vec3::ONE),
            None if is_required => self.t.require(key)?.color(),
            None => Ok(Vec3::ZERO),
        }
    }

    fn lobes<T>(&mut self, read: impl Fn(Value<'s>) -> Result<T, SceneError>) -> Result<Vec<T>, SceneError> {
        let elements = self.t.get("lobes").map_or(Ok(Vec::new()), |v| v.elements("an array of lobes"))?;
        elements.into_iter().map(read).collect()
    }

    /// The maps of highlights that have an exponent.
    fn exponents(&mut self) -> Result<(), SceneError> {
        self.surface.specular = self.map("specular_map", Encoding::Srgb)?;
        self.surface.exponent = self.channel("exponent_map")?;
        Ok(())
    }

    fn phong(&mut self, name: &str) -> Result<Material, SceneError> {
        let kd = self.base("kd", false)?;
        let scale = self.t.get("ks").map(|v| v.color()).transpose()?;
        self.exponents()?;
        let ks = scale.unwrap_or(if self.surface.specular.is_some() { Vec3::ONE } else { Vec3::ZERO });
        let exponent = self.t.require("exponent")?.number()?;
        Ok(match name {
            "phong" => Phong { kd, ks, exponent }.into(),
            "neumann" => Neumann { kd, ks, exponent }.into(),
            _ => ModifiedPhong { kd, ks, exponent }.into(),
        })
    }

    fn lafortune(&mut self) -> Result<Lafortune, SceneError> {
        let diffuse = self.base("diffuse", false)?;
        let lobes = self.lobes(lafortune_lobe)?;
        self.exponents()?;
        if let Some(v) = self.t.get("frame") {
            self.surface.follows_u = match v.string()? {
                "normal" => false,
                "texture" => true,
                _ => return Err(v.error("expected \"normal\" or \"texture\"")),
            };
        }
        Ok(Lafortune { diffuse, lobes })
    }

    fn half_vector(&mut self) -> Result<HalfVector, SceneError> {
        let diffuse = self.base("diffuse", false)?;
        let lobes = self.lobes(half_vector_lobe)?;
        self.surface.specular = self.map("specular_map", Encoding::Srgb)?;
        self.surface.roughness = self.channel("roughness_map")?;
        Ok(HalfVector { diffuse, lobes })
    }

    fn metallic_roughness(&mut self, model: Value<'_>) -> Result<MetallicRoughness, SceneError> {
        let base = self.base("base", true)?;
        let (metallic, roughness) = (self.number("metallic", 1.0)?, self.number("roughness", 1.0)?);
        self.surface.metallic = self.channel("metallic_map")?;
        self.surface.roughness = self.channel("roughness_map")?;
        self.surface.specular = self.map("specular_map", Encoding::Srgb)?;
        self.surface.coat = self.channel("coat_map")?;
        let mut metal = MetallicRoughness::new(base, metallic, roughness).map_err(|e| model.error(e))?;
        if let Some(ior) = self.t.get("ior") {
            let n = ior.number()?;
            if n.is_nan() || n < 1.0 {
                return Err(ior.error(format!("{n} must be at least 1")));
            }
            let f0 = ((n - 1.0) / (n + 1.0)).powi(2);
            metal = metal.with_coat(Vec3::splat(f0), 1.0).map_err(|e| ior.error(e))?;
        }
        if let Some(strength) = self.t.get("anisotropy") {
            metal = metal.with_anisotropy(strength.number()?).map_err(|e| strength.error(e))?;
            self.surface.anisotropy_turn = self.number("anisotropy_rotation", 0.0)?.to_radians();
            self.surface.anisotropy = self.map("anisotropy_map", Encoding::Linear)?;
            self.surface.follows_u = metal.anisotropy() > 0.0;
        }
        self.clearcoat(metal)
    }

    /// A clear coat above a material, if there is one.
    fn clearcoat(&mut self, metal: MetallicRoughness) -> Result<MetallicRoughness, SceneError> {
        let Some(weight) = self.t.get("clearcoat") else { return Ok(metal) };
        let roughness = self.number("clearcoat_roughness", 0.0)?;
        self.surface.clearcoat = self.channel("clearcoat_map")?;
        self.surface.clearcoat_roughness = self.channel("clearcoat_roughness_map")?;
        self.surface.clearcoat_normal = self.normal("clearcoat_normal_map")?;
        metal.with_clearcoat(weight.number()?, roughness).map_err(|e| weight.error(e))
    }
}

/// Fits lobes to a table of measurements beside the scene file; a warning states their kind and their error.
fn measured(file: Value<'_>, lobes: usize, path: &Path, context: &mut Context) -> Result<Material, SceneError> {
    let bytes = context.files.read(&path.with_file_name("").join(file.string()?)).map_err(|e| file.error(e))?;
    let table = Merl::read(&bytes).map_err(|e| file.error(e))?;
    let fitted = fit(|i, o| table.eval(i, o), lobes).map_err(|e| file.error(e))?;
    let (name, percent) = (file.string()?, 100.0 * fitted.residual);
    let kind = if matches!(fitted.model, Material::HalfVector(_)) { "half-vector" } else { "Lafortune" };
    let plural = if lobes == 1 { "" } else { "s" };
    context.warn(
        path,
        format!(
            "{name}: a fit by {lobes} {kind} lobe{plural} is {percent:.0} % off (root mean square, weighted by cosines)"
        ),
    );
    Ok(fitted.model)
}

/// The part of a surface where the colour's image is opaque.
fn cut_out(value: Value<'_>, color: Option<&TextureMap>) -> Result<CutOut, SceneError> {
    let limit = value.number()?;
    if !(0.0..=1.0).contains(&limit) {
        return Err(value.error(format!("{limit} must lie in [0, 1]")));
    }
    let map = color.ok_or_else(|| value.error("expected a color_map, whose alpha it cuts at"))?;
    Ok(CutOut { map: Some(map.clone()), factor: 1.0, limit })
}

fn lafortune_lobe(value: Value<'_>) -> Result<LafortuneLobe, SceneError> {
    let mut t = value.table()?;
    let (exponent, scale) = (t.require("exponent")?.number()?, t.require("scale")?.color()?);
    let lobe = match t.one_of(&["c", "matrix"])? {
        ("c", c) => LafortuneLobe::diagonal(c.vec3()?, exponent, scale),
        (_, m) => LafortuneLobe::new(m.mat3()?, exponent, scale),
    };
    t.finish()?;
    lobe.validate().map_err(|e| value.error(e))?;
    Ok(lobe)
}

fn half_vector_lobe(value: Value<'_>) -> Result<HalfVectorLobe, SceneError> {
    let mut t = value.table()?;
    let roughness = t.require("roughness")?;
    let f0 = t.require("f0")?.color()?;
    let f90 = t.get("f90").map_or(Ok(Vec3::ONE), |v| v.color())?;
    let number = roughness.number()?;
    if !(0.0..=1.0).contains(&number) {
        return Err(roughness.error(format!("{number} must lie in [0, 1]")));
    }
    t.finish()?;
    Ok(HalfVectorLobe::new(number, f0, f90))
}

/// Reads references to images.
struct Maps<'a> {
    path: &'a Path,
    images: &'a mut ImageFiles,
}

impl Maps<'_> {
    fn channel(&mut self, value: Value<'_>) -> Result<Channel, SceneError> {
        let mut index = 0;
        let map = self.map(value, Encoding::Linear, |t| {
            if let Some(v) = t.get("channel") {
                index = match v.string()? {
                    "red" => 0,
                    "green" => 1,
                    "blue" => 2,
                    "alpha" => 3,
                    _ => return Err(v.error("expected \"red\", \"green\", \"blue\" or \"alpha\"")),
                };
            }
            Ok(())
        })?;
        Ok(Channel { map, index })
    }

    fn normal(&mut self, value: Value<'_>) -> Result<(TextureMap, f32), SceneError> {
        let mut strength = 1.0;
        let map = self.map(value, Encoding::Linear, |t| {
            strength = t.get("strength").map_or(Ok(1.0), |v| v.number())?;
            Ok(())
        })?;
        Ok((map, strength))
    }

    /// A file's name, or a table with it and how it lies; `more` asks for keys that not all have.
    fn map(
        &mut self,
        value: Value<'_>,
        encoding: Encoding,
        more: impl FnOnce(&mut Table<'_>) -> Result<(), SceneError>,
    ) -> Result<TextureMap, SceneError> {
        if value.is_string() {
            return Ok(TextureMap::new(self.images.texture(value, self.path, encoding)?));
        }
        let mut t = value.table().map_err(|_| value.error("expected a file's name, or { file = … }"))?;
        let file = t.require("file")?;
        let scale = t.get("scale").map_or(Ok(Vec2::ONE), |v| v.vec2_or_number())?;
        let offset = t.get("offset").map_or(Ok(Vec2::ZERO), |v| v.vec2())?;
        let degrees = t.get("rotate").map_or(Ok(0.0), |v| v.number())?;
        let wrap = match t.get("wrap").map(|v| v.string().map(|name| (v, name))).transpose()? {
            None | Some((_, "repeat")) => Wrap::Repeat,
            Some((_, "mirror")) => Wrap::Mirror,
            Some((_, "clamp")) => Wrap::Clamp,
            Some((v, _)) => return Err(v.error("expected \"repeat\", \"mirror\" or \"clamp\"")),
        };
        let is_pixelated = match t.get("filter").map(|v| v.string().map(|name| (v, name))).transpose()? {
            None | Some((_, "linear")) => false,
            Some((_, "nearest")) => true,
            Some((v, _)) => return Err(v.error("expected \"linear\" or \"nearest\"")),
        };
        let uv_set = t.get("uv").map_or(Ok(0), |v| v.whole(0, 255))? as usize;
        more(&mut t)?;
        t.finish()?;
        let texture = self.images.texture(file, self.path, encoding)?;
        let matrix2 = Mat2::from_diagonal(scale) * Mat2::from_angle(degrees.to_radians());
        let transform = Affine2 { matrix2, translation: offset };
        Ok(TextureMap { texture, uv_set, transform, wrap: [wrap; 2], is_pixelated })
    }
}
