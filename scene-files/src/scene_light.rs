//! The lights of a scene file.

use crate::emission::emitted;
use crate::files::Source;
use crate::keys::Keys;
use crate::scene_environment::{read_environment, read_linear};
use crate::toml_reader::{Table, Value};
use glam::{DVec3, Mat4, Vec3};
use lighting::{
    AmbientLight, Environment, EnvironmentMap, FlatLight, Light, SphereLight, SpotLight, SunLight, TubeLight,
};
use lobe_core::{LightImage, Sphere};
use scene::motion::{LightMover, LightPlace, Mover, Origins};
use scene::{Bounds, MAX_COORDINATE, Object, Scene, SceneError, Surface};
use shading::LightLobes;
use std::cell::RefCell;
use std::f64::consts::PI;
use std::path::Path;
use std::sync::Arc;

/// Radius of a point or a spot that states none.
const POINT: f32 = 0.01;

const KINDS: &str = "\"sphere\", \"spheres\", \"rectangle\", \"disc\", \"polygon\", \"tube\", \"point\", \"spot\", \"sun\", \"ambient\" or \
                     \"environment\"";

/// The lights of a scene file.
#[derive(Default)]
pub(crate) struct SceneLights {
    pub(crate) lights: Vec<Light>,
    pub(crate) movers: Vec<LightMover>,
    sky: Option<Sky>,
}

/// Light from all around that objects hide, of all tables together.
struct Sky {
    /// The place of its lights among the others.
    first: usize,
    picture: Option<(EnvironmentMap, u32)>,
    ambient: Vec3,
}

/// Patches along each side of the cube of ambient light: it is the same everywhere.
const AMBIENT_PATCHES: u32 = 1;

/// The context of a light's keys: the file, the origin of the scene's coordinates and the box around its objects.
pub(crate) struct Around<'a> {
    pub(crate) files: &'a Source,
    pub(crate) path: &'a Path,
    pub(crate) origin: DVec3,
    pub(crate) bounds: &'a Bounds,
    /// Lines about what was replaced in images.
    pub(crate) notes: &'a RefCell<Vec<String>>,
}

/// Lights in their own coordinates, and the key that says how bright they are.
struct Own<'s> {
    origins: Origins,
    lights: Vec<Light>,
    value: Value<'s>,
}

impl Own<'_> {
    /// The lights as far as their range.
    fn ranged(self, t: &mut Table<'_>) -> Result<Self, SceneError> {
        let Some(range) = t.get("range").map(|v| v.positive()).transpose()? else { return Ok(self) };
        let ranged = |light| match light {
            Light::Sphere(light) => SpotLight::everywhere(light, range).into(),
            Light::Spot(light) => SpotLight { range, ..light }.into(),
            other => other,
        };
        Ok(Self { lights: self.lights.into_iter().map(ranged).collect(), ..self })
    }
}

impl SceneLights {
    /// Appends a light and its motion.
    pub(crate) fn read(&mut self, mut t: Table<'_>, around: &Around<'_>) -> Result<(), SceneError> {
        let kind = t.require("kind")?;
        let world = around.bounds.sphere();
        let own = match kind.string()? {
            "sphere" => sphere(&mut t, around, None, &["radiance", "flux"])?.ranged(&mut t)?,
            "point" => sphere(&mut t, around, Some(POINT), &["intensity", "flux", "radiance"])?.ranged(&mut t)?,
            "spot" => spot(&mut t, around)?.ranged(&mut t)?,
            "spheres" => {
                let list = t.require("spheres")?;
                let origins = Origins::of(around.origin, list.first_place()?);
                let (lights, value) = sphere_lights(&mut t, list, list.spheres(origins.own)?, &["radiance", "flux"])?;
                Own { origins, lights, value }
            }
            "rectangle" => rectangle(&mut t, around)?,
            "disc" => disc(&mut t, around)?,
            "polygon" => polygon(&mut t, around)?,
            "tube" => tube(&mut t, around)?,
            "sun" => sun(&mut t, around, world)?,
            "ambient" => {
                let radiance = t.require("radiance")?.color()?;
                if t.get("occluded").map_or(Ok(false), |v| v.boolean())? {
                    self.sky().ambient += radiance;
                } else {
                    self.lights.push(AmbientLight { radiance, world }.into());
                }
                return t.finish();
            }
            "environment" => {
                if self.sky().picture.is_some() {
                    return Err(kind.error("there is an environment already: a scene has one"));
                }
                self.sky().picture = Some(read_environment(&mut t, around)?);
                return t.finish();
            }
            other => {
                return Err(kind.error(format!("unknown kind of light \"{other}\": expected {KINDS}")));
            }
        };
        self.place(t, kind, own)
    }

    fn sky(&mut self) -> &mut Sky {
        let first = self.lights.len();
        self.sky.get_or_insert(Sky { first, picture: None, ambient: Vec3::ZERO })
    }

    /// The environment of all tables, whose lights take their place among the others; `bounds` is around all that blocks and is lit.
    pub(crate) fn environment(&mut self, bounds: &Bounds) -> Option<Arc<Environment>> {
        let Sky { first, picture, ambient } = self.sky.take()?;
        let (picture, across) = picture.map_or((None, AMBIENT_PATCHES), |(picture, across)| (Some(picture), across));
        let environment = Environment::with_ambient(picture, ambient, across, bounds.sphere());
        let lights = environment.lights();
        self.movers.iter_mut().filter(|mover| mover.first >= first).for_each(|mover| mover.first += lights.len());
        self.lights.splice(first..first, lights.iter().cloned());
        Some(Arc::new(environment))
    }

    /// Appends the lights of an object whose material emits. Returns the relative error of lights inside the object, which then must
    /// not block.
    pub(crate) fn emit(
        &mut self,
        object: (usize, &Object),
        surface: &Surface,
        key: Value<'_>,
        mover: Option<&Mover>,
    ) -> Result<Option<f32>, SceneError> {
        // Clips are not posed yet.
        let lamp = emitted(object, surface, mover, &[]).map_err(|reason| key.error(reason))?;
        let inside = lamp.inside;
        lamp.add(&mut self.lights, &mut self.movers);
        Ok(inside)
    }

    fn place(&mut self, mut t: Table<'_>, kind: Value<'_>, own: Own<'_>) -> Result<(), SceneError> {
        let Own { origins, lights: own, value } = own;
        let keys = Keys::read(&mut t)?;
        t.finish()?;
        if !own.iter().all(|light| light.full_radiance().is_finite()) {
            return Err(value.error("the light's radiance is too large for single precision"));
        }
        let is_far = |light: &Light| light.bounds().center.abs().max_element() > MAX_COORDINATE;
        if own.iter().any(|light| !matches!(light, Light::Sun(_)) && is_far(light)) {
            return Err(kind.error("coordinates of the light must lie within ±1e9"));
        }
        let first = self.lights.len();
        // Their own coordinates are the world's.
        let shift = Mat4::from_translation(crate::origin::relative(DVec3::ZERO, origins.shift()));
        self.lights.extend(own.iter().map(|light| light.moved(shift)));
        if let Some(keys) = keys {
            let placement = LightPlace::Keys(keys.rigid_placement(origins)?);
            self.movers.push(LightMover { first, lights: own, placement });
        }
        Ok(())
    }
}

/// A sphere; `radius` is its default radius.
fn sphere<'s>(
    t: &mut Table<'s>,
    around: &Around<'_>,
    radius: Option<f32>,
    units: &[&'static str],
) -> Result<Own<'s>, SceneError> {
    let center = t.require("center")?;
    let radius = match radius {
        None => t.require("radius")?.positive()?,
        Some(usual) => t.get("radius").map_or(Ok(usual), |v| v.positive())?,
    };
    let origins = Origins::of(around.origin, center.place()?);
    let spheres = vec![Sphere { center: center.relative(origins.own)?, radius }];
    let (lights, value) = sphere_lights(t, center, spheres, units)?;
    Ok(Own { origins, lights, value })
}

fn spot<'s>(t: &mut Table<'s>, around: &Around<'_>) -> Result<Own<'s>, SceneError> {
    let axis = t.require("direction")?.direction()?;
    let cos = read_spot(t)?;
    let own = sphere(t, around, Some(POINT), &["intensity", "radiance"])?;
    let spot = |light| match light {
        Light::Sphere(light) => SpotLight { light, axis, cos, range: f32::INFINITY }.into(),
        other => other,
    };
    Ok(Own { lights: own.lights.into_iter().map(spot).collect(), ..own })
}

fn rectangle<'s>(t: &mut Table<'s>, around: &Around<'_>) -> Result<Own<'s>, SceneError> {
    let center = t.require("center")?;
    let origins = Origins::of(around.origin, center.place()?);
    let at = center.relative(origins.own)?;
    let (key_u, key_v) = (t.require("u")?, t.require("v")?);
    let [u, v] = Value::half_sides(&key_u, &key_v)?;
    let light = FlatLight::rectangle(at, u, v, Vec3::ONE).map_err(|e| center.error(e))?;
    flat(t, light, origins, around)
}

fn disc<'s>(t: &mut Table<'s>, around: &Around<'_>) -> Result<Own<'s>, SceneError> {
    let center = t.require("center")?;
    let origins = Origins::of(around.origin, center.place()?);
    let at = center.relative(origins.own)?;
    let normal = t.require("normal")?.direction()?;
    let radius = t.require("radius")?.positive()?;
    let light = FlatLight::disc(at, normal, radius, Vec3::ONE).map_err(|e| center.error(e))?;
    flat(t, light, origins, around)
}

fn polygon<'s>(t: &mut Table<'s>, around: &Around<'_>) -> Result<Own<'s>, SceneError> {
    let list = t.require("corners")?;
    let places = list.elements("[[x, y, z], …]")?;
    let first = places.first().ok_or_else(|| list.error("expected 3 corners or more"))?.place()?;
    let origins = Origins::of(around.origin, first);
    let corners = places.iter().map(|p| p.relative(origins.own)).collect::<Result<Vec<_>, _>>()?;
    let light = FlatLight::polygon(&corners, Vec3::ONE).map_err(|e| list.error(e))?;
    flat(t, light, origins, around)
}

/// Sides, image and unit of a flat light.
fn flat<'s>(t: &mut Table<'s>, light: FlatLight, origins: Origins, around: &Around<'_>) -> Result<Own<'s>, SceneError> {
    let two_sided = t.get("two_sided").map_or(Ok(false), |v| v.boolean())?;
    let light = if two_sided { light.on_both_sides() } else { light };
    let (light, mean) = match t.get("image") {
        None => (light, Vec3::ONE),
        Some(image) => {
            let (size, texels) = read_linear(image, around)?;
            // Files begin with the top row.
            let rows = texels.chunks_exact(size.x as usize).rev();
            let (shown, mean) = LightImage::new(size, &rows.flatten().copied().collect::<Vec<_>>())
                .ok_or_else(|| image.error("an image of light has finite pixels that are not negative"))?;
            let fault = "only rectangles with right angles show images";
            (light.showing(Arc::new(shown)).ok_or_else(|| image.error(fault))?, mean)
        }
    };
    let (unit, value) = t.one_of(&["radiance", "flux"])?;
    let color = value.color()?;
    let light = if unit == "flux" { light.with_flux(color) } else { light.with_radiance(color * mean) };
    Ok(Own { origins, lights: vec![light.into()], value })
}

fn tube<'s>(t: &mut Table<'s>, around: &Around<'_>) -> Result<Own<'s>, SceneError> {
    let (from, to) = (t.require("from")?, t.require("to")?);
    let origins = Origins::of(around.origin, from.place()?);
    let ends = [from.relative(origins.own)?, to.relative(origins.own)?];
    let radius = t.require("radius")?.positive()?;
    if ends[0].distance(ends[1]) <= 1e-4 * radius {
        return Err(to.error("a tube has two ends: this one is the other"));
    }
    let (unit, value) = t.one_of(&["radiance", "flux"])?;
    let color = value.color()?;
    let light = TubeLight { ends, radius, radiance: color };
    let light = if unit == "flux" { light.with_flux(color) } else { light };
    Ok(Own { origins, lights: vec![light.into()], value })
}

fn sun<'s>(t: &mut Table<'s>, around: &Around<'_>, world: Sphere) -> Result<Own<'s>, SceneError> {
    let along = t.require("direction")?.direction()?;
    let degrees = match t.get("angle") {
        None => SunLight::HALF_ANGLE,
        Some(v) => match v.positive()? {
            angle if (1e-3..=120.0).contains(&angle) => 0.5 * angle,
            angle => return Err(v.error(format!("{angle} must lie between 0.001 and 120 degrees"))),
        },
    };
    let (unit, value) = t.one_of(&["irradiance", "radiance"])?;
    let color = value.color()?;
    let light = SunLight::new(-along, degrees, color, world);
    let light = if unit == "radiance" { SunLight { radiance: color, ..light } } else { light };
    Ok(Own { origins: Origins::of(around.origin, DVec3::ZERO), lights: vec![light.into()], value })
}

/// Sphere lights, with their brightness in one of some units.
fn sphere_lights<'s>(
    t: &mut Table<'s>,
    place: Value<'s>,
    spheres: Vec<Sphere>,
    units: &[&'static str],
) -> Result<(Vec<Light>, Value<'s>), SceneError> {
    Scene::check_spheres(&spheres).map_err(|e| place.error(e))?;
    let (unit, value) = t.one_of(units)?;
    let color = value.color()?;
    // In f64, since squares of small radii leave f32.
    let squares: f64 = spheres.iter().map(|b| f64::from(b.radius).powi(2)).sum();
    let radiance = match unit {
        // L = Φ/(4π²·Σr²).
        "flux" => (color.as_dvec3() / (4.0 * PI.powi(2) * squares)).as_vec3(),
        // L = I/(πr²).
        "intensity" => (color.as_dvec3() / (PI * squares)).as_vec3(),
        _ => color,
    };
    Ok((spheres.into_iter().map(|sphere| SphereLight::new(sphere, radiance).into()).collect(), value))
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

#[cfg(test)]
mod tests {
    use crate::context::Context;
    use crate::scene_file;
    use glam::Vec3;
    use lobe_core::Receiver;
    use shading::LightLobes as _;
    use std::path::Path;

    #[test]
    fn directions_may_have_any_length() {
        let text = |length: &str| {
            format!(
                "[[objects]]\nplane = {{ point = [0, 0, 0], normal = [0, {length}, 0] }}\n[[lights]]\nkind = \"sun\"\n\
                 direction = [0, -{length}, 0]\nirradiance = 1\n"
            )
        };
        let mut context = Context::default();
        let of = |length: &str, context: &mut Context| {
            scene_file::parse(Path::new("test.toml"), &text(length), context).expect("a scene").0.lights
        };
        let usual = of("1", &mut context);
        assert!(["1e30", "1e-30", "3"].iter().all(|length| of(length, &mut context) == usual));
    }

    /// A point and a spot whose light ends where they say; other kinds have no such key.
    #[test]
    fn lights_may_have_a_range() {
        let parse = |light: &str| {
            let floor = "[[objects]]\nplane = { point = [0, 0, 0], normal = [0, 1, 0] }\n[[lights]]\n";
            scene_file::parse(Path::new("test.toml"), &format!("{floor}{light}"), &mut Context::default())
        };
        let point = "kind = \"point\"\ncenter = [0, 1, 0]\nintensity = 2\n";
        let spot = "kind = \"spot\"\ncenter = [0, 1, 0]\nintensity = 2\ndirection = [0, -1, 0]\nangle = 40\n";
        for light in [point, spot] {
            let seen = |text: &str, far: f32| {
                let at = Receiver::on_surface(Vec3::NEG_Y * far, Vec3::Y, Vec3::Y);
                let (scene, _) = parse(text).expect("a scene");
                scene.lights[0].seen_from(&at).radiance.x
            };
            let ranged = format!("{light}range = 4\n");
            assert_eq!(seen(&ranged, 3.1), 0.0);
            let part = seen(&ranged, 1.0) / seen(light, 1.0);
            assert!((part - (1.0 - 0.5_f32.powi(4))).abs() < 1e-5, "{part}");
        }
        assert!(parse(&format!("{point}range = 0\n")).is_err());
        assert!(parse("kind = \"sun\"\ndirection = [0, -1, 0]\nirradiance = 1\nrange = 3\n").is_err());
    }
}
