//! `lobes bake`.

use crate::args::BakeArgs;
use crate::console::{self, STOP, counted, note, progress, say};
use crate::failure::Failure;
use crate::files;
use bake::{Baked, Baker, Map, Stage};
use cosine_lobes::{ImageFileError, Output, sweep_unfinished};
use serde_json::json;
use std::io::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

pub(crate) fn run(args: &BakeArgs) -> Result<(), Failure> {
    console::cancellable(|| bake_file(args))
}

fn bake_file(args: &BakeArgs) -> Result<(), Failure> {
    files::distinct([&args.output], [&args.file])?;
    sweep_unfinished(&args.output);
    console::set_threads(args.threads)?;
    // Opened before the long work, so that a path that cannot be written is refused at once.
    let output = files::create_glb(&args.output)?;
    let start = Instant::now();
    let options = args.model.options(args.clip.as_deref());
    let mut baker = Baker::open(&args.file, &options, args.settings(), args.render_settings())?;
    if !args.quiet {
        baker.notes().iter().for_each(|line| note(format_args!("lobes: warning: {line}")));
    }
    baker.set_cancel(STOP.clone());
    let load = start.elapsed().as_secs_f64();
    let bars = [(Stage::Coordinates, "coordinates"), (Stage::Light, "light")];
    let bars = bars.map(|(stage, name)| (stage, progress(name, 1000, args.quiet)));
    let baked = baker.bake(&mut |stage, done| {
        let bar = bars.iter().find(|(of, _)| *of == stage);
        bar.inspect(|(_, bar)| bar.set_position((1000.0 * done) as u64));
        ControlFlow::Continue(())
    });
    bars.iter().for_each(|(_, bar)| bar.finish_and_clear());
    let baked = baked?;
    let seconds = start.elapsed().as_secs_f64() - load;
    if baked.subdivision.is_some_and(|made| made.is_cut) && !args.quiet {
        note(format_args!(
            "lobes: warning: subdivision ended at {} vertices before light was near enough everywhere (--vertices, --density)",
            baked.vertices
        ));
    }
    let maps = write_maps(args, &baked)?;
    write(output, &baked.glb)?;
    summary(args, &baked, &maps, [load, seconds]);
    Ok(())
}

fn write(output: Output, bytes: &[u8]) -> Result<(), Failure> {
    let path = output.path().to_owned();
    Ok(output.finish(|file| file.write_all(bytes).map_err(|source| ImageFileError::Io { path, source }))?)
}

/// The name of a file beside the output: `baked.glb` gives `baked.lightmap0.exr`.
fn beside(output: &Path, map: &Map, ending: &str) -> PathBuf {
    let mut name = output.file_stem().unwrap_or_default().to_owned();
    name.push(format!(".{}.{ending}", map.name));
    output.with_file_name(name)
}

/// Writes each map as OpenEXR, those of all lights as PNG as well. Returns their paths.
fn write_maps(args: &BakeArgs, baked: &Baked) -> Result<Vec<PathBuf>, Failure> {
    let mut all = Vec::new();
    for map in &baked.maps {
        all.push((beside(&args.output, map, "exr"), map.exr()?));
        if !map.is_single {
            all.push((beside(&args.output, map, "png"), map.linear_png()?));
        }
    }
    files::distinct(all.iter().map(|(path, _)| path), [&args.file, &args.output])?;
    // All of them can be written, or none is.
    let opened = all.iter().map(|(path, _)| Output::create(path)).collect::<Result<Vec<_>, _>>()?;
    for (output, (_, bytes)) in opened.into_iter().zip(&all) {
        write(output, bytes)?;
    }
    Ok(all.into_iter().map(|(path, _)| path).collect())
}

fn summary(args: &BakeArgs, baked: &Baked, maps: &[PathBuf], [load, seconds]: [f64; 2]) {
    if args.json {
        let scale = |map: &Map| json!({"name": map.name, "white": map.white, "cut_texels": map.cut_texels()});
        say(json!({
            "surfaces": baked.surfaces,
            "pages": baked.pages,
            "texels": baked.texels,
            "vertices": baked.vertices,
            "maps": baked.maps.iter().map(scale).collect::<Vec<_>>(),
            "files": maps,
            "bytes": baked.glb.len(),
            "scale": baked.scale,
            "subdivision": baked.subdivision.map(|made| json!({
                "triangles": made.triangles,
                "mean_error": made.mean_error,
                "beyond": made.beyond,
                "is_cut": made.is_cut,
            })),
            "load_seconds": load,
            "bake_seconds": seconds,
        }));
        return;
    }
    if args.quiet {
        return;
    }
    let output = args.output.display();
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
