//! A mesh file as a scene of its own: with a floor, and lights and a camera where it has none.

use crate::appearance::Appearance;
use crate::context::Context;
use crate::defaults::{DEFAULT_SIZE, DEFAULT_SPHERES, default_camera, default_material};
use crate::emission::light_up;
use crate::gltf_file::Read;
use crate::gltf_light::PlacedLight;
use crate::mesh_file::near_parts;
use crate::part::share_out;
use crate::studio;
use brdf::ModifiedPhong;
use glam::{Mat4, Vec3};
use scene::motion::{LightMover, LightPlace, Placement};
use scene::{Animation, Bounds, Camera, Mesh, Object, Proxy, Scene, SceneError};
use std::path::Path;

pub(crate) const MESH_OR_SCENE: &str = ".toml, .obj, .ply, .gltf or .glb";

/// The contents of a mesh file, without the floor and the lights that [`bare`] adds. The objects are not posed yet.
pub(crate) struct Bare {
    pub(crate) objects: Vec<Object>,
    appearances: Vec<Appearance>,
    pub(crate) animation: Animation,
    camera: Option<Camera>,
    lights: Vec<PlacedLight>,
}

pub(crate) fn bare_objects(path: &Path, file: Read, context: &mut Context) -> Bare {
    let Read { mut parts, camera, moving_camera, lights } = file;
    let mut animation = Animation { origin: context.origin, camera: moving_camera, ..context.animation() };
    let here = Placement::Fixed(Mat4::IDENTITY);
    animation.movers = parts.iter_mut().map(|part| part.place(context.normals, &here)).collect();
    context.tell_smoothed(path, &parts, context.normals, false);
    let floor = ModifiedPhong { kd: Vec3::splat(0.32), ks: Vec3::splat(0.18), exponent: 50.0 };
    let mut appearances: Vec<Appearance> = vec![floor.into(), default_material().into()];
    let mut keys: Vec<(usize, usize)> = Vec::new();
    let counts = share_out(DEFAULT_SPHERES, &parts);
    let mut objects = Vec::new();
    for (mut part, count) in parts.into_iter().zip(counts) {
        let material = match part.material.take() {
            None => 1,
            Some((key, appearance)) => match keys.iter().find(|(k, _)| *k == key) {
                Some(&(_, index)) => index,
                None => {
                    appearances.push(appearance);
                    keys.push((key, appearances.len() - 1));
                    appearances.len() - 1
                }
            },
        };
        let kept = context.document.as_mut().zip(part.source).and_then(|(all, source)| all.parts.get_mut(source));
        if let Some(kept) = kept {
            kept.object = Some(objects.len());
        }
        let (name, proxy) = (part.name.clone(), Proxy::Count(count));
        let shape = part.into_shape();
        objects.push(Object {
            name,
            shape,
            material,
            proxy,
            visible: true,
            strategy: None,
            terminator: context.terminator,
        });
    }
    Bare { objects, appearances, animation, camera, lights }
}

/// The box that holds the objects at all times, approximated by its union over several moments.
fn swept_bounds(animation: &Animation, objects: &mut [Object]) -> Bounds {
    const MOMENTS: u32 = 16;
    let moments = if animation.is_still() { 1 } else { MOMENTS };
    let mut bounds = Bounds::EMPTY;
    // The first moment comes last, because the objects keep the last pose.
    for i in (0..moments).rev() {
        let time = animation.duration() * i as f32 / MOMENTS as f32;
        animation.move_objects(time, &animation.worlds(time), objects);
        bounds = objects.iter().fold(bounds, |b, o| b.union(o.shape.bounds()));
    }
    bounds
}

/// Adds the lights of a studio to those of objects that emit, if these are faint or the studio is requested.
fn add_studio(path: &Path, scene: &mut Scene, bounds: &Bounds, context: &mut Context) {
    let is_faint = studio::is_faint(&scene.lights, bounds);
    if !is_faint && context.studio.is_none() {
        return;
    }
    if !scene.lights.is_empty() && context.studio.is_none() {
        context.warn(path, "what emits in it is faint: a studio lights it as well");
    }
    scene.lights.extend(context.studio.unwrap_or_default().lights(bounds));
}

/// A mesh file as a scene of its own. Floor, light and camera suit the whole animation.
pub(crate) fn bare(path: &Path, clip: Option<&str>, context: &mut Context) -> Result<(Scene, Animation), SceneError> {
    let file = near_parts(path, clip, context, MESH_OR_SCENE)?;
    let Bare { mut objects, appearances, mut animation, camera, lights: own } = bare_objects(path, file, context);
    let bounds = swept_bounds(&animation, &mut objects);
    let radius = bounds.radius();
    let (width, height) = DEFAULT_SIZE;
    let is_kept = context.document.is_some();
    // A little below the lowest point: a model with a floor of its own must not lie in ours.
    let ground = Vec3::new(bounds.center().x, bounds.min.y - 1e-3 * radius, bounds.center().z);
    let is_below = !is_kept && own.iter().any(|light| light.is_below(ground.y));
    if is_below {
        context.warn(path, "a light of its own shines from below: no floor is added, which would hide it");
    }
    if !is_kept && !is_below {
        let half = 60.0 * radius;
        let floor = Mesh::quad(ground, Vec3::X * half, Vec3::NEG_Z * half);
        objects.insert(0, Object::mesh("floor", floor, 0, Proxy::None));
        animation.movers.insert(0, None);
    }
    let lights = own.iter().map(|own| own.light.at_origin(&bounds).moved(own.world)).collect();
    animation.lights = own
        .iter()
        .enumerate()
        .filter_map(|(first, own)| {
            let (skeleton, node) = own.mover?;
            let placement = LightPlace::Node { skeleton, node };
            Some(LightMover { first, lights: vec![own.light.at_origin(&bounds)], placement })
        })
        .collect();
    let camera = camera.unwrap_or_else(|| default_camera(bounds, width, height));
    let (materials, surfaces) = Appearance::parted(appearances);
    let mut scene = Scene { camera, width, height, materials, surfaces, objects, lights, ..Scene::default() };
    light_up(path, &mut scene, &mut animation, context);
    if own.is_empty() && !is_kept {
        add_studio(path, &mut scene, &bounds, context);
    }
    scene.validate().map_err(|e| SceneError::file(path, e.to_string()))?;
    Ok((scene, animation))
}
