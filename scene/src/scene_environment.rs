//! Light from all around, in a scene file.

use crate::SceneError;
use crate::files::extension;
use crate::image_file;
use crate::scene_light::Around;
use crate::toml_reader::{Table, Value};
use glam::{UVec2, Vec3};
use lighting::{Environment, EnvironmentMap};
use lobe_core::Sphere;

/// Patches along each side of the environment's cube, where a scene does not say.
const PATCHES: u32 = 2;
const MOST_PATCHES: u32 = 16;

/// Reads the rest of a light of kind "environment".
pub(crate) fn read_environment(t: &mut Table<'_>, around: &Around<'_>) -> Result<Environment, SceneError> {
    let (kind, value) = t.one_of(&["file", "radiance"])?;
    let map = if kind == "radiance" { EnvironmentMap::uniform(value.color()?) } else { read_map(value, around)? };
    let strength = t.get("strength").map(|v| v.color()).transpose()?;
    let map = strength.map_or(map.clone(), |strength| map.scaled(strength));
    let up = t.get("up").map_or(Ok(Vec3::Y), |v| v.nonzero_vec3())?;
    let turn = t.get("turn").map_or(Ok(0.0), |v| v.number())?;
    let patches = t.get("patches").map_or(Ok(PATCHES), |v| v.whole(1, MOST_PATCHES))?;
    let world = Sphere { center: around.bounds.center(), radius: around.bounds.radius() };
    Ok(Environment::new(map.turned(up, turn), patches, world))
}

fn read_map(value: Value<'_>, around: &Around<'_>) -> Result<EnvironmentMap, SceneError> {
    let (size, texels) = read_linear(value, around)?;
    EnvironmentMap::new(size, texels)
        .map_err(|e| value.error(format!("image \"{}\": {e}", value.string().unwrap_or(""))))
}

/// The linear colours of an image file, the top row first.
pub(crate) fn read_linear(value: Value<'_>, around: &Around<'_>) -> Result<(UVec2, Vec<Vec3>), SceneError> {
    let name = value.string()?;
    let file = around.path.with_file_name("").join(name);
    let bytes = around.files.read(&file).map_err(|e| value.error(e))?;
    image_file::decode_linear(name, &extension(&file), &bytes).map_err(|e| value.error(e))
}
