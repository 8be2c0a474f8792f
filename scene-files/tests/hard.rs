//! Difficult and valid files from a shared collection: every one either gives a valid scene or one clear line.
//!
//! The collection lies beside the repository and is not part of it; where it is absent these tests are shown as ignored.

#![expect(clippy::unwrap_used, reason = "a test")]

use std::collections::HashMap;
use std::fs;
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};

const SHARED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/assets");

fn files_below(folder: &Path, out: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            files_below(&path, out);
        } else {
            out.push(path);
        }
    }
}

/// Loads without a panic; a scene is valid, an error is one line that names the file.
fn load(path: &Path) -> Result<scene::Scene, String> {
    let result = catch_unwind(|| scene_files::load(path)).unwrap_or_else(|_| panic!("{} panicked", path.display()));
    match result {
        Ok(scene) => {
            scene.validate().unwrap_or_else(|e| panic!("{}: {e}", path.display()));
            Ok(scene)
        }
        Err(e) => {
            let message = e.to_string();
            assert!(!message.contains('\n') && message.len() < 1000, "{message}");
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            assert!(message.contains(&name), "{message} does not name {name}");
            Err(message)
        }
    }
}

/// File name → verdict, from the collection's own table.
fn verdicts() -> HashMap<String, String> {
    let text = fs::read_to_string(format!("{SHARED}/hard/INDEX.md")).unwrap();
    text.lines()
        .filter_map(|line| {
            let cells: Vec<&str> = line.split('|').map(str::trim).collect();
            let name = cells.get(1)?.strip_prefix('`')?.strip_suffix('`')?;
            Some((name.to_owned(), (*cells.get(3)?).to_owned()))
        })
        .collect()
}

#[test]
#[cfg_attr(not(shared_assets), ignore = "needs ../shared/assets beside the repository")]
fn difficult_files_get_the_verdict_of_their_index() {
    let verdicts = verdicts();
    let mut paths = Vec::new();
    files_below(&Path::new(SHARED).join("hard"), &mut paths);
    assert!(paths.len() >= 199);
    let mut wrong = Vec::new();
    for path in paths {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let start = std::time::Instant::now();
        let result = load(&path);
        assert!(start.elapsed().as_secs_f64() < 2.0, "{name} took {:?}", start.elapsed());
        let told = match &result {
            Ok(scene) => format!("{} triangles", scene.triangles() - 2),
            Err(message) => message.clone(),
        };
        println!("{name}: {told}");
        match (verdicts.get(&name).map(String::as_str), &result) {
            (Some("load"), Err(message)) => wrong.push(format!("should load: {message}")),
            (Some("refuse"), Ok(_)) => wrong.push(format!("should refuse: {name}")),
            _ => {}
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// An error in a clip names its place in the file; a clip that loads can be played.
#[test]
#[cfg_attr(not(shared_assets), ignore = "needs ../shared/assets beside the repository")]
fn broken_clips_are_refused() {
    let mut files = 0;
    for (name, _) in verdicts().iter().filter(|(name, _)| name.starts_with("gltf_anim_")) {
        files += 1;
        let loaded = scene_files::load_animated(Path::new(SHARED).join("hard").join(name));
        let words = match name.strip_prefix("gltf_anim_").unwrap().trim_end_matches(".gltf") {
            "nan_time" => ["channel 0", "NaN", "must lie within"],
            "huge_time" => ["channel 0", "3e38", "must lie within"],
            "node_missing" => ["channel 0", "no node 12", "expected"],
            "sampler_missing" => ["channel 0", "no sampler 5", "expected"],
            "too_few_values" => ["channel 0", "2 values for 4 keys", "expected 4"],
            "interp_unknown" => ["channel 0", "expected LINEAR", "in sampler 0"],
            "unsorted" => ["channel 0", "not in order", "after"],
            "zero_quaternion" => ["channel 0", "rotation key 0", "expected a unit quaternion"],
            _ => {
                let (mut scene, animation, warnings) = loaded.unwrap();
                println!("{name}: {:?} {warnings:?}", animation.clips());
                assert_eq!(animation.clips().is_empty(), animation.is_still(), "{name}");
                for i in -2..20 {
                    animation.seek(0.1 * i as f32, &mut scene);
                    scene.validate().unwrap();
                }
                continue;
            }
        };
        let message = loaded.unwrap_err().to_string();
        println!("{message}");
        assert!(message.contains(name.as_str()) && !message.contains('\n'), "{message}");
        assert!(words.iter().all(|w| message.contains(w)) && message.contains("animation 0"), "{message}");
    }
    assert_eq!(files, 15);
}

#[test]
#[cfg_attr(not(shared_assets), ignore = "needs ../shared/assets beside the repository")]
fn difficult_obj_files_keep_their_triangles() {
    let mesh = |name: &str| {
        let scene = scene_files::load(Path::new(SHARED).join("hard").join(name)).unwrap();
        let scene::Shape::Mesh(mesh) = scene.objects[1].shape.clone() else { panic!() };
        mesh
    };
    for (name, triangles) in [
        ("obj_negative_indices.obj", 12),
        ("obj_crlf_continuation.obj", 12),
        ("obj_cr_only.obj", 12),
        ("obj_vertex_colors_w.obj", 24),
        ("obj_lines_points_curves.obj", 12),
        ("obj_unknown_keywords.obj", 12),
        ("obj_zero_area.obj", 12),
        ("obj_intersecting_cubes.obj", 24),
        ("obj_nonmanifold.obj", 4),
        ("ply_big_endian.ply", 12),
        ("ply_crlf_header_binary.ply", 12),
        ("ply_extra_properties.ply", 12),
        ("glb_valid_cube.glb", 12),
        ("gltf_datauri_long.gltf", 12),
        ("gltf_skin_valid.gltf", 4),
    ] {
        assert_eq!(mesh(name).triangles.len(), triangles, "{name}");
    }
    // A concave hexagon of area 3, a star of 1.1756, a 12-gon of 3.
    let polygons = mesh("obj_ngon_concave.obj");
    assert_eq!(polygons.triangles.len(), 22);
    assert!((polygons.area() - 7.1756).abs() < 1e-3, "{}", polygons.area());
}

#[test]
#[cfg_attr(not(shared_assets), ignore = "needs ../shared/assets beside the repository")]
fn good_files_load() {
    let mut paths = Vec::new();
    files_below(&Path::new(SHARED).join("meshes"), &mut paths);
    files_below(&Path::new(SHARED).join("gltf"), &mut paths);
    let known = |p: &PathBuf| {
        p.extension().is_some_and(|e| ["obj", "ply", "gltf", "glb"].contains(&e.to_string_lossy().as_ref()))
    };
    paths.retain(known);
    for path in paths {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let start = std::time::Instant::now();
        match load(&path) {
            Ok(s) => {
                println!("{name}: {} objects, {} triangles, {:?}", s.objects.len(), s.triangles(), start.elapsed())
            }
            Err(message) => {
                // Compressed geometry needs a decoder.
                assert!(["BoxDraco.gltf", "BoxMeshopt.glb"].contains(&name.as_str()), "{message}");
            }
        }
    }
}
