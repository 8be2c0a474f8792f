//! Masks of flat lights from silhouettes, sample by sample, against f64 rays to every sample.

use crate::common::soups::{soup, vec};
use crate::common::{Compared, LitParts, Rays, Soup};
use core::f32::consts::TAU;
use glam::{DVec3, Vec2, Vec3};
use lighting::TubeLight;
use lobe_core::oracle::Random;
use lobe_core::{Capsule, Lobe, Outline, Receiver, Sphere, light_integral};
use shading::{Accuracy, Coverage, LightExtent, LightId, LightLobes, Shaft, Visibility, VisibilityQuery};
use visibility_mask::{Blockers, MaskVisibility, Raster, UnitSquare, hooks};
use visibility_silhouettes::{AnyHit, SilhouetteBlockers, SilhouetteMesh};

/// Corners of a polygon of up to 24, thin ones among them, about a point.
fn corners(random: &mut Random, center: Vec3, normal: Vec3) -> Vec<Vec3> {
    let (u, v) = normal.any_orthonormal_pair();
    let size = random.log_uniform(0.02, 1.5) as f32;
    let long = random.log_uniform(1.0, 40.0) as f32;
    let count = 3 + (random.bits() % 22) as usize;
    let turn = random.between(0.0, 1.0) as f32;
    (0..count)
        .map(|k| {
            let (sin, cos) = (TAU * (k as f32 + turn) / count as f32).sin_cos();
            center + (u * cos + v * (sin / long)) * size
        })
        .collect()
}

/// A window on a light: all of it, or any part.
fn window(case: usize, random: &mut Random, whole: UnitSquare) -> UnitSquare {
    if case.is_multiple_of(3) {
        return whole;
    }
    let part = |random: &mut Random| Vec2::new(random.between(0.1, 1.0) as f32, random.between(0.1, 1.0) as f32);
    let half = whole.half * part(random);
    let place = 2.0 * part(random) - 1.0;
    UnitSquare { half, center: whole.center + (whole.half - half) * place, ..whole }
}

/// A light among triangles or before them, as a receiver sees it.
struct Seen {
    normal: Vec3,
    position: Vec3,
    whole: Outline,
    outline: Outline,
    extent: LightExtent,
}

impl Seen {
    /// A polygon, with a normal and a place for its receiver. Every fourth one may be among the triangles.
    fn polygon(case: usize, random: &mut Random) -> Option<Self> {
        let low = if case.is_multiple_of(4) { -0.5 } else { 1.5 };
        let center = vec(random, 0.3) + Vec3::Y * random.between(low, 4.0) as f32;
        let tilt = random.between(0.0, 1.2);
        let facing = random.axis_at(DVec3::Y, tilt).as_vec3().normalize();
        let corners = corners(random, center, facing);
        let normal = random.axis().as_vec3().normalize();
        let position = vec(random, 1.0) - Vec3::Y * random.between(0.0, 3.0) as f32;
        let axis = if facing.dot(center - position) > 0.0 { facing } else { -facing };
        let relative: Vec<Vec3> = corners.iter().map(|p| p - position).collect();
        let whole = Outline::new(&relative, axis)?;
        let light = whole.sphere();
        let extent = |n: Vec3| corners.iter().map(|p| n.dot(*p - position - light.center).abs()).fold(0.0, f32::max);
        let (u, v) = facing.any_orthonormal_pair();
        let sides = [u * extent(u), v * extent(v)];
        let extent = LightExtent { sides, margin: 0.1 * light.radius, is_beyond_all: false };
        Some(Self { normal, position, whole, outline: whole.above(normal)?, extent })
    }

    /// A tube, thin or thick, most of them among the triangles.
    fn tube(case: usize, random: &mut Random) -> Option<Self> {
        let low = if case.is_multiple_of(4) { 1.5 } else { -0.5 };
        let center = vec(random, 0.3) + Vec3::Y * random.between(low, 1.5) as f32;
        let along = random.axis().as_vec3() * random.log_uniform(0.02, 1.5) as f32;
        let radius = random.log_uniform(0.01, 0.5) as f32;
        let tube = TubeLight { ends: [center - along, center + along], radius, radiance: Vec3::ONE };
        let normal = random.axis().as_vec3().normalize();
        let position = vec(random, 1.0) - Vec3::Y * random.between(0.0, 3.0) as f32;
        let at = Receiver::on_surface(position, normal, normal);
        let whole = tube.outline(&at)?;
        whole.body()?;
        Some(Self { normal, position, whole, outline: whole.above(normal)?, extent: tube.extent()? })
    }

    /// How far a ray goes that begins at the receiver, in lengths of its direction, which is one long along the axis: to a tube, whose distance from points
    /// along the ray falls and then grows, or to its rim.
    fn distance(&self, direction: DVec3) -> f64 {
        let Some(body) = self.outline.body() else { return f64::from(self.outline.depth_to(true)) };
        let [a, b] = body.ends.map(|p| p.as_dvec3());
        let (unit, radius) = (direction.normalize(), f64::from(body.radius));
        let off = |t: f64| {
            let along = ((unit * t - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            (unit * t).distance(a + (b - a) * along) - radius
        };
        let (mut low, mut high) = (0.0, a.length() + b.length() + radius);
        for _ in 0..80 {
            let [p, q] = [0.4, 0.6].map(|part| low + (high - low) * part);
            if off(p) < off(q) { high = q } else { low = p }
        }
        let nearest = low;
        if off(nearest) >= f64::from(Capsule::RIM) * radius {
            return f64::from(self.outline.depth_to(true));
        }
        if off(nearest) >= 0.0 {
            return (nearest + 4.0 * off(nearest)) / direction.length();
        }
        low = 0.0;
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if off(middle) < 0.0 { high = middle } else { low = middle }
        }
        low / direction.length()
    }

    /// Whether the light's plane or a tube cuts a triangle.
    fn is_cut(&self, soup: &Soup, origin: DVec3) -> bool {
        let axis = self.outline.axis().as_dvec3();
        let reaches = self.outline.body().is_some_and(|body| {
            let [a, b] = body.ends.map(|p| p.as_dvec3());
            let near = 0.5 * a.distance(b) + f64::from(body.radius);
            soup.corners().any(|corners| {
                let [p, q, r] = corners.map(|p| p.as_dvec3() - origin);
                let middle = (p + q + r) / 3.0;
                middle.distance(0.5 * (a + b))
                    < near + [p, q, r].map(|p| p.distance(middle)).into_iter().fold(0.0, f64::max)
            })
        });
        reaches
            || soup.corners().any(|corners| {
                let last = f64::from(self.outline.depth_to(true));
                let behind = corners.map(|p| axis.dot(p.as_dvec3() - origin) > last);
                behind.contains(&true) && behind.contains(&false)
            })
    }
}

fn compare(case: usize, random: &mut Random, seen: fn(usize, &mut Random) -> Option<Seen>) -> Option<Compared> {
    let soup = soup(case % 6, random);
    if soup.triangles.is_empty() {
        return None;
    }
    let seen = seen(case, random)?;
    let Seen { normal, position, whole, outline, extent } = &seen;
    let at = Receiver::on_surface(*position, *normal, *normal);
    let rays = Rays(&soup);
    let meshes = [SilhouetteMesh::new(0, &soup.positions, &soup.triangles)];
    let blockers = SilhouetteBlockers::new(&meshes, rays);
    let mut scratch = blockers.scratch();
    if !case.is_multiple_of(3) {
        let middle = *position + vec(random, 0.1);
        let light = whole.sphere();
        let light = Sphere { center: light.center + *position, ..light };
        let shaft = Shaft::new(Sphere { center: middle, radius: position.distance(middle) * 1.001 }, light, LightId(0));
        blockers.enter(&shaft.with_extent(Some(*extent)), &mut scratch);
    }
    let cone = whole.cone();
    let query = VisibilityQuery {
        outline: Some(outline),
        ..VisibilityQuery::new(&at, LightId(0), &cone, Accuracy::new(0.003))
    };
    let coverage = blockers.select(&query, &mut scratch);
    if cone.one_minus_cos < 0.6 {
        // Edges beside the outline count as far as all groups list them: its masks are turned the same way in each.
        let mut alone = blockers.scratch();
        blockers.select(&query, &mut alone);
        let [here, alone] = [&scratch, &alone].map(|scratch| blockers.across(&query, scratch));
        assert!(here == alone, "case {case}: {here} {alone}");
    }
    let square = UnitSquare::around_outline(outline, random.axis().as_vec3());
    let square = window(case, random, square);
    let depth = 1 + (case as u32 / 7) % 6;
    let mut mask = hooks::mask_of(&square, depth, case.is_multiple_of(2), *normal, outline);
    let emitting: Vec<_> = (0..mask.side()).map(|j| mask.emitting(j)).collect();
    match coverage {
        Coverage::Lit => {}
        Coverage::Dark => mask.block_all(),
        Coverage::Partial => blockers.splat(&query, &mut scratch, &mut mask),
    }
    let origin = rays.leave(*position, *normal).as_dvec3();
    let touches = seen.is_cut(&soup, origin);
    let raster = mask.raster();
    let [mut different, mut all, mut wrong] = [0; 3];
    let mut open = 0;
    for (j, (from, to)) in emitting.into_iter().enumerate() {
        let row = hooks::row(&mask, j);
        for i in from..to {
            let truth = |aside: f64, up: f64| {
                let x = f64::from(raster.left)
                    + (f64::from(i) + 0.5 + f64::from(Raster::shift(j)) + aside) / f64::from(raster.samples);
                let y = f64::from(raster.bottom) + (j as f64 + 0.5 + up) / f64::from(raster.rows);
                let [r, u, a] = [square.right, square.up, square.axis].map(|v| v.as_dvec3());
                let direction = r * x + u * y + a;
                soup.hits(origin, direction, seen.distance(direction))
            };
            let dark = row[i as usize / 64] >> (i % 64) & 1 == 0;
            all += 1;
            let hidden = truth(0.0, 0.0);
            open += u32::from(!hidden);
            if dark != hidden {
                different += 1;
                // Next to an edge either answer is right.
                let around = [(2e-2, 0.0), (-2e-2, 0.0), (0.0, 2e-2), (0.0, -2e-2)];
                wrong += u32::from(around.iter().all(|(x, y)| truth(*x, *y) != dark));
            }
        }
    }
    let is_partial = coverage == Coverage::Partial;
    let lit = is_partial.then(|| LitParts::of(&blockers, &query, &mut scratch, &mask, [open, all])).flatten();
    Some(Compared { samples: [different, all, wrong], touches, lit })
}

/// Samples that differ, all samples, and those that differ by more than rounding, of cases without and with cuts; the worst case of each kind, and
/// how many cases there were.
type Sums = ([[u64; 3]; 2], [[u32; 2]; 2], [u32; 2]);

fn compare_all(seed: u64, count: usize, seen: fn(usize, &mut Random) -> Option<Seen>) -> (Sums, LitParts) {
    let mut random = Random::new(seed);
    let (mut sums, mut worst, mut cases) = ([[0_u64; 3]; 2], [[0; 2]; 2], [0; 2]);
    let mut known = LitParts::default();
    for case in 0..count {
        let Some(Compared { samples: [different, all, wrong], touches, lit }) = compare(case, &mut random, seen) else {
            continue;
        };
        known.add(lit);
        let kind = usize::from(touches);
        cases[kind] += 1;
        for (sum, x) in sums[kind].iter_mut().zip([different, all, wrong]) {
            *sum += u64::from(x);
        }
        if wrong > worst[kind][0] {
            worst[kind] = [wrong, case as u32];
            println!("case {case} (kind {}): {different} of {all} differ, {wrong} of them are wrong", case % 6);
        }
    }
    for ([different, all, wrong], (cases, light)) in sums.iter().zip(cases.iter().zip(["apart", "cut"])) {
        println!("{cases} cases, {light}: {different} of {all} samples differ, {wrong} are wrong");
    }
    ((sums, worst, cases), known)
}

/// Edges beside the outline are left out, and yet each sample is right: in whole windows and parts of them, above horizons, before
/// triangles that the light's plane cuts.
#[test]
fn every_sample_is_that_of_a_ray() {
    let ((sums, worst, cases), known) = compare_all(177, 8_000, Seen::polygon);
    known.check();
    assert!(cases.iter().all(|count| *count > 600), "{cases:?}");
    let part = |k: usize| sums[k][0] as f64 / sums[k][1] as f64;
    assert!(worst.iter().all(|worst| worst[0] <= 2) && sums.iter().all(|sum| sum[2] <= 4), "{worst:?} {sums:?}");
    assert!(part(0) < 1e-5 && part(1) < 1e-5, "{} {}", part(0), part(1));
}

/// The same of tubes, whose surface cuts the triangles among which they are: all but a few samples beside the chords of their arcs.
#[test]
fn every_sample_of_a_tube_is_that_of_a_ray() {
    let ((sums, worst, cases), _) = compare_all(178, 3_000, Seen::tube);
    assert!(cases.iter().all(|count| *count > 200), "{cases:?}");
    let part = |k: usize| sums[k][0] as f64 / sums[k][1] as f64;
    assert!(worst.iter().all(|worst| worst[0] <= 4) && sums.iter().all(|sum| sum[2] <= 20), "{worst:?} {sums:?}");
    assert!(part(0) < 1e-5 && part(1) < 2e-5, "{} {}", part(0), part(1));
}

/// A ceiling above a tube is cut by the tube's plane for most receivers, but beside the tube: they see all of it without a mask.
#[test]
fn a_ceiling_above_a_tube_hides_nothing_of_it() {
    let mut soup = Soup::default();
    let [a, b, c, d] = [(-3.0, -3.0), (3.0, -3.0), (3.0, 3.0), (-3.0, 3.0)].map(|(x, z)| Vec3::new(x, 2.8, z));
    soup.add([a, b, c]);
    soup.add([a, c, d]);
    let tube =
        TubeLight { ends: [Vec3::new(-0.8, 2.6, 0.0), Vec3::new(0.8, 2.6, 0.0)], radius: 0.02, radiance: Vec3::ONE };
    let meshes = [SilhouetteMesh::new(0, &soup.positions, &soup.triangles)];
    let blockers = SilhouetteBlockers::new(&meshes, Rays(&soup));
    let (mut cut, mut lit) = (0, 0);
    for k in 0..400 {
        let position = Vec3::new(0.25 * (k % 20) as f32 - 2.4, 0.0, 0.25 * (k / 20) as f32 - 2.4);
        let at = Receiver::on_surface(position, Vec3::Y, Vec3::Y);
        let outline = tube.outline(&at).expect("above the floor");
        let cone = outline.cone();
        let query = VisibilityQuery {
            outline: Some(&outline),
            ..VisibilityQuery::new(&at, LightId(0), &cone, Accuracy::default())
        };
        let behind = [a, b, c, d].map(|p| outline.axis().dot(p - position) > outline.depth_to(false));
        cut += u32::from(behind.contains(&true) && behind.contains(&false));
        lit += u32::from(blockers.select(&query, &mut blockers.scratch()) == Coverage::Lit);
    }
    assert!(cut > 300 && lit == 400, "{cut} cut, {lit} lit");
}

/// Half the length and half the width of a strip of light, how high it is, and where a wall stands through it.
const LENGTH: f32 = 1.2;
const WIDTH: f32 = 0.15;
const HEIGHT: f32 = 0.45;
const WALL: f32 = -0.7;

/// A wall stands through a strip of light. The line in which the light cuts it is an outline as any other: it turns masks, and the lit part is found as it is.
/// While masks were turned without it, rows ran along it, and bands on the floor were wrong by up to 3.5 %.
#[test]
fn a_wall_through_a_strip_of_light_hides_what_is_behind_it() {
    let mut soup = Soup::default();
    let [a, b, c, d] = [(0.02, -0.3), (0.82, -0.3), (0.82, 0.3), (0.02, 0.3)].map(|(y, z)| Vec3::new(WALL, y, z));
    soup.add([a, b, c]);
    soup.add([a, c, d]);
    let meshes = [SilhouetteMesh::new(0, &soup.positions, &soup.triangles)];
    let rays = Rays(&soup);
    let visibility = MaskVisibility::new(SilhouetteBlockers::new(&meshes, rays));
    let corners = [(LENGTH, WIDTH), (-LENGTH, WIDTH), (-LENGTH, -WIDTH), (LENGTH, -WIDTH)];
    let corners = corners.map(|(x, z)| Vec3::new(x, HEIGHT, z));
    let lobe = Lobe::new(Vec3::Y, 1.0, Vec3::ONE);
    let (mut sum, mut largest, mut count) = (0.0, 0.0_f64, 0);
    for k in 0..200_u16 {
        let position = Vec3::new(-3.0 + 0.11 * f32::from(k % 20), 0.0, 0.13 + 0.17 * f32::from(k / 20));
        let at = Receiver::on_surface(position, Vec3::Y, Vec3::Y);
        let outline = Outline::new(&corners.map(|p| p - position), Vec3::Y).expect("above the floor");
        let cone = outline.cone();
        let query = VisibilityQuery {
            outline: Some(&outline),
            ..VisibilityQuery::new(&at, LightId(0), &cone, Accuracy::default())
        };
        let mut scratch = visibility.scratch();
        if visibility.coverage(&query, &mut scratch) != Coverage::Partial {
            continue;
        }
        let all = light_integral(&at, &lobe.into(), &cone, Some(&outline));
        let got = f64::from(visibility.fraction(&query, &lobe, all, &mut scratch).x);
        let origin = rays.leave(position, Vec3::Y).as_dvec3();
        let (mut lit, mut total) = (0.0, 0.0);
        for (i, j) in (0..600).flat_map(|i| (0..120).map(move |j| (i, j))) {
            let [x, z] = [(i, 600, LENGTH), (j, 120, WIDTH)]
                .map(|(i, of, half)| f64::from(half) * ((2 * i + 1) as f64 / f64::from(of) - 1.0));
            let to = DVec3::new(x, f64::from(HEIGHT), z) - origin;
            let part = 1.0 / to.length_squared().powi(2);
            total += part;
            lit += if soup.hits(origin, to, 1.0) { 0.0 } else { part };
        }
        let error = (got / (lit / total) - 1.0).abs();
        (sum, largest, count) = (sum + error, largest.max(error), count + 1);
    }
    let mean = sum / f64::from(count);
    println!("{count} receivers: own radiance off by {mean:.5} in the mean, by {largest:.5} at most");
    assert!(count > 60 && mean < 1.5e-3 && largest < 9e-3, "{count} {mean} {largest}");
}
