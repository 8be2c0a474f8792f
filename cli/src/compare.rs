use crate::args::CompareArgs;
use crate::console::say;
use crate::failure::Failure;
use crate::files;
use cosine_lobes::{
    Comparison, FlipMap, Picture, RegionError, ShadowErrors, luminance, read_exr, read_exr_layer, signed_difference,
    write_png,
};
use serde_json::{Value, json};
use std::path::Path;

/// Reads a picture and refuses one with infinite or undefined values.
fn read(path: &Path) -> Result<Picture, Failure> {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
        let why = "pictures are compared as linear radiance, which a PNG does not hold: OpenEXR is needed (render -o picture.exr)";
        return Err(Failure::new(format_args!("{}: {why}", path.display())));
    }
    finite(path, read_exr(path)?)
}

fn finite(path: &Path, picture: Picture) -> Result<Picture, Failure> {
    match picture.non_finite() {
        0 => Ok(picture),
        n => Err(Failure::new(format_args!("{}: {n} pixels are not finite", path.display()))),
    }
}

pub(crate) fn run(args: &CompareArgs) -> Result<(), Failure> {
    files::distinct(
        args.diff.iter().chain(&args.heatmap),
        [&args.test, &args.reference].into_iter().chain(&args.unshadowed),
    )?;
    let (test, reference) = (read(&args.test)?, read(&args.reference)?);
    let comparison = Comparison::of(&test, &reference)?;
    let shadows = match &args.unshadowed {
        None => None,
        Some(path) => {
            let layer = match read_exr_layer(path, "unshadowed")? {
                Some(picture) => finite(path, picture)?,
                None => read(path)?,
            };
            Some(ShadowErrors::of(&test, &reference, &layer)?)
        }
    };
    // Opened before FLIP, which takes a while.
    let diff = args.diff.as_ref().map(files::create_png).transpose()?;
    let heatmap = args.heatmap.as_ref().map(files::create_png).transpose()?;
    let flip = FlipMap::of(&test, &reference, args.exposure)?;

    if let Some(output) = diff {
        let scale = args.diff_scale.map_or_else(|| usual_difference(&test, &reference), f64::from);
        write_png(output, test.width(), test.height(), &signed_difference(&test, &reference, scale)?)?;
    }
    if let Some(output) = heatmap {
        write_png(output, test.width(), test.height(), &flip.rgb_bytes())?;
    }
    if args.json {
        say(to_json(&comparison, flip.mean(), shadows.as_ref())?);
    } else {
        print(&comparison, flip.mean(), shadows.as_ref());
    }
    Ok(())
}

/// 99th percentile of the differences of luminance that are not zero.
fn usual_difference(test: &Picture, reference: &Picture) -> f64 {
    let difference = |(a, b): (&glam::Vec3, &glam::Vec3)| (luminance(*a) - luminance(*b)).abs();
    let all = test.pixels().iter().zip(reference.pixels()).map(difference);
    let mut differences: Vec<f64> = all.filter(|d| *d > 0.0).collect();
    differences.sort_unstable_by(f64::total_cmp);
    differences.get(differences.len() * 99 / 100).copied().unwrap_or(1.0)
}

fn to_json(comparison: &Comparison, flip: f64, shadows: Option<&ShadowErrors>) -> Result<String, Failure> {
    let mut value = serde_json::to_value(comparison)?;
    value["flip"] = json!(flip);
    if let (Some(shadows), Value::Object(keys)) = (shadows, &mut value) {
        let Value::Object(more) = serde_json::to_value(shadows)? else { return Ok(value.to_string()) };
        keys.extend(more);
    }
    Ok(serde_json::to_string_pretty(&value)?)
}

fn print(c: &Comparison, flip: f64, shadows: Option<&ShadowErrors>) {
    let percent = |x: f64| {
        if c.reference_mean > 0.0 {
            format!("{:.4} % of the mean", 100.0 * x / c.reference_mean)
        } else {
            String::new()
        }
    };
    say(format_args!("pixels          {}", c.pixels));
    say(format_args!("reference mean  {:.6}", c.reference_mean));
    say(format_args!("mean error      {:.6}   {}", c.mae, percent(c.mae)));
    say(format_args!("RMS error       {:.6}   {}", c.rmse, percent(c.rmse)));
    say(format_args!("largest error   {:.6}", c.max));
    say(format_args!("bias            {:+.6}  {}", c.bias, percent(c.bias)));
    say(format_args!("mean relative   {:.4} %", 100.0 * c.mean_relative));
    say(format_args!("FLIP            {flip:.5}"));
    let line = |name: &str, of: &str, r: &RegionError| {
        let [mean, p99, max] = [r.mean, r.p99, r.max].map(|x| 100.0 * x);
        format!(
            "{name:15} {} pixels, error in % of {of}: mean {mean:.4}, 99th percentile {p99:.4}, max {max:.4}",
            r.pixels
        )
    };
    say(line("own radiance", "the pixel's own", &c.own));
    let Some(s) = shadows else { return };
    let unshadowed = "unshadowed";
    say(line("penumbra", unshadowed, &s.penumbra));
    say(line("fully lit", unshadowed, &s.lit));
    say(format_args!("{}; {} not exactly 0", line("fully dark", unshadowed, &s.dark), s.dark_nonzero));
}
