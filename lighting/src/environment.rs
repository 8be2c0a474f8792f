//! Light from all around, at infinity.

mod map;
mod suns;

pub use self::map::{EnvironmentError, EnvironmentMap};

use crate::{Light, SkyLight, SkyPatch};
use glam::{DVec3, UVec2, Vec3};
use lobe_core::{LightImage, Sphere};
use std::sync::Arc;

/// A picture of all directions as lights: suns, which are small and bright, and the rest as patches of a cube's sides that show it.
///
/// Each of them has a mask of its own, as any light has. The map itself stays, for sampling.
///
/// ```
/// use glam::{DVec3, UVec2, Vec3};
/// use lighting::{Environment, EnvironmentMap};
/// use lobe_core::Sphere;
/// // Blue above, brown below.
/// let map = EnvironmentMap::new(UVec2::new(1, 2), vec![Vec3::new(0.2, 0.5, 1.0), Vec3::new(0.3, 0.2, 0.1)]).unwrap();
/// assert_eq!(map.radiance(Vec3::Y), Vec3::new(0.2, 0.5, 1.0));
/// let environment = Environment::new(map, 1, Sphere { center: Vec3::ZERO, radius: 10.0 });
/// assert_eq!(environment.lights().len(), 6);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    map: EnvironmentMap,
    behind: Behind,
    sky: EnvironmentMap,
    lights: Vec<Light>,
}

/// The picture that is seen behind all objects.
#[derive(Clone, Debug, PartialEq)]
enum Behind {
    /// The one that shines.
    Map,
    /// Another: what shines is brighter.
    Darker(EnvironmentMap),
    Nothing,
}

/// Texels along a patch's side, at least and at most.
const FEWEST: u32 = 8;
const MOST: u32 = 256;

/// Texels around of the picture without its suns, at most: an eighth of the finest step in which a sky is summed.
const AROUND: u32 = 1024;

/// Patches whose texels differ by less than this part are as bright everywhere.
const PLAIN: f32 = 1e-4;

impl Environment {
    /// The lights of a map, with `across`² patches, one at least, on each side of the cube; `world` is a sphere around all that blocks and all that is lit.
    #[must_use]
    pub fn new(map: EnvironmentMap, across: u32, world: Sphere) -> Self {
        Self::of(map, Behind::Map, across, world)
    }

    /// Ambient light that objects hide: a picture, if there is one, and as much radiance from all directions beside, which is not seen behind
    /// the objects. One search for outlines serves both.
    ///
    /// ```
    /// use glam::Vec3;
    /// use lighting::{Environment, EnvironmentMap};
    /// use lobe_core::Sphere;
    /// let world = Sphere { center: Vec3::ZERO, radius: 10.0 };
    /// let ambient = Environment::with_ambient(None, Vec3::splat(0.2), 1, world);
    /// assert_eq!((ambient.map().radiance(Vec3::X), ambient.behind()), (Vec3::splat(0.2), None));
    /// ```
    #[must_use]
    pub fn with_ambient(picture: Option<EnvironmentMap>, ambient: Vec3, across: u32, world: Sphere) -> Self {
        match picture {
            None => Self::of(EnvironmentMap::uniform(ambient), Behind::Nothing, across, world),
            Some(picture) if ambient == Vec3::ZERO => Self::new(picture, across, world),
            Some(picture) => {
                let map = picture.clone().brightened(ambient);
                Self::of(map, Behind::Darker(picture), across, world)
            }
        }
    }

    fn of(map: EnvironmentMap, behind: Behind, across: u32, world: Sphere) -> Self {
        let across = across.max(1);
        let (rest, suns) = suns::cut(&map, world);
        let mut lights: Vec<Light> = suns.into_iter().map(|sun| SkyLight::Sun(sun).into()).collect();
        // Four times as many as the map has there, since samples take whole texels.
        let side = (map.size().x / across).next_power_of_two().clamp(FEWEST, MOST);
        for axis in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z] {
            let (right, up) = axis.any_orthonormal_pair();
            for k in 0..across * across {
                let place = |k: u32| (2 * k + 1) as f32 / across as f32 - 1.0;
                let center = axis + right * place(k % across) + up * place(k / across);
                let sides = [right, up].map(|v| v / across as f32);
                lights.extend(patch(&rest, axis, center, sides, side, world).map(|p| SkyLight::Patch(p).into()));
            }
        }
        Self { sky: rest.reduced(AROUND), map, behind, lights }
    }

    /// Suns first, then patches that are not black.
    #[must_use]
    pub fn lights(&self) -> &[Light] {
        &self.lights
    }

    /// The picture without its suns, as coarse as patches are not to be: for sums over all directions.
    #[must_use]
    pub const fn sky(&self) -> &EnvironmentMap {
        &self.sky
    }

    /// Which of some lights are the patches of this environment, if all of them are there, in order and as they were made, whatever
    /// [world](SkyPatch::world) they are for. Together they are the [sky](Self::sky).
    #[must_use]
    pub fn patches_among(&self, lights: &[Light]) -> Option<Vec<bool>> {
        let mut own = self.lights.iter().filter_map(Light::sky_patch).peekable();
        let mut is_next = |light: &Light| {
            let is_it = own.peek().zip(light.sky_patch()).is_some_and(|(own, other)| own.shows_same(other));
            if is_it {
                own.next();
            }
            is_it
        };
        let among = lights.iter().map(&mut is_next).collect();
        own.next().is_none().then_some(among)
    }

    /// The picture that shines.
    #[must_use]
    pub const fn map(&self) -> &EnvironmentMap {
        &self.map
    }

    /// The picture that is seen behind all objects; none of ambient light alone.
    #[must_use]
    pub const fn behind(&self) -> Option<&EnvironmentMap> {
        match &self.behind {
            Behind::Map => Some(&self.map),
            Behind::Darker(picture) => Some(picture),
            Behind::Nothing => None,
        }
    }
}

fn patch(
    map: &EnvironmentMap,
    axis: Vec3,
    center: Vec3,
    sides: [Vec3; 2],
    texels: u32,
    world: Sphere,
) -> Option<SkyPatch> {
    let [u, v] = sides;
    let at = |x: f32, y: f32| center + u * (2.0 * x / texels as f32 - 1.0) + v * (2.0 * y / texels as f32 - 1.0);
    // As many samples of the map as it has texels there, and one in the middle of what is much smaller than these.
    let finest = (u.length() * 2.0 / texels as f32) * map.size().x as f32 / core::f32::consts::TAU;
    let samples = if finest > 0.5 { (finest.ceil() as u32 + 1).min(16) } else { 1 };
    let mut values = Vec::with_capacity((texels * texels) as usize);
    let mut vectors = [DVec3::ZERO; 3];
    let sample = (4.0 * u.length() * v.length()) / (texels * samples * texels * samples) as f32;
    for y in 0..texels {
        for x in 0..texels {
            let part = |k: u32| (k as f32 + 0.5) / samples as f32;
            let mut sum = Vec3::ZERO;
            for k in 0..samples * samples {
                let p = at(x as f32 + part(k % samples), y as f32 + part(k / samples));
                let radiance = map.radiance(p);
                sum += radiance;
                let weight = (p * (sample / p.length_squared().powi(2))).as_dvec3();
                vectors.iter_mut().zip(radiance.to_array()).for_each(|(v, l)| *v += weight * f64::from(l));
            }
            values.push(sum / (samples * samples) as f32);
        }
    }
    let (image, radiance) = LightImage::new(UVec2::splat(texels), &values)?;
    let is_plain = values.iter().all(|v| (v - radiance).abs().cmple(radiance * PLAIN).all());
    let one = |k: usize| if radiance[k] > 0.0 { vectors[k].as_vec3() / radiance[k] } else { Vec3::ZERO };
    let image = (!is_plain).then(|| Arc::new(image.with_vectors([one(0), one(1), one(2)])));
    (radiance != Vec3::ZERO).then_some(SkyPatch { axis, center, sides, radiance, image, world })
}
