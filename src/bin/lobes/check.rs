use crate::args::CheckArgs;
use crate::console::say;
use crate::failure::Failure;
use crate::input;
use cosine_lobes::lobe_core::BrdfLobes;
use cosine_lobes::render_cpu::BlockersError;
use cosine_lobes::scene::{Object, Proxy, SCHEMA_EXAMPLE, Scene, Shape};
use cosine_lobes::visibility_spheres::SphereSet;
use serde_json::{Value, json};

/// Bytes of a visible point in the G-buffer and of its result, in the bands that `render` works in.
const POINT_BYTES: u64 = 112;
const BAND_POINTS: u64 = 1 << 19;
/// Bytes of a pixel: radiance, and three bytes of a PNG file.
const PIXEL_BYTES: u64 = 15;
/// Bytes of a triangle with its share of the hierarchy.
const TRIANGLE_BYTES: u64 = 160;

pub(crate) fn run(args: &CheckArgs) -> Result<(), Failure> {
    if args.schema {
        say(SCHEMA_EXAMPLE.trim_end());
        return Ok(());
    }
    let (scene, _animation) = input::load(args.file.as_deref(), false)?;
    let spheres = scene.objects.iter().map(spheres).collect::<Result<Vec<_>, _>>()?;
    if args.json {
        say(serde_json::to_string_pretty(&requirements(&scene, &spheres))?);
    } else {
        print(&scene, &spheres);
    }
    Ok(())
}

/// Blocker spheres of an object: at most so many when they are still to be built.
fn spheres(object: &Object) -> Result<usize, BlockersError> {
    match (&object.proxy, &object.shape) {
        (Proxy::None, _) => Ok(0),
        (Proxy::Spheres(list), _) | (Proxy::Count(_), Shape::Spheres(list)) => Ok(list.len()),
        (Proxy::Count(n), Shape::Mesh(_)) => Ok(*n),
        (Proxy::File(path), _) => {
            let text = std::fs::read_to_string(path);
            let text = text.map_err(|source| BlockersError::Read { path: path.clone(), source })?;
            let set = SphereSet::from_json(&text);
            Ok(set.map_err(|source| BlockersError::Set { path: path.clone(), source })?.spheres.len())
        }
    }
}

fn triangles(scene: &Scene) -> usize {
    let count = |shape: &Shape| if let Shape::Mesh(m) = shape { m.triangles.len() } else { 0 };
    scene.objects.iter().map(|o| count(&o.shape)).sum()
}

fn memory(scene: &Scene) -> u64 {
    let pixels = u64::from(scene.width) * u64::from(scene.height);
    pixels.min(BAND_POINTS) * POINT_BYTES + pixels * PIXEL_BYTES + triangles(scene) as u64 * TRIANGLE_BYTES
}

fn requirements(scene: &Scene, spheres: &[usize]) -> Value {
    let materials = scene.materials.iter().map(|m| json!({"model": m.model_name(), "lobes": m.max_lobes()}));
    let objects = scene.objects.iter().zip(spheres).map(|(o, spheres)| {
        let (kind, primitives) = match &o.shape {
            Shape::Mesh(m) => ("triangles", m.triangles.len()),
            Shape::Spheres(s) => ("balls", s.len()),
        };
        json!({"name": o.name, "material": o.material, kind: primitives, "spheres": spheres, "visible": o.visible})
    });
    json!({
        "width": scene.width,
        "height": scene.height,
        "lights": scene.lights.len(),
        "triangles": triangles(scene),
        "spheres": spheres.iter().sum::<usize>(),
        "memory_bytes": memory(scene),
        "materials": materials.collect::<Vec<_>>(),
        "objects": objects.collect::<Vec<_>>(),
    })
}

fn print(scene: &Scene, spheres: &[usize]) {
    say(format_args!("image      {} x {}", scene.width, scene.height));
    say(format_args!("lights     {}", scene.lights.len()));
    say(format_args!("triangles  {}", triangles(scene)));
    for (i, m) in scene.materials.iter().enumerate() {
        say(format_args!("material   {i}: {}, lobes at most: {}", m.model_name(), m.max_lobes()));
    }
    for (o, spheres) in scene.objects.iter().zip(spheres) {
        let shape = match &o.shape {
            Shape::Mesh(m) => format!("{} triangles", m.triangles.len()),
            Shape::Spheres(s) => format!("{} balls", s.len()),
        };
        let blocks = match &o.proxy {
            Proxy::None => "blocks nothing".to_owned(),
            Proxy::File(path) => format!("blocks with the {spheres} spheres of {}", path.display()),
            Proxy::Count(n) if matches!(o.shape, Shape::Mesh(_)) => {
                format!("blocks with up to {n} spheres, built at the first picture and kept")
            }
            _ => format!("blocks with {spheres} spheres"),
        };
        let seen = if o.visible { "" } else { ", not seen by the camera" };
        say(format_args!("object     \"{}\": {shape}, material {}{seen}, {blocks}", o.name, o.material));
    }
    let lit = |o: &Object| o.proxy != Proxy::None;
    let advice = match (scene.lights.is_empty(), scene.objects.iter().any(lit)) {
        (true, _) => "no light: the picture is black",
        (_, false) => "nothing blocks light: `--visibility none` gives the same picture and costs one integral a lobe",
        _ => "`--visibility spheres`",
    };
    say(format_args!("advice     {advice}"));
    say(format_args!("memory     about {} MB for a frame", memory(scene).div_ceil(1_000_000)));
}
