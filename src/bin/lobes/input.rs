//! Scenes from the command line.

use crate::args::ViewArgs;
use crate::console;
use crate::failure::Failure;
use crate::sphere_cache;
use crate::strategy::Plan;
use cosine_lobes::render_cpu::SceneSpheres;
use cosine_lobes::scene::{self, Animation, Scene};
use std::ops::ControlFlow;
use std::path::Path;

/// Loads the scene as it is at its first moment, or takes the built-in one, and passes warnings on.
pub(crate) fn load(file: Option<&Path>, quiet: bool) -> Result<(Scene, Animation), Failure> {
    let Some(file) = file else { return Ok((scene::builtin(), Animation::default())) };
    let (scene, animation, warnings) = scene::load_animated(file)?;
    if !quiet {
        warnings.iter().for_each(|w| console::note(format_args!("lobes: warning: {w}")));
    }
    Ok((scene, animation))
}

/// The scene of a view, with the size that was asked for.
pub(crate) fn view(args: &ViewArgs) -> Result<(Scene, Animation), Failure> {
    console::set_threads(args.threads)?;
    let (mut scene, animation) = load(args.file.as_deref(), args.quiet)?;
    if let Some((width, height)) = args.size {
        (scene.width, scene.height) = (width, height);
    }
    Ok((scene, animation))
}

/// The blocker spheres of those objects that the plan gives some; the scene is at its first moment.
pub(crate) fn make_spheres(
    scene: &mut Scene,
    animation: &Animation,
    plan: &Plan,
    quiet: bool,
) -> Result<SceneSpheres, Failure> {
    sphere_cache::fill(scene, plan, quiet)?;
    let bar = console::progress("spheres", 1000, quiet);
    let source = |object| plan.spheres(scene, object);
    let set = SceneSpheres::new(scene, Some(animation), source, &mut |_, done| {
        bar.set_position((done * 1000.0) as u64);
        ControlFlow::Continue(())
    });
    bar.finish_and_clear();
    Ok(set?)
}
