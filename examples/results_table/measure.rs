//! Timing of frames whose visible points are given.

use crate::scenes::Case;
use cosine_lobes::lobe_core::Accuracy;
use cosine_lobes::render_cpu::CpuShader;
use cosine_lobes::scene::{BlockerSet, Frame, Scene, Shade, ShadeStats, ShadingPoints};
use cosine_lobes::visibility_mask::MaskVisibility;
use cosine_lobes::visibility_spheres::SphereBlockers;
use cosine_lobes::{Output, Picture, srgb_bytes, write_png};
use glam::Vec3;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// The default tolerance and the depth that it asks for, which is the paper's.
pub(crate) const TOLERANCE: f32 = 0.005;
pub(crate) const DEPTH: u32 = 5;

/// A timed scene.
pub(crate) struct Row {
    pub(crate) name: &'static str,
    pub(crate) note: &'static str,
    pub(crate) paper: &'static str,
    pub(crate) target: f64,
    pub(crate) spheres: usize,
    pub(crate) lights: usize,
    pub(crate) timing: Timing,
}

/// Repeated frames.
pub(crate) struct Timing {
    pub(crate) points: usize,
    /// The frame of median time.
    pub(crate) stats: ShadeStats,
    /// The shortest time: the one that others on the machine disturbed least.
    pub(crate) best: f64,
    /// Seconds that the threads spent on a processor a frame, all together, where the system tells: what others on the machine do
    /// is not in it.
    pub(crate) processor: Option<f64>,
    /// Quartiles of the time.
    pub(crate) quartiles: [f64; 2],
}

impl Timing {
    /// Point–light pairs: their number, and what share of them lies in penumbra and in the dark.
    pub(crate) fn shares(&self) -> [f64; 3] {
        let c = self.stats.counts;
        let pairs = (c.lit_points + c.dark_points + c.penumbra_points).max(1) as f64;
        [pairs, c.penumbra_points as f64 / pairs, c.dark_points as f64 / pairs]
    }

    /// Seconds of each stage, in Table 1's order.
    pub(crate) fn stages(&self) -> [f64; 5] {
        let s = self.stats.stages;
        [s.reflectance, s.lighting, s.mask, s.visibility_lobes, s.integration]
    }
}

pub(crate) fn row(case: &Case, repeats: usize, pictures: Option<&Path>) -> Result<Row, String> {
    let (scene, blockers, gbuffer) = case.make();
    let (timing, radiance) = frames(&scene, &blockers, &gbuffer.points, case.threshold, repeats)?;
    if let Some(folder) = pictures {
        let name = case.name.replace(|c: char| !c.is_alphanumeric(), "");
        let picture =
            Picture::new(gbuffer.width as usize, gbuffer.height as usize, gbuffer.resolve(&radiance, Vec3::ZERO));
        let write = |path: PathBuf| {
            let output = Output::create(path)?;
            write_png(output, picture.width(), picture.height(), &srgb_bytes(&picture, 0.0))
        };
        write(folder.join(format!("{name}.png"))).map_err(|e| e.to_string())?;
    }
    Ok(Row {
        name: case.name,
        note: case.note,
        paper: case.paper,
        target: case.target,
        spheres: blockers.spheres.len(),
        lights: scene.lights.len(),
        timing,
    })
}

/// No row is repeated for longer, once there are three frames.
const LONGEST: Duration = Duration::from_secs(4);

/// Shades once to warm up, then `repeats` times; the radiance as well.
pub(crate) fn frames(
    scene: &Scene,
    blockers: &BlockerSet,
    points: &ShadingPoints,
    threshold: f32,
    repeats: usize,
) -> Result<(Timing, Vec<Vec3>), String> {
    let spheres = SphereBlockers::new(&blockers.spheres, &blockers.objects, &blockers.self_distances)
        .with_self_shadows(&blockers.self_shadows);
    let mut shader = CpuShader::new(MaskVisibility::new(spheres));
    let frame = Frame {
        materials: &scene.materials,
        lights: &scene.lights,
        accuracy: Accuracy { tolerance: TOLERANCE, depth: DEPTH },
        threshold,
    };
    let mut out = vec![Vec3::ZERO; points.receivers.len()];
    let mut runs = Vec::with_capacity(repeats);
    shader.shade(points, &frame, &mut out).map_err(|e| e.to_string())?;
    let (start, before) = (Instant::now(), processor_seconds());
    while runs.len() < repeats && (runs.len() < 3 || start.elapsed() < LONGEST) {
        runs.push(shader.shade(points, &frame, &mut out).map_err(|e| e.to_string())?);
    }
    let spent = processor_seconds().zip(before).map(|(after, before)| (after - before) / runs.len() as f64);
    runs.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    let at = |share: f64| runs[((runs.len() - 1) as f64 * share).round() as usize];
    let timing = Timing {
        points: points.receivers.len(),
        stats: at(0.5),
        best: at(0.0).seconds,
        processor: spent,
        quartiles: [at(0.25).seconds, at(0.75).seconds],
    };
    Ok((timing, out))
}

/// Seconds on a processor of all threads so far, to the nanosecond (Linux).
fn processor_seconds() -> Option<f64> {
    let nanoseconds = |folder: std::fs::DirEntry| {
        let text = std::fs::read_to_string(folder.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<u64>().ok()
    };
    let all: u64 = std::fs::read_dir("/proc/self/task").ok()?.flatten().filter_map(nanoseconds).sum();
    (all > 0).then_some(all as f64 * 1e-9)
}
