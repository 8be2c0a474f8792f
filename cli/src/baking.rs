//! `lobes bake`.

use crate::args::{BakeArgs, ClockArgs, ConsoleArgs};
use crate::console::{self, STOP, counted, note, plain, progress, say};
use crate::failure::Failure;
use crate::files;
use crate::fingerprint::Fingerprint;
use crate::journal::Journal;
use crate::moment::{self, Moment};
use bake::{Baked, Baker, Stage, beside, glb_binary, glb_stamp, stamped_glb};
use cosine_lobes::{Output, sweep_unfinished};
use serde_json::{Value, json};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

pub(crate) fn run(args: &BakeArgs) -> Result<(), Failure> {
    console::cancellable(|| bake_file(args))
}

fn bake_file(args: &BakeArgs) -> Result<(), Failure> {
    let frames: Vec<Option<u32>> = args.frames.map_or(vec![None], |(start, end)| (start..end).map(Some).collect());
    let path = |frame: Option<u32>| frame.map_or(args.output.clone(), |frame| files::numbered(&args.output, frame));
    files::distinct(&frames.iter().map(|frame| path(*frame)).collect::<Vec<_>>(), [&args.file])?;
    sweep_unfinished(&args.output);
    console::set_threads(args.console.threads)?;
    let options = args.model.options(args.clip.as_deref())?;
    // Opened before the long work, so that a path that cannot be written is refused at once.
    let mut opened = Some(files::create_glb(&path(frames[0]))?);
    let start = Instant::now();
    let mut baker = Baker::open(&args.file, &options, args.settings(), args.render_settings())?;
    if !args.console.quiet {
        baker.notes().iter().for_each(|line| note(format_args!("lobes: warning: {}", plain(line))));
    }
    baker.set_cancel(STOP.clone());
    let load = start.elapsed().as_secs_f64();
    let animation = baker.renderer().animation();
    let moments = match args.frames {
        Some(ends) => moment::sequence(args.clock, ends, animation)?,
        None => vec![moment::single(args.clock, animation)?],
    };
    let stamp = BakeStamp::new(args, &baker);
    let is_sequence = args.frames.is_some();
    let mut done = Done { args, load, skipped: 0, frames: Vec::new() };
    for moment in moments {
        let output = path(moment.frame);
        if is_sequence && stamp.made(&output, moment.time) {
            done.skipped += 1;
            opened = None;
            continue;
        }
        let file = opened.take().map_or_else(|| files::create_glb(&output), Ok)?;
        baker.seek(moment.time)?;
        let mut journal = Journal::open(&output, stamp.origin(moment.time), args.console.quiet);
        let (mut baked, seconds) = bake_moment(args, &mut baker, &mut journal)?;
        let maps = baked.map_files()?;
        if is_sequence {
            let line = stamp.line(moment.time, &baked.glb, &maps);
            baked.glb = stamped_glb(&baked.glb, &line).unwrap_or(baked.glb);
        }
        let maps = write(args, file, &output, (&baked, &maps))?;
        journal.end();
        done.frame(moment, &output, (&baked, &maps), seconds);
    }
    done.end();
    Ok(())
}

/// Bakes the light of a moment; returns it, and the seconds that this took.
fn bake_moment(args: &BakeArgs, baker: &mut Baker, journal: &mut Journal) -> Result<(Baked, f64), Failure> {
    let start = Instant::now();
    let bars = [(Stage::Coordinates, "coordinates"), (Stage::Light, "light")];
    let bars = bars.map(|(stage, name)| (stage, progress(name, 1000, args.console.quiet)));
    let mut hear = |stage, done| {
        let bar = bars.iter().find(|(of, _)| *of == stage);
        bar.inspect(|(_, bar)| bar.set_position((1000.0 * done) as u64));
        ControlFlow::Continue(())
    };
    let baked = baker.bake_with(&mut hear, journal);
    bars.iter().for_each(|(_, bar)| bar.finish_and_clear());
    let baked = baked?;
    if baked.subdivision.is_some_and(|made| made.is_cut) && !args.console.quiet {
        note(format_args!(
            "lobes: warning: subdivision ended at {} vertices before light was near enough everywhere (--vertices, --density)",
            baked.vertices
        ));
    }
    Ok((baked, start.elapsed().as_secs_f64()))
}

/// Writes the file and its maps beside it. Returns the maps' paths.
fn write(
    args: &BakeArgs,
    file: Output,
    output: &PathBuf,
    (baked, maps): (&Baked, &[(String, Vec<u8>)]),
) -> Result<Vec<PathBuf>, Failure> {
    let paths: Vec<PathBuf> = maps.iter().map(|(ending, _)| beside(output, ending)).collect();
    files::distinct(&paths, [&args.file, output])?;
    Ok(baked.write(file, output, maps)?)
}

/// The origin of baked light: the version, the options, the file, its scene and animation. Frames carry it as a line, with their content.
struct BakeStamp {
    job: u64,
}

impl BakeStamp {
    fn new(args: &BakeArgs, baker: &Baker) -> Self {
        // Options without effect on the light, or covered by scene, animation and moment.
        let options = BakeArgs {
            file: PathBuf::new(),
            output: PathBuf::new(),
            frames: None,
            clock: ClockArgs::default(),
            clip: None,
            console: ConsoleArgs::default(),
            ..args.clone()
        };
        let (renderer, file) = (baker.renderer(), baker.document());
        let all = Fingerprint::new().debug(&options).debug(renderer.scene()).debug(renderer.animation());
        let all = all.bytes(file.json.as_bytes());
        let blobs = file.buffers.iter().chain(file.images.iter().flatten());
        Self { job: blobs.fold(all, |all, blob| all.bytes(blob)).value() }
    }

    /// The origin of the light of a moment in seconds, without its content.
    fn origin(&self, time: f32) -> u64 {
        Fingerprint::new().debug(&(env!("CARGO_PKG_VERSION"), self.job, time)).value()
    }

    fn content<'a>(binary: &[u8], maps: impl Iterator<Item = &'a [u8]>) -> u64 {
        maps.fold(Fingerprint::new().bytes(binary), Fingerprint::bytes).value()
    }

    /// The line for a file and its maps.
    fn line(&self, time: f32, glb: &[u8], maps: &[(String, Vec<u8>)]) -> String {
        let content = Self::content(glb_binary(glb), maps.iter().map(|(_, bytes)| &bytes[..]));
        let endings: Vec<&str> = maps.iter().map(|(ending, _)| ending.as_str()).collect();
        let origin = self.origin(time);
        format!("{} {origin:016x} {content:016x} {}", env!("CARGO_PKG_VERSION"), endings.join(" "))
            .trim_end()
            .to_owned()
    }

    /// Whether a file and its maps are complete and show the light of that moment.
    fn made(&self, output: &Path, time: f32) -> bool {
        let Ok(glb) = std::fs::read(output) else { return false };
        let Some((line, binary)) = glb_stamp(&glb) else { return false };
        let mut words = line.split(' ').skip(1);
        let is = |word: Option<&str>, value: u64| word.is_some_and(|word| word == format!("{value:016x}"));
        if !is(words.next(), self.origin(time)) {
            return false;
        }
        let content = words.next();
        let Some(maps) = words.map(|ending| std::fs::read(beside(output, ending)).ok()).collect::<Option<Vec<_>>>()
        else {
            return false;
        };
        is(content, Self::content(binary, maps.iter().map(Vec::as_slice)))
    }
}

/// The results, as they are reported.
struct Done<'a> {
    args: &'a BakeArgs,
    load: f64,
    skipped: usize,
    /// Of frames.
    frames: Vec<Value>,
}

impl Done<'_> {
    fn frame(&mut self, moment: Moment, output: &Path, (baked, maps): (&Baked, &[PathBuf]), seconds: f64) {
        let Self { args, load, .. } = *self;
        match (args.console.json, moment.frame) {
            (true, None) => say(figures(baked, maps, Some(load), seconds)),
            (true, Some(frame)) => {
                let mut all = figures(baked, maps, None, seconds);
                all["frame"] = frame.into();
                self.frames.push(all);
            }
            (false, None) if !args.console.quiet => summary(args, output, (baked, maps), [load, seconds]),
            (false, Some(_)) if !args.console.quiet => say(format_args!(
                "{}: {}, {seconds:.2} s",
                output.display(),
                match baked.vertices {
                    0 => counted(baked.texels as usize, "texel"),
                    vertices => format!("{vertices} vertices"),
                }
            )),
            _ => {}
        }
    }

    fn end(self) {
        let Some((start, end)) = self.args.frames else { return };
        let made = (end - start) as usize - self.skipped;
        if self.args.console.json {
            say(json!({"frames": self.frames, "skipped_frames": self.skipped, "load_seconds": self.load}));
        } else if !self.args.console.quiet {
            say(format_args!("{} baked, {} there already", counted(made, "frame"), self.skipped));
        }
    }
}

/// The report of a bake with its times.
fn figures(baked: &Baked, maps: &[PathBuf], load: Option<f64>, seconds: f64) -> Value {
    let mut all = baked.report(maps);
    all["bake_seconds"] = seconds.into();
    if let Some(load) = load {
        all["load_seconds"] = load.into();
    }
    all
}

fn summary(args: &BakeArgs, output: &Path, (baked, maps): (&Baked, &[PathBuf]), [load, seconds]: [f64; 2]) {
    let output = output.display();
    if baked.vertices > 0 {
        say(format_args!("vertices   {} of {}", baked.vertices, counted(baked.surfaces, "surface")));
    } else {
        let pages = baked.pages.iter().map(|[width, height]| format!("{width} x {height}")).collect::<Vec<_>>();
        let surfaces = counted(baked.surfaces, "surface");
        say(format_args!("texels     {} of {surfaces}, on pages of {}", baked.texels, pages.join(", ")));
    }
    if let (Some(made), Some(error)) = (baked.subdivision, args.subdivide) {
        let (mean, beyond) = (100.0 * made.mean_error, 100.0 * made.beyond);
        let error = 100.0 * error;
        say(format_args!(
            "triangles  {}: light between vertices is {mean:.2} % of the mean light off, and more than {error} % on {beyond:.1} % of the surface",
            made.triangles
        ));
    }
    say(format_args!("time       {seconds:.2} s, and {load:.2} s to load"));
    for map in baked.maps.iter().filter(|map| !map.is_single) {
        let cut = match map.cut_texels() {
            0 => String::new(),
            count => format!(", which cuts {} (not in the EXR)", counted(count, "texel")),
        };
        say(format_args!("{:<10} white in the PNG is {} W/m²{cut}", map.name, map.white));
    }
    if baked.scale > 1.0 {
        say(format_args!("colours    {:.4} times darker than the light, so that none is above 1", baked.scale));
    }
    say(format_args!(
        "written    {output}{}",
        if maps.is_empty() { String::new() } else { format!(", and {}", counted(maps.len(), "map")) }
    ));
}
