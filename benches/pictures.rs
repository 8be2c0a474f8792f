//! Detects changes of pixels: renders scenes × strategies × methods × devices and compares each picture's bits with
//! those of an earlier run.
//!
//! ```sh
//! cargo bench --bench pictures -- --save target/before.txt      # before the change
//! cargo bench --bench pictures -- --against target/before.txt   # after it
//! ```
//!
//! With `--device cpu` or `--device gpu` it renders only pictures of that device. A GPU's bits depend on its driver: compare runs of one machine.

use cosine_lobes::{checksum, read_exr};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// Scenes of the repository, and whether they are drawn on a GPU, too (kernels of a software device compile for long).
const SCENES: [(&str, bool); 10] = [
    ("builtin", true),
    ("glossy_spheres", true),
    ("soft_spheres", false),
    ("lafortune", true),
    ("bunny", true),
    ("armadillo", false),
    ("room", false),
    ("toys", true),
    ("walk", true),
    ("tentacles", false),
];

const STRATEGIES: [&str; 6] = ["scene", "spheres", "silhouettes", "shadow-map", "rays", "none"];

/// Further arguments of a picture, beside scene, strategy and device, and their name.
const SETTINGS: [(&str, &[&str]); 5] = [
    ("moments", &[]),
    ("moments at 0.1 %", &["--tolerance", "0.001"]),
    ("moments at 2 %", &["--tolerance", "0.02", "--threshold", "0.001"]),
    ("moments in layers", &["--layers"]),
    ("paper", &["--method", "paper"]),
];

/// One picture: its name, and the command's arguments.
struct Shot {
    name: String,
    arguments: Vec<String>,
}

fn shots(device: &str) -> Vec<Shot> {
    let mut shots = Vec::new();
    for (scene, on_gpu) in SCENES {
        for strategy in STRATEGIES {
            for (setting, options) in SETTINGS {
                let plain = setting == "moments";
                let wanted = match device {
                    // Every strategy by moments, and each other setting on the scene's own strategy and on spheres.
                    "cpu" => plain || matches!(strategy, "scene" | "spheres"),
                    _ => on_gpu && setting != "moments in layers" && (plain || strategy == "scene"),
                };
                // Fits of sets for these take minutes, and show nothing new.
                let is_long = strategy == "spheres" && matches!(scene, "room" | "toys");
                if !wanted || is_long {
                    continue;
                }
                let mut arguments = vec!["render".to_owned()];
                if scene != "builtin" {
                    arguments.push(format!("{}/../scenes/{scene}.toml", env!("CARGO_MANIFEST_DIR")));
                }
                let size = if device == "cpu" { "120x68" } else { "64x40" };
                let rest = ["--quiet", "--samples", "1", "--size", size, "--visibility", strategy, "--device", device];
                arguments.extend(rest.iter().chain(options).map(|word| (*word).to_owned()));
                shots.push(Shot { name: format!("{device} | {scene} | {strategy} | {setting}"), arguments });
            }
        }
    }
    shots
}

/// The checksum of a picture's values, all of its layers included.
fn digest(shot: &Shot, folder: &Path) -> Result<String, String> {
    let file = folder.join("picture.exr");
    let run = Command::new(env!("CARGO_BIN_EXE_lobes"))
        .args(&shot.arguments)
        .arg("-o")
        .arg(&file)
        .output()
        .map_err(|error| error.to_string())?;
    if !run.status.success() {
        return Err(String::from_utf8_lossy(&run.stderr).trim().to_owned());
    }
    let picture = read_exr(&file).map_err(|error| error.to_string())?;
    let mut bytes: Vec<u8> = picture.pixels().iter().flat_map(|p| p.to_array()).flat_map(f32::to_le_bytes).collect();
    if shot.arguments.iter().any(|word| word == "--layers") {
        for name in ["unshadowed", "light0", "normal", "lobes"] {
            if let Ok(Some(layer)) = cosine_lobes::read_exr_layer(&file, name) {
                bytes.extend(layer.pixels().iter().flat_map(|p| p.to_array()).flat_map(f32::to_le_bytes));
            }
        }
    }
    Ok(checksum(&bytes))
}

/// A path that the caller gives from the repository's root: Cargo runs benches in the folder of their package.
fn from_root(path: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/..")).join(path)
}

fn run() -> Result<ExitCode, String> {
    let (mut save, mut against, mut device) = (None, None, None);
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or(format!("{word}: what follows is missing"));
        match word.as_str() {
            "--save" => save = Some(from_root(&value()?)),
            "--against" => against = Some(from_root(&value()?)),
            "--device" => device = Some(value()?),
            // Cargo adds it.
            "--bench" => {}
            _ => return Err(format!("{word}: only --save FILE, --against FILE and --device cpu|gpu are known")),
        }
    }
    let before: Option<BTreeMap<String, String>> = match &against {
        None => None,
        Some(path) => {
            let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
            let pair = |line: &str| line.rsplit_once(" = ").map(|(name, sum)| (name.to_owned(), sum.to_owned()));
            Some(text.lines().filter_map(pair).collect())
        }
    };
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    let devices = device.map_or_else(|| vec!["cpu".to_owned(), "gpu".to_owned()], |one| vec![one]);
    let (mut lines, mut moved, mut all) = (String::new(), 0, 0);
    for shot in devices.iter().flat_map(|device| shots(device)) {
        let sum = digest(&shot, folder.path()).map_err(|error| format!("{}: {error}", shot.name))?;
        lines += &format!("{} = {sum}\n", shot.name);
        all += 1;
        match before.as_ref().map(|before| before.get(&shot.name)) {
            Some(Some(old)) if *old != sum => {
                moved += 1;
                println!("moved: {}", shot.name);
            }
            Some(None) => println!("new: {}", shot.name),
            _ => {}
        }
    }
    if let Some(path) = save {
        std::fs::write(&path, lines).map_err(|error| format!("{}: {error}", path.display()))?;
    }
    println!("{all} pictures{}", if against.is_some() { format!(", {moved} of them moved") } else { String::new() });
    Ok(if moved == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn main() -> ExitCode {
    run().unwrap_or_else(|error| {
        eprintln!("pictures: {error}");
        ExitCode::from(2)
    })
}
