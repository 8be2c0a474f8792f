use crate::args::{Geometry as Choice, ReferenceArgs, name};
use crate::checkpoint;
use crate::console::{self, STOP, note, say};
use crate::failure::Failure;
use crate::files::{self, Files};
use crate::input;
use crate::moment;
use cosine_lobes::ray_tracing::{GBuffer, World};
use cosine_lobes::reference::{Geometry, REPLICATES, Reference, ReferenceJob};
use cosine_lobes::renderer::{Plan, exposure};
use cosine_lobes::scene::{BlockerSet, Scene, Strategy};
use cosine_lobes::{ExrLayer, Picture};
use glam::Vec3;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// More points than this, at 192 bytes each, are refused.
const MAX_POINTS: u64 = 1 << 25;

pub(crate) fn run(args: &ReferenceArgs) -> Result<(), Failure> {
    let view = &args.view;
    files::distinct(&args.output, &view.file)?;
    let (mut scene, animation) = input::view(view)?;
    let moment = moment::single(view.clock, &animation)?;
    input::check_size(&scene, view.samples().usual(), MAX_POINTS, ["camera rays", "reference", ""])?;
    let files = Files::create(&args.output, None)?;
    let strategy = (args.geometry != Choice::Scene).then_some(Strategy::Spheres);
    let planned = |scene: &Scene| Plan::with_backdrops(strategy, scene);
    let mut blockers = BlockerSet::default();
    let takes_spheres = !args.unshadowed && args.geometry != Choice::Mesh;
    let spheres = match takes_spheres {
        true => {
            let plan = planned(&scene);
            Some(input::make_spheres(&mut scene, &animation, &plan, view.console.quiet)?)
        }
        false => None,
    };
    let exposure = match view.exposure {
        None if files.has_png() => exposure(&World::new(&scene)),
        exposure => exposure.unwrap_or_default(),
    };
    animation.seek(moment.time, &mut scene);
    if let Some(spheres) = spheres {
        spheres.pose(&scene, Some((&animation, moment.time)), &mut blockers)?;
    }
    let solid = planned(&scene).by_surfaces(&scene);
    let geometry = geometry(args, &solid);
    let world = World::new(&scene);
    let whole = [0..scene.width, 0..scene.height];
    let gbuffer = GBuffer::sampled(&world, [scene.width, scene.height], view.samples(), whole, &STOP);
    let gbuffer = gbuffer.ok_or_else(|| Failure::interrupted("stopped before the first sample"))?;
    let job = ReferenceJob { world: &world, gbuffer: &gbuffer, blockers: &blockers, geometry, seed: args.seed };
    let mut reference = Reference::new(job);

    let checkpoint = checkpoint_path(&args.output[0]);
    let seconds = sample(args, &mut reference, &checkpoint)?;
    let mut estimate = reference.estimate();
    gbuffer.add_emission(&mut estimate.radiance);
    gbuffer.add_emission(&mut estimate.unshadowed);
    let picture = gbuffer.picture(&estimate.radiance, scene.background);
    let picture = Picture::new(scene.width as usize, scene.height as usize, picture);
    let std_error = gbuffer.resolve_errors(&estimate.std_error);
    let layers = [
        ExrLayer::color("unshadowed", &gbuffer.picture(&estimate.unshadowed, scene.background)),
        ExrLayer::color("stderr", &std_error),
    ];
    files.write(&picture, &args.png.display(exposure), &layers)?;
    if args.keep {
        checkpoint::save(&reference, &checkpoint)?;
    } else {
        let _ = std::fs::remove_file(&checkpoint);
    }

    let counts = [gbuffer.len(), blockers.spheres.len(), world.triangle_count(), scene.lights.len()];
    report(args, counts, seconds, [mean(&std_error), mean(picture.pixels())])
}
/// The geometry that blocks light; `solid` has the objects whose surfaces do by their strategies.
fn geometry<'a>(args: &ReferenceArgs, solid: &'a [bool]) -> Geometry<'a> {
    match args.geometry {
        _ if args.unshadowed => Geometry::None,
        Choice::Mesh => Geometry::Mesh,
        Choice::Scene if solid.contains(&true) => Geometry::Mixed(solid),
        Choice::Scene | Choice::Spheres => Geometry::Spheres,
    }
}

/// Takes all samples that are not in the checkpoint; the seconds.
fn sample(args: &ReferenceArgs, reference: &mut Reference<'_>, checkpoint: &Path) -> Result<f64, Failure> {
    let is_quiet = args.view.console.quiet;
    let all = reference.work(args.spp);
    let done = |r: &Reference<'_>| 100.0 * (1.0 - r.work(args.spp) as f64 / all.max(1) as f64);
    if checkpoint::resume(reference, checkpoint, is_quiet)? && !is_quiet {
        note(format_args!("lobes: goes on from {}, {:.1} % done", checkpoint.display(), done(reference)));
    }
    let start = Instant::now();
    console::stoppable(|| checkpoint::advance(reference, args.spp, checkpoint, "sampling", is_quiet))?;
    if reference.samples() < args.spp {
        checkpoint::save(reference, checkpoint)?;
        return Err(Failure::interrupted(format_args!(
            "{:.1} % of the work is kept in {}; the same command goes on from there",
            done(reference),
            checkpoint.display()
        )));
    }
    Ok(start.elapsed().as_secs_f64())
}

fn mean(values: &[Vec3]) -> f64 {
    values.iter().map(|v| f64::from(v.x + v.y + v.z)).sum::<f64>() / (3.0 * values.len().max(1) as f64)
}

/// Prints the numbers of points, spheres, triangles and lights, the seconds, and the means of the standard error and of the radiance.
fn report(
    args: &ReferenceArgs,
    [points, spheres, triangles, lights]: [usize; 4],
    seconds: f64,
    [mean_error, mean_radiance]: [f64; 2],
) -> Result<(), Failure> {
    let samples = args.spp.next_multiple_of(REPLICATES);
    if args.view.console.json {
        say(serde_json::to_string_pretty(&json!({
            "geometry": if args.unshadowed { "none".to_owned() } else { name(&args.geometry) },
            "spp": samples,
            "points": points,
            "spheres": spheres,
            "triangles": triangles,
            "lights": lights,
            "seconds": seconds,
            "stderr": mean_error,
            "mean": mean_radiance,
        }))?);
    } else if !args.view.console.quiet {
        let relative = if mean_radiance > 0.0 { 100.0 * mean_error / mean_radiance } else { 0.0 };
        say(format_args!("{samples} samples, {points} points, {seconds:.2} s"));
        say(format_args!("standard error {mean_error:.3e}, {relative:.4} % of the mean radiance {mean_radiance:.6}"));
    }
    Ok(())
}

fn checkpoint_path(output: &Path) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(".checkpoint");
    name.into()
}
