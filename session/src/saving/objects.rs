//! The objects of a scene file.

use super::entries::{append, copy, elements, remove};
use super::values::{number, place, put, put_or_remove, read_color, read_vector, value_of, vector};
use super::{Cut, Order, SaveError, change};
use crate::{ObjectItem, Primitive, Snapshot};
use glam::{DVec3, Mat4, Quat, Vec3};
use toml_edit::{DocumentMut, InlineTable, Item, Table, TableLike, Value};

pub(super) fn objects(
    document: &mut DocumentMut,
    before: &Snapshot,
    now: &Snapshot,
) -> Result<Order<ObjectItem>, SaveError> {
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
