//! Triangles that are tested one by one in f64.

pub(crate) mod moment;
pub(crate) mod soups;

use glam::{DVec3, Quat, Vec3};
use lobe_core::Sphere;
use lobe_core::oracle::Random;
use shading::VisibilityQuery;
use visibility_mask::{Blockers, LitArea, Mask, hooks};
use visibility_silhouettes::AnyHit;

#[derive(Clone, Debug, Default)]
pub(crate) struct Soup {
    pub(crate) positions: Vec<Vec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Soup {
    pub(crate) fn add(&mut self, corners: [Vec3; 3]) {
        let first = self.positions.len() as u32;
        self.positions.extend(corners);
        self.triangles.push([first, first + 1, first + 2]);
    }

    pub(crate) fn append(&mut self, other: &Self) {
        let first = self.positions.len() as u32;
        self.positions.extend(&other.positions);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| i + first)));
    }

    pub(crate) fn corners(&self) -> impl Iterator<Item = [Vec3; 3]> {
        self.triangles.iter().map(|t| t.map(|i| self.positions[i as usize]))
    }

    /// Whether a triangle lies on a ray nearer than a distance.
    pub(crate) fn hits(&self, origin: DVec3, direction: DVec3, distance: f64) -> bool {
        self.corners().any(|c| {
            let [a, b, c] = c.map(|p| p.as_dvec3() - origin);
            // The ray passes on the same side of all three edges.
            let sides = [(a, b), (b, c), (c, a)].map(|(p, q)| p.cross(q).dot(direction));
            let inside = sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0);
            let n = (b - a).cross(c - a);
            let t = n.dot(a) / n.dot(direction);
            inside && n.dot(direction) != 0.0 && t > 0.0 && t < distance
        })
    }
}

/// Rays against a soup.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rays<'s>(pub(crate) &'s Soup);

impl AnyHit for Rays<'_> {
    type Scratch = ();

    fn scratch(&self) {}

    fn leave(&self, position: Vec3, face: Vec3) -> Vec3 {
        position + face * (5e-7 * position.abs().max_element())
    }

    fn is_hit(&self, origin: Vec3, direction: Vec3, distance: f32, (): &mut ()) -> bool {
        self.0.hits(origin.as_dvec3(), direction.as_dvec3(), f64::from(distance))
    }

    fn triangles_meeting(&self, _: Sphere, visit: &mut dyn FnMut([Vec3; 3])) {
        self.0.corners().for_each(visit);
    }

    fn has(&self, _: u32) -> bool {
        true
    }
}

/// A closed sphere of triangles.
pub(crate) fn globe(center: Vec3, radius: f32, rings: u32) -> Soup {
    let sides = 2 * rings;
    let mut soup = Soup::default();
    for i in 0..=rings {
        let (s, c) = (core::f32::consts::PI * i as f32 / rings as f32).sin_cos();
        let s = if i == rings { 0.0 } else { s };
        for k in 0..sides {
            let (x, z) = (core::f32::consts::TAU * k as f32 / sides as f32).sin_cos();
            soup.positions.push(center + radius * Vec3::new(s * x, c, s * z));
        }
    }
    for i in 0..rings {
        for k in 0..sides {
            let [a, b] = [i * sides + k, i * sides + (k + 1) % sides];
            soup.triangles.extend([[a, a + sides, b], [b, a + sides, b + sides]]);
        }
    }
    soup
}

/// A random rotation.
pub(crate) fn turn(random: &mut Random) -> Quat {
    Quat::from_axis_angle(random.axis().as_vec3().normalize(), random.between(0.0, 6.3) as f32)
}

/// A box with eight corners, as twelve triangles.
pub(crate) fn cuboid(random: &mut Random, center: Vec3, size: f64) -> Soup {
    let half = Vec3::from_array(core::array::from_fn(|_| random.log_uniform(0.02 * size, size) as f32));
    let q = turn(random);
    let corner = |k: u32| {
        let sign = Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2 & 1) as f32) * 2.0 - 1.0;
        center + q * (sign * half)
    };
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    Soup { positions: (0..8).map(corner).collect(), triangles }
}

/// A mask beside f64 rays.
pub(crate) struct Compared {
    /// Samples that differ, all samples, and samples that differ by more than the rounding of an edge.
    pub(crate) samples: [u32; 3],
    /// Whether a triangle reaches into the light or through its plane.
    pub(crate) touches: bool,
    /// Of masks with many rows: the lit part as it is, less that of the samples which rays see, as parts of the light.
    pub(crate) lit: Option<f64>,
}

/// The errors of lit parts.
#[derive(Default)]
pub(crate) struct LitParts(Vec<f64>);

impl LitParts {
    /// That of a mask of 500 samples and more after `splat`, if it is known: `open` of `all` samples are seen by rays.
    pub(crate) fn of<B: Blockers>(
        blockers: &B,
        query: &VisibilityQuery<'_>,
        scratch: &mut B::Scratch,
        mask: &Mask,
        [open, all]: [u32; 2],
    ) -> Option<f64> {
        let mut area = LitArea::default();
        let narrowest = 1e-5 * mask.square().half.x;
        let is_found = mask.depth() >= 5 && all > 500 && blockers.find_lit(query, scratch, mask, narrowest, &mut area);
        let sample = f64::from((mask.raster().samples * mask.raster().rows).recip());
        is_found.then(|| (f64::from(hooks::area(&area)) / sample - f64::from(open)) / f64::from(all))
    }

    pub(crate) fn add(&mut self, lit: Option<f64>) {
        self.0.extend(lit.map(f64::abs));
    }

    /// They are many, and small: rows of samples are coarser.
    pub(crate) fn check(mut self) {
        let Self(errors) = &mut self;
        errors.sort_unstable_by(f64::total_cmp);
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let [p99, most] = [errors[errors.len() * 99 / 100], errors[errors.len() - 1]];
        println!(
            "{} lit parts as they are: {mean:.5} of the light off, 99 % {p99:.5}, largest {most:.5}",
            errors.len()
        );
        assert!(errors.len() > 200 && mean < 1e-3 && p99 < 0.015 && most < 0.03, "{mean} {p99} {most}");
    }
}
