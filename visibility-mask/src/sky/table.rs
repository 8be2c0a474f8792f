use super::meridians::{circle, elevation, row_number};
use super::{Meridians, Pole, SkyResolution};
use fearless_simd::{Simd, f32x8, prelude::*};
use glam::{DVec3, Vec3};
use lobe_core::vec3x8::{LANES, Vec3x8};
use rayon::prelude::*;

/// Places along a sample's side at which a sky is looked at, at most.
const FINEST: usize = 8;
/// From so many rows on one place does where texels are larger than samples.
const FINE: usize = 512;

/// Eight samples side by side: `∫ radiance dω` per channel, and unit directions in the world.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(32))]
pub(super) struct Cell([[f32; LANES]; 6]);

/// The light of a sky, sample by sample, for the meridians of each pole.
///
/// A sample holds its integral of radiance over its solid angle, times the length of the mean direction weighted by radiance, and that
/// direction's unit vector. So the sum over samples of `light · (n·direction)` is `∫ L(v) n·v dv` but for the samples that the horizon cuts.
///
/// # Cost
/// 24 bytes a sample and pole: 0.6 MB for 64 × 64, 1.2 MB for 128 × 64. Linear in the sky's texels, at least four looks a sample, on all
/// threads.
#[derive(Clone, Debug)]
pub struct SkyTable {
    meridians: Meridians,
    /// For each pole the samples of eight rows, then those of the next eight.
    cells: Vec<Vec<Cell>>,
    is_uneven: bool,
}

/// Skies whose brightest sample is brighter than the mean by more than this factor are uneven.
const UNEVEN: f32 = 4.0;
/// Nearer to the axis samples are too small to tell.
const LEAST_SIN: f32 = 0.1;

/// The light and the direction of one sample.
type Sample = [Vec3; 2];

impl SkyTable {
    /// Of a sky's radiance (W·m⁻²·sr⁻¹ per channel) in a direction of unit length, which is a picture of so many texels around or as smooth
    /// as one.
    #[must_use]
    pub fn new(resolution: SkyResolution, texels: u32, radiance: impl Fn(Vec3) -> Vec3 + Sync) -> Self {
        let meridians = Meridians::new(resolution);
        let (rows, samples) = (resolution.rows(), resolution.samples());
        let fewest = if rows >= FINE { 1 } else { 2 };
        let looks = |count: usize| (2 * texels as usize / count).clamp(fewest, FINEST);
        let looks = [looks(rows), looks(2 * samples)];
        // Opposite poles have the same samples in another order.
        let half: Vec<Vec<Sample>> = Pole::ALL[..3]
            .iter()
            .map(|pole| {
                let row = |j: usize| row_of(resolution, *pole, j, looks, &radiance);
                (0..rows).into_par_iter().flat_map_iter(row).collect()
            })
            .collect();
        let cells = (0..6).map(|pole| {
            let at = |row: usize, sample: usize| match pole {
                0..3 => half[pole][row * samples + sample],
                _ => half[pole - 3][mirrored(row, rows) * samples + (samples - 1 - sample)],
            };
            let mut cells = vec![Cell::default(); resolution.blocks() * samples];
            for (row, sample) in (0..rows).flat_map(|row| (0..samples).map(move |sample| (row, sample))) {
                let [light, direction] = at(row, sample).map(|v| v.to_array());
                let Cell(columns) = &mut cells[row / LANES * samples + sample];
                for (column, value) in columns.iter_mut().zip(light.into_iter().chain(direction)) {
                    column[row % LANES] = value;
                }
            }
            cells
        });
        let cells: Vec<Vec<Cell>> = cells.collect();
        Self { is_uneven: contrast(&cells) > UNEVEN, cells, meridians }
    }

    /// Whether a small part of the sky may give much of its light: how much light is seen does not tell then how much of the sky is.
    #[must_use]
    pub const fn is_uneven(&self) -> bool {
        self.is_uneven
    }

    /// Its meridians.
    #[must_use]
    pub const fn meridians(&self) -> &Meridians {
        &self.meridians
    }

    /// Memory, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.cells.iter().map(|cells| size_of_val(&cells[..])).sum()
    }

    /// The numbers that a GPU's kernels read ([`wgsl::SKY_BUFFER`](crate::wgsl::SKY_BUFFER)): cosines and sines of the rows; then, for each pole, for each of six
    /// components of light and direction and each sample, a number a row.
    #[must_use]
    pub fn packed(&self) -> Vec<f32> {
        let resolution = self.meridians.resolution();
        let (rows, samples) = (resolution.rows(), resolution.samples());
        let circle = |axis: usize| (0..rows).map(move |row| self.meridians.row(row)[axis]);
        let mut all: Vec<f32> = circle(0).chain(circle(1)).collect();
        all.reserve(6 * 6 * rows * samples);
        for cells in &self.cells {
            for (component, sample) in (0..6).flat_map(|component| (0..samples).map(move |sample| (component, sample)))
            {
                let blocks = cells[sample..].iter().step_by(samples);
                all.extend(blocks.flat_map(|Cell(columns)| columns[component]));
            }
        }
        all
    }

    /// The samples of eight rows of a pole.
    #[inline(always)]
    pub(super) fn block(&self, pole: Pole, block: usize) -> &[Cell] {
        let samples = self.meridians.resolution().samples();
        &self.cells[pole.number()][block * samples..][..samples]
    }
}

impl Cell {
    #[inline(always)]
    pub(super) fn light<S: Simd>(&self, simd: S) -> Vec3x8<S> {
        let [x, y, z, ..] = self.0;
        Vec3x8::new(f32x8::simd_from(simd, x), f32x8::simd_from(simd, y), f32x8::simd_from(simd, z))
    }

    #[inline(always)]
    pub(super) fn direction<S: Simd>(&self, simd: S) -> Vec3x8<S> {
        let [x, y, z] = self.directions();
        Vec3x8::new(f32x8::simd_from(simd, x), f32x8::simd_from(simd, y), f32x8::simd_from(simd, z))
    }

    #[inline(always)]
    pub(super) fn directions(&self) -> [[f32; LANES]; 3] {
        [self.0[3], self.0[4], self.0[5]]
    }
}

/// The brightest sample's radiance over the mean. A sample's solid angle goes with its distance from the pole's axis.
fn contrast(cells: &[Vec<Cell>]) -> f32 {
    let (mut brightest, mut light, mut angle) = (0.0_f32, 0.0, 0.0);
    for (pole, cells) in Pole::ALL.iter().zip(cells) {
        let [.., axis] = pole.frame();
        for Cell(columns) in cells {
            (0..LANES).for_each(|lane| {
                let at = |first: usize| Vec3::from_array(core::array::from_fn(|k| columns[first + k][lane]));
                let sin = at(3).cross(axis).length();
                light += at(0).max_element();
                angle += sin;
                brightest = brightest.max(at(0).max_element() / sin.max(LEAST_SIN));
            });
        }
    }
    if light > 0.0 { brightest * angle / light } else { 1.0 }
}

/// The row of the opposite pole's meridians that is the same half circle.
fn mirrored(row: usize, rows: usize) -> usize {
    (rows + rows / 4 - 1 - row) % rows
}

/// The samples of a row, each looked at so many times across and along.
fn row_of(
    resolution: SkyResolution,
    pole: Pole,
    row: usize,
    [across, along]: [usize; 2],
    radiance: impl Fn(Vec3) -> Vec3,
) -> Vec<Sample> {
    let (rows, samples) = (resolution.rows(), resolution.samples());
    let part = |k: usize, parts: usize| k as f64 / parts as f64;
    let wedges: Vec<(DVec3, f64)> = (0..across)
        .map(|b| {
            let at = |b: f64| circle(row_number(row as f64 + b, rows));
            let [low, mid, high] =
                [part(b, across), 0.5 * (part(b, across) + part(b + 1, across)), part(b + 1, across)].map(at);
            let turn = low[0] * high[1] - low[1] * high[0];
            (DVec3::new(mid[0], mid[1], 0.0), turn.atan2(low[0] * high[0] + low[1] * high[1]))
        })
        .collect();
    let one = |sample: usize| {
        let (mut light, mut toward, mut middle, mut solid) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO, 0.0);
        for a in 0..along {
            let at = |a: f64| elevation(1.0 - 2.0 * (sample as f64 + a) / samples as f64);
            let [low, mid, high] =
                [part(a, along), 0.5 * (part(a, along) + part(a + 1, along)), part(a + 1, along)].map(at);
            for (azimuth, width) in &wedges {
                let v = *azimuth * mid[0] + DVec3::Z * mid[1];
                let omega = width * (low[1] - high[1]);
                let v = pole.world(v.as_vec3());
                let l = radiance(v).as_dvec3() * omega;
                light += l;
                toward += v.as_dvec3() * l.element_sum();
                middle += v.as_dvec3() * omega;
                solid += omega;
            }
        }
        let all = light.element_sum();
        let mean = if all > 0.0 { toward / all } else { middle / solid };
        [(light * mean.length()).as_vec3(), mean.normalize_or(DVec3::Z).as_vec3()]
    };
    (0..samples).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The table of each pole holds the light of the whole sphere, and its directions are those of its meridians.
    #[test]
    fn each_pole_has_the_same_light() {
        let sky = |v: Vec3| Vec3::new(1.0, 0.5 + 0.5 * v.y, (v.x * 3.0).sin().powi(2));
        let resolution = SkyResolution::new(32, 32);
        let table = SkyTable::new(resolution, 64, sky);
        let words = table.packed();
        assert_eq!(words.len(), 64 + 36 * 32 * 32);
        assert_eq!([words[7], words[32 + 7]], table.meridians.row(7));
        let packed = |pole: Pole, component: usize, sample: usize, row: usize| {
            words[64 + ((6 * pole.number() + component) * 32 + sample) * 32 + row]
        };
        for pole in Pole::ALL {
            let (mut sum, mut count) = (DVec3::ZERO, 0);
            for block in 0..resolution.blocks() {
                for (sample, Cell(columns)) in table.block(pole, block).iter().enumerate() {
                    for (lane, _) in columns[0].iter().enumerate() {
                        let at = |c: usize| columns[c][lane];
                        sum += DVec3::new(at(0).into(), at(1).into(), at(2).into());
                        let place = table.meridians.direction((block * LANES + lane) as f64 + 0.5, sample as f64 + 0.5);
                        let v = Vec3::new(at(3), at(4), at(5));
                        assert!(v.distance(pole.world(place)) < 0.12, "{pole:?} {v} {place}");
                        count += 1;
                    }
                }
            }
            assert_eq!(count, 32 * 32);
            assert_eq!(packed(pole, 5, 9, 17), table.block(pole, 2)[9].0[5][1]);
            let all = 4.0 * core::f64::consts::PI;
            // ∫ sin²(3x) dω = 2π (1 − sin 6/6).
            let want = DVec3::new(all, 0.5 * all, 0.5 * all * (1.0 - 6.0_f64.sin() / 6.0));
            assert!((sum / want - 1.0).abs().max_element() < 4e-3, "{pole:?}: {sum} for {want}");
        }
    }
}
