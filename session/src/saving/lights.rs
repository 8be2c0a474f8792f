//! The lights of a scene file.

use super::entries::{append, copy, elements, remove};
use super::values::{color, number, place, put, read_color, vector};
use super::{Cut, Order, SaveError, change};
use crate::{LightItem, Snapshot, lamp};
use core::f32::consts::PI;
use glam::{DVec3, Vec3};
use lighting::Light;
use shading::LightLobes;
use toml_edit::{Array, DocumentMut, Item, Table, TableLike, Value};

/// Writes the lights.
pub(super) fn lights(
    document: &mut DocumentMut,
    before: &Snapshot,
    now: &Snapshot,
) -> Result<Order<LightItem>, SaveError> {
    let mut cuts = before.cuts.lights.clone();
    let (mut next, mut order, mut gone) = (0, Vec::with_capacity(now.lights.len()), Vec::new());
    for (index, table) in elements(document, "lights").into_iter().enumerate() {
        let kind = table.get("kind").and_then(Item::as_str).unwrap_or_default().to_owned();
        let count = count_of(table, &kind, &before.lights[next.min(before.lights.len())..]);
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
    add_new(document, before, now, (&mut order, &mut cuts))?;
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

/// The number of lights that a table stands for; `rest` are those that no table before has.
fn count_of(table: &dyn TableLike, kind: &str, rest: &[LightItem]) -> usize {
    match kind {
        "spheres" => table.get("spheres").and_then(Item::as_array).map_or(0, Array::len),
        "environment" | "ambient" if kind == "environment" || is_occluded(table) => {
            rest.iter().take_while(|item| matches!(item.light, Light::Sky(_))).count()
        }
        _ => 1,
    }
}

/// Appends tables of lights that were not there before: those of their own where they were cut out.
fn add_new(
    document: &mut DocumentMut,
    before: &Snapshot,
    now: &Snapshot,
    (order, cuts): (&mut Vec<LightItem>, &mut Vec<Cut<LightItem>>),
) -> Result<(), SaveError> {
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
    Ok(())
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
            if spot.range.is_finite() {
                put(&mut table, "range", number(spot.range));
            }
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
    let all: Vec<_> = new.iter().filter_map(|item| item.light.sphere()).collect();
    let radiance = new[0].light.full_radiance();
    if new.iter().any(|item| item.light.full_radiance() != radiance) {
        return Err(change("lights of one list have one radiance"));
    }
    let list: Array = all
        .iter()
        .map(|sphere| {
            let [x, y, z] = (sphere.center.as_dvec3() + origin).to_array();
            Value::from_iter([number(x as f32), number(y as f32), number(z as f32), number(sphere.radius)])
        })
        .collect();
    put(table, "spheres", Value::Array(list));
    let squares: f32 = all.iter().map(|sphere| sphere.radius * sphere.radius).sum();
    brightness(table, radiance, None, &[("radiance", 1.0), ("flux", 4.0 * PI * PI * squares)])
}

fn light(table: &mut dyn TableLike, (old, new): (&LightItem, &LightItem), origin: DVec3) -> Result<(), SaveError> {
    let radiance = new.light.full_radiance();
    let mut before = None;
    let units = match &new.light {
        Light::Sphere(light) => sphere(table, light.sphere, origin),
        Light::Spot(spot) => {
            if table.get("kind").and_then(Item::as_str) == Some("spot") {
                put(table, "direction", vector(spot.axis));
            }
            sphere(table, spot.light.sphere, origin)
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
fn sphere(table: &mut dyn TableLike, sphere: lobe_core::Sphere, origin: DVec3) -> Vec<(&'static str, f32)> {
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
