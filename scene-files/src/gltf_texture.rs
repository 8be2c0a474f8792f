//! Textures of a glTF document.

use crate::files::Source;
use crate::gltf_buffers::{Buffers, data_of, percent_decoded, read_uri};
use crate::image_file;
use glam::{Affine2, Vec2};
use gltf::json::extensions::texture::TextureTransform;
use gltf::json::texture::{MagFilter, Sampler, WrappingMode};
use gltf::json::validation::Checked;
use gltf::json::{Index, Root, texture};
use scene::{Encoding, Texture, TextureMap, Wrap};
use std::collections::HashMap;
use std::path::Path;

/// The images of a document that were used so far, decoded once for each encoding.
pub(crate) struct Images<'a> {
    files: Source,
    path: &'a Path,
    root: &'a Root,
    known: HashMap<(usize, bool), Option<Texture>>,
    /// Warnings about images that do not exist.
    pub(crate) notes: Vec<String>,
}

/// A reference to a texture, from any kind of field.
pub(crate) struct Reference<'a> {
    index: usize,
    uv_set: u32,
    transform: Option<&'a TextureTransform>,
}

impl<'a> Reference<'a> {
    pub(crate) fn new(index: Index<texture::Texture>, uv_set: u32) -> Self {
        Self { index: index.value(), uv_set, transform: None }
    }
}

impl<'a> From<&'a texture::Info> for Reference<'a> {
    fn from(info: &'a texture::Info) -> Self {
        let transform = info.extensions.as_ref().and_then(|e| e.texture_transform.as_ref());
        Self { transform, ..Self::new(info.index, info.tex_coord) }
    }
}

impl<'a> Images<'a> {
    pub(crate) fn new(files: &Source, path: &'a Path, root: &'a Root) -> Self {
        Self { files: files.clone(), path, root, known: HashMap::new(), notes: Vec::new() }
    }

    /// A texture, and the number of its image if it names one. A document that names a missing texture is broken.
    pub(crate) fn source(&self, index: usize) -> Result<(&'a texture::Texture, Option<usize>), String> {
        let texture = self.root.textures.get(index).ok_or_else(|| format!("there is no texture {index}"))?;
        match texture.source.value() {
            // The document reader takes this number for a source that is not named.
            image if image == u32::MAX as usize => Ok((texture, None)),
            image if image >= self.root.images.len() => Err(format!("texture {index}: there is no image {image}")),
            image => Ok((texture, Some(image))),
        }
    }

    /// The texture of a reference, and its placement. `None` without a reference, and with a warning where the image is missing or its
    /// format is not read.
    pub(crate) fn map(
        &mut self,
        buffers: &Buffers<'_>,
        reference: Option<Reference<'_>>,
        encoding: Encoding,
    ) -> Result<Option<TextureMap>, String> {
        let Some(reference) = reference else { return Ok(None) };
        let index = reference.index;
        let (texture, Some(image)) = self.source(index)? else {
            self.note(format!("texture {index} has no image that is read: its factor is taken alone"));
            return Ok(None);
        };
        let key = (image, encoding == Encoding::Srgb);
        let texture_of = match self.known.get(&key) {
            Some(known) => known.clone(),
            None => {
                let decoded = self.decode(buffers, image, encoding)?;
                self.known.insert(key, decoded.clone());
                decoded
            }
        };
        let Some(pixels) = texture_of else { return Ok(None) };
        let mut map = TextureMap { uv_set: reference.uv_set as usize, ..TextureMap::new(pixels) };
        if let Some(sampler) = texture.sampler {
            let s = sampler.value();
            let sampler =
                self.root.samplers.get(s).ok_or_else(|| format!("texture {index}: there is no sampler {s}"))?;
            map.wrap = wraps(sampler).map_err(|e| format!("sampler {s}: {e}"))?;
            map.is_pixelated = matches!(sampler.mag_filter, Some(Checked::Valid(MagFilter::Nearest)));
        }
        if let Some(transform) = reference.transform {
            let [x, y] = transform.offset.0;
            let ([sx, sy], angle) = (transform.scale.0, transform.rotation.0);
            // Turned against the clock as seen, where v points down.
            let (s, c) = angle.sin_cos();
            let axes = (Vec2::new(c, -s) * sx, Vec2::new(s, c) * sy);
            map.transform = Affine2 { matrix2: glam::Mat2::from_cols(axes.0, axes.1), translation: Vec2::new(x, y) };
            if !map.transform.is_finite() {
                return Err(format!("texture {index}: its transform is not finite"));
            }
            map.uv_set = transform.tex_coord.map_or(map.uv_set, |set| set as usize);
        }
        Ok(Some(map))
    }

    /// The document's file.
    pub(crate) const fn path(&self) -> &'a Path {
        self.path
    }

    /// Adds a warning that appears once.
    pub(crate) fn note(&mut self, note: String) {
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }

    fn decode(&mut self, buffers: &Buffers<'_>, index: usize, encoding: Encoding) -> Result<Option<Texture>, String> {
        let image = &self.root.images[index];
        let fault = |e: String| format!("image {index}: {e}");
        let name = match (&image.name, &image.uri) {
            (Some(name), _) if !name.is_empty() => name.clone(),
            (_, Some(uri)) if data_of(uri).is_none() => uri.clone(),
            _ => format!("{index}"),
        };
        let bytes = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => match read_uri(&self.files, self.path, uri) {
                Ok(bytes) => bytes,
                // A model may come without its images.
                Err(e) if data_of(uri).is_none() && self.is_missing(uri) => {
                    self.note(format!("image {index} is not there: its factor is taken alone ({e})"));
                    return Ok(None);
                }
                Err(e) => return Err(fault(e)),
            },
            (None, Some(view)) => buffers.view(view).map_err(fault)?.0.to_vec(),
            (None, None) => return Err(fault("has neither uri nor bufferView".to_owned())),
        };
        let ending = image.uri.as_deref().and_then(|uri| uri.rsplit_once('.')).map_or("", |(_, ending)| ending);
        image_file::decode(&name, ending, &bytes, encoding, &self.files.budget).map(Some)
    }

    fn is_missing(&self, uri: &str) -> bool {
        percent_decoded(uri).is_some_and(|name| self.files.beside(self.path, &name).is_none())
    }
}

fn wraps(sampler: &Sampler) -> Result<[Wrap; 2], String> {
    let wrap = |mode: &Checked<WrappingMode>| match mode {
        Checked::Valid(WrappingMode::Repeat) => Ok(Wrap::Repeat),
        Checked::Valid(WrappingMode::MirroredRepeat) => Ok(Wrap::Mirror),
        Checked::Valid(WrappingMode::ClampToEdge) => Ok(Wrap::Clamp),
        Checked::Invalid => Err("unknown wrapping mode".to_owned()),
    };
    Ok([wrap(&sampler.wrap_s)?, wrap(&sampler.wrap_t)?])
}
