use crate::Resolution;
use crate::fit::fit_product_from;
use glam::Vec3;
use lobe_core::Lobe;

/// The largest exponent of the table.
pub(crate) const LAST: f32 = 1e5;

/// The product of two lobes, tabulated (§4.1): partial scaling factor `p_r` and exponent `e_r` over (e1, e2, α).
///
/// Sampled as printed, [`Resolution::PAPER`]; 4.3 MB in f32, because a product is symmetric and only `e1 ≤ e2` is kept.
/// `p_r` and `e_r` are interpolated linearly in all three directions. The axis is not tabulated: Eq. 19 has a closed form.
#[derive(Clone, Debug, PartialEq)]
pub struct ProductTable {
    resolution: Resolution,
    /// `[p_r, e_r]` by row (e1), then e2 ≥ e1, then angle.
    entries: Vec<[f32; 2]>,
}

/// One row of a [`ProductTable`]: all `e2 ≥ e1` and all angles for one `e1`.
#[derive(Clone, Debug, PartialEq)]
pub struct TableRow(Vec<[f32; 2]>);

impl ProductTable {
    /// Builds the table of the paper on the calling thread: half a million fits, some seconds (4 hours in 2010).
    #[must_use]
    pub fn build() -> Self {
        Self::build_with(Resolution::PAPER)
    }

    /// Builds a table of another resolution.
    ///
    /// # Panics
    /// When the resolution has fewer than 2 angles or 2 exponents an interval.
    #[must_use]
    pub fn build_with(resolution: Resolution) -> Self {
        Self::from_rows(resolution, (0..resolution.exponents()).map(|i| Self::build_row(resolution, i)))
    }

    /// Row `index < resolution.exponents()` of the table: rows are independent, so a caller may build them on many
    /// threads and join them by [`from_rows`](Self::from_rows). Later rows are shorter.
    #[must_use]
    pub fn build_row(resolution: Resolution, index: usize) -> TableRow {
        let e1 = resolution.exponent(index);
        let mut row = Vec::with_capacity((resolution.exponents() - index) * resolution.angles);
        for j in index..resolution.exponents() {
            let e2 = resolution.exponent(j);
            let mut exponent = (e1 + e2) as f32;
            for k in 0..resolution.angles {
                let fit = fit_product_from(e1, e2, resolution.angle(k), (k > 0).then_some(f64::from(exponent)));
                // Where nothing is left to fit (α = π), the exponent of the last angle keeps the table smooth.
                if fit.scale > 0.0 || k + 1 < resolution.angles {
                    exponent = fit.exponent as f32;
                }
                row.push([fit.scale as f32, exponent]);
            }
        }
        TableRow(row)
    }

    /// Joins the rows of [`build_row`](Self::build_row), given in order.
    ///
    /// # Panics
    /// When the rows are not all rows of this resolution.
    #[must_use]
    pub fn from_rows(resolution: Resolution, rows: impl IntoIterator<Item = TableRow>) -> Self {
        let mut entries = Vec::with_capacity(Self::entry_count(resolution));
        rows.into_iter().for_each(|row| entries.extend(row.0));
        Self::from_entries(resolution, entries).expect("rows of another resolution")
    }

    pub(crate) fn from_entries(resolution: Resolution, entries: Vec<[f32; 2]>) -> Option<Self> {
        (entries.len() == Self::entry_count(resolution)).then_some(Self { resolution, entries })
    }

    pub(crate) fn entry_count(resolution: Resolution) -> usize {
        let n = resolution.exponents();
        n * (n + 1) / 2 * resolution.angles
    }

    pub(crate) fn entries(&self) -> &[[f32; 2]] {
        &self.entries
    }

    /// How finely this table is sampled.
    #[must_use]
    pub fn resolution(&self) -> Resolution {
        self.resolution
    }

    /// Memory of the table's entries in bytes.
    #[must_use]
    pub fn size(&self) -> usize {
        size_of_val(self.entries.as_slice())
    }

    /// `(p_r, e_r)` at exponents and angle (radians) of any value, clamped to the table's range: trilinear
    /// interpolation.
    #[must_use]
    pub fn lookup(&self, e1: f32, e2: f32, alpha: f32) -> (f32, f32) {
        let (i, u) = self.resolution.locate_exponent(e1);
        let (j, v) = self.resolution.locate_exponent(e2);
        let (k, w) = self.resolution.locate_angle(alpha);
        let along_angle = |i: usize, j: usize| {
            let (low, high) = (i.min(j), i.max(j));
            let n = self.resolution.exponents();
            // Rows 0, 1, … hold n, n−1, … columns.
            let column = low * n - low * low.saturating_sub(1) / 2 + high - low;
            let first = column * self.resolution.angles + k;
            mix(self.entries[first], self.entries[first + 1], w)
        };
        let near = mix(along_angle(i, j), along_angle(i, j + 1), v);
        let far = mix(along_angle(i + 1, j), along_angle(i + 1, j + 1), v);
        let [scale, exponent] = mix(near, far, u);
        (scale, exponent)
    }

    /// One lobe for the product of two (Eqs. 15–17), colour by colour.
    ///
    /// Scales multiply as they are. An exponent above 1e5 is taken as 1e5 with the lobe's flux kept, so that a point
    /// light (e = ∞) stays finite. An exponent of 0 is a constant on the hemisphere of its axis, as everywhere. The
    /// paper keeps the receiver's cosine as a lobe of its own; when a factor carries one
    /// ([`Lobe::times_cosine`]), so does the result, once.
    #[must_use]
    pub fn product(&self, c1: &Lobe, c2: &Lobe) -> Lobe {
        let (e1, e2) = (c1.exponent.min(LAST), c2.exponent.min(LAST));
        let scale = |lobe: &Lobe, e: f32| lobe.flux * ((e + 1.0) * core::f32::consts::FRAC_1_PI * 0.5);
        let (across, along) = ((c1.axis - c2.axis).length(), (c1.axis + c2.axis).length());
        let (p, e) = self.lookup(e1, e2, 2.0 * across.atan2(along));
        let result = Lobe::new(product_direction(c1.axis, e1, c2.axis, e2), e, scale(c1, e1) * scale(c2, e2) * p);
        Lobe { has_cosine: c1.has_cosine || c2.has_cosine, ..result }
    }
}

fn mix(a: [f32; 2], b: [f32; 2], t: f32) -> [f32; 2] {
    [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]
}

/// The unit axis of Eq. 19, without trigonometric functions: `a1 sin(α−t) + a2 sin t`, normalised.
fn product_direction(a1: Vec3, e1: f32, a2: Vec3, e2: f32) -> Vec3 {
    let (sin, cos) = (a1.cross(a2).length(), a1.dot(a2));
    if e1 + e2 == 0.0 {
        return (a1 + a2).try_normalize().unwrap_or(a1);
    }
    // Relative to the larger, so that no square overflows or vanishes.
    let (e1, e2) = (e1 / e1.max(e2), e2 / e1.max(e2));
    let root = (((e1 - e2) * cos).powi(2) + 4.0 * e1 * e2).sqrt();
    let sum = (e1 + e2) * cos.abs() + root;
    let (one, two) = if cos >= 0.0 {
        (Vec3::new(2.0 * e2 * sin, sum, 0.0), Vec3::new(2.0 * e1 * sin, sum, 0.0))
    } else {
        (Vec3::new(sum, 2.0 * e1 * sin, 0.0), Vec3::new(sum, 2.0 * e2 * sin, 0.0))
    };
    let sine = |pair: Vec3| pair.x / pair.length();
    (a1 * sine(two) + a2 * sine(one)).try_normalize().unwrap_or(a1)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::{fit_product, product_axis};
    use core::f64::consts::PI;
    use lobe_core::oracle::Random;

    pub(crate) const SMALL: Resolution = Resolution { angles: 33, per_interval: 4 };

    #[test]
    fn samples_are_the_fits() {
        let table = ProductTable::build_with(SMALL);
        for i in (0..SMALL.exponents()).step_by(3) {
            for j in 0..SMALL.exponents() {
                for k in (0..SMALL.angles - 1).step_by(5) {
                    let (e1, e2, alpha) = (SMALL.exponent(i), SMALL.exponent(j), SMALL.angle(k));
                    let (p, e) = table.lookup(e1 as f32, e2 as f32, alpha as f32);
                    let fit = fit_product(e1, e2, alpha);
                    // The f32 coordinates are off the sample by 1e-7 of the range, times the slope to the neighbour.
                    assert!((f64::from(p) - fit.scale).abs() < 1e-4, "{e1} {e2} {alpha} {p} {fit:?}");
                    assert!(
                        (f64::from(e) - fit.exponent).abs() < 2e-3 * (1.0 + fit.exponent),
                        "{e1} {e2} {alpha} {e} {fit:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn symmetric_everywhere() {
        let table = ProductTable::build_with(SMALL);
        let mut random = Random::new(61);
        for _ in 0..500 {
            let (e1, e2, alpha) =
                (random.exponent(2e5) as f32, random.exponent(2e5) as f32, random.uniform() as f32 * 3.2);
            let ((p, e), (q, f)) = (table.lookup(e1, e2, alpha), table.lookup(e2, e1, alpha));
            assert!((p - q).abs() <= 1e-6 && (e - f).abs() <= 1e-5 * e, "{e1} {e2} {alpha}");
        }
    }

    #[test]
    fn axis_as_in_eq_19() {
        let mut random = Random::new(62);
        for _ in 0..2000 {
            let (e1, e2, alpha) = (random.exponent(1e5), random.exponent(1e5), random.between(0.0, 3.1));
            let a1 = random.axis();
            let a2 = random.axis_at(a1, alpha);
            let found = product_direction(a1.as_vec3(), e1 as f32, a2.as_vec3(), e2 as f32).as_dvec3();
            let across = (a2 - a1 * a1.dot(a2)).try_normalize().unwrap_or(a1);
            let t = product_axis(e1, e2, alpha);
            let exact = a1 * t.cos() + across * t.sin();
            // cos α near a right angle carries the rounding of f32; a constant's rim amplifies it by 1/sin α.
            assert!((found - exact).length() < 3e-6 / alpha.sin().max(0.02), "{e1} {e2} {alpha}: {found} {exact}");
        }
    }

    #[test]
    fn multiplies_colours_and_keeps_the_flux_of_a_point_light() {
        let table = ProductTable::build_with(SMALL);
        let red = Lobe::new(Vec3::Z, 10.0, Vec3::new(2.0, 0.5, 0.0));
        let green = Lobe::new(Vec3::Z, 90.0, Vec3::new(0.5, 4.0, -1.0));
        let product = table.product(&red, &green);
        assert!((product.scale() - Vec3::new(1.0, 2.0, 0.0)).length() < 0.02, "{product:?}");
        assert!((product.exponent - 100.0).abs() < 1.0 && product.axis == Vec3::Z);
        // A delta picks the value of the other lobe: flux·f(axis).
        let delta = Lobe::with_flux(Vec3::Z, f32::INFINITY, Vec3::ONE);
        let picked = table.product(&red, &delta);
        assert!((picked.flux - Vec3::new(2.0, 0.5, 0.0)).length() < 0.02, "{picked:?}");
        assert!(table.product(&red.times_cosine(), &delta).has_cosine);
    }

    #[test]
    fn finite_at_the_extremes() {
        let table = ProductTable::build_with(SMALL);
        let mut random = Random::new(63);
        let exponents = [0.0, 1e-6, 0.5, 1.0, 1e5, 1e7, f32::INFINITY];
        for e1 in exponents {
            for e2 in exponents {
                for alpha in [0.0, 1e-7, 0.5 * PI, PI - 1e-7, PI] {
                    let a1 = random.axis();
                    let a2 = if alpha == PI { -a1 } else { random.axis_at(a1, alpha) };
                    let lobe = |a: glam::DVec3, e| Lobe::with_flux(a.as_vec3().normalize(), e, Vec3::ONE);
                    let product = table.product(&lobe(a1, e1), &lobe(a2, e2));
                    assert!(product.flux.is_finite() && product.flux.x >= 0.0, "{e1} {e2} {alpha} {product:?}");
                    assert!(product.exponent.is_finite() && (product.axis.length() - 1.0).abs() < 1e-5);
                }
            }
        }
    }

    #[test]
    fn constant_on_a_hemisphere() {
        let table = ProductTable::build_with(SMALL);
        let half = Lobe::new(Vec3::X, 0.0, Vec3::ONE);
        let narrow = Lobe::new(Vec3::new(0.8, 0.0, 0.6), 1000.0, Vec3::ONE);
        let kept = table.product(&half, &narrow);
        assert!(
            (kept.flux.x / narrow.flux.x - 1.0).abs() < 0.02 && kept.axis.abs_diff_eq(narrow.axis, 1e-6),
            "{kept:?}"
        );
        let behind = table.product(&half, &Lobe { axis: -narrow.axis, ..narrow });
        assert!(behind.flux.x < 1e-6, "{behind:?}");
    }
}
