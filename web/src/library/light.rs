use crate::library::fault::Fault;
use glam::Vec3;
use lighting::{AmbientLight, FlatLight, Light, SphereLight, SpotLight, SunLight, TubeLight};
use lobe_core::Sphere;
use serde::Deserialize;

/// Of suns and ambient light before a renderer fits them to its objects.
const NOWHERE: Sphere = Sphere { center: Vec3::ZERO, radius: 1e-3 };

/// A light as JavaScript describes it: angles in degrees, and how bright it is by one of several units.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum LightGiven {
    Sphere {
        center: Vec3,
        radius: f32,
        radiance: Option<Vec3>,
        flux: Option<Vec3>,
    },
    Point {
        center: Vec3,
        radius: f32,
        intensity: Vec3,
    },
    Spot {
        center: Vec3,
        direction: Vec3,
        radius: f32,
        intensity: Vec3,
        angle: f32,
        inner: f32,
    },
    #[serde(rename_all = "camelCase")]
    Rectangle {
        center: Vec3,
        u: Vec3,
        v: Vec3,
        radiance: Option<Vec3>,
        flux: Option<Vec3>,
        two_sided: bool,
    },
    #[serde(rename_all = "camelCase")]
    Disc {
        center: Vec3,
        normal: Vec3,
        radius: f32,
        radiance: Option<Vec3>,
        flux: Option<Vec3>,
        two_sided: bool,
    },
    #[serde(rename_all = "camelCase")]
    Polygon {
        corners: Vec<Vec3>,
        radiance: Option<Vec3>,
        flux: Option<Vec3>,
        two_sided: bool,
    },
    Tube {
        start: Vec3,
        end: Vec3,
        radius: f32,
        radiance: Option<Vec3>,
        flux: Option<Vec3>,
    },
    Sun {
        direction: Vec3,
        angle: f32,
        radiance: Option<Vec3>,
        irradiance: Option<Vec3>,
    },
    Ambient {
        radiance: Vec3,
    },
}

/// How bright a light is.
enum Bright {
    Radiance(Vec3),
    /// The unit beside radiance that its kind has: flux, or irradiance.
    Other(Vec3),
}

fn bright(radiance: Option<Vec3>, other: Option<Vec3>) -> Result<Bright, Fault> {
    match (radiance, other) {
        (Some(radiance), None) => Ok(Bright::Radiance(radiance)),
        (None, Some(other)) => Ok(Bright::Other(other)),
        _ => Err(Fault::range("expected radiance, or its other unit")),
    }
}

fn flat(
    light: FlatLight,
    two_sided: bool,
    radiance: Option<Vec3>,
    flux: Option<Vec3>,
) -> Result<lighting::Light, Fault> {
    let light = if two_sided { light.on_both_sides() } else { light };
    Ok(match bright(radiance, flux)? {
        Bright::Radiance(radiance) => light.with_radiance(radiance),
        Bright::Other(flux) => light.with_flux(flux),
    }
    .into())
}

impl LightGiven {
    /// The light, checked as one of a scene.
    pub(crate) fn light(self) -> Result<Light, Fault> {
        let light = self.unchecked()?;
        light.kind().validate().map_err(|error| Fault::range(error.to_string()))?;
        Ok(light)
    }

    fn unchecked(self) -> Result<Light, Fault> {
        Ok(match self {
            Self::Sphere { center, radius, radiance, flux } => match bright(radiance, flux)? {
                Bright::Radiance(radiance) => SphereLight::new(Sphere { center, radius }, radiance),
                Bright::Other(flux) => SphereLight::with_flux(Sphere { center, radius }, flux),
            }
            .into(),
            Self::Point { center, radius, intensity } => {
                SphereLight::with_intensity(Sphere { center, radius }, intensity).into()
            }
            Self::Spot { center, direction: axis, radius, intensity, angle, inner } => {
                let light = SphereLight::with_intensity(Sphere { center, radius }, intensity);
                SpotLight {
                    light,
                    axis,
                    cos: [inner, angle].map(|degrees| degrees.to_radians().cos()),
                    range: f32::INFINITY,
                }
                .into()
            }
            Self::Rectangle { center, u, v, radiance, flux, two_sided } => {
                flat(FlatLight::rectangle(center, u, v, Vec3::ONE)?, two_sided, radiance, flux)?
            }
            Self::Disc { center, normal, radius, radiance, flux, two_sided } => {
                flat(FlatLight::disc(center, normal, radius, Vec3::ONE)?, two_sided, radiance, flux)?
            }
            Self::Polygon { corners, radiance, flux, two_sided } => {
                flat(FlatLight::polygon(&corners, Vec3::ONE)?, two_sided, radiance, flux)?
            }
            Self::Tube { start, end, radius, radiance, flux } => {
                let tube = TubeLight { ends: [start, end], radius, radiance: Vec3::ONE };
                match bright(radiance, flux)? {
                    Bright::Radiance(radiance) => TubeLight { radiance, ..tube },
                    Bright::Other(flux) => tube.with_flux(flux),
                }
                .into()
            }
            Self::Sun { direction, angle, radiance, irradiance } => match bright(radiance, irradiance)? {
                Bright::Radiance(radiance) => {
                    SunLight { radiance, ..SunLight::new(-direction, 0.5 * angle, radiance, NOWHERE) }
                }
                Bright::Other(irradiance) => SunLight::new(-direction, 0.5 * angle, irradiance, NOWHERE),
            }
            .into(),
            Self::Ambient { radiance } => AmbientLight { radiance, world: NOWHERE }.into(),
        })
    }
}
