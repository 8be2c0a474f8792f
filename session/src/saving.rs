//! Changes of a session written back into the scene file that it was opened from.

use crate::{LightItem, MaterialItem, ObjectItem, Primitive, Snapshot, lamp};
use brdf::Material;
use core::f32::consts::PI;
use core::fmt;
use glam::{DVec3, Mat4, Quat, Vec3};
use lighting::Light;
use scene::SceneError;
use scene_files::{Disk, Files};
use shading::LightLobes;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, Table, TableLike, Value};

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
    if old.vertical_fov != new.vertical_fov {
        put(to, "fov", number(new.vertical_fov.to_degrees()));
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

/// Puts a number into one of a list of tables.
fn put_in_list(to: &mut dyn TableLike, list: &str, place: usize, key: &str, value: Value) -> Result<(), SaveError> {
    let missing = || change(format!("there is no {list} {place}"));
    match to.get_mut(list) {
        Some(Item::ArrayOfTables(all)) => put(all.get_mut(place).ok_or_else(missing)?, key, value),
        Some(Item::Value(Value::Array(all))) => {
            put(all.get_mut(place).and_then(Value::as_inline_table_mut).ok_or_else(missing)?, key, value);
        }
        _ => return Err(missing()),
    }
    Ok(())
}

/// The tables of a list of the file, however they are written.
fn elements<'d>(document: &'d mut DocumentMut, key: &str) -> Vec<&'d mut dyn TableLike> {
    match document.get_mut(key) {
        Some(Item::ArrayOfTables(all)) => {
            ArrayOfTables::iter_mut(all).map(|table| table as &mut dyn TableLike).collect()
        }
        Some(Item::Value(Value::Array(all))) => {
            all.iter_mut().filter_map(|value| Some(value.as_inline_table_mut()? as &mut dyn TableLike)).collect()
        }
        _ => Vec::new(),
    }
}

/// Writes the lights.
fn lights(document: &mut DocumentMut, before: &Snapshot, now: &Snapshot) -> Result<Order<LightItem>, SaveError> {
    let mut cuts = before.cuts.lights.clone();
    let (mut next, mut order, mut gone) = (0, Vec::with_capacity(now.lights.len()), Vec::new());
    for (index, table) in elements(document, "lights").into_iter().enumerate() {
        let kind = table.get("kind").and_then(Item::as_str).unwrap_or_default().to_owned();
        let count = match kind.as_str() {
            "spheres" => table.get("spheres").and_then(Item::as_array).map_or(0, Array::len),
            "environment" | "ambient" if kind == "environment" || is_occluded(table) => before.lights
                [next.min(before.lights.len())..]
                .iter()
                .take_while(|item| matches!(item.light, Light::Sky(_)))
                .count(),
            _ => 1,
        };
        let range = next..next + count;
        next += count;
        let other = || SaveError::Text("it has other lights".to_owned());
        let old = before.lights.get(range).ok_or_else(other)?;
        let new: Vec<LightItem> = old.iter().filter_map(|item| now.light(item.handle)).cloned().collect();
        if new.is_empty() && count > 0 {
            gone.push(index);
            cuts.push(Cut { items: old.to_vec(), table: copy(table) });
        } else if new.len() < count && kind != "spheres" {
            return Err(other());
        } else if new.len() < count || old.iter().zip(&new).any(is_changed) {
            match kind.as_str() {
                "spheres" => spheres(table, &new, now.origin)?,
                _ => light(table, (&old[0], &new[0]), now.origin)?,
            }
        }
        order.extend(new);
    }
    remove(document, "lights", &gone);
    for item in now.lights.iter().filter(|item| before.light(item.handle).is_none()) {
        if order.iter().any(|known: &LightItem| known.handle == item.handle) {
            continue;
        }
        let is_cut = |cut: &Cut<LightItem>| cut.items.iter().any(|old| old.handle == item.handle);
        let Some(place) = cuts.iter().position(is_cut) else {
            append(document, "lights", new_light(item, now.origin)?)?;
            order.push(item.clone());
            continue;
        };
        let Cut { items: old, mut table } = cuts.remove(place);
        let new: Vec<LightItem> = old.iter().filter_map(|item| now.light(item.handle)).cloned().collect();
        if table.get("kind").and_then(Item::as_str) == Some("spheres") {
            spheres(&mut table, &new, now.origin)?;
        } else if old.iter().zip(&new).any(is_changed) {
            light(&mut table, (&old[0], &new[0]), now.origin)?;
        }
        append(document, "lights", table)?;
        order.extend(new);
    }
    // Those of objects that emit follow.
    let rest = before.lights.get(next..).unwrap_or_default();
    for (old, new) in rest.iter().filter_map(|old| Some((old, now.light(old.handle)?))) {
        if is_changed((old, new)) {
            return Err(change("a light that an object of the file shines with is changed by the object's material"));
        }
        order.push(new.clone());
    }
    Ok((order, cuts))
}

/// A table of the file by itself.
fn copy(table: &dyn TableLike) -> Table {
    table.iter().map(|(key, item)| (key, item.clone())).collect()
}

fn is_changed((old, new): (&LightItem, &LightItem)) -> bool {
    old.light != new.light && !new.is_animated
}

/// The table of a light that came.
fn new_light(item: &LightItem, origin: DVec3) -> Result<Table, SaveError> {
    let mut table = Table::new();
    let is_even = |corners: &[Vec3]| {
        let &[a, b, c, d] = corners else { return false };
        (a + c - b - d).abs().max_element() <= 1e-5 * (c - a).length()
    };
    let (kind, unit) = match &item.light {
        light if light.image().is_some() => return Err(change("a new light with an image has no keys")),
        Light::Sphere(_) => ("sphere", "radiance"),
        Light::Spot(_) => ("spot", "intensity"),
        Light::Flat(flat) if flat.as_disc().1.is_some() => ("disc", "radiance"),
        Light::Flat(flat) if is_even(flat.corners()) => ("rectangle", "radiance"),
        Light::Sun(_) => ("sun", "irradiance"),
        other => return Err(change(format!("a new light of the kind {} has no keys", other.name()))),
    };
    put(&mut table, "kind", Value::from(kind));
    // In the place of the number that follows.
    put(&mut table, unit, Value::from(0));
    light(&mut table, (item, item), origin)?;
    match &item.light {
        Light::Spot(spot) => {
            let [inner, outer] = spot.cos.map(|cos| number(cos.clamp(-1.0, 1.0).acos().to_degrees()));
            put(&mut table, "angle", outer);
            put(&mut table, "inner", inner);
        }
        Light::Flat(flat) if flat.two_sided => put(&mut table, "two_sided", Value::from(true)),
        _ => {}
    }
    Ok(table)
}

/// Whether ambient light is a part of the environment, whose lights take the place of the first of its tables.
fn is_occluded(table: &dyn TableLike) -> bool {
    table.get("occluded").and_then(Item::as_bool).unwrap_or_default()
}

fn spheres(table: &mut dyn TableLike, new: &[LightItem], origin: DVec3) -> Result<(), SaveError> {
    let balls: Vec<_> = new.iter().filter_map(|item| item.light.sphere()).collect();
    let radiance = new[0].light.full_radiance();
    if new.iter().any(|item| item.light.full_radiance() != radiance) {
        return Err(change("lights of one list have one radiance"));
    }
    let list: Array = balls
        .iter()
        .map(|ball| {
            let [x, y, z] = (ball.center.as_dvec3() + origin).to_array();
            Value::from_iter([number(x as f32), number(y as f32), number(z as f32), number(ball.radius)])
        })
        .collect();
    put(table, "spheres", Value::Array(list));
    let squares: f32 = balls.iter().map(|ball| ball.radius * ball.radius).sum();
    brightness(table, radiance, None, &[("radiance", 1.0), ("flux", 4.0 * PI * PI * squares)])
}

fn light(table: &mut dyn TableLike, (old, new): (&LightItem, &LightItem), origin: DVec3) -> Result<(), SaveError> {
    let radiance = new.light.full_radiance();
    let mut before = None;
    let units = match &new.light {
        Light::Sphere(light) => ball(table, light.sphere, origin),
        Light::Spot(spot) => {
            put(table, "direction", vector(spot.axis));
            ball(table, spot.light.sphere, origin)
        }
        Light::Flat(flat) => {
            let corners = flat.corners();
            match (flat.as_disc(), table.contains_key("corners")) {
                ((center, Some(radius)), _) => {
                    put(table, "center", place(center, origin));
                    put(table, "normal", vector(flat.normal()));
                    put(table, "radius", number(radius));
                }
                (_, true) => {
                    let list: Array = corners.iter().map(|corner| place(*corner, origin)).collect();
                    put(table, "corners", Value::Array(list));
                }
                ((center, None), false) => {
                    put(table, "center", place(center, origin));
                    put(table, "u", vector(0.5 * (corners[1] - corners[0])));
                    put(table, "v", vector(0.5 * (corners[3] - corners[0])));
                }
            }
            if table.contains_key("image") {
                before = Some(old.light.full_radiance());
            }
            let sides = if flat.two_sided { 2.0 } else { 1.0 };
            vec![("radiance", 1.0), ("flux", PI * flat.area() * sides)]
        }
        Light::Tube(tube) => {
            put(table, "from", place(tube.ends[0], origin));
            put(table, "to", place(tube.ends[1], origin));
            put(table, "radius", number(tube.radius));
            vec![("radiance", 1.0), ("flux", PI * tube.area())]
        }
        Light::Sun(sun) => {
            put(table, "direction", vector(-sun.toward));
            put(table, "angle", number(2.0 * lamp::size(&new.light).unwrap_or_default().to_degrees()));
            vec![("radiance", 1.0), ("irradiance", PI * sun.sin * sun.sin)]
        }
        Light::Ambient(_) => vec![("radiance", 1.0)],
        other => return Err(change(format!("a light of the kind {} has no keys", other.name()))),
    };
    brightness(table, radiance, before, &units)
}

/// Place and radius of a sphere; the units that its brightness may be in.
fn ball(table: &mut dyn TableLike, sphere: lobe_core::Sphere, origin: DVec3) -> Vec<(&'static str, f32)> {
    put(table, "center", place(sphere.center, origin));
    if table.contains_key("radius") || (sphere.radius - 0.01).abs() > 1e-6 {
        put(table, "radius", number(sphere.radius));
    }
    let square = PI * sphere.radius * sphere.radius;
    vec![("radiance", 1.0), ("intensity", square), ("flux", 4.0 * PI * square)]
}

/// Brightness in the unit that the file has; `before`: the radiance that the value there stands for, where that is times an image.
fn brightness(
    table: &mut dyn TableLike,
    radiance: Vec3,
    before: Option<Vec3>,
    units: &[(&str, f32)],
) -> Result<(), SaveError> {
    let Some((unit, factor)) = units.iter().find(|(unit, _)| table.contains_key(unit)) else {
        return Err(SaveError::Text("a light has no brightness".to_owned()));
    };
    let value = match before {
        None => {
            let (value, old) = (radiance * *factor, table.get(unit).and_then(read_color));
            // As it was written, but for rounding.
            match old.filter(|old| (value - old).abs().cmple(value.abs() * 1e-6).all()) {
                Some(_) => return Ok(()),
                None => value,
            }
        }
        Some(before) if before == radiance => return Ok(()),
        Some(before) => {
            let old = table.get(unit).and_then(read_color).ok_or_else(|| change("its brightness cannot be read"))?;
            let ratio = |k: usize| if before[k] > 0.0 { old[k] * radiance[k] / before[k] } else { old[k] };
            Vec3::new(ratio(0), ratio(1), ratio(2))
        }
    };
    put(table, unit, color(value));
    Ok(())
}

fn objects(document: &mut DocumentMut, before: &Snapshot, now: &Snapshot) -> Result<Order<ObjectItem>, SaveError> {
    let mut cuts = before.cuts.objects.clone();
    let (mut next, mut order, mut gone) = (0, Vec::with_capacity(now.objects.len()), Vec::new());
    for (index, table) in elements(document, "objects").into_iter().enumerate() {
        let given = table.get("name").and_then(Item::as_str).map(str::to_owned);
        let name = given.clone().unwrap_or_else(|| format!("object {index}"));
        let is_part = |item: &&ObjectItem| item.name.strip_prefix(&name).is_some_and(|rest| rest.starts_with('/'));
        let rest = before.objects.get(next..).unwrap_or_default();
        let count = match rest.first() {
            Some(first) if first.name == name => 1,
            _ => rest.iter().take_while(is_part).count(),
        };
        let old = rest.get(..count).filter(|old| !old.is_empty());
        let old = old.ok_or_else(|| SaveError::Text("it has other objects".to_owned()))?;
        next += count;
        let new: Vec<&ObjectItem> = old.iter().filter_map(|item| now.object(item.handle)).collect();
        if new.is_empty() {
            gone.push(index);
            let mut table = copy(table);
            put(&mut table, "name", Value::from(name.as_str()));
            cuts.push(Cut { items: old.to_vec(), table });
            continue;
        }
        // Its place in the file was its name.
        if given.is_none() && !gone.is_empty() {
            put(table, "name", Value::from(name.as_str()));
        }
        object(table, &Changes::of_all(old, &new, &name)?, &name, now.origin)?;
        order.extend(new.into_iter().cloned());
    }
    if before.objects.len() != next {
        return Err(SaveError::Text("it has other objects".to_owned()));
    }
    remove(document, "objects", &gone);
    for item in now.objects.iter().filter(|item| before.object(item.handle).is_none()) {
        if order.iter().any(|known: &ObjectItem| known.handle == item.handle) {
            continue;
        }
        let is_cut = |cut: &Cut<ObjectItem>| cut.items.iter().any(|old| old.handle == item.handle);
        let Some(place) = cuts.iter().position(is_cut) else {
            let table = new_object(document, item, now.origin)?;
            append(document, "objects", table)?;
            order.push(item.clone());
            continue;
        };
        let Cut { items: old, mut table } = cuts.remove(place);
        let new: Vec<&ObjectItem> = old.iter().filter_map(|item| now.object(item.handle)).collect();
        object(&mut table, &Changes::of_all(&old, &new, &item.name)?, &item.name, now.origin)?;
        append(document, "objects", table)?;
        order.extend(new.into_iter().cloned());
    }
    Ok((order, cuts))
}

/// The table of an object that came.
fn new_object(document: &DocumentMut, item: &ObjectItem, origin: DVec3) -> Result<Table, SaveError> {
    let name = &item.name;
    let primitive =
        item.primitive.ok_or_else(|| change(format!("\"{name}\" is new, and neither a sphere nor a box")))?;
    let mut keys = InlineTable::new();
    match primitive {
        Primitive::Sphere(sphere) => {
            keys.insert("center", place(sphere.center, origin));
            keys.insert("radius", number(sphere.radius));
        }
        Primitive::Box { center, size } => {
            keys.insert("center", place(center, origin));
            keys.insert("size", vector(size));
        }
    }
    let named = document.get("materials").and_then(Item::as_table_like);
    let material = named.and_then(|all| all.iter().nth(item.material).map(|(key, _)| key.to_owned()));
    let material = material.ok_or_else(|| change(format!("the material of \"{name}\" is not of the scene file")))?;
    let mut table = Table::new();
    put(&mut table, "name", Value::from(name.as_str()));
    put(&mut table, &primitive.to_string(), Value::InlineTable(keys));
    put(&mut table, "material", Value::from(material));
    let changes = Changes {
        step: (item.transform != Mat4::IDENTITY).then_some(item.transform),
        visible: (!item.visible).then_some(false),
        strategy: item.strategy.map(Some),
        material: false,
    };
    object(&mut table, &changes, name, origin)?;
    Ok(table)
}

/// Removes entries of a list of the file, however it is written. Comments above an entry go with it, but for those before a blank line.
fn remove(document: &mut DocumentMut, key: &str, gone: &[usize]) {
    for index in gone.iter().rev() {
        match document.get_mut(key) {
            Some(Item::ArrayOfTables(all)) => {
                let prefix = |table: &Table| table.decor().prefix().and_then(|text| text.as_str()).map(str::to_owned);
                let above = all.get(*index).and_then(prefix).unwrap_or_default();
                let kept = above.rfind("\n\n").map_or("", |end| above[..end].trim_end_matches('\n'));
                all.remove(*index);
                if let Some(next) = all.get_mut(*index).filter(|_| !kept.is_empty()) {
                    let own = prefix(next).unwrap_or_default();
                    next.decor_mut().set_prefix(format!("{kept}\n{own}"));
                }
            }
            Some(Item::Value(Value::Array(all))) => {
                all.remove(*index);
            }
            _ => {}
        }
    }
}

/// Appends an entry to a list of the file, however it is written.
fn append(document: &mut DocumentMut, key: &str, mut table: Table) -> Result<(), SaveError> {
    table.decor_mut().set_prefix("\n");
    match document.entry(key).or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new())) {
        Item::ArrayOfTables(all) => all.push(table),
        Item::Value(Value::Array(all)) => all.push(table.into_inline_table()),
        _ => return Err(SaveError::Text(format!("{key} is no list"))),
    }
    Ok(())
}

/// The changes of an object.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Changes {
    /// From where it stood.
    step: Option<Mat4>,
    visible: Option<bool>,
    strategy: Option<Option<scene::Strategy>>,
    material: bool,
}

impl Changes {
    /// Those of all the parts that an entry gives.
    fn of_all(old: &[ObjectItem], new: &[&ObjectItem], name: &str) -> Result<Self, SaveError> {
        let mut changes = old.iter().zip(new).map(|(old, new)| Self::new(old, new));
        let one = changes.next();
        match one.filter(|one| old.len() == new.len() && changes.all(|other| other == *one)) {
            Some(one) => Ok(one),
            None => {
                Err(change(format!("\"{name}\" is one object of the file: its parts change together or not at all")))
            }
        }
    }

    fn new(old: &ObjectItem, new: &ObjectItem) -> Self {
        let step = (old.transform != new.transform).then(|| new.transform * old.transform.inverse());
        Self {
            step,
            visible: (old.visible != new.visible).then_some(new.visible),
            strategy: (old.strategy != new.strategy).then_some(new.strategy),
            material: old.material != new.material,
        }
    }
}

fn object(table: &mut dyn TableLike, changes: &Changes, name: &str, origin: DVec3) -> Result<(), SaveError> {
    if changes.material {
        return Err(change(format!("\"{name}\" has another material")));
    }
    if let Some(visible) = changes.visible {
        put_or_remove(table, "visible", (!visible).then(|| Value::from(false)));
    }
    if let Some(strategy) = changes.strategy {
        put_or_remove(table, "visibility", strategy.map(|strategy| Value::from(strategy.name())));
    }
    let Some(step) = changes.step else { return Ok(()) };
    let is_shift = step == Mat4::from_translation(step.w_axis.truncate());
    if origin != DVec3::ZERO && !is_shift {
        return Err(change(format!("\"{name}\" lies far from the origin of the file: it can be shifted, not turned")));
    }
    let is_matrix = table.contains_key("matrix");
    if is_shift && !is_matrix {
        let old = table.get("translate").and_then(read_vector).unwrap_or(Vec3::ZERO);
        put(table, "translate", vector(old + step.w_axis.truncate()));
        return Ok(());
    }
    let new =
        step * standing(table).ok_or_else(|| change(format!("\"{name}\" stands in a way that cannot be read")))?;
    let (scale, turn, shift) = new.to_scale_rotation_translation();
    let again = Mat4::from_scale_rotation_translation(scale, turn, shift);
    let is_plain =
        (0..4).all(|k| (again.col(k) - new.col(k)).abs().max_element() <= 1e-5 * (1.0 + new.col(k).length()));
    if is_matrix || !is_plain {
        for key in ["scale", "rotate", "translate"] {
            table.remove(key);
        }
        let row = |k: usize| Value::from_iter(new.row(k).to_array().map(number));
        put(table, "matrix", Value::from_iter((0..4).map(row)));
        return Ok(());
    }
    let is_even = (scale - scale.x).abs().max_element() <= 1e-5 * scale.x.abs();
    let is_one = (scale - Vec3::ONE).abs().max_element() <= 1e-5;
    put_or_remove(table, "scale", (!is_one).then(|| if is_even { number(scale.x) } else { vector(scale) }));
    let (axis, angle) = turn.to_axis_angle();
    let rotation = || {
        let mut keys = InlineTable::new();
        keys.insert("axis", vector(axis));
        keys.insert("degrees", number(angle.to_degrees()));
        Value::InlineTable(keys)
    };
    put_or_remove(table, "rotate", (angle.abs() > 1e-6).then(rotation));
    put_or_remove(table, "translate", (shift != Vec3::ZERO).then(|| vector(shift)));
    Ok(())
}

/// The matrix that the keys of an object mean.
fn standing(table: &dyn TableLike) -> Option<Mat4> {
    if let Some(matrix) = table.get("matrix") {
        let mut all = [0.0; 16];
        for (k, row) in matrix.as_array()?.iter().take(4).enumerate() {
            for (j, value) in row.as_array()?.iter().take(4).enumerate() {
                all[4 * k + j] = value_of(value)?;
            }
        }
        return Some(Mat4::from_cols_array(&all).transpose());
    }
    let scale = match table.get("scale") {
        None => Vec3::ONE,
        Some(scale) => read_color(scale)?,
    };
    let turn = match table.get("rotate") {
        None => Quat::IDENTITY,
        Some(rotate) => {
            let keys = rotate.as_table_like()?;
            let degrees = keys.get("degrees")?.as_value().and_then(value_of)?;
            Quat::from_axis_angle(read_vector(keys.get("axis")?)?.normalize(), degrees.to_radians())
        }
    };
    let shift = match table.get("translate") {
        None => Vec3::ZERO,
        Some(shift) => read_vector(shift)?,
    };
    Some(Mat4::from_scale_rotation_translation(scale, turn, shift))
}

/// A table of the file's top, made where there is none.
fn table<'d>(root: &'d mut toml_edit::Table, key: &str) -> Result<&'d mut dyn TableLike, SaveError> {
    let item = root.entry(key).or_insert_with(|| Item::Table(toml_edit::Table::new()));
    item.as_table_like_mut().ok_or_else(|| SaveError::Text(format!("{key} is no table")))
}

/// Puts a value in the place of one; what stands around that, a comment behind it for one, stays. One that is the same number stays as it
/// is written.
fn put(table: &mut dyn TableLike, key: &str, mut value: Value) {
    match table.get_mut(key).and_then(Item::as_value_mut) {
        Some(old) if is_same(old, &value) => {}
        Some(old) => {
            *value.decor_mut() = old.decor().clone();
            *old = value;
        }
        None => {
            table.insert(key, Item::Value(value));
        }
    }
}

fn put_or_remove(table: &mut dyn TableLike, key: &str, value: Option<Value>) {
    match value {
        Some(value) => put(table, key, value),
        None => {
            table.remove(key);
        }
    }
}

/// The shortest number that is read as this one.
fn number(value: f32) -> Value {
    Value::from(shortest(value))
}

fn shortest(value: f32) -> f64 {
    value.to_string().parse().unwrap_or_else(|_| f64::from(value))
}

fn vector(v: Vec3) -> Value {
    Value::from_iter(v.to_array().map(|v| Value::from(shortest(v))))
}

/// A point of the scene, in the coordinates of the file.
fn place(point: Vec3, origin: DVec3) -> Value {
    if origin == DVec3::ZERO {
        return vector(point);
    }
    Value::from_iter((point.as_dvec3() + origin).to_array().map(Value::from))
}

/// A colour; a grey one as one number.
fn color(c: Vec3) -> Value {
    if c.x == c.y && c.y == c.z { number(c.x) } else { vector(c) }
}

/// Whether both are read as the same numbers.
fn is_same(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Array(a), Value::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| is_same(a, b)),
        (Value::InlineTable(a), Value::InlineTable(b)) => {
            a.len() == b.len() && a.iter().all(|(key, a)| b.get(key).is_some_and(|b| is_same(a, b)))
        }
        (Value::String(a), Value::String(b)) => a.value() == b.value(),
        (Value::Boolean(a), Value::Boolean(b)) => a.value() == b.value(),
        _ => value_of(a).is_some_and(|a| value_of(b) == Some(a)),
    }
}

fn value_of(value: &Value) -> Option<f32> {
    value.as_float().or_else(|| value.as_integer().map(|n| n as f64)).map(|v| v as f32)
}

fn read_vector(item: &Item) -> Option<Vec3> {
    let all = item.as_array()?;
    let at = |k: usize| all.get(k).and_then(value_of);
    Some(Vec3::new(at(0)?, at(1)?, at(2)?))
}

/// A vector, or one number for all three.
fn read_color(item: &Item) -> Option<Vec3> {
    item.as_value().and_then(value_of).map(Vec3::splat).or_else(|| read_vector(item))
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
    let is_same_camera = is_near(scene.camera.eye, now.camera.eye) && is_near(scene.camera.target, now.camera.target);
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
