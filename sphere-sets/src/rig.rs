use crate::bound_set::{BoundSet, CARRIERS, at_least};
use crate::error::BindError;
use glam::Mat4;
use visibility_spheres::SphereBlockers;

/// The blockers that follow bones, as `pose.wgsl` reads them: one buffer uploaded once, and one for each pose.
///
/// ```no_run
/// # fn of(blockers: &visibility_spheres::SphereBlockers, body: &sphere_sets::BoundSet, joints: &[glam::Mat4])
/// # -> Result<(), sphere_sets::BindError> {
/// use sphere_sets::{SphereRig, SphereRigPart};
/// let rig = SphereRig::new(blockers, &[SphereRigPart { first: 0, set: body }])?;
/// let mut bones = Vec::new();
/// rig.bones(&[(joints, &[])], &mut bones)?;
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SphereRig {
    words: Vec<u32>,
    /// Of each set: joints and morph targets that it needs.
    needs: Vec<[usize; 2]>,
}

/// The spheres of a set, among all that block.
#[derive(Clone, Copy, Debug)]
pub struct SphereRigPart<'a> {
    /// The number of the set's first sphere; the others follow it.
    pub first: usize,
    /// The set.
    pub set: &'a BoundSet,
}

/// `RIG_WORDS`, `MORPH_WORDS` and the floats of a joint.
pub(crate) const RIG_WORDS: usize = 30;
pub(crate) const MORPH_WORDS: usize = 13;
const JOINT_FLOATS: usize = 12;

impl SphereRig {
    /// The rig of blockers of which `parts` follow bones; all the others stand still.
    ///
    /// A sphere that blocks nothing in the blockers as they are, of radius 0 say, is not among those that are posed: make
    /// them of the sets' [rest](BoundSet::rest) poses, where all have a size. O(spheres × (30 + 13 targets)).
    ///
    /// # Errors
    /// [`BindError::Missing`] where the blockers end before a set does.
    pub fn new(blockers: &SphereBlockers, parts: &[SphereRigPart<'_>]) -> Result<Self, BindError> {
        let mut slots = vec![None; blockers.spheres().len()];
        for (slot, index) in blockers.order().iter().enumerate() {
            slots[*index as usize] = Some(slot as u32);
        }
        let (mut rig, mut morphs, mut float) = (Self { words: vec![0], needs: Vec::new() }, Vec::new(), 0);
        for SphereRigPart { first, set } in parts {
            at_least("spheres", slots.len(), first + set.spheres.len())?;
            let [joints, targets] = [set.joints(), set.targets()];
            let morph = float + JOINT_FLOATS * joints;
            for (i, sphere) in set.spheres.iter().enumerate() {
                let Some(slot) = slots[first + i] else { continue };
                rig.words[0] += 1;
                // The last is where among the morphs: they are moved behind all spheres below.
                rig.words.extend([slot, float as u32, morph as u32, targets as u32, morphs.len() as u32]);
                let pairs = sphere.joints.chunks(2).map(|pair| u32::from(pair[0]) | u32::from(pair[1]) << 16);
                rig.words.extend(pairs);
                let (own, fixed) = blockers.self_shadow(first + i);
                let points = sphere.points.iter().flat_map(|point| point.to_array());
                let floats = sphere.weights.into_iter().chain(points);
                let floats = floats.chain([sphere.radius, own.radius, own.distance, fixed]);
                let floats = floats.chain(sphere.offset.clamp_length_max(1.0 - own.radius).to_array());
                rig.words.extend(floats.map(f32::to_bits));
                for target in &set.targets {
                    let points = target[i].points.iter().flat_map(|point| point.to_array());
                    morphs.extend(points.chain([target[i].radius]).map(f32::to_bits));
                }
            }
            float = morph + targets;
            rig.needs.push([joints, targets]);
        }
        let end = rig.words.len() as u32;
        for sphere in rig.words[1..].chunks_exact_mut(RIG_WORDS) {
            sphere[4] += end;
        }
        rig.words.extend(morphs);
        Ok(rig)
    }

    /// The buffer `rig` of `pose.wgsl`.
    #[must_use]
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// The number of spheres that follow bones.
    #[must_use]
    pub fn spheres(&self) -> u32 {
        self.words.first().copied().unwrap_or(0)
    }

    /// Replaces `out` by the buffer `bones` of `pose.wgsl`: of each part the joints (bind space to the world) and the weights of
    /// the morph targets, as for [`BoundSet::pose`]. 48 bytes a joint, 4 a target.
    ///
    /// # Errors
    /// [`BindError::Missing`] for fewer poses than parts, or fewer joints or weights than a set needs; `out` is left as it is.
    pub fn bones(&self, poses: &[(&[Mat4], &[f32])], out: &mut Vec<f32>) -> Result<(), BindError> {
        at_least("poses", poses.len(), self.needs.len())?;
        for ((joints, morph), [needed, targets]) in poses.iter().zip(&self.needs) {
            at_least("joints", joints.len(), *needed)?;
            at_least("morph weights", morph.len(), *targets)?;
        }
        out.clear();
        for ((joints, morph), [needed, targets]) in poses.iter().zip(&self.needs) {
            for joint in &joints[..*needed] {
                out.extend((0..3).flat_map(|row| joint.row(row).to_array()));
            }
            out.extend(&morph[..*targets]);
        }
        Ok(())
    }
}

// The shader's words of a sphere and of a morph.
const _: () = assert!(RIG_WORDS == 5 + CARRIERS / 2 + CARRIERS + 3 * CARRIERS + 7 && MORPH_WORDS == 3 * CARRIERS + 1);
