use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::bound_set::{BoundSet, BoundSphere, CARRIERS, Morph};
use crate::error::SetFileError;
use crate::sphere_set::SphereSet;

/// The part of a [`BoundSet`] in a set file; one row a sphere.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Bones {
    joints: Vec<[u16; CARRIERS]>,
    weights: Vec<[f32; CARRIERS]>,
    /// `CARRIERS` points, one after the other.
    points: Vec<[f32; 3 * CARRIERS]>,
    radii: Vec<f32>,
    /// Empty in older files, where a near sphere has its sphere's centre.
    #[serde(default)]
    offsets: Vec<[f32; 3]>,
    #[serde(default)]
    targets: Vec<Target>,
}

/// The offsets of a morph target.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Target {
    points: Vec<[f32; 3 * CARRIERS]>,
    radii: Vec<f32>,
}

impl Bones {
    /// Checks that every list has one row for each sphere, and finite numbers.
    pub(crate) fn check(&self, count: usize) -> Result<(), SetFileError> {
        let refuse = |message: String| Err(SetFileError { message });
        let target_rows = self.targets.iter().flat_map(|target| [target.points.len(), target.radii.len()]);
        let rows = [self.joints.len(), self.weights.len(), self.points.len(), self.radii.len()];
        let rows = rows.into_iter().chain((!self.offsets.is_empty()).then_some(self.offsets.len()));
        if rows.chain(target_rows).any(|rows| rows != count) {
            return refuse(format!("\"bones\" should have one row for each of its {count} spheres"));
        }
        let numbers = self.weights.as_flattened().iter().chain(self.points.as_flattened()).chain(&self.radii);
        let numbers = numbers.chain(self.offsets.as_flattened());
        let added = self.targets.iter().flat_map(|target| target.points.as_flattened().iter().chain(&target.radii));
        if !numbers.chain(added).all(|number| number.is_finite()) {
            return refuse("\"bones\" have a number that is not finite".to_owned());
        }
        if self.weights.iter().any(|row| row.iter().any(|w| *w < 0.0) || (row.iter().sum::<f32>() - 1.0).abs() > 1e-3) {
            return refuse("the weights of \"bones\" should be positive numbers of sum 1".to_owned());
        }
        Ok(())
    }
}

impl BoundSet {
    /// The set as JSON: the keys of [`SphereSet::to_json`] and `"bones": {"joints", "weights", "points", "radii",
    /// "offsets", "targets"}`, of which each has a row a sphere, in bind space.
    ///
    /// [`BoundSet::from_json`] gives the same set back, bit for bit.
    #[must_use]
    pub fn to_json(&self) -> String {
        let targets = self.targets.iter().map(|target| Target {
            points: target.iter().map(|morph| flat(morph.points)).collect(),
            radii: target.iter().map(|morph| morph.radius).collect(),
        });
        self.rest.write(Some(&Bones {
            joints: self.spheres.iter().map(|sphere| sphere.joints).collect(),
            weights: self.spheres.iter().map(|sphere| sphere.weights).collect(),
            points: self.spheres.iter().map(|sphere| flat(sphere.points)).collect(),
            radii: self.spheres.iter().map(|sphere| sphere.radius).collect(),
            offsets: self.spheres.iter().map(|sphere| sphere.offset.to_array()).collect(),
            targets: targets.collect(),
        }))
    }

    /// Reads the output of [`BoundSet::to_json`].
    ///
    /// # Errors
    /// As [`SphereSet::from_json`]; also for a set without bones, or with bones that do not match its spheres.
    pub fn from_json(text: &str) -> Result<Self, SetFileError> {
        let refuse = |message: &str| Err(SetFileError { message: message.to_owned() });
        let (rest, bones) = SphereSet::read(text)?;
        let Some(bones) = bones else {
            return refuse("it has no \"bones\": it was built from a mesh without joints");
        };
        let count = rest.spheres.len();
        let spheres = (0..count).map(|i| BoundSphere {
            joints: bones.joints[i],
            weights: bones.weights[i],
            points: points(bones.points[i]),
            radius: bones.radii[i],
            offset: bones.offsets.get(i).map_or(Vec3::ZERO, |offset| Vec3::from(*offset)),
        });
        let targets = bones.targets.iter().map(|target| {
            let rows = target.points.iter().zip(&target.radii);
            rows.map(|(row, radius)| Morph { points: points(*row), radius: *radius }).collect()
        });
        Ok(Self { spheres: spheres.collect(), targets: targets.collect(), rest })
    }
}

fn flat(points: [Vec3; CARRIERS]) -> [f32; 3 * CARRIERS] {
    core::array::from_fn(|i| points[i / 3][i % 3])
}

fn points(flat: [f32; 3 * CARRIERS]) -> [Vec3; CARRIERS] {
    core::array::from_fn(|k| Vec3::from_slice(&flat[3 * k..3 * k + 3]))
}
