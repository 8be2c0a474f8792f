use fearless_simd::{Level, Simd, dispatch, f32x8, i32x8, prelude::*};
use glam::{Vec3, Vec4};
use lobe_core::SelfShadow;
use lobe_core::vec3x8::Vec3x8;
use rayon::prelude::*;

use crate::quality::self_distance;
use crate::random::{Random, fibonacci, quasi_random};
use crate::surface::Surface;
use crate::tree::TriangleTree;

/// Points of the surface from which rays are cast, and directions over the whole sphere at each; those below the
/// horizon and within some degrees of it are left out. A quarter of the points lets many spheres fit their own rays only:
/// 128 spheres then err by 9 % more.
const POINTS: usize = 48_000;
/// Sets of up to this number of spheres use a part of the points: for each sphere as many as in a set of 128.
const FEW: usize = 8;
const DIRECTIONS: usize = 24;
const LOWEST: f32 = 0.1;
/// Cost of a lit ray that is blocked, relative to a dark ray that is not: dark spots show more than missing shade. Bunny,
/// 64 spheres: of all points 0.40 % are dark by mistake with 2, 0.20 % with 3, where dark points get 3.0 and 3.8 % light.
const DARK_SPOT: f32 = 2.5;
/// `UNLIKE`: cost of a distance that is e times the set's own, as a fraction of the rays, so that the set's distance stays where
/// no ray decides. With twenty times this value 484 spheres err twice as much, because each has few rays. `UNLIKE_SPHERE`: cost of a
/// near sphere that is moved or shrunk by a whole radius. With 484 spheres it saves a twentieth of the error.
const UNLIKE: f32 = 1e-6;
const UNLIKE_SPHERE: f32 = 6e-6;
/// Radii that are tried, near spheres tried for each, and sweeps in which each sphere is fitted to the rays that the others leave.
const RADII: [f32; 7] = [1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4];
const TRIES: usize = 24;
const SWEEPS: i32 = 15;
/// Resolution of distances, as fractions of the radius; the last bin holds all beyond four radii.
const BINS: usize = 1025;
const BIN: f32 = 4.0 / 1024.0;
/// Farther than any point of the mesh, whose bounding box has a diagonal of 1: never blocks.
const NEVER: f32 = 4.0;

/// One ray from the surface past a sphere: from its start to the centre, its direction, and how much its start sees of the
/// near sphere.
struct Pass {
    ray: u32,
    to: Vec3,
    v: Vec3,
    near: f32,
}

impl Pass {
    fn new(ray: u32, from: Vec3, v: Vec3, sphere: Vec4) -> Self {
        let to = sphere.truncate() - from;
        Self { ray, to, v, near: SelfShadow::nearness(sphere.w, to.length()) }
    }

    /// The distance at which the ray leaves its near sphere; negative if it misses.
    fn exit(&self, whole: f32, own: &SelfShadow) -> f32 {
        let radius = whole - whole * (1.0 - own.radius) * self.near;
        let to = self.to + own.offset * (whole * self.near);
        let along = to.dot(self.v);
        let half_sq = radius * radius - (to.length_squared() - along * along);
        if half_sq > 0.0 { along + half_sq.sqrt() } else { -1.0 }
    }

    fn blocks(&self, whole: f32, own: &SelfShadow) -> bool {
        let exit = self.exit(whole, own);
        exit > 0.0 && exit > own.distance
    }
}

/// Passes, eight side by side, and the cost of blocking each. The last block is filled with passes that cost nothing.
#[derive(Default)]
struct Passes {
    /// Rows: to the centre, direction, nearness, cost.
    blocks: Vec<[[f32; 8]; 8]>,
    count: usize,
}

impl Passes {
    fn clear(&mut self) {
        self.blocks.clear();
        self.count = 0;
    }

    fn push(&mut self, pass: &Pass, cost: f32) {
        let lane = self.count % 8;
        if lane == 0 {
            self.blocks.push([[0.0; 8]; 8]);
        }
        let Pass { to, v, near, .. } = *pass;
        if let Some(block) = self.blocks.last_mut() {
            let column = [to.x, to.y, to.z, v.x, v.y, v.z, near, cost];
            block.iter_mut().zip(column).for_each(|(row, value)| row[lane] = value);
        }
        self.count += 1;
    }

    /// Adds the cost of each pass to the bin of its [exit](Pass::exit); those that miss go to bins of their own lanes, so that none waits for
    /// another.
    #[inline(always)]
    fn bin<S: Simd>(&self, simd: S, whole: f32, own: &SelfShadow, bins: &mut [f32; BINS + 8]) {
        let scale = 1.0 / (BIN * whole);
        let [zero, last] = [0.0, (BINS - 1) as f32].map(|value| f32x8::splat(simd, value));
        let missed: [f32; 8] = core::array::from_fn(|lane| (BINS + lane) as f32);
        let missed = f32x8::simd_from(simd, missed);
        let shrink = f32x8::splat(simd, whole * (1.0 - own.radius));
        for block in &self.blocks {
            let row = |i: usize| f32x8::simd_from(simd, block[i]);
            let near = row(6);
            let radius = whole - shrink * near;
            let moved = Vec3x8::splat(simd, own.offset) * (near * whole);
            let to = Vec3x8::new(row(0), row(1), row(2)) + moved;
            let along = to.dot(Vec3x8::new(row(3), row(4), row(5)));
            let half_sq = radius * radius - (to.length_squared() - along * along);
            let exit = along + half_sq.max(zero).sqrt();
            let meets = half_sq.simd_gt(zero) & exit.simd_gt(zero);
            let place = meets.select((exit * scale).min(last), missed);
            let places: [i32; 8] = place.to_int::<i32x8<S>>().into();
            for (place, cost) in places.iter().zip(&block[7]) {
                bins[*place as usize] += cost;
            }
        }
    }
}

/// Fits a near sphere and a distance to each sphere, for shadows on its own object.
///
/// Rays leave points spread over the mesh; a ray is dark if it meets the mesh. The fit minimises the cost of misclassified rays,
/// sphere by sphere, given the rays that the other spheres block. The best distance for a near sphere follows from a histogram of
/// the exit distances of the rays that no other sphere blocks. The fit starts from whole spheres with the set's one distance
/// and tries near spheres around the best one, in smaller and smaller steps.
///
/// Receivers inside the sphere see the near sphere. It becomes the whole sphere with growing distance ([`SelfShadow::seen`]).
/// Bunny, 64 spheres, points that the fit does not know: V errs by 1.89 % in the mean, 0.25 % of all points are dark by
/// mistake (by more than 0.3), and dark points get 3.7 % light. With the sphere's own centre instead: 2.16, 0.29 and 5.2 %;
/// with a near sphere that does not grow back: 2.10, 0.30 and 4.0 %.
pub(crate) fn self_shadows(surface: &Surface, tree: &TriangleTree, spheres: &[Vec4]) -> Vec<SelfShadow> {
    let start = self_distance(surface, spheres);
    let points = if spheres.len() > FEW { POINTS } else { POINTS / 128 * spheres.len() };
    let rays = rays(surface, tree, points);
    let whole = SelfShadow::whole(start);
    let passes: Vec<Vec<Pass>> = spheres
        .par_iter()
        .map(|sphere| {
            let pass = |(&(from, v, _), number): (&(Vec3, Vec3, bool), u32)| {
                let pass = Pass::new(number, from, v, *sphere);
                (pass.exit(sphere.w, &whole) > 0.0).then_some(pass)
            };
            rays.iter().zip(0..).filter_map(pass).collect()
        })
        .collect();

    // Distances are lengths until the end.
    let mut found = vec![whole; spheres.len()];
    let mut covers = vec![0_u32; rays.len()];
    for (sphere, passes) in spheres.iter().zip(&passes) {
        passes.iter().filter(|p| p.blocks(sphere.w, &whole)).for_each(|p| covers[p.ray as usize] += 1);
    }
    let [unlike, unlike_sphere] = [UNLIKE, UNLIKE_SPHERE].map(|share| share * rays.len() as f32);
    let price = |own: &SelfShadow| {
        let distance = if start > 0.0 { unlike * (own.distance / start).ln().abs() } else { 0.0 };
        distance + unlike_sphere * (own.offset.length() + 1.0 - own.radius)
    };
    let mut random = Random::new(2);
    let mut free = Passes::default();
    for sweep in 0..SWEEPS {
        let step = 0.4 * 0.85_f32.powi(sweep);
        for ((sphere, passes), found) in spheres.iter().zip(&passes).zip(&mut found) {
            passes.iter().filter(|p| p.blocks(sphere.w, found)).for_each(|p| covers[p.ray as usize] -= 1);
            free.clear();
            for pass in passes.iter().filter(|p| covers[p.ray as usize] == 0) {
                free.push(pass, if rays[pass.ray as usize].2 { -1.0 } else { DARK_SPOT });
            }
            let tried = tries(found, step, &mut random);
            let tried: Vec<(f32, SelfShadow)> =
                tried.par_iter().map(|own| farthest(&free, *own, sphere.w, 0.1 * start, price)).collect();
            if let Some(best) = tried.iter().min_by(|a, b| a.0.total_cmp(&b.0)) {
                *found = best.1;
            }
            passes.iter().filter(|p| p.blocks(sphere.w, found)).for_each(|p| covers[p.ray as usize] += 1);
        }
    }
    let ratio = |(sphere, own): (&Vec4, SelfShadow)| {
        if sphere.w > 0.0 { SelfShadow { distance: own.distance / sphere.w, ..own } } else { SelfShadow::whole(0.0) }
    };
    spheres.iter().zip(found).map(ratio).collect()
}

/// Spheres to try: the best until now, concentric ones and such about its centre, and some around it.
fn tries(best: &SelfShadow, step: f32, random: &mut Random) -> Vec<SelfShadow> {
    let shadow = |offset: Vec3, radius: f32| SelfShadow { offset, radius, ..*best }.sound();
    let mut tried = vec![*best];
    for radius in RADII {
        tried.push(shadow(Vec3::ZERO, radius));
        if best.offset != Vec3::ZERO {
            tried.push(shadow(best.offset, radius));
        }
    }
    for _ in 0..TRIES {
        let radius = (best.radius + 0.3 * (random.unit() - 0.5)).clamp(0.4, 1.0);
        let mut unit = || 2.0 * random.unit() - 1.0;
        let aside = Vec3::new(unit(), unit(), unit());
        tried.push(shadow(best.offset + aside.clamp_length_max(1.0) * step, radius));
    }
    tried
}

/// The distance that minimises the cost of misclassified rays for one sphere; returns the cost and both.
fn farthest(
    free: &Passes,
    own: SelfShadow,
    whole: f32,
    least: f32,
    price: impl Fn(&SelfShadow) -> f32,
) -> (f32, SelfShadow) {
    let mut bins = [0.0_f32; BINS + 8];
    dispatch!(Level::new(), simd => free.bin(simd, whole, &own, &mut bins));
    // From blocking nothing to blocking all that leaves it farther than `least`. Against that, each dark ray that is
    // blocked is one less wrong, each lit one more.
    let at = |distance: f32| SelfShadow { distance, ..own };
    let (mut wrong, mut best) = (0.0, (price(&at(NEVER)), at(NEVER)));
    for (bin, cost) in bins[..BINS].iter().enumerate().rev() {
        let distance = bin as f32 * BIN * whole;
        if distance < least || bin == 0 {
            break;
        }
        wrong += cost;
        let own = at(distance);
        let cost = wrong + price(&own);
        if cost < best.0 {
            best = (cost, own);
        }
    }
    best
}

/// Rays that leave the mesh: start, direction, and whether the mesh is in the way.
fn rays(surface: &Surface, tree: &TriangleTree, points: usize) -> Vec<(Vec3, Vec3, bool)> {
    const OFF: f32 = 2e-6;
    let spread = surface.spread();
    let normals: Vec<Vec3> = surface.normals().map(Vec3::normalize_or_zero).collect();
    let of_point = |i: usize| {
        let (t, [a, b, c]) = spread(quasi_random(i));
        let triangle = surface.triangles[t];
        let p = triangle[0] * a + triangle[1] * b + triangle[2] * c;
        // Sheets are seen from both sides, solids from outside.
        let normal = if i.is_multiple_of(2) { normals[t] } else { -normals[t] };
        let inside = |n: Vec3| tree.contains(p + n * 1e-4);
        let normal = if inside(normal) { -normal } else { normal };
        let seen = normal != Vec3::ZERO && !inside(normal);
        // The spiral turned by as much as the point's number says.
        let turn = quasi_random(i + POINTS);
        let turn = glam::Quat::from_euler(
            glam::EulerRot::ZYZ,
            core::f32::consts::TAU * turn.x,
            (2.0 * turn.y - 1.0).acos(),
            core::f32::consts::TAU * turn.z,
        );
        (0..if seen { DIRECTIONS } else { 0 })
            .map(move |k| turn * fibonacci(k, DIRECTIONS))
            .filter(move |v| v.dot(normal) > LOWEST)
            .map(move |v| (p + normal * OFF, v, tree.blocks(p + normal * OFF, v)))
    };
    (0..points).into_par_iter().flat_map_iter(of_point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes;

    fn surface(triangles: &[[Vec3; 3]]) -> Surface {
        let positions: Vec<Vec3> = triangles.iter().flatten().copied().collect();
        let indices: Vec<[u32; 3]> = (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        Surface::new(&positions, &indices).expect("a mesh")
    }

    /// Whether the spheres block a ray from the mesh's surface.
    fn blocked(spheres: &[Vec4], own: &[SelfShadow], from: Vec3, v: Vec3) -> bool {
        spheres.iter().zip(own).any(|(sphere, own)| {
            let own = SelfShadow { distance: sphere.w * own.distance, ..*own };
            Pass::new(0, from, v, *sphere).blocks(sphere.w, &own)
        })
    }

    /// Fraction of the rays that the spheres misclassify.
    fn wrong(rays: &[(Vec3, Vec3, bool)], spheres: &[Vec4], own: &[SelfShadow]) -> f32 {
        let differ = |(from, v, dark): &&(Vec3, Vec3, bool)| blocked(spheres, own, *from, *v) != *dark;
        rays.iter().filter(differ).count() as f32 / rays.len() as f32
    }

    /// Eight passes at once fall into the bins of one by one, to the bit.
    #[test]
    fn passes_side_by_side_exit_as_one_by_one() {
        let mut random = Random::new(3);
        let mut unit = || 2.0 * random.unit() - 1.0;
        let mut vector = || Vec3::new(unit(), unit(), unit());
        for whole in [0.3_f32, 1e-3] {
            let own = SelfShadow { offset: 0.3 * vector(), radius: 0.7, distance: 0.1 };
            let (mut passes, mut want) = (Passes::default(), [0.0_f32; BINS + 8]);
            for k in 0..1003_u32 {
                let pass = Pass::new(k, vector() * (3.0 * whole), vector().normalize_or(Vec3::X), Vec4::W * whole);
                let (exit, cost) = (pass.exit(whole, &own), 0.5 + k as f32);
                let at = if exit > 0.0 { ((exit * (1.0 / (BIN * whole))) as usize).min(BINS - 1) } else { BINS };
                want[at] += cost;
                passes.push(&pass, cost);
            }
            let mut bins = [0.0; BINS + 8];
            dispatch!(Level::new(), simd => passes.bin(simd, whole, &own, &mut bins));
            assert!(want[BINS] > 0.0 && want[BINS - 1] > 0.0);
            assert_eq!(bins[..BINS], want[..BINS]);
            assert_eq!(bins[BINS..].iter().sum::<f32>(), want[BINS]);
        }
    }

    #[test]
    fn a_sphere_that_bulges_out_does_not_blacken_its_mesh() {
        let surface = surface(&shapes::bumpy_sphere(16));
        let tree = TriangleTree::new(&surface.triangles);
        let rays = rays(&surface, &tree, POINTS);
        assert!(rays.len() > POINTS * DIRECTIONS / 3);
        let [lo, hi] = surface.unit_bounds();
        let sphere = (0.5 * (lo + hi)).extend(0.55 * (hi - lo).max_element());
        let own = self_shadows(&surface, &tree, &[sphere]);
        let whole = [SelfShadow::whole(0.01 / sphere.w)];
        let (before, after) = (wrong(&rays, &[sphere], &whole), wrong(&rays, &[sphere], &own));
        let dark = rays.iter().filter(|r| r.2).count() as f32 / rays.len() as f32;
        println!("{before} wrong before, {after} after, {dark} dark; {own:?}");
        assert!(before > 0.5 && after <= dark);
    }

    #[test]
    fn what_stands_apart_still_shadows() {
        // Two spheres side by side, exact: each must still shadow the other.
        let (positions, triangles) = shapes::sphere(12);
        let part: Vec<[Vec3; 3]> = triangles.iter().map(|t| t.map(|i| positions[i as usize])).collect();
        let both: Vec<[Vec3; 3]> =
            part.iter().copied().chain(part.iter().map(|t| t.map(|p| p + Vec3::X * 2.6))).collect();
        let surface = surface(&both);
        let tree = TriangleTree::new(&surface.triangles);
        let scale = (1.0 / surface.diagonal) as f32;
        let at = |x: f32| ((Vec3::X * x - surface.center.as_vec3()) * scale).extend(scale);
        let spheres = [at(0.0), at(2.6)];
        let own = self_shadows(&surface, &tree, &spheres);
        let rays = rays(&surface, &tree, POINTS);
        let dark = rays.iter().filter(|r| r.2).count() as f32 / rays.len() as f32;
        let missed = wrong(&rays, &spheres, &own);
        println!("{dark} dark, {missed} wrong; {own:?}");
        assert!(missed < 0.35 * dark, "{missed} of {dark}");
    }

    /// A sphere with a dent as deep as the cap that it replaces.
    fn dented_sphere() -> Vec<[Vec3; 3]> {
        let (positions, triangles) = shapes::sphere(16);
        let dent = |p: Vec3| if p.z > 0.6 { p.with_z(1.2 - p.z) } else { p };
        triangles.iter().map(|t| t.map(|i| dent(positions[i as usize]))).collect()
    }

    /// The whole sphere bridges the dent: no dark spot may be seen in it.
    #[test]
    fn a_bridged_hollow_stays_lit() {
        let surface = surface(&dented_sphere());
        let tree = TriangleTree::new(&surface.triangles);
        let scale = (1.0 / surface.diagonal) as f32;
        let unit = |p: Vec3| (p - surface.center.as_vec3()) * scale;
        let sphere = [unit(Vec3::ZERO).extend(scale)];
        let own = self_shadows(&surface, &tree, &sphere);
        let rim = unit(Vec3::Z * 0.59).z;
        let hollow = |p: Vec3| p.z > unit(Vec3::ZERO).z && p.distance(sphere[0].truncate()) < 0.97 * scale && p.z < rim;
        let rays = rays(&surface, &tree, POINTS);
        let lit: Vec<_> = rays.iter().filter(|r| !r.2 && hollow(r.0)).collect();
        let lost = |own: &[SelfShadow]| {
            lit.iter().filter(|r| blocked(&sphere, own, r.0, r.1)).count() as f32 / lit.len() as f32
        };
        let one = [SelfShadow::whole(self_distance(&surface, &sphere) / scale)];
        println!("{} rays, {} lost with one distance, {} fitted; {own:?}", lit.len(), lost(&one), lost(&own));
        assert!(lit.len() > 1000 && lost(&one) > 0.1 && lost(&own) < 0.02, "{}", lost(&own));
    }

    /// The surface inside the sphere needs a smaller one, the plate beside it sees the whole silhouette: one radius cannot be both.
    #[test]
    fn the_whole_sphere_is_seen_from_afar() {
        let mut triangles = dented_sphere();
        let corner = |y: f32, z: f32| Vec3::new(2.5, y, z);
        let [a, b, c, d] = [corner(-1.5, -1.5), corner(1.5, -1.5), corner(-1.5, 1.5), corner(1.5, 1.5)];
        triangles.extend([[a, b, c], [b, d, c]]);
        let surface = surface(&triangles);
        let tree = TriangleTree::new(&surface.triangles);
        let scale = (1.0 / surface.diagonal) as f32;
        let unit = |p: Vec3| (p - surface.center.as_vec3()) * scale;
        let sphere = [unit(Vec3::ZERO).extend(scale)];
        let own = self_shadows(&surface, &tree, &sphere);
        let mut rays = rays(&surface, &tree, POINTS);
        rays.retain(|ray| ray.0.x > unit(Vec3::X * 2.0).x && ray.1.x < 0.0);
        // Compare: the near sphere everywhere, also as seen from the plate.
        let near = own[0].near(scale);
        let small = [(sphere[0].truncate() + near.center).extend(near.radius)];
        let same = [SelfShadow::whole(own[0].distance / own[0].radius)];
        let (fitted, one) = (wrong(&rays, &sphere, &own), wrong(&rays, &small, &same));
        println!("{fitted} of {} wrong, {one} with one radius; {own:?}", rays.len());
        assert!(own[0].radius < 0.95 && fitted < 0.7 * one, "{fitted} against {one}");
    }
}
