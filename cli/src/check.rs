use crate::advice::{Advice, advise};
use crate::args::CheckArgs;
use crate::console::{counted, listed, note, say};
use crate::failure::Failure;
use crate::input;
use crate::moment::last_frame;
use crate::prices::Prices;
use cosine_lobes::brdf::{Material, residual, residual_of_cosine_lobes};
use cosine_lobes::lobe_core::Receiver;
use cosine_lobes::render_cpu::{BlockersError, SphereSource, read_set};
use cosine_lobes::renderer::{BAND_RAYS, Backend, Plan, known_set};
use cosine_lobes::scene::{Animation, Bounds, Object, Proxy, SCHEMA_EXAMPLE, Scene, Shape, Strategy, Surface, Texture};
use cosine_lobes::sphere_sets::SetQuality;
use glam::Vec3;
use rayon::prelude::*;
use serde_json::{Value, json};
use std::collections::HashMap;

/// Bytes of a visible point: found tile by tile and then put together, so that for a moment there are two of it.
const POINT_BYTES: usize = 2 * (size_of::<Receiver>() + 2 * size_of::<u32>() + size_of::<f32>());
/// Bytes of a pixel: radiance, and three bytes of a PNG file.
const PIXEL_BYTES: usize = size_of::<Vec3>() + 3;
/// Bytes of a triangle with its part of the hierarchy, measured on the armadillo.
const TRIANGLE_BYTES: usize = 160;

/// The requirements of an object.
struct Requirement {
    /// Its strategy when `render` has no `--visibility`.
    strategy: Strategy,
    /// Blocker spheres; an upper bound if they are still to be built.
    spheres: usize,
    /// The quality of its sphere set, if that exists already.
    quality: Option<SetQuality>,
    advice: Advice,
}

pub(crate) fn run(args: &CheckArgs) -> Result<(), Failure> {
    if args.schema {
        say(schema());
        return Ok(());
    }
    let (scene, animation) = input::load(args.file.as_deref(), &args.model.options(args.clip.as_deref())?, false)?;
    let plan = Plan::new(None, &scene);
    let boxes: Vec<Bounds> = scene.objects.iter().map(|object| object.shape.bounds()).collect();
    let requirement = |number| requirement(&scene, &animation, &plan, &boxes, number);
    let objects = (0..scene.objects.len()).map(requirement).collect::<Result<Vec<_>, Failure>>()?;
    let prices = || {
        note("lobes: note: --prices: fits spheres to meshes and makes small pictures; this may take a minute");
        Prices::measure(scene.clone(), &animation)
    };
    let prices = args.prices.then(prices).transpose()?;
    if args.json {
        let mut all = requirements(&scene, &animation, &plan, &objects);
        if let Some(prices) = prices {
            all["prices"] = prices.json();
        }
        say(serde_json::to_string_pretty(&all)?);
    } else {
        let of_scene =
            args.file.as_ref().is_some_and(|f| f.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")));
        print(&scene, &animation, &plan, &objects, of_scene);
        if let Some(prices) = prices {
            prices.print();
        }
    }
    Ok(())
}

/// The commented scene file, with a word on the files that it names.
fn schema() -> String {
    let quoted = |line: &str| -> Option<String> {
        let key = line.split('#').next()?;
        let names = ["mesh = \"", "file = \"", "_map = \""];
        let start = names.iter().find_map(|n| Some(key.find(n)? + n.len()))?;
        Some(key[start..].split('"').next()?.to_owned())
    };
    let mut files: Vec<String> = SCHEMA_EXAMPLE.lines().filter_map(quoted).collect();
    files.sort();
    files.dedup();
    format!(
        "# Not a scene yet: it names files that are yours to put there ({}).\n{}",
        files.join(", "),
        SCHEMA_EXAMPLE.trim_end()
    )
}

fn requirement(
    scene: &Scene,
    animation: &Animation,
    plan: &Plan,
    boxes: &[Bounds],
    number: usize,
) -> Result<Requirement, Failure> {
    let object = &scene.objects[number];
    let (count, quality) = spheres(object)?;
    let spheres = match plan.spheres(scene, number) {
        SphereSource::Nothing => 0,
        _ => count,
    };
    let advice = advise(scene, animation, boxes, number, plan.of(number), quality.as_ref());
    Ok(Requirement { strategy: plan.of(number), spheres, advice, quality })
}

/// The number of spheres that stand for an object, and their quality where known.
fn spheres(object: &Object) -> Result<(usize, Option<SetQuality>), BlockersError> {
    match (&object.proxy, &object.shape) {
        (Proxy::None, _) => Ok((0, None)),
        (Proxy::Spheres(list), _) | (Proxy::Count(_), Shape::Spheres(list)) => Ok((list.len(), None)),
        (Proxy::Count(n), shape) => {
            let mesh = shape.mesh().unwrap_or_default();
            Ok((*n, input::cache_folder().and_then(|cache| known_set(&mesh, *n, &cache)).map(|set| set.quality)))
        }
        (Proxy::File { path, placement }, _) => {
            let set = read_set(path, placement, object)?;
            Ok((set.spheres.len(), Some(set.quality)))
        }
    }
}

/// Bytes of a frame without its shadow maps.
fn memory(scene: &Scene) -> u64 {
    let pixels = u64::from(scene.width) * u64::from(scene.height);
    let triangles = (scene.triangles() * TRIANGLE_BYTES) as u64;
    let mut textures: Vec<&Texture> = Vec::new();
    for (_, texture) in scene.surfaces.iter().flat_map(Surface::textures) {
        if !textures.iter().any(|known| known.is_same(texture)) {
            textures.push(texture);
        }
    }
    let textures: usize = textures.into_iter().map(Texture::bytes).sum();
    pixels.min(BAND_RAYS) * POINT_BYTES as u64 + pixels * PIXEL_BYTES as u64 + triangles + textures as u64
}

fn requirements(scene: &Scene, animation: &Animation, plan: &Plan, objects: &[Requirement]) -> Value {
    let materials = scene.materials.par_iter().enumerate().map(|(i, m)| {
        let textures = scene.surface(i).into_iter().flat_map(Surface::textures);
        let texture = |(name, texture): (_, &Texture)| json!({"field": name, "size": texture.size()});
        json!({
            "model": m.name(),
            "lobes": m.model().lobe_count(),
            "lobes_of_directions": m.model().cosine_lobe_count(),
            "residual": residual(m),
            "residual_of_directions": residual_of_cosine_lobes(m),
            "textures": textures.map(texture).collect::<Vec<_>>(),
        })
    });
    let objects_json = scene.objects.iter().zip(objects).map(|(o, needs)| {
        let (kind, primitives) = match &o.shape {
            Shape::Mesh(_) | Shape::Instances(_) => ("triangles", o.shape.triangle_count()),
            Shape::Spheres(s) => ("spheres", s.len()),
        };
        json!({
            "name": o.name,
            "material": o.material,
            kind: primitives,
            "spheres": needs.spheres,
            "silhouette_error": needs.quality.as_ref().map(|q| q.silhouette_error),
            "visible": o.visible,
            "visibility": needs.strategy.name(),
            "advice": {"visibility": needs.advice.strategy.name(), "reason": needs.advice.reason},
        })
    });
    json!({
        "width": scene.width,
        "height": scene.height,
        "lights": scene.lights.len(),
        "triangles": scene.triangles(),
        "spheres": objects.iter().map(|o| o.spheres).sum::<usize>(),
        "memory_bytes": memory(scene),
        "map_bytes_at_most": plan.most_map_bytes(scene),
        "materials": materials.collect::<Vec<Value>>(),
        "objects": objects_json.collect::<Vec<_>>(),
        "animation": (!animation.is_still()).then(|| json!({
            "duration": animation.duration(),
            "fps": animation.fps(),
            "frames": u64::from(last_frame(animation, animation.fps())) + 1,
            "clips": animation.clips(),
        })),
    })
}

/// `of_scene`: whether there is a scene file to write advice into.
fn print(scene: &Scene, animation: &Animation, plan: &Plan, objects: &[Requirement], of_scene: bool) {
    say(format_args!("image      {} x {}", scene.width, scene.height));
    say(format_args!("lights     {}", scene.lights.len()));
    say(format_args!("triangles  {}", scene.triangles()));
    if !animation.is_still() {
        let (fps, last) = (animation.fps(), last_frame(animation, animation.fps()));
        let (seconds, all) = (animation.duration(), last + 1);
        say(format_args!("animation  {seconds} s, frames 0 to {last} at {fps} a second: all by --frames 0..{all}"));
    }
    for clip in animation.clips() {
        say(format_args!("clip       {clip}"));
    }
    let materials = scene.materials.par_iter().enumerate().map(|(i, m)| describe_material(m, scene.surface(i)));
    for (i, text) in materials.collect::<Vec<_>>().iter().enumerate() {
        say(format_args!("material   {i}: {text}"));
    }
    // Objects with the same text share their lines, at the first one's place.
    let mut told: Vec<(String, Vec<&str>)> = Vec::new();
    let mut places: HashMap<String, usize> = HashMap::new();
    for (o, needs) in scene.objects.iter().zip(objects) {
        let text = describe(o, needs, of_scene);
        let place = *places.entry(text.clone()).or_insert(told.len());
        if place == told.len() {
            told.push((text, Vec::new()));
        }
        told[place].1.push(&o.name);
    }
    for (text, names) in told {
        say(format_args!("object     {}: {text}", listed(&names)));
    }
    if let Some(lack) = input::darkness(scene) {
        say(format_args!("note       {lack}: the picture is black"));
    } else if objects.iter().all(|o| o.strategy == Strategy::None) {
        say("note       nothing blocks light: a point costs one integral a lobe");
    }
    let megabytes = |bytes: u64| bytes.div_ceil(1_000_000);
    let maps = match plan.most_map_bytes(scene).min(Backend::Cpu.room_for_maps()) {
        0 => String::new(),
        bytes => format!(", and up to {} MB for shadow maps", megabytes(bytes)),
    };
    say(format_args!("memory     about {} MB for a frame{maps}", megabytes(memory(scene))));
}

/// A material's model, lobes and textures.
fn describe_material(material: &Material, surface: Option<&Surface>) -> String {
    let (most, of_directions) = (material.model().lobe_count(), material.model().cosine_lobe_count());
    let mut text = format!("{}, lobes at most: {most}", material.name());
    if of_directions != most {
        text += &format!(" ({of_directions} by the methods `paper` and `lobes`)");
    }
    text += &residuals(material);
    for (name, texture) in surface.into_iter().flat_map(Surface::textures) {
        let [width, height] = texture.size();
        text += &format!("\n           {name}: texture {width} x {height}");
    }
    text
}

/// The residual of a material's lobes; empty where the lobes are the material.
fn residuals(material: &Material) -> String {
    const EXACT: f64 = 1e-3;
    // Its lobes are the material: one of many in a file, of which each would take a millisecond.
    if matches!(material, Material::MetallicRoughness(_)) {
        return String::new();
    }
    let percent = |residual: f64| format!("{:.1} %", 100.0 * residual);
    // Those of the methods `paper` and `lobes` are in the JSON alone: few take them.
    let own = residual(material);
    if own < EXACT {
        return String::new();
    }
    let told = format!("{} off", percent(own));
    format!("\n           its lobes are {told} (root mean square over directions, views up to 75°)")
}

/// The description of an object without its name: one line, and the advice in one or two.
fn describe(o: &Object, needs: &Requirement, of_scene: bool) -> String {
    let shape = match &o.shape {
        Shape::Mesh(m) => counted(m.triangles.len(), "triangle"),
        Shape::Instances(all) => {
            let each = counted(all.mesh().triangles.len(), "triangle");
            format!("{each} at {}", counted(all.places().len(), "place"))
        }
        Shape::Spheres(s) => counted(s.len(), "sphere"),
    };
    let seen = if o.visible { "" } else { ", not seen by the camera" };
    let Advice { strategy, reason } = &needs.advice;
    let (wanted, taken) = (strategy.name(), needs.strategy.name());
    let mut text = format!("{shape}, material {}{seen}, {}", o.material, blocks(o, needs));
    text += &format!("\n           advice: visibility = \"{wanted}\" ({reason})");
    if needs.strategy != *strategy {
        let how = if of_scene {
            format!("write visibility = \"{wanted}\" under this object")
        } else {
            format!("--visibility {wanted}, or a scene file with visibility = \"{wanted}\" for this object")
        };
        text += &format!("\n           render takes \"{taken}\" unless told so: {how}");
    }
    text
}

/// How an object blocks light.
fn blocks(o: &Object, needs: &Requirement) -> String {
    let spheres = needs.spheres;
    match (needs.strategy, &o.proxy, &o.shape) {
        (Strategy::None, ..) => "blocks nothing".to_owned(),
        (Strategy::Custom(name), ..) => format!("blocks by {name}"),
        (Strategy::Silhouettes, _, Shape::Mesh(_) | Shape::Instances(_)) => "blocks by its silhouettes".to_owned(),
        (Strategy::Rays, ..) => {
            "blocks by rays, which miss openings and blockers narrower than an eighth of a light".to_owned()
        }
        (Strategy::ShadowMap, _, Shape::Instances(_)) => "blocks by its silhouettes".to_owned(),
        (Strategy::ShadowMap, _, Shape::Mesh(_)) => "blocks through shadow maps".to_owned(),
        (Strategy::Spheres, Proxy::File { path, .. }, _) => {
            format!("blocks with the {} of {}", counted(spheres, "sphere"), path.display())
        }
        (Strategy::Spheres, Proxy::Count(n), Shape::Mesh(_) | Shape::Instances(_)) => match &needs.quality {
            Some(_) => format!("blocks with {}, built before", counted(*n, "sphere")),
            None => format!("blocks with up to {}, built at the first picture and kept", counted(*n, "sphere")),
        },
        _ => format!("blocks with {}", counted(spheres, "sphere")),
    }
}
