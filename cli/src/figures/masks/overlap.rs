//! Fig. 11: how lobes of a cover overlap.

use super::super::canvas::Draw;
use super::super::chart::{Axis, Chart, Curve};
use super::super::gallery::Page;
use super::super::studio::Studio;
use crate::failure::Failure;
use cosine_lobes::lobe_core::{Cone, Lobe, Sphere};
use cosine_lobes::paper::PaperWeights;
use glam::Vec3;
use plotters::prelude::SeriesLabelPosition;

/// Some of the distances at which the paper tabulates weights.
const DISTANCES: [f32; 4] = [0.25, 1.0, 3.0, 10.0];

pub(in crate::figures) fn overlap(name: &str, studio: &mut Studio) -> Result<Page, Failure> {
    const LEVEL: u32 = 3;
    let tables = studio.tables()?;
    let weights = PaperWeights::solve(5, &tables);
    let mut curves = Vec::new();
    let mut rows = String::new();
    let side = 1_u32 << LEVEL;
    for (k, dist) in DISTANCES.into_iter().enumerate() {
        let tan = 0.5 / dist;
        // The lobes of all nodes of a level, as method `paper` makes them.
        let node = |i: u32| {
            let place = |k: u32| 2.0 * tan * ((k as f32 + 0.5) / side as f32 - 0.5);
            let center = Vec3::new(place(i % side), place(i / side), 1.0);
            let radius = core::f32::consts::SQRT_2 * tan / side as f32;
            tables.caps.occluder(&Cone::of_sphere(Vec3::ZERO, Sphere { center, radius }))
        };
        let cover: Vec<Lobe> = (0..side * side).map(node).collect();
        let sum = |x: f32| {
            let direction = Vec3::new(2.0 * tan * x, 0.0, 1.0).normalize();
            f64::from(cover.iter().map(|lobe| lobe.eval(direction).x).sum::<f32>())
        };
        let along = (-120..=120).map(|i| i as f32 / 200.0).map(|x| (f64::from(x), sum(x))).collect();
        curves.push(Curve::line(format!("dist {dist}"), k, along));
        let level = |l: u32| weights.weight(l, dist);
        rows += &format!(
            "\n| {dist} | {:.1}° | {:.2} | {:.2} | {:.3} | {:.3} | {:.3} |",
            tan.atan().to_degrees(),
            sum(0.0),
            sum(0.4375),
            level(1),
            level(LEVEL),
            level(5)
        );
    }
    let chart = Chart {
        title: "Sum of the lobes of a whole cover (64 nodes of level 3)",
        x: Axis::linear("place on the unit square, along its middle", -0.6..0.6),
        y: Axis::linear("sum of the lobes, without weights", 0.0..2.7),
        curves,
        key: SeriesLabelPosition::LowerMiddle,
    };
    Ok(Page {
        title: "overlap of lobes by distance",
        images: chart.images(name)?,
        shows: "The same mask, wholly covered by nodes of one level, with the unit square at several distances. Where lobes overlap their sum \
                is above 1; it changes with the distance, since lobes are functions of directions and not of places on the square."
            .into(),
        paper: "The overlap varies with dist even for the same mask, so weights w_i depend on dist and on the depth of a leaf; they are fixed \
                by eye for twelve values of dist (Fig. 11, §5.3)."
            .into(),
        here: format!(
            "Weights are solved for here, so that a light covered by nodes of one level is dark.\n\n| dist | light's half-angle | sum in the \
             middle | sum at the rim | w at level 1 | w at level {LEVEL} | w at level 5 |\n|---|---|---|---|---|---|---|{rows}"
        ),
        differs: "The paper's weights are not printed.".into(),
    })
}
