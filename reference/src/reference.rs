//! The Monte-Carlo reference: no lobe and no mask, only rays.

mod checkpoint;
mod meridian;
mod occluders;
mod pair;

pub use self::checkpoint::CheckpointError;
use self::meridian::{Cap, Meridian};
use self::occluders::{Occluders, tile_candidates};
use self::pair::Pair;
use crate::cone::LightCone;
use crate::sky::Sky;
use crate::sobol::mix;
use brdf::Material;
use core::f64::consts::TAU;
use core::sync::atomic::{AtomicBool, Ordering};
use glam::{DVec3, Vec3};
use lighting::Light;
use lobe_core::{BrdfLobe, Receiver, Sphere};
use ray_tracing::{GBuffer, World};
use rayon::prelude::*;
use scene::{BlockerSet, Bounds};
use shading::{BrdfLobes, LightLobes};

/// Independent randomisations; their spread gives the error.
pub const REPLICATES: u32 = 8;

/// Points that are sampled together.
const TILE_POINTS: usize = 64;

/// Samples a replicate that a tile takes before the next tile's turn.
const CHUNK: u32 = 32;

/// Above this product of a lobe's exponent and the light's `1 − cos θ` the lobe, and not the light, decides where
/// samples are needed: `e^−2` is how far a lobe falls within such a light.
const GLOSSY: f64 = 2.0;

/// The geometry that casts shadows in a [`Reference`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Geometry<'a> {
    /// The same blocker spheres that the lobes see, with the same rule for an object's own ones.
    Spheres,
    /// The true geometry: triangles and spheres.
    Mesh,
    /// The true geometry of the objects whose entry is true, by number, and all blocker spheres: the reference for a
    /// [`Mixture`](visibility_mask::Mixture) of strategies.
    Mixed(&'a [bool]),
    /// Nothing.
    None,
}

impl Geometry<'_> {
    /// Whether the blocker spheres matter.
    const fn has_spheres(self) -> bool {
        matches!(self, Self::Spheres | Self::Mixed(_))
    }
}

/// The input of a [`Reference`].
#[derive(Clone, Copy, Debug)]
pub struct ReferenceJob<'a> {
    /// The geometry; its scene gives materials and lights.
    pub world: &'a World<'a>,
    /// The visible points.
    pub gbuffer: &'a GBuffer,
    /// Blocker spheres, for [`Geometry::Spheres`] and [`Geometry::Mixed`].
    pub blockers: &'a BlockerSet,
    /// The geometry that casts shadows.
    pub geometry: Geometry<'a>,
    /// Chooses the randomisations.
    pub seed: u64,
}

/// The replicates of one point: running means of the samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Tally {
    radiance: [Vec3; REPLICATES as usize],
    unshadowed: [Vec3; REPLICATES as usize],
}

/// The result of a [`Reference`] so far, one entry a point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Estimate {
    /// Radiance toward the eye.
    pub radiance: Vec<Vec3>,
    /// The same without blockers, from the same samples: equal to `radiance` to the bit where nothing blocks.
    pub unshadowed: Vec<Vec3>,
    /// Standard error of `radiance` per channel: `s/√8` with the standard deviation s of the replicates.
    pub std_error: Vec<Vec3>,
}

/// Direct light by Monte-Carlo integration (Eq. 1 with the lights as the only sources), progressive and resumable.
///
/// For every point and light each of [`REPLICATES`] Owen-scrambled Sobol' sequences samples the light's cone uniformly;
/// where a lobe of the material is narrower than the light, as many directions of the reflectance are sampled as well and
/// both are combined by the power heuristic (E. Veach, L. Guibas, *Optimally Combining Sampling Techniques*, 1995).
/// The receiver's horizon and the blocker spheres that lie wholly between receiver and light are integrated exactly along
/// each sampled meridian of the light's cone, which leaves next to no error of shadow edges; all other blockers are met
/// by rays. Sums are taken in
/// f64. A direction is blocked when a blocker is met nearer than the light's near surface, and in the true geometry when it
/// is below the receiver's own facet, which rays that leave it do not meet; the lights
/// themselves block nothing. A receiver inside a light sees it in all directions.
///
/// The result depends on the job and the number of samples, not on threads or interruptions.
#[derive(Debug)]
pub struct Reference<'a> {
    job: ReferenceJob<'a>,
    /// The scene's environment.
    sky: Option<Sky<'a>>,
    tallies: Vec<Tally>,
    /// Samples a replicate that each tile has.
    done: Vec<u32>,
}

impl<'a> Reference<'a> {
    /// Nothing sampled yet. Needs 192 bytes a point.
    #[must_use]
    pub fn new(job: ReferenceJob<'a>) -> Self {
        let count = job.gbuffer.len();
        let environment = job.world.scene().environment.as_deref();
        let sky = environment.map(|environment| Sky::new(environment.map()));
        Self { job, sky, tallies: vec![Tally::default(); count], done: vec![0; count.div_ceil(TILE_POINTS)] }
    }

    /// Samples a light that every point has by now.
    #[must_use]
    pub fn samples(&self) -> u32 {
        self.done.iter().min().map_or(u32::MAX, |n| n.saturating_mul(REPLICATES))
    }

    /// Work that [`advance`](Self::advance) to `samples` would do, in the units that it reports: points times samples.
    #[must_use]
    pub fn work(&self, samples: u32) -> u64 {
        let target = samples.div_ceil(REPLICATES);
        let left = |n: &u32| u64::from(target.saturating_sub(*n)) * u64::from(REPLICATES) * TILE_POINTS as u64;
        self.done.iter().map(left).sum()
    }

    /// Brings every point to at least `samples` samples a light (rounded up to a multiple of [`REPLICATES`]; powers of
    /// two converge best). Returns early, with whole tiles done, when `stop` becomes true. Calls `progress` for every
    /// piece of work done, from any thread.
    pub fn advance(&mut self, samples: u32, stop: &AtomicBool, progress: &(dyn Fn(u64) + Sync)) {
        let target = samples.div_ceil(REPLICATES);
        let (job, sky) = (self.job, self.sky.as_ref());
        // Round after round, so that an interrupted picture is about equally good everywhere.
        let mut round = self.done.iter().min().copied().unwrap_or(target);
        while round < target && !stop.load(Ordering::Relaxed) {
            round = (round + CHUNK).min(target);
            self.tallies
                .par_chunks_mut(TILE_POINTS)
                .zip(self.done.par_iter_mut())
                .enumerate()
                .filter(|(_, (_, done))| **done < round)
                .for_each_init(Sampler::default, |sampler, (tile, (tallies, done))| {
                    if stop.load(Ordering::Relaxed) {
                        return;
                    }
                    sampler.tile(&job, sky, tile * TILE_POINTS, tallies, *done..round);
                    progress(u64::from((round - *done) * REPLICATES) * TILE_POINTS as u64);
                    *done = round;
                });
        }
    }

    /// The means and their standard errors; zero where nothing was sampled.
    #[must_use]
    pub fn estimate(&self) -> Estimate {
        let n = f64::from(REPLICATES);
        let mean = |values: &[Vec3]| values.iter().map(|v| v.as_dvec3()).sum::<DVec3>() / n;
        let error = |t: &Tally| {
            let mean = mean(&t.radiance);
            let square = |v: &Vec3| (v.as_dvec3() - mean).powf(2.0);
            let variance = t.radiance.iter().map(square).sum::<DVec3>() / (n - 1.0);
            (variance / n).map(f64::sqrt).as_vec3()
        };
        Estimate {
            radiance: self.tallies.iter().map(|t| mean(&t.radiance).as_vec3()).collect(),
            unshadowed: self.tallies.iter().map(|t| mean(&t.unshadowed).as_vec3()).collect(),
            std_error: self.tallies.iter().map(error).collect(),
        }
    }
}

/// Working memory of a thread.
#[derive(Default)]
struct Sampler {
    candidates: Vec<u32>,
    occluders: Occluders,
    meridian: Meridian,
    lobes: Vec<BrdfLobe>,
}

impl Sampler {
    /// Adds the samples of the range to the points from `first` on.
    fn tile(
        &mut self,
        job: &ReferenceJob<'_>,
        sky: Option<&Sky<'_>>,
        first: usize,
        tallies: &mut [Tally],
        range: core::ops::Range<u32>,
    ) {
        let mut sums = vec![[[DVec3::ZERO; 2]; REPLICATES as usize]; tallies.len()];
        for (number, light) in job.world.scene().lights.iter().enumerate() {
            // The lights of an environment are replaced by samples of its picture.
            if sky.is_none() || !matches!(light, Light::Sky(_)) {
                self.light(job, (number, light), first, &mut sums, range.clone());
            }
        }
        if let Some(sky) = sky.filter(|sky| !sky.is_black()) {
            self.sky(job, sky, first, &mut sums, range.clone());
        }
        // Running means: old and new ones weighted by their numbers of samples.
        let (old, new) = (f64::from(range.start), f64::from(range.end - range.start));
        let merge = |mean: &mut Vec3, sum: DVec3| *mean = ((mean.as_dvec3() * old + sum) / (old + new)).as_vec3();
        for (tally, sums) in tallies.iter_mut().zip(&sums) {
            for (r, [radiance, unshadowed]) in sums.iter().enumerate() {
                merge(&mut tally.radiance[r], *radiance);
                merge(&mut tally.unshadowed[r], *unshadowed);
            }
        }
    }

    /// Adds one light to the points from `first` on.
    fn light(
        &mut self,
        job: &ReferenceJob<'_>,
        (number, light): (usize, &Light),
        first: usize,
        sums: &mut [[[DVec3; 2]; REPLICATES as usize]],
        range: core::ops::Range<u32>,
    ) {
        let points = &job.gbuffer.points;
        let receivers = &points.receivers[first..first + sums.len()];
        let geometry = if light.has_shadows() { job.geometry } else { Geometry::None };
        if geometry.has_spheres() {
            let bounds = receivers.iter().fold(Bounds::EMPTY, |b, at| b.with_point(at.position));
            tile_candidates(receivers, light.bounds_from(&bounds.sphere()), job.blockers, &mut self.candidates);
        }
        for (i, (at, sums)) in receivers.iter().zip(sums).enumerate() {
            let Some(area) = light.kind().area(at.position) else { continue };
            let cone = LightCone::new(at.position, area.bounds);
            if cone.one_minus_cos() <= 0.0 {
                continue;
            }
            if geometry.has_spheres() {
                // A shape may reach through all of the sphere around it.
                let farthest = if area.is_sphere() { cone.surface_range().1 } else { cone.far_side() };
                self.occluders.select(at, &cone, farthest, &self.candidates, job.blockers);
            } else {
                self.occluders.none();
            }
            let material = &job.gbuffer.materials[points.materials[first + i] as usize];
            let sharpest = self.sharpest(material, at);
            let below = -at.normal.as_dvec3().normalize_or_zero();
            let pair = Pair {
                horizon: cone.cut_by(below).then(|| Cap::new(&cone, below, 0.0)),
                azimuths: cone.azimuths_beside(below),
                world: job.world,
                geometry,
                at,
                material,
                radiance: light.radiance(at),
                area: (!area.is_sphere()).then_some(area),
                cone,
                occluders: &self.occluders,
                origin: job.world.leave(at.position, at.face),
                glossy: sharpest * cone.one_minus_cos() > GLOSSY,
            };
            for (replicate, sum) in sums.iter_mut().enumerate() {
                let key = mix(mix(mix(job.seed, (first + i) as u64), number as u64), replicate as u64);
                pair.sample(key, range.clone(), &mut self.meridian, sum);
            }
        }
    }

    /// Adds the light of the environment to the points from `first` on.
    fn sky(
        &mut self,
        job: &ReferenceJob<'_>,
        sky: &Sky<'_>,
        first: usize,
        sums: &mut [[[DVec3; 2]; REPLICATES as usize]],
        range: core::ops::Range<u32>,
    ) {
        let points = &job.gbuffer.points;
        let receivers = &points.receivers[first..first + sums.len()];
        let all = job.world.scene().bounds();
        // Around all that blocks, wherever receivers are in it.
        let around = |p: Vec3| Sphere { center: p, radius: 4.0 * all.radius() + 2.0 * p.distance(all.center()) };
        if job.geometry.has_spheres() {
            let far = Sphere { radius: 16.0 * all.radius(), center: all.center() };
            tile_candidates(receivers, far, job.blockers, &mut self.candidates);
        }
        for (i, (at, sums)) in receivers.iter().zip(sums).enumerate() {
            let cone = LightCone::new(at.position, around(at.position));
            if job.geometry.has_spheres() {
                self.occluders.select(at, &cone, cone.surface_range().1, &self.candidates, job.blockers);
            } else {
                self.occluders.none();
            }
            let pair = Pair {
                horizon: None,
                azimuths: (0.0, TAU),
                world: job.world,
                geometry: job.geometry,
                at,
                material: &job.gbuffer.materials[points.materials[first + i] as usize],
                radiance: Vec3::ONE,
                area: None,
                cone,
                occluders: &self.occluders,
                origin: job.world.leave(at.position, at.face),
                glossy: true,
            };
            for (replicate, sum) in sums.iter_mut().enumerate() {
                let key = mix(mix(mix(job.seed, (first + i) as u64), u64::MAX), replicate as u64);
                pair.sky_sample(key, sky, range.clone(), sum);
            }
        }
    }

    /// Largest exponent among the material's lobes: only used to choose how to sample.
    fn sharpest(&mut self, material: &Material, at: &Receiver) -> f64 {
        self.lobes.clear();
        material.brdf_lobes(at, &mut self.lobes);
        let exponent = |lobe: &BrdfLobe| match lobe {
            BrdfLobe::Cosine(lobe) => lobe.exponent,
            // Of the narrowest of the cosine lobes that microfacets are a sum of.
            BrdfLobe::Microfacets(facets) => 0.5 * facets.exponent,
        };
        self.lobes.iter().map(|lobe| f64::from(exponent(lobe))).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests;
