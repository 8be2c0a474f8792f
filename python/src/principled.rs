//! Blender's Principled: GGX with several scatterings over a diffuse base, layered by the light that the dielectric reflects, below a clear coat.

use cosine_lobes::brdf::{Brdf, Factors, Material, Model};
use cosine_lobes::lobe_core::{BrdfLobe, Lobe, Microfacets, Receiver};
use cosine_lobes::shading::BrdfLobes;
use glam::Vec3;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Rows, even in roughness, and columns, even in `√(1 − n·ω_o)`.
const ROUGHNESSES: usize = 17;
const VIEWS: usize = 32;
/// Normals that a node is the mean of, along each side.
const NORMALS: usize = 20;
/// Smallest `α = roughness²`, as of the other materials.
const MIN_ALPHA: f32 = 1e-3;

/// `f̃ = metallic·m·S_m + (1 − metallic)·(k·m_d·S_d + base/π·(n·v)·(1 − A))`, `S` GGX with Schlick's reflectance, from `f0` (of the metal: base)
/// to 1. As Blender 4 and 5 have it:
/// - `m = 1 + F_ms (1 − E)/E` gives back what scatters more than once, `F_ms = F_ss E_avg/(1 − F_ss (1 − E_avg))` (C. Kulla and A. Conty, *Revisiting
///   Physically Based Shading at Imageworks*, 2017), `E` the part that a white coat reflects toward this view, `E_avg` its mean.
/// - `k` is Fresnel's reflection over Schlick's, both of all light toward this view: for lobes alone, Schlick's shape has Fresnel's strength.
/// - `A` is what the dielectric reflects in all toward this view, the largest channel.
///
/// With a clear coat of weight `c` it is `c·k_c·S_c + (1 − c·A_c)·(1 + c·(t^d − 1))·f̃`, where `S_c` and `k_c` are as of a dielectric whose light scatters once, `t` is the coat's tint and
/// `d = 1/cos θ_t` the way through it of a view that is refracted into it.
#[derive(Clone, Debug)]
pub(crate) struct Principled {
    pub(crate) base: Vec3,
    pub(crate) metallic: f32,
    pub(crate) roughness: f32,
    /// Of the dielectric at normal incidence.
    pub(crate) f0: Vec3,
    /// Whether light that scatters more than once counts.
    pub(crate) scatters: bool,
    table: Arc<Table>,
    coat: Option<Coat>,
}

/// A clear coat over all.
#[derive(Clone, Debug)]
struct Coat {
    weight: f32,
    roughness: f32,
    ior: f32,
    tint: Vec3,
    table: Arc<Table>,
}

impl Coat {
    fn alpha(&self) -> f32 {
        (self.roughness * self.roughness).max(MIN_ALPHA)
    }

    /// The reflectances of its lobes, at normal and at grazing incidence, and the part of all light below that remains.
    fn layer(&self, cos: f32) -> ([Vec3; 2], Vec3) {
        let (node, _) = self.table.at(self.roughness, cos);
        let f0 = normal_incidence(f64::from(self.ior)) as f32;
        let reflected = |rise: f32| f0 * (node.all - rise) + rise;
        let full = reflected(node.fresnel);
        let strength = self.weight * full / reflected(node.schlick).max(1e-6);
        let refracted = (1.0 - (1.0 - cos * cos) / (self.ior * self.ior)).max(1e-6).sqrt();
        let through = Vec3::ONE.lerp(self.tint.powf(1.0 / refracted), self.weight);
        ([Vec3::splat(f0 * strength), Vec3::splat(strength)], through * (1.0 - self.weight * full))
    }
}

/// At a roughness, for a view.
#[derive(Clone, Copy, Debug, Default)]
struct Node {
    /// Reflected if all normals reflect all, `E`.
    all: f32,
    /// Reflected with Schlick's `(1 − v·h)⁵`.
    schlick: f32,
    /// Reflected with Fresnel's reflectance, from 0 at normal incidence to 1.
    fresnel: f32,
}

/// The reflection of dielectrics of one refractive index.
#[derive(Debug)]
struct Table {
    nodes: Vec<[Node; VIEWS]>,
    /// `E_avg` of each roughness.
    mean: [f32; ROUGHNESSES],
    /// Mean of Fresnel's reflectance, from 0 to 1 likewise.
    fresnel: f32,
}

impl Node {
    fn mixed(self, other: Self, t: f32) -> Self {
        let mix = |a: f32, b: f32| a + (b - a) * t;
        Self {
            all: mix(self.all, other.all),
            schlick: mix(self.schlick, other.schlick),
            fresnel: mix(self.fresnel, other.fresnel),
        }
    }
}

/// Fresnel's reflectance of unpolarised light, at this cosine.
fn fresnel(cos: f64, ior: f64) -> f64 {
    let root = (ior * ior - 1.0 + cos * cos).max(0.0).sqrt();
    let (a, b) = ((root - cos) / (root + cos), (cos * (root + cos) - 1.0) / (cos * (root - cos) + 1.0));
    0.5 * a * a * (1.0 + b * b)
}

/// `F0` of a refractive index.
fn normal_incidence(ior: f64) -> f64 {
    ((ior - 1.0) / (ior + 1.0)).powi(2)
}

/// Mean over the normals that the eye sees (E. Heitz, *Sampling the GGX Distribution of Visible Normals*, 2018).
fn node(alpha: f64, cos: f64, ior: f64) -> Node {
    let view = glam::DVec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
    let stretched = glam::DVec3::new(alpha * view.x, 0.0, cos).normalize();
    let across = glam::DVec3::Y;
    let along = stretched.cross(across);
    let lambda = |z: f64| 0.5 * ((1.0 + alpha * alpha * (1.0 / (z * z) - 1.0)).sqrt() - 1.0);
    let (own, low) = (lambda(cos.max(1e-6)), normal_incidence(ior));
    let mut sums = [0.0; 3];
    for i in 0..NORMALS {
        for j in 0..NORMALS {
            let [u, v] = [i, j].map(|k| (k as f64 + 0.5) / NORMALS as f64);
            let (sin, turn) = (TAU * v).sin_cos();
            let (x, y) = (u.sqrt() * turn, u.sqrt() * sin);
            let half = 0.5 * (1.0 + stretched.z);
            let y = (1.0 - half) * (1.0 - x * x).max(0.0).sqrt() + half * y;
            let n = across * x + along * y + stretched * (1.0 - x * x - y * y).max(0.0).sqrt();
            let h = glam::DVec3::new(alpha * n.x, alpha * n.y, n.z.max(1e-9)).normalize();
            let vh = view.dot(h);
            let z = 2.0 * vh * h.z - cos;
            if z > 0.0 {
                let weight = (1.0 + own) / (1.0 + own + lambda(z));
                let full = if low < 1.0 { (fresnel(vh.max(0.0), ior) - low) / (1.0 - low) } else { 0.0 };
                for (sum, part) in sums.iter_mut().zip([1.0, (1.0 - vh).powi(5), full]) {
                    *sum += weight * part;
                }
            }
        }
    }
    let [all, schlick, fresnel] = sums.map(|sum| (sum / (NORMALS * NORMALS) as f64) as f32);
    Node { all, schlick, fresnel }
}

impl Table {
    fn new(ior: f64) -> Self {
        let cosine = |i: usize| 1.0 - (i as f64 / (VIEWS - 1) as f64).powi(2);
        let row = |r: usize| {
            let roughness = r as f64 / (ROUGHNESSES - 1) as f64;
            let alpha = (roughness * roughness).max(f64::from(MIN_ALPHA));
            core::array::from_fn(|i| node(alpha, cosine(i).max(1e-3), ior))
        };
        let nodes: Vec<[Node; VIEWS]> = (0..ROUGHNESSES).map(row).collect();
        // ∫ 2 E μ dμ by trapezoids.
        let step = |row: &[Node; VIEWS], i: usize| {
            let [a, b] = [cosine(i), cosine(i + 1)];
            (a - b) * (a * f64::from(row[i].all) + b * f64::from(row[i + 1].all))
        };
        let mean = core::array::from_fn(|r| (0..VIEWS - 1).map(|i| step(&nodes[r], i)).sum::<f64>() as f32);
        // A fit of Kulla and Conty's.
        let (low, average) = (normal_incidence(ior), (ior - 1.0) / (4.08567 + 1.00071 * ior));
        let fresnel = if low < 1.0 { ((average - low) / (1.0 - low)).clamp(0.0, 1.0) as f32 } else { 0.0 };
        Self { nodes, mean, fresnel }
    }

    /// The node of a roughness and a view, and `E_avg`.
    fn at(&self, roughness: f32, cos: f32) -> (Node, f32) {
        let (column, t) = place((1.0 - cos).max(0.0).sqrt(), VIEWS);
        let (row, s) = place(roughness, ROUGHNESSES);
        let [a, b] = [row, row + 1].map(|r| self.nodes[r][column].mixed(self.nodes[r][column + 1], t));
        (a.mixed(b, s), self.mean[row] + (self.mean[row + 1] - self.mean[row]) * s)
    }
}

/// The node before a place in [0, 1] and how far it is on to the next.
fn place(at: f32, nodes: usize) -> (usize, f32) {
    let at = at.clamp(0.0, 1.0) * (nodes - 1) as f32;
    let first = (at as usize).min(nodes - 2);
    (first, at - first as f32)
}

impl Principled {
    /// Base colour, metalness, roughness and tint within [0, 1], and the refractive index of the dielectric, at least 1.
    pub(crate) fn new(base: Vec3, [metallic, roughness]: [f32; 2], ior: f64, tint: Vec3, scatters: bool) -> Self {
        let (f0, table) = (normal_incidence(ior) as f32 * tint, Arc::new(Table::new(ior)));
        Self { base, metallic, roughness, f0, scatters, table, coat: None }
    }

    /// Weight, roughness and tint of the coat within [0, 1], and its refractive index, at least 1.
    pub(crate) fn with_coat(self, [weight, roughness]: [f32; 2], ior: f32, tint: Vec3) -> Self {
        let coat =
            (weight > 0.0).then(|| Coat { weight, roughness, ior, tint, table: Arc::new(Table::new(f64::from(ior))) });
        Self { coat, ..self }
    }

    fn alpha(&self) -> f32 {
        (self.roughness * self.roughness).max(MIN_ALPHA)
    }

    /// Factor of a lobe with the mean reflectance `F_ss`, for what scatters more than once.
    fn again(&self, node: Node, mean: f32, fss: Vec3) -> Vec3 {
        if !self.scatters {
            return Vec3::ONE;
        }
        let missing = (1.0 - node.all).max(0.0) / node.all.max(1e-3);
        let often = fss * mean / (Vec3::ONE - fss * (1.0 - mean)).max(Vec3::splat(1e-3));
        Vec3::ONE + often * missing
    }

    fn lobes(&self, at: &Receiver) -> impl Iterator<Item = BrdfLobe> + use<> {
        let cos = at.normal.dot(at.view).clamp(0.0, 1.0);
        let (node, mean) = self.table.at(self.roughness, cos);
        let (coat, beneath) = self.coat.as_ref().map_or(([Vec3::ZERO; 2], Vec3::ONE), |coat| coat.layer(cos));
        let dielectric = 1.0 - self.metallic;
        let reflected = |f0: Vec3, rise: f32| f0 * (node.all - rise) + rise;
        let (full, plain) = (reflected(self.f0, node.fresnel), reflected(self.f0, node.schlick));
        let fss = self.f0.lerp(Vec3::ONE, self.table.fresnel);
        // No reflection without a refractive index.
        let reflects = if self.f0 == Vec3::ZERO { 0.0 } else { 1.0 };
        let scatter = self.again(node, mean, fss) * reflects;
        let strength = scatter * full / plain.max(Vec3::splat(1e-6)) * dielectric;
        let metal = self.again(node, mean, self.base.lerp(Vec3::ONE, 1.0 / 21.0)) * self.metallic;
        let reflectances = [self.f0 * strength + self.base * metal, strength + metal].map(|f| f * beneath);
        let below = 1.0 - (full * scatter).max_element().clamp(0.0, 1.0);
        let diffuse = Lobe::with_flux(at.normal, 1.0, self.base * beneath * (dielectric * below));
        let facets = Microfacets::new(at.view, self.alpha(), reflectances);
        let coat = Microfacets::new(at.view, self.coat.as_ref().map_or(1.0, Coat::alpha), coat);
        let all = core::iter::once(diffuse.into()).chain(facets.into_iter().chain(coat).map(BrdfLobe::Microfacets));
        all.filter(|lobe: &BrdfLobe| lobe.flux() != Vec3::ZERO)
    }
}

impl BrdfLobes for Principled {
    fn brdf_lobes(&self, at: &Receiver, out: &mut Vec<BrdfLobe>) {
        out.extend(self.lobes(at));
    }
}

impl Brdf for Principled {
    fn eval(&self, at: &Receiver, v: Vec3) -> Vec3 {
        if at.normal.dot(v) <= 0.0 {
            return Vec3::ZERO;
        }
        self.lobes(at).map(|lobe| lobe.eval_at(at.normal, v)).sum()
    }
}

/// Was checked when it was made.
impl Model for Principled {
    fn name(&self) -> &'static str {
        "principled"
    }

    fn lobe_count(&self) -> usize {
        if self.coat.is_some() { 5 } else { 3 }
    }

    /// One of many, a point's own.
    fn scaled(&self, by: &Factors) -> Option<Material> {
        let scaled = Self {
            base: self.base * by.color,
            metallic: self.metallic * by.metallic,
            roughness: self.roughness * by.roughness,
            f0: self.f0 * by.specular,
            ..self.clone()
        };
        Some(Material::Custom(Arc::new(scaled)))
    }
}
