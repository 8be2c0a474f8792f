use crate::coat;
use crate::ggx::{FAMILY_COUNT, Row};
use crate::models::{Models, cosine_number, number};
use crate::rows::ROWS;
use crate::{HalfVector, Lafortune, Material, MetallicRoughness, Neumann};
use core::f32::consts::{PI, TAU};
use glam::Vec3;
use lobe_core::gpu::{GpuMaterialSet, GpuMaterials};

/// Materials as the words that the WGSL of [`wgsl`](crate::wgsl) reads from its `materials`.
///
/// Two words a material (number of its model + 256 × number of its lobes; where its numbers begin), then the numbers: 3
/// words for Lambert, 8 for Phong and Neumann, 4 and 25 a lobe for Lafortune, 14 for metallic–roughness by microfacets and 22 by cosine lobes, and
/// tables that these share. Lobes that reflect nothing from anywhere are not among them.
#[derive(Clone, Debug, PartialEq)]
pub struct PackedMaterials {
    /// The words that the shader reads. Not empty.
    pub words: Vec<u32>,
    /// Whose code the shader needs.
    pub models: Models,
    /// The largest number of lobes.
    pub max_lobes: u32,
}

impl PackedMaterials {
    /// Packs the lobes of materials whose parameters are [valid](Material::validate).
    ///
    /// ```
    /// use brdf::{Material, PackedMaterials};
    /// let packed = PackedMaterials::new(&[Material::lambert(glam::Vec3::ONE)]);
    /// assert_eq!((packed.words.len(), packed.max_lobes), (5, 1));
    /// ```
    #[must_use]
    pub fn new(materials: &[Material]) -> Self {
        Self::pack(materials, Tables::microfacets)
    }

    /// Packs their [cosine lobes](lobe_core::BrdfLobes::cosine_lobes).
    #[must_use]
    pub fn of_cosine_lobes(materials: &[Material]) -> Self {
        Self::pack(materials, Tables::cosine_lobes)
    }

    /// `glossy` packs those that are microfacets, and returns the number of the model, that of the lobes, and where its numbers begin.
    fn pack(materials: &[Material], glossy: fn(&mut Tables, &Material, &mut Vec<u32>) -> Option<[u32; 3]>) -> Self {
        // Nothing at all reads as a material without lobes.
        let mut words = vec![0; 2 * materials.len().max(1)];
        let (mut models, mut max_lobes) = (0, 0);
        let mut tables = Tables::default();
        for (i, material) in materials.iter().enumerate() {
            let [model, lobes, first] = glossy(&mut tables, material, &mut words).unwrap_or_else(|| {
                let first = words.len() as u32;
                [number(material), plain(material, &mut words), first]
            });
            words[2 * i + 1] = first;
            words[2 * i] = model | lobes << 8;
            models |= 1 << model;
            max_lobes = max_lobes.max(lobes);
        }
        Self { words, models: Models::from_bits(models), max_lobes }
    }
}

impl GpuMaterials for Material {
    fn gpu_set(materials: &[Self]) -> GpuMaterialSet {
        let has_microfacets = materials.iter().any(|m| matches!(m, Self::MetallicRoughness(_) | Self::HalfVector(_)));
        GpuMaterialSet { has_microfacets, ..PackedMaterials::new(materials).into() }
    }

    fn gpu_cosine_set(materials: &[Self]) -> GpuMaterialSet {
        PackedMaterials::of_cosine_lobes(materials).into()
    }
}

impl From<PackedMaterials> for GpuMaterialSet {
    fn from(PackedMaterials { words, models, max_lobes }: PackedMaterials) -> Self {
        let names: Vec<&str> = models.names().collect();
        Self {
            name: if names.is_empty() { "no materials".to_owned() } else { names.join(" + ") },
            wgsl: crate::wgsl::compose(models),
            words,
            max_lobes,
            is_lambert: names.iter().all(|name| *name == "lambert"),
            has_microfacets: false,
        }
    }
}

/// Packs a material whose lobes are all cosine lobes; their number.
fn plain(material: &Material, words: &mut Vec<u32>) -> u32 {
    match material {
        Material::Lambert(m) => lambert(m.albedo, words),
        Material::Phong(m) => phong([PI * m.kd, m.ks * (TAU / (m.exponent + 1.0))], m.exponent, words),
        Material::ModifiedPhong(m) => {
            let e = m.exponent;
            phong([m.kd, m.ks * ((e + 2.0) / (e + 1.0))], e, words)
        }
        Material::Neumann(m) => {
            let highlight = phong([m.kd, m.ks * (m.exponent + 2.0)], m.exponent, words);
            // For the one of Phong's.
            highlight + if m.ks == Vec3::ZERO { 0 } else { Neumann::LOBES as u32 - 2 }
        }
        Material::Lafortune(m) => lafortune(m, words),
        Material::HalfVector(_) | Material::MetallicRoughness(_) => 0,
    }
}

fn push(words: &mut Vec<u32>, values: impl IntoIterator<Item = f32>) {
    words.extend(values.into_iter().map(f32::to_bits));
}

fn lambert(albedo: Vec3, words: &mut Vec<u32>) -> u32 {
    push(words, albedo.to_array());
    u32::from(albedo != Vec3::ZERO)
}

fn phong([diffuse, specular]: [Vec3; 2], exponent: f32, words: &mut Vec<u32>) -> u32 {
    let lobes = lambert(diffuse, words);
    words.push(1 - lobes);
    push(words, specular.to_array());
    push(words, [exponent]);
    lobes + u32::from(specular != Vec3::ZERO)
}

fn lafortune(model: &Lafortune, words: &mut Vec<u32>) -> u32 {
    let mut lobes = lambert(model.diffuse, words);
    words.push(1 - lobes);
    for lobe in model.lobes.iter().filter(|lobe| lobe.scale() != Vec3::ZERO) {
        push(words, bytemuck::cast::<_, [f32; 25]>(lobe.any));
        lobes += 1;
    }
    lobes
}

/// By microfacets: exponent and reflectances of each.
fn half_vector(model: &HalfVector, words: &mut Vec<u32>) -> u32 {
    let diffuse = lambert(model.diffuse, words);
    words.push(1 - diffuse);
    for lobe in &model.lobes {
        let alpha = lobe.alpha();
        push(words, [2.0 / (alpha * alpha) - 2.0]);
        push(words, lobe.reflectances().into_iter().flat_map(|f| f.to_array()));
    }
    diffuse + 2 * model.lobes.len() as u32
}

/// Where the tables of metals begin, once they are there.
#[derive(Default)]
struct Tables {
    coat: Option<u32>,
    /// By the rows' address: few, with so many users that they share it.
    rows: Vec<(*const Row, u32)>,
}

impl Tables {
    fn microfacets(&mut self, material: &Material, words: &mut Vec<u32>) -> Option<[u32; 3]> {
        let (lobes, first) = match material {
            Material::HalfVector(m) => {
                let first = words.len() as u32;
                (half_vector(m, words), first)
            }
            Material::MetallicRoughness(m) => {
                let (has_base, first) = self.metal(m, None, words);
                words.push(has_base);
                (has_base + 2, first)
            }
            _ => return None,
        };
        Some([number(material), lobes, first])
    }

    fn cosine_lobes(&mut self, material: &Material, words: &mut Vec<u32>) -> Option<[u32; 3]> {
        let (lobes, first) = match material {
            Material::HalfVector(m) => self.half_vector(m, words),
            Material::MetallicRoughness(m) => {
                let (has_base, first) = self.metal(m, Some(m.rows()), words);
                let (slots, lobes) = slots(m.rows(), has_base);
                words.extend(slots);
                (lobes, first)
            }
            _ => return None,
        };
        Some([cosine_number(material), lobes, first])
    }

    /// Packs the numbers of a metallic–roughness material that both need, with its rows or without, and, before them, the tables that it is
    /// the first to need; 1 if it has a diffuse base, and where it begins.
    fn metal(&mut self, model: &MetallicRoughness, rows: Option<&[Row; ROWS]>, words: &mut Vec<u32>) -> (u32, u32) {
        let coat = *self.coat.get_or_insert_with(|| {
            let (at, table) = (words.len() as u32, &*coat::TABLE);
            push(words, table.schlick);
            push(words, table.reflected.as_flattened().as_flattened().iter().copied());
            at
        });
        let rows = rows.map(|rows| self.rows(rows, words));
        let first = words.len() as u32;
        let diffuse = model.base * (1.0 - model.metallic);
        let [f0, f90] = model.reflectances();
        let below = model.coat();
        push(words, diffuse.to_array());
        push(words, f0.to_array());
        push(words, [f90.x, model.roughness, below.f0, below.f90, below.base, model.alpha()]);
        words.push(coat);
        words.extend(rows);
        (u32::from(diffuse != Vec3::ZERO), first)
    }

    /// Packs cosine lobes, after the tables that they are the first to need: for each of them where its half-vector lobe's rows and
    /// reflectances begin, and its slot; their number, and where they begin.
    fn half_vector(&mut self, model: &HalfVector, words: &mut Vec<u32>) -> (u32, u32) {
        let lobes: Vec<_> = model
            .lobes
            .iter()
            .map(|lobe| {
                let rows = self.rows(lobe.rows(), words);
                let at = words.len() as u32;
                words.push(rows);
                push(words, lobe.reflectances().into_iter().flat_map(|f| f.to_array()));
                (at, slots(lobe.rows(), 0))
            })
            .collect();
        let first = words.len() as u32;
        let mut count = lambert(model.diffuse, words);
        words.push(1 - count);
        for (at, (slots, used)) in lobes {
            words.extend(slots[..used as usize].iter().flat_map(|slot| [at, *slot]));
            count += used;
        }
        (count, first)
    }

    fn rows(&mut self, rows: &[Row; ROWS], words: &mut Vec<u32>) -> u32 {
        let key = rows.as_ptr();
        if let Some(known) = self.rows.iter().find(|(known, _)| *known == key) {
            return known.1;
        }
        let at = words.len() as u32;
        for f in rows.iter().flat_map(|row| &row.families) {
            push(words, [f.flux[0], f.flux[1], f.tilt, f.spread, f.exponent]);
        }
        self.rows.push((key, at));
        at
    }
}

/// For each cosine lobe its word, and how many there are.
fn slots(rows: &[Row; ROWS], has_base: u32) -> ([u32; 9], u32) {
    let mut slots = [0; 9];
    let mut lobes = has_base as usize;
    for k in 0..FAMILY_COUNT {
        let families = || rows.iter().map(|row| &row.families[k]);
        // Without F0 all that is left of a family is its grazing part.
        let places = match families().any(|family| family.flux != [0.0; 2]) {
            false => 0..0,
            true if families().all(|family| family.spread == 0.0) => 1..2,
            true => 0..3,
        };
        for place in places {
            slots[lobes] = 1 + 3 * k as u32 + place;
            lobes += 1;
        }
    }
    (slots, lobes as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LafortuneLobe, Lambert, ModifiedPhong, Phong};

    #[test]
    fn what_reflects_nothing_is_not_counted() {
        let (black, white) = (Vec3::ZERO, Vec3::ONE);
        let lobe = |scale| LafortuneLobe::diagonal(white, 2.0, scale);
        let cases: [(Material, u32); 8] = [
            (Lambert { albedo: black }.into(), 0),
            (Phong { kd: black, ks: white, exponent: 2.0 }.into(), 1),
            (ModifiedPhong { kd: white, ks: black, exponent: 2.0 }.into(), 1),
            (ModifiedPhong { kd: white, ks: white, exponent: 2.0 }.into(), 2),
            (Lafortune { diffuse: black, lobes: vec![lobe(black), lobe(white), lobe(white)] }.into(), 2),
            (MetallicRoughness::new(white, 0.0, 0.3).unwrap().into(), 9),
            // No haze of its own, no diffuse base, and one family that is spread.
            (MetallicRoughness::new(white, 1.0, 0.8).unwrap().into(), 5),
            // The constant distribution is one family.
            (MetallicRoughness::new(white, 1.0, 1.0).unwrap().into(), 1),
        ];
        let materials: Vec<Material> = cases.iter().map(|(material, _)| material.clone()).collect();
        let packed = PackedMaterials::of_cosine_lobes(&materials);
        for (i, (material, lobes)) in cases.iter().enumerate() {
            assert_eq!(packed.words[2 * i] >> 8, *lobes, "{} {i}", material.model_name());
        }
        assert_eq!((packed.models, packed.max_lobes), (Models::from_bits(0x1f), 9));
        assert_eq!(PackedMaterials::new(&materials).max_lobes, 3);
        let none = PackedMaterials::new(&[]);
        assert_eq!((none.words.len(), none.models, none.max_lobes), (2, Models::default(), 0));
    }
}
