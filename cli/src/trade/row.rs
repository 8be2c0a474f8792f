use super::setting::Setting;
use super::stage::{Shot, Stage};
use super::truth::Truth;
use crate::failure::Failure;
use cosine_lobes::checksum;
use serde::{Deserialize, Serialize};

/// One measured setting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Row {
    pub(super) scene: String,
    pub(super) method: String,
    pub(super) visibility: String,
    pub(super) device: String,
    /// Null where the method has none.
    pub(super) tolerance: Option<f64>,
    pub(super) depth: Option<u32>,
    pub(super) spp: Option<u32>,
    /// Shading of one frame, visible points given: the median.
    pub(super) seconds: f64,
    /// The upper quartile less the lower one.
    pub(super) spread: f64,
    pub(super) quartiles: [f64; 2],
    pub(super) repeats: usize,
    /// The same with finding the visible points, and shadow maps where there are some.
    pub(super) frame_seconds: f64,
    /// Error as fractions of each pixel's own radiance.
    #[serde(default)]
    pub(super) own_mean: f64,
    #[serde(default)]
    pub(super) own_p99: f64,
    /// Error in penumbra, as fractions of the unshadowed radiance.
    pub(super) mean: f64,
    pub(super) p99: f64,
    /// Of the whole picture.
    pub(super) flip: f64,
    /// No other row is both faster and nearer to the reference.
    #[serde(default)]
    pub(super) front: bool,
    /// The stamp of the measurement: scene, options, version.
    pub(super) stamp: String,
    /// Of all other values but `front`, as JSON.
    #[serde(default)]
    pub(super) checksum: String,
}

impl Row {
    pub(super) fn new(
        scene: &str,
        setting: &Setting,
        shot: &Shot,
        stage: &Stage<'_>,
        truth: &Truth,
        stamp: &str,
    ) -> Result<Self, Failure> {
        let ([own, error], flip) = truth.compare(&stage.picture(&shot.radiance), stage.exposure())?;
        let quartiles = [shot.at(0.25), shot.at(0.75)];
        let seconds = shot.at(0.5);
        Ok(Self {
            scene: scene.to_owned(),
            method: setting.method.clone(),
            visibility: setting.visibility.clone(),
            device: setting.device_name.clone(),
            tolerance: setting.tolerance.map(decimal),
            depth: setting.depth,
            spp: setting.spp,
            seconds,
            spread: quartiles[1] - quartiles[0],
            quartiles,
            repeats: shot.seconds.len(),
            frame_seconds: seconds + stage.gbuffer_seconds() + shot.map_seconds,
            own_mean: own.mean,
            own_p99: own.p99,
            mean: error.mean,
            p99: error.p99,
            flip,
            front: false,
            stamp: stamp.to_owned(),
            checksum: String::new(),
        })
    }

    /// The checksum that it should have.
    pub(super) fn sum(&self) -> String {
        let plain = Self { front: false, checksum: String::new(), ..self.clone() };
        checksum(serde_json::to_string(&plain).unwrap_or_default().as_bytes())
    }

    /// Whether it belongs to this setting.
    pub(super) fn is(&self, setting: &Setting) -> bool {
        self.method == setting.method
            && self.visibility == setting.visibility
            && self.device == setting.device_name
            && self.tolerance == setting.tolerance.map(decimal)
            && (self.depth, self.spp) == (setting.depth, setting.spp)
    }

    /// The technique: one line or curve of a plot.
    pub(super) fn technique(&self) -> String {
        let device = if self.device == "cpu" { "" } else { " / gpu" };
        format!("{} / {}{device}", self.method, self.visibility)
    }

    /// The values of the settings.
    pub(super) fn knobs(&self) -> String {
        match (self.tolerance, self.depth, self.spp) {
            (Some(t), Some(d), _) => format!("{} %, depth {d}", decimal((100.0 * t) as f32)),
            (None, Some(d), _) => format!("depth {d}"),
            (.., Some(n)) => format!("{n} samples"),
            _ => String::new(),
        }
    }

    pub(super) fn sentence(&self) -> String {
        let (ms, own) = (1e3 * self.seconds, 100.0 * self.own_mean);
        let [mean, p99] = [self.mean, self.p99].map(|error| 100.0 * error);
        format!(
            "{} at {}: {ms:.2} ms, of own radiance mean {own:.3} %, penumbra mean {mean:.3} %, 99 % {p99:.3} % of unshadowed",
            self.technique(),
            self.knobs()
        )
    }
}

/// Marks the rows that no other one beats in time and error: the Pareto front.
pub(super) fn mark_front(rows: &mut [Row]) {
    let beaten =
        |a: &Row, b: &Row| b.seconds <= a.seconds && b.mean <= a.mean && (b.seconds < a.seconds || b.mean < a.mean);
    let marks: Vec<bool> = rows.iter().map(|a| !rows.iter().any(|b| beaten(a, b))).collect();
    rows.iter_mut().zip(marks).for_each(|(row, mark)| row.front = mark);
}

/// The number as it was typed, not with the digits that f64 adds to an f32.
fn decimal(x: f32) -> f64 {
    x.to_string().parse().unwrap_or(f64::from(x))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A row of which only time and error matter.
    pub(crate) fn row(method: &str, seconds: f64, mean: f64) -> Row {
        Row {
            scene: "scene".into(),
            method: method.into(),
            visibility: "spheres".into(),
            device: "cpu".into(),
            tolerance: Some(0.01),
            depth: Some(4),
            spp: None,
            seconds,
            spread: 0.1 * seconds,
            quartiles: [0.95 * seconds, 1.05 * seconds],
            repeats: 3,
            frame_seconds: 2.0 * seconds,
            own_mean: 2.0 * mean,
            own_p99: 6.0 * mean,
            mean,
            p99: 3.0 * mean,
            flip: 0.01,
            front: false,
            stamp: "1".into(),
            checksum: String::new(),
        }
    }

    #[test]
    fn the_front_is_what_nothing_beats() {
        let mut rows =
            [row("a", 1.0, 0.5), row("b", 2.0, 0.4), row("c", 3.0, 0.45), row("d", 2.0, 0.4), row("e", 9.0, 0.1)];
        mark_front(&mut rows);
        assert_eq!(rows.map(|r| r.front), [true, true, false, true, true]);
    }
}
