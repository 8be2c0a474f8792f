use crate::args::{Method, RenderArgs, Visibility, name};
use crate::console::{self, say};
use crate::failure::Failure;
use crate::files::{self, Files};
use crate::input;
use cosine_lobes::lighting::{Blockers, MaskVisibility, PaperVisibility, depth_for};
use cosine_lobes::lobe_core::paper::{ProductTable, Resolution, Tables};
use cosine_lobes::lobe_core::{self, Unshadowed, VisibilityLobes};
use cosine_lobes::render_cpu::{CpuShader, GBuffer, RayBlockers, TILE, World};
use cosine_lobes::scene::{BlockerSet, Frame, Scene, Shade, ShadeStats};
use cosine_lobes::visibility_spheres::SphereBlockers;
use cosine_lobes::{ExrLayer, ImageFileError, Output, Picture};
use glam::Vec3;
use rayon::prelude::*;
use serde_json::{Value, json};
use std::io::Write;
use std::time::Instant;

/// Camera rays in flight: bounds the memory of large pictures.
const BAND_RAYS: u64 = 1 << 19;

/// Seconds outside shading.
#[derive(Default)]
struct Clocks {
    load: f64,
    spheres: f64,
    tables: f64,
    hierarchy: f64,
    gbuffer: f64,
    write: f64,
}

/// The picture and what it is made of, row by row as bands are finished.
#[derive(Default)]
struct Planes {
    beauty: Vec<Vec3>,
    unshadowed: Vec<Vec3>,
    lights: Vec<Vec<Vec3>>,
    normals: Vec<Vec3>,
    depths: Vec<f32>,
    lobes: Vec<f32>,
    products: Vec<f32>,
    points: usize,
    /// One entry a repetition.
    stats: Vec<ShadeStats>,
}

fn seconds<T>(clock: &mut f64, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = work();
    *clock += start.elapsed().as_secs_f64();
    result
}

pub(crate) fn run(args: &RenderArgs) -> Result<(), Failure> {
    files::distinct(args.output.iter().chain(&args.stats), &args.view.file)?;
    let mut clocks = Clocks::default();
    let mut scene = seconds(&mut clocks.load, || input::view(&args.view))?;
    let files = Files::create(&args.output)?;
    let stats_file = args.stats.as_ref().map(Output::create).transpose()?;
    let quiet = args.view.quiet;
    let blockers = match args.visibility {
        Visibility::Spheres => seconds(&mut clocks.spheres, || input::make_blockers(&mut scene, quiet))?,
        Visibility::Rays | Visibility::None => BlockerSet::default(),
    };
    let world = seconds(&mut clocks.hierarchy, || World::new(&scene));
    let depth = args.depth.unwrap_or_else(|| depth_for(args.tolerance));
    let frame = Frame {
        materials: &scene.materials,
        lights: &scene.lights,
        tolerance: args.tolerance,
        depth,
        threshold: args.threshold,
    };
    let tables = match args.method {
        Method::Moments => None,
        Method::Paper => Some(seconds(&mut clocks.tables, || paper_tables(quiet))),
    };
    let planes = match args.visibility {
        Visibility::Spheres => {
            let spheres = SphereBlockers::new(&blockers.spheres, &blockers.objects, &blockers.self_distances);
            masked(args, &world, &frame, spheres, tables.as_ref(), &mut clocks)?
        }
        Visibility::Rays => masked(args, &world, &frame, RayBlockers::new(&world), tables.as_ref(), &mut clocks)?,
        Visibility::None => {
            let method = tables.as_ref().map_or(lobe_core::Method::Moments, lobe_core::Method::Paper);
            picture(args, &world, &frame, CpuShader::with_method(Unshadowed, method), &mut clocks)?
        }
    };

    let (width, height) = (scene.width as usize, scene.height as usize);
    let layers = if args.layers { planes.layers() } else { Vec::new() };
    let image = Picture::new(width, height, planes.beauty);
    seconds(&mut clocks.write, || files.write(&image, args.view.exposure, &layers))?;

    let stats = summary(args, &scene, &world, &blockers, planes.points, planes.stats, &clocks);
    if let Some(output) = stats_file {
        let text = serde_json::to_string_pretty(&stats)?;
        let path = output.path().to_owned();
        output.finish(|file| writeln!(file, "{text}").map_err(|source| ImageFileError::Io { path, source }))?;
    }
    if args.view.json {
        say(serde_json::to_string_pretty(&stats)?);
    } else if !quiet {
        print(args, &stats);
    }
    Ok(())
}

/// The picture with any strategy that fills masks, by either method.
fn masked<B: Blockers>(
    args: &RenderArgs,
    world: &World<'_>,
    frame: &Frame<'_>,
    blockers: B,
    tables: Option<&Tables>,
    clocks: &mut Clocks,
) -> Result<Planes, Failure> {
    match tables {
        None => picture(args, world, frame, CpuShader::new(MaskVisibility::new(blockers, frame.depth)), clocks),
        Some(tables) => {
            let visibility = PaperVisibility::new(blockers, frame.depth, tables);
            let shader = CpuShader::with_method(visibility, lobe_core::Method::Paper(tables));
            picture(args, world, frame, shader, clocks)
        }
    }
}

/// The paper's tables, row by row on all cores.
fn paper_tables(quiet: bool) -> Tables {
    let resolution = Resolution::PAPER;
    let count = resolution.exponents() as u64;
    let bar = console::progress("product table", count, quiet);
    let rows: Vec<_> = (0..count as usize)
        .into_par_iter()
        .map(|row| {
            let row = ProductTable::build_row(resolution, row);
            bar.inc(1);
            row
        })
        .collect();
    bar.finish_and_clear();
    Tables::with_products(ProductTable::from_rows(resolution, rows))
}

/// Shades the picture in bands.
fn picture<V: VisibilityLobes>(
    args: &RenderArgs,
    world: &World<'_>,
    frame: &Frame<'_>,
    mut shader: CpuShader<'_, V>,
    clocks: &mut Clocks,
) -> Result<Planes, Failure> {
    let scene = world.scene();
    let samples = args.view.samples;
    let ray_rows = BAND_RAYS / (u64::from(scene.width) * u64::from(samples));
    let band = (ray_rows as u32 / TILE * TILE).max(TILE);
    let bar = console::progress("shading", u64::from(scene.height), args.view.quiet);
    let mut planes = Planes { lights: vec![Vec::new(); frame.lights.len()], ..Planes::default() };
    // At once: a picture that finds no room is refused here, and growing would take twice the memory.
    planes.beauty.try_reserve_exact(scene.width as usize * scene.height as usize)?;
    planes.stats.resize(args.repeat as usize, ShadeStats::default());
    for top in (0..scene.height).step_by(band as usize) {
        let rows = top..(top + band).min(scene.height);
        bar.set_position(u64::from(top));
        let g = seconds(&mut clocks.gbuffer, || GBuffer::rows(world, scene.width, scene.height, samples, rows));
        let mut radiance = vec![Vec3::ZERO; g.len()];
        for total in &mut planes.stats {
            let stats = if args.layers {
                let (stats, layers) = shader.shade_layers(&g.points, frame, &mut radiance)?;
                if planes.unshadowed.len() == planes.beauty.len() {
                    let count = frame.lights.len();
                    planes.unshadowed.extend(g.resolve(&layers.unshadowed, scene.background));
                    for (l, plane) in planes.lights.iter_mut().enumerate() {
                        let part: Vec<Vec3> = layers.lights.iter().skip(l).step_by(count).copied().collect();
                        plane.extend(g.resolve(&part, Vec3::ZERO));
                    }
                    let numbers = |n: &[u32]| n.iter().map(|n| *n as f32).collect::<Vec<f32>>();
                    planes.lobes.extend(g.resolve(&numbers(&layers.lobes), 0.0));
                    planes.products.extend(g.resolve(&numbers(&layers.integrals), 0.0));
                }
                stats
            } else {
                shader.shade(&g.points, frame, &mut radiance)?
            };
            add(total, &stats);
        }
        if args.layers {
            let normals: Vec<Vec3> = g.points.receivers.iter().map(|r| r.normal).collect();
            planes.normals.extend(g.resolve(&normals, Vec3::ZERO));
            planes.depths.extend(g.resolve(&g.depths, f32::INFINITY));
        }
        planes.beauty.extend(g.resolve(&radiance, scene.background));
        planes.points += g.len();
    }
    bar.finish_and_clear();
    Ok(planes)
}

fn add(total: &mut ShadeStats, band: &ShadeStats) {
    total.seconds += band.seconds;
    let (a, b) = (&mut total.stages, &band.stages);
    a.reflectance += b.reflectance;
    a.lighting += b.lighting;
    a.mask += b.mask;
    a.visibility_lobes += b.visibility_lobes;
    a.integration += b.integration;
    let (a, b) = (&mut total.counts, &band.counts);
    a.lobes += b.lobes;
    a.integrals += b.integrals;
    a.pruned += b.pruned;
    a.lit_points += b.lit_points;
    a.dark_points += b.dark_points;
    a.penumbra_points += b.penumbra_points;
}

impl Planes {
    fn layers(&self) -> Vec<ExrLayer> {
        let mut layers = vec![ExrLayer::color("unshadowed", &self.unshadowed)];
        layers.extend(self.lights.iter().enumerate().map(|(i, l)| ExrLayer::color(&format!("light{i}"), l)));
        layers.push(ExrLayer::vector("normal", &self.normals));
        layers.push(ExrLayer::scalar("depth", 'Z', self.depths.clone()));
        layers.push(ExrLayer::scalar("lobes", 'N', self.lobes.clone()));
        layers.push(ExrLayer::scalar("products", 'N', self.products.clone()));
        layers
    }
}

fn summary(
    args: &RenderArgs,
    scene: &Scene,
    world: &World<'_>,
    blockers: &BlockerSet,
    points: usize,
    mut runs: Vec<ShadeStats>,
    clocks: &Clocks,
) -> Value {
    runs.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    let ShadeStats { seconds, stages, counts } = runs.get(runs.len() / 2).copied().unwrap_or_default();
    json!({
        "device": name(&args.device),
        "method": name(&args.method),
        "visibility": name(&args.visibility),
        "width": scene.width,
        "height": scene.height,
        "points": points,
        "frames": runs.len(),
        "lights": scene.lights.len(),
        "spheres": blockers.spheres.len(),
        "triangles": world.triangle_count(),
        "tolerance": decimal(args.tolerance),
        "depth": args.depth.unwrap_or_else(|| depth_for(args.tolerance)),
        "threads": rayon::current_num_threads(),
        "seconds": seconds,
        "points_per_second": if seconds > 0.0 { points as f64 / seconds } else { 0.0 },
        "stages": {
            "reflectance": stages.reflectance,
            "lighting": stages.lighting,
            "mask": stages.mask,
            "visibility_lobes": stages.visibility_lobes,
            "integration": stages.integration,
        },
        "counts": {
            "lobes": counts.lobes,
            "integrals": counts.integrals,
            "pruned": counts.pruned,
            "lit_points": counts.lit_points,
            "dark_points": counts.dark_points,
            "penumbra_points": counts.penumbra_points,
        },
        "load_seconds": clocks.load,
        "spheres_seconds": clocks.spheres,
        "tables_seconds": clocks.tables,
        "hierarchy_seconds": clocks.hierarchy,
        "gbuffer_seconds": clocks.gbuffer,
        "write_seconds": clocks.write,
    })
}

/// The number as it was typed, not with the digits that f64 adds to an f32.
fn decimal(x: f32) -> f64 {
    x.to_string().parse().unwrap_or(f64::from(x))
}

fn print(args: &RenderArgs, stats: &Value) {
    let names: Vec<String> = args.output.iter().map(|p| p.display().to_string()).collect();
    let number = |key: &str| stats[key].as_f64().unwrap_or_default();
    let milliseconds = |key: &str| format!("{:.1} ms", 1e3 * number(key));
    let counts = &stats["counts"];
    let count = |key: &str| counts[key].as_u64().unwrap_or_default();
    let pairs = count("lit_points") + count("dark_points") + count("penumbra_points");
    let share = 100.0 * count("penumbra_points") as f64 / pairs.max(1) as f64;
    say(format_args!("{}: {} x {}", names.join(", "), stats["width"], stats["height"]));
    say(format_args!(
        "shading {} ({} points, {} spheres, {} lights, {share:.1} % in penumbra), G-buffer {}, spheres {}, writing {}",
        milliseconds("seconds"),
        stats["points"],
        stats["spheres"],
        stats["lights"],
        milliseconds("gbuffer_seconds"),
        milliseconds("spheres_seconds"),
        milliseconds("write_seconds"),
    ));
}
