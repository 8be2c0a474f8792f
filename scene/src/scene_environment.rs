//! Light from all around, in a scene file.

use crate::files;
use crate::image_file;
use crate::toml_reader::{Table, Value};
use crate::{Bounds, SceneError};
use glam::{UVec2, Vec3};
use lighting::{Environment, EnvironmentMap};
use lobe_core::Sphere;
use std::path::Path;

/// Patches along each side of the environment's cube, where a scene does not say.
const PATCHES: u32 = 2;
const MOST_PATCHES: u32 = 16;

/// Reads the rest of a light of kind "environment".
pub(crate) fn read_environment(t: &mut Table<'_>, path: &Path, bounds: &Bounds) -> Result<Environment, SceneError> {
    let (kind, value) = t.one_of(&["file", "radiance"])?;
    let map = if kind == "radiance" { EnvironmentMap::uniform(value.color()?) } else { read_map(value, path)? };
    let strength = t.get("strength").map(|v| v.color()).transpose()?;
    let map = strength.map_or(map.clone(), |strength| map.scaled(strength));
    let up = t.get("up").map_or(Ok(Vec3::Y), |v| v.nonzero_vec3())?;
    let turn = t.get("turn").map_or(Ok(0.0), |v| v.number())?;
    let patches = t.get("patches").map_or(Ok(PATCHES), |v| v.whole(1, MOST_PATCHES))?;
    let world = Sphere { center: bounds.center(), radius: bounds.radius() };
    Ok(Environment::new(map.turned(up, turn), patches, world))
}

fn read_map(value: Value<'_>, path: &Path) -> Result<EnvironmentMap, SceneError> {
    let (size, texels) = read_linear(value, path)?;
    EnvironmentMap::new(size, texels)
        .map_err(|e| value.error(format!("image \"{}\": {e}", value.string().unwrap_or(""))))
}

/// The linear colours of an image file, the top row first.
pub(crate) fn read_linear(value: Value<'_>, path: &Path) -> Result<(UVec2, Vec<Vec3>), SceneError> {
    let name = value.string()?;
    let file = path.with_file_name("").join(name);
    let bytes = files::read(&file).map_err(|e| value.error(e))?;
    image_file::decode_linear(name, &files::extension(&file), &bytes).map_err(|e| value.error(e))
}
