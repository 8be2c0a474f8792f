use crate::wgsl::{ModelWgsl, compose};
use crate::{Material, Model};
use glam::Vec3;
use shading::gpu::{GpuMaterialSet, GpuMaterials};

/// Materials as the words that the WGSL of [`wgsl`](crate::wgsl) reads from its `materials`.
///
/// Two words a material (number of its model among `models` + 256 × number of its lobes; where its numbers begin), then what each
/// [packs](crate::Model::pack), and tables that materials share. Lobes that reflect nothing from anywhere are not among them.
#[derive(Clone, Debug, PartialEq)]
pub struct PackedMaterials {
    /// The words that the shader reads. Not empty.
    pub words: Vec<u32>,
    /// Whose code the shader needs, by name.
    pub models: Vec<ModelWgsl>,
    /// The largest number of lobes.
    pub max_lobes: u32,
}

/// The words of materials while they are [packed](crate::Model::pack).
#[derive(Debug)]
pub struct Packer {
    words: Vec<u32>,
    /// Where the numbers of the present material begin.
    first: usize,
    /// Tables by address, and where they begin: few, with so many users that they share them.
    tables: Vec<(*const (), u32)>,
}

impl Packer {
    /// The numbers of the present material begin here, and not where it began to write.
    pub fn begin(&mut self) {
        self.first = self.words.len();
    }

    /// Appends numbers.
    pub fn push(&mut self, values: impl IntoIterator<Item = f32>) {
        self.words.extend(values.into_iter().map(f32::to_bits));
    }

    /// Appends a whole number.
    pub fn push_word(&mut self, word: u32) {
        self.words.push(word);
    }

    /// Appends the flux of a diffuse lobe; whether there is such a lobe, 1 or 0.
    pub fn push_diffuse(&mut self, flux: Vec3) -> u32 {
        self.push(flux.to_array());
        u32::from(flux != Vec3::ZERO)
    }

    /// How many words there are, of all materials together.
    #[must_use]
    pub fn len(&self) -> u32 {
        self.words.len() as u32
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.words.is_empty()
    }

    /// Where a table begins, which the first material that needs it writes. Before [`begin`](Self::begin).
    pub(crate) fn table<T>(&mut self, table: &T, write: impl FnOnce(&T, &mut Self)) -> u32 {
        let key = core::ptr::from_ref(table).cast();
        if let Some((_, at)) = self.tables.iter().find(|(known, _)| *known == key) {
            return *at;
        }
        let at = self.len();
        write(table, self);
        self.tables.push((key, at));
        at
    }
}

impl PackedMaterials {
    /// Packs materials whose parameters are [valid](Material::validate).
    ///
    /// # Errors
    /// The name of a model that has no WGSL, or shares its name with another, in a sentence.
    ///
    /// ```
    /// use brdf::{Material, PackedMaterials};
    /// let packed = PackedMaterials::new(&[Material::lambert(glam::Vec3::ONE)])?;
    /// assert_eq!((packed.words.len(), packed.max_lobes), (5, 1));
    /// # Ok::<(), String>(())
    /// ```
    pub fn new(materials: &[Material]) -> Result<Self, String> {
        Self::with(materials, |model| model.wgsl(), |model, out| model.pack(out))
    }

    /// The same by [cosine lobes](shading::BrdfLobes::cosine_lobes).
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn of_cosine_lobes(materials: &[Material]) -> Result<Self, String> {
        Self::with(materials, |model| model.cosine_wgsl(), |model, out| model.cosine_pack(out))
    }

    fn with(
        materials: &[Material],
        wgsl: impl Fn(&dyn Model) -> Option<ModelWgsl>,
        pack: impl Fn(&dyn Model, &mut Packer) -> u32,
    ) -> Result<Self, String> {
        let mut of = Vec::with_capacity(materials.len());
        for material in materials {
            let (model, name) = (material.model(), material.name());
            of.push(wgsl(model).ok_or_else(|| format!("a GPU cannot shade the material `{name}`: it has no WGSL"))?);
        }
        let mut models = of.clone();
        models.sort_by_key(|model| model.name);
        models.dedup();
        if let Some(pair) = models.windows(2).find(|pair| pair[0].name == pair[1].name) {
            return Err(format!("two models are called `{}`, and have different WGSL", pair[0].name));
        }
        // Nothing at all reads as a material without lobes.
        let words = vec![0; 2 * materials.len().max(1)];
        let mut packer = Packer { words, first: 0, tables: Vec::new() };
        let mut max_lobes = 0;
        for (i, (material, own)) in materials.iter().zip(&of).enumerate() {
            packer.begin();
            let lobes = pack(material.model(), &mut packer);
            let number = models.iter().position(|model| model.name == own.name).unwrap_or_default();
            packer.words[2 * i] = number as u32 | lobes << 8;
            packer.words[2 * i + 1] = packer.first as u32;
            max_lobes = max_lobes.max(lobes);
        }
        Ok(Self { words: packer.words, models, max_lobes })
    }
}

impl GpuMaterials for Material {
    fn gpu_set(materials: &[Self]) -> Result<GpuMaterialSet, String> {
        PackedMaterials::new(materials).map(Into::into)
    }

    fn gpu_cosine_set(materials: &[Self]) -> Result<GpuMaterialSet, String> {
        PackedMaterials::of_cosine_lobes(materials).map(Into::into)
    }
}

impl From<PackedMaterials> for GpuMaterialSet {
    fn from(PackedMaterials { words, models, max_lobes }: PackedMaterials) -> Self {
        let (needs, wgsl) = compose(&models);
        let names: Vec<&str> = models.iter().map(|model| model.name).collect();
        Self {
            name: if names.is_empty() { "no materials".to_owned() } else { names.join(" + ") },
            wgsl,
            needs,
            words,
            max_lobes,
            is_lambert: names.iter().all(|name| *name == "lambert"),
            has_microfacets: models.iter().any(|model| model.has_microfacets),
            has_grain: models.iter().any(|model| model.has_grain),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Lafortune, LafortuneLobe, Lambert, MetallicRoughness, ModifiedPhong, Phong};

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
        let packed = PackedMaterials::of_cosine_lobes(&materials).unwrap();
        for (i, (material, lobes)) in cases.iter().enumerate() {
            assert_eq!(packed.words[2 * i] >> 8, *lobes, "{} {i}", material.name());
            let model = &packed.models[(packed.words[2 * i] & 0xff) as usize];
            assert_eq!(model.name, material.name());
        }
        assert_eq!((packed.models.len(), packed.max_lobes), (5, 9));
        assert_eq!(PackedMaterials::new(&materials).unwrap().max_lobes, 3);
        let none = PackedMaterials::new(&[]).unwrap();
        assert_eq!((none.words.len(), none.models.len(), none.max_lobes), (2, 0, 0));
    }
}
