//! All parts of a mesh file as one mesh, with its joints and weights.

use cosine_lobes::scene::{Animation, Object};
use cosine_lobes::sphere_sets::Carriers;
use glam::{Mat4, Vec3};

/// The triangles of all objects, at the first moment.
#[derive(Default)]
pub(crate) struct WholeMesh {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Joints of the parts, one part after another; a part that stands still has one.
    joints: Vec<[u16; 4]>,
    weights: Vec<[f32; 4]>,
    targets: Vec<Vec<Vec3>>,
    rest_joints: Vec<Mat4>,
    rest_morph: Vec<f32>,
    moves: bool,
}

impl WholeMesh {
    pub(crate) fn new(objects: &[Object], animation: &Animation) -> Self {
        let mut all = Self::default();
        for (number, object) in objects.iter().enumerate() {
            let Some(mesh) = object.shape.mesh() else { continue };
            let first = all.positions.len();
            all.positions.extend_from_slice(&mesh.positions);
            all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|i| i + first as u32)));
            all.carry(number, mesh.positions.len(), animation);
        }
        all
    }

    fn carry(&mut self, object: usize, vertices: usize, animation: &Animation) {
        let (rig, pose) = (animation.rig(object), animation.pose(object, 0.0));
        let first = self.rest_joints.len() as u16;
        self.rest_joints.extend_from_slice(&pose.joints);
        self.moves |= rig.is_some();
        let before = self.joints.len();
        match rig {
            Some(rig) => {
                self.joints.extend(rig.joints.iter().map(|j| j.map(|j| j.saturating_add(first))));
                self.weights.extend_from_slice(rig.weights);
                for target in rig.targets {
                    let mut whole = vec![Vec3::ZERO; before];
                    whole.extend_from_slice(target);
                    self.targets.push(whole);
                }
                self.rest_morph.extend_from_slice(&pose.morph);
            }
            None => {
                self.joints.extend(std::iter::repeat_n([first, 0, 0, 0], vertices));
                self.weights.extend(std::iter::repeat_n([1.0, 0.0, 0.0, 0.0], vertices));
            }
        }
        // No other part's targets move this one.
        self.targets.iter_mut().for_each(|t| t.resize(self.joints.len(), Vec3::ZERO));
    }

    /// The joints and weights of its points; `None` when it stands still, or has more joints than can be numbered.
    pub(crate) fn carriers(&self) -> Option<Carriers<'_>> {
        (self.moves && self.rest_joints.len() <= usize::from(u16::MAX)).then_some(Carriers {
            joints: &self.joints,
            weights: &self.weights,
            targets: &self.targets,
            rest_joints: &self.rest_joints,
            rest_morph: &self.rest_morph,
        })
    }
}
