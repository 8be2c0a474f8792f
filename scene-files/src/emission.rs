//! Objects that emit, as lights.

use crate::context::{Context, and_others};
use crate::scene_file::place_of;
use glam::{Mat4, Vec3};
use lighting::{EnclosedLight, Light, SphereLight, emissive_mesh};
use lobe_core::scales_evenly;
use scene::motion::{Body, Carrier, LightMover, LightPlace, Mover, Skeleton};
use scene::{Animation, Object, Scene, Shape, Strategy, Surface};
use std::path::Path;

/// Whether objects whose material emits light the others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Emission {
    /// Those do that become lights exactly, or within 2 %: spheres, meshes of up to 24 flat faces, and curved meshes that spheres
    /// and tubes stand for. A warning names the others. An object at a light of its file shows that light and adds none.
    #[default]
    Lights,
    /// They are seen only. In a scene file, objects with `light = true` light the others all the same.
    Seen,
}

/// The mean error of irradiance up to which spheres and tubes stand for a curved mesh unless a file requests it.
const ERROR: f32 = 0.02;
/// The most triangles of a mesh that becomes lights unless a file requests it, and the most lights by emission in a scene: both take time.
const MOST_TRIANGLES: usize = 50_000;
const MOST_LIGHTS: usize = 128;
/// The fewest for which there is room, however many triangles a small file stands for.
const FEWEST_LIGHTS: usize = 8;
/// The most objects that may turn out to be no lights. Each may take a tenth of a second.
const MOST_FAILED: usize = 32;

/// The lights of an object that emits.
pub(crate) struct Emitted {
    pub(crate) lights: Vec<Light>,
    /// Where they go, and the lights in own coordinates.
    motion: Option<(LightPlace, Vec<Light>)>,
    /// The relative error of lights inside the object, which then must not block.
    pub(crate) inside: Option<f32>,
}

impl Emitted {
    /// Appends the lights and their motion.
    pub(crate) fn add(self, lights: &mut Vec<Light>, movers: &mut Vec<LightMover>) {
        let first = lights.len();
        lights.extend(self.lights);
        movers.extend(self.motion.map(|(placement, lights)| LightMover { first, lights, placement }));
    }
}

/// One light for each flat face or each sphere of an object, or an approximation of a curved mesh. They move as the object does.
///
/// The error says why the object is no light.
pub(crate) fn emitted(
    (number, object): (usize, &Object),
    surface: &Surface,
    mover: Option<&Mover>,
    skeletons: &[Skeleton],
) -> Result<Emitted, String> {
    let radiance = surface.emission;
    if radiance == Vec3::ZERO {
        return Err("the object's material has no emission".to_owned());
    }
    if surface.emission_map.is_some() || surface.is_unlit {
        return Err("an emission with a picture is no light: a rectangle of `[[lights]]` shows an image".to_owned());
    }
    // Rounding decides whether a point of a sphere's surface is inside it.
    let own = |light| Light::from(EnclosedLight { light: Box::new(light), object: number as u32 });
    let (lights, inside) = match &object.shape {
        Shape::Spheres(spheres) => {
            (spheres.iter().map(|sphere| own(SphereLight::new(*sphere, radiance).into())).collect(), None)
        }
        Shape::Mesh(_) | Shape::Instances(_) => {
            let mesh = object.shape.mesh().unwrap_or_default();
            let lamp = emissive_mesh(&mesh.positions, &mesh.triangles, radiance)
                .map_err(|e| format!("{e}: lights of `[[lights]]` in its place light as they are meant to"))?;
            match lamp.is_inside {
                true => (lamp.lights.into_iter().map(own).collect(), Some(lamp.error)),
                false => (lamp.lights, None),
            }
        }
    };
    if inside.is_some() && object.strategy.is_some_and(|s| s != Strategy::None) {
        return Err(
            "a curved mesh that lights the scene hides nothing: expected no `visibility`, or \"none\"".to_owned()
        );
    }
    let motion = mover.map(|mover| motion(mover, &lights, skeletons)).transpose()?;
    Ok(Emitted { lights, motion, inside })
}

/// How lights move as their object does.
fn motion(mover: &Mover, lights: &[Light], skeletons: &[Skeleton]) -> Result<(LightPlace, Vec<Light>), String> {
    let (now, place) = match &mover.body {
        Body::Mesh(_, Some(carrier)) => {
            rigid(carrier, mover, skeletons).ok_or("its clip bends it, or changes its size")?
        }
        _ if mover.placement.keeps_size() => (mover.placement.at(0.0), LightPlace::Keys(mover.placement.clone())),
        _ => return Err("an object that lights the scene keeps its size".to_owned()),
    };
    let back = now.inverse();
    Ok((place, lights.iter().map(|light| light.moved(back)).collect()))
}

/// The node that carries all of a mesh, where it is one that never changes its size, and its matrix at the first moment.
fn rigid(carrier: &Carrier, mover: &Mover, skeletons: &[Skeleton]) -> Option<(Mat4, LightPlace)> {
    const MOMENTS: u32 = 16;
    let Carrier { skeleton, joints, morph: None } = carrier else { return None };
    let [(Some(node), bind)] = joints[..] else { return None };
    let of_file = skeletons.get(*skeleton)?;
    let is_placed = !mover.placement.is_fixed() || mover.placement.at(0.0) != Mat4::IDENTITY;
    if is_placed || bind != Mat4::IDENTITY {
        return None;
    }
    let first = of_file.worlds(0.0)[node];
    let size = first.x_axis.truncate().as_dvec3().length();
    let mut moments = (0..=MOMENTS).map(|k| of_file.end() * k as f32 / MOMENTS as f32);
    let is_rigid = size > 0.0 && moments.all(|time| scales_evenly(&of_file.worlds(time)[node], size, 1e-3));
    is_rigid.then_some((first, LightPlace::Node { skeleton: *skeleton, node }))
}

/// Lets the objects of a scene that emit light the others, but for those that a key has decided upon.
pub(crate) fn light_up(path: &Path, scene: &mut Scene, animation: &mut Animation, context: &mut Context) {
    if context.emission == Emission::Seen {
        return;
    }
    let before = scene.lights.len();
    let triangles = scene.objects.iter().map(|object| object.shape.triangle_count()).sum();
    let most = context.files.budget.lights(triangles).clamp(FEWEST_LIGHTS, MOST_LIGHTS);
    let (mut dark, mut curved, mut failed) = (Vec::new(), Vec::new(), 0);
    for number in 0..scene.objects.len() {
        let object = &scene.objects[number];
        let Some(surface) = scene.surface(object.material).filter(|s| s.emits() && !s.is_unlit) else { continue };
        let is_decided = context.emitters.contains(&number);
        if is_decided || is_at_a_light(&scene.lights[..before], object) {
            continue;
        }
        if !object.visible {
            dark.push((object.name.clone(), "it is not visible (`light = true` in a scene file takes it)".to_owned()));
            continue;
        }
        let mover = animation.movers.get(number).and_then(Option::as_ref);
        let used = scene.lights.len() - before;
        match by_default((number, object), surface, (mover, &animation.skeletons), ([used, most], &mut failed)) {
            Ok(lamp) => {
                if lamp.inside.is_some() {
                    curved.push(object.name.clone());
                    scene.objects[number].strategy = Some(Strategy::None);
                }
                lamp.add(&mut scene.lights, &mut animation.lights);
            }
            Err(reason) => dark.push((object.name.clone(), reason)),
        }
    }
    if let [first, others @ ..] = &curved[..] {
        let more = and_others(others.len());
        context.warn(
            path,
            format!("object \"{first}\"{more} lights as spheres and tubes, within 2 %, and casts no shadow"),
        );
    }
    if let [(first, reason), others @ ..] = &dark[..] {
        let more = and_others(others.len());
        context.warn(path, format!("object \"{first}\"{more} emits, but lights no other: {reason}"));
    }
}

/// The lights of an object for which its file requests none.
fn by_default(
    (number, object): (usize, &Object),
    surface: &Surface,
    (mover, skeletons): (Option<&Mover>, &[Skeleton]),
    ([used, most], failed): ([usize; 2], &mut usize),
) -> Result<Emitted, String> {
    if surface.emission_map.is_some() {
        return Err("a picture of its emission is seen only".to_owned());
    }
    if object.shape.triangle_count() > MOST_TRIANGLES {
        return Err(format!("it has more than {MOST_TRIANGLES} triangles"));
    }
    let room = most.saturating_sub(used);
    let is_full = || {
        let few =
            if most < MOST_LIGHTS { ", as many as so small a file with this number of triangles may have" } else { "" };
        format!("the scene has {most} lights by emission already{few}")
    };
    // Before curved meshes are fitted, which takes long.
    if room == 0 {
        return Err(is_full());
    }
    if *failed == MOST_FAILED {
        return Err(format!("{MOST_FAILED} objects before it are no lights either"));
    }
    let lamp = emitted((number, object), surface, mover, skeletons).inspect_err(|_| *failed += 1)?;
    if let Some(error) = lamp.inside
        && error > ERROR
    {
        *failed += 1;
        if !error.is_finite() {
            return Err("spheres and tubes cannot stand for it".to_owned());
        }
        let percent = 100.0 * error;
        return Err(format!(
            "spheres and tubes in its place are {percent:.1} % off (`light = true` in a scene file takes them)"
        ));
    }
    if lamp.lights.len() > room {
        return Err(is_full());
    }
    Ok(lamp)
}

/// Whether a light is in or near an object: then the object shows the light.
fn is_at_a_light(lights: &[Light], object: &Object) -> bool {
    let bounds = object.shape.bounds();
    let reach = 0.25 * bounds.radius();
    let is_near = |center: Vec3| center.distance(center.clamp(bounds.min, bounds.max)) <= reach;
    lights.iter().filter_map(place_of).any(is_near)
}
