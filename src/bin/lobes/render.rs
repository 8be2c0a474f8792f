use crate::args::{Method, RenderArgs, name};
use crate::console::{self, note, say};
use crate::failure::Failure;
use crate::files::{self, Files};
use crate::input;
use crate::picture::{Bands, Planes, Shading, seconds};
use crate::stats::{self, Clocks, Figures};
use crate::strategy::{Occlusion, Plan};
use cosine_lobes::lighting::depth_for;
use cosine_lobes::lobe_core::paper::{ProductTable, Resolution, Tables};
use cosine_lobes::render_cpu::World;
use cosine_lobes::scene::{BlockerSet, Frame, Scene};
use cosine_lobes::visibility_shadowmap::{Bounds, Fineness, ShadowMap};
use cosine_lobes::{ImageFileError, Output, Picture};
use rayon::prelude::*;
use std::io::Write;

pub(crate) fn run(args: &RenderArgs) -> Result<(), Failure> {
    files::distinct(args.output.iter().chain(&args.stats), &args.view.file)?;
    let mut clocks = Clocks::default();
    let mut scene = seconds(&mut clocks.load, || input::view(&args.view))?;
    let files = Files::create(&args.output)?;
    let stats_file = args.stats.as_ref().map(Output::create).transpose()?;
    let quiet = args.view.quiet;
    let plan = Plan::new(args.visibility, &scene);
    if args.map_resolution.is_some() && !plan.wants_maps(&scene) {
        let word = name(&args.visibility);
        return Err(Failure::new(format_args!("--map-resolution: no shadow map is made with --visibility {word}")));
    }
    let blockers = seconds(&mut clocks.spheres, || input::make_blockers(&mut scene, &plan, quiet))?;
    let tables = match args.method {
        Method::Moments => None,
        Method::Paper => Some(seconds(&mut clocks.tables, || paper_tables(quiet))),
    };
    let mut figures = Figures::default();
    let planes = picture(args, &scene, &plan, &blockers, tables.as_ref(), &mut figures, &mut clocks)?;

    let layers = if args.layers { planes.layers() } else { Vec::new() };
    let image = Picture::new(scene.width as usize, scene.height as usize, planes.beauty);
    seconds(&mut clocks.write, || files.write(&image, args.view.exposure, &layers))?;

    let stats = stats::summary(args, &scene, &figures, &clocks);
    if let Some(output) = stats_file {
        let text = serde_json::to_string_pretty(&stats)?;
        let path = output.path().to_owned();
        output.finish(|file| writeln!(file, "{text}").map_err(|source| ImageFileError::Io { path, source }))?;
    }
    if args.view.json {
        say(serde_json::to_string_pretty(&stats)?);
    } else if !quiet {
        stats::print(args, &stats);
    }
    Ok(())
}

/// One picture of the scene as it is now.
fn picture(
    args: &RenderArgs,
    scene: &Scene,
    plan: &Plan,
    blockers: &BlockerSet,
    tables: Option<&Tables>,
    figures: &mut Figures,
    clocks: &mut Clocks,
) -> Result<Planes, Failure> {
    let depth = args.depth.unwrap_or_else(|| depth_for(args.tolerance));
    let frame = Frame {
        materials: &scene.materials,
        lights: &scene.lights,
        tolerance: args.tolerance,
        depth,
        threshold: args.threshold,
    };
    let world = seconds(&mut clocks.hierarchy, || World::new(scene));
    let mut bands = Bands::new(&world, args.view.samples);
    let maps = match plan.wants_maps(scene).then(|| bands.bounds()).flatten() {
        Some(receivers) => {
            let maps = seconds(&mut clocks.maps, || plan.maps(scene, receivers, args.map_resolution))?;
            if !args.view.quiet {
                advise(&maps, &receivers);
            }
            maps
        }
        None => Vec::new(),
    };
    figures.spheres = blockers.spheres.len();
    figures.triangles = world.triangle_count();
    figures.map_resolutions = maps.iter().map(ShadowMap::resolution).collect();
    figures.map_bytes = maps.iter().map(ShadowMap::bytes).sum();
    let bar = console::progress("shading", u64::from(scene.height), args.view.quiet);
    let progress = |row: u32| bar.set_position(u64::from(row));
    let shading = Shading { args, frame: &frame, bands: &mut bands, progress: &progress };
    let planes = Occlusion::new(plan, &world, blockers, maps).shade(depth, tables, shading)?;
    bar.finish_and_clear();
    clocks.gbuffer += bands.seconds;
    figures.points = planes.points;
    figures.runs.extend_from_slice(&planes.stats);
    Ok(planes)
}

/// Says which maps are too coarse for their lights.
fn advise(maps: &[ShadowMap], receivers: &Bounds) {
    for (light, map) in maps.iter().enumerate() {
        let advice = map.advice(receivers);
        let instead = match advice.fineness {
            Fineness::Fine => continue,
            Fineness::Coarse => "",
            Fineness::TooCoarse => "; `--visibility rays` needs no map",
        };
        note(format_args!("lobes: note: light {light}: {advice}{instead}"));
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
