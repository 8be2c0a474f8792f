use crate::args::{Method, RenderArgs, name};
use crate::budget::Budget;
use crate::console::{self, note, say};
use crate::device::Backend;
use crate::failure::Failure;
use crate::files::{self, Files};
use crate::input;
use crate::moment::{self, Moment};
use crate::picture::{Bands, Planes, Shading, seconds};
use crate::stamp::Stamp;
use crate::stats::{self, Clocks, Figures, FrameClocks};
use crate::strategy::{KeptSpheres, Occlusion, Plan};
use cosine_lobes::lobe_core::paper::{ProductTable, Resolution, Tables};
use cosine_lobes::render_cpu::{BlockersError, SceneSilhouettes, World};
use cosine_lobes::scene::{BlockerSet, Frame};
use cosine_lobes::visibility_shadowmap::{Bounds, Fineness, ShadowMap};
use cosine_lobes::visibility_spheres::SphereBlockers;
use cosine_lobes::{ImageFileError, Output, Picture, Window};
use rayon::prelude::*;
use std::io::Write;
use std::path::PathBuf;

pub(crate) fn run(args: &RenderArgs) -> Result<(), Failure> {
    files::distinct(args.output.iter().chain(&args.stats), &args.view.file)?;
    if args.layers && !args.output.iter().any(|path| files::holds_layers(path)) {
        return Err(Failure::new("--layers: no .exr file is written, and no other holds layers (-o picture.exr)"));
    }
    let mut clocks = Clocks::default();
    let (mut scene, animation) = seconds(&mut clocks.load, || input::view(&args.view))?;
    let window = args.window(scene.width, scene.height)?;
    let moments = match args.frames {
        Some(ends) => moment::sequence(&args.view, ends, &animation)?,
        None => vec![moment::single(&args.view, &animation)?],
    };
    let plan = Plan::new(args.visibility, &scene);
    if args.map_resolution.is_some() && !plan.wants_maps(&scene) {
        let word = name(&args.visibility);
        return Err(Failure::new(format_args!("--map-resolution: no shadow map is made with --visibility {word}")));
    }
    let mut backend = Backend::new(args)?;
    let all = moments.len();
    let paths = |moment: &Moment| -> Vec<PathBuf> {
        let of = |path: &PathBuf| moment.frame.map_or(path.clone(), |frame| files::numbered(path, frame));
        args.output.iter().map(of).collect()
    };
    let stamp = args.frames.is_some().then(|| Stamp::new(args, &backend.name(), &scene, &animation));
    let there =
        |moment: &Moment| stamp.as_ref().is_some_and(|stamp| stamp.made(&paths(moment), moment.time, args.view.quiet));
    let moments: Vec<Moment> = moments.into_iter().filter(|m| !there(m)).collect();
    let open = |moment: &Moment| {
        let line = stamp.as_ref().map(|stamp| stamp.at(moment.time));
        Files::create(&paths(moment), line.as_deref())
    };
    // Before the long work: what cannot be written is refused at once.
    let mut opened = moments.first().map(open).transpose()?;
    let stats_file = args.stats.as_ref().map(Output::create).transpose()?;
    let quiet = args.view.quiet;

    let mut figures = Figures { skipped: all - moments.len(), device: backend.name(), ..Figures::default() };
    if !moments.is_empty() {
        let spheres = seconds(&mut clocks.spheres, || input::make_spheres(&mut scene, &animation, &plan, quiet))?;
        let tables = match args.method {
            Method::Moments => None,
            Method::Paper => Some(seconds(&mut clocks.tables, || paper_tables(quiet))),
        };
        let bar = console::progress("shading", moments.len() as u64 * window.rows.len() as u64, quiet);
        let (mut set, mut blockers) = (BlockerSet::default(), KeptSpheres::default());
        let mut hierarchy = None;
        let (mut silhouettes, none) = (None::<SceneSilhouettes>, SceneSilhouettes::default());
        for (index, moment) in moments.iter().enumerate() {
            let files = opened.take().map_or_else(|| open(moment), Ok)?;
            let mut clocks = FrameClocks::default();
            seconds(&mut clocks.pose, || animation.seek(moment.time, &mut scene));
            let at = Some((&animation, moment.time));
            seconds(&mut clocks.spheres, || {
                spheres.pose(&scene, at, &mut set)?;
                blockers.update(&set);
                Ok::<(), BlockersError>(())
            })?;
            let world = seconds(&mut clocks.hierarchy, || match hierarchy.take() {
                Some(hierarchy) => World::refit(&scene, hierarchy),
                None => World::new(&scene),
            });
            seconds(&mut clocks.silhouettes, || match &mut silhouettes {
                Some(kept) => kept.update(&scene),
                None => silhouettes = Some(SceneSilhouettes::new(&scene, |o| plan.by_silhouettes(&scene, o))),
            });
            let done = index as u64 * window.rows.len() as u64;
            let progress = |row: u32| bar.set_position(done + u64::from(row));
            let (spheres, tables) = (blockers.get(), tables.as_ref());
            let silhouettes = silhouettes.as_ref().unwrap_or(&none);
            let job = Job { args, window: &window, plan: &plan, spheres, silhouettes, tables, progress: &progress };
            let planes = job.picture(&world, &mut backend, &mut figures, &mut clocks)?;
            hierarchy = Some(world.into_hierarchy());
            let layers = if args.layers { planes.layers() } else { Vec::new() };
            let [width, height] = window.size();
            let image = Picture::new(width, height, planes.beauty);
            let part = window.clone();
            seconds(&mut clocks.write, || files.write_window(part, &image, args.view.exposure, &layers))?;
            figures.frames.push(clocks);
        }
        bar.finish_and_clear();
    }

    figures.compiled = backend.kernels();
    let stats = stats::summary(args, &scene, &window, &figures, &clocks);
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

/// What is the same for the pictures of all frames, and the spheres of this one.
struct Job<'a> {
    args: &'a RenderArgs,
    window: &'a Window,
    plan: &'a Plan,
    spheres: Option<&'a SphereBlockers>,
    silhouettes: &'a SceneSilhouettes,
    tables: Option<&'a Tables>,
    progress: &'a dyn Fn(u32),
}

impl Job<'_> {
    /// One picture of a world.
    fn picture(
        &self,
        world: &World<'_>,
        backend: &mut Backend,
        figures: &mut Figures,
        clocks: &mut FrameClocks,
    ) -> Result<Planes, Failure> {
        let Self { args, window, plan, spheres, silhouettes, tables, progress } = *self;
        let scene = world.scene();
        let mut bands = Bands::new(world, args.view.samples, window.clone());
        let mut maps = Vec::new();
        if let Some(receivers) = plan.wants_maps(scene).then(|| bands.bounds()).flatten() {
            let (resolution, room) = (args.map_resolution, backend.room_for_maps());
            let coarser;
            (maps, coarser) = seconds(&mut clocks.maps, || plan.maps(scene, receivers, resolution, room))?;
            if figures.frames.is_empty() && !args.view.quiet {
                if let Some(coarser) = coarser {
                    note(format_args!("lobes: note: {coarser}"));
                }
                advise(&maps, &receivers);
            }
        }
        let (tolerance, depth) = args.setting();
        let (materials, lights) = (&scene.materials, &scene.lights);
        let mut frame = Frame { materials, lights, tolerance, depth, threshold: args.threshold };
        match (figures.setting, args.time_budget) {
            (Some(setting), _) => (frame.tolerance, frame.depth) = setting,
            (None, Some(budget)) => {
                let (maps, fixed, quiet) = (&maps, clocks.maps, args.view.quiet);
                let choice = Budget { world, plan, spheres, maps, silhouettes, tables, fixed, quiet };
                (frame.tolerance, frame.depth) = choice.choose(backend, budget, &bands, &frame)?;
            }
            (None, None) => {}
        }
        figures.setting = Some((frame.tolerance, frame.depth));
        figures.spheres = spheres.map_or(0, |s| s.spheres().len());
        figures.triangles = world.triangle_count();
        figures.map_resolutions = maps.iter().map(ShadowMap::resolution).collect();
        figures.map_bytes = maps.iter().map(ShadowMap::bytes).sum();
        let planes = Occlusion::new(plan, world, spheres, maps, silhouettes, frame.tolerance).shade(
            backend,
            frame.depth,
            tables,
            Shading { args, frame: &frame, bands: &mut bands, progress },
        )?;
        clocks.gbuffer = bands.seconds;
        figures.kernels += planes.kernels;
        figures.runs.extend(planes.stats.iter().map(|stats| (*stats, planes.points)));
        Ok(planes)
    }
}

/// Says which maps are too coarse for their lights.
fn advise(maps: &[ShadowMap], receivers: &Bounds) {
    for (light, map) in maps.iter().enumerate() {
        let advice = map.advice(receivers);
        let instead = match advice.fineness {
            Fineness::Fine => continue,
            Fineness::Coarse => "",
            Fineness::TooCoarse => "; `--visibility silhouettes` needs no map",
        };
        note(format_args!("lobes: note: light {light}: {advice}{instead}"));
    }
}

/// The paper's tables, row by row on all cores.
pub(crate) fn paper_tables(quiet: bool) -> Tables {
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
