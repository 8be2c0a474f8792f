//! The check of an animation that was not made by this crate.

use crate::SceneError;
use crate::animation::{Animation, Body, CameraMover, LightPlace, Mover};
use crate::deformer::{BoundSphere, Deformer, joints_in_use};
use crate::placement::{Placement, Turn};
use crate::skeleton::{Bone, Skeleton};
use crate::track::Track;

impl Animation {
    /// Checks everything that [`seek`](Self::seek), [`pose`](Self::pose) and [`duration`](Self::duration) rely on: that the skeletons, nodes and joints that the
    /// [parts](crate::motion) refer to exist, and that tracks and lists have the lengths that are stated. Readers of files and
    /// [`set_keys`](Self::set_keys) make animations for which it holds.
    ///
    /// Cost: one pass over the vertices that move.
    ///
    /// # Errors
    /// [`SceneError::Invalid`] that names the first fault.
    ///
    /// ```
    /// use scene::Animation;
    /// use scene::motion::CameraMover;
    /// let camera = CameraMover::Node { skeleton: 0, node: 3, projection: scene::Projection::perspective(0.6) };
    /// let animation = Animation { camera: Some(camera), ..Animation::default() };
    /// assert_eq!(animation.validate().unwrap_err().to_string(), "camera: there is no skeleton 0 of 0");
    /// ```
    pub fn validate(&self) -> Result<(), SceneError> {
        let all = || -> Result<(), String> {
            for (i, skeleton) in self.skeletons.iter().enumerate() {
                check_skeleton(skeleton).map_err(|e| format!("skeleton {i}: {e}"))?;
            }
            for (i, mover) in self.movers.iter().enumerate() {
                mover
                    .as_ref()
                    .map_or(Ok(()), |mover| self.check_mover(mover))
                    .map_err(|e| format!("object {i}: {e}"))?;
            }
            for mover in &self.lights {
                let checked = match &mover.placement {
                    LightPlace::Keys(placement) => check_placement(placement),
                    LightPlace::Node { skeleton, node } => self.check_node(*skeleton, *node),
                };
                checked.map_err(|e| format!("light {}: {e}", mover.first))?;
            }
            self.check_camera().map_err(|e| format!("camera: {e}"))
        };
        all().map_err(SceneError::invalid)
    }

    fn skeleton(&self, number: usize) -> Result<&Skeleton, String> {
        let count = self.skeletons.len();
        self.skeletons.get(number).ok_or_else(|| format!("there is no skeleton {number} of {count}"))
    }

    fn check_node(&self, skeleton: usize, node: usize) -> Result<(), String> {
        below("node", [node], self.skeleton(skeleton)?.bones.len())
    }

    fn check_camera(&self) -> Result<(), String> {
        match &self.camera {
            None => Ok(()),
            Some(CameraMover::Node { skeleton, node, .. }) => self.check_node(*skeleton, *node),
            Some(CameraMover::Keys(keys)) => {
                [&keys.eye, &keys.target, &keys.up].into_iter().try_for_each(|track| width(track, 3))?;
                keys.projection.track().map_or(Ok(()), |track| width(track, 1))
            }
        }
    }

    fn check_mover(&self, mover: &Mover) -> Result<(), String> {
        check_placement(&mover.placement)?;
        let joints = match &mover.body {
            Body::Spheres(_) => 1,
            Body::Mesh(deformer, None) => {
                check_deformer(deformer, 1, 0)?;
                1
            }
            Body::Mesh(deformer, Some(carrier)) => {
                let bones = &self.skeleton(carrier.skeleton)?.bones;
                let nodes = carrier.joints.iter().filter_map(|(node, _)| *node);
                below("node", nodes.chain(carrier.morph), bones.len())?;
                let weights = carrier.morph.map_or(0, |node| bones[node].rest_weights.len());
                check_deformer(deformer, carrier.joints.len(), weights)?;
                carrier.joints.len()
            }
        };
        below("joint", mover.proxy.iter().flat_map(BoundSphere::joints).map(usize::from), joints)
    }
}

fn check_skeleton(skeleton: &Skeleton) -> Result<(), String> {
    let count = skeleton.bones.len();
    below("node", skeleton.order.iter().copied(), count)?;
    for (i, bone) in skeleton.bones.iter().enumerate() {
        let Bone { parent, scale, rotation, translation, weights, rest_weights, .. } = bone;
        below("node", *parent, count)?;
        for (track, numbers) in [(scale, 3), (rotation, 4), (translation, 3), (weights, rest_weights.len())] {
            track.as_ref().map_or(Ok(()), |track| width(track, numbers)).map_err(|e| format!("node {i}: {e}"))?;
        }
    }
    Ok(())
}

fn check_placement(placement: &Placement) -> Result<(), String> {
    let Placement::Keys(keys) = placement else { return Ok(()) };
    width(&keys.scale, 3)?;
    width(&keys.translation, 3)?;
    match &keys.turn {
        Turn::About(_, degrees) => width(degrees, 1),
        Turn::Free(track) => width(track, 4),
    }
}

fn check_deformer(deformer: &Deformer, joints: usize, weights: usize) -> Result<(), String> {
    let Deformer { positions, normals, normal_targets, targets, smooth, .. } = deformer;
    let vertices = positions.len();
    let one_each = |name: &str, count: usize| {
        let found = || format!("{count} {name} for {vertices} vertices");
        (count == vertices).then_some(()).ok_or_else(found)
    };
    let one_or_none = |name: &str, count: usize| if count == 0 { Ok(()) } else { one_each(name, count) };
    one_each("lists of joints", deformer.joints.len())?;
    one_each("lists of weights", deformer.weights.len())?;
    one_or_none("normals", normals.len())?;
    targets.iter().try_for_each(|target| one_each("displacements", target.len()))?;
    normal_targets.iter().try_for_each(|target| one_or_none("displacements of normals", target.len()))?;
    if let Some(groups) = smooth {
        one_each("groups of normals", groups.len())?;
        below("group", groups.iter().map(|(group, _)| *group as usize), vertices)?;
    }
    if weights > targets.len() {
        return Err(format!("{weights} morph weights for {} targets", targets.len()));
    }
    // A rigid mesh is on joint 0, whether it has vertices or not.
    let of_vertices =
        deformer.joints.iter().zip(&deformer.weights).flat_map(|(on, weights)| joints_in_use(*on, *weights));
    below("joint", of_vertices.chain([0]).map(usize::from), joints)
}

fn below(name: &str, numbers: impl IntoIterator<Item = usize>, count: usize) -> Result<(), String> {
    match numbers.into_iter().find(|number| *number >= count) {
        Some(number) => Err(format!("there is no {name} {number} of {count}")),
        None => Ok(()),
    }
}

fn width(track: &Track, numbers: usize) -> Result<(), String> {
    let found = track.width();
    (found == numbers).then_some(()).ok_or_else(|| format!("a track has {found} numbers a key: expected {numbers}"))
}
