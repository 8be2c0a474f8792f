//! The lights of a scene file.

use crate::animation::{LightMover, LightPlace};
use crate::keys::Keys;
use crate::mesh::MAX_COORDINATE;
use crate::origin::Origins;
use crate::scene::check_balls;
use crate::toml_reader::{Table, Value};
use crate::{Bounds, SceneError};
use glam::{DVec3, Mat4, Vec3};
use lighting::{FlatLight, Light, SphereLight, SpotLight, SunLight, TubeLight};
use lobe_core::{LightLobes, Sphere};
use std::f64::consts::PI;

/// Radius of a point or a spot that states none.
const POINT: f32 = 0.01;

const KINDS: &str =
    "\"sphere\", \"spheres\", \"rectangle\", \"disc\", \"polygon\", \"tube\", \"point\", \"spot\" or \"sun\"";

/// Appends a light; what moves it, if anything does.
pub(crate) fn read_light(
    mut t: Table<'_>,
    origin: DVec3,
    bounds: &Bounds,
    lights: &mut Vec<Light>,
) -> Result<Option<LightMover>, SceneError> {
    let kind = t.require("kind")?;
    let (origins, own, value) = match kind.string()? {
        "sphere" => {
            let (center, radius) = (t.require("center")?, t.require("radius")?);
            let origins = Origins::of(origin, center.place()?);
            let balls = vec![Sphere { center: center.relative(origins.own)?, radius: radius.positive()? }];
            let (own, value) = balls_of(&mut t, center, balls, &["radiance", "flux"])?;
            (origins, own, value)
        }
        "spheres" => {
            let list = t.require("spheres")?;
            let origins = Origins::of(origin, list.first_place()?);
            let balls = list.spheres(origins.own)?;
            let (own, value) = balls_of(&mut t, list, balls, &["radiance", "flux"])?;
            (origins, own, value)
        }
        "point" => {
            let center = t.require("center")?;
            let radius = t.get("radius").map_or(Ok(POINT), |v| v.positive())?;
            let origins = Origins::of(origin, center.place()?);
            let balls = vec![Sphere { center: center.relative(origins.own)?, radius }];
            let (own, value) = balls_of(&mut t, center, balls, &["intensity", "flux", "radiance"])?;
            (origins, own, value)
        }
        "spot" => {
            let center = t.require("center")?;
            let radius = t.get("radius").map_or(Ok(POINT), |v| v.positive())?;
            let origins = Origins::of(origin, center.place()?);
            let balls = vec![Sphere { center: center.relative(origins.own)?, radius }];
            let axis = t.require("direction")?.nonzero_vec3()?.normalize();
            let cos = read_spot(&mut t)?;
            let (own, value) = balls_of(&mut t, center, balls, &["intensity", "radiance"])?;
            let spot = |light| match light {
                Light::Sphere(light) => SpotLight { light, axis, cos }.into(),
                other => other,
            };
            (origins, own.into_iter().map(spot).collect(), value)
        }
        "rectangle" => {
            let center = t.require("center")?;
            let origins = Origins::of(origin, center.place()?);
            let at = center.relative(origins.own)?;
            let [u, v] = [t.require("u")?.vec3()?, t.require("v")?.vec3()?];
            let light = FlatLight::rectangle(at, u, v, Vec3::ONE).map_err(|e| center.error(e))?;
            let (light, value) = flat(&mut t, light)?;
            (origins, vec![light], value)
        }
        "disc" => {
            let center = t.require("center")?;
            let origins = Origins::of(origin, center.place()?);
            let at = center.relative(origins.own)?;
            let normal = t.require("normal")?.nonzero_vec3()?;
            let radius = t.require("radius")?.positive()?;
            let light = FlatLight::disc(at, normal, radius, Vec3::ONE).map_err(|e| center.error(e))?;
            let (light, value) = flat(&mut t, light)?;
            (origins, vec![light], value)
        }
        "polygon" => {
            let list = t.require("corners")?;
            let places = list.elements("[[x, y, z], …]")?;
            let first = places.first().ok_or_else(|| list.error("expected 3 corners or more"))?.place()?;
            let origins = Origins::of(origin, first);
            let corners = places.iter().map(|p| p.relative(origins.own)).collect::<Result<Vec<_>, _>>()?;
            let light = FlatLight::polygon(&corners, Vec3::ONE).map_err(|e| list.error(e))?;
            let (light, value) = flat(&mut t, light)?;
            (origins, vec![light], value)
        }
        "tube" => {
            let (from, to) = (t.require("from")?, t.require("to")?);
            let origins = Origins::of(origin, from.place()?);
            let ends = [from.relative(origins.own)?, to.relative(origins.own)?];
            let radius = t.require("radius")?.positive()?;
            if ends[0].distance(ends[1]) <= 1e-4 * radius {
                return Err(to.error("a tube has two ends: this one is the other"));
            }
            let (unit, value) = t.one_of(&["radiance", "flux"])?;
            let color = value.color()?;
            let light = TubeLight { ends, radius, radiance: color };
            let light = if unit == "flux" { light.with_flux(color) } else { light };
            (origins, vec![light.into()], value)
        }
        "sun" => {
            let along = t.require("direction")?.nonzero_vec3()?.normalize();
            let degrees = match t.get("angle") {
                None => SunLight::HALF_ANGLE,
                Some(v) => match v.positive()? {
                    angle if (1e-3..=120.0).contains(&angle) => 0.5 * angle,
                    angle => return Err(v.error(format!("{angle} must lie between 0.001 and 120 degrees"))),
                },
            };
            let (unit, value) = t.one_of(&["irradiance", "radiance"])?;
            let color = value.color()?;
            let world = Sphere { center: bounds.center(), radius: bounds.radius() };
            let light = SunLight::new(-along, degrees, color, world);
            let light = if unit == "radiance" { SunLight { radiance: color, ..light } } else { light };
            (Origins::of(origin, DVec3::ZERO), vec![light.into()], value)
        }
        other => {
            return Err(kind.error(format!("unknown kind of light \"{other}\": expected {KINDS}")));
        }
    };
    let keys = Keys::read(&mut t)?;
    t.finish()?;
    if !own.iter().all(|light| light.full_radiance().is_finite()) {
        return Err(value.error("the light's radiance is too large for single precision"));
    }
    let is_far = |light: &Light| light.bounds().center.abs().max_element() > MAX_COORDINATE;
    if own.iter().any(|light| !matches!(light, Light::Sun(_)) && is_far(light)) {
        return Err(kind.error("coordinates of the light must lie within ±1e9"));
    }
    let first = lights.len();
    // Where they stand: their own coordinates are the world's.
    let shift = Mat4::from_translation(crate::origin::relative(DVec3::ZERO, origins.shift()));
    lights.extend(own.iter().map(|light| light.moved(shift)));
    keys.map(|keys| Ok(LightMover { first, lights: own, placement: LightPlace::Keys(keys.rigid_placement(origins)?) }))
        .transpose()
}

/// Balls in one of some units.
fn balls_of<'s>(
    t: &mut Table<'s>,
    place: Value<'s>,
    balls: Vec<Sphere>,
    units: &[&'static str],
) -> Result<(Vec<Light>, Value<'s>), SceneError> {
    check_balls(&balls).map_err(|e| place.error(e))?;
    let (unit, value) = t.one_of(units)?;
    let color = value.color()?;
    // In f64, since squares of small radii leave f32.
    let squares: f64 = balls.iter().map(|b| f64::from(b.radius).powi(2)).sum();
    let radiance = match unit {
        // L = Φ/(4π²·Σr²).
        "flux" => (color.as_dvec3() / (4.0 * PI.powi(2) * squares)).as_vec3(),
        // L = I/(πr²).
        "intensity" => (color.as_dvec3() / (PI * squares)).as_vec3(),
        _ => color,
    };
    Ok((balls.into_iter().map(|ball| SphereLight::new(ball, radiance).into()).collect(), value))
}

/// Sides and unit of a flat light.
fn flat<'s>(t: &mut Table<'s>, light: FlatLight) -> Result<(Light, Value<'s>), SceneError> {
    let two_sided = t.get("two_sided").map_or(Ok(false), |v| v.boolean())?;
    let light = if two_sided { light.on_both_sides() } else { light };
    let (unit, value) = t.one_of(&["radiance", "flux"])?;
    let color = value.color()?;
    let light = if unit == "flux" { light.with_flux(color) } else { light.with_radiance(color) };
    Ok((light.into(), value))
}

/// Cosines of a spot's half-angles: `angle`, where it ends, and `inner`, where it begins to.
fn read_spot(t: &mut Table<'_>) -> Result<[f32; 2], SceneError> {
    let outer = t.require("angle")?;
    let inner = t.get("inner");
    let end = outer.positive()?;
    if end > 90.0 {
        return Err(outer.error(format!("{end} must lie between 0 and 90 degrees: it is half of the spot's angle")));
    }
    let begin = inner.map_or(Ok(0.0), |v| v.number())?;
    if !(0.0..=end).contains(&begin) {
        let place = inner.unwrap_or(outer);
        return Err(place.error(format!("{begin} must lie between 0 and angle, which is {end} degrees")));
    }
    Ok([begin, end].map(|degrees| degrees.to_radians().cos()))
}
