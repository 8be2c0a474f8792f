use crate::coat::MIN_ALPHA;
use crate::error::{check_coefficient, check_fraction};
use crate::rows::{self, RowTable};
use crate::sampling::{cosine_power_direction, luminance};
use crate::visible_normals::VisibleNormals;
use crate::wgsl::{MATERIAL, ModelWgsl};
use crate::{Brdf, BrdfSample, Factors, Material, MaterialError, Model, Packer};
use core::f32::consts::FRAC_1_PI;
use glam::Vec3;
use lobe_core::wgsl::Piece;
use lobe_core::{BrdfLobe, Lobe, Microfacets, Receiver};
use shading::BrdfLobes;

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
    fn scaled(&self, roughness: f32, color: Vec3) -> Self {
        let reflectances = self.reflectances.map(|f| f * color);
        Self { roughness: self.roughness * roughness, reflectances, rows: RowTable::Shared }
    }

    fn alpha(&self) -> f32 {
        (self.roughness * self.roughness).max(MIN_ALPHA)
    }

    fn rows(&self) -> &rows::Rows {
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

static MICROFACETS_WGSL: Piece = Piece::new(include_str!("half_vector_microfacets.wgsl")).needs(&[&MATERIAL]);

static DIRECTIONS_WGSL: Piece = Piece::new(include_str!("half_vector.wgsl")).needs(&[&rows::WGSL]);

impl Model for HalfVector {
    fn name(&self) -> &'static str {
        "half-vector"
    }

    fn validate(&self) -> Result<(), MaterialError> {
        check_coefficient("diffuse", self.diffuse)?;
        self.lobes.iter().try_for_each(HalfVectorLobe::validate)
    }

    fn lobe_count(&self) -> usize {
        1 + 2 * self.lobes.len()
    }

    fn cosine_lobe_count(&self) -> usize {
        1 + rows::LOBES * self.lobes.len()
    }

    fn scaled(&self, by: &Factors) -> Option<Material> {
        let lobes = self.lobes.iter().map(|lobe| lobe.scaled(by.roughness, by.specular)).collect();
        Some(Self { diffuse: self.diffuse * by.color, lobes }.into())
    }

    fn wgsl(&self) -> Option<ModelWgsl> {
        let own = ModelWgsl::new("half-vector-microfacets", &MICROFACETS_WGSL);
        Some(own.with_microfacets())
    }

    fn cosine_wgsl(&self) -> Option<ModelWgsl> {
        Some(ModelWgsl::new("half-vector", &DIRECTIONS_WGSL))
    }

    /// Of microfacets: exponent and reflectances of each.
    fn pack(&self, out: &mut Packer) -> u32 {
        let diffuse = out.push_diffuse(self.diffuse);
        out.push_word(1 - diffuse);
        for lobe in &self.lobes {
            let alpha = lobe.alpha();
            out.push([2.0 / (alpha * alpha) - 2.0]);
            out.push(lobe.reflectances.into_iter().flat_map(|f| f.to_array()));
        }
        diffuse + 2 * self.lobes.len() as u32
    }

    /// For each lobe where its half-vector lobe's rows and reflectances begin, and its slot.
    fn cosine_pack(&self, out: &mut Packer) -> u32 {
        let pack = |lobe: &HalfVectorLobe, out: &mut Packer| {
            let rows = rows::pack(lobe.rows(), out);
            let at = out.len();
            out.push_word(rows);
            out.push(lobe.reflectances.into_iter().flat_map(|f| f.to_array()));
            (at, rows::slots(lobe.rows(), 0))
        };
        let lobes: Vec<_> = self.lobes.iter().map(|lobe| pack(lobe, out)).collect();
        out.begin();
        let mut count = out.push_diffuse(self.diffuse);
        out.push_word(1 - count);
        for (at, (slots, used)) in lobes {
            for slot in &slots[..used as usize] {
                out.push_word(at);
                out.push_word(*slot);
            }
            count += used;
        }
        count
    }
}
