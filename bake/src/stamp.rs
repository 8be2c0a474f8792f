//! A line that a binary glTF file carries.

use crate::glb::{BINARY, JSON, container};
use crate::json::Json;
use serde_json::{Value, json};

/// The field of the document's `extras` that holds it.
const FIELD: &str = "cosine_lobes";

/// The chunks of a container: the text of its JSON, and its bytes, which may be none.
fn chunks(glb: &[u8]) -> Option<(&str, &[u8])> {
    let word = |at: usize| Some(u32::from_le_bytes(glb.get(at..at + 4)?.try_into().ok()?));
    (glb.starts_with(b"glTF") && word(8)? as usize == glb.len() && word(16)? == JSON).then_some(())?;
    let end = 20_usize.checked_add(word(12)? as usize)?;
    let text = core::str::from_utf8(glb.get(20..end)?).ok()?;
    let Some(length) = word(end) else { return Some((text, &[])) };
    (word(end + 4)? == BINARY).then_some(())?;
    Some((text, glb.get(end + 8..(end + 8).checked_add(length as usize)?)?))
}

/// A binary glTF file with a line in the `extras` of its document, beside what else is in them; all else stays byte for byte. `None` where
/// `extras` are no object, and for other files.
///
/// ```
/// let glb = bake::stamped_glb(&[], "line");
/// assert!(glb.is_none());
/// ```
#[must_use]
pub fn stamped_glb(glb: &[u8], line: &str) -> Option<Vec<u8>> {
    let (text, binary) = chunks(glb)?;
    let mut document = Json::parse(text).ok()?;
    let extras = if document.has("extras") { document.field("extras").value() } else { json!({}) };
    extras.is_object().then_some(())?;
    if !document.has("extras") {
        *document.field("extras") = extras.into();
    }
    *document.field("extras").field(FIELD) = json!(line).into();
    Some(container(document.text().into_bytes(), binary))
}

/// The line that [`stamped_glb`] put into a file, and the bytes of its buffer; `None` where it has none, or is cut short.
#[must_use]
pub fn glb_stamp(glb: &[u8]) -> Option<(String, &[u8])> {
    let (text, binary) = chunks(glb)?;
    let document: Value = serde_json::from_str(text).ok()?;
    Some((document["extras"][FIELD].as_str()?.to_owned(), binary))
}

/// The bytes of a binary glTF file's buffer; none for other files.
#[must_use]
pub fn glb_binary(glb: &[u8]) -> &[u8] {
    chunks(glb).map_or(&[], |(_, binary)| binary)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_come_back() {
        let plain = |text: &str, binary: &[u8]| container(text.as_bytes().to_vec(), binary);
        for (text, rest) in [
            (r#"{"a":1.50}"#, r#"{"a":1.50,"extras":{"cosine_lobes":"one 1"}}"#),
            (r#"{"extras": {"b" : 2 }}"#, r#"{"extras":{"b":2,"cosine_lobes":"one 1"}}"#),
        ] {
            for binary in [&[][..], &[1, 2, 3, 4]] {
                let glb = stamped_glb(&plain(text, binary), "one 1").unwrap();
                assert_eq!(glb, plain(rest, binary));
                assert_eq!(glb_stamp(&glb), Some(("one 1".to_owned(), binary)));
                assert_eq!(stamped_glb(&glb, "two"), Some(stamped_glb(&plain(text, binary), "two").unwrap()));
                for end in 0..glb.len() {
                    assert!(glb_stamp(&glb[..end]).is_none(), "{end}");
                }
            }
        }
        assert!(stamped_glb(&plain(r#"{"extras":[1]}"#, &[]), "no").is_none());
        assert!(glb_stamp(&plain("{}", &[])).is_none() && glb_stamp(b"glTF").is_none());
    }
}
