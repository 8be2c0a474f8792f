//! A page of texels: their values, and the values of those around them.

use crate::steps::Band;
use glam::Vec3;

/// Bytes of a texel with one value.
pub(crate) const TEXEL_BYTES: usize = size_of::<Vec3>() + size_of::<State>() + size_of::<f32>();

/// The bytes that all pages of a bake may take.
pub(crate) const MOST_BYTES: u64 = 4_000_000_000;

/// The bytes of pages with a number of values a texel.
pub(crate) fn bytes(pages: &[[u32; 2]], values: usize) -> u64 {
    let texels: u64 = pages.iter().map(|[width, height]| u64::from(*width) * u64::from(*height)).sum();
    texels * (TEXEL_BYTES + (values - 1) * size_of::<Vec3>()) as u64
}

/// A texel with less of a surface than this shows its very edge alone, where another surface may begin: in texels.
pub(crate) const THIN: f64 = 0.01;

/// The origin of a texel's value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum State {
    /// It has none: no surface is there.
    #[default]
    Empty,
    /// It has none: its surface is inside of a body.
    Buried,
    /// Less of a surface than [`THIN`]: the texels beside it decide, if there are any.
    Thin,
    /// The surface.
    Surface,
    /// The texels around it.
    Around,
}

/// A page: a list of values for each thing that is baked.
#[derive(Clone, Debug)]
pub(crate) struct Page {
    pub(crate) size: [u32; 2],
    pub(crate) states: Vec<State>,
    pub(crate) layers: Vec<Vec<Vec3>>,
}

impl Page {
    pub(crate) fn new(size: [u32; 2], layers: usize) -> Self {
        let count = size[0] as usize * size[1] as usize;
        Self { size, states: vec![State::Empty; count], layers: vec![vec![Vec3::ZERO; count]; layers] }
    }

    fn range(&self, rows: [u32; 2]) -> core::ops::Range<usize> {
        let [first, end] = rows.map(|row| row as usize * self.size[0] as usize);
        first..end
    }

    /// The texels of a band of rows.
    pub(crate) fn rows(&self, rows: [u32; 2]) -> Band {
        let range = self.range(rows);
        let layers = self.layers.iter().map(|layer| layer[range.clone()].to_vec()).collect();
        Band { states: self.states[range].to_vec(), layers }
    }

    /// Sets the texels of a band of rows; other numbers of texels or layers change nothing.
    pub(crate) fn set_rows(&mut self, rows: [u32; 2], band: &Band) {
        let range = self.range(rows);
        let is_whole = band.states.len() == range.len() && band.layers.len() == self.layers.len();
        if is_whole && band.layers.iter().all(|layer| layer.len() == range.len()) {
            self.states[range.clone()].copy_from_slice(&band.states);
            self.layers.iter_mut().zip(&band.layers).for_each(|(own, new)| own[range.clone()].copy_from_slice(new));
        }
    }

    /// The texels around one.
    fn around(&self, at: usize) -> impl Iterator<Item = usize> {
        let [width, height] = self.size.map(|k| k as usize);
        let (x, y) = (at % width, at / width);
        let rows = y.saturating_sub(1)..(y + 2).min(height);
        rows.flat_map(move |row| (x.saturating_sub(1)..(x + 2).min(width)).map(move |column| row * width + column))
    }

    /// Gives values to the texels around surfaces: ring after ring the mean of the values beside them, so that filters find at a chart's
    /// edge what is on it.
    pub(crate) fn dilate(&mut self, rings: u32) {
        let has_value = |state: State| matches!(state, State::Surface | State::Around);
        let mut bare: Vec<usize> = (0..self.states.len()).filter(|at| !has_value(self.states[*at])).collect();
        for _ in 0..rings {
            let mut ring = Vec::new();
            for at in bare {
                let beside: Vec<usize> = self.around(at).filter(|k| has_value(self.states[*k])).collect();
                if !beside.is_empty() {
                    let mean = |layer: &Vec<Vec3>| beside.iter().map(|k| layer[*k]).sum::<Vec3>() / beside.len() as f32;
                    ring.push((at, self.layers.iter().map(mean).collect::<Vec<Vec3>>()));
                }
            }
            // The next ring lies beside this one.
            bare = ring.iter().flat_map(|(at, _)| self.around(*at)).collect();
            bare.sort_unstable();
            bare.dedup();
            for (at, values) in ring {
                self.states[at] = State::Around;
                self.layers.iter_mut().zip(values).for_each(|(layer, value)| layer[at] = value);
            }
            bare.retain(|at| !has_value(self.states[*at]));
        }
        let alone = self.states.iter_mut().filter(|state| **state == State::Thin);
        alone.for_each(|state| *state = State::Surface);
    }

    /// Gives all other texels the mean of the smallest block of 2, 4, 8 … texels a side around them that has values: coarser levels of the
    /// page are no darker then.
    pub(crate) fn fill(&mut self) {
        let [width, height] = self.size.map(|k| k as usize);
        for layer in 0..self.layers.len() {
            let known = |state: &State| if *state == State::Empty { 0.0 } else { 1.0 };
            let first = self.layers[layer].iter().zip(&self.states).map(|(v, s)| v.extend(known(s)) * known(s));
            let mut levels = vec![(width, height, first.collect::<Vec<_>>())];
            while levels.last().is_some_and(|(w, h, _)| w.max(h) > &1) {
                let (w, h, finer) = &levels[levels.len() - 1];
                let (half_w, half_h) = (w.div_ceil(2), h.div_ceil(2));
                let mut sums = vec![glam::Vec4::ZERO; half_w * half_h];
                for (at, value) in finer.iter().enumerate() {
                    sums[at / w / 2 * half_w + at % w / 2] += *value;
                }
                levels.push((half_w, half_h, sums));
            }
            for at in (0..width * height).filter(|at| self.states[*at] == State::Empty) {
                let sum = levels
                    .iter()
                    .enumerate()
                    .map(|(k, (w, _, sums))| sums[((at / width) >> k) * w + ((at % width) >> k)]);
                if let Some(sum) = sum.into_iter().find(|sum| sum.w > 0.0) {
                    self.layers[layer][at] = sum.truncate() / sum.w;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rings_take_the_mean_of_what_is_beside_them() {
        let mut page = Page::new([7, 1], 2);
        for (at, value) in [(2, 1.0), (3, 3.0)] {
            page.states[at] = State::Surface;
            page.layers.iter_mut().for_each(|layer| layer[at] = Vec3::splat(value));
        }
        page.states[4] = State::Buried;
        page.dilate(1);
        let row = |page: &Page| page.layers[1].iter().map(|v| v.x).collect::<Vec<f32>>();
        assert_eq!(row(&page), [0.0, 1.0, 1.0, 3.0, 3.0, 0.0, 0.0]);
        assert_eq!(page.states[4], State::Around);
        page.dilate(1);
        assert_eq!(row(&page), [1.0, 1.0, 1.0, 3.0, 3.0, 3.0, 0.0]);
        page.fill();
        // The block of the last two texels has none; that of the last four has two.
        assert_eq!(row(&page)[6], 3.0);
        assert_eq!(page.states[6], State::Empty);
        let mut page = Page::new([4, 1], 1);
        page.states = vec![State::Surface, State::Thin, State::Empty, State::Thin];
        page.layers[0] = [1.0, 9.0, 0.0, 7.0].map(Vec3::splat).to_vec();
        page.dilate(1);
        assert_eq!(page.layers[0].iter().map(|v| v.x).collect::<Vec<_>>(), [1.0, 1.0, 0.0, 7.0]);
        assert_eq!(page.states, [State::Surface, State::Around, State::Empty, State::Surface]);
    }
}
