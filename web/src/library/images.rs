//! Images on materials as JavaScript describes them.

use crate::library::fault::Fault;
use crate::library::mail::{Arrays, Span};
use glam::Vec3;
use scene::{Channel, Encoding, Surface, Texture, TextureMap};
use serde::Deserialize;

/// Images that the values of a material multiply.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct ImagesGiven {
    color: Option<Texels>,
    specular: Option<Texels>,
    emission: Option<Texels>,
    normal: Option<Texels>,
    roughness: Option<Texels>,
    metallic: Option<Texels>,
    normal_scale: f32,
}

/// An image, the upper row first: one, three or four bytes a texel, of which the fourth has no say.
#[derive(Clone, Copy, Debug, Deserialize)]
struct Texels {
    width: u32,
    height: u32,
    data: Span,
}

impl ImagesGiven {
    /// A surface with these images.
    pub(crate) fn on(self, plain: Surface, arrays: Arrays<'_>) -> Result<Surface, Fault> {
        let map = |name, texels: Option<Texels>, encoding| {
            texels.map(|texels| texels.map(name, encoding, arrays)).transpose()
        };
        // As in glTF, roughness is green and metallic blue where an image has colours.
        let channel = |name, texels, index| {
            Ok::<_, Fault>(map(name, texels, Encoding::Linear)?.map(|map| Channel { map, index }))
        };
        let emission_map = map("emission", self.emission, Encoding::Srgb)?;
        // As in files, the image alone is the radiance.
        let is_radiance = emission_map.is_some() && plain.emission == Vec3::ZERO;
        Ok(Surface {
            color: map("color", self.color, Encoding::Srgb)?,
            specular: map("specular", self.specular, Encoding::Srgb)?,
            normal: map("normal", self.normal, Encoding::Linear)?.map(|map| (map, self.normal_scale)),
            roughness: channel("roughness", self.roughness, 1)?,
            metallic: channel("metallic", self.metallic, 2)?,
            emission: if is_radiance { Vec3::ONE } else { plain.emission },
            emission_map,
            ..plain
        })
    }
}

impl Texels {
    fn map(self, name: &str, encoding: Encoding, arrays: Arrays<'_>) -> Result<TextureMap, Fault> {
        let Self { width, height, data } = self;
        let sides = 1..=Texture::MAX_SIDE;
        if !(sides.contains(&width) && sides.contains(&height)) {
            let most = Texture::MAX_SIDE;
            return Err(Fault::range(format!("{name} has {width} x {height} texels: expected 1 to {most} a side")));
        }
        let (bytes, count) = (arrays.bytes(data)?, width as usize * height as usize);
        let texels: Vec<[u8; 4]> = match bytes.len() / count {
            1 => bytes.iter().map(|t| [*t, *t, *t, u8::MAX]).collect(),
            wide => bytes.chunks_exact(wide.max(3)).map(|t| [t[0], t[1], t[2], u8::MAX]).collect(),
        };
        if texels.len() != count || !bytes.len().is_multiple_of(count) {
            let have = bytes.len();
            return Err(Fault::range(format!(
                "{name} has {have} bytes: expected 1, 3 or 4 for each of {count} texels"
            )));
        }
        Ok(TextureMap::new(Texture::new(name, [width, height], texels, encoding)))
    }
}
