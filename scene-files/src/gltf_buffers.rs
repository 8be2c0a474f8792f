//! The data behind glTF accessors, every length checked before anything is read or reserved.

use crate::budget::Budget;
use crate::files::Source;
use crate::unit::unit;
use glam::Vec3;
use gltf::json::accessor::sparse::Sparse;
use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::Checked;
use gltf::json::{Accessor, Index, Root, buffer};
use std::borrow::Cow;
use std::path::{Component, Path};
use std::sync::Arc;

/// Buffers of a document.
pub(crate) struct Buffers<'a> {
    root: &'a Root,
    data: Vec<Vec<u8>>,
    pub(crate) budget: Arc<Budget>,
}

/// The most numbers that an accessor may claim without data behind them.
const MAX_WITHOUT_DATA: usize = 1 << 24;
/// The extension that leaves views out because it has the data.
const COMPRESSED: &str = "KHR_draco_mesh_compression";

impl<'a> Buffers<'a> {
    /// Reads all buffers: from the file's own binary chunk, data URIs and files beside `path`.
    pub(crate) fn load(files: &Source, path: &Path, root: &'a Root, mut chunk: Option<&[u8]>) -> Result<Self, String> {
        let mut data = Vec::new();
        for (i, buffer) in root.buffers.iter().enumerate() {
            let fault = |message: String| format!("buffer {i}: {message}");
            let mut bytes = match &buffer.uri {
                Some(uri) => read_uri(files, path, uri).map_err(fault)?,
                None => chunk.take().filter(|_| i == 0).ok_or_else(|| fault("has no data".to_owned()))?.to_vec(),
            };
            let (wanted, found) = (buffer.byte_length.0, bytes.len());
            if (found as u64) < wanted {
                return Err(fault(format!("has {found} bytes, byteLength says {wanted}")));
            }
            bytes.truncate(wanted as usize);
            data.push(bytes);
        }
        Ok(Self { root, data, budget: files.budget.clone() })
    }

    /// All bytes, buffer by buffer.
    pub(crate) fn into_data(self) -> Vec<Vec<u8>> {
        self.data
    }

    /// The bytes of a view, and their stride.
    pub(crate) fn view(&self, index: Index<buffer::View>) -> Result<(&[u8], Option<usize>), String> {
        let i = index.value();
        let view = self.root.buffer_views.get(i).ok_or_else(|| format!("there is no buffer view {i}"))?;
        let b = view.buffer.value();
        let data = self.data.get(b).ok_or_else(|| format!("buffer view {i}: there is no buffer {b}"))?;
        let start = view.byte_offset.map_or(0, |o| o.0);
        let range = start.checked_add(view.byte_length.0).and_then(|end| data.get(start as usize..end as usize));
        let bytes =
            range.ok_or_else(|| format!("buffer view {i} is longer than its buffer of {} bytes", data.len()))?;
        Ok((bytes, view.byte_stride.map(|s| s.0)))
    }

    /// The numbers of an accessor, row after row; integers that are `normalized` in [−1, 1].
    pub(crate) fn floats(&self, index: Index<Accessor>, kind: Type) -> Result<Vec<f32>, String> {
        let is_normalized = self.accessor(index, kind)?.0.normalized;
        self.numbers(index, kind, is_normalized)
    }

    fn numbers(&self, index: Index<Accessor>, kind: Type, is_normalized: bool) -> Result<Vec<f32>, String> {
        let (accessor, component) = self.accessor(index, kind)?;
        let scale = match (is_normalized, component) {
            (true, ComponentType::I8) => 127.0,
            (true, ComponentType::U8) => 255.0,
            (true, ComponentType::I16) => 32767.0,
            (true, ComponentType::U16) => 65535.0,
            _ => 1.0,
        };
        if component == ComponentType::F32 {
            // As they are: most numbers of a file.
            return self.read(index, accessor, component, kind, |bytes| f32::from_le_bytes(four(bytes)));
        }
        let to_float = |bytes: &[u8]| {
            let x = number(bytes, component);
            if scale == 1.0 { x as f32 } else { (x / scale).max(-1.0) as f32 }
        };
        self.read(index, accessor, component, kind, to_float)
    }

    /// Colours of an accessor, within [0, 1], and their alphas; none of these where all are 1. Integers are normalized, even where the
    /// accessor forgets to say so.
    pub(crate) fn colors(&self, index: Index<Accessor>) -> Result<(Vec<Vec3>, Vec<f32>), String> {
        let has_alpha = self.root.accessors.get(index.value()).is_some_and(|a| a.type_ == Checked::Valid(Type::Vec4));
        let values = self.numbers(index, if has_alpha { Type::Vec4 } else { Type::Vec3 }, true)?;
        let rows = values.chunks_exact(if has_alpha { 4 } else { 3 });
        let color = |row: &[f32]| Vec3::new(unit(row[0]), unit(row[1]), unit(row[2]));
        let is_clear = has_alpha && rows.clone().any(|row| row[3] < 1.0 || row[3].is_nan());
        let alphas = if is_clear { rows.clone().map(|row| unit(row[3])).collect() } else { Vec::new() };
        Ok((rows.map(color).collect(), alphas))
    }

    /// The whole numbers of an accessor.
    pub(crate) fn integers(&self, index: Index<Accessor>, kind: Type) -> Result<Vec<u32>, String> {
        let (accessor, component) = self.accessor(index, kind)?;
        if !matches!(component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32) {
            return Err(format!("accessor {}: expected unsigned integers", index.value()));
        }
        match component {
            ComponentType::U32 => self.read(index, accessor, component, kind, |bytes| u32::from_le_bytes(four(bytes))),
            _ => self.read(index, accessor, component, kind, |bytes| number(bytes, component) as u32),
        }
    }

    fn accessor(&self, index: Index<Accessor>, kind: Type) -> Result<(&'a Accessor, ComponentType), String> {
        let i = index.value();
        let accessor = self.root.accessors.get(i).ok_or_else(|| format!("there is no accessor {i}"))?;
        let Checked::Valid(component) = &accessor.component_type else {
            return Err(format!("accessor {i}: unknown componentType"));
        };
        match accessor.type_ {
            Checked::Valid(found) if found == kind => Ok((accessor, component.0)),
            Checked::Valid(found) => Err(format!("accessor {i}: is {found:?}, expected {kind:?}")),
            Checked::Invalid => Err(format!("accessor {i}: unknown type")),
        }
    }

    fn read<T: Copy + Default>(
        &self,
        index: Index<Accessor>,
        accessor: &Accessor,
        component: ComponentType,
        kind: Type,
        convert: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, String> {
        let of_accessor = || {
            let layout = Layout::of(accessor, component, kind)?;
            let mut out = self.dense(accessor, &layout, &convert)?;
            if let Some(sparse) = &accessor.sparse {
                self.replace(sparse, &layout, &convert, &mut out)?;
            }
            Ok(out)
        };
        of_accessor().map_err(|message: String| format!("accessor {}: {message}", index.value()))
    }

    /// The elements of an accessor before sparse ones replace some; zeros where there is no view.
    fn dense<T: Copy + Default>(
        &self,
        accessor: &Accessor,
        layout: &Layout,
        convert: &impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, String> {
        let Layout { count, width, size, row } = *layout;
        let Some(view) = accessor.buffer_view else {
            let is_compressed = accessor.sparse.is_none() && self.root.extensions_used.iter().any(|e| e == COMPRESSED);
            let most = MAX_WITHOUT_DATA / width;
            return match count <= most {
                _ if is_compressed => Err("has no data (compressed meshes are not supported)".to_owned()),
                true => Ok(vec![T::default(); count * width]),
                false => Err(format!("{count} elements without data: at most {most} are read")),
            };
        };
        let (bytes, stride) = self.view(view)?;
        let stride = stride.unwrap_or(row);
        if stride < row {
            return Err(format!("byteStride {stride} is less than an element's {row} bytes"));
        }
        let start = accessor.byte_offset.map_or(0, |o| o.0);
        let view_start = self.root.buffer_views[view.value()].byte_offset.map_or(0, |o| o.0);
        let at = view_start.saturating_add(start);
        if !start.is_multiple_of(size as u64) || !at.is_multiple_of(size as u64) {
            return Err(format!("begins at byte {at} of its buffer: expected a multiple of {size}"));
        }
        if !stride.is_multiple_of(size) {
            return Err(format!("byteStride {stride}: expected a multiple of {size}"));
        }
        let end = (count as u64 - 1).checked_mul(stride as u64).and_then(|n| n.checked_add(start + row as u64));
        if start > bytes.len() as u64 || end.is_none_or(|end| end > bytes.len() as u64) {
            return Err(format!("{count} elements do not fit into a view of {} bytes", bytes.len()));
        }
        let mut out = Vec::with_capacity(count * width);
        for k in 0..count {
            let at = start as usize + k * stride;
            out.extend(bytes[at..at + row].chunks_exact(size).map(convert));
        }
        Ok(out)
    }

    /// Replaces the elements that an accessor stores apart.
    fn replace<T>(
        &self,
        sparse: &Sparse,
        layout: &Layout,
        convert: &impl Fn(&[u8]) -> T,
        out: &mut [T],
    ) -> Result<(), String> {
        let Layout { count, width, size, row } = *layout;
        let Checked::Valid(index_kind) = &sparse.indices.component_type else {
            return Err("unknown componentType of sparse indices".to_owned());
        };
        let index_size = index_kind.0.size();
        let take = |view, offset: u64, bytes_each: usize| -> Result<&[u8], String> {
            let (bytes, _) = self.view(view)?;
            let length = sparse.count.0.checked_mul(bytes_each as u64);
            length
                .and_then(|n| n.checked_add(offset))
                .and_then(|end| bytes.get(usize::try_from(offset).ok()?..usize::try_from(end).ok()?))
                .ok_or_else(|| format!("{} sparse elements do not fit into their view", sparse.count.0))
        };
        let indices = take(sparse.indices.buffer_view, sparse.indices.byte_offset.0, index_size)?;
        let values = take(sparse.values.buffer_view, sparse.values.byte_offset.0, row)?;
        for (at, value) in indices.chunks_exact(index_size).zip(values.chunks_exact(row)) {
            let at = number(at, index_kind.0) as usize;
            let slots = out.get_mut(at * width..(at + 1) * width);
            let slots = slots.ok_or_else(|| format!("sparse index {at} of {count}"))?;
            for (slot, bytes) in slots.iter_mut().zip(value.chunks_exact(size)) {
                *slot = convert(bytes);
            }
        }
        Ok(())
    }
}

/// How the elements of an accessor lie in memory.
#[derive(Clone, Copy)]
struct Layout {
    count: usize,
    /// Numbers of an element, bytes of a number and of an element.
    width: usize,
    size: usize,
    row: usize,
}

impl Layout {
    fn of(accessor: &Accessor, component: ComponentType, kind: Type) -> Result<Self, String> {
        let (width, size) = (kind.multiplicity(), component.size());
        let count = usize::try_from(accessor.count.0).map_err(|e| e.to_string())?;
        if count == 0 {
            return Err("count is 0".to_owned());
        }
        Ok(Self { count, width, size, row: width * size })
    }
}

/// Up to four bytes, and zeros.
fn four(bytes: &[u8]) -> [u8; 4] {
    bytes.try_into().unwrap_or_else(|_| {
        let mut raw = [0; 4];
        raw[..bytes.len()].copy_from_slice(bytes);
        raw
    })
}

fn number(bytes: &[u8], component: ComponentType) -> f64 {
    let raw = four(bytes);
    match component {
        ComponentType::I8 => f64::from(raw[0] as i8),
        ComponentType::U8 => f64::from(raw[0]),
        ComponentType::I16 => f64::from(i16::from_le_bytes([raw[0], raw[1]])),
        ComponentType::U16 => f64::from(u16::from_le_bytes([raw[0], raw[1]])),
        ComponentType::U32 => f64::from(u32::from_le_bytes(raw)),
        ComponentType::F32 => f64::from(f32::from_le_bytes(raw)),
    }
}

/// The rest of a data URI after its scheme, which may have any capitals; `None` for other URIs.
pub(crate) fn data_of(uri: &str) -> Option<&str> {
    let (scheme, data) = uri.split_at_checked("data:".len())?;
    scheme.eq_ignore_ascii_case("data:").then_some(data)
}

/// The bytes of a data URI: base64, in which blanks and line breaks mean nothing, or text. Both may have percent signs.
fn decoded(data: &str) -> Result<Vec<u8>, String> {
    let (kind, text) = data.split_once(',').ok_or("data URI has no comma")?;
    let bytes = match text.contains('%') {
        true => percent_bytes(text).ok_or("data URI has percent signs without two digits")?.into(),
        false => Cow::Borrowed(text.as_bytes()),
    };
    let is_base64 = kind.rsplit_once(';').is_some_and(|(_, last)| last.trim().eq_ignore_ascii_case("base64"));
    if !is_base64 {
        return Ok(bytes.into_owned());
    }
    let digits = match bytes.iter().any(u8::is_ascii_whitespace) {
        true => bytes.iter().copied().filter(|b| !b.is_ascii_whitespace()).collect(),
        false => bytes,
    };
    base64(&digits).ok_or_else(|| "data URI is not valid base64".to_owned())
}

/// A data URI, or a file by its path relative to the document's folder, as OBJ names them: nothing else is ever opened.
pub(crate) fn read_uri(files: &Source, path: &Path, uri: &str) -> Result<Vec<u8>, String> {
    if let Some(data) = data_of(uri) {
        return decoded(data);
    }
    if uri.contains("://") {
        return Err(format!("{uri}: only files and data URIs are read"));
    }
    let name = percent_decoded(uri).ok_or_else(|| format!("cannot read uri \"{uri}\""))?;
    let name = if Path::new(&name).is_absolute() { name } else { name.replace('\\', "/") };
    let relative = Path::new(&name);
    if relative.components().any(|c| matches!(c, Component::RootDir | Component::Prefix(_))) {
        return Err(format!("\"{name}\" is an absolute path: only relative ones are read"));
    }
    let file = files.beside(path, &name).unwrap_or_else(|| path.with_file_name("").join(relative));
    files.read(&file).map_err(|e| e.to_string())
}

pub(crate) fn percent_decoded(text: &str) -> Option<String> {
    String::from_utf8(percent_bytes(text)?).ok()
}

fn percent_bytes(text: &str) -> Option<Vec<u8>> {
    let mut out = Vec::with_capacity(text.len());
    let mut bytes = text.bytes();
    while let Some(b) = bytes.next() {
        if b == b'%' {
            let hex = [bytes.next()?, bytes.next()?];
            out.push(u8::from_str_radix(std::str::from_utf8(&hex).ok()?, 16).ok()?);
        } else {
            out.push(b);
        }
    }
    Some(out)
}

fn base64(text: &[u8]) -> Option<Vec<u8>> {
    let length = text.iter().rposition(|b| *b != b'=').map_or(0, |last| last + 1);
    let digits = &text[..length];
    let mut out = Vec::with_capacity(digits.len() * 3 / 4);
    for chunk in digits.chunks(4) {
        let mut word = 0_u32;
        for &c in chunk {
            let value = match c {
                b'A'..=b'Z' => c - b'A',
                b'a'..=b'z' => c - b'a' + 26,
                b'0'..=b'9' => c - b'0' + 52,
                b'+' | b'-' => 62,
                b'/' | b'_' => 63,
                _ => return None,
            };
            word = word << 6 | u32::from(value);
        }
        if chunk.len() == 1 {
            return None;
        }
        word <<= 6 * (4 - chunk.len());
        out.extend_from_slice(&word.to_be_bytes()[1..chunk.len()]);
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_known_texts() {
        for (text, want) in [("", ""), ("Zg==", "f"), ("Zm8=", "fo"), ("Zm9v", "foo"), ("Zm9vYmE", "fooba")] {
            assert_eq!(base64(text.as_bytes()).unwrap(), want.as_bytes());
        }
        assert!(base64(b"Zm9?").is_none() && base64(b"Z").is_none());
    }

    #[test]
    fn data_uris_as_people_write_them() {
        let uris =
            ["data:;base64,Zm9v", "DATA:a/b;charset=x;BASE64, Zm\n 9v ", "data:a/b;base64,Zm9%76", "data:,f%6Fo"];
        for uri in uris {
            assert_eq!(decoded(data_of(uri).unwrap()).unwrap(), b"foo", "{uri}");
        }
        assert!(data_of("data").is_none() && data_of("a.bin").is_none() && data_of("dat\u{e4}:,x").is_none());
        assert!(decoded("a/b;base64").is_err() && decoded(",%2").is_err() && decoded(";base64,Zm9?").is_err());
    }

    #[test]
    fn percent_signs() {
        assert_eq!(percent_decoded("Box%20With%20Spaces.bin").unwrap(), "Box With Spaces.bin");
        assert!(percent_decoded("a%2").is_none() && percent_decoded("a%zz").is_none());
    }
}
