//! All times come from the caller's clock, so that targets without a clock render too.

use core::sync::atomic::{AtomicU64, Ordering};
use renderer::{Device, Renderer, Settings, set_clock};
use scene::{Animation, Strategy};
use std::fs;
use std::path::Path;

/// Number of calls: each call is one second later.
static LOOKS: AtomicU64 = AtomicU64::new(0);

fn clock() -> f64 {
    LOOKS.fetch_add(1, Ordering::Relaxed) as f64
}

#[test]
fn times_are_read_from_the_clock_that_was_given() {
    assert!(set_clock(clock));
    assert!(!set_clock(|| 0.0), "the first one stays");
    let mut scene = scene::builtin();
    (scene.width, scene.height) = (32, 18);
    let settings = Settings { strategy: Some(Strategy::Silhouettes), device: Device::Cpu, ..Settings::default() };
    let mut renderer = Renderer::new(scene, Animation::default(), settings).expect("a scene");
    let before = LOOKS.load(Ordering::Relaxed);
    let stats = renderer.render().expect("a picture").stats;
    let looks = (LOOKS.load(Ordering::Relaxed) - before) as f64;
    let times = [stats.clocks.hierarchy, stats.clocks.silhouettes, stats.clocks.gbuffer, stats.shading[0].seconds];
    // Whole seconds, and no more than there were calls.
    assert!(times.iter().all(|time| *time >= 1.0 && time.fract() == 0.0), "{times:?}");
    assert!(times.iter().sum::<f64>() <= looks, "{times:?} in {looks}");
}

/// The libraries read the system's clock in one place, which is left out on targets without a clock.
#[test]
fn no_library_reads_another_clock() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let names = "brdf lighting lobe-core pictures ray-tracing reference render-cpu render-gpu renderer scene sphere-sets \
                 visibility-mask visibility-rays visibility-shadowmap visibility-silhouettes visibility-spheres";
    let mut found = Vec::new();
    let mut folders: Vec<_> = names.split_whitespace().map(|name| root.join(name).join("src")).collect();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("a folder").flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let text = fs::read_to_string(&path).unwrap_or_default();
            // Tests may measure: files of tests have names that end so, and tests inside a file are at its end.
            let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
            let is_test = path.file_stem().is_some_and(|stem| stem.to_string_lossy().ends_with("tests"));
            if !is_test && ["Instant::now", "SystemTime::now"].iter().any(|clock| code.contains(clock)) {
                found.push(path.strip_prefix(&root).unwrap_or(&path).to_owned());
            }
        }
    }
    assert_eq!(found, [Path::new("scene/src/clock.rs")]);
}
