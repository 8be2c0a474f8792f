//! Lobes of the materials against those of `brdf`.

use crate::call::{call_with, trial};
use brdf::{
    Factors, HalfVector, HalfVectorLobe, Lafortune, LafortuneLobe, Lambert, Material, MetallicRoughness, ModifiedPhong,
    Neumann, PackedMaterials, Phong,
};
use glam::{DMat3, Mat3, Quat, Vec3};
use libtest_mimic::Trial;
use lobe_core::wgsl::join;
use lobe_core::{BrdfLobe, PackedLobe, Receiver, orthonormal_basis};
use render_gpu::Gpu;
use shading::BrdfLobes;

pub(crate) fn trials(gpu: Option<&Gpu>) -> Vec<Trial> {
    vec![
        trial("materials_lambert", gpu, |gpu| agree(gpu, &several(lambert, 8))),
        trial("materials_phong", gpu, |gpu| agree(gpu, &several(phong, 100))),
        trial("materials_modified_phong", gpu, |gpu| agree(gpu, &several(modified_phong, 100))),
        trial("materials_half_vector", gpu, |gpu| agree(gpu, &several(half_vector, 12))),
        trial("materials_neumann", gpu, |gpu| agree(gpu, &several(neumann, 100))),
        trial("materials_lafortune", gpu, |gpu| agree(gpu, &several(lafortune, 150))),
        trial("materials_metallic_roughness", gpu, |gpu| agree(gpu, &several(metallic_roughness, 24))),
        trial("materials_clearcoat", gpu, |gpu| agree(gpu, &several(clearcoat, 24))),
        trial("materials_brushed", gpu, |gpu| agree(gpu, &several(brushed, 24))),
        trial("materials_of_all_models", gpu, |gpu| {
            let models = [
                lambert,
                phong,
                modified_phong,
                neumann,
                lafortune,
                metallic_roughness,
                clearcoat,
                brushed,
                half_vector,
            ];
            agree(gpu, &models.map(|model| several(model, 8)).concat());
        }),
        trial("materials_lafortune_without_an_axis", gpu, no_axis),
    ]
}

/// Numbers, directions and colours.
struct Random(lobe_core::Random);

impl Random {
    const fn new(seed: u64) -> Self {
        Self(lobe_core::Random::new(seed))
    }

    /// In [0, 1).
    fn next(&mut self) -> f32 {
        (self.0.bits() >> 40) as f32 / (1u64 << 24) as f32
    }

    fn direction(&mut self) -> Vec3 {
        let (z, phi) = (2.0 * self.next() - 1.0, core::f32::consts::TAU * self.next());
        let s = (1.0 - z * z).sqrt();
        Vec3::new(s * phi.cos(), s * phi.sin(), z).normalize()
    }

    /// A colour, sometimes black.
    fn color(&mut self) -> Vec3 {
        let color = Vec3::new(self.next(), self.next(), self.next());
        if self.next() < 0.2 { Vec3::ZERO } else { color }
    }

    /// From 0 to 1e6, every magnitude.
    fn exponent(&mut self) -> f32 {
        if self.next() < 0.1 { 0.0 } else { 10.0_f32.powf(8.0 * self.next() - 2.0) }
    }
}

fn several(model: fn(&mut Random) -> Material, count: usize) -> Vec<Material> {
    let mut random = Random::new(7);
    let all: Vec<Material> = (0..count).map(|_| model(&mut random)).collect();
    all.iter().for_each(|material| material.validate().expect("a valid material"));
    all
}

fn lambert(random: &mut Random) -> Material {
    Lambert { albedo: random.color() }.into()
}

fn phong(random: &mut Random) -> Material {
    Phong { kd: random.color(), ks: random.color(), exponent: random.exponent() }.into()
}

fn modified_phong(random: &mut Random) -> Material {
    ModifiedPhong { kd: random.color(), ks: random.color(), exponent: random.exponent() }.into()
}

fn neumann(random: &mut Random) -> Material {
    Neumann { kd: random.color(), ks: random.color(), exponent: random.exponent().max(1.0) }.into()
}

fn half_vector(random: &mut Random) -> Material {
    let lobe = |random: &mut Random| HalfVectorLobe::new(random.next(), random.color(), random.color());
    let lobes = (0..1 + (3.0 * random.next()) as usize).map(|_| lobe(random)).collect();
    HalfVector { diffuse: random.color(), lobes }.into()
}

fn lafortune(random: &mut Random) -> Material {
    let lobes = (0..1 + (3.0 * random.next()) as usize).map(|_| lafortune_lobe(random)).collect();
    Lafortune { diffuse: random.color(), lobes }.into()
}

/// Matrices that mirror, shrink, flatten, or grow with exponents that allow it; along the axes or rotated.
fn lafortune_lobe(random: &mut Random) -> LafortuneLobe {
    let mut exponent = random.exponent();
    let signs = Vec3::new(-1.0, -1.0, 1.0);
    let size = |random: &mut Random, low: f32| low + (1.0 - low) * random.next();
    let c = match (5.0 * random.next()) as u32 {
        0 => signs,
        1 => signs * size(random, 0.9999),
        2 => signs * Vec3::new(size(random, 0.0), size(random, 0.9), size(random, 0.5)),
        3 => Vec3::new(random.next(), 0.0, random.next() - 0.5),
        _ => {
            exponent = exponent.min(30.0);
            Vec3::new(size(random, -2.0), size(random, -2.0), 2.0 * random.next())
        }
    };
    let mut matrix = Mat3::from_diagonal(c);
    if random.next() < 0.5 {
        let turn = Mat3::from_quat(Quat::from_axis_angle(random.direction(), 6.0 * random.next()));
        matrix = turn * matrix * turn.transpose();
        // At exactly the largest height rounding would decide.
        exponent = exponent.min(1e6);
    }
    LafortuneLobe::new(matrix, exponent, random.color() + Vec3::X)
}

fn metallic_roughness(random: &mut Random) -> Material {
    let base = random.color();
    let end = |x: f32| (1.2 * x - 0.1).clamp(0.0, 1.0);
    MetallicRoughness::new(base, end(random.next()), end(random.next())).expect("a valid material").into()
}

/// With the receiver's normal and with another.
fn clearcoat(random: &mut Random) -> Material {
    let Material::MetallicRoughness(metal) = metallic_roughness(random) else { unreachable!("a metal") };
    let coated = metal.with_clearcoat(1.0 - 0.9 * random.next(), random.next()).expect("a valid material").into();
    let normal = random.direction();
    if random.next() < 0.5 { coated } else { coated.with_clearcoat_normal(normal).expect("a coat") }
}

/// With an own tangent, some of no length, and without, some under a clear coat; a strength of zero, as a texture may give it.
fn brushed(random: &mut Random) -> Material {
    let made = if random.next() < 0.3 { clearcoat(random) } else { metallic_roughness(random) };
    let Material::MetallicRoughness(metal) = made else { unreachable!("a metal") };
    let made = Material::from(metal.with_anisotropy(1.0 - 0.9 * random.next()).expect("a valid material"));
    let strength = if random.next() < 0.1 { 0.0 } else { random.next() };
    let made = made.scaled(&Factors { anisotropy: strength, ..Factors::ONE });
    let tangent = if random.next() < 0.1 { Vec3::ZERO } else { 3.0 * random.direction() };
    if random.next() < 0.3 { made } else { made.turned(Vec3::Z, tangent).expect("a grain") }
}

/// Whether two lobes are of one kind; a grain's direction may be rounded to the next of its steps.
fn is_alike(got: f32, want: f32) -> bool {
    if want < PackedLobe::MICROFACETS_GRAIN {
        return got == want;
    }
    const STEP: u32 = 1 << 11;
    let apart = got.to_bits().abs_diff(want.to_bits());
    got >= PackedLobe::MICROFACETS_GRAIN && [0, STEP, (STEP - 1) * STEP].contains(&apart)
}

fn receiver(normal: Vec3, view: Vec3) -> Receiver {
    Receiver::on_surface(Vec3::ZERO, normal, view)
}

/// Views along the normal, grazing and below the horizon; normals at the poles, where bases turn.
fn receivers() -> Vec<Receiver> {
    let mut random = Random::new(3);
    let mut all = Vec::new();
    for i in 0..40 {
        let normal = match i % 10 {
            0 => Vec3::Z,
            1 => -Vec3::Z,
            2 => Vec3::new(1e-7, -1e-7, -1.0).normalize(),
            3 => Vec3::X,
            _ => random.direction(),
        };
        let (t, b) = orthonormal_basis(normal);
        let (sin, cos) = random.direction().truncate().normalize().into();
        let aside = t * cos + b * sin;
        let up = match i / 5 {
            0 => 1.0,
            1 => 1.0 - 1e-6 * random.next(),
            2 => 1e-4 * random.next(),
            3 => -0.3 * random.next(),
            _ => random.next(),
        };
        all.push(receiver(normal, (normal * up + aside * (1.0 - up * up).sqrt()).normalize()));
    }
    all.push(receiver(Vec3::Z, Vec3::X));
    all
}

/// All lobes that the GPU computes for each of the materials and receivers.
fn lobes(gpu: &Gpu, packed: &PackedMaterials, materials: usize, receivers: &[Receiver]) -> Vec<Vec<PackedLobe>> {
    let pairs = (0..materials).flat_map(|m| receivers.iter().map(move |at| (m, at)));
    let mut rows: Vec<f32> = Vec::new();
    for (material, at) in pairs {
        for k in 0..packed.max_lobes {
            rows.extend(at.normal.to_array().into_iter().chain(at.view.to_array()));
            rows.extend([material as f32, k as f32]);
        }
    }
    let (pieces, text) = brdf::wgsl::compose(&packed.models);
    let binding = "@group(0) @binding(2) var<storage, read> materials: array<u32>;";
    let body = "
        let n = vec3f(x(0), x(1), x(2));
        let at = Receiver(vec3f(0.0), NO_OBJECT, n, u32(x(6)), n, 0u, vec3f(x(3), x(4), x(5)), 0u);
        var lobe = Lobe();
        if u32(x(7)) < brdf_lobe_count(at.material) { lobe = brdf_lobe(at.material, at, u32(x(7))); }
        y(0, lobe.axis.x); y(1, lobe.axis.y); y(2, lobe.axis.z); y(3, lobe.exponent);
        y(4, lobe.flux.x); y(5, lobe.flux.y); y(6, lobe.flux.z); y(7, lobe.kind);";
    let text = join(&pieces) + &text + binding;
    let got = call_with(gpu, &text, body, &rows, [8, 8], &[(2, &packed.words)]);
    assert!(got.iter().all(|value| value.is_finite()));
    let lobes: Vec<PackedLobe> = bytemuck::cast_slice(&got).to_vec();
    lobes.chunks(packed.max_lobes as usize).map(<[PackedLobe]>::to_vec).collect()
}

/// A smaller flux never counts in a sum: some machines end an exponential's smallest values earlier.
fn visible(lobe: &PackedLobe) -> bool {
    lobe.flux.max_element() > 1e-30
}

/// The GPU's lobes are Rust's, in the same order; so are its cosine lobes.
fn agree(gpu: &Gpu, materials: &[Material]) {
    agree_with(
        gpu,
        materials,
        &PackedMaterials::of_cosine_lobes(materials).expect("built-in models"),
        Material::cosine_lobes,
    );
    if materials.iter().any(|m| matches!(m, Material::MetallicRoughness(_) | Material::HalfVector(_))) {
        agree_with(gpu, materials, &PackedMaterials::new(materials).expect("built-in models"), Material::brdf_lobes);
    }
}

fn agree_with(
    gpu: &Gpu,
    materials: &[Material],
    packed: &PackedMaterials,
    of: impl Fn(&Material, &Receiver, &mut Vec<BrdfLobe>),
) {
    let receivers = receivers();
    let all = lobes(gpu, packed, materials.len(), &receivers);
    let mut worst = [0.0_f32; 3];
    for (i, got) in all.iter().enumerate() {
        let (material, at) = (&materials[i / receivers.len()], &receivers[i % receivers.len()]);
        let mut want = Vec::new();
        of(material, at, &mut want);
        let want: Vec<PackedLobe> = want.into_iter().map(PackedLobe::from).filter(visible).collect();
        let got: Vec<&PackedLobe> = got.iter().filter(|lobe| visible(lobe)).collect();
        let name = material.name();
        assert_eq!(got.len(), want.len(), "{name} {i}: {got:?}\n{want:?}");
        for (got, want) in got.iter().zip(&want) {
            let errors = [
                (got.axis - want.axis).length(),
                (got.exponent - want.exponent).abs() / want.exponent.max(1.0),
                (got.flux - want.flux).abs().max_element() / want.flux.max_element(),
            ];
            let allowed = allowed(material, at, want);
            for k in 0..3 {
                worst[k] = worst[k].max(errors[k] / allowed[k] * TOLERANCE);
                assert!(errors[k] <= allowed[k], "{name} {i}: {got:?}\n{want:?}\n{errors:?} of {allowed:?}");
            }
            assert!(is_alike(got.kind, want.kind), "{name} {i}: {got:?}\n{want:?}");
            if want.exponent == 1.0 && want.axis == at.normal {
                assert_eq!((got.exponent, got.axis), (want.exponent, want.axis), "a Lambert lobe is exact");
            }
        }
    }
    println!("worst of axis, exponent, flux, conditioned to {TOLERANCE:.0e}: {worst:?}");
}

/// Some roundings of f32.
const TOLERANCE: f32 = 2e-6;

/// Allowed errors of axis, exponent and flux: the tolerance times the lobe's sensitivity to a rounding of its arguments.
fn allowed(material: &Material, at: &Receiver, want: &PackedLobe) -> [f32; 3] {
    match material {
        // The light below a coat is a difference from one, and the rows of a second table are mirrored twice.
        Material::MetallicRoughness(m) if m.clearcoat().is_some() => {
            let left = material.lets_out(at).max(1e-6);
            [4.0 * TOLERANCE, 48.0 * TOLERANCE, TOLERANCE * (48.0 + 1.0 / left)]
        }
        Material::Lafortune(m) if want.kind == PackedLobe::COSINE => {
            let (t, b) = orthonormal_basis(at.normal);
            let view = Vec3::new(t.dot(at.view), b.dot(at.view), at.normal.dot(at.view)).as_dvec3();
            // The exponent identifies the lobe; among equal exponents the most sensitive lobe counts.
            let own = m.lobes.iter().filter(|lobe| lobe.exponent() == want.exponent);
            let sensitive = own.map(|lobe| {
                let q = DMat3::from_cols_array(&lobe.matrix().to_cols_array().map(f64::from));
                let length = (q * view).length();
                let largest = lobe.matrix().to_cols_array().iter().fold(0.0_f32, |s, x| s.max(x.abs()));
                // gain = exp(e/2·ln(1 + ωᵀQω)), and small gains come from |Mω| itself: the effect of a rounding of ω on them, and
                // on the logarithm.
                let square = (q.transpose() * q - DMat3::IDENTITY) * view;
                let turn = (square.length() / (length * length)).min(f64::from(largest) / length);
                let steep = f64::from(lobe.exponent()) * turn;
                let ln_gain = f64::from(lobe.exponent()) * length.ln();
                [1.0 + largest / length as f32, 1.0 + (0.15 * steep + 0.25 * ln_gain.abs()) as f32]
            });
            let [axis, flux] = sensitive.fold([1.0_f32; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])]);
            [TOLERANCE * axis, TOLERANCE, TOLERANCE * flux]
        }
        // A position among 48 rows has 1/48 of an f32's digits, and rows differ by up to a half.
        Material::MetallicRoughness(_) | Material::HalfVector(_) if want.axis != at.normal => {
            [TOLERANCE, 24.0 * TOLERANCE, 24.0 * TOLERANCE]
        }
        // Also from a table; and a rounding of the divisor n·ω counts more the smaller it is, down to the smallest divisor.
        Material::Neumann(m) if want.axis != at.normal => {
            let divisor = at.normal.dot(at.view).max(1.0 / (15.0 * (m.exponent + 1.0).sqrt()));
            // The lobe without cosine begins with a weight of zero: a rounding of the whole highlight counts.
            let whole = (m.ks.max_element() / want.flux.max_element()).max(1.0);
            let number = TOLERANCE * (24.0 + whole * (1.0 + 0.1 / divisor));
            [TOLERANCE, number, number]
        }
        _ => [TOLERANCE; 3],
    }
}

/// `M ω = 0` gives no lobe, and no NaN.
fn no_axis(gpu: &Gpu) {
    let at = [receiver(Vec3::Z, Vec3::X), receiver(Vec3::X, Vec3::NEG_Y)];
    for c in [Vec3::Z, Vec3::ZERO, Vec3::splat(1e-32)] {
        for exponent in [0.0, 1e-6, 0.5, 1.0, 200.0, 1e5, 1e7] {
            let lobe = LafortuneLobe::diagonal(c, exponent, Vec3::ONE);
            let material = Lafortune { diffuse: Vec3::ZERO, lobes: vec![lobe] }.into();
            let got = lobes(gpu, &PackedMaterials::new(&[material]).expect("a built-in model"), 1, &at);
            assert!(got.iter().flatten().all(|lobe| lobe.flux == Vec3::ZERO));
        }
    }
}
