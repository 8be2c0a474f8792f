//! Scenes from the command line.

use crate::args::ViewArgs;
use crate::console;
use crate::failure::Failure;
use crate::teller::Teller;
use cosine_lobes::brdf::Material;
use cosine_lobes::lobe_core::Receiver;
use cosine_lobes::render_cpu::SceneSpheres;
use cosine_lobes::renderer::{Plan, scene_spheres};
use cosine_lobes::scene::{self, Animation, LoadOptions, Scene};
use cosine_lobes::shading::BrdfLobes;
use glam::Vec3;
use std::path::{Path, PathBuf};

/// Loads the scene as it is at its first moment, or takes the built-in one, and passes warnings on.
pub(crate) fn load(file: Option<&Path>, options: &LoadOptions, quiet: bool) -> Result<(Scene, Animation), Failure> {
    let Some(file) = file else { return Ok((scene::builtin(), Animation::default())) };
    let (scene, animation, warnings) = scene::load_with(file, options)?;
    if !quiet {
        let own = scene.materials.iter().enumerate().filter_map(|(i, m)| too_bright(i, m));
        warnings.into_iter().chain(own).for_each(|w| console::note(format_args!("lobes: warning: {w}")));
    }
    Ok((scene, animation))
}

/// A line about a material that reflects more than it receives, seen and lit from straight above.
fn too_bright(number: usize, material: &Material) -> Option<String> {
    // It never does, and its cosine lobes would take milliseconds.
    if matches!(material, Material::MetallicRoughness(_)) {
        return None;
    }
    let at = Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::Z).on_object(0);
    let mut lobes = Vec::new();
    material.cosine_lobes(&at, &mut lobes);
    let lobes = lobes.iter().map(|lobe| lobe.cosine_lobe(at.normal));
    // About the normal a cosine leaves so much of a lobe.
    let all: Vec3 =
        lobes.map(|l| l.flux * if l.has_cosine { (l.exponent + 1.0) / (l.exponent + 2.0) } else { 1.0 }).sum();
    let most = all.max_element();
    // Lobes reach below the horizon by a little, and numbers are rounded.
    (most > 1.01).then(|| format!("material {number} ({}) reflects {most:.2} times the light it gets", material.name()))
}

/// The scene of a view, with the requested size.
pub(crate) fn view(args: &ViewArgs) -> Result<(Scene, Animation), Failure> {
    console::set_threads(args.console.threads)?;
    let (mut scene, animation) =
        load(args.file.as_deref(), &args.model.options(args.clip.as_deref())?, args.console.quiet)?;
    if let Some((width, height)) = args.size {
        (scene.width, scene.height) = (width, height);
    }
    if let Some(lack) = darkness(&scene).filter(|_| !args.console.quiet) {
        console::note(format_args!(
            "lobes: warning: the scene has {lack}: its picture is black (a table `[[lights]]` adds one)"
        ));
    }
    Ok((scene, animation))
}

/// The words for a scene that is not lit; `None` for others.
pub(crate) fn darkness(scene: &Scene) -> Option<&'static str> {
    let lack = if scene.environment.is_some() { "no light but a black sky" } else { "no light" };
    scene.lights.is_empty().then_some(lack)
}

/// Refuses more visible points than `most`.
///
/// `points` is their name in the message, `work` what they are too many for, `hint` the option that helps.
pub(crate) fn check_size(
    scene: &Scene,
    samples: u32,
    most: u64,
    [points, work, hint]: [&str; 3],
) -> Result<(), Failure> {
    let count = u64::from(scene.width) * u64::from(scene.height) * u64::from(samples);
    if count > most {
        return Err(Failure::new(format_args!("{count} {points} are too many for a {work}, at most {most}{hint}")));
    }
    Ok(())
}

/// The blocker spheres of those objects that the plan gives some; the scene is at its first moment.
pub(crate) fn make_spheres(
    scene: &mut Scene,
    animation: &Animation,
    plan: &Plan,
    quiet: bool,
) -> Result<SceneSpheres, Failure> {
    let (cache, mut teller) = (cache_folder(), Teller::new(quiet));
    Ok(scene_spheres(scene, animation, plan, cache.as_deref(), &mut |event| teller.hear(event))?)
}

/// The folder of kept sphere sets and the paper's table: `cosine-lobes` in the user's cache folder. It need not exist.
pub(crate) fn cache_folder() -> Option<PathBuf> {
    Some(dirs::cache_dir()?.join("cosine-lobes"))
}
