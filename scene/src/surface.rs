use crate::{Texture, Wrap};
use brdf::Factors;
use glam::{Affine2, Vec2, Vec3};

/// A texture and how it lies on a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureMap {
    /// The image.
    pub texture: Texture,
    /// The number of the set of texture coordinates; a set that the mesh lacks is 0 everywhere.
    pub uv_set: usize,
    /// From the mesh's coordinates to the image's.
    pub transform: Affine2,
    /// The values outside the image, along u and v.
    pub wrap: [Wrap; 2],
    /// Whether nearby texels are shown as squares instead of interpolated.
    pub is_pixelated: bool,
}

/// One of the four numbers of a texture.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// The texture that it is read from.
    pub map: TextureMap,
    /// 0 red, 1 green, 2 blue, 3 alpha.
    pub index: usize,
}

/// Textures and emission of a material. The values of textures are [`Factors`] of the material's own.
///
/// Normal maps are in tangent space, x along u, y against v, z the normal: `n = 2t − 1`, x and y times a scale. The camera sees
/// emission; loading a file lets it light others ([`Scene::lights`](crate::Scene::lights)).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Of [`Factors::color`].
    pub color: Option<TextureMap>,
    /// Of [`Factors::specular`].
    pub specular: Option<TextureMap>,
    /// Of [`Factors::coat`].
    pub coat: Option<Channel>,
    /// Of [`Factors::exponent`].
    pub exponent: Option<Channel>,
    /// Of [`Factors::metallic`].
    pub metallic: Option<Channel>,
    /// Of [`Factors::roughness`].
    pub roughness: Option<Channel>,
    /// Directions along which the surface is rougher, from the tangent in red and green, 0.5 as 0, and in blue [`Factors::anisotropy`].
    pub anisotropy: Option<TextureMap>,
    /// By how much these, or the tangent, are turned: radians from growing u, against growing v.
    pub anisotropy_turn: f32,
    /// Of [`Factors::clearcoat`].
    pub clearcoat: Option<Channel>,
    /// Of [`Factors::clearcoat_roughness`].
    pub clearcoat_roughness: Option<Channel>,
    /// The normal map, and the scale of its x and y.
    pub normal: Option<(TextureMap, f32)>,
    /// The same of a clear coat, which without one keeps the mesh's normal.
    pub clearcoat_normal: Option<(TextureMap, f32)>,
    /// Radiance of its own.
    pub emission: Vec3,
    /// Its factor.
    pub emission_map: Option<TextureMap>,
    /// Whether the tangent is the direction of growing u in the first set of coordinates, so that anisotropic lobes follow the texture.
    pub follows_u: bool,
    /// Whether the emission is a picture and no light: vertex colours multiply it.
    pub is_unlit: bool,
}

/// A place on a surface, as textures see it: coordinates in a set, and their change along the sides of the pixel.
#[derive(Clone, Copy, Debug, Default)]
pub struct TexturePlace {
    /// u and v.
    pub uv: Vec2,
    /// Sides of the pixel's footprint in them.
    pub footprint: [Vec2; 2],
}

impl TextureMap {
    /// A texture that is repeated, by the first set of coordinates.
    #[must_use]
    pub const fn new(texture: Texture) -> Self {
        Self { texture, uv_set: 0, transform: Affine2::IDENTITY, wrap: [Wrap::Repeat; 2], is_pixelated: false }
    }

    /// The mean over a footprint: [`Texture::sample`].
    #[must_use]
    pub fn sample(&self, place: &dyn Fn(usize) -> TexturePlace) -> [f32; 4] {
        let TexturePlace { uv, footprint } = place(self.uv_set);
        let sides = footprint.map(|side| self.transform.transform_vector2(side));
        self.texture.sample(self.transform.transform_point2(uv), sides, self.wrap, self.is_pixelated)
    }
}

impl Channel {
    fn sample(&self, place: &dyn Fn(usize) -> TexturePlace) -> f32 {
        self.map.sample(place)[self.index.min(3)]
    }
}

fn rgb([r, g, b, _]: [f32; 4]) -> Vec3 {
    Vec3::new(r, g, b)
}

impl Surface {
    /// Whether it adds nothing to its material.
    #[must_use]
    pub fn is_plain(&self) -> bool {
        *self == Self::default()
    }

    /// Whether the material differs from place to place.
    #[must_use]
    pub fn varies(&self) -> bool {
        let channels =
            [&self.coat, &self.exponent, &self.metallic, &self.roughness, &self.clearcoat, &self.clearcoat_roughness];
        self.follows_u
            || self.anisotropy.is_some()
            || self.color.is_some()
            || self.specular.is_some()
            || channels.iter().any(|channel| channel.is_some())
    }

    /// Whether it has light of its own.
    #[must_use]
    pub fn emits(&self) -> bool {
        self.emission != Vec3::ZERO
    }

    /// Whether any texture is looked up.
    #[must_use]
    pub fn has_textures(&self) -> bool {
        let normals = self.normal.is_some() || self.clearcoat_normal.is_some();
        self.varies() || normals || self.emits() && self.emission_map.is_some()
    }

    /// Its textures, each with the name of the field that it stands in.
    pub fn textures(&self) -> impl Iterator<Item = (&'static str, &Texture)> {
        self.maps().map(|(name, map)| (name, &map.texture))
    }

    /// The same with their places on the surface.
    pub fn maps(&self) -> impl Iterator<Item = (&'static str, &TextureMap)> {
        let maps = [
            ("color", &self.color),
            ("specular", &self.specular),
            ("anisotropy", &self.anisotropy),
            ("emission", &self.emission_map),
        ];
        let channels = [
            ("coat", &self.coat),
            ("exponent", &self.exponent),
            ("metallic", &self.metallic),
            ("roughness", &self.roughness),
            ("clearcoat", &self.clearcoat),
            ("clearcoat roughness", &self.clearcoat_roughness),
        ];
        let maps = maps.into_iter().filter_map(|(name, map)| Some((name, map.as_ref()?)));
        let channels = channels.into_iter().filter_map(|(name, c)| Some((name, &c.as_ref()?.map)));
        let normals = [("normal", &self.normal), ("clearcoat normal", &self.clearcoat_normal)];
        let normals = normals.into_iter().filter_map(|(name, map)| Some((name, &map.as_ref()?.0)));
        maps.chain(channels).chain(normals)
    }

    /// The factors of the material at a place; `place` gives the coordinates of a set.
    #[must_use]
    pub fn factors(&self, place: &dyn Fn(usize) -> TexturePlace) -> Factors {
        let color = |map: &Option<TextureMap>| map.as_ref().map_or(Vec3::ONE, |map| rgb(map.sample(place)));
        let number = |channel: &Option<Channel>| channel.as_ref().map_or(1.0, |channel| channel.sample(place));
        let (metallic, roughness) = match (&self.metallic, &self.roughness) {
            // One image, as glTF has them.
            (Some(m), Some(r)) if m.map.texture.is_same(&r.map.texture) && m.map == r.map => {
                let values = m.map.sample(place);
                (values[m.index.min(3)], values[r.index.min(3)])
            }
            (m, r) => (number(m), number(r)),
        };
        Factors {
            color: color(&self.color),
            specular: color(&self.specular),
            coat: number(&self.coat),
            exponent: number(&self.exponent),
            metallic,
            roughness,
            anisotropy: self.anisotropy.as_ref().map_or(1.0, |map| map.sample(place)[2]),
            clearcoat: number(&self.clearcoat),
            clearcoat_roughness: number(&self.clearcoat_roughness),
        }
    }

    /// Radiance of its own at a place.
    #[must_use]
    pub fn emission(&self, place: &dyn Fn(usize) -> TexturePlace) -> Vec3 {
        self.emission * self.emission_map.as_ref().map_or(Vec3::ONE, |map| rgb(map.sample(place)))
    }

    /// The normal in tangent space at a place, of any length; none without a map.
    #[must_use]
    pub fn normal(&self, place: &dyn Fn(usize) -> TexturePlace) -> Option<Vec3> {
        self.normal.as_ref().map(|map| local_normal(map, place))
    }

    /// The direction along which the surface is rougher, as parts along growing u and against growing v.
    #[must_use]
    pub fn grain(&self, place: &dyn Fn(usize) -> TexturePlace) -> Vec2 {
        let own = self.anisotropy.as_ref().map_or(Vec2::X, |map| 2.0 * rgb(map.sample(place)).truncate() - Vec2::ONE);
        Vec2::from_angle(self.anisotropy_turn).rotate(own)
    }

    /// The same of a clear coat.
    #[must_use]
    pub fn clearcoat_normal(&self, place: &dyn Fn(usize) -> TexturePlace) -> Option<Vec3> {
        self.clearcoat_normal.as_ref().map(|map| local_normal(map, place))
    }
}

fn local_normal((map, scale): &(TextureMap, f32), place: &dyn Fn(usize) -> TexturePlace) -> Vec3 {
    let n = 2.0 * rgb(map.sample(place)) - Vec3::ONE;
    Vec3::new(n.x * scale, n.y * scale, n.z)
}
