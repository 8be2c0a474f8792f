use crate::args::{RenderArgs, name};
use crate::console::{self, STOP, say};
use crate::device;
use crate::failure::Failure;
use crate::files::{self, Files};
use crate::input;
use crate::moment::{self, Moment};
use crate::stamp::Stamp;
use crate::stats::{self, Figures};
use crate::teller::Teller;
use cosine_lobes::renderer::{Band, ImageStats, Layers, Renderer, Settings, seconds};
use cosine_lobes::{ExrLayer, ExrPart, ImageFileError, Output, Window, sweep_unfinished};
use std::io::Write;
use std::ops::ControlFlow;
use std::path::PathBuf;

pub(crate) fn run(args: &RenderArgs) -> Result<(), Failure> {
    console::cancellable(|| pictures(args))
}

/// Refuses outputs that are inputs, and layers without a file for them; removes what an interrupted run has left.
fn check_outputs(args: &RenderArgs) -> Result<(), Failure> {
    files::distinct(args.output.iter().chain(&args.stats), &args.view.file)?;
    args.output.iter().for_each(|path| sweep_unfinished(path));
    if args.layers && !args.output.iter().any(|path| files::holds_layers(path)) {
        return Err(Failure::new("--layers: no .exr file is written, and no other holds layers (-o picture.exr)"));
    }
    Ok(())
}

/// Refuses a resolution of shadow maps where none is made.
fn check_maps(args: &RenderArgs, renderer: &Renderer) -> Result<(), Failure> {
    if args.map_resolution.is_some() && !renderer.plan().wants_maps(renderer.scene()) {
        let word = name(&args.visibility);
        return Err(Failure::new(format_args!("--map-resolution: no shadow map is made with --visibility {word}")));
    }
    Ok(())
}

fn pictures(args: &RenderArgs) -> Result<(), Failure> {
    check_outputs(args)?;
    let mut figures = Figures::default();
    let (scene, animation) = seconds(&mut figures.load, || input::view(&args.view))?;
    let window = args.window(scene.width, scene.height)?;
    let moments = match args.frames {
        Some(ends) => moment::sequence(args.view.clock, ends, &animation)?,
        None => vec![moment::single(args.view.clock, &animation)?],
    };
    // Another picture sees the same points only where lights alone move.
    let is_still = (0..scene.objects.len()).all(|o| !animation.moves_object(o)) && !animation.moves_camera();
    let settings = Settings { keep_points: moments.len() > 1 && is_still, ..args.settings() };
    let mut renderer = device::renderer(args, scene, animation, settings)?;
    renderer.set_cancel(STOP.clone());
    check_maps(args, &renderer)?;
    let quiet = args.view.console.quiet;
    figures.device = renderer.backend().name();
    let all = moments.len();
    let paths = |moment: &Moment| -> Vec<PathBuf> {
        let of = |path: &PathBuf| moment.frame.map_or(path.clone(), |frame| files::numbered(path, frame));
        args.output.iter().map(of).collect()
    };
    let stamp =
        args.frames.is_some().then(|| Stamp::new(args, &figures.device, renderer.scene(), renderer.animation()));
    let there = |moment: &Moment| stamp.as_ref().is_some_and(|stamp| stamp.made(&paths(moment), moment.time, quiet));
    let moments: Vec<Moment> = moments.into_iter().filter(|m| !there(m)).collect();
    let open = |moment: &Moment| {
        let line = stamp.as_ref().map(|stamp| stamp.at(moment.time));
        Files::create(&paths(moment), line.as_deref())
    };
    // Outputs are opened before the long work, so that a path that cannot be written is refused at once.
    let mut opened = moments.first().map(open).transpose()?;
    let stats_file = args.stats.as_ref().map(Output::create).transpose()?;

    figures.skipped = all - moments.len();
    let mut teller = Teller::of_pictures(quiet, moments.len(), args.time_budget);
    if !moments.is_empty() {
        renderer.prepare(&mut |event| teller.hear(event))?;
    }
    // At the first moment, of the whole picture: all frames and all parts are alike.
    let is_shown = opened.as_ref().is_some_and(|files| files.has_png() || !window.is_whole());
    let exposure = match args.view.exposure {
        None if is_shown => Some(renderer.exposure()),
        exposure => exposure,
    };
    for moment in &moments {
        let files = opened.take().map_or_else(|| open(moment), Ok)?;
        renderer.seek(moment.time);
        figures.pictures.push(picture(args, &mut renderer, &window, files, exposure, &mut teller)?);
        teller.next_picture();
    }
    teller.end();

    figures.exposure = exposure;
    figures.compiled = device::kernels(renderer.backend());
    figures.clocks = renderer.clocks();
    report(args, &stats::summary(args, renderer.scene(), &window, &figures), stats_file)
}

/// Renders one picture into its files; its figures and the seconds of writing.
fn picture(
    args: &RenderArgs,
    renderer: &mut Renderer,
    window: &Window,
    files: Files,
    exposure: Option<f32>,
    teller: &mut Teller,
) -> Result<(ImageStats, f64), Failure> {
    let names = channels(args.layers.then_some(renderer.scene().lights.len()));
    // A part of a picture carries the exposure for `merge`.
    let kept = exposure.filter(|_| !window.is_whole());
    let mut stream = files.stream(window.clone(), &args.png.display(exposure.unwrap_or_default()), kept, &names)?;
    let stats = renderer.render_bands(window, &mut |event| teller.hear(event), &mut |band| {
        // The stream reports the reason when it is finished.
        match stream.send(part(band)) {
            true => ControlFlow::Continue(()),
            false => ControlFlow::Break(()),
        }
    })?;
    let mut write = 0.0;
    seconds(&mut write, || stream.finish())?;
    Ok((stats, write))
}

/// Writes and prints the figures of a run.
fn report(args: &RenderArgs, stats: &serde_json::Value, file: Option<Output>) -> Result<(), Failure> {
    if let Some(output) = file {
        let text = serde_json::to_string_pretty(stats)?;
        let path = output.path().to_owned();
        output.finish(|file| writeln!(file, "{text}").map_err(|source| ImageFileError::Io { path, source }))?;
    }
    if args.view.console.json {
        say(serde_json::to_string_pretty(stats)?);
    } else if !args.view.console.quiet {
        stats::print(args, stats);
    }
    Ok(())
}

/// The names of a picture's channels, with the channels of `--layers` for a number of lights.
fn channels(lights: Option<usize>) -> Vec<String> {
    let mut all = vec![ExrLayer::color("beauty", &[])];
    if let Some(count) = lights {
        let layers = Layers { lights: vec![Vec::new(); count], ..Layers::default() };
        all.extend(exr_layers(&layers));
    }
    ExrPart::of_layers(Window::default(), &all).channels.into_iter().map(|(name, _)| name).collect()
}

/// A band as files take it.
fn part(band: &Band) -> ExrPart {
    let mut all = vec![ExrLayer::color("beauty", &band.radiance)];
    if !band.layers.depths.is_empty() {
        all.extend(exr_layers(&band.layers));
    }
    ExrPart::of_layers(band.window.clone(), &all)
}

/// The layers of `--layers`.
fn exr_layers(layers: &Layers) -> Vec<ExrLayer> {
    let mut all = vec![ExrLayer::color("unshadowed", &layers.unshadowed)];
    all.extend(layers.lights.iter().enumerate().map(|(i, l)| ExrLayer::color(&format!("light{i}"), l)));
    all.push(ExrLayer::vector("normal", &layers.normals));
    all.push(ExrLayer::scalar("depth", 'Z', layers.depths.clone()));
    all.push(ExrLayer::scalar("lobes", 'N', layers.lobes.clone()));
    all.push(ExrLayer::scalar("products", 'N', layers.products.clone()));
    all
}
