//! The scene file.

use crate::appearance::Appearance;
use crate::context::Context;
use crate::defaults::{DEFAULT_FOV, DEFAULT_SIZE, default_camera};
use crate::keys::Keys;
use crate::scene_light::{Around, SceneLights};
use crate::scene_material::{ImageFiles, Materials, read_material};
use crate::scene_object::{count_files, read_object};
use crate::toml_reader::{Source, Table, Value};
use glam::{DVec3, Vec3};
use lighting::Light;
use scene::motion::{CameraKeys, CameraMover, MAX_SECONDS, Mover};
use scene::{Animation, Bounds, Camera, MAX_COORDINATE, Object, Projection, Scene, SceneError, Strategy};
use shading::LightLobes;
use std::cell::RefCell;
use std::path::Path;
use toml::de::DeTable;

/// Every key of a scene file, with its meaning and its default: a complete file, as an example and as the reference.
pub const SCHEMA_EXAMPLE: &str = include_str!("example.toml");

/// Lights in place of a mesh are worth a warning from this error on.
const WORTH_SAYING: f32 = 0.02;

/// Reads the text of a scene file. Messages name `path`, and relative paths start from it. A scene far from the
/// origin, most of its objects and lights too, is read relative to a point near the first target of its camera.
pub(crate) fn parse(path: &Path, text: &str, context: &mut Context) -> Result<(Scene, Animation), SceneError> {
    let mark = context.files.budget.mark();
    let (scene, animation) = match parse_from(path, text, DVec3::ZERO, context) {
        Ok(read) => read,
        Err(error) => {
            // Single precision may not tell corners apart that are far from the origin.
            let place = written_place(path, text).filter(|(p, _)| p.abs().max_element() <= f64::from(MAX_COORDINATE));
            let origin = place.map_or(DVec3::ZERO, |(place, size)| crate::origin::near(place, size));
            if origin == DVec3::ZERO {
                return Err(error);
            }
            context.files.budget.back_to(mark);
            *context = context.anew();
            return parse_from(path, text, origin, context);
        }
    };
    let mut camera = scene.camera;
    if let Some(CameraMover::Keys(keys)) = &animation.camera {
        camera = keys.at(0.0);
    }
    let origin = crate::origin::near(camera.target.as_dvec3(), camera.eye.distance(camera.target).into());
    // A camera may be far from all that it sees, and its target be next to it.
    let centers =
        scene.objects.iter().map(|o| o.shape.bounds().center()).chain(scene.lights.iter().filter_map(place_of));
    let nearer = |p: &Vec3| p.as_dvec3().distance_squared(origin) < p.as_dvec3().length_squared();
    let (all, count) = (centers.clone().count(), centers.filter(nearer).count());
    if origin == DVec3::ZERO || 2 * count <= all {
        return Ok((scene, animation));
    }
    drop(scene);
    context.files.budget.back_to(mark);
    *context = context.anew();
    parse_from(path, text, origin, context)
}

/// A place in the scene in double precision, and the size of what is seen there: the target of the camera and its distance, or without a
/// camera the place of the first object that has one, and 1.
fn written_place(path: &Path, text: &str) -> Option<(DVec3, f64)> {
    let source = Source { path, text };
    let root = DeTable::parse(text).ok()?;
    let mut root = Table::new(source, 0, "scene", root.get_ref());
    if let Some(camera) = root.get("camera") {
        let mut camera = camera.table().ok()?;
        let [eye, target] = [camera.get("eye")?.place().ok()?, camera.get("target")?.place().ok()?];
        return Some((target, eye.distance(target)));
    }
    let objects = root.get("objects")?.elements("[[objects]]").ok()?;
    objects.into_iter().find_map(|object| place_of_object(object.table().ok()?)).map(|place| (place, 1.0))
}

/// Where a file says that an object is: its translation, else the place of its shape.
fn place_of_object(mut object: Table<'_>) -> Option<DVec3> {
    if let Some(translate) = object.get("translate") {
        return translate.place().ok();
    }
    let (key, shape) =
        ["quad", "box", "sphere", "plane"].into_iter().find_map(|key| object.get(key).map(|shape| (key, shape)))?;
    shape.table().ok()?.get(if key == "plane" { "point" } else { "center" })?.place().ok()
}

/// Width and height of `[image]`.
fn read_size(value: Value<'_>) -> Result<(u32, u32), SceneError> {
    let mut t = value.table()?;
    let edge = |v: Option<Value<'_>>, default| v.map_or(Ok(default), |v| v.whole(1, Scene::MAX_SIDE));
    let size = (edge(t.get("width"), DEFAULT_SIZE.0)?, edge(t.get("height"), DEFAULT_SIZE.1)?);
    t.finish()?;
    Ok(size)
}

/// All `[materials]`.
fn read_materials(value: Value<'_>, path: &Path, context: &mut Context) -> Result<Materials, SceneError> {
    let mut materials = Materials::default();
    let mut images = ImageFiles::new(&context.files);
    for entry in value.table()?.entries() {
        let appearance = read_material(entry.table()?, path, &mut images, context)?;
        appearance.material.validate().map_err(|e| entry.error(e))?;
        materials.names.insert(entry.name().to_owned(), materials.all.len());
        materials.all.push(appearance);
    }
    Ok(materials)
}

/// Duration and frames a second of `[animation]`.
fn read_pace(value: Value<'_>) -> Result<(Option<f32>, f32), SceneError> {
    let mut t = value.table()?;
    let seconds = |v: Value<'_>| match v.positive()? {
        s if s <= MAX_SECONDS => Ok(s),
        s => Err(v.error(format!("{s} is more than {MAX_SECONDS} seconds"))),
    };
    let duration = t.get("duration").map(seconds).transpose()?;
    let fps = t.get("fps").map_or(Ok(Animation::DEFAULT_FPS), |v| match v.positive()? {
        fps if (1e-3..=1e4).contains(&fps) => Ok(fps),
        fps => Err(v.error(format!("{fps} must lie between 0.001 and 10000"))),
    })?;
    t.finish()?;
    Ok((duration, fps))
}

/// The objects of a scene file.
#[derive(Default)]
struct Objects<'s> {
    objects: Vec<Object>,
    /// One for each object.
    movers: Vec<Option<Mover>>,
    /// Objects that are lights, with the keys that say so.
    emitters: Vec<(usize, Value<'s>)>,
}

/// All `[[objects]]`.
fn read_objects<'s>(
    value: Value<'s>,
    path: &Path,
    origin: DVec3,
    materials: &mut Materials,
    context: &mut Context,
) -> Result<Objects<'s>, SceneError> {
    let mut all = Objects::default();
    let entries = value.elements("[[objects]]")?;
    count_files(&entries, path, context);
    for (i, entry) in entries.into_iter().enumerate() {
        let read = read_object(entry.table()?, i, path, origin, materials, context)?;
        for (object, mover) in read.objects {
            if let Some((key, is_light)) = read.light {
                context.emitters.push(all.objects.len());
                all.emitters.extend(is_light.then_some((all.objects.len(), key)));
            }
            all.objects.push(object);
            all.movers.push(mover);
        }
    }
    Ok(all)
}

impl Objects<'_> {
    /// Adds the lights of objects whose emission lights the others; these objects block nothing where lights are inside.
    fn light_up(
        &mut self,
        materials: &Materials,
        lit: &mut SceneLights,
        path: &Path,
        context: &mut Context,
    ) -> Result<(), SceneError> {
        for &(number, key) in &self.emitters {
            let object = &mut self.objects[number];
            let mover = self.movers[number].as_ref();
            let Some(error) = lit.emit((number, object), materials.surface(object), key, mover)? else { continue };
            object.strategy = Some(Strategy::None);
            if error > WORTH_SAYING {
                let (name, percent) = (&object.name, 100.0 * error);
                context.warn(path, format!("object \"{name}\" lights as spheres and tubes, about {percent:.0} % off"));
            }
        }
        Ok(())
    }
}

/// All `[[lights]]`.
fn read_lights(
    value: Value<'_>,
    path: &Path,
    origin: DVec3,
    bounds: &Bounds,
    context: &mut Context,
) -> Result<SceneLights, SceneError> {
    let mut lit = SceneLights::default();
    let notes = RefCell::default();
    for entry in value.elements("[[lights]]")? {
        lit.read(entry.table()?, &Around { path, files: &context.files, origin, bounds, notes: &notes })?;
    }
    notes.into_inner().into_iter().for_each(|note| context.warn(path, note));
    Ok(lit)
}

fn parse_from(path: &Path, text: &str, origin: DVec3, context: &mut Context) -> Result<(Scene, Animation), SceneError> {
    let source = Source { path, text };
    let root = DeTable::parse(text)
        .map_err(|e| source.error(e.span().map_or(text.len(), |s| s.start), e.message().to_owned()))?;
    let mut root = Table::new(source, 0, "scene", root.get_ref());

    let (width, height) = root.get("image").map_or(Ok(DEFAULT_SIZE), read_size)?;
    let background = root.get("background").map_or(Ok(Vec3::ZERO), |v| v.color())?;

    let mut materials = root.get("materials").map_or(Ok(Materials::default()), |v| read_materials(v, path, context))?;
    let (duration, fps) = root.get("animation").map_or(Ok((None, Animation::DEFAULT_FPS)), read_pace)?;
    let list = root.get("objects");
    let mut all = list.map_or(Ok(Objects::default()), |v| read_objects(v, path, origin, &mut materials, context))?;
    let bounds = all.objects.iter().fold(Bounds::EMPTY, |b, o| b.union(o.shape.bounds()));
    let list = root.get("lights");
    let mut lit = list.map_or(Ok(SceneLights::default()), |v| read_lights(v, path, origin, &bounds, context))?;
    let environment = lit.environment(&bounds);
    all.light_up(&materials, &mut lit, path, context)?;
    let Objects { objects, movers, .. } = all;
    let camera = root.get("camera");
    root.finish()?;
    if objects.is_empty() {
        return Err(source.error(text.len(), "scene has no objects: expected [[objects]]"));
    }
    let (camera, camera_keys) = match camera {
        Some(value) => read_camera(value, origin)?,
        None => (default_camera(bounds, width, height), None),
    };
    let animation = Animation {
        origin,
        duration,
        fps,
        movers,
        lights: lit.movers,
        camera: camera_keys.map(|keys| CameraMover::Keys(Box::new(keys))),
        ..context.animation()
    };
    let (materials, surfaces) = Appearance::parted(materials.all);
    let lights = lit.lights;
    let scene = Scene { camera, width, height, background, environment, materials, surfaces, objects, lights };
    scene.validate().map_err(|e| SceneError::file(path, e.to_string()))?;
    Ok((scene, animation))
}

/// The position of a light; suns and skies have none.
pub(crate) fn place_of(light: &Light) -> Option<Vec3> {
    let is_nowhere = matches!(light, Light::Sun(_) | Light::Sky(_) | Light::Ambient(_));
    (!is_nowhere).then(|| light.bounds().center)
}

fn read_camera(value: Value<'_>, origin: DVec3) -> Result<(Camera, Option<CameraKeys>), SceneError> {
    let mut t = value.table()?;
    let (eye, target) = (t.require("eye")?, t.require("target")?);
    let up = t.get("up");
    let projection = read_projection(&mut t, value)?;
    let camera = Camera {
        eye: eye.relative(origin)?,
        target: target.relative(origin)?,
        up: up.map_or(Ok(Vec3::Y), |v| v.direction())?,
        projection,
    };
    let keys = Keys::read(&mut t)?;
    t.finish()?;
    let far = |v: Vec3| v.abs().max_element() > MAX_COORDINATE;
    let place = match (far(camera.eye), far(camera.target) || camera.eye == camera.target) {
        (true, _) => eye,
        (_, true) => target,
        _ => up.unwrap_or(value),
    };
    camera.validate().map_err(|e| place.error(e))?;
    Ok((camera, keys.map(|keys| keys.camera(camera, origin)).transpose()?))
}

/// The keys `projection`, `fov` and `height` of a camera.
fn read_projection<'s>(t: &mut Table<'s>, camera: Value<'s>) -> Result<Projection, SceneError> {
    let (kind, fov, height) = (t.get("projection"), t.get("fov"), t.get("height"));
    let name = kind.map_or(Ok("perspective"), |v| v.string())?;
    let none = |value: Option<Value<'_>>| match value {
        Some(v) => Err(v.error(format!(
            "is of another projection than \"{name}\": fov is of \"perspective\", height of \"orthographic\""
        ))),
        None => Ok(()),
    };
    let projection = match name {
        "perspective" => {
            none(height)?;
            let (place, degrees) = (fov.unwrap_or(camera), fov.map_or(Ok(DEFAULT_FOV), |v| v.number())?);
            if !(degrees > 0.0 && degrees < 180.0) {
                return Err(place.error(format!("{degrees} must lie between 0 and 180 degrees")));
            }
            let projection = Projection::perspective(degrees.to_radians());
            projection.validate().map_err(|e| place.error(e))?;
            projection
        }
        "orthographic" => {
            none(fov)?;
            let height = height.ok_or_else(|| camera.error("an orthographic camera needs a height in units"))?;
            let projection = Projection::Orthographic { height: height.number()? };
            projection.validate().map_err(|e| height.error(e))?;
            projection
        }
        "panoramic" => {
            none(fov.or(height))?;
            Projection::Panoramic
        }
        other => {
            let place = kind.unwrap_or(camera);
            let expected = "expected \"perspective\", \"orthographic\" or \"panoramic\"";
            return Err(place.error(format!("found \"{other}\": {expected}")));
        }
    };
    Ok(projection)
}
