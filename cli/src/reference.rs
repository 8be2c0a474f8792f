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
    let moment = moment::single(view, &animation)?;
    let points = u64::from(scene.width) * u64::from(scene.height) * u64::from(view.samples().usual());
    if points > MAX_POINTS {
        return Err(Failure::new(format_args!(
            "{points} camera rays are too many for a reference, at most {MAX_POINTS}"
        )));
    }
    let files = Files::create(&args.output, None)?;
    let planned = |scene: &Scene| Plan::new((args.geometry != Choice::Scene).then_some(Strategy::Spheres), scene);
    let mut blockers = BlockerSet::default();
    let takes_spheres = !args.unshadowed && args.geometry != Choice::Mesh;
    let spheres = match takes_spheres {
        true => {
            let plan = planned(&scene);
            Some(input::make_spheres(&mut scene, &animation, &plan, view.quiet)?)
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
    let geometry = match args.geometry {
        _ if args.unshadowed => Geometry::None,
        Choice::Mesh => Geometry::Mesh,
        Choice::Scene if solid.contains(&true) => Geometry::Mixed(&solid),
        Choice::Scene | Choice::Spheres => Geometry::Spheres,
    };
    let world = World::new(&scene);
    let whole = [0..scene.width, 0..scene.height];
    let gbuffer = GBuffer::sampled(&world, [scene.width, scene.height], view.samples(), whole, &STOP);
    let gbuffer = gbuffer.ok_or_else(|| Failure::interrupted("stopped before the first sample"))?;
    let job = ReferenceJob { world: &world, gbuffer: &gbuffer, blockers: &blockers, geometry, seed: args.seed };
    let mut reference = Reference::new(job);

    let checkpoint = checkpoint_path(&args.output[0]);
    let all = reference.work(args.spp);
    let done = |r: &Reference<'_>| 100.0 * (1.0 - r.work(args.spp) as f64 / all.max(1) as f64);
    if checkpoint::resume(&mut reference, &checkpoint, view.quiet)? && !view.quiet {
        note(format_args!("lobes: goes on from {}, {:.1} % done", checkpoint.display(), done(&reference)));
    }
    let start = Instant::now();
    console::stoppable(|| checkpoint::advance(&mut reference, args.spp, &checkpoint, "sampling", view.quiet))?;
    let seconds = start.elapsed().as_secs_f64();
    if reference.samples() < args.spp {
        checkpoint::save(&reference, &checkpoint)?;
        return Err(Failure::interrupted(format_args!(
            "{:.1} % of the work is kept in {}; the same command goes on from there",
            done(&reference),
            checkpoint.display()
        )));
    }

    let mut estimate = reference.estimate();
    gbuffer.add_emission(&mut estimate.radiance);
    gbuffer.add_emission(&mut estimate.unshadowed);
    let picture = gbuffer.picture(&estimate.radiance, scene.background);
    let picture = Picture::new(scene.width as usize, scene.height as usize, picture);
    let std_error = of_pixels(&estimate.std_error, &gbuffer);
    let layers = [
        ExrLayer::color("unshadowed", &gbuffer.picture(&estimate.unshadowed, scene.background)),
        ExrLayer::color("stderr", &std_error),
    ];
    files.write(&picture, exposure, &layers)?;
    if args.keep {
        checkpoint::save(&reference, &checkpoint)?;
    } else {
        let _ = std::fs::remove_file(&checkpoint);
    }

    let mean = |values: &[Vec3]| {
        values.iter().map(|v| f64::from(v.x + v.y + v.z)).sum::<f64>() / (3.0 * values.len().max(1) as f64)
    };
    let samples = args.spp.next_multiple_of(REPLICATES);
    let (mean_error, mean_radiance) = (mean(&std_error), mean(picture.pixels()));
    if view.json {
        say(serde_json::to_string_pretty(&json!({
            "geometry": if args.unshadowed { "none".to_owned() } else { name(&args.geometry) },
            "spp": samples,
            "points": gbuffer.len(),
            "spheres": blockers.spheres.len(),
            "triangles": world.triangle_count(),
            "lights": scene.lights.len(),
            "seconds": seconds,
            "stderr": mean_error,
            "mean": mean_radiance,
        }))?);
    } else if !view.quiet {
        let relative = if mean_radiance > 0.0 { 100.0 * mean_error / mean_radiance } else { 0.0 };
        say(format_args!("{samples} samples, {} points, {seconds:.2} s", gbuffer.len()));
        say(format_args!("standard error {mean_error:.3e}, {relative:.4} % of the mean radiance {mean_radiance:.6}"));
    }
    Ok(())
}

/// Standard errors of pixels from those of their points. These are independent: a pixel's variance is the sum of theirs times the
/// squares of their parts of its rays. In units of the largest, whose square may be no f32.
fn of_pixels(errors: &[Vec3], gbuffer: &GBuffer) -> Vec<Vec3> {
    let largest = errors.iter().map(|e| e.max_element()).fold(0.0, f32::max);
    let unit = if largest > 0.0 { largest } else { 1.0 };
    let mut variances: Vec<Vec3> = errors.iter().map(|e| (*e / unit) * (*e / unit)).collect();
    variances.iter_mut().zip(&gbuffer.rays).for_each(|(variance, rays)| *variance *= *rays as f32);
    let part = 1.0 / gbuffer.samples as f32;
    gbuffer.resolve(&variances, Vec3::ZERO).iter().map(|v| (*v * part).map(f32::sqrt) * unit).collect()
}

fn checkpoint_path(output: &Path) -> PathBuf {
    let mut name = output.as_os_str().to_owned();
    name.push(".checkpoint");
    name.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One pixel of as many rays, of which its points stand for so many each.
    fn pixel(samples: u32, rays: &[u32]) -> GBuffer {
        let points = if rays.is_empty() { samples as usize } else { rays.len() };
        GBuffer { width: 1, height: 1, samples, pixels: vec![0; points], rays: rays.to_vec(), ..GBuffer::default() }
    }

    #[test]
    fn errors_of_any_radiance() {
        for size in [1e-30_f32, 1.0, 1e30] {
            let errors = [Vec3::splat(3.0 * size), Vec3::splat(4.0 * size)];
            // √(9 + 16)/2, and √((1·3)² + (3·4)²)/4 where the second stands for three of four rays.
            for (pixel, want) in [(pixel(2, &[]), 2.5), (pixel(4, &[1, 3]), 153.0_f32.sqrt() / 4.0)] {
                let error = of_pixels(&errors, &pixel)[0] / size;
                assert!((error - Vec3::splat(want)).length() < 1e-5, "{size}: {error}");
            }
        }
        assert_eq!(of_pixels(&[Vec3::ZERO], &pixel(1, &[])), [Vec3::ZERO]);
    }
}
