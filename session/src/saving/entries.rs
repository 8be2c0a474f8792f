//! Entries of the lists of a scene file, and tables.

use super::values::put;
use super::{SaveError, change};
use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, TableLike, Value};

/// Puts a number into one of a list of tables.
pub(super) fn put_in_list(
    to: &mut dyn TableLike,
    list: &str,
    place: usize,
    key: &str,
    value: Value,
) -> Result<(), SaveError> {
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
pub(super) fn elements<'d>(document: &'d mut DocumentMut, key: &str) -> Vec<&'d mut dyn TableLike> {
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

/// A table of the file by itself.
pub(super) fn copy(table: &dyn TableLike) -> Table {
    table.iter().map(|(key, item)| (key, item.clone())).collect()
}

/// Removes entries of a list of the file, however it is written. Comments above an entry go with it, but for those before a blank line.
pub(super) fn remove(document: &mut DocumentMut, key: &str, gone: &[usize]) {
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
pub(super) fn append(document: &mut DocumentMut, key: &str, mut table: Table) -> Result<(), SaveError> {
    table.decor_mut().set_prefix("\n");
    match document.entry(key).or_insert_with(|| Item::ArrayOfTables(ArrayOfTables::new())) {
        Item::ArrayOfTables(all) => all.push(table),
        Item::Value(Value::Array(all)) => all.push(table.into_inline_table()),
        _ => return Err(SaveError::Text(format!("{key} is no list"))),
    }
    Ok(())
}

/// A table of the file's top, made where there is none.
pub(super) fn table<'d>(root: &'d mut toml_edit::Table, key: &str) -> Result<&'d mut dyn TableLike, SaveError> {
    let item = root.entry(key).or_insert_with(|| Item::Table(toml_edit::Table::new()));
    item.as_table_like_mut().ok_or_else(|| SaveError::Text(format!("{key} is no table")))
}
