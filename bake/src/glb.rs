//! A glTF document that things are added to, and the binary file that it is written as.

use crate::json::Json;
use scene_files::GltfDocument;
use serde_json::{Value, json};

/// The kinds of a GLB's chunks.
pub(crate) const JSON: u32 = 0x4e4f_534a;
pub(crate) const BINARY: u32 = 0x004e_4942;

/// A document with all that it refers to in one buffer.
#[derive(Clone, Debug)]
pub(crate) struct Document {
    /// As it was.
    pub(crate) before: Value,
    /// As it will be.
    pub(crate) json: Json,
    /// The bytes of the one buffer.
    pub(crate) binary: Vec<u8>,
}

impl Document {
    /// The document of a file. Bytes of the first buffer keep their places; those of others, and of images that are files, follow.
    pub(crate) fn new(file: &GltfDocument) -> Result<Self, serde_json::Error> {
        let before: Value = serde_json::from_str(&file.json)?;
        let mut own = Self { json: Json::parse(&file.json)?, before, binary: Vec::new() };
        own.join_buffers(&file.buffers);
        for (place, bytes) in file.images.iter().enumerate() {
            if let Some(bytes) = bytes {
                let view = own.add_view(bytes, None);
                let image = own.json.field("images").item(place);
                let Some(image) = image else { continue };
                image.remove("uri");
                *image.field("bufferView") = json!(view).into();
                if !image.has("mimeType") {
                    *image.field("mimeType") = json!(mime(bytes)).into();
                }
            }
        }
        Ok(own)
    }

    /// Puts all buffers into the first one.
    fn join_buffers(&mut self, buffers: &[Vec<u8>]) {
        let mut starts = Vec::new();
        for bytes in buffers {
            self.align();
            starts.push(self.binary.len());
            self.binary.extend_from_slice(bytes);
        }
        let views = self.before["bufferViews"].as_array().cloned().unwrap_or_default();
        for (place, view) in views.iter().enumerate() {
            let buffer = view["buffer"].as_u64().unwrap_or(0) as usize;
            let Some(start) = starts.get(buffer).filter(|_| buffer > 0) else { continue };
            let offset = view["byteOffset"].as_u64().unwrap_or(0);
            if let Some(view) = self.json.field("bufferViews").item(place) {
                *view.field("buffer") = json!(0).into();
                *view.field("byteOffset") = json!(offset + *start as u64).into();
            }
        }
        let list = self.json.field("buffers");
        if buffers.len() > 1 {
            let first = list.item(0).cloned();
            *list = json!([]).into();
            list.push(first.unwrap_or_else(|| json!({}).into()));
        }
        if let Some(first) = list.item(0).filter(|_| !buffers.is_empty()) {
            first.remove("uri");
        }
    }

    fn align(&mut self) {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
    }

    /// Adds bytes as a buffer view, for a target of a GPU or none.
    pub(crate) fn add_view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.align();
        let mut view = json!({"buffer": 0, "byteOffset": self.binary.len(), "byteLength": bytes.len()});
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.binary.extend_from_slice(bytes);
        self.json.field("bufferViews").push(view)
    }

    /// Adds a PNG image as a texture that is smooth and ends at its edges.
    pub(crate) fn add_texture(&mut self, name: &str, png: &[u8]) -> usize {
        const LINEAR: u32 = 9729;
        const CLAMP: u32 = 33071;
        let view = self.add_view(png, None);
        let sampler = json!({"magFilter": LINEAR, "minFilter": LINEAR, "wrapS": CLAMP, "wrapT": CLAMP});
        let sampler = self.json.field("samplers").push(sampler);
        let image = json!({"name": name, "bufferView": view, "mimeType": "image/png"});
        let image = self.json.field("images").push(image);
        self.json.field("textures").push(json!({"name": name, "sampler": sampler, "source": image}))
    }

    /// Lists an extension as used.
    pub(crate) fn uses(&mut self, extension: &str) {
        let list = self.json.field("extensionsUsed");
        let is_listed = list.value().as_array().is_some_and(|names| names.iter().any(|name| name == extension));
        if !is_listed {
            list.push(json!(extension));
        }
    }

    /// The binary file (glTF 2.0, §4).
    pub(crate) fn into_glb(mut self) -> Vec<u8> {
        self.align();
        if !self.binary.is_empty() {
            let buffers = self.json.field("buffers");
            if buffers.item(0).is_none() {
                buffers.push(json!({}));
            }
            if let Some(first) = buffers.item(0) {
                *first.field("byteLength") = json!(self.binary.len()).into();
            }
        }
        container(self.json.text().into_bytes(), &self.binary)
    }
}

/// A binary file of a document's text and of bytes whose number is a multiple of four, or of none.
pub(crate) fn container(mut text: Vec<u8>, bytes: &[u8]) -> Vec<u8> {
    text.resize(text.len().next_multiple_of(4), b' ');
    let binary = if bytes.is_empty() { 0 } else { 8 + bytes.len() };
    let length = 12 + 8 + text.len() + binary;
    let mut out = Vec::with_capacity(length);
    let word = |out: &mut Vec<u8>, value: u32| out.extend_from_slice(&value.to_le_bytes());
    out.extend_from_slice(b"glTF");
    word(&mut out, 2);
    word(&mut out, length as u32);
    word(&mut out, text.len() as u32);
    word(&mut out, JSON);
    out.extend_from_slice(&text);
    if binary > 0 {
        word(&mut out, bytes.len() as u32);
        word(&mut out, BINARY);
        out.extend_from_slice(bytes);
    }
    out
}

/// The kind of an image by its first bytes.
fn mime(bytes: &[u8]) -> &'static str {
    match bytes {
        [0x89, b'P', b'N', b'G', ..] => "image/png",
        [b'R', b'I', b'F', b'F', ..] => "image/webp",
        [0xab, b'K', b'T', b'X', ..] => "image/ktx2",
        _ => "image/jpeg",
    }
}
