use crate::coat::MIN_ALPHA;
use crate::error::{check_coefficient, check_fraction};
use crate::rows::{self, RowTable};
use crate::sampling::{cosine_power_direction, luminance};
use crate::visible_normals::VisibleNormals;
use crate::{Brdf, BrdfSample, MaterialError};
use core::f32::consts::FRAC_1_PI;
use glam::Vec3;
use lobe_core::{BrdfLobe, BrdfLobes, Lobe, Microfacets, Receiver};

/// A diffuse part and lobes about the half vector, each with a roughness and colours of its own: what [`fit`](crate::fit()) makes of
/// measured metals. `f̃(v) = diffuse/π·(n·v) + Σ F·D(h)·W(v)`, with `D`, `W` and `h` of
/// [`MetallicRoughness`](crate::MetallicRoughness) and Schlick's `F = f0·(1 − s) + f90·s`, `s = (1 − ω_o·h)⁵`.
///
/// Reciprocal. Conserves energy while `diffuse + Σ max(f0, f90) ≤ 1`; a fit may do with more at grazing views, where nothing was measured.
///
/// # Lobes
/// Two of [`Microfacets`] for each, which are the model; the [cosine lobes](BrdfLobes::cosine_lobes) are those of
/// [`MetallicRoughness`](crate::MetallicRoughness).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HalfVector {
    /// Fraction of light that is reflected diffusely.
    pub diffuse: Vec3,
    /// The lobes.
    pub lobes: Vec<HalfVectorLobe>,
}

/// One lobe of [`HalfVector`].
#[derive(Clone, Debug)]
pub struct HalfVectorLobe {
    roughness: f32,
    reflectances: [Vec3; 2],
    rows: RowTable,
}

impl PartialEq for HalfVectorLobe {
    fn eq(&self, other: &Self) -> bool {
        // The rows follow from these.
        (self.roughness, self.reflectances) == (other.roughness, other.reflectances)
    }
}

impl HalfVectorLobe {
    /// The lobe of a roughness `√α` in [0, 1] and the reflectances `f0` at normal and `f90` at grazing incidence.
    #[must_use]
    pub fn new(roughness: f32, f0: Vec3, f90: Vec3) -> Self {
        Self { roughness, reflectances: [f0, f90], rows: RowTable::own() }
    }

    /// `√α`.
    #[must_use]
    pub const fn roughness(&self) -> f32 {
        self.roughness
    }

    /// `f0` and `f90`.
    #[must_use]
    pub const fn reflectances(&self) -> [Vec3; 2] {
        self.reflectances
    }

    /// One of many, a point's own.
    pub(crate) fn scaled(&self, roughness: f32, color: Vec3) -> Self {
        let reflectances = self.reflectances.map(|f| f * color);
        Self { roughness: self.roughness * roughness, reflectances, rows: RowTable::Shared }
    }

    pub(crate) fn alpha(&self) -> f32 {
        (self.roughness * self.roughness).max(MIN_ALPHA)
    }

    pub(crate) fn rows(&self) -> &rows::Rows {
        self.rows.get(self.roughness, (self.reflectances[0].element_sum() / 3.0).clamp(0.04, 1.0))
    }

    fn validate(&self) -> Result<(), MaterialError> {
        check_fraction("roughness", self.roughness)?;
        check_coefficient("f0", self.reflectances[0])?;
        check_coefficient("f90", self.reflectances[1])
    }

    fn microfacets(&self, at: &Receiver) -> [Microfacets; 2] {
        Microfacets::new(at.view, self.alpha(), self.reflectances)
    }

    fn visible(&self, at: &Receiver) -> VisibleNormals {
        VisibleNormals::new(at.normal, at.view, self.alpha())
    }

    /// How bright it is from here.
    fn weight(&self, at: &Receiver) -> f32 {
        let s = (1.0 - at.normal.dot(at.view).clamp(0.0, 1.0)).powi(5);
        let [f0, f90] = self.reflectances.map(luminance);
        f0 * (1.0 - s) + f90 * s
    }
}

impl HalfVector {
    /// Checks the parameters.
    ///
    /// # Errors
    /// [`MaterialError`] that names what is wrong.
    pub fn validate(&self) -> Result<(), MaterialError> {
        check_coefficient("diffuse", self.diffuse)?;
        self.lobes.iter().try_for_each(HalfVectorLobe::validate)
    }

    /// The diffuse part, and both parts of each lobe; without those that reflect nothing.
    pub(crate) fn lobes<'a>(&'a self, at: &'a Receiver) -> impl Iterator<Item = BrdfLobe> + Clone + 'a {
        let facets = self.lobes.iter().flat_map(|lobe| lobe.microfacets(at)).map(BrdfLobe::Microfacets);
        core::iter::once(self.diffuse_lobe(at).into()).chain(facets).filter(|lobe| lobe.flux() != Vec3::ZERO)
    }

    pub(crate) fn cosines<'a>(&'a self, at: &'a Receiver) -> impl Iterator<Item = Lobe> + Clone + 'a {
        let highlights = self.lobes.iter().flat_map(|lobe| rows::lobes(lobe.rows(), lobe.reflectances, at));
        core::iter::once(self.diffuse_lobe(at)).chain(highlights).filter(|lobe| lobe.flux != Vec3::ZERO)
    }

    fn diffuse_lobe(&self, at: &Receiver) -> Lobe {
        Lobe::with_flux(at.normal, 1.0, self.diffuse)
    }

    /// Of the diffuse part and of all lobes: how often each is drawn from.
    fn weights(&self, at: &Receiver) -> [f32; 2] {
        [luminance(self.diffuse), self.lobes.iter().map(|lobe| lobe.weight(at)).sum()]
    }
}

impl BrdfLobes for HalfVector {
    fn brdf_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
        out.extend(self.lobes(at));
    }

    fn cosine_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
        out.extend(self.cosines(at).map(BrdfLobe::Cosine));
    }
}

impl Brdf for HalfVector {
    fn eval(&self, at: &Receiver, v: Vec3) -> Vec3 {
        if at.normal.dot(v) <= 0.0 {
            return Vec3::ZERO;
        }
        self.lobes(at).map(|lobe| lobe.eval_at(at.normal, v)).sum()
    }

    fn sample(&self, at: &Receiver, u: [f32; 3]) -> Option<BrdfSample> {
        let [diffuse, lobes] = self.weights(at);
        let mut left = u[0] * (diffuse + lobes) - diffuse;
        let direction = if left < 0.0 {
            cosine_power_direction(at.normal, 1.0, u[1], u[2])
        } else {
            // The last one where rounding leaves something.
            let mut seen = self.lobes.iter().filter(|lobe| lobe.weight(at) > 0.0);
            let chosen = seen.clone().find(|lobe| {
                left -= lobe.weight(at);
                left < 0.0
            });
            chosen.or(seen.next_back())?.visible(at).draw([u[1], u[2]])
        };
        let pdf = self.pdf(at, direction);
        (pdf > 0.0).then_some(BrdfSample { direction, pdf })
    }

    fn pdf(&self, at: &Receiver, v: Vec3) -> f32 {
        let (cos, [diffuse, lobes]) = (at.normal.dot(v), self.weights(at));
        if cos <= 0.0 || diffuse + lobes <= 0.0 {
            return 0.0;
        }
        let highlights: f32 = self.lobes.iter().map(|lobe| lobe.weight(at) * lobe.visible(at).density(v)).sum();
        (diffuse * cos * FRAC_1_PI + highlights) / (diffuse + lobes)
    }
}
