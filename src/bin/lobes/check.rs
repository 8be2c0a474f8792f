use crate::advice::{Advice, advise};
use crate::args::CheckArgs;
use crate::console::say;
use crate::failure::Failure;
use crate::moment::last_frame;
use crate::{input, sphere_cache};
use cosine_lobes::lobe_core::BrdfLobes;
use cosine_lobes::render_cpu::{BlockersError, read_set};
use cosine_lobes::scene::{Animation, Object, Proxy, SCHEMA_EXAMPLE, Scene, Shape, Strategy};
use cosine_lobes::visibility_spheres::SetQuality;
use serde_json::{Value, json};

/// Bytes of a visible point in the G-buffer and of its result, in the bands that `render` works in.
const POINT_BYTES: u64 = 112;
const BAND_POINTS: u64 = 1 << 19;
/// Bytes of a pixel: radiance, and three bytes of a PNG file.
const PIXEL_BYTES: u64 = 15;
/// Bytes of a triangle with its share of the hierarchy.
const TRIANGLE_BYTES: u64 = 160;

/// What an object requires.
struct Requirement {
    /// Blocker spheres: at most so many when they are still to be built.
    spheres: usize,
    /// How well they stand for it, where they are there already.
    quality: Option<SetQuality>,
    advice: Advice,
}

pub(crate) fn run(args: &CheckArgs) -> Result<(), Failure> {
    if args.schema {
        say(schema());
        return Ok(());
    }
    let (scene, animation) = input::load(args.file.as_deref(), None, false)?;
    let objects = (0..scene.objects.len()).map(|n| requirement(&scene, n)).collect::<Result<Vec<_>, Failure>>()?;
    if args.json {
        say(serde_json::to_string_pretty(&requirements(&scene, &animation, &objects))?);
    } else {
        print(&scene, &animation, &objects);
    }
    Ok(())
}

/// The commented scene file, with a word on the files that it names.
fn schema() -> String {
    let quoted = |line: &str| -> Option<String> {
        let key = line.split('#').next()?;
        let names = ["mesh = \"", "file = \""];
        let start = names.iter().find_map(|n| Some(key.find(n)? + n.len()))?;
        Some(key[start..].split('"').next()?.to_owned())
    };
    let files: Vec<String> = SCHEMA_EXAMPLE.lines().filter_map(quoted).collect();
    format!(
        "# Not a scene yet: it names files that are yours to put there ({}).\n{}",
        files.join(", "),
        SCHEMA_EXAMPLE.trim_end()
    )
}

fn requirement(scene: &Scene, number: usize) -> Result<Requirement, Failure> {
    let object = &scene.objects[number];
    let (spheres, quality) = spheres(object)?;
    let advice = advise(scene, number, quality.as_ref());
    Ok(Requirement { spheres, quality, advice })
}

fn spheres(object: &Object) -> Result<(usize, Option<SetQuality>), BlockersError> {
    match (&object.proxy, &object.shape) {
        (Proxy::None, _) => Ok((0, None)),
        (Proxy::Spheres(list), _) | (Proxy::Count(_), Shape::Spheres(list)) => Ok((list.len(), None)),
        (Proxy::Count(n), Shape::Mesh(mesh)) => Ok((*n, sphere_cache::known(mesh, *n).map(|set| set.quality))),
        (Proxy::File(path), _) => {
            let set = read_set(path, object)?;
            Ok((set.spheres.len(), Some(set.quality)))
        }
    }
}

fn memory(scene: &Scene) -> u64 {
    let pixels = u64::from(scene.width) * u64::from(scene.height);
    pixels.min(BAND_POINTS) * POINT_BYTES + pixels * PIXEL_BYTES + scene.triangles() as u64 * TRIANGLE_BYTES
}

fn requirements(scene: &Scene, animation: &Animation, objects: &[Requirement]) -> Value {
    let materials = scene.materials.iter().map(|m| json!({"model": m.model_name(), "lobes": m.max_lobes()}));
    let objects_json = scene.objects.iter().zip(objects).map(|(o, needs)| {
        let (kind, primitives) = match &o.shape {
            Shape::Mesh(m) => ("triangles", m.triangles.len()),
            Shape::Spheres(s) => ("balls", s.len()),
        };
        json!({
            "name": o.name,
            "material": o.material,
            kind: primitives,
            "spheres": needs.spheres,
            "silhouette_error": needs.quality.as_ref().map(|q| q.silhouette_error),
            "visible": o.visible,
            "visibility": o.strategy.map(Strategy::name),
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
        "materials": materials.collect::<Vec<_>>(),
        "objects": objects_json.collect::<Vec<_>>(),
        "animation": (!animation.is_still()).then(|| json!({
            "duration": animation.duration(),
            "fps": animation.fps(),
            "frames": u64::from(last_frame(animation, animation.fps())) + 1,
            "clips": animation.clips(),
        })),
    })
}

fn print(scene: &Scene, animation: &Animation, objects: &[Requirement]) {
    say(format_args!("image      {} x {}", scene.width, scene.height));
    say(format_args!("lights     {}", scene.lights.len()));
    say(format_args!("triangles  {}", scene.triangles()));
    if !animation.is_still() {
        let (fps, last) = (animation.fps(), last_frame(animation, animation.fps()));
        say(format_args!("animation  {} s, frames 0 to {last} at {fps} a second", animation.duration()));
    }
    for clip in animation.clips() {
        say(format_args!("clip       {clip}"));
    }
    for (i, m) in scene.materials.iter().enumerate() {
        say(format_args!("material   {i}: {}, lobes at most: {}", m.model_name(), m.max_lobes()));
    }
    for (o, needs) in scene.objects.iter().zip(objects) {
        let shape = match &o.shape {
            Shape::Mesh(m) => format!("{} triangles", m.triangles.len()),
            Shape::Spheres(s) => format!("{} balls", s.len()),
        };
        let seen = if o.visible { "" } else { ", not seen by the camera" };
        say(format_args!("object     \"{}\": {shape}, material {}{seen}, {}", o.name, o.material, blocks(o, needs)));
        let Advice { strategy, reason } = &needs.advice;
        let now = o.strategy.unwrap_or(if o.proxy == Proxy::None { Strategy::None } else { Strategy::Spheres });
        let change = if now == *strategy { "" } else { ", which it has not now" };
        say(format_args!("           advice: visibility = \"{}\"{change} ({reason})", strategy.name()));
    }
    let blocking = |o: &Object| match o.strategy {
        None | Some(Strategy::Spheres) => o.proxy != Proxy::None,
        Some(Strategy::ShadowMap | Strategy::Rays) => true,
        Some(Strategy::None) => false,
    };
    if scene.lights.is_empty() {
        say("note       no light: the picture is black");
    } else if !scene.objects.iter().any(blocking) {
        say("note       nothing blocks light: a point costs one integral a lobe");
    }
    say(format_args!("memory     about {} MB for a frame", memory(scene).div_ceil(1_000_000)));
}

/// What an object blocks light with.
fn blocks(o: &Object, needs: &Requirement) -> String {
    let spheres = needs.spheres;
    match (o.strategy, &o.proxy) {
        (Some(Strategy::None), _) => "blocks nothing".to_owned(),
        (Some(Strategy::Rays), _) => "blocks by rays".to_owned(),
        (Some(Strategy::ShadowMap), _) => "blocks through shadow maps".to_owned(),
        (_, Proxy::None) => "blocks nothing".to_owned(),
        (_, Proxy::File(path)) => format!("blocks with the {spheres} spheres of {}", path.display()),
        (_, Proxy::Count(n)) if matches!(o.shape, Shape::Mesh(_)) => match &needs.quality {
            Some(_) => format!("blocks with {n} spheres, built before"),
            None => format!("blocks with up to {n} spheres, built at the first picture and kept"),
        },
        _ => format!("blocks with {spheres} spheres"),
    }
}
