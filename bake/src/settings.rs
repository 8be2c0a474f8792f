use crate::BakeError;

/// The form in which baked light is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Form {
    /// Reflected and own light as the emission of black materials (KHR_materials_emissive_strength): any viewer shows it.
    #[default]
    Emission,
    /// Irradiance as light maps beside the materials (MOZ_lightmap): engines multiply it by the colour.
    Lightmap,
    /// Irradiance over π as colours of vertices, of unlit materials (KHR_materials_unlit): any viewer shows it.
    VertexColors,
}

/// The settings of a [`Baker`](crate::Baker).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakeSettings {
    /// The form in which light is written.
    pub form: Form,
    /// Side of a page in texels, of a map.
    pub page: u32,
    /// Texels along a unit of length, for coordinates that are made; `None`: as many as fit one page. Of vertices the edges along a unit, at
    /// most, that [`subdivide`](Self::subdivide) makes; `None`: 512 along the longest side of the box around all surfaces.
    pub density: Option<f32>,
    /// Texels around each chart that repeat its edge.
    pub padding: u32,
    /// Points along a texel's side: a texel's value is the mean over their square, as far as it lies on the surface.
    pub samples: u32,
    /// Whether each light has maps of its own, too; all patches of a sky count as one light.
    pub per_light: bool,
    /// Whether coordinates are made also where the file has a second set.
    pub unwrap: bool,
    /// Whether double-sided surfaces have a back with light of its own: one more primitive, and single-sided materials. Surfaces of scene
    /// files, OBJ and PLY are all double-sided then. Without it both sides show the light of the front.
    pub both_sides: bool,
    /// Of colours of vertices: triangles are divided until light between their vertices differs from its interpolation by at most this part
    /// of the mean light, above 0 and at most 1. `None`: the vertices are those of the file.
    pub subdivide: Option<f32>,
    /// The most vertices that [`subdivide`](Self::subdivide) makes: the largest differences are mended first.
    pub most_vertices: u32,
}

impl Default for BakeSettings {
    /// Emission, on pages of 1024² texels, with 2 texels of padding and 2 × 2 points a texel.
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl BakeSettings {
    /// The [default](Self::default).
    pub const DEFAULT: Self = Self {
        form: Form::Emission,
        page: 1024,
        density: None,
        padding: 2,
        samples: 2,
        per_light: false,
        unwrap: false,
        both_sides: false,
        subdivide: None,
        most_vertices: 1_000_000,
    };

    /// The most vertices that a subdivision may be let make: they take 3 GB of memory while they are made.
    pub const MAX_VERTICES: u32 = 2_000_000;

    /// The largest side of a page.
    pub const MAX_PAGE: u32 = 16384;

    /// Whether all numbers are in their ranges.
    ///
    /// # Errors
    /// [`BakeError::Setting`] that names the first number that is not.
    pub fn validate(&self) -> Result<(), BakeError> {
        let fault = |name, value: &dyn core::fmt::Display, expected| {
            Err(BakeError::Setting { name, value: value.to_string(), expected })
        };
        if !(16..=Self::MAX_PAGE).contains(&self.page) {
            return fault("page", &self.page, "16 to 16384 texels a side");
        }
        if let Some(density) = self.density.filter(|density| !(*density > 0.0 && density.is_finite())) {
            return fault("density", &density, "texels a unit above 0");
        }
        if !(1..=16).contains(&self.padding) || 4 * self.padding >= self.page {
            return fault("padding", &self.padding, "1 to 16 texels, less than a quarter of the page");
        }
        if !(1..=8).contains(&self.samples) {
            return fault("points along a texel", &self.samples, "1 to 8");
        }
        if let Some(error) = self.subdivide.filter(|error| !(*error > 0.0 && *error <= 1.0)) {
            return fault("difference of subdivision", &error, "above 0 and at most 1");
        }
        if !(1..=Self::MAX_VERTICES).contains(&self.most_vertices) {
            return fault("number of vertices", &self.most_vertices, "1 to 2000000");
        }
        if self.subdivide.is_some() && self.form != Form::VertexColors {
            return fault("form", &format_args!("{:?}", self.form), "colours of vertices, which alone are subdivided");
        }
        Ok(())
    }
}
