//! The nodes of a glTF file, moved by a clip.

use crate::placement::{Clock, sample};
use crate::track::Track;
use glam::{DMat4, DQuat, DVec3, Mat4, Quat, Vec3};

/// A node's matrix to its parent.
#[derive(Clone, Debug)]
pub(crate) enum Local {
    Matrix(Mat4),
    Parts { scale: Vec3, rotation: Quat, translation: Vec3 },
}

/// The same in double precision.
#[derive(Clone, Copy, Debug)]
pub(crate) enum FineLocal {
    Matrix(DMat4),
    Parts { scale: DVec3, rotation: DQuat, translation: DVec3 },
}

/// One node.
#[derive(Clone, Debug)]
pub(crate) struct Bone {
    pub(crate) parent: Option<usize>,
    pub(crate) local: Local,
    pub(crate) fine: FineLocal,
    /// The world matrix at rest: finite.
    pub(crate) rest: Mat4,
    pub(crate) scale: Option<Track>,
    pub(crate) rotation: Option<Track>,
    pub(crate) translation: Option<Track>,
    pub(crate) weights: Option<Track>,
    /// Morph weights at rest.
    pub(crate) rest_weights: Vec<f32>,
}

/// All nodes of a file and the clip that moves them.
#[derive(Clone, Debug)]
pub(crate) struct Skeleton {
    /// By the file's numbers.
    pub(crate) bones: Vec<Bone>,
    /// Parents before their children.
    pub(crate) order: Vec<usize>,
    /// World matrices are relative to it.
    pub(crate) origin: DVec3,
    /// Whether matrices are multiplied in double precision: some node is far from its parent.
    pub(crate) is_fine: bool,
    pub(crate) clock: Clock,
}

/// The part of a skeleton that carries a mesh.
#[derive(Clone, Debug)]
pub(crate) struct Carrier {
    /// The number of the skeleton in the animation.
    pub(crate) skeleton: usize,
    /// Each joint's node and inverse bind matrix; no node for vertices that stay where they are.
    pub(crate) joints: Vec<(Option<usize>, Mat4)>,
    /// The node whose weights morph the mesh.
    pub(crate) morph: Option<usize>,
}

impl Local {
    /// The same in double precision.
    pub(crate) fn fine(&self) -> FineLocal {
        match *self {
            Self::Matrix(matrix) => FineLocal::Matrix(matrix.as_dmat4()),
            Self::Parts { scale, rotation, translation } => FineLocal::Parts {
                scale: scale.as_dvec3(),
                rotation: rotation.as_dquat().normalize(),
                translation: translation.as_dvec3(),
            },
        }
    }

    /// Whether a node is so far from its parent that single precision moves it by more than 7e-6.
    fn is_far(&self) -> bool {
        let translation = match self {
            Self::Matrix(matrix) => matrix.w_axis.truncate(),
            Self::Parts { translation, .. } => *translation,
        };
        translation.abs().max_element() >= 128.0
    }
}

impl Bone {
    pub(crate) fn moves(&self) -> bool {
        [&self.scale, &self.rotation, &self.translation].into_iter().flatten().any(|t| !t.is_constant())
    }

    pub(crate) fn local(&self, time: f32) -> Mat4 {
        match self.parts(time) {
            Err(matrix) => matrix,
            Ok((scale, rotation, translation)) => Mat4::from_scale_rotation_translation(scale, rotation, translation),
        }
    }

    /// The same in double precision.
    fn fine_local(&self, time: f32) -> DMat4 {
        let (scale, rotation, translation) = match self.fine {
            FineLocal::Matrix(matrix) => return matrix,
            FineLocal::Parts { scale, rotation, translation } => (scale, rotation, translation),
        };
        let vector = |track: &Option<Track>, rest: DVec3| {
            track.as_ref().map_or(rest, |t| Vec3::from_array(sample(t, time)).as_dvec3())
        };
        let turned = |t: &Track| Quat::from_array(sample(t, time)).as_dquat().normalize();
        let rotation = self.rotation.as_ref().map_or(rotation, turned);
        DMat4::from_scale_rotation_translation(
            vector(&self.scale, scale),
            rotation,
            vector(&self.translation, translation),
        )
    }

    /// Scale, rotation and translation, or the matrix: glTF 2.0 allows no channels on a node that has one.
    fn parts(&self, time: f32) -> Result<(Vec3, Quat, Vec3), Mat4> {
        let (scale, rotation, translation) = match self.local {
            Local::Matrix(matrix) => return Err(matrix),
            Local::Parts { scale, rotation, translation } => (scale, rotation, translation),
        };
        let vector = |track: &Option<Track>, rest| track.as_ref().map_or(rest, |t| Vec3::from_array(sample(t, time)));
        let rotation = self.rotation.as_ref().map_or(rotation, |t| Quat::from_array(sample(t, time)));
        Ok((vector(&self.scale, scale), rotation, vector(&self.translation, translation)))
    }
}

impl Skeleton {
    /// Takes transforms in double precision where some node is far from its parent: those of the document's JSON, whose numbers the typed
    /// document has rounded.
    pub(crate) fn refine(&mut self, nodes: impl FnOnce() -> Option<Vec<Option<FineLocal>>>) {
        self.is_fine = self.bones.iter().any(|bone| bone.local.is_far());
        if let Some(fine) = self.is_fine.then(nodes).flatten() {
            for (bone, fine) in self.bones.iter_mut().zip(fine) {
                bone.fine = fine.unwrap_or(bone.fine);
            }
        }
    }

    /// World matrices of all nodes; a node beyond the range of single precision keeps its rest pose.
    pub(crate) fn worlds(&self, time: f32) -> Vec<Mat4> {
        if self.is_fine || self.origin != DVec3::ZERO {
            return self.far_worlds(time);
        }
        let time = self.clock.local(time);
        let mut worlds = vec![Mat4::IDENTITY; self.bones.len()];
        for &i in &self.order {
            let bone = &self.bones[i];
            let local = bone.local(time);
            let world = bone.parent.map_or(local, |p| worlds[p] * local);
            let usable = world.to_cols_array().iter().all(|v| v.abs() <= crate::mesh::MAX_COORDINATE);
            worlds[i] = if usable { world } else { bone.rest };
        }
        worlds
    }

    /// The same in double precision, relative to the origin.
    fn far_worlds(&self, time: f32) -> Vec<Mat4> {
        let time = self.clock.local(time);
        let mut far = vec![DMat4::IDENTITY; self.bones.len()];
        let mut worlds = vec![Mat4::IDENTITY; self.bones.len()];
        for &i in &self.order {
            let bone = &self.bones[i];
            let local = bone.fine_local(time);
            let world = bone.parent.map_or(local, |p| far[p] * local);
            let usable = world.to_cols_array().iter().all(|v| v.abs() <= f64::from(crate::mesh::MAX_COORDINATE));
            far[i] = if usable { world } else { bone.rest.as_dmat4() };
            let mut near = far[i];
            near.w_axis -= self.origin.extend(0.0);
            worlds[i] = near.as_mat4();
        }
        worlds
    }

    /// Appends the morph weights of a node.
    pub(crate) fn morph_weights(&self, node: usize, time: f32, out: &mut Vec<f32>) {
        let bone = &self.bones[node];
        let start = out.len();
        out.extend(&bone.rest_weights);
        if let Some(track) = &bone.weights {
            track.sample(self.clock.local(time), &mut out[start..]);
        }
    }

    /// For each node whether the clip moves it or a node above it.
    pub(crate) fn moving(&self) -> Vec<bool> {
        let mut moving = vec![false; self.bones.len()];
        for &i in &self.order {
            moving[i] = self.bones[i].moves() || self.bones[i].parent.is_some_and(|p| moving[p]);
        }
        moving
    }

    /// Seconds until the clip's last key.
    pub(crate) const fn end(&self) -> f32 {
        self.clock.last
    }
}

impl Carrier {
    /// From bind space to the file's world.
    pub(crate) fn joints(&self, worlds: &[Mat4]) -> impl Iterator<Item = Mat4> {
        self.joints.iter().map(|&(node, bind)| node.map_or(bind, |n| worlds[n] * bind))
    }
}
