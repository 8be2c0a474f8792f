//! Messages between JavaScript and this module: JSON, and arrays of numbers beside it.

use crate::library::fault::Fault;
use bytemuck::{AnyBitPattern, NoUninit};
use glam::Vec3;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

/// An array of a message: the bytes that it has, among those beside the JSON.
#[derive(Clone, Copy, Debug, Deserialize, Serialize)]
pub(crate) struct Span {
    at: usize,
    bytes: usize,
}

/// The arrays of a command.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arrays<'a>(pub(crate) &'a [u8]);

impl<'a> Arrays<'a> {
    pub(crate) fn bytes(self, span: Span) -> Result<&'a [u8], Fault> {
        let end = span.at.checked_add(span.bytes);
        end.and_then(|end| self.0.get(span.at..end)).ok_or_else(|| Fault::range("an array is cut short"))
    }

    /// Numbers, or rows of numbers.
    pub(crate) fn list<T: NoUninit + AnyBitPattern>(self, span: Span) -> Result<Vec<T>, Fault> {
        let bytes = self.bytes(span)?;
        if !bytes.len().is_multiple_of(size_of::<T>()) {
            return Err(Fault::range("an array has no whole number of rows"));
        }
        Ok(bytemuck::pod_collect_to_vec(bytes))
    }

    pub(crate) fn optional<T: NoUninit + AnyBitPattern>(self, span: Option<Span>) -> Result<Vec<T>, Fault> {
        span.map_or_else(|| Ok(Vec::new()), |span| self.list(span))
    }
}

/// The arrays of an answer.
#[derive(Debug)]
pub(crate) enum Memory {
    Bytes(Vec<u8>),
    /// The memory that a picture was rendered into, without a copy.
    Pixels(Vec<Vec3>),
}

impl Default for Memory {
    fn default() -> Self {
        Self::Bytes(Vec::new())
    }
}

impl Memory {
    pub(crate) fn bytes(&self) -> &[u8] {
        match self {
            Self::Bytes(bytes) => bytes,
            Self::Pixels(pixels) => bytemuck::cast_slice(pixels),
        }
    }
}

/// The answer of a command.
#[derive(Debug, Default)]
pub(crate) struct Answer {
    pub(crate) head: Value,
    pub(crate) arrays: Memory,
}

impl Answer {
    /// An answer of JSON alone.
    pub(crate) fn of(head: Value) -> Self {
        Self { head, arrays: Memory::default() }
    }

    /// An answer of several arrays, by their names.
    pub(crate) fn named<'a>(layers: impl IntoIterator<Item = (String, &'a [u8])>) -> Self {
        let (mut head, mut arrays) = (Map::new(), Vec::new());
        for (name, bytes) in layers {
            head.insert(name, json!({ "at": arrays.len(), "bytes": bytes.len() }));
            arrays.extend_from_slice(bytes);
        }
        Self { head: head.into(), arrays: Memory::Bytes(arrays) }
    }
}
