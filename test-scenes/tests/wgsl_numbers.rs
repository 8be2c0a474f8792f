//! Numbers that stand in WGSL and in Rust are the same.

use core::f64::consts;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// A number in WGSL: the file, its name, and where Rust has it.
type Pair = (&'static str, &'static str, Rust);

enum Rust {
    /// A constant of a file.
    Is(&'static str, &'static str),
    /// One over a constant of a file.
    Inverse(&'static str, &'static str),
    /// A number of the language.
    Number(f64),
    /// There is none: f32 on another path needs a number of its own.
    Own,
}

use Rust::{Inverse, Is, Number, Own};

const PAIRS: &[Pair] = &[
    ("lobe-core/src/geometry.wgsl", "CONE_INSIDE", Is("lobe-core/src/geometry.rs", "INSIDE")),
    ("lobe-core/src/microfacets.wgsl", "MICROFACETS_GRAZING", Is("lobe-core/src/microfacets.rs", "GRAZING")),
    ("lobe-core/src/special.wgsl", "PI", Number(consts::PI)),
    ("lobe-core/src/special.wgsl", "TAU", Number(consts::TAU)),
    ("lobe-core/src/special.wgsl", "FRAC_PI_2", Number(consts::FRAC_PI_2)),
    ("lobe-core/src/special.wgsl", "FRAC_PI_4", Number(consts::FRAC_PI_4)),
    ("lobe-core/src/special.wgsl", "FRAC_1_PI", Number(consts::FRAC_1_PI)),
    ("lobe-core/src/special.wgsl", "FRAC_1_TAU", Number(1.0 / consts::TAU)),
    ("lobe-core/src/special.wgsl", "FRAC_1_SQRT_2", Number(consts::FRAC_1_SQRT_2)),
    ("lobe-core/src/special.wgsl", "FRAC_2_SQRT_PI", Number(consts::FRAC_2_SQRT_PI)),
    ("lobe-core/src/special.wgsl", "LN_2", Number(consts::LN_2)),
    ("lobe-core/src/special.wgsl", "LOG2_E", Number(consts::LOG2_E)),
    ("lobe-core/src/special.wgsl", "MIN_POSITIVE", Number(f32::MIN_POSITIVE as f64)),
    ("lobe-core/src/special.wgsl", "MAX_FLOAT", Number(f32::MAX as f64)),
    ("lobe-core/src/special.wgsl", "ERF_END", Is("lobe-core/src/special.rs", "ERF_END")),
    ("lobe-core/src/cap/cap.wgsl", "MIRROR", Is("lobe-core/src/cap/form.rs", "MIRROR")),
    ("lobe-core/src/cap/chord.wgsl", "KAPPA", Is("lobe-core/src/cap/chord.rs", "KAPPA")),
    ("lobe-core/src/cap/chord.wgsl", "ENDS", Is("lobe-core/src/cap/chord.rs", "ENDS")),
    ("lobe-core/src/cap/microfacets.wgsl", "ELLIPSE_FAR", Is("lobe-core/src/cap/microfacets.rs", "FAR")),
    ("lobe-core/src/cap/slab.wgsl", "SLAB_EXPONENT", Is("lobe-core/src/cap/slab.rs", "EXPONENT")),
    ("lobe-core/src/cap/slab.wgsl", "SLAB_WIDTH", Is("lobe-core/src/cap/slab.rs", "WIDTH")),
    ("lobe-core/src/outline/outline.wgsl", "OUTLINE_DEPTH", Is("lobe-core/src/outline/mod.rs", "DEPTH")),
    ("lobe-core/src/outline/outline.wgsl", "OUTLINE_WIDEST", Is("lobe-core/src/outline/mod.rs", "WIDEST")),
    ("lobe-core/src/outline/image.wgsl", "IMAGE_BORDER", Is("lobe-core/src/outline/image.rs", "BORDER")),
    ("lobe-core/src/outline/integral.wgsl", "OUTLINE_WIDE", Is("lobe-core/src/outline/integral.rs", "WIDE")),
    (
        "lobe-core/src/outline/image_integral.wgsl",
        "OUTLINE_SMALL_LIGHT",
        Is("lobe-core/src/outline/cubature.rs", "SMALL_LIGHT"),
    ),
    ("lobe-core/src/outline/outline.wgsl", "OUTLINE_AROUND", Is("lobe-core/src/outline/mod.rs", "AROUND")),
    ("lobe-core/src/outline/integral.wgsl", "OUTLINE_STEEP", Is("lobe-core/src/outline/integral.rs", "STEEP")),
    ("lobe-core/src/outline/integral.wgsl", "OUTLINE_EQUAL", Is("lobe-core/src/outline/lambert.rs", "EQUAL")),
    ("lobe-core/src/outline/integral.wgsl", "OUTLINE_SHORT", Is("lobe-core/src/outline/lambert.rs", "SHORT")),
    ("lobe-core/src/outline/integral.wgsl", "OUTLINE_CUT", Is("lobe-core/src/outline/lambert.rs", "CUT")),
    ("lobe-core/src/outline/integral.wgsl", "OUTLINE_SMALL", Is("lobe-core/src/outline/cubature.rs", "SMALL")),
    ("lobe-core/src/outline/integral.wgsl", "OUTLINE_NOTHING", Is("lobe-core/src/outline/integral.rs", "NOTHING")),
    // π/6 over its sine, which Rust works out.
    ("lighting/src/plane_lights.wgsl", "TUBE_REACH", Number(consts::FRAC_PI_3)),
    ("visibility-mask/src/flat.wgsl", "FLAT_WIDE", Is("visibility-mask/src/visibility.rs", "WIDE")),
    ("paper/src/tables.wgsl", "PAPER_LAST", Is("paper/src/product_table.rs", "LAST")),
    ("visibility-mask/src/contour.wgsl", "CONTOUR_WIDE", Is("visibility-mask/src/contour.rs", "WIDE")),
    // In 127ths of a cell.
    ("visibility-mask/src/contour.wgsl", "CONTOUR_WHOLE", Number(i8::MAX as f64)),
    ("visibility-mask/src/edges.wgsl", "EDGES_PLANE", Is("visibility-mask/src/edges.rs", "PLANE")),
    ("visibility-mask/src/fraction_glossy.wgsl", "LEFT_OUT", Is("visibility-mask/src/visible_fraction.rs", "LEFT_OUT")),
    (
        "visibility-mask/src/fraction_glossy.wgsl",
        "MIRROR_EXPONENT",
        Is("visibility-mask/src/visible_fraction.rs", "MIRROR"),
    ),
    ("visibility-mask/src/fraction_lambert.wgsl", "CORNER", Is("visibility-mask/src/visible_fraction.rs", "CORNER")),
    ("visibility-mask/src/fraction_microfacets.wgsl", "HIGHLIGHT", Is("visibility-mask/src/square.rs", "HIGHLIGHT")),
    ("visibility-mask/src/square.wgsl", "WIDEST_TAN", Is("visibility-mask/src/square.rs", "WIDEST_TAN")),
    ("visibility-mask/src/square.wgsl", "NARROWEST", Is("visibility-mask/src/square.rs", "NARROWEST")),
    ("visibility-mask/src/square.wgsl", "FARTHEST", Is("visibility-mask/src/square.rs", "FARTHEST")),
    ("visibility-mask/src/square.wgsl", "THINNEST", Is("visibility-mask/src/square.rs", "THINNEST")),
    ("visibility-mask/src/visibility.wgsl", "CROWDED", Is("visibility-mask/src/visibility.rs", "CROWDED")),
    ("visibility-mask/src/visibility.wgsl", "COARSE", Is("visibility-mask/src/fineness.rs", "COARSE")),
    ("visibility-mask/src/visibility.wgsl", "FINEST", Is("shading/src/accuracy.rs", "FINEST")),
    ("visibility-mask/src/visibility_window.wgsl", "STEEP", Is("visibility-mask/src/visibility.rs", "STEEP")),
    ("visibility-shadowmap/src/coverage.wgsl", "MAP_DIAGONAL", Number(consts::FRAC_1_SQRT_2)),
    // A layer of the packed map that has no surface.
    ("visibility-shadowmap/src/layer.wgsl", "MAP_EMPTY", Own),
    ("visibility-shadowmap/src/face_view.wgsl", "MAP_BIAS", Is("visibility-shadowmap/src/face_view.rs", "BIAS")),
    ("visibility-shadowmap/src/face_view.wgsl", "MAP_TILT", Is("visibility-shadowmap/src/face_view.rs", "TILT")),
    (
        "visibility-shadowmap/src/face_view.wgsl",
        "MAP_ROUNDING",
        Is("visibility-shadowmap/src/face_view.rs", "ROUNDING"),
    ),
    ("visibility-shadowmap/src/face_view.wgsl", "MAP_SHIFT", Is("visibility-shadowmap/src/face_view.rs", "SHIFT")),
    ("visibility-shadowmap/src/face_view.wgsl", "MAP_SMALL", Is("visibility-shadowmap/src/face_view.rs", "SMALL")),
    (
        "visibility-shadowmap/src/face_view.wgsl",
        "MAP_PART_SHIFT",
        Is("visibility-shadowmap/src/face_view.rs", "PART_SHIFT"),
    ),
    ("visibility-shadowmap/src/face_view.wgsl", "MAP_NEAR", Is("visibility-shadowmap/src/face_view.rs", "NEAR")),
    (
        "visibility-silhouettes/src/silhouettes.wgsl",
        "SILHOUETTES_UNSURE",
        Is("visibility-silhouettes/src/hull.rs", "UNSURE"),
    ),
    (
        "visibility-silhouettes/src/silhouettes.wgsl",
        "SILHOUETTES_AROUND",
        Is("visibility-silhouettes/src/select.rs", "AROUND"),
    ),
    (
        "visibility-silhouettes/src/silhouettes.wgsl",
        "SILHOUETTES_AROUND_SQ",
        Is("visibility-silhouettes/src/select.rs", "AROUND_SQ"),
    ),
    (
        "visibility-silhouettes/src/silhouettes.wgsl",
        "SILHOUETTES_MARGIN",
        Is("visibility-silhouettes/src/beside.rs", "MARGIN"),
    ),
    // The CPU's hulls have margins of their own.
    ("visibility-silhouettes/src/silhouettes.wgsl", "SILHOUETTES_ROUNDING", Own),
    (
        "visibility-silhouettes/src/silhouettes_splat.wgsl",
        "SILHOUETTES_WIDEST",
        Is("visibility-silhouettes/src/blockers.rs", "WIDEST_DISC"),
    ),
    (
        "visibility-silhouettes/src/silhouettes_splat.wgsl",
        "SILHOUETTES_BESIDE",
        Is("visibility-silhouettes/src/select.rs", "BESIDE"),
    ),
    (
        "visibility-silhouettes/src/silhouettes_splat.wgsl",
        "SILHOUETTES_NEAR",
        Is("visibility-silhouettes/src/project.rs", "NEAR"),
    ),
    (
        "visibility-silhouettes/src/silhouettes_splat.wgsl",
        "SILHOUETTES_FAR_OUTSIDE",
        Is("visibility-silhouettes/src/project.rs", "FAR_OUTSIDE"),
    ),
    (
        "visibility-silhouettes/src/silhouettes_splat.wgsl",
        "SILHOUETTES_LENGTHS",
        Inverse("visibility-mask/src/edges.rs", "STEP"),
    ),
    ("visibility-spheres/src/cone_test.wgsl", "CONE_SLACK", Is("visibility-spheres/src/blocked_cones.rs", "SLACK")),
    ("visibility-spheres/src/ellipse.wgsl", "FLAT", Is("visibility-spheres/src/ellipse.rs", "FLAT")),
    // A device's roots and quotients are less exact than the CPU's.
    ("visibility-spheres/src/shaft.wgsl", "SHAFT_SLACK", Own),
    ("visibility-spheres/src/shaft.wgsl", "SHAFT_NEARLY", Own),
    ("visibility-spheres/src/shaft.wgsl", "MARGIN", Is("visibility-spheres/src/shaft.rs", "MARGIN")),
    ("visibility-spheres/src/wide_cone.wgsl", "WIDE_LIMIT", Is("visibility-spheres/src/wide_cone.rs", "LIMIT")),
    ("visibility-spheres/src/bounds.wgsl", "BOUNDS_EVERYTHING", Own),
    ("render-gpu/src/kernels/bvh.wgsl", "NEVER", Own),
    ("render-gpu/src/kernels/bvh.wgsl", "BVH_EDGE", Is("ray-tracing/src/world/primitive.rs", "EDGE")),
    ("render-gpu/src/kernels/bvh.wgsl", "WIDEST", Is("ray-tracing/src/world/packet.rs", "WIDEST")),
    ("render-gpu/src/kernels/bvh.wgsl", "CLOSE", Is("ray-tracing/src/world/primitive.rs", "CLOSE")),
    ("render-gpu/src/kernels/bvh.wgsl", "CLOSE_TO_SPHERE", Is("ray-tracing/src/world/primitive.rs", "CLOSE_TO_SPHERE")),
    ("render-gpu/src/kernels/any_hit.wgsl", "BLUR", Is("ray-tracing/src/world/query.rs", "BLUR")),
    ("visibility-rays/src/rays_splat.wgsl", "GRAZING", Is("visibility-rays/src/rays.rs", "GRAZING")),
];

/// The folder of all crates.
const WORKSPACE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// A number as WGSL and Rust write it; quotients too.
fn number(text: &str) -> Option<f64> {
    if let Some((over, under)) = text.split_once('/') {
        return Some(number(over.trim())? / number(under.trim())?);
    }
    text.replace('_', "").trim_end_matches('f').parse().ok()
}

/// The constants of a text in WGSL that are no whole numbers.
fn of_wgsl(text: &str) -> impl Iterator<Item = (&str, f64)> {
    let constants =
        text.lines().filter_map(|line| line.trim().strip_prefix("const ")?.strip_suffix(';')?.split_once(" = "));
    let is_real = |value: &str| value.contains(['.', 'e', 'f']) && !value.starts_with("0x");
    constants.filter_map(move |(name, value)| Some((name, number(value).filter(|_| is_real(value))?)))
}

/// A constant of a text in Rust.
fn of_rust(text: &str, name: &str) -> Option<f64> {
    let line = text.lines().find(|line| line.contains(&format!("const {name}: ")))?;
    number(line.split_once(" = ")?.1.trim_end_matches(';'))
}

fn texts(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()) {
        if entry.is_dir() {
            texts(&entry, found);
        } else if entry.extension().is_some_and(|extension| extension == "wgsl") {
            found.push(entry);
        }
    }
}

/// Every number of every text is in the table, and is Rust's to the last digit of f32.
#[test]
fn numbers_are_rusts() {
    let workspace = Path::new(WORKSPACE);
    let read = |path: &str| fs::read_to_string(workspace.join(path)).expect(path);
    let mut files = Vec::new();
    for entry in fs::read_dir(workspace).expect("a folder").map(|entry| entry.expect("an entry").path().join("src")) {
        if entry.is_dir() {
            texts(&entry, &mut files);
        }
    }
    let mut left: BTreeSet<(&str, &str)> = PAIRS.iter().map(|(path, name, _)| (*path, *name)).collect();
    for file in &files {
        let path = file.strip_prefix(workspace).expect("inside").to_string_lossy().replace('\\', "/");
        for (name, value) in of_wgsl(&fs::read_to_string(file).expect("a text")) {
            let (known, id, rust) = PAIRS
                .iter()
                .find(|(known, of, _)| (*known, *of) == (path.as_str(), name))
                .unwrap_or_else(|| panic!("{path}: is {name} Rust's, too?"));
            let want = match rust {
                Is(file, name) => of_rust(&read(file), name).unwrap_or_else(|| panic!("{file} has no {name}")),
                Inverse(file, name) => {
                    1.0 / of_rust(&read(file), name).unwrap_or_else(|| panic!("{file} has no {name}"))
                }
                Number(number) => *number,
                Own => value,
            };
            assert_eq!(value as f32, want as f32, "{path}: {name}");
            left.remove(&(*known, *id));
        }
    }
    assert!(left.is_empty(), "not there: {left:?}");
}
