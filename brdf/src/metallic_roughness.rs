use crate::anisotropy::{self, Anisotropy};
use crate::clearcoat::{self, Clearcoat};
use crate::coat::{self, Coat, MIN_ALPHA};
use crate::error::check_fraction;
use crate::rows::{self, RowTable, Rows};
use crate::sampling::{cosine_power_direction, luminance};
use crate::visible_normals::VisibleNormals;
use crate::wgsl::ModelWgsl;
use crate::{Brdf, BrdfSample, Factors, Material, MaterialError, Model, Packer};
use core::f32::consts::FRAC_1_PI;
use glam::Vec3;
use lobe_core::wgsl::Piece;
use lobe_core::{BrdfLobe, Lobe, Microfacets, Receiver};
use shading::BrdfLobes;

/// glTF's metallic–roughness material as lobes: a diffuse base under a dielectric coat, mixed with a
/// metal (glTF 2.0, appendix B; B. Walter et al., *Microfacet Models for Refraction through Rough Surfaces*, 2007).
///
/// With `α = roughness²`, `F0 = c + metallic·(base − c)`, `F90 = w + metallic·(1 − w)` and `h` half-way between `v` and `ω_o`:
/// `f̃ ≈ (1−metallic)·base/π·(1−F_d)·(n·v) + F·D(h)·W(v)`, `D = α²/π((n·h)²(α²−1)+1)²`,
/// `F = F0 + (F90−F0)(1−ω_o·h)⁵`, `W = G₂/(4 n·ω_o)` with Smith's height-correlated `G₂`. The coat has `c = 0.04` and `w = 1`, a
/// refractive index of 1.5, unless [`with_coat`](Self::with_coat) says otherwise.
///
/// `eval` and `sample` are this formula, but for the base: `1 − F_d` is its mean over the light's directions, so that coat and base
/// together give back no more than they get.
///
/// [`with_clearcoat`](Self::with_clearcoat) adds a layer above all of that, as KHR_materials_clearcoat has it:
/// `f̃·(1 − c·F_c) + c·F_c·D_c·W_c` with `F_c = 0.04 + 0.96(1 − n·ω_o)⁵`.
///
/// # Lobes
/// - By default [`Microfacets`]: `F·D·W` itself, with its long tails and its length at grazing views; two lobes, and one for a diffuse base; two for a clear coat.
/// - [Cosine lobes](BrdfLobes::cosine_lobes) for the paper's method and visibility as lobes: `D` is split into three or (α < 0.3) four parts, each of which
///   becomes a lobe with the same flux, mean direction and width across the plane of incidence, the two narrow ones up to three lobes
///   where the highlight is longer than wide (from about 30°): one to eight lobes, and one for a diffuse base.
///
/// # Accuracy
/// Microfacets: docs/materials.md has the table (radiance of lights of 0.5 to 25°: 0.2 % in the mean). Cosine lobes: the reflected
/// fraction is GGX's within 0.5 %, and never above 1. For roughness 0.1 … 1 the highlight's peak is within 9 % of GGX's up to 60° from the
/// normal, and its L2 residual 2–15 %. Beyond, three round lobes are no streak: at 75° the peak is 11–35 % low and the highlight up to
/// 1.8 times too wide across, at 80° 15–55 % and 2.6 times.
///
/// # Cost
/// Some milliseconds when its cosine lobes are first requested.
///
/// ```
/// use brdf::{Brdf, MetallicRoughness};
/// use glam::Vec3;
/// let gold = MetallicRoughness::new(Vec3::new(1.0, 0.77, 0.34), 1.0, 0.3)?;
/// let at = lobe_core::Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::Z);
/// // Straight back: F0·D/4 with D = 1/(π 0.09²).
/// let peak = gold.eval(&at, Vec3::Z);
/// assert!((peak.x - 9.82).abs() < 0.05 * 9.82);
/// # Ok::<(), brdf::MaterialError>(())
/// ```
#[derive(Clone, Debug)]
pub struct MetallicRoughness {
    pub(crate) base: Vec3,
    pub(crate) metallic: f32,
    pub(crate) roughness: f32,
    /// Of the coat, at normal and grazing incidence.
    coat: [Vec3; 2],
    rows: RowTable,
    clearcoat: Option<Clearcoat>,
    anisotropy: Option<Anisotropy>,
}

/// glTF's: a white, rough metal.
impl Default for MetallicRoughness {
    fn default() -> Self {
        let coat = [Vec3::splat(DIELECTRIC), Vec3::ONE];
        Self {
            base: Vec3::ONE,
            metallic: 1.0,
            roughness: 1.0,
            coat,
            rows: RowTable::own(),
            clearcoat: None,
            anisotropy: None,
        }
    }
}

impl PartialEq for MetallicRoughness {
    fn eq(&self, other: &Self) -> bool {
        // The rows follow from these.
        (self.base, self.metallic, self.roughness, self.coat, self.clearcoat, self.anisotropy)
            == (other.base, other.metallic, other.roughness, other.coat, other.clearcoat, other.anisotropy)
    }
}

impl MetallicRoughness {
    /// The material with base colour, metalness and roughness, all in [0, 1].
    ///
    /// # Errors
    /// [`MaterialError::Fraction`] for what lies outside.
    pub fn new(base: Vec3, metallic: f32, roughness: f32) -> Result<Self, MaterialError> {
        base.to_array().iter().try_for_each(|&b| check_fraction("base", b))?;
        check_fraction("metallic", metallic)?;
        check_fraction("roughness", roughness)?;
        Ok(Self { base, metallic, roughness, ..Self::default() })
    }

    /// Another coat than that of refractive index 1.5: its reflectance at normal incidence and at grazing views, both in [0, 1]; the
    /// second no less than the first. An index `η` has `f0 = ((η − 1)/(η + 1))²` and `f90 = 1`.
    ///
    /// # Errors
    /// [`MaterialError::Fraction`] for what lies outside.
    pub fn with_coat(self, f0: Vec3, f90: f32) -> Result<Self, MaterialError> {
        f0.to_array().iter().try_for_each(|&f| check_fraction("f0", f))?;
        check_fraction("f90", f90)?;
        if f90 < f0.max_element() {
            return Err(MaterialError::Fraction { name: "f90 less than f0", value: f90 });
        }
        // Cosine lobes that are there are another coat's.
        Ok(Self { coat: [f0, Vec3::splat(f90)], rows: RowTable::own(), ..self })
    }

    /// With a clear coat above all: its weight `c` and its roughness, both in [0, 1]. It reflects by its own microfacets, of a refractive index of
    /// 1.5, and what is below gets the rest of the light. Without one where the weight is 0.
    ///
    /// Conserves energy, as the weight has the eye's angle for both. It is for that not reciprocal.
    ///
    /// # Errors
    /// [`MaterialError::Fraction`] for what lies outside.
    ///
    /// ```
    /// use brdf::{Brdf, MetallicRoughness};
    /// use glam::Vec3;
    /// let paint = MetallicRoughness::new(Vec3::new(0.6, 0.02, 0.02), 0.0, 0.6)?;
    /// let varnished = paint.clone().with_clearcoat(1.0, 0.1)?;
    /// let at = lobe_core::Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::Z);
    /// // Straight back a highlight is added, of 0.04·D/4; beside it 4 % of the light is missing.
    /// let added = varnished.eval(&at, Vec3::Z).x - 0.96 * paint.eval(&at, Vec3::Z).x;
    /// assert!((added - 0.01 / (core::f32::consts::PI * 1e-4)).abs() < 0.01);
    /// let beside = Vec3::new(0.8, 0.0, 0.6);
    /// assert!((varnished.eval(&at, beside).x / paint.eval(&at, beside).x - 0.96).abs() < 1e-3);
    /// # Ok::<(), brdf::MaterialError>(())
    /// ```
    pub fn with_clearcoat(self, weight: f32, roughness: f32) -> Result<Self, MaterialError> {
        check_fraction("clearcoat", weight)?;
        check_fraction("clearcoat roughness", roughness)?;
        let clearcoat = (weight > 0.0).then_some(Clearcoat { weight, roughness, normal: None });
        Ok(Self { clearcoat, ..self })
    }

    /// Brushed, by a strength in [0, 1]: along the tangent ([`Material::turned`]) microfacets have `α_t = α + (1 − α) strength²`, across it `α`, as
    /// KHR_materials_anisotropy has it (GGX as B. Burley, *Physically Based Shading at Disney*, 2012, has it). Exact as lobes of microfacets; cosine lobes
    /// have no grain.
    ///
    /// # Errors
    /// [`MaterialError::Fraction`] for what lies outside.
    ///
    /// ```
    /// use brdf::{Brdf, Material, MetallicRoughness};
    /// use glam::Vec3;
    /// let brushed = Material::from(MetallicRoughness::new(Vec3::ONE, 1.0, 0.3)?.with_anisotropy(0.7)?);
    /// let brushed = brushed.turned(Vec3::Z, Vec3::X).unwrap();
    /// let at = lobe_core::Receiver::on_surface(Vec3::ZERO, Vec3::Z, Vec3::Z);
    /// let [along, across] = [Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.0, 0.6, 0.8)].map(|v| brushed.eval(&at, v).x);
    /// assert!(along > 10.0 * across);
    /// # Ok::<(), brdf::MaterialError>(())
    /// ```
    pub fn with_anisotropy(self, strength: f32) -> Result<Self, MaterialError> {
        check_fraction("anisotropy", strength)?;
        let anisotropy = (strength > 0.0).then_some(Anisotropy { strength, tangent: None });
        Ok(Self { anisotropy, ..self })
    }

    /// The strength of its anisotropy; 0 without one.
    #[must_use]
    pub fn anisotropy(&self) -> f32 {
        self.anisotropy.map_or(0.0, |anisotropy| anisotropy.strength)
    }

    /// The roughness of an isotropic surface that stands for it.
    fn mean_roughness(&self) -> f32 {
        self.anisotropy.map_or(self.roughness, |anisotropy| anisotropy.mean(self.alpha()))
    }

    /// Weight and roughness of the clear coat, if there is one.
    #[must_use]
    pub fn clearcoat(&self) -> Option<(f32, f32)> {
        self.clearcoat.map(|coat| (coat.weight, coat.roughness))
    }

    /// The same coats on another base: colour, metalness and roughness, all in [0, 1].
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_base(self, base: Vec3, metallic: f32, roughness: f32) -> Result<Self, MaterialError> {
        let (clearcoat, anisotropy) = (self.clearcoat, self.anisotropy);
        Ok(Self { coat: self.coat, clearcoat, anisotropy, ..Self::new(base, metallic, roughness)? })
    }

    /// Base colour, metalness and roughness.
    ///
    /// ```
    /// # use brdf::MetallicRoughness;
    /// # use glam::Vec3;
    /// let metal = MetallicRoughness::new(Vec3::ONE, 1.0, 0.3)?;
    /// let (base, metallic, roughness) = metal.base();
    /// assert_eq!(metal.clone().with_base(base, metallic, roughness)?, metal);
    /// # Ok::<(), brdf::MaterialError>(())
    /// ```
    #[must_use]
    pub const fn base(&self) -> (Vec3, f32, f32) {
        (self.base, self.metallic, self.roughness)
    }

    pub(crate) fn rows(&self) -> &Rows {
        self.rows.get(self.mean_roughness(), self.reflectances()[0].element_sum() / 3.0)
    }

    /// Of coat and metal, at normal and at grazing incidence.
    pub(crate) fn reflectances(&self) -> [Vec3; 2] {
        [self.coat[0].lerp(self.base, self.metallic), self.coat[1].lerp(Vec3::ONE, self.metallic)]
    }

    /// The coat as the base sees it.
    pub(crate) fn coat(&self) -> Coat {
        Coat { f0: self.coat[0].max_element(), f90: self.coat[1].x, base: self.base.max_element() }
    }

    /// A diffuse lobe and two of microfacets.
    const LOBES: usize = 3;

    /// The part of its light that a clear coat above leaves to all the rest.
    fn below(&self, at: &Receiver) -> f32 {
        self.clearcoat.map_or(1.0, |coat| 1.0 - coat.reflects(at))
    }

    /// The diffuse base, if there is one, and both parts of the coat or metal.
    fn lobes_below(&self, at: &Receiver) -> impl Iterator<Item = BrdfLobe> + Clone + use<> {
        let below = self.below(at);
        let diffuse = self.base * (1.0 - self.metallic) * self.diffuse(at) * below;
        let diffuse = (diffuse != Vec3::ZERO).then(|| Lobe::with_flux(at.normal, 1.0, diffuse).into());
        let facets = Microfacets::new(at.view, self.alpha(), self.reflectances().map(|f| f * below));
        let grain = self.anisotropy.and_then(|anisotropy| anisotropy.grain(at));
        let facets = facets.map(|facets| facets.with_grain(grain));
        diffuse.into_iter().chain(facets.map(BrdfLobe::Microfacets))
    }

    /// The same, and both parts of a clear coat.
    pub(crate) fn lobes(&self, at: &Receiver) -> impl Iterator<Item = BrdfLobe> + Clone + use<> {
        let coat = self.clearcoat.map(|coat| coat.facets(at).map(BrdfLobe::Microfacets));
        self.lobes_below(at).chain(coat.into_iter().flatten())
    }

    pub(crate) fn alpha(&self) -> f32 {
        (self.roughness * self.roughness).max(MIN_ALPHA)
    }

    /// The share that the coat leaves to a white diffuse base.
    fn diffuse(&self, at: &Receiver) -> f32 {
        let cos = at.normal.dot(at.view).clamp(0.0, 1.0);
        let sin = (at.normal * at.normal.dot(at.view) - at.view).length().min(1.0);
        self.coat().leaves(self.mean_roughness(), cos, sin)
    }

    pub(crate) fn cosines(&self, at: &Receiver) -> impl Iterator<Item = Lobe> + Clone + use<> {
        let below = self.below(at);
        let diffuse = self.base * ((1.0 - self.metallic) * self.diffuse(at)) * below;
        let diffuse = (diffuse != Vec3::ZERO).then(|| Lobe::with_flux(at.normal, 1.0, diffuse));
        let highlights = rows::lobes(self.rows(), self.reflectances().map(|f| f * below), at);
        let coat = self.clearcoat.map(|coat| coat.cosines(at));
        diffuse.into_iter().chain(highlights).chain(coat.into_iter().flatten())
    }
}

/// `F0` of glTF's coat.
const DIELECTRIC: f32 = 0.04;

impl BrdfLobes for MetallicRoughness {
    fn brdf_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
        out.extend(self.lobes(at));
    }

    fn cosine_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
        out.extend(self.cosines(at).map(BrdfLobe::Cosine));
    }
}

impl Brdf for MetallicRoughness {
    fn eval(&self, at: &Receiver, v: Vec3) -> Vec3 {
        if at.normal.dot(v) <= 0.0 {
            return Vec3::ZERO;
        }
        let below: Vec3 = self.lobes_below(at).map(|lobe| lobe.eval_at(at.normal, v)).sum();
        // About its own normal, where its lobes are about the receiver's.
        self.clearcoat.map_or(below, |coat| below + coat.eval(at, v))
    }

    /// Of the base in proportion to the cosine, of coats by the normals that the eye sees (E. Heitz, *Sampling the GGX
    /// Distribution of Visible Normals*, 2018).
    fn sample(&self, at: &Receiver, u: [f32; 3]) -> Option<BrdfSample> {
        let of_clearcoat = self.chance_of_clearcoat(at);
        let direction = match self.clearcoat {
            Some(coat) if u[0] < of_clearcoat => coat.visible(at).draw([u[1], u[2]]),
            _ if (u[0] - of_clearcoat) < self.chance_of_base(at) * (1.0 - of_clearcoat) => {
                cosine_power_direction(at.normal, 1.0, u[1], u[2])
            }
            _ => self.visible(at).draw([u[1], u[2]]),
        };
        let pdf = self.pdf(at, direction);
        (pdf > 0.0).then_some(BrdfSample { direction, pdf })
    }

    fn pdf(&self, at: &Receiver, v: Vec3) -> f32 {
        let cos = at.normal.dot(v);
        if cos <= 0.0 {
            return 0.0;
        }
        let chance = self.chance_of_base(at);
        let below = chance * cos * FRAC_1_PI + (1.0 - chance) * self.visible(at).density(v);
        self.clearcoat.map_or(below, |coat| {
            let of_clearcoat = self.chance_of_clearcoat(at);
            below + of_clearcoat * (coat.visible(at).density(v) - below)
        })
    }
}

impl MetallicRoughness {
    /// How often the diffuse base is chosen: as much of it as there is, but never all or nothing of two.
    fn chance_of_base(&self, at: &Receiver) -> f32 {
        let [base, coat] = self.brightness(at);
        if base > 0.0 { (base / (base + coat)).clamp(0.1, 0.9) } else { 0.0 }
    }

    /// The same of a clear coat among all.
    fn chance_of_clearcoat(&self, at: &Receiver) -> f32 {
        let part = self.clearcoat.map_or(0.0, |coat| coat.reflects(at));
        let [base, coat] = self.brightness(at);
        if part > 0.0 { (part / (part + (1.0 - part) * (base + coat))).clamp(0.1, 0.9) } else { 0.0 }
    }

    /// Of the diffuse base, and of the coat or metal.
    fn brightness(&self, at: &Receiver) -> [f32; 2] {
        let base = luminance(self.base) * (1.0 - self.metallic) * self.diffuse(at);
        let cos = at.normal.dot(at.view).clamp(0.0, 1.0);
        let [f0, f90] = self.reflectances().map(luminance);
        [base, f0 + (f90 - f0) * (1.0 - cos).powi(5)]
    }

    fn visible(&self, at: &Receiver) -> VisibleNormals {
        let brushed = self.anisotropy.and_then(|anisotropy| anisotropy.visible(at, self.alpha()));
        brushed.unwrap_or_else(|| VisibleNormals::new(at.normal, at.view, self.alpha()))
    }
}

static MICROFACETS_WGSL: Piece = Piece::new(include_str!("metallic_microfacets.wgsl")).needs(&[&coat::WGSL]);
static COATED_MICROFACETS_WGSL: Piece =
    Piece::new(include_str!("clearcoat_microfacets.wgsl")).needs(&[&MICROFACETS_WGSL, &clearcoat::WGSL]);
static BRUSHED_MICROFACETS_WGSL: Piece =
    Piece::new(include_str!("brushed_microfacets.wgsl")).needs(&[&MICROFACETS_WGSL, &anisotropy::WGSL]);
static COATED_BRUSHED_MICROFACETS_WGSL: Piece = Piece::new(include_str!("clearcoat_brushed_microfacets.wgsl"))
    .needs(&[&COATED_MICROFACETS_WGSL, &anisotropy::WGSL]);
static DIRECTIONS_WGSL: Piece = Piece::new(include_str!("metallic_roughness.wgsl")).needs(&[&coat::WGSL, &rows::WGSL]);
static COATED_DIRECTIONS_WGSL: Piece =
    Piece::new(include_str!("clearcoat_directions.wgsl")).needs(&[&DIRECTIONS_WGSL, &clearcoat::WGSL]);

/// Was checked when it was made.
impl Model for MetallicRoughness {
    fn name(&self) -> &'static str {
        "metallic-roughness"
    }

    fn lobe_count(&self) -> usize {
        Self::LOBES + if self.clearcoat.is_some() { 2 } else { 0 }
    }

    fn cosine_lobe_count(&self) -> usize {
        1 + rows::LOBES * if self.clearcoat.is_some() { 2 } else { 1 }
    }

    /// One of many, a point's own.
    fn scaled(&self, by: &Factors) -> Option<Material> {
        let [f0, f90] = self.coat;
        let scaled = Self {
            base: self.base * by.color,
            metallic: self.metallic * by.metallic,
            roughness: self.roughness * by.roughness,
            coat: [f0 * by.specular * by.coat, f90 * by.coat],
            rows: RowTable::Shared,
            clearcoat: self.clearcoat.map(|coat| coat.scaled(by)),
            anisotropy: self.anisotropy.map(|own| Anisotropy { strength: own.strength * by.anisotropy, ..own }),
        };
        Some(scaled.into())
    }

    fn turned(&self, normal: Vec3, tangent: Vec3) -> Option<Material> {
        // Meshes without coordinates have none.
        let aside = tangent - normal * normal.dot(tangent);
        let tangent = (aside != Vec3::ZERO).then_some(tangent);
        let anisotropy = Anisotropy { tangent, ..self.anisotropy? };
        Some(Self { anisotropy: Some(anisotropy), ..self.clone() }.into())
    }

    fn with_clearcoat_normal(&self, normal: Vec3) -> Option<Material> {
        let clearcoat = Clearcoat { normal: Some(normal), ..self.clearcoat? };
        Some(Self { clearcoat: Some(clearcoat), ..self.clone() }.into())
    }

    fn lets_out(&self, at: &Receiver) -> f32 {
        self.below(at)
    }

    fn wgsl(&self) -> Option<ModelWgsl> {
        let round = |name, piece| ModelWgsl::new(name, piece).with_microfacets();
        let brushed = |name, piece| ModelWgsl::new(name, piece).with_grain();
        Some(match (self.clearcoat.is_some(), self.anisotropy.is_some()) {
            (false, false) => round("metallic-microfacets", &MICROFACETS_WGSL),
            (true, false) => round("clearcoat-microfacets", &COATED_MICROFACETS_WGSL),
            (false, true) => brushed("brushed-microfacets", &BRUSHED_MICROFACETS_WGSL),
            (true, true) => brushed("clearcoat-brushed-microfacets", &COATED_BRUSHED_MICROFACETS_WGSL),
        })
    }

    fn cosine_wgsl(&self) -> Option<ModelWgsl> {
        Some(match self.clearcoat {
            None => ModelWgsl::new("metallic-roughness", &DIRECTIONS_WGSL),
            Some(_) => ModelWgsl::new("clearcoat-directions", &COATED_DIRECTIONS_WGSL),
        })
    }

    fn pack(&self, out: &mut Packer) -> u32 {
        let coat = coat::pack(out);
        let has_base = self.pack_numbers(coat, out);
        out.push_word(has_base);
        if let Some(coat) = self.clearcoat {
            coat.pack(out);
        }
        if let Some(anisotropy) = self.anisotropy {
            anisotropy.pack(out);
        }
        has_base + if self.clearcoat.is_some() { 4 } else { 2 }
    }

    fn cosine_pack(&self, out: &mut Packer) -> u32 {
        let coat = coat::pack(out);
        let rows = rows::pack(self.rows(), out);
        let clearcoat = self.clearcoat.map(|coat| (coat, coat.pack_rows(out)));
        let has_base = self.pack_numbers(coat, out);
        out.push_word(rows);
        let (slots, lobes) = rows::slots(self.rows(), has_base);
        slots.into_iter().for_each(|slot| out.push_word(slot));
        let Some((coat, (rows, slots, above))) = clearcoat else { return lobes };
        out.push_word(lobes);
        coat.pack(out);
        out.push_word(rows);
        slots.into_iter().for_each(|slot| out.push_word(slot));
        lobes + above
    }
}

impl MetallicRoughness {
    /// The numbers that both kinds of lobes come from; 1 if there is a diffuse base.
    fn pack_numbers(&self, coat: u32, out: &mut Packer) -> u32 {
        out.begin();
        let diffuse = self.base * (1.0 - self.metallic);
        let [f0, f90] = self.reflectances();
        let below = self.coat();
        out.push(diffuse.to_array().into_iter().chain(f0.to_array()));
        out.push([f90.x, self.mean_roughness(), below.f0, below.f90, below.base, self.alpha()]);
        out.push_word(coat);
        u32::from(diffuse != Vec3::ZERO)
    }
}
