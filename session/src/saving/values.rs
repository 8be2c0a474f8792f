//! Numbers, vectors and colours, as a person writes them.

use glam::{DVec3, Vec3};
use toml_edit::{Item, TableLike, Value};

/// Puts a value in the place of one; what stands around that, a comment behind it for one, stays. One that is the same number stays as it
/// is written.
pub(super) fn put(table: &mut dyn TableLike, key: &str, mut value: Value) {
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

pub(super) fn put_or_remove(table: &mut dyn TableLike, key: &str, value: Option<Value>) {
    match value {
        Some(value) => put(table, key, value),
        None => {
            table.remove(key);
        }
    }
}

/// The shortest number that is read as this one.
pub(super) fn number(value: f32) -> Value {
    Value::from(shortest(value))
}

pub(super) fn shortest(value: f32) -> f64 {
    value.to_string().parse().unwrap_or_else(|_| f64::from(value))
}

pub(super) fn vector(v: Vec3) -> Value {
    Value::from_iter(v.to_array().map(|v| Value::from(shortest(v))))
}

/// A point of the scene, in the coordinates of the file.
pub(super) fn place(point: Vec3, origin: DVec3) -> Value {
    if origin == DVec3::ZERO {
        return vector(point);
    }
    Value::from_iter((point.as_dvec3() + origin).to_array().map(Value::from))
}

/// A colour; a grey one as one number.
pub(super) fn color(c: Vec3) -> Value {
    if c.x == c.y && c.y == c.z { number(c.x) } else { vector(c) }
}

/// Whether both are read as the same numbers.
pub(super) fn is_same(a: &Value, b: &Value) -> bool {
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

pub(super) fn value_of(value: &Value) -> Option<f32> {
    value.as_float().or_else(|| value.as_integer().map(|n| n as f64)).map(|v| v as f32)
}

pub(super) fn read_vector(item: &Item) -> Option<Vec3> {
    let all = item.as_array()?;
    let at = |k: usize| all.get(k).and_then(value_of);
    Some(Vec3::new(at(0)?, at(1)?, at(2)?))
}

/// A vector, or one number for all three.
pub(super) fn read_color(item: &Item) -> Option<Vec3> {
    item.as_value().and_then(value_of).map(Vec3::splat).or_else(|| read_vector(item))
}
