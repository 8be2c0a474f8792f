//! The figures of `render`.

use crate::args::{RenderArgs, name};
use crate::console::{counted, say};
use crate::files::numbered;
use cosine_lobes::Window;
use cosine_lobes::render_gpu::CompiledKernel;
use cosine_lobes::renderer::{Clocks, FrameClocks, ImageStats};
use cosine_lobes::scene::{Counts, Scene, ShadeStats, StageSeconds};
use serde_json::{Value, json};
use std::path::PathBuf;

/// The results of a run.
#[derive(Default)]
pub(crate) struct Figures {
    /// Seconds of loading.
    pub(crate) load: f64,
    /// One entry a picture, and seconds of writing it.
    pub(crate) pictures: Vec<(ImageStats, f64)>,
    /// Frames that were there already.
    pub(crate) skipped: usize,
    /// Of PNG files.
    pub(crate) exposure: Option<f32>,
    /// The name of the device.
    pub(crate) device: String,
    /// Each kernel of a GPU, the slowest first.
    pub(crate) compiled: Vec<CompiledKernel>,
    /// Seconds spent once.
    pub(crate) clocks: Clocks,
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or_default()
}

fn stage_seconds(stages: &StageSeconds) -> Value {
    json!({
        "reflectance": stages.reflectance,
        "lighting": stages.lighting,
        "mask": stages.mask,
        "visibility_lobes": stages.visibility_lobes,
        "integration": stages.integration,
    })
}

fn numbers(counts: &Counts) -> Value {
    json!({
        "lobes": counts.lobes,
        "integrals": counts.integrals,
        "pruned": counts.pruned,
        "lit_points": counts.lit_points,
        "dark_points": counts.dark_points,
        "penumbra_points": counts.penumbra_points,
    })
}

pub(crate) fn summary(args: &RenderArgs, scene: &Scene, window: &Window, figures: &Figures) -> Value {
    let pictures = || figures.pictures.iter().map(|(stats, _)| stats);
    let last = pictures().next_back().cloned().unwrap_or_default();
    let accuracy = if figures.pictures.is_empty() { args.accuracy() } else { last.accuracy };
    let Window { columns, rows, .. } = window;
    let mut runs: Vec<_> = pictures().flat_map(|p| p.shading.iter().map(|stats| (*stats, p.points))).collect();
    runs.sort_by(|a, b| a.0.seconds.total_cmp(&b.0.seconds));
    let (ShadeStats { seconds, stages, counts }, points) = runs.get(runs.len() / 2).copied().unwrap_or_default();
    let frames = || pictures().map(|p| &p.clocks);
    let of = |clock: fn(&FrameClocks) -> f64| median(frames().map(clock).collect());
    // The first frame is built and not updated.
    let updates = || frames().skip(1);
    let update = |clock: fn(&FrameClocks) -> f64| median(updates().map(clock).collect());
    json!({
        "device": figures.device,
        "method": name(&args.method),
        "visibility": name(&args.visibility),
        "width": scene.width,
        "height": scene.height,
        "crop": [columns.start, rows.start, columns.end, rows.end],
        "points": points,
        "frames": figures.pictures.len(),
        "skipped_frames": figures.skipped,
        "lights": scene.lights.len(),
        "spheres": last.spheres,
        "triangles": last.triangles,
        "tolerance": decimal(accuracy.tolerance),
        "depth": accuracy.depth,
        "threads": rayon::current_num_threads(),
        "map_resolutions": last.map_resolutions,
        "map_bytes": last.map_bytes,
        "seconds": seconds,
        "points_per_second": if seconds > 0.0 { points as f64 / seconds } else { 0.0 },
        "stages": stage_seconds(&stages),
        "counts": numbers(&counts),
        "update_seconds": median(updates().map(|f| f.pose + f.spheres + f.hierarchy + f.silhouettes + f.maps).collect()),
        "update": {
            "pose": update(|f| f.pose),
            "spheres": update(|f| f.spheres),
            "hierarchy": update(|f| f.hierarchy),
            "silhouettes": update(|f| f.silhouettes),
            "maps": update(|f| f.maps),
        },
        "exposure": figures.exposure.map(decimal),
        "load_seconds": figures.load,
        "spheres_seconds": figures.clocks.spheres,
        "tables_seconds": figures.clocks.tables,
        "kernels_seconds": pictures().map(|p| p.kernels).sum::<f64>(),
        "kernels": figures.compiled.iter().map(kernel).collect::<Vec<_>>(),
        "hierarchy_seconds": frames().next().map_or(0.0, |f| f.hierarchy),
        "silhouettes_seconds": frames().next().map_or(0.0, |f| f.silhouettes),
        "map_seconds": of(|f| f.maps),
        "gbuffer_seconds": of(|f| f.gbuffer),
        "write_seconds": median(figures.pictures.iter().map(|(_, write)| *write).collect()),
    })
}

fn kernel(CompiledKernel { name, time }: &CompiledKernel) -> Value {
    json!({ "name": name, "seconds": time.as_secs_f64() })
}

/// The number as it was typed, not with the digits that f64 adds to an f32.
fn decimal(x: f32) -> f64 {
    x.to_string().parse().unwrap_or(f64::from(x))
}

pub(crate) fn print(args: &RenderArgs, stats: &Value) {
    let mut names: Vec<String> = args.output.iter().map(|p| p.display().to_string()).collect();
    if let Some((from, to)) = args.frames {
        let name = |path: &PathBuf, frame| numbered(path, frame).display().to_string();
        names = args.output.iter().map(|p| format!("{} to {}", name(p, from), name(p, to - 1))).collect();
        let (done, kept) = (&stats["frames"], &stats["skipped_frames"]);
        say(format_args!("frames {from} to {}: {done} rendered, {kept} kept", to - 1));
        if *done == 0 {
            return;
        }
    }
    let number = |key: &str| stats[key].as_f64().unwrap_or_default();
    let milliseconds = |key: &str| format!("{:.1} ms", 1e3 * number(key));
    let counts = &stats["counts"];
    let count = |key: &str| counts[key].as_u64().unwrap_or_default();
    let pairs = count("lit_points") + count("dark_points") + count("penumbra_points");
    let share = 100.0 * count("penumbra_points") as f64 / pairs.max(1) as f64;
    let exposure = match stats["exposure"].as_f64() {
        Some(stops) => format!(", exposure {stops:+.1}"),
        None => String::new(),
    };
    say(format_args!("{}: {} x {}{exposure}", names.join(", "), stats["width"], stats["height"]));
    let maps = match stats["map_resolutions"].as_array() {
        Some(list) if !list.is_empty() => {
            let mut sides: Vec<String> = list.iter().map(|n| format!("{n}²")).collect();
            sides.dedup();
            let maps = counted(list.len(), "shadow map");
            format!(", {maps} of {} in {}", sides.join(" "), milliseconds("map_seconds"))
        }
        _ => String::new(),
    };
    let (device, kernels) = match stats["device"].as_str() {
        Some("cpu") | None => (String::new(), String::new()),
        Some(name) => (format!(" on {name}"), format!(", kernels {}", milliseconds("kernels_seconds"))),
    };
    say(format_args!(
        "shading {}{device} ({} points, {} spheres, {} lights, {share:.1} % in penumbra){kernels}, G-buffer {}, spheres \
         {}{maps}, writing {}",
        milliseconds("seconds"),
        stats["points"],
        stats["spheres"],
        stats["lights"],
        milliseconds("gbuffer_seconds"),
        milliseconds("spheres_seconds"),
        milliseconds("write_seconds"),
    ));
    if number("update_seconds") > 0.0 {
        say(format_args!("each frame after the first: {} to update", milliseconds("update_seconds")));
    }
}
