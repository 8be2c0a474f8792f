use glam::Vec3;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReceiverBounds {
    /// Smallest coordinates.
    pub min: Vec3,
    /// Largest coordinates.
    pub max: Vec3,
}

impl ReceiverBounds {
    /// The smallest box around points; `None` without points.
    #[must_use]
    pub fn of(points: impl IntoIterator<Item = Vec3>) -> Option<Self> {
        let mut points = points.into_iter();
        let first = points.next()?;
        Some(points.fold(Self { min: first, max: first }, |b, p| Self { min: b.min.min(p), max: b.max.max(p) }))
    }

    pub(crate) fn corners(&self) -> [Vec3; 8] {
        core::array::from_fn(|k| {
            let pick = |bit: usize, low: f32, high: f32| if k >> bit & 1 == 0 { low } else { high };
            Vec3::new(pick(0, self.min.x, self.max.x), pick(1, self.min.y, self.max.y), pick(2, self.min.z, self.max.z))
        })
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.min.is_finite() && self.max.is_finite()
    }
}

/// Options of building a map.
///
/// ```
/// use visibility_shadowmap::MapOptions;
/// assert!(MapOptions { resolution: 512, ..MapOptions::default() }.check().is_ok());
/// assert!(MapOptions { resolution: 0, ..MapOptions::default() }.check().is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapOptions {
    /// Texels along the longer side of the map; for a cube those of one whole face. 16…8192.
    /// [`ShadowMap::advice`](crate::ShadowMap::advice) reports the resolution that a light at a given distance needs. Memory: 8
    /// bytes a texel and layer, 28 bytes a texel while the map is built.
    pub resolution: u32,
    /// The most depth layers, 1…4. The first layer is the nearest surface. The second is the next surface behind it; without it the
    /// far side of an object leaks light. The third is the second surface that faces the light; without it an object behind another
    /// one leaks. The fourth is that object's far side. A layer that the scene does not need costs nothing.
    pub layers: u32,
    /// The box of all receivers. The map is fitted to the casters that can shadow them: others (the floor below, the walls around
    /// receivers and light) take no texels. `None`: receivers may be anywhere.
    pub receivers: Option<ReceiverBounds>,
}

impl Default for MapOptions {
    fn default() -> Self {
        Self { resolution: 1024, layers: 4, receivers: None }
    }
}

impl MapOptions {
    /// The largest resolution.
    pub const MAX_RESOLUTION: u32 = 8192;
    /// The smallest resolution.
    pub const MIN_RESOLUTION: u32 = 16;

    /// Checks that a map can be built with these options.
    ///
    /// # Errors
    /// [`MapError::Resolution`], [`MapError::Layers`] or [`MapError::NotFinite`], with the value.
    pub fn check(&self) -> Result<(), MapError> {
        if !(Self::MIN_RESOLUTION..=Self::MAX_RESOLUTION).contains(&self.resolution) {
            return Err(MapError::Resolution(self.resolution));
        }
        if !(1..=4).contains(&self.layers) {
            return Err(MapError::Layers(self.layers));
        }
        if self.receivers.is_some_and(|b| !b.is_finite()) {
            return Err(MapError::NotFinite("the receivers' bounds".into()));
        }
        Ok(())
    }
}

/// Why a map cannot be built.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MapError {
    /// The resolution is out of range.
    #[error("a shadow map has 16 to 8192 texels a side, not {0}")]
    Resolution(u32),
    /// The number of layers is out of range.
    #[error("a shadow map has 1 to 4 layers, not {0}")]
    Layers(u32),
    /// A triangle has a corner that the mesh does not have.
    #[error("triangle {triangle} refers to vertex {vertex} of {count}")]
    Index {
        /// Number of the triangle.
        triangle: usize,
        /// The vertex that it refers to.
        vertex: u32,
        /// Vertices in the mesh.
        count: usize,
    },
    /// A number is NaN or infinite.
    #[error("{0} is not finite")]
    NotFinite(String),
    /// The light's radius is negative.
    #[error("the light's radius is negative")]
    NegativeRadius,
}
