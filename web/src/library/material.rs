use crate::library::fault::Fault;
use crate::library::images::ImagesGiven;
use crate::library::mail::Arrays;
use brdf::{
    HalfVector, HalfVectorLobe, Lafortune, LafortuneLobe, Lambert, Material, MetallicRoughness, ModifiedPhong, Neumann,
    Phong,
};
use glam::{Mat3, Vec3};
use scene::Surface;
use serde::Deserialize;

/// A material as JavaScript describes it.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct MaterialGiven {
    model: Model,
    emission: Vec3,
    images: Option<ImagesGiven>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "camelCase", rename_all_fields = "camelCase")]
enum Model {
    Lambert {
        albedo: Vec3,
    },
    Phong {
        kd: Vec3,
        ks: Vec3,
        exponent: f32,
    },
    ModifiedPhong {
        kd: Vec3,
        ks: Vec3,
        exponent: f32,
    },
    Neumann {
        kd: Vec3,
        ks: Vec3,
        exponent: f32,
    },
    Lafortune {
        diffuse: Vec3,
        lobes: Vec<LafortuneGiven>,
    },
    HalfVector {
        diffuse: Vec3,
        lobes: Vec<HalfVectorGiven>,
    },
    MetallicRoughness {
        base: Vec3,
        metallic: f32,
        roughness: f32,
        f0: Option<Vec3>,
        clearcoat: f32,
        clearcoat_roughness: f32,
    },
}

/// A lobe by the rows of its matrix.
#[derive(Clone, Debug, Deserialize)]
struct LafortuneGiven {
    exponent: f32,
    scale: Vec3,
    matrix: [Vec3; 3],
}

#[derive(Clone, Debug, Deserialize)]
struct HalfVectorGiven {
    roughness: f32,
    f0: Vec3,
    f90: Vec3,
}

impl MaterialGiven {
    /// The white diffuse material of points without one: π times their radiance is the irradiance.
    pub(crate) fn white() -> Material {
        Material::lambert(Vec3::ONE)
    }

    /// The material with its images and emission, checked as one of a scene.
    pub(crate) fn material(self, arrays: Arrays<'_>) -> Result<(Material, Surface), Fault> {
        let material: Material = match self.model {
            Model::Lambert { albedo } => Lambert { albedo }.into(),
            Model::Phong { kd, ks, exponent } => Phong { kd, ks, exponent }.into(),
            Model::ModifiedPhong { kd, ks, exponent } => ModifiedPhong { kd, ks, exponent }.into(),
            Model::Neumann { kd, ks, exponent } => Neumann { kd, ks, exponent }.into(),
            Model::Lafortune { diffuse, lobes } => {
                let lobe = |lobe: LafortuneGiven| {
                    let [x, y, z] = lobe.matrix;
                    let lobe = LafortuneLobe::new(Mat3::from_cols(x, y, z).transpose(), lobe.exponent, lobe.scale);
                    lobe.validate().map(|()| lobe)
                };
                Lafortune { diffuse, lobes: lobes.into_iter().map(lobe).collect::<Result<_, _>>()? }.into()
            }
            Model::HalfVector { diffuse, lobes } => {
                let lobe = |lobe: HalfVectorGiven| HalfVectorLobe::new(lobe.roughness, lobe.f0, lobe.f90);
                HalfVector { diffuse, lobes: lobes.into_iter().map(lobe).collect() }.into()
            }
            Model::MetallicRoughness { base, metallic, roughness, f0, clearcoat, clearcoat_roughness } => {
                let metal = MetallicRoughness::new(base, metallic, roughness)?;
                let metal = metal.with_clearcoat(clearcoat, clearcoat_roughness)?;
                f0.map_or(Ok(metal.clone()), |f0| metal.with_coat(f0, 1.0))?.into()
            }
        };
        material.validate()?;
        let plain = Surface { emission: self.emission, ..Surface::default() };
        let surface = self.images.map_or(Ok(plain.clone()), |images| images.on(plain, arrays))?;
        Ok((material, surface))
    }
}
