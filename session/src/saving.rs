//! Changes of a session written back into the scene file that it was opened from.

mod entries;
mod lights;
mod objects;
mod values;

use self::entries::{put_in_list, table};
use self::lights::lights;
use self::objects::objects;
use self::values::{color, number, place, put, vector};
use crate::{LightItem, MaterialItem, ObjectItem, Snapshot, lamp};
use brdf::Material;
use core::fmt;
use glam::Vec3;
use scene::{Projection, SceneError};
use scene_files::{Disk, Files};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use toml_edit::{DocumentMut, Item, Table, TableLike, Value};

/// Why changes were not saved. The file is then as it was.
#[derive(Debug)]
#[non_exhaustive]
pub enum SaveError {
    /// A change that a scene file cannot hold in the way that this one is written.
    Change(String),
    /// The text is no scene file (any more).
    Text(String),
    /// The scene that the new text means is refused.
    Scene(SceneError),
    /// The disk refuses.
    Io(io::Error),
}

impl fmt::Display for SaveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Change(what) => write!(f, "not saved: {what}"),
            Self::Text(what) => write!(f, "not saved: the file is no scene file: {what}"),
            Self::Scene(error) => write!(f, "not saved: {error}"),
            Self::Io(error) => write!(f, "not saved: {error}"),
        }
    }
}

impl core::error::Error for SaveError {}

fn change(what: impl Into<String>) -> SaveError {
    SaveError::Change(what.into())
}

/// Writes the changes from one snapshot to another into the scene file that the first one was loaded from. Comments, the order of keys
/// and all that has not changed stay as they are.
///
/// The camera, the size of the picture, lights, materials, and how objects stand, are seen and block are saved, and lights, spheres and boxes
/// that came and all that went; settings are not part of a scene. The new text is read before it is written, and must give this scene.
///
/// Returns the new snapshot with its lights in the order of the file, for the next time: new lights stand before those of objects
/// that emit.
///
/// # Errors
/// [`SaveError`]; the file is then as it was.
pub fn save(path: &Path, before: &Snapshot, now: &Snapshot) -> Result<Snapshot, SaveError> {
    let text = std::fs::read_to_string(path).map_err(SaveError::Io)?;
    let (text, now) = changed(&text, before, now)?;
    check(path, &text, &now)?;
    // Beside it first: a full disk leaves the old one.
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".new");
    let new = path.with_file_name(name);
    let written = std::fs::write(&new, text).and_then(|()| std::fs::rename(&new, path));
    written.map(|()| now).map_err(|error| {
        let _ = std::fs::remove_file(&new);
        SaveError::Io(error)
    })
}

/// The text of a scene file with the changes from one snapshot to another.
///
/// # Errors
/// [`SaveError`].
pub fn changed_text(text: &str, before: &Snapshot, now: &Snapshot) -> Result<String, SaveError> {
    changed(text, before, now).map(|(text, _)| text)
}

/// The text, and the scene with its lights in their order there.
fn changed(text: &str, before: &Snapshot, now: &Snapshot) -> Result<(String, Snapshot), SaveError> {
    let mut document: DocumentMut =
        text.parse().map_err(|e: toml_edit::TomlError| SaveError::Text(e.message().to_owned()))?;
    if before.size != now.size {
        let image = table(document.as_table_mut(), "image")?;
        put(image, "width", Value::from(i64::from(now.size[0])));
        put(image, "height", Value::from(i64::from(now.size[1])));
    }
    if before.camera != now.camera && !now.is_camera_animated {
        camera(table(document.as_table_mut(), "camera")?, before, now);
    }
    materials(&mut document, before, now)?;
    let (lights, light_cuts) = lights(&mut document, before, now)?;
    let (objects, object_cuts) = objects(&mut document, before, now)?;
    let cuts = Cuts { lights: light_cuts, objects: object_cuts };
    Ok((document.to_string(), Snapshot { lights, objects, cuts, ..now.clone() }))
}

/// Entries that savings have removed from the file: undo may bring them back.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cuts {
    lights: Vec<Cut<LightItem>>,
    objects: Vec<Cut<ObjectItem>>,
}

/// A removed entry, with the items that it gave.
#[derive(Clone, Debug)]
struct Cut<T> {
    items: Vec<T>,
    table: Table,
}

/// The items in the order in which the file gives them, and the entries that it no longer has.
type Order<T> = (Vec<T>, Vec<Cut<T>>);

fn camera(to: &mut dyn TableLike, before: &Snapshot, now: &Snapshot) {
    let (old, new) = (&before.camera, &now.camera);
    put(to, "eye", place(new.eye, now.origin));
    put(to, "target", place(new.target, now.origin));
    if old.up != new.up {
        put(to, "up", vector(new.up));
    }
    if old.projection == new.projection {
        return;
    }
    let is_other = old.projection.name() != new.projection.name();
    if is_other {
        put(to, "projection", Value::from(new.projection.name()));
    }
    let (key, value) = match new.projection {
        Projection::Perspective { vertical_fov } => ("fov", Some(vertical_fov.to_degrees())),
        Projection::Orthographic { height } => ("height", Some(height)),
        Projection::Panoramic => ("", None),
    };
    ["fov", "height"].into_iter().filter(|other| *other != key).for_each(|other| drop(to.remove(other)));
    if let Some(value) = value {
        put(to, key, number(value));
    }
}

fn materials(document: &mut DocumentMut, before: &Snapshot, now: &Snapshot) -> Result<(), SaveError> {
    for (place, (old, new)) in before.materials.iter().zip(&now.materials).enumerate() {
        if old.material == new.material {
            continue;
        }
        let named = document.get_mut("materials").and_then(Item::as_table_like_mut);
        let entry = named.and_then(|all| all.iter_mut().nth(place).map(|(_, item)| item));
        let Some(entry) = entry.and_then(Item::as_table_like_mut) else {
            return Err(change(format!("material {place} is not of the scene file, but of a model in it")));
        };
        material(entry, new)?;
    }
    Ok(())
}

fn material(to: &mut dyn TableLike, new: &MaterialItem) -> Result<(), SaveError> {
    match &new.material {
        Material::Lambert(lambert) => put(to, "albedo", color(lambert.albedo)),
        Material::Phong(phong) => phong_keys(to, phong.kd, phong.ks, phong.exponent),
        Material::ModifiedPhong(phong) => phong_keys(to, phong.kd, phong.ks, phong.exponent),
        Material::Neumann(metal) => phong_keys(to, metal.kd, metal.ks, metal.exponent),
        Material::MetallicRoughness(metal) => {
            let (base, _, roughness) = metal.base();
            put(to, "base", color(base));
            put(to, "roughness", number(roughness));
        }
        Material::Lafortune(all) => {
            put(to, "diffuse", color(all.diffuse));
            for (number_of, lobe) in all.lobes.iter().enumerate() {
                put_in_list(to, "lobes", number_of, "exponent", number(lobe.exponent()))?;
            }
        }
        Material::HalfVector(all) => {
            put(to, "diffuse", color(all.diffuse));
            for (number_of, lobe) in all.lobes.iter().enumerate() {
                put_in_list(to, "lobes", number_of, "roughness", number(lobe.roughness()))?;
            }
        }
        other => return Err(change(format!("a material of the model {} has no keys", other.name()))),
    }
    Ok(())
}

fn phong_keys(to: &mut dyn TableLike, kd: Vec3, ks: Vec3, exponent: f32) {
    // A key that is missing has a default, or an image in its place: it stays so where that is the number.
    for (key, value) in [("kd", kd), ("ks", ks)] {
        if to.contains_key(key) || ![Vec3::ZERO, Vec3::ONE].contains(&value) {
            put(to, key, color(value));
        }
    }
    put(to, "exponent", number(exponent));
}

/// The files of the disk, but for one whose text is another.
struct Overlay {
    path: PathBuf,
    text: String,
}

impl Files for Overlay {
    fn read(&self, path: &Path) -> Result<Vec<u8>, io::Error> {
        if path == self.path { Ok(self.text.clone().into_bytes()) } else { Disk.read(path) }
    }
}

/// Whether a text is read as this scene.
fn check(path: &Path, text: &str, now: &Snapshot) -> Result<(), SaveError> {
    let files = Overlay { path: path.to_owned(), text: text.to_owned() };
    let (scene, animation, _) = scene_files::load_from(Arc::new(files), path, None).map_err(SaveError::Scene)?;
    let wrong = |what: &str| Err(change(format!("the file would give another {what}")));
    let extent = now.bounds().radius().max(1e-6);
    let is_near = |a: Vec3, b: Vec3| (a - b).abs().max_element() <= 1e-4 * (extent + b.length());
    let is_moving = now.time != 0.0;
    if [scene.width, scene.height] != now.size || scene.lights.len() != now.lights.len() {
        return wrong("picture, or other lights");
    }
    let is_same_projection = match (scene.camera.projection, now.camera.projection) {
        (Projection::Perspective { vertical_fov: a }, Projection::Perspective { vertical_fov: b })
        | (Projection::Orthographic { height: a }, Projection::Orthographic { height: b }) => (a - b).abs() <= 1e-4 * b,
        (a, b) => a == b,
    };
    let is_same_camera = is_same_projection
        && is_near(scene.camera.eye, now.camera.eye)
        && is_near(scene.camera.target, now.camera.target);
    if !is_same_camera && !animation.moves_camera() {
        return wrong("camera");
    }
    for (light, item) in scene.lights.iter().zip(&now.lights).filter(|(_, item)| !item.is_animated) {
        let is_same_place = match (lamp::center(light), lamp::center(&item.light)) {
            (Some(a), Some(b)) => is_near(a, b),
            (a, b) => a == b,
        };
        let (a, b) = (light.full_radiance(), item.light.full_radiance());
        if !is_same_place || (a - b).abs().max_element() > 1e-4 * b.max_element() {
            return wrong("light");
        }
    }
    if scene.objects.len() != now.objects.len() {
        return wrong("number of objects");
    }
    for (object, item) in scene.objects.iter().zip(&now.objects).filter(|(_, item)| !(item.is_animated && is_moving)) {
        let bounds = object.shape.bounds();
        let is_same = is_near(bounds.min, item.bounds.min) && is_near(bounds.max, item.bounds.max);
        if !is_same || object.visible != item.visible || object.strategy != item.strategy {
            return wrong(&format!("object \"{}\"", item.name));
        }
        // By objects: numbers of materials are others where objects of models went.
        let materials = now.materials.get(item.material).zip(scene.materials.get(object.material));
        if materials.is_none_or(|(item, read)| !is_like(read, &item.material)) {
            return wrong(&format!("material of \"{}\"", item.name));
        }
    }
    // Those that the file names come first, whether or not an object has them.
    let named = text.parse::<DocumentMut>().ok();
    let named = named.as_ref().and_then(|text| text.get("materials")).and_then(Item::as_table_like);
    let mut pairs = scene.materials.iter().zip(&now.materials).take(named.map_or(0, TableLike::len));
    match pairs.position(|(read, item)| !is_like(read, &item.material)) {
        Some(place) => wrong(&format!("material {place}")),
        None => Ok(()),
    }
}

/// Whether two materials reflect alike, to rounding.
fn is_like(a: &Material, b: &Material) -> bool {
    use crate::gloss;
    let near = |a: Vec3, b: Vec3| (a - b).abs().max_element() <= 1e-4 * (1.0 + b.abs().max_element());
    let colors = match (gloss::color(a), gloss::color(b)) {
        (Some(a), Some(b)) => near(a, b),
        (a, b) => a == b,
    };
    let number = |material: &Material| match gloss::of(material) {
        Some(gloss::Gloss::Exponent(number) | gloss::Gloss::Roughness(number)) => number,
        None => 0.0,
    };
    let (x, y) = (number(a), number(b));
    a.name() == b.name() && colors && (x - y).abs() <= 1e-4 * (1.0 + y.abs())
}
