use crate::args::SpheresArgs;
use crate::console::{self, say};
use crate::failure::Failure;
use crate::files;
use crate::whole_mesh::WholeMesh;
use cosine_lobes::scene;
use cosine_lobes::sphere_sets::{BuildOptions, SetQuality, SphereSet, Verdict, preview};
use cosine_lobes::write_png;
use serde_json::json;
use std::ops::ControlFlow;
use std::time::Instant;

/// Side of a panel of the preview in pixels.
const PANEL: u32 = 512;
/// The default number of spheres: enough for most meshes that suit spheres at all.
const COUNT: usize = 64;

/// All triangles of the file, at the first moment of its clip.
fn load(args: &SpheresArgs) -> Result<WholeMesh, Failure> {
    let mesh = args.mesh.display();
    if args.mesh.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) {
        let message = "a set is built for one mesh, .obj, .ply, .gltf or .glb; those of a scene are built by render";
        return Err(Failure::new(format_args!("{mesh}: {message}")));
    }
    let (objects, animation, warnings) = scene::load_objects(&args.mesh, args.clip.as_deref())?;
    if !args.quiet {
        warnings.iter().for_each(|w| console::note(format_args!("lobes: warning: {w}")));
    }
    let whole = WholeMesh::new(&objects, &animation);
    if args.bones && whole.carriers().is_none() {
        return Err(Failure::new(format_args!("--bones: {mesh} has none, nothing in it moves")));
    }
    Ok(whole)
}

/// A bound with a larger overhang has filled an opening. As a fraction of the diagonal it is 0.03 for a lumpy sphere with 64
/// spheres, 0.34 to 0.46 for a bowl.
const OVERHANG: f32 = 0.1;

/// A line about a set that stands badly for its mesh, with the reason.
fn doubt(args: &SpheresArgs, options: &BuildOptions, quality: &SetQuality) -> Option<String> {
    let percent = 100.0 * quality.hausdorff_outside;
    let why = match quality.verdict(options) {
        _ if args.bounding && quality.hausdorff_outside > OVERHANG => {
            format!(
                "its bound reaches {percent:.0} % of the diagonal out of it, since it is open or the spheres are few"
            )
        }
        // The number of spheres follows from the requested error.
        _ if args.tolerance.is_some() => return None,
        Verdict::Suits => return None,
        Verdict::FewSpheres => format!("too few spheres ({}) for it, --count allows more", options.count),
        Verdict::Draft => "--draft leaves about three times the error of a full fit".to_owned(),
        Verdict::Bounding => "a bound casts too large a shadow, and of an open mesh it fills the inside".to_owned(),
        Verdict::Unsuitable => "spheres do not suit this mesh, render it with --visibility silhouettes".to_owned(),
    };
    let error = 100.0 * quality.silhouette_error;
    Some(format!("{}: silhouette error {error:.0} %: {why}", args.mesh.display()))
}

pub(crate) fn run(args: &SpheresArgs) -> Result<(), Failure> {
    files::distinct(args.output.iter().chain(&args.preview), [&args.mesh])?;
    let output = args.output.as_ref().map(files::create_json).transpose()?;
    let picture = args.preview.as_ref().map(files::create_png).transpose()?;
    let whole = load(args)?;
    let (positions, triangles) = (&whole.positions, &whole.triangles);

    let count = args.count.unwrap_or(if args.tolerance.is_some() { 1024 } else { COUNT as u32 }) as usize;
    let options = if args.draft { BuildOptions::draft(count) } else { BuildOptions::new(count) };
    let options = BuildOptions { seed: args.seed, bounding: args.bounding, ..options };
    let bar = console::progress("spheres", 1000, args.quiet);
    let start = Instant::now();
    let mut report = |done: f32| {
        bar.set_position((done * 1000.0) as u64);
        ControlFlow::Continue(())
    };
    let set = match args.tolerance {
        Some(tolerance) => SphereSet::build_to_tolerance(positions, triangles, tolerance, &options, &mut report),
        None => SphereSet::build_with_progress(positions, triangles, &options, &mut report),
    };
    bar.finish_and_clear();
    let set = set.map_err(|e| Failure::new(format_args!("{}: {e}", args.mesh.display())))?;
    let seconds = start.elapsed().as_secs_f64();
    if let Some(line) = doubt(args, &options, &set.quality).filter(|_| !args.quiet) {
        console::note(format_args!("lobes: warning: {line}"));
    }
    if output.is_none() && !args.quiet {
        console::note("lobes: note: the set is not kept: -o set.json would write it");
    }

    if let Some(output) = output {
        let text = match whole.carriers().filter(|_| args.bones) {
            Some(carriers) => set.bind(positions, triangles, &carriers).map_err(Failure::new)?.to_json(),
            None => set.to_json(),
        };
        output.write(text.as_bytes())?;
    }
    if let Some(output) = picture {
        let map = preview(&set, positions, triangles, PANEL)?;
        let rgb: Vec<u8> = map.data().chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
        write_png(output, map.width() as usize, map.height() as usize, &rgb)?;
    }
    tell(args, &set, seconds, triangles.len())
}

/// Prints what the set is like.
fn tell(args: &SpheresArgs, set: &SphereSet, seconds: f64, triangles: usize) -> Result<(), Failure> {
    let q = &set.quality;
    if args.json {
        say(serde_json::to_string_pretty(&json!({
            "count": set.spheres.len(),
            "bounding": args.bounding,
            "seconds": seconds,
            "coverage": q.coverage,
            "protrusion_volume": q.protrusion_volume,
            "hausdorff_outside": q.hausdorff_outside,
            "p95_gap": q.p95_gap,
            "silhouette_error": q.silhouette_error,
            "self_distance": set.self_distance,
            "triangles": triangles,
        }))?);
    } else if !args.quiet {
        say(format_args!("spheres           {} in {seconds:.2} s", set.spheres.len()));
        say(format_args!("coverage          {:.2} % of the mesh's volume", 100.0 * q.coverage));
        say(format_args!("protrusion        {:.2} % of it outside", 100.0 * q.protrusion_volume));
        say(format_args!("silhouette error  {:.2} % of the silhouette's area", 100.0 * q.silhouette_error));
        say(format_args!("largest overhang  {:.3} % of the diagonal", 100.0 * q.hausdorff_outside));
        say(format_args!("95 % gap          {:.3} % of the diagonal", 100.0 * q.p95_gap));
    }
    Ok(())
}
