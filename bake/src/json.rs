//! JSON that is edited in place: whatever is not touched stays as it is written, byte for byte.

use serde_json::Value;

/// A value of a document: as it is written, or opened to be edited.
#[derive(Clone, Debug)]
pub(crate) enum Json {
    /// As it is written.
    Raw(String),
    /// The items of an array.
    Array(Vec<Self>),
    /// The fields of an object, in their order, with their names as written, quotes included.
    Object(Vec<(String, Self)>),
}

impl From<Value> for Json {
    fn from(value: Value) -> Self {
        Self::Raw(value.to_string())
    }
}

impl Json {
    /// The value that a text is, if it is one.
    pub(crate) fn parse(text: &str) -> Result<Self, serde_json::Error> {
        serde_json::from_str::<serde::de::IgnoredAny>(text)?;
        Ok(Self::Raw(text.trim().to_owned()))
    }

    /// Opens one level, where the value is an array or an object.
    fn open(&mut self) {
        let Self::Raw(text) = self else { return };
        match text.as_bytes().first() {
            Some(b'[') => {
                *self = Self::Array(pieces(text).into_iter().map(|item| Self::Raw(item.to_owned())).collect())
            }
            Some(b'{') => {
                let field = |field: &str| {
                    let name = string_end(field.as_bytes(), 0);
                    let value = field[name..].trim_start().trim_start_matches(':').trim();
                    (field[..name].to_owned(), Self::Raw(value.to_owned()))
                };
                *self = Self::Object(pieces(text).into_iter().map(field).collect());
            }
            _ => {}
        }
    }

    /// The field of that name; of a value that is no object, and of an object without it, a new one: `null`.
    pub(crate) fn field(&mut self, name: &str) -> &mut Self {
        self.open();
        if !matches!(self, Self::Object(_)) {
            *self = Self::Object(Vec::new());
        }
        let Self::Object(fields) = self else { unreachable!("it is an object now") };
        // Of repeated names the last one counts.
        let place = fields.iter().rposition(|(known, _)| is_name(known, name)).unwrap_or_else(|| {
            fields.push((Value::from(name).to_string(), Self::Raw("null".to_owned())));
            fields.len() - 1
        });
        &mut fields[place].1
    }

    /// The item at a place, if there is one.
    pub(crate) fn item(&mut self, place: usize) -> Option<&mut Self> {
        self.open();
        match self {
            Self::Array(items) => items.get_mut(place),
            _ => None,
        }
    }

    /// Appends an item, to a new array where the value is none. Returns its place.
    pub(crate) fn push(&mut self, item: impl Into<Self>) -> usize {
        self.open();
        if !matches!(self, Self::Array(_)) {
            *self = Self::Array(Vec::new());
        }
        let Self::Array(items) = self else { unreachable!("it is an array now") };
        items.push(item.into());
        items.len() - 1
    }

    /// Takes a field away; an object that is left without fields stays.
    pub(crate) fn remove(&mut self, name: &str) {
        self.open();
        if let Self::Object(fields) = self {
            fields.retain(|(known, _)| !is_name(known, name));
        }
    }

    /// Whether an object has the field.
    pub(crate) fn has(&mut self, name: &str) -> bool {
        self.open();
        matches!(self, Self::Object(fields) if fields.iter().any(|(known, _)| is_name(known, name)))
    }

    /// The value, as it is now.
    pub(crate) fn value(&self) -> Value {
        serde_json::from_str(&self.text()).unwrap_or_default()
    }

    /// The text, as it is now.
    pub(crate) fn text(&self) -> String {
        let mut out = String::new();
        self.write(&mut out);
        out
    }

    fn write(&self, out: &mut String) {
        let list = |out: &mut String, ends: [char; 2], count: usize, each: &dyn Fn(usize, &mut String)| {
            out.push(ends[0]);
            for i in 0..count {
                if i > 0 {
                    out.push(',');
                }
                each(i, out);
            }
            out.push(ends[1]);
        };
        match self {
            Self::Raw(text) => out.push_str(text),
            Self::Array(items) => list(out, ['[', ']'], items.len(), &|i, out| items[i].write(out)),
            Self::Object(fields) => list(out, ['{', '}'], fields.len(), &|i, out| {
                out.push_str(&fields[i].0);
                out.push(':');
                fields[i].1.write(out);
            }),
        }
    }
}

/// Whether a name as written means that name.
fn is_name(written: &str, name: &str) -> bool {
    written.get(1..written.len() - 1) == Some(name) || serde_json::from_str::<String>(written).is_ok_and(|n| n == name)
}

/// The place after a string that begins at a place with its quote.
fn string_end(text: &[u8], start: usize) -> usize {
    let mut at = start + 1;
    while at < text.len() && text[at] != b'"' {
        at += 1 + usize::from(text[at] == b'\\');
    }
    (at + 1).min(text.len())
}

/// The pieces between the commas of an array or an object: of valid JSON.
fn pieces(text: &str) -> Vec<&str> {
    let bytes = text.as_bytes();
    let (mut found, mut depth, mut start, mut at) = (Vec::new(), 0_usize, 1, 1);
    while at < bytes.len() {
        match bytes[at] {
            b'"' => {
                at = string_end(bytes, at);
                continue;
            }
            b'[' | b'{' => depth += 1,
            b',' if depth == 0 => {
                found.push(text[start..at].trim());
                start = at + 1;
            }
            b']' | b'}' if depth == 0 => break,
            b']' | b'}' => depth -= 1,
            _ => {}
        }
        at += 1;
    }
    found.push(text[start..at.min(text.len())].trim());
    found.retain(|piece| !piece.is_empty());
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    const TEXT: &str =
        r#" { "b" : [1.0e-5, 0.10 ,"a,]\"}"], "a":{"x\u0041": {"deep":[ { } ,[ ]]}, "é" : null}, "c":[] } "#;

    #[test]
    fn untouched_values_stay_as_written() {
        let mut json = Json::parse(TEXT).unwrap();
        assert_eq!(json.text(), TEXT.trim());
        *json.field("new") = json!({"k": 1}).into();
        assert_eq!(json.field("b").push(json!(true)), 3);
        *json.field("a").field("xA").field("more") = json!("m").into();
        assert_eq!(json.field("c").push(json!(0)), 0);
        let written = json.text();
        let want = r#"{"b":[1.0e-5,0.10,"a,]\"}",true],"a":{"x\u0041":{"deep":[ { } ,[ ]],"more":"m"},"é":null},"c":[0],"new":{"k":1}}"#;
        assert_eq!(written, want);
        assert_eq!(json.value()["a"]["xA"]["deep"], json!([{}, []]));
    }

    #[test]
    fn fields_come_and_go() {
        let mut json = Json::parse(r#"{"a": 1, "a": 2, "b": "x"}"#).unwrap();
        assert!(json.has("a") && !json.has("c"));
        *json.field("a") = json!(3).into();
        assert_eq!(json.value()["a"], json!(3));
        json.remove("a");
        assert_eq!(json.text(), r#"{"b":"x"}"#);
        assert!(json.field("b").item(0).is_none());
        assert!(Json::parse("{\"a\": }").is_err());
    }
}
