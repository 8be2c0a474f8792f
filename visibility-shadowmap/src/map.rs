use crate::contacts::shaft_texels;
use crate::face::Face;
use crate::face_view::Item;
use crate::fit::{Fit, Triangle, corners};
use crate::layer::Layer;
use crate::options::{MapError, MapOptions, ReceiverBounds};
use crate::raster::draw;
use core::fmt;
use glam::Vec3;
use lobe_core::Sphere;
use std::sync::Arc;

/// Depth maps around one light's centre: the surfaces that its light meets first, and those hidden behind them.
///
/// One perspective image if the casters fit into it, else the needed faces of a cube, which overlap at the seams.
/// Every texel with a surface is a small blocker, see [`ShadowMapBlockers`](crate::ShadowMapBlockers).
///
/// # Cost
/// Building took 40 ms at 512², 160 ms at 1024² and 700 ms at 2048² (7 k triangles, three layers, two busy cores; a fourth layer,
/// if there is one, adds little). 8 bytes a texel and layer.
#[derive(Clone, Debug)]
pub struct ShadowMap {
    pub(crate) light: Sphere,
    /// Shared by clones.
    pub(crate) faces: Arc<[Face]>,
    resolution: u32,
    /// The box around the drawn triangles; `None` if there are none.
    casters: Option<ReceiverBounds>,
    /// The receivers that the map was fitted to.
    pub(crate) receivers: Option<ReceiverBounds>,
}

/// Whether a map is fine enough for the penumbrae of a light, see [`ShadowMap::advice`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapAdvice {
    /// The width of the shaft between receivers and light, in texels, at the blocker nearest to the light; infinite if nothing
    /// blocks.
    pub shaft_texels: f32,
    /// The resolution at which the shaft is 32 texels wide; may be above [`MapOptions::MAX_RESOLUTION`].
    pub wanted_resolution: u32,
    /// Whether the map is fine enough.
    pub fineness: MapFineness,
}

/// The 16/32-texel rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapFineness {
    /// 32 texels or more: mean error over penumbrae on floors about 0.5 % or less; on the casters themselves below 2 % from 64
    /// texels on.
    Fine,
    /// 16 to 32 texels: about 1 %, more for thin features and on the objects themselves.
    Coarse,
    /// Fewer than 16 texels: larger errors. Below 8 use another strategy.
    TooCoarse,
}

impl fmt::Display for MapAdvice {
    /// One sentence, to be shown as a warning unless the map is fine.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.fineness {
            MapFineness::Fine => write!(f, "the shadow map is fine enough"),
            _ => write!(
                f,
                "the light is {:.1} texels of the shadow map wide, penumbrae want 32: resolution {}",
                self.shaft_texels, self.wanted_resolution
            ),
        }
    }
}

/// The rule's two widths in texels.
const FINE: f64 = 32.0;
const COARSE: f64 = 16.0;
/// The required width in texels for casters close to each other.
const CONTACT: f64 = 4.5;
/// The resolution of the rough map from which the needed resolution is computed.
const ROUGH: u32 = 64;

impl ShadowMap {
    /// Draws triangles, seen from a light's centre. Winding does not matter; triangles without area, and parts inside the light,
    /// block nothing.
    ///
    /// Texel sizes come in steps of a fifth, windows begin at whole texels, and the axis of the image is one of a set of directions
    /// 2° apart. After a small motion most casters are thus drawn on the same grid, and the edges of their shadows do not jump. An
    /// image may therefore have a fifth fewer texels a side than the resolution.
    ///
    /// # Errors
    /// [`MapError`] for options out of range, a corner that does not exist, numbers that are not finite, a negative
    /// radius.
    pub fn build(
        positions: &[Vec3],
        triangles: &[[u32; 3]],
        light: Sphere,
        options: &MapOptions,
    ) -> Result<Self, MapError> {
        options.check()?;
        if !(light.center.is_finite() && light.radius.is_finite()) {
            return Err(MapError::NotFinite("the light".into()));
        }
        if light.radius < 0.0 {
            return Err(MapError::NegativeRadius);
        }
        if let Some(k) = positions.iter().position(|p| !p.is_finite()) {
            return Err(MapError::NotFinite(format!("vertex {k}")));
        }
        let bad = |t: &[u32; 3]| t.iter().copied().find(|v| *v as usize >= positions.len());
        if let Some((triangle, vertex)) = triangles.iter().enumerate().find_map(|(k, t)| bad(t).map(|v| (k, v))) {
            return Err(MapError::Index { triangle, vertex, count: positions.len() });
        }

        let center = light.center.as_dvec3();
        let radius = f64::from(light.radius);
        let all = triangles.iter().map(|t| t.map(|v| positions[v as usize].as_dvec3() - center));
        let receivers = options.receivers.map(|b| corners(&b, center));
        let largest = positions.iter().chain([&light.center]).map(|p| p.abs().max_element()).fold(0.0, f32::max);
        let mut fit =
            Fit { radius, resolution: options.resolution, receivers: receivers.as_ref(), far: f64::from(largest) };
        let casters: Vec<Triangle> = all.filter(|t| fit.needs(t, f64::from(largest))).collect();
        fit.far = casters.iter().flatten().map(|p| p.length()).fold(0.0, f64::max);
        let mut faces = if casters.is_empty() { Vec::new() } else { fit.faces(&casters) };
        for face in &mut faces {
            face.layers = draw(face, &casters, fit.near(), radius, options.layers as usize)
                .into_iter()
                .filter_map(|q| Layer::new(face.width, face.height, face.texel, q))
                .collect();
        }
        faces.retain(|face| !face.layers.is_empty());
        let casters = ReceiverBounds::of(casters.iter().flatten().map(|p| (*p + center).as_vec3()));
        let (resolution, receivers) = (options.resolution, options.receivers);
        Ok(Self { light, faces: faces.into(), resolution, casters, receivers })
    }

    /// Draws the coarsest map that is fine enough. It first draws a rough map. Then it takes the resolution, from 256 to that of
    /// the options, at which the light is 64 texels wide (see [`advice`](Self::advice)), both for receivers at the centre of the
    /// options' bounds and for receivers at the centre of the drawn casters, which are nearer to their blockers.
    ///
    /// For casters close to each other, such as rails on pickets, the light is also at least 4.5 texels wide in the penumbrae
    /// there. A long image may then be finer than the options, as long as it has no more texels than a square one. On a fence's own
    /// pickets the mean error of penumbrae is 8.9 % of the light at 2.1 texels, 3.2 % at 4, 2.5 % at 4.5 and 0.7 % at 8.3, whatever
    /// the layers and the bias. Single sheets behind each other do not raise the resolution.
    ///
    /// ```
    /// # use visibility_shadowmap::{MapOptions, ShadowMap};
    /// # use glam::Vec3;
    /// # let corners = [Vec3::Y, Vec3::Y + Vec3::X, Vec3::Y + Vec3::Z];
    /// let options = MapOptions { resolution: 2048, ..MapOptions::default() };
    /// let map = |radius| {
    ///     let light = lobe_core::Sphere { center: Vec3::new(0.0, 5.0, 0.0), radius };
    ///     ShadowMap::fitted(&corners, &[[0, 1, 2]], light, &options)
    /// };
    /// assert!(map(1.0)?.resolution() < map(0.1)?.resolution());
    /// # Ok::<(), visibility_shadowmap::MapError>(())
    /// ```
    ///
    /// # Errors
    /// As [`build`](Self::build).
    pub fn fitted(
        positions: &[Vec3],
        triangles: &[[u32; 3]],
        light: Sphere,
        options: &MapOptions,
    ) -> Result<Self, MapError> {
        options.check()?;
        let rough =
            MapOptions { resolution: options.resolution.min(ROUGH), layers: MapOptions::default().layers, ..*options };
        let rough = Self::build(positions, triangles, light, &rough)?;
        let wanted = |b: Option<ReceiverBounds>| b.map_or(0, |b| rough.advice(&b).wanted_resolution);
        let wanted = wanted(options.receivers).max(wanted(rough.casters)).saturating_mul(2);
        let contacts = shaft_texels(&rough.faces, f64::from(light.radius));
        let contacts = (f64::from(rough.resolution) * CONTACT / contacts).ceil() as u32;
        // A long image may have as many texels as a square one.
        let area = rough.faces.iter().map(|f| f.width * f.height).max().unwrap_or(0) as f64;
        let most = f64::from(options.resolution) * f64::from(rough.resolution) / area.max(1.0).sqrt();
        let most = (most as u32).clamp(options.resolution, MapOptions::MAX_RESOLUTION);
        let resolution = wanted.max(256).min(options.resolution).max(contacts.min(most));
        Self::build(positions, triangles, light, &MapOptions { resolution, ..*options })
    }

    pub(crate) fn layer(&self, item: Item) -> &Layer {
        &self.faces[usize::from(item.face)].layers[usize::from(item.layer)]
    }

    /// The resolution it was built with.
    #[must_use]
    pub fn resolution(&self) -> u32 {
        self.resolution
    }

    /// The light that the map was drawn for.
    #[must_use]
    pub fn light(&self) -> Sphere {
        self.light
    }

    /// Number of images: none without casters, one perspective, or up to six of a cube.
    #[must_use]
    pub fn faces(&self) -> usize {
        self.faces.len()
    }

    /// Depth layers in use, all faces together.
    #[must_use]
    pub fn layers(&self) -> usize {
        self.faces.iter().map(|f| f.layers.len()).sum()
    }

    /// Memory in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.faces.iter().flat_map(|f| &f.layers).map(Layer::bytes).sum()
    }

    /// Whether the map is fine enough for receivers in `bounds`.
    ///
    /// The measure is the width in texels of the shaft from the bounds' centre to the light, at the blocker nearest to the light:
    /// `w = 2r(d − z)/(d z t)` with r the light's radius, d and z the distances of receiver and blocker from the light, t the texel
    /// at distance 1. Measured mean error of penumbrae: on a floor under a bunny 1.2 % of the light at w = 7, 0.6 % at 14 and at
    /// 42, 0.4 % at 84, 0.2 % at 169; on the bunny itself 7 % at 15, 4.5 % at 31, 1.7 % at 62, 0.7 % at 123; under a picket fence
    /// 1.1 % at 11.
    #[must_use]
    pub fn advice(&self, receivers: &ReceiverBounds) -> MapAdvice {
        let middle = 0.5 * (receivers.min.as_dvec3() + receivers.max.as_dvec3());
        let light = self.light.center.as_dvec3();
        let farthest = receivers.corners().iter().map(|p| p.as_dvec3().distance(light)).fold(0.0, f64::max);
        let width = |face: &Face| {
            let nearest = face.layers.first().map_or(f32::NEG_INFINITY, Layer::nearest);
            let z = face.z0 / (1.0 + f64::from(nearest));
            // If the centre is nearer to the light than the blocker, only farther receivers can be in its shadow.
            let middle = middle.distance(light);
            let d = if middle > z { middle } else { farthest };
            2.0 * f64::from(self.light.radius) * (d - z) / (d * z * face.texel)
        };
        let widest = self.faces.iter().map(width).fold(f64::NEG_INFINITY, f64::max);
        let widest = if self.faces.is_empty() { f64::INFINITY } else { widest.max(1e-3) };
        MapAdvice {
            shaft_texels: widest as f32,
            wanted_resolution: (f64::from(self.resolution) * FINE / widest).ceil() as u32,
            fineness: match widest {
                w if w >= FINE => MapFineness::Fine,
                w if w >= COARSE => MapFineness::Coarse,
                _ => MapFineness::TooCoarse,
            },
        }
    }
}
