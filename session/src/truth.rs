use glam::Vec3;
use ray_tracing::{GBuffer, World};
use reference::{Geometry, Reference, ReferenceJob};
use renderer::Renderer;
use scene::{BlockerSet, Cancel};

/// The picture by Monte Carlo as far as it has come: shadow rays on the true surfaces, whatever strategy and method pictures take.
#[derive(Clone, Debug, Default)]
pub struct Truth {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Linear radiance toward the eye, row by row.
    pub radiance: Vec<Vec3>,
    /// The same without blockers.
    pub unshadowed: Vec<Vec3>,
    /// Samples of each light for each camera ray.
    pub samples: u32,
    /// The number of changes of the session that it shows.
    pub edits: u64,
}

/// A reference that grows between other work.
#[derive(Debug)]
pub(crate) struct Growth {
    gbuffer: GBuffer,
    truth: Truth,
    /// Of the sums so far, one value a point.
    radiance: Vec<Vec3>,
    unshadowed: Vec<Vec3>,
    /// A step has randomisations of its own.
    step: u64,
}

/// Samples of the first step.
const FIRST: u32 = 8;
/// Samples of a step, at most: an edit waits for no step, but a stopped one is lost in part.
const MOST: u32 = 64;

impl Growth {
    /// Nothing sampled yet, of the renderer's present picture after so many changes.
    pub(crate) fn new(renderer: &mut Renderer, edits: u64) -> Self {
        let (width, height) = (renderer.scene().width, renderer.scene().height);
        let samples = renderer.settings().samples;
        let whole = [0..width, 0..height];
        let find = |world: &World<'_>| GBuffer::sampled(world, [width, height], samples, whole, &Cancel::new());
        let gbuffer = renderer.with_world(find).unwrap_or_default();
        let truth = Truth { size: [width as usize, height as usize], edits, ..Truth::default() };
        let none = vec![Vec3::ZERO; gbuffer.len()];
        Self { gbuffer, truth, radiance: none.clone(), unshadowed: none, step: 0 }
    }

    pub(crate) const fn edits(&self) -> u64 {
        self.truth.edits
    }

    pub(crate) const fn samples(&self) -> u32 {
        self.truth.samples
    }

    /// Samples once more, and as many as so far, within bounds; ends early where that is requested. The reference so far; none where this
    /// step brought nothing.
    pub(crate) fn advance(&mut self, renderer: &mut Renderer, cancel: &Cancel) -> Option<Truth> {
        let wanted = self.truth.samples.clamp(FIRST, MOST);
        self.step += 1;
        let (gbuffer, seed) = (&self.gbuffer, self.step);
        let (estimate, count) = renderer.with_world(|world| {
            let blockers = BlockerSet::default();
            let job = ReferenceJob { world, gbuffer, blockers: &blockers, geometry: Geometry::Mesh, seed };
            let mut reference = Reference::new(job);
            reference.advance(wanted, cancel.flag(), &|_| {});
            (reference.estimate(), reference.samples().min(wanted))
        });
        // Points that no step has reached are worth nothing.
        let before = self.truth.samples;
        if count == 0 {
            return None;
        }
        let weight = count as f32 / (before + count) as f32;
        let merge = |sum: &mut Vec<Vec3>, new: &[Vec3]| {
            sum.iter_mut().zip(new).for_each(|(mean, new)| *mean += weight * (*new - *mean));
        };
        merge(&mut self.radiance, &estimate.radiance);
        merge(&mut self.unshadowed, &estimate.unshadowed);
        self.truth.samples = before + count;
        let background = renderer.scene().background;
        let picture = |points: &[Vec3]| {
            let mut points = points.to_vec();
            gbuffer.add_emission(&mut points);
            gbuffer.picture(&points, background)
        };
        self.truth.radiance = picture(&self.radiance);
        self.truth.unshadowed = picture(&self.unshadowed);
        Some(self.truth.clone())
    }
}
