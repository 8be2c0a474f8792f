//! The nodes of a glTF file, moved by a clip.

use crate::placement::{Clock, sample};
use crate::track::Track;
use glam::{DMat4, DQuat, DVec3, Mat4, Quat, Vec3};

/// A node's matrix to its parent.
#[derive(Clone, Debug)]
pub enum Local {
    /// A matrix, which no clip moves.
    Matrix(Mat4),
    /// Scaled first, then turned, then moved.
    Parts {
        /// Along the axes.
        scale: Vec3,
        /// A unit quaternion.
        rotation: Quat,
        /// A shift.
        translation: Vec3,
    },
}

/// The same in double precision.
#[derive(Clone, Copy, Debug)]
pub enum FineLocal {
    /// As [`Local::Matrix`].
    Matrix(DMat4),
    /// As [`Local::Parts`].
    Parts {
        /// Along the axes.
        scale: DVec3,
        /// A unit quaternion.
        rotation: DQuat,
        /// A shift.
        translation: DVec3,
    },
}

/// One node.
#[derive(Clone, Debug)]
pub struct Bone {
    /// The number of the node above it.
    pub parent: Option<usize>,
    /// At rest.
    pub local: Local,
    /// At rest, for [`Skeleton::is_fine`].
    pub fine: FineLocal,
    /// The world matrix at rest: finite.
    pub rest: Mat4,
    /// Three numbers, in place of [`Local::Parts`].
    pub scale: Option<Track>,
    /// Quaternions, in place of [`Local::Parts`].
    pub rotation: Option<Track>,
    /// Three numbers, in place of [`Local::Parts`].
    pub translation: Option<Track>,
    /// As many numbers as `rest_weights`, in place of these.
    pub weights: Option<Track>,
    /// Morph weights at rest.
    pub rest_weights: Vec<f32>,
}

/// All nodes of a file and the clip that moves them.
#[derive(Clone, Debug)]
pub struct Skeleton {
    /// By the file's numbers.
    pub bones: Vec<Bone>,
    /// Parents before their children.
    pub order: Vec<usize>,
    /// World matrices are relative to it.
    pub origin: DVec3,
    /// Whether matrices are multiplied in double precision: some node is far from its parent.
    pub is_fine: bool,
    /// The clock of the clip.
    pub clock: Clock,
}

/// The part of a skeleton that carries a mesh.
#[derive(Clone, Debug)]
pub struct Carrier {
    /// The number of the skeleton in the animation.
    pub skeleton: usize,
    /// Each joint's node and inverse bind matrix; no node for vertices that stay where they are.
    pub joints: Vec<(Option<usize>, Mat4)>,
    /// The node whose weights morph the mesh.
    pub morph: Option<usize>,
}

impl Local {
    /// The same in double precision.
    #[must_use]
    pub fn fine(&self) -> FineLocal {
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
    /// Whether the clip moves it.
    #[must_use]
    pub fn moves(&self) -> bool {
        [&self.scale, &self.rotation, &self.translation].into_iter().flatten().any(|t| !t.is_constant())
    }

    /// The matrix to its parent, at a time on the clip's clock.
    #[must_use]
    pub fn local(&self, time: f32) -> Mat4 {
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
    pub fn refine(&mut self, nodes: impl FnOnce() -> Option<Vec<Option<FineLocal>>>) {
        self.is_fine = self.bones.iter().any(|bone| bone.local.is_far());
        if let Some(fine) = self.is_fine.then(nodes).flatten() {
            for (bone, fine) in self.bones.iter_mut().zip(fine) {
                bone.fine = fine.unwrap_or(bone.fine);
            }
        }
    }

    /// World matrices of all nodes; a node beyond the range of single precision keeps its rest pose.
    #[must_use]
    pub fn worlds(&self, time: f32) -> Vec<Mat4> {
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
    ///
    /// # Panics
    /// When there is no such node.
    pub fn morph_weights(&self, node: usize, time: f32, out: &mut Vec<f32>) {
        let bone = &self.bones[node];
        let start = out.len();
        out.extend(&bone.rest_weights);
        if let Some(track) = &bone.weights {
            track.sample(self.clock.local(time), &mut out[start..]);
        }
    }

    /// For each node whether the clip moves it or a node above it.
    #[must_use]
    pub fn moving(&self) -> Vec<bool> {
        let mut moving = vec![false; self.bones.len()];
        for &i in &self.order {
            moving[i] = self.bones[i].moves() || self.bones[i].parent.is_some_and(|p| moving[p]);
        }
        moving
    }

    /// Seconds until the clip's last key.
    #[must_use]
    pub const fn end(&self) -> f32 {
        self.clock.last
    }
}

impl Carrier {
    /// From bind space to the file's world.
    pub fn joints(&self, worlds: &[Mat4]) -> impl Iterator<Item = Mat4> {
        self.joints.iter().map(|&(node, bind)| node.map_or(bind, |n| worlds[n] * bind))
    }
}
