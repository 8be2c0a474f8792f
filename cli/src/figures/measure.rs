//! Timing of frames whose visible points are given.
//!
//! Shared with `examples/results_table`.

use cosine_lobes::paper::{PaperIntegrator, PaperVisibility, Tables};
use cosine_lobes::render_cpu::CpuShader;
use cosine_lobes::scene::{BlockerSet, Frame, Scene, Shade, ShadeStats, ShadingPoints};
use cosine_lobes::shading::{Accuracy, Integrator, Visibility};
use cosine_lobes::visibility_mask::MaskVisibility;
use cosine_lobes::visibility_spheres::SphereBlockers;
use glam::Vec3;
use std::time::{Duration, Instant};

/// The default tolerance and the depth that it asks for, which is the paper's.
pub(crate) const TOLERANCE: f32 = 0.005;
pub(crate) const DEPTH: u32 = 5;

/// The settings of a frame's shading.
#[derive(Clone, Copy, Default)]
pub(crate) struct How<'t> {
    /// The paper's `t_i`.
    pub(crate) threshold: f32,
    /// With tables by the paper's method, else by moments.
    pub(crate) tables: Option<&'t Tables>,
}

/// Repeated frames.
pub(crate) struct Timing {
    pub(crate) points: usize,
    /// The frame of median time.
    pub(crate) stats: ShadeStats,
    /// All frames together.
    sum: ShadeStats,
    /// The shortest time: the one with the least disturbance by other programs.
    pub(crate) best: f64,
    /// Processor seconds of a frame, summed over its threads, where the system reports them. Other programs do not
    /// change them.
    pub(crate) processor: Option<f64>,
    /// Quartiles of the time.
    pub(crate) quartiles: [f64; 2],
}

impl Timing {
    /// Point–light pairs: their number, and the fractions of them in penumbra and in the dark.
    pub(crate) fn shares(&self) -> [f64; 3] {
        let c = self.stats.counts;
        let pairs = (c.lit_points + c.dark_points + c.penumbra_points).max(1) as f64;
        [pairs, c.penumbra_points as f64 / pairs, c.dark_points as f64 / pairs]
    }

    /// Milliseconds a frame, with quartiles.
    pub(crate) fn milliseconds(&self) -> String {
        let [middle, low, high] = [self.stats.seconds, self.quartiles[0], self.quartiles[1]].map(|s| 1e3 * s);
        // Two digits and more.
        let digits = if middle < 10.0 { 2 } else { usize::from(middle < 100.0) };
        format!("{middle:.digits$} ({low:.digits$}–{high:.digits$})")
    }

    /// Milliseconds on processors a frame, all threads together.
    pub(crate) fn processor_milliseconds(&self) -> String {
        self.processor.map_or_else(|| "–".to_owned(), |s| format!("{:.2}", 1e3 * s))
    }

    /// Processor milliseconds of a frame, or the shortest time where the system does not report them. Costs are compared by this number.
    pub(crate) fn cost(&self) -> f64 {
        1e3 * self.processor.unwrap_or(self.best)
    }

    /// Per cent of each stage, in Table 1's order.
    pub(crate) fn stages(&self) -> [f64; 5] {
        let s = self.sum.stages;
        let seconds = [s.reflectance, s.lighting, s.mask, s.visibility_lobes, s.integration];
        let all = seconds.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        seconds.map(|s| 100.0 * s / all)
    }
}

/// No scene is repeated for longer, once there are three frames.
const LONGEST: Duration = Duration::from_secs(4);

/// The blockers, in the form that the shaders take.
pub(crate) fn spheres(blockers: &BlockerSet) -> SphereBlockers {
    SphereBlockers::new(&blockers.spheres, &blockers.objects, &blockers.self_distances)
        .with_self_shadows(&blockers.self_shadows)
}

/// Shades once to warm up, then `repeats` times; the radiance as well.
pub(crate) fn frames(
    scene: &Scene,
    blockers: &BlockerSet,
    points: &ShadingPoints,
    how: How<'_>,
    repeats: usize,
) -> Result<(Timing, Vec<Vec3>), String> {
    let spheres = spheres(blockers);
    match how.tables {
        None => repeat(CpuShader::new(MaskVisibility::new(spheres)), scene, points, how.threshold, repeats),
        Some(tables) => {
            let visibility = PaperVisibility::new(spheres, tables);
            repeat(
                CpuShader::with_integrator(visibility, PaperIntegrator { tables }),
                scene,
                points,
                how.threshold,
                repeats,
            )
        }
    }
}

fn repeat<V: Visibility, I: Integrator<V>>(
    mut shader: CpuShader<V, I>,
    scene: &Scene,
    points: &ShadingPoints,
    threshold: f32,
    repeats: usize,
) -> Result<(Timing, Vec<Vec3>), String> {
    let accuracy = Accuracy { tolerance: TOLERANCE, depth: DEPTH };
    let frame = Frame { materials: &scene.materials, lights: &scene.lights, accuracy, threshold };
    let mut out = vec![Vec3::ZERO; points.receivers.len()];
    let mut runs = Vec::with_capacity(repeats);
    shader.shade(points, &frame, &mut out).map_err(|e| e.to_string())?;
    let (start, before) = (Instant::now(), processor_seconds());
    while runs.len() < repeats && (runs.len() < 3 || start.elapsed() < LONGEST) {
        runs.push(shader.shade(points, &frame, &mut out).map_err(|e| e.to_string())?);
    }
    let spent = processor_seconds().zip(before).map(|(after, before)| (after - before) / runs.len() as f64);
    let mut sum = ShadeStats::default();
    runs.iter().for_each(|run| sum += *run);
    runs.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    let at = |share: f64| runs[((runs.len() - 1) as f64 * share).round() as usize];
    let timing = Timing {
        points: points.receivers.len(),
        stats: at(0.5),
        sum,
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
