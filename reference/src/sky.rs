//! An environment's picture, sampled by its brightness, in f64.

use core::f64::consts::{PI, TAU};
use glam::{DVec3, Vec3};
use lighting::EnvironmentMap;

/// Draws directions of a picture of all directions, by a row and a place in it.
#[derive(Debug)]
pub(crate) struct Sky<'a> {
    map: &'a EnvironmentMap,
    width: usize,
    height: usize,
    /// Cumulative weights of the rows, and in each row of the texels.
    rows: Vec<f64>,
    texels: Vec<f64>,
}

impl<'a> Sky<'a> {
    pub(crate) fn new(map: &'a EnvironmentMap) -> Self {
        let [width, height] = map.size().to_array().map(|n| n as usize);
        let bright = |x: usize, y: usize| f64::from(map.texels()[y * width + x].element_sum());
        let (mut rows, mut texels) = (Vec::with_capacity(height), Vec::with_capacity(width * height));
        let mut all = 0.0;
        for y in 0..height {
            let (mut row, solid) = (0.0, f64::from(map.solid_angle(y as u32)));
            for x in 0..width {
                // Radiance between texels is as bright as a neighbour, at most.
                let columns = [(x + width - 1) % width, x, (x + 1) % width];
                let near = [y.saturating_sub(1), y, (y + 1).min(height - 1)];
                let most = near.iter().flat_map(|y| columns.map(|x| bright(x, *y))).fold(0.0, f64::max);
                row += most * solid;
                texels.push(row);
            }
            all += row;
            rows.push(all);
        }
        Self { map, width, height, rows, texels }
    }

    pub(crate) fn is_black(&self) -> bool {
        self.rows.last().is_none_or(|all| *all <= 0.0)
    }

    pub(crate) fn radiance(&self, v: DVec3) -> Vec3 {
        self.map.radiance(v.as_vec3())
    }

    /// A direction and its density per steradian.
    pub(crate) fn sample(&self, u: f64, v: f64) -> (DVec3, f64) {
        let (y, down) = pick(&self.rows, u);
        let row = &self.texels[y * self.width..(y + 1) * self.width];
        let (x, across) = pick(row, v);
        let cos = |y: usize| (y as f64 / self.height as f64 * PI).cos();
        let angle = (cos(y) + (cos(y + 1) - cos(y)) * down).clamp(-1.0, 1.0).acos();
        let place = [(x as f64 + across) as f32, (angle / PI * self.height as f64) as f32];
        (self.map.direction(place[0], place[1]).as_dvec3().normalize(), self.density(x, y))
    }

    /// The density with which a direction is drawn.
    pub(crate) fn pdf(&self, v: DVec3) -> f64 {
        let [x, y] = self.map.place(v.as_vec3()).to_array();
        let x = (f64::from(x) * self.width as f64).max(0.0) as usize;
        let y = (f64::from(y) * self.height as f64).max(0.0) as usize;
        self.density(x.min(self.width - 1), y.min(self.height - 1))
    }

    fn density(&self, x: usize, y: usize) -> f64 {
        let row = &self.texels[y * self.width..(y + 1) * self.width];
        let weight = row[x] - if x > 0 { row[x - 1] } else { 0.0 };
        let cos = |y: usize| (y as f64 / self.height as f64 * PI).cos();
        let solid = (cos(y) - cos(y + 1)) * TAU / self.width as f64;
        weight / (self.rows[self.height - 1] * solid)
    }
}

/// The step of a rising sequence that contains a fraction of its end, and the position in that step.
fn pick(sums: &[f64], part: f64) -> (usize, f64) {
    let at = part * sums[sums.len() - 1];
    let i = sums.partition_point(|sum| *sum <= at).min(sums.len() - 1);
    let before = if i > 0 { sums[i - 1] } else { 0.0 };
    let step = sums[i] - before;
    (i, if step > 0.0 { ((at - before) / step).clamp(0.0, 1.0) } else { 0.5 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::UVec2;

    /// Directions and densities agree, and the mean over samples is the integral.
    #[test]
    fn samples_weigh_what_the_picture_shows() {
        let size = UVec2::new(16, 8);
        let texels = (0..128).map(|k| Vec3::new(if k == 37 { 100.0 } else { (k % 7) as f32 }, 1.0, 0.0)).collect();
        let map = EnvironmentMap::new(size, texels).expect("a picture").turned(Vec3::new(0.3, 1.0, 0.2), 40.0);
        let sky = Sky::new(&map);
        let n = 300;
        let at = |k: usize| (k as f64 + 0.5) / n as f64;
        let (mut sum, mut solid) = (DVec3::ZERO, 0.0);
        for k in 0..n * n {
            let (v, pdf) = sky.sample(at(k % n), at(k / n));
            let other = sky.pdf(v);
            // On the line between two texels it may be either's.
            assert!((other / pdf - 1.0).abs() < 1e-6 || k % 97 != 0, "{other} {pdf}");
            sum += sky.radiance(v).as_dvec3() / pdf;
            solid += 1.0 / pdf;
        }
        let m = 800;
        let mut want = DVec3::ZERO;
        for k in 0..m * m {
            let (z, phi) = (2.0 * ((k % m) as f64 + 0.5) / m as f64 - 1.0, TAU * ((k / m) as f64 + 0.5) / m as f64);
            let s = (1.0 - z * z).sqrt();
            want += sky.radiance(DVec3::new(s * phi.cos(), z, s * phi.sin())).as_dvec3();
        }
        let (got, want) = (sum / (n * n) as f64, want * 2.0 * TAU / (m * m) as f64);
        assert!((got - want).abs().max_element() < 5e-3 * want.x, "{got} {want}");
        assert!((solid / (n * n) as f64 / (2.0 * TAU) - 1.0).abs() < 1e-2);
    }
}
