use glam::Vec4;
use rayon::prelude::*;

use crate::bits::for_disc;
use crate::random::Random;
use crate::view::View;

/// Radii tried at a place: depth plus these, in units of D.
const PROTRUSIONS: [f32; 4] = [0.0, 0.004, 0.01, 0.02];

/// The usual protrusion. All places are judged with it first, in half of the views; one in PROMISING is then tried with all.
const USUAL: f32 = 0.004;
const PROMISING: usize = 5;

/// One in this number of views judges all places.
const SPARSE: usize = 8;

/// Candidates that the choice is made among, per sphere to be placed.
const SHORTLIST: usize = 40;

/// The silhouette error that each sphere's removal would add, over all views: pixels that only it covers.
fn removal_costs(views: &[View], spheres: &[Vec4]) -> Vec<f32> {
    let per_view: Vec<Vec<f32>> = views
        .par_iter()
        .map_init(
            || vec![(0_u32, 0_u32); views[0].size * views[0].size],
            |pixels, view| {
                pixels.fill((0, 0));
                for (i, sphere) in spheres.iter().enumerate() {
                    let (center, radius) = view.frame.disc(*sphere);
                    for_disc(view.size, center, radius, |row, start, end| {
                        for (count, owner) in &mut pixels[row * view.size + start..row * view.size + end] {
                            *count += 1;
                            *owner = i as u32;
                        }
                    });
                }
                let mut sums = vec![0_i32; spheres.len()];
                for ((count, owner), outside) in pixels.iter().zip(&view.outside) {
                    if *count == 1 {
                        sums[*owner as usize] -= i32::from(*outside);
                    }
                }
                sums.iter().map(|sum| *sum as f32 * 0.25 * view.inverse_area).collect()
            },
        )
        .collect();
    let mut costs = vec![0.0; spheres.len()];
    for view in &per_view {
        for (cost, own) in costs.iter_mut().zip(view) {
            *cost += own / views.len() as f32;
        }
    }
    costs
}

/// Removes about `count` spheres that the silhouettes miss least, no two of them neighbours.
pub(crate) fn take_out(views: &[View], spheres: &mut Vec<Vec4>, count: usize, random: &mut Random) {
    let costs = removal_costs(views, spheres);
    // Blurred costs make the rounds differ.
    let mut order: Vec<(f32, usize)> =
        costs.iter().enumerate().map(|(i, cost)| (cost * (0.6 + 0.8 * random.unit()), i)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut gone: Vec<usize> = Vec::with_capacity(count);
    for (_, i) in order {
        if gone.len() == count || gone.len() + 1 >= spheres.len() {
            break;
        }
        let beside = |j: &usize| {
            let reach = spheres[i].w.max(spheres[*j].w);
            spheres[i].truncate().distance_squared(spheres[*j].truncate()) < reach * reach
        };
        if !gone.iter().any(beside) {
            gone.push(i);
        }
    }
    gone.sort_unstable();
    for i in gone.into_iter().rev() {
        spheres.remove(i);
    }
}

/// Removes up to `count` spheres, any of them, but not the last.
pub(crate) fn take_any(spheres: &mut Vec<Vec4>, count: usize, random: &mut Random) {
    for _ in 0..count.min(spheres.len().saturating_sub(1)) {
        spheres.swap_remove(random.below(spheres.len()));
    }
}

/// The possible gain in one view: running sums along rows of +1 for a subpixel of the silhouette that no
/// sphere covers, −1 for one outside it.
struct Gains<'a> {
    view: &'a View,
    open: Vec<i8>,
    /// `size + 1` entries a row.
    sums: Vec<i16>,
}

impl<'a> Gains<'a> {
    fn new(view: &'a View, spheres: &[Vec4]) -> Self {
        let mut gains = Self {
            view,
            open: view.outside.iter().map(|outside| -outside).collect(),
            sums: vec![0; (view.size + 1) * view.size],
        };
        for sphere in spheres {
            gains.close(*sphere);
        }
        for row in 0..view.size {
            gains.sum_row(row);
        }
        gains
    }

    fn close(&mut self, sphere: Vec4) {
        let (center, radius) = self.view.frame.disc(sphere);
        let size = self.view.size;
        for_disc(size, center, radius, |row, start, end| self.open[row * size + start..row * size + end].fill(0));
    }

    fn sum_row(&mut self, row: usize) {
        let size = self.view.size;
        let sums = &mut self.sums[row * (size + 1)..(row + 1) * (size + 1)];
        let mut sum = 0;
        for (out, open) in sums[1..].iter_mut().zip(&self.open[row * size..(row + 1) * size]) {
            sum += i16::from(*open);
            *out = sum;
        }
    }

    fn place(&mut self, sphere: Vec4) {
        self.close(sphere);
        let (center, radius) = self.view.frame.disc(sphere);
        let mut rows = (usize::MAX, 0);
        for_disc(self.view.size, center, radius, |row, _, _| rows = (rows.0.min(row), rows.1.max(row + 1)));
        for row in rows.0..rows.1 {
            self.sum_row(row);
        }
    }

    fn gain(&self, sphere: Vec4) -> f32 {
        let (center, radius) = self.view.frame.disc(sphere);
        let size = self.view.size;
        let mut sum = 0_i32;
        for_disc(size, center, radius, |row, start, end| {
            let row = &self.sums[row * (size + 1)..(row + 1) * (size + 1)];
            sum += i32::from(row[end]) - i32::from(row[start]);
        });
        sum as f32 * 0.25 * self.view.inverse_area
    }
}

/// Adds up to `count` spheres where each lowers the silhouette error most, among `places` (centre, depth) with several
/// radii. All places are judged in every [`SPARSE`]th view, the best ones in all. Stops when nothing helps.
pub(crate) fn insert(views: &[View], spheres: &mut Vec<Vec4>, places: &[Vec4], count: usize, random: &mut Random) {
    let mut gains: Vec<Gains> = views.par_iter().map(|view| Gains::new(view, spheres)).collect();
    let first = random.below(SPARSE);
    let sparse = |sphere: Vec4, step: usize| {
        gains.iter().skip(first).step_by(step).map(|view| view.gain(sphere)).sum::<f32>() * step as f32
    };
    let grown = |place: &Vec4, out: f32| place.truncate().extend(place.w + out);
    let mut rough: Vec<(f32, &Vec4)> =
        places.par_iter().map(|place| (sparse(grown(place, USUAL), 2 * SPARSE), place)).collect();
    rough.sort_by(|a, b| b.0.total_cmp(&a.0));
    // Many spheres are small: which place is theirs shows only with their own radius.
    let promising = if spheres.len() + count <= 96 { PROMISING } else { 1 };
    rough.truncate(places.len() / promising);
    let mut candidates: Vec<(f32, Vec4)> = rough
        .par_iter()
        .flat_map_iter(|(_, place)| PROTRUSIONS.iter().map(|out| grown(place, *out)))
        .filter(|sphere| sphere.w > 0.0)
        .map(|sphere| (sparse(sphere, SPARSE), sphere))
        .collect();
    candidates.sort_by(|a, b| b.0.total_cmp(&a.0));
    candidates.truncate(SHORTLIST * count);
    let exact = |gains: &[Gains], sphere: Vec4| gains.iter().map(|view| view.gain(sphere)).sum::<f32>();
    candidates.par_iter_mut().for_each(|(gain, sphere)| *gain = exact(&gains, *sphere));
    for _ in 0..count {
        // Gains mostly shrink as spheres are placed, so those that were not judged again are mostly below its old gain.
        let mut best = None;
        candidates.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (old, sphere) in &mut candidates {
            if best.is_some_and(|(gain, _)| *old <= gain) {
                break;
            }
            *old = exact(&gains, *sphere);
            if *old > 0.0 && best.is_none_or(|(gain, _)| *old > gain) {
                best = Some((*old, *sphere));
            }
        }
        let Some((_, sphere)) = best else { break };
        gains.par_iter_mut().for_each(|view| view.place(sphere));
        spheres.push(sphere);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The last sphere stays, those that stay are unchanged, and chance decides which they are.
    #[test]
    fn some_are_taken() {
        let all: Vec<Vec4> = (0..9).map(|i| Vec4::splat(i as f32)).collect();
        let mut random = Random::new(0);
        let left = |count: usize, random: &mut Random| {
            let mut spheres = all.clone();
            take_any(&mut spheres, count, random);
            spheres
        };
        for (count, kept) in [(0, 9), (4, 5), (8, 1), (20, 1)] {
            let mut spheres = left(count, &mut random);
            spheres.sort_by(|a, b| a.x.total_cmp(&b.x));
            spheres.dedup();
            assert_eq!(spheres.len(), kept);
            assert!(spheres.iter().all(|sphere| all.contains(sphere)));
        }
        assert_ne!(left(4, &mut random), left(4, &mut random));
        take_any(&mut Vec::new(), 3, &mut random);
    }
}
