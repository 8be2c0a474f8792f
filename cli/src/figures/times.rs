//! Fig. 17 and 20, and Table 1: where the time goes.

use super::canvas::Draw;
use super::chart::{Axis, Chart, Curve};
use super::gallery::Page;
use super::measure::{How, Timing, frames};
use super::scenes::{Case, cube, far_light, spiral_lights};
use super::studio::Studio;
use crate::failure::Failure;
use cosine_lobes::lighting::Light;
use cosine_lobes::paper::Tables;
use cosine_lobes::render_cpu::{GBuffer, World};
use plotters::prelude::SeriesLabelPosition;

/// Pixels a side.
const SIDE: u32 = 160;
const METHODS: [&str; 2] = ["moments", "paper"];
/// Frames that Table 1 is measured in.
const FRAMES: [usize; 2] = [60, 9];

fn of(method: usize, tables: &Tables) -> How<'_> {
    How { tables: (method == 1).then_some(tables), ..How::default() }
}

/// The cube under these lights, by a method.
fn cube_time(lights: Vec<Light>, how: How<'_>) -> Result<Timing, Failure> {
    let (scene, blockers) = cube(lights);
    let points = GBuffer::new(&World::new(&scene), SIDE, SIDE, 1).points;
    frames(&scene, &blockers, &points, how, 9).map(|(timing, _)| timing).map_err(Failure::new)
}

/// Processor milliseconds over a number, for both methods, and the fraction of points in penumbra.
struct Series {
    numbers: Vec<f64>,
    times: [Vec<f64>; 2],
    penumbra: Vec<f64>,
}

impl Series {
    fn measure(numbers: &[f64], tables: &Tables, lights: impl Fn(f64) -> Vec<Light>) -> Result<Self, Failure> {
        let mut series = Self { numbers: numbers.to_vec(), times: [const { Vec::new() }; 2], penumbra: Vec::new() };
        for number in numbers {
            for method in 0..2 {
                let timing = cube_time(lights(*number), of(method, tables))?;
                series.times[method].push(timing.cost());
                if method == 0 {
                    series.penumbra.push(100.0 * timing.shares()[1]);
                }
            }
        }
        Ok(series)
    }

    /// Times over the first one.
    fn relative(&self, method: usize) -> impl Iterator<Item = f64> {
        self.times[method].iter().map(move |t| t / self.times[method][0])
    }

    fn curves(&self) -> Vec<Curve> {
        let curve = |method: usize| {
            let points = self.numbers.iter().copied().zip(self.relative(method)).collect();
            Curve::dots(format!("method {}", METHODS[method]), method, points)
        };
        vec![curve(0), curve(1)]
    }

    fn rows(&self) -> String {
        let [moments, paper] = [0, 1].map(|method| self.relative(method).collect::<Vec<_>>());
        let row = |i: usize| {
            format!(
                "\n| {} | {:.1} % | {:.2} ({:.2} ×) | {:.1} ({:.2} ×) |",
                self.numbers[i], self.penumbra[i], self.times[0][i], moments[i], self.times[1][i], paper[i]
            )
        };
        (0..self.numbers.len()).map(row).collect()
    }

    /// The part of the times' variance that a straight line explains, in per cent.
    fn linearity(&self, method: usize) -> f64 {
        let n = self.numbers.len() as f64;
        let mean = |values: &[f64]| values.iter().sum::<f64>() / n;
        let (x, y) = (mean(&self.numbers), mean(&self.times[method]));
        let product = |f: &dyn Fn(f64, f64) -> f64| {
            self.numbers.iter().zip(&self.times[method]).map(|(a, b)| f(a - x, b - y)).sum::<f64>()
        };
        100.0 * product(&|a, b| a * b).powi(2)
            / (product(&|a, _| a * a) * product(&|_, b| b * b)).max(f64::MIN_POSITIVE)
    }
}

pub(super) fn by_area(name: &str, studio: &mut Studio) -> Result<Page, Failure> {
    let tables = studio.tables()?;
    let series =
        Series::measure(&[0.5, 45.8, 91.1, 136.4, 181.7, 227.0], &tables, |area| vec![far_light(area as f32)])?;
    let most = series.relative(0).chain(series.relative(1)).fold(3.0, f64::max);
    let chart = Chart {
        title: "Time of a frame by the area of the light",
        x: Axis::linear("area of the light, m²", 0.0..230.0),
        y: Axis::linear("time over that of the smallest light", 0.0..1.1 * most),
        curves: series.curves(),
        key: SeriesLabelPosition::LowerRight,
    };
    Ok(Page {
        title: "time by area of the light",
        images: chart.images(name)?,
        shows: "A cube as 64 spheres over a floor. The light, 20 units away, grows: more points lie in penumbra.".into(),
        paper: "Time grows nearly linearly with the area, between 450 and 1200 ms on the axis, a ratio of at most 2.7, for areas of 0.5 to 227 m² \
                (Fig. 17)."
            .into(),
        here: format!(
            "{} points, milliseconds on processors:\n\n| area | penumbra | `moments` | `paper` |\n|---|---|---|---|{}\n\nA straight line explains {:.0} % of the \
             variance with `moments`, {:.0} % with `paper`.",
            SIDE * SIDE,
            series.rows(),
            series.linearity(0),
            series.linearity(1)
        ),
        differs: "The paper tests all spheres at every point, for any light; here a point that nothing can shade costs next to nothing, so the \
                  ratio is larger. The paper's cube moves and its lights are placed at random, in a scene of its own; its distances and its values between the ends \
                  of the axis are not given."
            .into(),
    })
}

pub(super) fn by_lights(name: &str, studio: &mut Studio) -> Result<Page, Failure> {
    let tables = studio.tables()?;
    let series = Series::measure(&[1.0, 4.0, 12.0, 25.0, 50.0], &tables, |count| spiral_lights(count as usize))?;
    let most = series.relative(0).chain(series.relative(1)).fold(50.0, f64::max);
    let chart = Chart {
        title: "Time of a frame by the number of lights",
        x: Axis::linear("lights", 0.0..52.0),
        y: Axis::linear("time over that of one light", 0.0..1.1 * most),
        curves: series.curves(),
        key: SeriesLabelPosition::LowerRight,
    };
    Ok(Page {
        title: "time by number of lights",
        images: chart.images(name)?,
        shows: "The cube of Fig. 21 under 1 to 50 spherical lights.".into(),
        paper: "Time is linear in the number of lights; the axis ends at 800 ms and 50 lights (Fig. 20, §6).".into(),
        here: format!(
            "{} points, milliseconds on processors:\n\n| lights | penumbra | `moments` | `paper` |\n|---|---|---|---|{}\n\nA straight line explains {:.1} % of the \
             variance with `moments`, {:.1} % with `paper`.",
            SIDE * SIDE,
            series.rows(),
            series.linearity(0),
            series.linearity(1)
        ),
        differs: "The paper's number of points and its lights are not given.".into(),
    })
}

/// Table 1 of the paper: per cent of the time, (a) to (e).
const TABLE: [(&str, [f64; 5]); 4] = [
    ("13", [2.1, 1.5, 84.8, 4.5, 7.1]),
    ("22(a)", [3.6, 4.7, 72.2, 9.1, 10.4]),
    ("22(b)", [2.5, 3.5, 60.1, 14.4, 19.5]),
    ("22(c)", [2.7, 2.5, 52.1, 18.2, 24.5]),
];
const STAGES: [&str; 5] = ["reflectance", "lighting", "mask", "visibility lobes", "integration"];

pub(super) fn by_stage(name: &str, studio: &mut Studio) -> Result<Page, Failure> {
    let tables = studio.tables()?;
    let mut bars: Vec<(String, [f64; 5])> = Vec::new();
    let (mut rows, mut masks) = (String::new(), Vec::new());
    let row = |rows: &mut String, figure: &str, who: &str, shares: &[f64; 5]| {
        *rows += &format!("\n| {figure} | {who} |");
        shares.iter().for_each(|share| *rows += &format!(" {share:.1} |"));
    };
    for (k, (figure, paper)) in TABLE.iter().enumerate() {
        let case = if k == 0 { Case::fig13() } else { Case::fig22(k - 1) };
        let (scene, blockers, gbuffer) = case.make(&studio.model(case.spheres)?);
        let points = case.counted(gbuffer.points);
        row(&mut rows, figure, "the paper", paper);
        bars.push((format!("Fig. {figure}, the paper"), *paper));
        for method in [1, 0] {
            let (timing, _) =
                frames(&scene, &blockers, &points, of(method, &tables), FRAMES[method]).map_err(Failure::new)?;
            row(&mut rows, figure, &format!("`{}`", METHODS[method]), &timing.stages());
            bars.push((format!("method {}", METHODS[method]), timing.stages()));
            if method == 1 {
                masks.push(timing.stages()[2]);
            }
        }
    }
    Ok(Page {
        title: "time by stage",
        images: super::bars::Bars { stages: STAGES, bars }.images(name)?,
        shows: "The fraction of a frame's time that each stage takes: (a) lobes of reflectance, (b) lighting, (c) visibility masks, \
                (d) visibility lobes, (e) products and integrals."
            .into(),
        paper: "Masks take most of it, 52 to 85 %, and their share falls as penumbrae grow (Table 1, §6).".into(),
        here: format!(
            "Per cent, on {} threads:\n\n| Fig. | | (a) | (b) | (c) | (d) | (e) |\n|---|---|---|---|---|---|---|{rows}\n\nMethod `moments` makes no \
             visibility lobes: its (d) is the visible fraction. With `paper` the fraction of masks goes from {:.0} % in 22(a) to {:.0} % in 22(c).",
            rayon::current_num_threads(),
            masks[1],
            masks[3]
        ),
        differs: "The paper's shares are of a GPU and its CPU, ours of a CPU, where one group of points in 32 is timed.".into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_linear_and_parabolas_are_not() {
        let series = |f: fn(f64) -> f64| {
            let numbers: Vec<f64> = (0..9).map(f64::from).collect();
            let times = numbers.iter().map(|x| f(*x)).collect::<Vec<_>>();
            Series { numbers, times: [times.clone(), times], penumbra: vec![0.0; 9] }
        };
        assert!((series(|x| 3.0 + 2.0 * x).linearity(0) - 100.0).abs() < 1e-9);
        assert!(series(|x| (x - 4.0).powi(2)).linearity(1) < 1e-9);
    }

    #[test]
    fn the_paper_s_shares_add_up() {
        for (figure, shares) in TABLE {
            assert!((shares.iter().sum::<f64>() - 100.0).abs() < 0.11, "{figure}");
        }
    }
}
