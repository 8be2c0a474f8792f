//! The paper's scenes, timed, and their targets.

use crate::measure::{How, Timing, frames};
use crate::models::Models;
use crate::scenes::Case;
use cosine_lobes::{Output, Picture, srgb_bytes, write_png};
use glam::Vec3;
use std::path::Path;

/// One line of the table.
pub(crate) struct Line {
    pub(crate) name: &'static str,
    pub(crate) note: &'static str,
    /// The paper's figure.
    pub(crate) paper: &'static str,
    /// Target in frames a second; 0 without one.
    pub(crate) target: f64,
    pub(crate) case: Case,
    threshold: f32,
}

/// A timed scene.
pub(crate) struct Row {
    pub(crate) line: Line,
    pub(crate) spheres: usize,
    pub(crate) lights: usize,
    pub(crate) timing: Timing,
}

pub(crate) fn all() -> Vec<Line> {
    let line = |name, note, paper, target, case| Line { name, note, paper, target, case, threshold: 0.0 };
    vec![
        line("Fig. 13", "diffuse + Lafortune lobe, varying", "3.01 fps; mask 84.8 %", 250.0, Case::fig13()),
        line("Fig. 15", "glossy, t_i = 0", "products halved, +2 fps", 0.0, Case::fig15()),
        Line { threshold: 0.005, ..line("Fig. 15, t_i", "glossy, t_i = 0.5 %", "", 0.0, Case::fig15()) },
        line("Fig. 16", "56 cows, diffuse", "17.68 s a frame", 1.0 / 0.15, Case::fig16()),
        line("Fig. 18 left", "self-shadowing, small light", "4.5 fps", 120.0, Case::fig18(false)),
        line("Fig. 18 right", "self-shadowing, large light", "2.3 fps", 80.0, Case::fig18(true)),
        line("Fig. 22(a)", "diffuse, on the floor", "mask 72.2 %", 300.0, Case::fig22(0)),
        line("Fig. 22(b)", "diffuse, above the floor", "mask 60.1 %", 300.0, Case::fig22(1)),
        line("Fig. 22(c)", "diffuse, higher", "mask 52.1 %", 300.0, Case::fig22(2)),
    ]
}

pub(crate) fn measure(line: Line, models: &mut Models, repeats: usize, pictures: Option<&Path>) -> Result<Row, String> {
    eprintln!("{}", line.name);
    let (scene, blockers, mut gbuffer) = line.case.make(models.of(line.case.spheres)?);
    let points = line.case.counted(core::mem::take(&mut gbuffer.points));
    gbuffer.pixels.truncate(line.case.points);
    let how = How { threshold: line.threshold, tables: None };
    let (timing, radiance) = frames(&scene, &blockers, &points, how, repeats)?;
    if let Some(folder) = pictures {
        let name = line.name.replace(|c: char| !c.is_alphanumeric(), "");
        let pixels = gbuffer.resolve(&radiance, Vec3::ZERO);
        let picture = Picture::new(gbuffer.width as usize, gbuffer.height as usize, pixels);
        Output::create(folder.join(format!("{name}.png")))
            .and_then(|output| write_png(output, picture.width(), picture.height(), &srgb_bytes(&picture, 0.0)))
            .map_err(|e| e.to_string())?;
    }
    Ok(Row { spheres: blockers.spheres.len(), lights: scene.lights.len(), timing, line })
}
