//! Scenes from the command line.

use crate::args::ViewArgs;
use crate::console;
use crate::failure::Failure;
use crate::sphere_cache;
use crate::strategy::Plan;
use cosine_lobes::render_cpu::blockers_from;
use cosine_lobes::scene::{self, BlockerSet, Scene};
use std::ops::ControlFlow;
use std::path::Path;

/// Loads the scene, or takes the built-in one, and passes warnings on.
pub(crate) fn load(file: Option<&Path>, quiet: bool) -> Result<Scene, Failure> {
    let Some(file) = file else { return Ok(scene::builtin()) };
    let (scene, warnings) = scene::load_with_warnings(file)?;
    if !quiet {
        warnings.iter().for_each(|w| console::note(format_args!("lobes: warning: {w}")));
    }
    Ok(scene)
}

/// The scene of a view, with the size that was asked for.
pub(crate) fn view(args: &ViewArgs) -> Result<Scene, Failure> {
    console::set_threads(args.threads)?;
    let mut scene = load(args.file.as_deref(), args.quiet)?;
    if let Some((width, height)) = args.size {
        (scene.width, scene.height) = (width, height);
    }
    Ok(scene)
}

/// The blocker spheres of those objects that the plan gives some.
pub(crate) fn make_blockers(scene: &mut Scene, plan: &Plan, quiet: bool) -> Result<BlockerSet, Failure> {
    sphere_cache::fill(scene, plan, quiet)?;
    let bar = console::progress("spheres", 1000, quiet);
    let source = |object| plan.spheres(scene, object);
    let set = blockers_from(scene, source, &mut |_, done| {
        bar.set_position((done * 1000.0) as u64);
        ControlFlow::Continue(())
    });
    bar.finish_and_clear();
    Ok(set?)
}
