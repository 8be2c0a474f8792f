use core::ops::ControlFlow;

use glam::{Vec3, Vec4};

use crate::build::Builder;
use crate::error::BuildError;
use crate::options::{BuildOptions, Progress};
use crate::quality::SetQuality;
use crate::sphere_set::SphereSet;
use crate::surface::Surface;
use crate::tree::TriangleTree;

/// Counts closer than this ratio are as good as each other: builds of them differ by chance.
const CLOSE: f32 = 1.04;

impl SphereSet {
    /// Builds the smallest set whose silhouette error is at most `tolerance`, of at most `options.count` spheres.
    ///
    /// Tries counts between those known to be too few and enough, where the last errors' power law says, until they are
    /// within 4 % of each other. Takes a few times as long as building the set that it finds.
    ///
    /// # Errors
    /// As [`SphereSet::build_with_progress`]; [`BuildError::ToleranceNotReached`] if no allowed count is enough, and
    /// [`BuildError::BadTolerance`] for a tolerance outside `(0, 1]`.
    pub fn build_to_tolerance(
        positions: &[Vec3],
        triangles: &[[u32; 3]],
        tolerance: f32,
        options: &BuildOptions,
        progress: &mut Progress,
    ) -> Result<Self, BuildError> {
        if !(tolerance > 0.0 && tolerance <= 1.0) {
            return Err(BuildError::BadTolerance);
        }
        if options.count == 0 {
            return Err(BuildError::NoSpheres);
        }
        let surface = Surface::new(positions, triangles)?;
        let tree = TriangleTree::new(&surface.triangles);
        let mut builder = Builder::new(&surface, &tree, options.count.min(START));
        let mut tried = 0;
        let unit = smallest(tolerance, options.count, |count| {
            // The number of trials is not known: each takes half of the remaining bar.
            tried += 1;
            let left = 0.5_f32.powi(tried);
            let mut part = |done: f32| -> ControlFlow<()> { progress(1.0 - left * (2.0 - done)) };
            let unit = builder.build(&BuildOptions { count, ..*options }, &mut part)?;
            let error = SetQuality::silhouette_error_of(&surface, &unit);
            Ok((unit, error))
        })?;
        Ok(Self::judge(&surface, &tree, builder.solid(), triangles.len(), &unit))
    }
}

/// The first count that is tried.
const START: usize = 12;

/// The spheres of the smallest count whose error is at most `tolerance`.
fn smallest(
    tolerance: f32,
    most: usize,
    mut attempt: impl FnMut(usize) -> Result<(Vec<Vec4>, f32), BuildError>,
) -> Result<Vec<Vec4>, BuildError> {
    // Errors fall about as 1/n^0.85.
    let guess = |count: usize, error: f32| count as f32 * (error / tolerance).max(1e-3).powf(1.0 / 0.85);
    let (mut few, mut few_error) = (0, f32::INFINITY);
    let mut enough: Option<(usize, f32, Vec<Vec4>)> = None;
    let mut count = START.min(most);
    loop {
        let (unit, error) = attempt(count)?;
        if error <= tolerance {
            // Meshes that fewer spheres make up entirely.
            count = unit.len().min(count);
            enough = Some((count, error, unit));
        } else if count == most {
            return Err(BuildError::ToleranceNotReached { count, reached: error, requested: tolerance });
        } else {
            (few, few_error) = (count, error);
        }
        let Some((above, above_error, _)) = &enough else {
            count = (guess(few, few_error).min(4.0 * few as f32) as usize).clamp(few + 1, most);
            continue;
        };
        if *above <= few + 1 || (few > 0 && *above as f32 <= CLOSE * few as f32) {
            break;
        }
        let next = if few == 0 {
            guess(*above, *above_error)
        } else {
            let part = (few_error / tolerance).ln() / (few_error / above_error.max(1e-6)).ln();
            few as f32 * (*above as f32 / few as f32).powf(part.clamp(0.1, 0.9))
        };
        count = (next as usize).clamp(few + 1, above - 1);
    }
    enough.map(|(_, _, unit)| unit).ok_or(BuildError::NoSpheres)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A model error in place of builds: the count found is the smallest, or within 4 % of it.
    #[test]
    fn finds_the_smallest_count() {
        for tolerance in [0.9, 0.3, 0.05, 0.011, 0.004] {
            let mut requested = Vec::new();
            let error = |n: usize| 0.9 * (n as f32).powf(-0.7);
            let unit = smallest(tolerance, 5000, |n| {
                requested.push(n);
                Ok((vec![Vec4::ZERO; n], error(n)))
            });
            let found = unit.expect("enough spheres").len();
            let exact = (1..).find(|n| error(*n) <= tolerance).expect("a falling error");
            assert!(found >= exact && found as f32 <= CLOSE * exact as f32 + 1.0, "{tolerance}: {found}, {exact}");
            assert!(requested.len() <= 12, "{requested:?}");
        }
    }

    #[test]
    fn says_what_is_left() {
        let left = smallest(0.01, 100, |n| Ok((vec![Vec4::ZERO; n], 0.0275)));
        let message = left.expect_err("too few").to_string();
        assert!(
            message.starts_with("100 spheres leave a silhouette error of 2.75 %, but 1.00 % is requested"),
            "{message}"
        );
    }
}
