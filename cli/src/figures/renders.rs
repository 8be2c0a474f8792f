//! Figures that are pictures of a scene: 5, 12, 13, 16, 18, 19, 21 and 22.

use super::canvas::{Cell, Sheet};
use super::gallery::Page;
use super::lab::{SMOOTH, cell, reference, shade};
use super::measure::{How, Timing, frames};
use super::scenes::{Case, cube, diffuse, light, on_floor, spiral_lights};
use super::studio::Studio;
use crate::drawing::smaller;
use crate::failure::Failure;
use cosine_lobes::lighting::{FlatLight, Light, SphereLight};
use cosine_lobes::lobe_core::Sphere;
use cosine_lobes::paper::Tables;
use cosine_lobes::ray_tracing::{GBuffer, World};
use cosine_lobes::reference::Geometry;
use cosine_lobes::render_cpu::blockers;
use cosine_lobes::scene::{BlockerSet, Scene, ShadingPoints, builtin};
use cosine_lobes::{Comparison, Picture, signed_difference};
use glam::Vec3;
use std::ops::ControlFlow;

/// Frames of which the median is taken.
const REPEATS: usize = 7;
/// Frames a second of the paper.
const PAPER_FPS: [f64; 3] = [3.01, 4.5, 2.3];

/// Both methods, with their names.
fn methods(tables: &Tables) -> [(&'static str, How<'_>); 2] {
    [("moments", How::default()), ("paper", How { tables: Some(tables), ..How::default() })]
}

fn fps(timing: &Timing) -> f64 {
    1.0 / timing.stats.seconds
}

/// Times a case by a method at the paper's number of points.
fn timed(
    case: &Case,
    scene: &Scene,
    blockers: &BlockerSet,
    gbuffer: &GBuffer,
    how: How<'_>,
) -> Result<Timing, Failure> {
    let points = case.counted(gbuffer.points.clone());
    frames(scene, blockers, &points, how, REPEATS).map(|(timing, _)| timing).map_err(Failure::new)
}

pub(super) fn thresholds(name: &str, studio: &mut Studio) -> Result<Page, Failure> {
    const THRESHOLDS: [f32; 4] = [0.0, 0.001, 0.004, 0.016];
    let (tables, cow) = (studio.tables()?, studio.model(64)?);
    let (scene, blockers, gbuffer) = Case::fig15().make(&cow);
    let mut cells: Vec<Cell> = Vec::new();
    let mut first: Option<Picture> = None;
    let mut rows = String::new();
    for threshold in THRESHOLDS {
        let how = How { threshold, tables: Some(&tables) };
        let (timing, radiance) = frames(&scene, &blockers, &gbuffer.points, how, 1).map_err(Failure::new)?;
        let picture = super::lab::resolve(&gbuffer, &radiance);
        let counts = timing.stats.counts;
        let dropped = 100.0 * counts.pruned as f64 / counts.integrals.max(1) as f64;
        let change = match &first {
            None => 0.0,
            Some(first) => {
                let change = Comparison::of(&picture, first)?;
                100.0 * change.mae / change.reference_mean
            }
        };
        cells.push(cell(format!("t = {threshold}"), format!("{dropped:.0} % of the products dropped"), &picture, 0.0));
        rows += &format!("\n| {threshold} | {dropped:.1} % | {change:.2} % |");
        first.get_or_insert(picture);
    }
    Ok(Page {
        title: "a scene with several thresholds",
        images: vec![Sheet::new(4, cells).image(name)?],
        shows: "The same scene by method `paper`, with products left out whose radiance is below the threshold t. Penumbrae are made of many \
                thin lobes, which are the first to go."
            .into(),
        paper: "When the threshold is too high, shadows become aliased (Fig. 5, §4.3). No numbers.".into(),
        here: format!(
            "The threshold is in units of radiance, of which the picture's mean is {:.2}:\n\n| t | products dropped | change of the picture, of \
             its mean |\n|---|---|---|{rows}\n\nAt t = 0 only products that are nothing are dropped.",
            first.map_or(0.0, |p| p.pixels().iter().map(|c| c.y).sum::<f32>() / p.pixels().len() as f32)
        ),
        differs: "The paper's scene and its values of t are not given.".into(),
    })
}

/// Samples of the references.
const SAMPLES: u32 = 256;

pub(super) fn methods_beside_reference(name: &str, studio: &mut Studio) -> Result<Page, Failure> {
    let tables = studio.tables()?;
    let mut scene = Scene { width: 320, height: 180, ..builtin() };
    let set = blockers(&scene, &mut |_, _| ControlFlow::Continue(()))?;
    let gbuffer = GBuffer::new(&World::new(&scene), scene.width, scene.height, 1);
    // Those of points with textures, too.
    scene.materials.clone_from(&gbuffer.materials);
    let truth = reference(&scene, &set, &gbuffer, Geometry::Spheres, SAMPLES);
    let mut cells = vec![cell("reference", format!("Monte Carlo, {SAMPLES} samples"), &truth, 0.0)];
    let (mut maps, mut rows) = (Vec::new(), String::new());
    for (method, how) in methods(&tables) {
        let picture = shade(&scene, &set, &gbuffer, how)?;
        let error = Comparison::of(&picture, &truth)?;
        let [relative, whole, bias] =
            [error.mean_relative, error.mae / error.reference_mean, error.bias / error.reference_mean];
        let relative = 100.0 * relative;
        cells.push(cell(format!("method {method}"), format!("pixel to pixel {relative:.2} %"), &picture, 0.0));
        maps.push(Cell {
            title: format!("{method} − reference"),
            note: "white 0, full colour ±20 % of the mean".into(),
            size: (picture.width(), picture.height()),
            rgb: signed_difference(&picture, &truth, 0.2 * error.reference_mean)?,
        });
        rows += &format!("\n| `{method}` | {relative:.3} % | {:.3} % | {:+.3} % |", 100.0 * whole, 100.0 * bias);
    }
    let mesh = reference(&scene, &set, &gbuffer, Geometry::Mesh, SAMPLES);
    let proxy = Comparison::of(&mesh, &truth)?;
    cells.push(cell("reference, triangles", "instead of blocker spheres", &mesh, 0.0));
    cells.extend(maps);
    Ok(Page {
        title: "both methods beside a reference",
        images: vec![Sheet::new(3, cells).image(name)?],
        shows: "The built-in scene by Monte Carlo and by both methods, all with the same blocker spheres, masks of depth 5.".into(),
        paper: "The mean pixel-to-pixel difference between path tracing and the paper's method is 12.57 %, that of the integration alone \
                10.02 % (Fig. 12, §6)."
            .into(),
        here: format!(
            "Against the reference:\n\n| method | pixel to pixel | mean difference, of the mean | signed |\n|---|---|---|---|{rows}\n\n\
             Triangles instead of spheres change the reference by {:.2} % of its mean.",
            100.0 * proxy.mae / proxy.reference_mean
        ),
        differs: "The paper's scene is not available: the built-in one stands for it.".into(),
    })
}

pub(super) fn lafortune(name: &str, studio: &mut Studio) -> Result<Page, Failure> {
    let (tables, cow) = (studio.tables()?, studio.model(67)?);
    let case = Case::fig13();
    let (scene, blockers, gbuffer) = case.make(&cow);
    let picture = shade(&scene, &blockers, &case.look(&scene, SMOOTH), How::default())?;
    let (mut rows, mut penumbra, mut points) = (String::new(), None, 0);
    for (method, how) in methods(&tables) {
        let timing = timed(&case, &scene, &blockers, &gbuffer, how)?;
        points = timing.points;
        penumbra.get_or_insert(timing.shares()[1]);
        rows += &format!(
            "\n| `{method}` | {} | {} | {:.0} | {:.0} × |",
            timing.milliseconds(),
            timing.processor_milliseconds(),
            fps(&timing),
            fps(&timing) / PAPER_FPS[0]
        );
    }
    Ok(Page {
        title: "spatially varying Lafortune, two lobes",
        images: vec![Sheet::new(1, vec![cell("method moments", "sixteen materials by a pattern", &picture, 0.3)]).image(name)?],
        shows: "A diffuse part and one Lafortune lobe, whose colours and exponents (8 to 200) vary over the surfaces.".into(),
        paper: "89 284 points, 67 spheres, one spherical light: 3.01 frames a second (Fig. 13).".into(),
        here: format!(
            "{points} points, {} spheres, {} light, on {} threads, visible points given, {:.0} % of the points in penumbra:\n\n| method | ms a frame (quartiles) | ms \
             on processors | frames a second | over the paper's |\n|---|---|---|---|---|{rows}",
            blockers.spheres.len(),
            scene.lights.len(),
            rayon::current_num_threads(),
            100.0 * penumbra.unwrap_or_default()
        ),
        differs: "The paper's model and its materials are not available, and it does not say whether finding the visible points is in its time."
            .into(),
    })
}

pub(super) fn many(name: &str, studio: &mut Studio) -> Result<Page, Failure> {
    let (tables, cow) = (studio.tables()?, studio.model(64)?);
    let case = Case::fig16();
    let (scene, blockers, gbuffer) = case.make(&cow);
    let (mut rows, mut picture, mut penumbra) = (String::new(), None, None);
    for (method, how) in methods(&tables) {
        let (timing, radiance) = frames(&scene, &blockers, &gbuffer.points, how, 3).map_err(Failure::new)?;
        penumbra.get_or_insert(timing.shares()[1]);
        let over = 17.68 / timing.stats.seconds;
        rows += &format!(
            "\n| `{method}` | {} | {} | {over:.0} × |",
            timing.milliseconds(),
            timing.processor_milliseconds()
        );
        picture.get_or_insert_with(|| smaller(&super::lab::resolve(&gbuffer, &radiance), 2));
    }
    let cells = picture.iter().map(|p| cell("method moments", "56 cows, two lights", p, 1.6)).collect();
    let triangles = 56 * cow.mesh.triangles.len();
    Ok(Page {
        title: "3578 spheres",
        images: vec![Sheet::new(1, cells).image(name)?],
        shows: "Many objects, each by its own spheres, under two spherical lights.".into(),
        paper: "3578 spheres, 642 000 points, 664 011 triangles, two spherical lights, depth 5: 17.68 s (Fig. 16)."
            .into(),
        here: format!(
            "The same numbers of spheres, points and lights, {triangles} triangles, on {} threads, {:.0} % of the points and lights in \
             penumbra:\n\n| method | ms a frame (quartiles) | ms on processors | the paper's time over it |\n|---|---|---|---|{rows}",
            rayon::current_num_threads(),
            100.0 * penumbra.unwrap_or_default()
        ),
        differs: "The paper's scene is not available.".into(),
    })
}

pub(super) fn self_shadows(name: &str, studio: &mut Studio) -> Result<Page, Failure> {
    let (tables, cow) = (studio.tables()?, studio.model(484)?);
    let (mut cells, mut rows) = (Vec::new(), String::new());
    let mut costs = Vec::new();
    for (large, title) in [(false, "small light"), (true, "large light, four times as wide")] {
        let case = Case::fig18(large);
        let (scene, blockers, gbuffer) = case.make(&cow);
        let picture = shade(&scene, &blockers, &case.look(&scene, SMOOTH), How::default())?;
        let paper = PAPER_FPS[1 + usize::from(large)];
        rows += &format!("\n| {title} | {paper} |");
        for (_, how) in methods(&tables) {
            let timing = timed(&case, &scene, &blockers, &gbuffer, how)?;
            rows += &format!(" {:.1} ({:.0} ×) |", fps(&timing), fps(&timing) / paper);
            if how.tables.is_none() {
                let [_, penumbra, _] = timing.shares();
                cells.push(cell(title, format!("{:.0} % in penumbra", 100.0 * penumbra), &picture, 0.0));
            }
            costs.push(timing.cost());
        }
    }
    Ok(Page {
        title: "self-shadowing",
        images: vec![Sheet::new(2, cells).image(name)?],
        shows: "One object fills the picture and shades itself, under a small and a large light of the same flux."
            .into(),
        paper: "484 spheres, 85 558 points, depth 5: 4.5 and 2.3 frames a second, a ratio of 1.96 (Fig. 18).".into(),
        here: format!(
            "The same counts, frames a second on {} threads, and how many times the paper's:\n\n| light | the paper | `moments` | `paper` |\n\
             |---|---|---|---|{rows}\n\nOn processors the large light takes {:.1} times as long with `moments`, {:.1} times with `paper`.",
            rayon::current_num_threads(),
            costs[2] / costs[0],
            costs[3] / costs[1]
        ),
        differs: "The paper's model (610 102 triangles) is not available; the widths of its lights are not given."
            .into(),
    })
}

/// All heights of the object fit into the picture.
fn widen(scene: &mut Scene) {
    scene.camera.target = Vec3::new(-0.5, 0.85, -0.2);
    scene.camera.projection = cosine_lobes::scene::Projection::perspective(42_f32.to_radians());
}

/// The square light of Fig. 19: its middle, half its sides, and its normal.
fn square() -> (Vec3, Vec3, Vec3) {
    let center = Vec3::new(2.2, 5.5, 1.2);
    let normal = -center.normalize();
    let u = normal.any_orthonormal_vector();
    (center, u * 0.9, normal.cross(u) * 0.9)
}

const BRIGHTNESS: f32 = 9.0;

/// The square itself; nine spheres; one sphere: seen from the front all have the same area.
fn square_lights() -> Result<[Vec<Light>; 3], Failure> {
    let (center, u, v) = square();
    let radiance = Vec3::splat(BRIGHTNESS);
    let sphere = |center: Vec3, radius: f32| Light::from(SphereLight::new(Sphere { center, radius }, radiance));
    let side = 2.0 * u.length();
    let radius = side / core::f32::consts::PI.sqrt();
    let nine = (0..9)
        .map(|i| sphere(center + u * ((i % 3) as f32 - 1.0) / 1.5 + v * ((i / 3) as f32 - 1.0) / 1.5, radius / 3.0));
    let flat = FlatLight::rectangle(center, u, v, radiance)?;
    Ok([vec![Light::from(flat)], nine.collect(), vec![sphere(center, radius)]])
}

/// Frames a second of each method, as cells of a table.
fn speeds_of(scene: &Scene, blockers: &BlockerSet, points: &ShadingPoints, tables: &Tables) -> Result<String, Failure> {
    let mut cells = String::new();
    for (_, how) in methods(tables) {
        let (timing, _) = frames(scene, blockers, points, how, 3).map_err(Failure::new)?;
        cells += &format!(" {:.1} |", fps(&timing));
    }
    Ok(cells)
}

pub(super) fn square_light(name: &str, studio: &mut Studio) -> Result<Page, Failure> {
    const HEIGHTS: [f32; 3] = [0.0, 0.7, 1.4];
    const SIDE: u32 = 200;
    let (tables, cow) = (studio.tables()?, studio.model(485)?);
    let [flat, nine, one] = square_lights()?;
    let paper = How { tables: Some(&tables), ..How::default() };
    let lit: [(&str, &[Light], How<'_>); 5] = [
        ("nine spheres, `paper`", &nine, paper),
        ("one sphere, `paper`", &one, paper),
        ("nine spheres, `moments`", &nine, How::default()),
        ("one sphere, `moments`", &one, How::default()),
        ("the square, `moments`", &flat, How::default()),
    ];
    let mut cells: Vec<Vec<Cell>> = vec![Vec::new(); lit.len()];
    let mut errors = vec![String::new(); lit.len()];
    let mut speeds = String::new();
    for (k, height) in HEIGHTS.into_iter().enumerate() {
        let (mut scene, blockers) = on_floor(&cow, height, light(Vec3::Y, 1.0), diffuse());
        widen(&mut scene);
        scene.lights.clone_from(&flat);
        let gbuffer = GBuffer::new(&World::new(&scene), SIDE, SIDE, 1);
        let truth = reference(&scene, &blockers, &gbuffer, Geometry::Spheres, SAMPLES);
        for (i, (title, lights, how)) in lit.iter().enumerate() {
            scene.lights = lights.to_vec();
            let picture = shade(&scene, &blockers, &gbuffer, *how)?;
            let error = Comparison::of(&picture, &truth)?;
            errors[i] += &format!(" {:.2} % |", 100.0 * error.mae / error.reference_mean);
            let note = format!("height #{}", k + 1);
            cells[i].push(cell(title.replace('`', ""), note, &picture, 0.8));
        }
        // 277 K points under one sphere, which the caption times.
        scene.lights.clone_from(&one);
        let points = GBuffer::new(&World::new(&scene), 526, 527, 1).points;
        speeds += &format!("\n| #{} | {} |", k + 1, ["1.6", "0.2", "0.2"][k]);
        speeds += &speeds_of(&scene, &blockers, &points, &tables)?;
    }
    // As in the paper, nine spheres and one; and the square.
    let shown = [0, 1, 4].into_iter().flat_map(|i| core::mem::take(&mut cells[i])).collect();
    let rows: String = lit.iter().zip(&errors).map(|((title, ..), errors)| format!("\n| {title} |{errors}")).collect();
    Ok(Page {
        title: "a square light, as spheres and as itself",
        images: vec![Sheet::new(3, shown).image(name)?],
        shows: "An object at three heights under a square light. Upper row: the square as nine spheres; middle row: as one sphere; lower row: the \
                square itself, which this project has as a kind of light."
            .into(),
        paper: "A square as nine spheres, 485 spheres for the object, depth 5; with one sphere of the same visible area shadows are smoother \
                (Fig. 19, §6). One sphere, 277 K points: 1.6, 0.2 and 0.2 frames a second."
            .into(),
        here: format!(
            "Mean difference from Monte Carlo of the true square ({SAMPLES} samples, the same blocker spheres), of the mean:\n\n\
             | light | height #1 | #2 | #3 |\n|---|---|---|---|{rows}\n\nFrames a second with one sphere, 277 202 points, {} threads:\n\n\
             | height | the paper | `moments` | `paper` |\n|---|---|---|---|{speeds}",
            rayon::current_num_threads()
        ),
        differs: "The paper's model (301 713 triangles) is not available. It gives no frame rates for nine spheres. A sphere does not get darker when it is seen from the \
                  side, as a square does: that is part of the differences."
            .into(),
    })
}

pub(super) fn several_lights(name: &str) -> Result<Page, Failure> {
    let (mut cells, mut rows) = (Vec::new(), String::new());
    for count in [4, 6, 11] {
        let (mut scene, blockers) = cube(spiral_lights(count));
        (scene.camera.eye, scene.camera.target) = (Vec3::new(3.0, 3.0, 4.6), Vec3::Y * 0.45);
        scene.camera.projection = cosine_lobes::scene::Projection::perspective(27_f32.to_radians());
        let picture = shade(&scene, &blockers, &GBuffer::new(&World::new(&scene), 224, 224, SMOOTH), How::default())?;
        cells.push(cell(format!("{count} lights"), "method moments", &picture, 0.6 - (count as f32).log2()));
        let gbuffer = GBuffer::new(&World::new(&scene), 64, 64, 1);
        let picture = shade(&scene, &blockers, &gbuffer, How::default())?;
        let differences = [Geometry::Spheres, Geometry::Mesh].map(|geometry| {
            let truth = reference(&scene, &blockers, &gbuffer, geometry, 64);
            Comparison::of(&picture, &truth).map(|error| 100.0 * error.mae / error.reference_mean)
        });
        let [spheres, mesh] = differences;
        rows += &format!("\n| {count} | {:.2} % | {:.2} % |", spheres?, mesh?);
    }
    Ok(Page {
        title: "a cube under several lights",
        images: vec![Sheet::new(3, cells).image(name)?],
        shows: "A cube as 64 spheres on a grid, over a floor, with a shadow for each spherical light. Pictures are exposed by the number of \
                lights."
            .into(),
        paper: "A cube as 64 spheres, with 4, 6 and 11 spherical lights (Fig. 21).".into(),
        here: format!(
            "Mean difference from Monte Carlo, of the mean:\n\n| lights | of the same spheres | of the true cube |\n|---|---|---|{rows}\n\n\
             64 spheres leave out the edges and corners of a cube."
        ),
        differs: "The places of the paper's lights are not given.".into(),
    })
}

pub(super) fn softening(name: &str, studio: &mut Studio) -> Result<Page, Failure> {
    const NAMES: [&str; 3] = ["(a)", "(b)", "(c)"];
    let (tables, cow) = (studio.tables()?, studio.model(64)?);
    let case = Case::fig22(0);
    let mut scenes: Vec<(String, Scene, BlockerSet)> = Vec::new();
    for (k, letter) in NAMES.iter().enumerate() {
        let (scene, blockers, _) = Case::fig22(k).make(&cow);
        scenes.push((format!("{letter} object {} above the plane", [0.0, 0.7, 1.4][k]), scene, blockers));
    }
    // The light comes nearer, of the same radius; its brightness follows, so that the pictures stay comparable.
    for (letter, share) in ["(d)", "(e)", "(f)"].iter().zip([1.4_f32, 0.9, 0.6]) {
        let (mut scene, blockers) = on_floor(&cow, 0.0, light(Vec3::Y, 1.0), diffuse());
        let sphere = Sphere { center: Vec3::new(3.0, 5.5, 1.5) * share, radius: 0.6 };
        scene.lights = vec![SphereLight::new(sphere, Vec3::splat(30.0 * share * share / 0.36)).into()];
        let distance = sphere.center.y;
        scenes.push((format!("{letter} light {distance:.1} above the plane"), scene, blockers));
    }
    let (mut cells, mut rows) = (Vec::new(), String::new());
    for (title, mut scene, blockers) in scenes {
        let gbuffer = case.look(&scene, 1);
        widen(&mut scene);
        let wide = GBuffer::new(&World::new(&scene), 224, 224, SMOOTH);
        let picture = shade(&scene, &blockers, &wide, How::default())?;
        rows += &format!("\n| {title} |");
        for (_, how) in methods(&tables) {
            let timing = timed(&case, &scene, &blockers, &gbuffer, How { threshold: 0.001, ..how })?;
            let [_, penumbra, _] = timing.shares();
            if how.tables.is_none() {
                cells.push(cell(&title, format!("{:.1} % in penumbra", 100.0 * penumbra), &picture, 0.0));
                rows += &format!(" {:.1} % |", 100.0 * penumbra);
            }
            rows += &format!(" {:.0} |", fps(&timing));
        }
    }
    Ok(Page {
        title: "shadows soften with distance",
        images: vec![Sheet::new(3, cells).image(name)?],
        shows: "Upper row: the object rises above the plane. Lower row: the light comes nearer to it. Penumbrae grow in both.".into(),
        paper: "65 536 points, one diffuse lobe, one spherical light, 64 spheres, depth 5, threshold 0.001; frame rates fall as penumbrae grow \
                (Fig. 22)."
            .into(),
        here: format!(
            "The same counts and settings, frames a second on {} threads:\n\n| | penumbra | `moments` | `paper` |\n|---|---|---|---|{rows}",
            rayon::current_num_threads()
        ),
        differs: "The paper's frame rates for this figure, and its distances, are not in its text. The pictures show more than the views that are \
                  timed."
            .into(),
    })
}
