//! Error against time of all settings on one scene.

mod plot;
mod record;
mod row;
mod setting;
mod sheet;
mod stage;
mod table;
mod truth;

use self::record::Record;
use self::row::Row;
use self::setting::Setting;
use self::stage::Stage;
use self::truth::Truth;
use crate::args::{Method, TradeArgs, TradeDevice, TradeGeometry, Visibility, name};
use crate::console::{self, STOP, say};
use crate::device;
use crate::failure::Failure;
use crate::fingerprint::Fingerprint;
use crate::input;
use crate::moment;
use crate::teller::Teller;
use cosine_lobes::render_cpu::{GBuffer, World};
use cosine_lobes::renderer::{Backend, Plan, paper_tables, seconds};
use cosine_lobes::scene::{Animation, BlockerSet, Proxy, Scene, Shape};

/// More points than this are refused: a reference needs 192 bytes each, and a sweep is done in small.
const MAX_POINTS: u64 = 1 << 22;

pub(crate) fn run(args: &TradeArgs) -> Result<(), Failure> {
    let view = &args.view;
    let (mut scene, animation) = input::view(view)?;
    let moment = moment::single(view.clock, &animation)?;
    let samples = view.samples.unwrap_or(1);
    input::check_size(&scene, samples, MAX_POINTS, ["points", "sweep", " (--size)"])?;
    let strategies = strategies(args, &scene)?;
    let gpu = if args.device.contains(&TradeDevice::Gpu) { device::gpu(view.console.quiet)? } else { Backend::Cpu };
    let failed = |e: std::io::Error| Failure::new(format_args!("{}: {e}", args.output.display()));
    std::fs::create_dir_all(&args.output).map_err(failed)?;

    // The objects that block by spheres depend on the strategy: spheres always do, meshes only by some.
    let mut sets = Vec::new();
    let all = strategies.iter().copied().filter(|v| *v != Visibility::Spheres);
    for visibility in all {
        sets.push((visibility, posed(&mut scene, &animation, moment.time, visibility, view.console.quiet)?));
    }
    let by_spheres = args.geometry == TradeGeometry::Spheres || strategies.contains(&Visibility::Spheres);
    let visibility = if by_spheres { Visibility::Spheres } else { Visibility::None };
    let blockers = posed(&mut scene, &animation, moment.time, visibility, view.console.quiet)?;
    sets.push((visibility, blockers.clone()));
    animation.seek(moment.time, &mut scene);
    let stamp = stamp(args, &scene, &blockers);
    let world = World::new(&scene);
    let mut gbuffer_times = [0.0; 3];
    let mut gbuffer = GBuffer::default();
    for time in &mut gbuffer_times {
        gbuffer = seconds(time, || GBuffer::new(&world, scene.width, scene.height, samples));
    }
    gbuffer_times.sort_by(f64::total_cmp);

    let truth = Truth::find(args, &world, &gbuffer, &blockers)?;
    let settings = setting::all(args, &strategies, &gpu.name());
    let mut record = Record::open(&args.output, &stamp, view.console.quiet);
    let mut stage = Stage::new(args, &world, (&gbuffer, gbuffer_times[1]), &blockers, &sets, gpu);
    measure(args, &mut stage, &settings, &truth, &mut record, &stamp)?;
    // Rows of other settings than this run's are kept, and shown.
    let title = scene_name(args);
    let about = stage.about(&title, &truth);
    record.write_tables(&about, stage.points())?;
    plot::write(&args.output, &title, record.rows())?;
    sheet::write(args, &mut stage, &settings, record.rows(), &truth)?;
    if view.console.json {
        say(serde_json::to_string_pretty(record.rows())?);
    } else if !view.console.quiet {
        for row in record.rows().iter().filter(|r| r.front) {
            say(row.sentence());
        }
        say(format_args!("{}: {} rows", args.output.display(), record.rows().len()));
    }
    Ok(())
}
/// Measures the settings that have no row yet.
fn measure(
    args: &TradeArgs,
    stage: &mut Stage<'_>,
    settings: &[Setting],
    truth: &Truth,
    record: &mut Record,
    stamp: &str,
) -> Result<(), Failure> {
    let is_quiet = args.view.console.quiet;
    let left = |record: &Record| settings.iter().filter(|s| record.find(s).is_none()).count();
    if settings.iter().any(|s| s.method == "paper") && (left(record) > 0 || !args.output.join("sheet.png").exists()) {
        let mut teller = Teller::new(is_quiet);
        stage.tables = Some(paper_tables(input::cache_folder().as_deref(), &mut |event| teller.hear(event))?);
        teller.end();
    }
    let title = scene_name(args);
    console::stoppable(|| -> Result<(), Failure> {
        let bar = console::progress("measuring", left(record) as u64, is_quiet);
        for setting in settings {
            if record.find(setting).is_some() {
                continue;
            }
            let shot = stage.shoot(setting)?;
            // A measurement that was cut short is no row.
            if STOP.is_cancelled() {
                break;
            }
            record.add(Row::new(&title, setting, &shot, stage, truth, stamp)?)?;
            bar.inc(1);
        }
        bar.finish_and_clear();
        Ok(())
    })?;
    let missing = left(record);
    if missing > 0 {
        let (done, all) = (settings.len() - missing, settings.len());
        return Err(Failure::interrupted(format_args!(
            "{done} of {all} rows are kept in {}; the same command goes on from there",
            record.path().display()
        )));
    }
    Ok(())
}

/// The spheres of a strategy, fitted at the scene's first moment and posed at another; the scene is left at its first.
fn posed(
    scene: &mut Scene,
    animation: &Animation,
    time: f32,
    visibility: Visibility,
    quiet: bool,
) -> Result<BlockerSet, Failure> {
    let plan = Plan::new(visibility.strategy(), scene);
    let spheres = input::make_spheres(scene, animation, &plan, quiet)?;
    animation.seek(time, scene);
    let mut set = BlockerSet::default();
    spheres.pose(scene, Some((animation, time)), &mut set)?;
    animation.seek(0.0, scene);
    Ok(set)
}

/// The scene's name in the rows.
fn scene_name(args: &TradeArgs) -> String {
    let stem = args.view.file.as_ref().and_then(|f| f.file_stem());
    stem.map_or_else(|| "builtin".to_owned(), |s| s.to_string_lossy().into_owned())
}

/// The requested strategies, or all that block with the geometry of the reference.
fn strategies(args: &TradeArgs, scene: &Scene) -> Result<Vec<Visibility>, Failure> {
    let blocks = |s: &&cosine_lobes::scene::Object| s.proxy != Proxy::None;
    let is_of_spheres = scene.objects.iter().filter(blocks).all(|o| matches!(o.shape, Shape::Spheres(_)));
    let mut good = vec![Visibility::Spheres];
    if args.geometry == TradeGeometry::Mesh && Plan::new(Visibility::ShadowMap.strategy(), scene).wants_maps(scene) {
        // The mixture that `render` uses, then each strategy for all objects.
        good.insert(0, Visibility::Scene);
        good.extend([Visibility::ShadowMap, Visibility::Silhouettes]);
    }
    if args.geometry == TradeGeometry::Mesh || is_of_spheres {
        good.push(Visibility::Rays);
    }
    if args.visibility.is_empty() {
        return Ok(good);
    }
    match args.visibility.iter().find(|v| !good.contains(v)) {
        Some(other) => {
            let known: Vec<String> = good.iter().map(name).collect();
            let (other, known) = (name(other), known.join(", "));
            let geometry = name(&args.geometry);
            Err(Failure::new(format_args!(
                "--visibility {other}: with --geometry {geometry} this scene can be compared by {known}"
            )))
        }
        None => Ok(args.visibility.clone()),
    }
}

/// Rows share a table if this agrees: scene, options and the program itself.
fn stamp(args: &TradeArgs, scene: &Scene, blockers: &BlockerSet) -> String {
    let options =
        (args.view.samples.unwrap_or(1), name(&args.geometry), args.reference_spp, args.repeat, args.map_resolution);
    let program = std::env::current_exe().and_then(std::fs::metadata).map(|m| (m.len(), m.modified().ok())).ok();
    let threads = rayon::current_num_threads();
    let all = Fingerprint::new().debug(&options).debug(&program).debug(&threads).debug(scene).debug(blockers);
    format!("{} {:016x}", env!("CARGO_PKG_VERSION"), all.value())
}

/// The method's word.
fn word(method: Method) -> String {
    name(&method)
}
