//! A group of receivers gets the same results as each alone, and receivers on one face with one result take one ray.

use crate::common::{Rays, Soup, cuboid};
use core::sync::atomic::{AtomicU32, Ordering};
use glam::{DVec3, Vec3};
use lobe_core::oracle::Random;
use lobe_core::{Cone, Lobe, Receiver, Sphere, cap_integral};
use shading::{Accuracy, Coverage, LightId, LightVisibility, Shaft, Visibility, VisibilityQuery};
use visibility_mask::{Blockers, MaskVisibility};
use visibility_silhouettes::{AnyHit, SilhouetteBlockers, SilhouetteMesh};

/// The triangles whose boxes meet a sphere, and the number of rays that were traced.
struct Counted<'s>(Rays<'s>, &'s AtomicU32);

impl AnyHit for Counted<'_> {
    type Scratch = ();

    fn scratch(&self) {}

    fn leave(&self, position: Vec3, face: Vec3) -> Vec3 {
        self.0.leave(position, face)
    }

    fn is_hit(&self, origin: Vec3, direction: Vec3, distance: f32, (): &mut ()) -> bool {
        self.1.fetch_add(1, Ordering::Relaxed);
        self.0.is_hit(origin, direction, distance, &mut ())
    }

    fn triangles_meeting(&self, sphere: Sphere, visit: &mut dyn FnMut([Vec3; 3])) {
        let meets = |[a, b, c]: &[Vec3; 3]| {
            let (low, high) = (a.min(*b).min(*c), a.max(*b).max(*c));
            let n = (*b - *a).as_dvec3().cross((*c - *a).as_dvec3()).normalize_or_zero();
            let away = n.dot((sphere.center - *a).as_dvec3()).abs();
            sphere.center.clamp(low, high).distance(sphere.center) <= sphere.radius
                && away <= f64::from(sphere.radius) * 1.0001
        };
        self.0.0.corners().filter(meets).for_each(visit);
    }

    fn has(&self, object: u32) -> bool {
        object == 0
    }
}

/// Two triangles of a floor, level or not, with or without a plate close above it.
fn floor(random: &mut Random, gap: Option<f32>) -> Soup {
    let up = if random.between(0.0, 1.0) < 0.5 { DVec3::Y } else { (DVec3::Y + random.axis() * 0.3).normalize() };
    let u = up.any_orthonormal_vector() * 6.0;
    let v = up.cross(u);
    let mut soup = Soup::default();
    for height in [Some(0.0), gap].into_iter().flatten() {
        let middle = up * (f64::from(height) - 1.5);
        let [a, b, c, d] = [-u - v, u - v, u + v, v - u].map(|p| (middle + p).as_vec3());
        soup.add([a, b, c]);
        soup.add([a, c, d]);
    }
    soup
}

#[test]
fn a_group_sees_what_each_sees_alone() {
    let mut random = Random::new(12);
    let [mut rays, mut receivers, mut partial, mut dark] = [0; 4];
    for case in 0..1500 {
        let gap = (case % 3 == 1).then(|| random.log_uniform(3e-6, 0.1) as f32);
        let mut soup = floor(&mut random, gap);
        for _ in 0..random.between(0.0, 4.0) as usize {
            let center = (random.axis() * random.between(0.0, 1.8)).as_vec3();
            soup.append(&cuboid(&mut random, center, 0.7));
        }
        let corners: Vec<_> = soup.corners().collect();
        if case % 5 == 0 {
            // A wall across the floor whose sides are far away.
            let (n, place) = (random.axis(), (corners[0][0] + corners[0][1] + corners[0][2]).as_dvec3() / 3.0);
            let u = n.any_orthonormal_vector() * 40.0;
            let at = place + random.axis() * random.between(0.0, 0.5);
            soup.add([at - u - n.cross(u), at + u - n.cross(u), at + n.cross(u)].map(|p| p.as_vec3()));
        }
        let [a, b, c] = if case % 4 == 0 {
            corners[(random.bits() % corners.len() as u64) as usize]
        } else {
            corners[usize::from(gap.is_some() && case % 2 == 0) * 2]
        };
        let light = Sphere {
            center: (random.axis() * 0.8).as_vec3() + Vec3::Y * random.between(0.5, 3.0) as f32,
            radius: random.log_uniform(0.01, 0.7) as f32,
        };
        let side = (b - a).cross(c - a).normalize_or_zero();
        let face = if side.dot(light.center - a) < 0.0 { -side } else { side };
        let (u, v) = (random.between(0.1, 0.4) as f32, random.between(0.1, 0.4) as f32);
        let size = random.log_uniform(1e-3, 0.1) as f32;
        let at: Vec<Receiver> = (0..24)
            .map(|_| {
                let [s, t] = [u, v].map(|w| w + size * random.between(-1.0, 1.0) as f32);
                let position = a + (b - a) * s + (c - a) * t;
                Receiver { position, normal: face, face, view: face, object: 0 }
            })
            .collect();
        let center = at.iter().map(|at| at.position).sum::<Vec3>() / at.len() as f32;
        let radius = at.iter().map(|at| at.position.distance(center)).fold(0.0, f32::max) * 1.001;
        let meshes = [SilhouetteMesh::new(0, &soup.positions, &soup.triangles)];
        let count = AtomicU32::new(0);
        let blockers = SilhouetteBlockers::new(&meshes, Counted(Rays(&soup), &count));
        let see = |at: &Receiver, scratch: &mut _| {
            let cone = Cone::of_sphere(at.position, light);
            blockers.select(&VisibilityQuery::new(at, LightId(0), &cone, Accuracy::new(0.003)), scratch)
        };
        let alone: Vec<Coverage> = at.iter().map(|at| see(at, &mut blockers.scratch())).collect();
        let asked = count.swap(0, Ordering::Relaxed);
        let mut scratch = blockers.scratch();
        let half_extent = at.iter().map(|at| (at.position - center).abs()).fold(Vec3::ZERO, Vec3::max);
        let group = Shaft::new(Sphere { center, radius }, light, LightId(0)).in_box(half_extent * 1.000_01);
        let all = blockers.enter(&group, &mut scratch);
        for (at, alone) in at.iter().zip(&alone) {
            let together = if all == Coverage::Lit { all } else { see(at, &mut scratch) };
            // A longer list may have more outlines that seem to be in front of the light: the mask decides.
            assert!(together == *alone || together == Coverage::Partial, "case {case}: {at:?} {together:?} {alone:?}");
        }
        if gap.is_none() && case % 4 != 0 && alone.iter().all(|seen| *seen == alone[0]) {
            rays += count.swap(0, Ordering::Relaxed);
            receivers += asked;
        }
        partial += u32::from(alone.contains(&Coverage::Partial));
        dark += u32::from(alone.contains(&Coverage::Dark));
    }
    println!("{rays} rays instead of {receivers}; {partial} cases partly lit, {dark} dark");
    assert!(partial > 80 && dark > 300 && 4 * rays < 3 * receivers, "{rays} {receivers} {partial} {dark}");
}

/// Half of a plane above the receivers, for rays.
struct HalfPlane;

const HEIGHT: f32 = 3.0;

impl AnyHit for HalfPlane {
    type Scratch = ();

    fn scratch(&self) {}

    fn leave(&self, position: Vec3, _: Vec3) -> Vec3 {
        position
    }

    fn is_hit(&self, origin: Vec3, direction: Vec3, distance: f32, (): &mut ()) -> bool {
        let t = (HEIGHT - origin.y) / direction.y;
        t > 0.0 && t < distance && (origin + direction * t).x < 0.0
    }

    fn triangles_meeting(&self, _: Sphere, _: &mut dyn FnMut([Vec3; 3])) {}

    fn has(&self, _: u32) -> bool {
        false
    }
}

/// A plate of a quarter of a million loose cards, none as high as its neighbours, hides what a whole plate does, though no receiver has a list of so many edges.
#[test]
fn more_edges_than_are_listed() {
    let mut random = Random::new(11);
    let mut cards = Soup::default();
    let (across, size) = (360_u16, 0.005_f32);
    for (i, k) in (0..across).flat_map(|i| (0..across).map(move |k| (i, k))) {
        let (x, z) = (f32::from(i), f32::from(k));
        let low = Vec3::new(size * (x - f32::from(across)), HEIGHT, size * (z - 0.5 * f32::from(across)));
        let y = 1e-5 * random.between(-1.0, 1.0) as f32;
        let [a, b, c, d] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
            .map(|[u, v]: [f32; 2]| low + Vec3::new(u * size, y, v * size));
        cards.add([a, b, c]);
        cards.add([a, c, d + 1e-5 * Vec3::Y]);
    }
    let mut plate = Soup::default();
    let [a, b, c, d] = [[-9.0, -9.0], [0.0, -9.0], [0.0, 9.0], [-9.0, 9.0]].map(|[x, z]| Vec3::new(x, HEIGHT, z));
    plate.add([a, b, c]);
    plate.add([a, c, d]);
    let light = Sphere { center: Vec3::new(0.0, 6.0, 0.0), radius: 1.6 };
    let [cards, plate] = [&cards, &plate].map(|soup| SilhouetteMesh::new(0, &soup.positions, &soup.triangles));
    let fractions = |mesh: &SilhouetteMesh| -> Vec<f32> {
        let strategy = MaskVisibility::new(SilhouetteBlockers::new([mesh], HalfPlane));
        let mut scratch = strategy.scratch();
        let group = Shaft::new(Sphere { center: Vec3::ZERO, radius: 0.5 }, light, LightId(0));
        let mut visit = LightVisibility::enter(&strategy, &group, Accuracy::new(0.005), &mut scratch);
        let of = |k: i16| {
            let at = Receiver::on_surface(Vec3::new(0.05 * f32::from(k), 0.0, 0.02), Vec3::Y, Vec3::Y);
            let cone = Cone::of_sphere(at.position, light);
            let lobe = Lobe::new(at.normal, 1.0, Vec3::ONE);
            visit.visible_fraction(&at, &cone, &lobe, cap_integral(&at, lobe, &cone)).x
        };
        (-9..10).map(of).collect()
    };
    let [found, want] = [fractions(&cards), fractions(&plate)];
    // As near as rays come.
    for (a, b) in found.iter().zip(&want) {
        assert!((a - b).abs() < 6e-3, "{a} {b}");
    }
    assert!(want.iter().filter(|part| (0.05..0.95).contains(*part)).count() > 5);
}
