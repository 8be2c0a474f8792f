//! Light from all around, in a scene file.

use crate::files::extension;
use crate::image_file;
use crate::scene_light::Around;
use crate::toml_reader::{Table, Value};
use glam::{UVec2, Vec3};
use lighting::EnvironmentMap;
use scene::SceneError;

/// Patches along each side of the environment's cube, where a scene does not say.
const PATCHES: u32 = 2;
const MOST_PATCHES: u32 = 16;

/// The picture of a light of kind "environment", and the patches along each side of its cube.
pub(crate) fn read_environment(t: &mut Table<'_>, around: &Around<'_>) -> Result<(EnvironmentMap, u32), SceneError> {
    let (kind, value) = t.one_of(&["file", "radiance"])?;
    let map = if kind == "radiance" { EnvironmentMap::uniform(value.color()?) } else { read_map(value, around)? };
    let strength = t.get("strength").map(|v| v.color()).transpose()?;
    let map = strength.map_or(map.clone(), |strength| map.scaled(strength));
    let up = t.get("up").map_or(Ok(Vec3::Y), |v| v.direction())?;
    let turn = t.get("turn").map_or(Ok(0.0), |v| v.number())?;
    let patches = t.get("patches").map_or(Ok(PATCHES), |v| v.whole(1, MOST_PATCHES))?;
    Ok((map.turned(up, turn), patches))
}

/// The largest number that half floats hold: brighter pixels of pictures that are kept in them are infinite.
const LARGEST_HALF: f32 = 65504.0;

fn read_map(value: Value<'_>, around: &Around<'_>) -> Result<EnvironmentMap, SceneError> {
    let (size, mut texels) = read_linear(value, around)?;
    let name = value.string().unwrap_or("");
    let notes = tame(&mut texels);
    let notes = stretched(size).into_iter().chain(notes);
    around.notes.borrow_mut().extend(notes.map(|note| format!("image \"{name}\": {note}")));
    EnvironmentMap::new(size, texels).map_err(|e| value.error(format!("image \"{name}\": {e}")))
}

/// A line about a picture that cannot be one of latitude and longitude: such are twice as wide as high. Gradients of few texels may have
/// any shape.
fn stretched(size: UVec2) -> Option<String> {
    const FEW: u32 = 4;
    let UVec2 { x, y } = size;
    let is_usual = y <= FEW || (1.9..=2.1).contains(&(f64::from(x) / f64::from(y)));
    (!is_usual).then(|| format!("is {x}x{y}, and a sky is twice as wide as high: it is stretched over the sphere"))
}

/// Replaces numbers that are no radiance; a line for each kind of them.
fn tame(texels: &mut [Vec3]) -> Vec<String> {
    let channels = || texels.iter().flat_map(|texel| texel.to_array());
    let brightest = channels().filter(|x| x.is_finite()).fold(LARGEST_HALF, f32::max);
    let largest = brightest.min(EnvironmentMap::BRIGHTEST);
    let (mut infinite, mut beyond, mut negative) = (0_usize, 0_usize, 0_usize);
    for texel in texels {
        let channels = texel.to_array();
        infinite += usize::from(channels.contains(&f32::INFINITY));
        beyond += usize::from(channels.iter().any(|x| x.is_finite() && *x > largest));
        negative += usize::from(channels.iter().any(|x| *x < 0.0));
        *texel = Vec3::from_array(channels.map(|x| if x > largest { largest } else { x }));
    }
    let mut notes = Vec::new();
    if infinite > 0 {
        notes.push(format!("{} infinite: taken as {largest}", pixels(infinite)));
    }
    if beyond > 0 {
        notes.push(format!("{} brighter than {largest:e}: taken as that", pixels(beyond)));
    }
    if negative > 0 {
        notes.push(format!("{} negative: taken as black", pixels(negative)));
    }
    notes
}

fn pixels(count: usize) -> String {
    if count == 1 { "1 pixel is".to_owned() } else { format!("{count} pixels are") }
}

/// The linear colours of an image file, the top row first.
pub(crate) fn read_linear(value: Value<'_>, around: &Around<'_>) -> Result<(UVec2, Vec<Vec3>), SceneError> {
    let name = value.string()?;
    let file = around.path.with_file_name("").join(name);
    let bytes = around.files.read(&file).map_err(|e| value.error(e))?;
    let mut notes = around.notes.borrow_mut();
    image_file::decode_linear(name, &extension(&file), &bytes, &mut notes, &around.files.budget)
        .map_err(|e| value.error(e))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_of_another_shape_are_told() {
        for (x, y, is_told) in
            [(64, 32, false), (63, 32, false), (1, 4, false), (24, 32, true), (192, 32, true), (5, 5, true)]
        {
            assert_eq!(stretched(UVec2::new(x, y)).is_some(), is_told, "{x} {y}");
        }
    }

    #[test]
    fn numbers_that_are_no_radiance_are_told() {
        let mut plain = vec![Vec3::splat(2e6), Vec3::ZERO];
        assert!(tame(&mut plain).is_empty());
        assert_eq!(plain[0], Vec3::splat(2e6));
        let mut odd = vec![Vec3::new(f32::INFINITY, 1.0, -2.0), Vec3::new(-f32::INFINITY, 3.0, 4.0)];
        let notes = tame(&mut odd);
        assert_eq!(odd[0].x, LARGEST_HALF);
        assert_eq!(notes.len(), 2);
        assert!(
            notes[0].starts_with("1 pixel is infinite") && notes[1].starts_with("2 pixels are negative"),
            "{notes:?}"
        );
        let mut huge = vec![Vec3::splat(1e30), Vec3::splat(f32::INFINITY)];
        assert_eq!(tame(&mut huge).len(), 2);
        assert_eq!(huge, [Vec3::splat(EnvironmentMap::BRIGHTEST); 2]);
    }
}
