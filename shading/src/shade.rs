//! Inputs and results of a renderer, the same for CPU and GPU.

use crate::Accuracy;
use glam::Vec3;
use lobe_core::{Receiver, SelfShadow, Sphere};

/// The visible points of one frame, in any order; neighbours in the list should be neighbours in space.
#[derive(Clone, Debug, Default)]
pub struct ShadingPoints {
    /// The receivers.
    pub receivers: Vec<Receiver>,
    /// Material number of each.
    pub materials: Vec<u32>,
    /// Where each tile of a picture ends among the receivers: points of two tiles are not culled together. May be left empty.
    pub ends: Vec<usize>,
    /// Where square tiles begin, in order: each has [`GROUP`](crate::GROUP) points, 8 rows of 8 neighbouring pixels. May be left empty.
    pub squares: Vec<usize>,
}

/// Blockers of all objects, posed for this frame.
#[derive(Clone, Debug, Default)]
pub struct BlockerSet {
    /// World-space spheres.
    pub spheres: Vec<Sphere>,
    /// For each sphere the number of the object that it stands for.
    pub objects: Vec<u32>,
    /// For each object number the self-shadow distance τ: its own spheres block a direction only if the ray leaves
    /// them farther than τ away.
    pub self_distances: Vec<f32>,
    /// For each sphere how receivers of its own object see it, instead of the object's τ; or empty.
    pub self_shadows: Vec<SelfShadow>,
}

impl BlockerSet {
    /// The sphere that receivers of its own object see inside a sphere, relative to its centre, and its τ.
    #[must_use]
    pub fn own(&self, sphere: usize) -> (Sphere, f32) {
        let (blocker, object) = (self.spheres[sphere], self.objects[sphere]);
        match self.self_shadows.get(sphere) {
            Some(own) => (own.near(blocker.radius), blocker.radius * own.distance),
            None => (
                Sphere { center: Vec3::ZERO, ..blocker },
                self.self_distances.get(object as usize).copied().unwrap_or(0.0),
            ),
        }
    }

    /// A sphere as a receiver sees it, and its τ for that receiver.
    #[must_use]
    pub fn seen_from(&self, sphere: usize, at: &Receiver) -> (Sphere, f32) {
        let blocker = self.spheres[sphere];
        if self.objects[sphere] != at.object {
            return (blocker, 0.0);
        }
        let (near, tau) = self.own(sphere);
        (SelfShadow::seen(blocker, near, at.position), tau)
    }
}

/// The constants of one frame: the built-in materials and lights, or own types.
#[derive(Debug)]
pub struct Frame<'a, M, L> {
    /// Materials that the points refer to.
    pub materials: &'a [M],
    /// Lights; a [`LightId`](crate::LightId) is a place in this list.
    pub lights: &'a [L],
    /// Requested error, and the depth of the masks.
    pub accuracy: Accuracy,
    /// Contributions whose radiance is below this are dropped (t_i of the paper, §4.3).
    pub threshold: f32,
}

impl<'a, M, L> Frame<'a, M, L> {
    /// A frame that drops no contribution.
    #[must_use]
    pub const fn new(materials: &'a [M], lights: &'a [L], accuracy: Accuracy) -> Self {
        Self { materials, lights, accuracy, threshold: 0.0 }
    }
}

impl<M, L> Clone for Frame<'_, M, L> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<M, L> Copy for Frame<'_, M, L> {}

/// Seconds of one frame, split as in the paper's Table 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StageSeconds {
    /// (a) Reflectance lobes.
    pub reflectance: f64,
    /// (b) Light cones and unshadowed integrals.
    pub lighting: f64,
    /// (c) Visibility masks.
    pub mask: f64,
    /// (d) Visibility lobes.
    pub visibility_lobes: f64,
    /// (e) Products and integrals with them.
    pub integration: f64,
}

/// Counts of the computation; independent of the machine. Pairs of a point and a light that is faint for it, which a CPU does not query under many lights,
/// are neither lit nor dark nor between.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Visibility lobes generated.
    pub lobes: u64,
    /// Lobe integrals evaluated, the unshadowed ones included.
    pub integrals: u64,
    /// Reflectance lobes dropped below the threshold.
    pub pruned: u64,
    /// Point–light pairs with V = 1.
    pub lit_points: u64,
    /// Point–light pairs with V = 0.
    pub dark_points: u64,
    /// Point–light pairs between.
    pub penumbra_points: u64,
}

/// Times and counts that shading reports.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShadeStats {
    /// Wall seconds of the whole call.
    pub seconds: f64,
    /// Stage times, summed over threads.
    pub stages: StageSeconds,
    /// Counters.
    pub counts: Counts,
}

// The sums over the parts of a picture.
impl core::ops::AddAssign for ShadeStats {
    fn add_assign(&mut self, part: Self) {
        self.seconds += part.seconds;
        let (all, part_stages) = (&mut self.stages, part.stages);
        all.reflectance += part_stages.reflectance;
        all.lighting += part_stages.lighting;
        all.mask += part_stages.mask;
        all.visibility_lobes += part_stages.visibility_lobes;
        all.integration += part_stages.integration;
        self.counts += part.counts;
    }
}

impl core::ops::AddAssign for Counts {
    fn add_assign(&mut self, part: Self) {
        self.lobes += part.lobes;
        self.integrals += part.integrals;
        self.pruned += part.pruned;
        self.lit_points += part.lit_points;
        self.dark_points += part.dark_points;
        self.penumbra_points += part.penumbra_points;
    }
}

/// A renderer of lobe sums, for one set of materials and one kind of lights: enums or boxes for several.
pub trait Shade<M, L> {
    /// The error of shading.
    type Error;

    /// Writes the radiance toward the eye of every point into `out`, which is as long as the points.
    ///
    /// # Errors
    /// The renderer's own; nothing is promised about `out` then.
    fn shade(
        &mut self,
        points: &ShadingPoints,
        frame: &Frame<'_, M, L>,
        out: &mut [Vec3],
    ) -> Result<ShadeStats, Self::Error>;
}
