use glam::{Vec3, Vec4};
use lobe_core::SelfShadow;
use rayon::prelude::*;

use super::quality::self_distance;
use super::random::{fibonacci, quasi_random};
use super::surface::Surface;
use super::tree::TriangleTree;

/// Points of the surface from which rays are cast, and directions over the whole sphere at each; those below the
/// horizon and within some degrees of it are left out. A quarter of the points lets many spheres fit their own rays only:
/// 128 spheres then err by 9 % more.
const POINTS: usize = 48_000;
const DIRECTIONS: usize = 24;
const LOWEST: f32 = 0.1;
/// What a lit ray that is blocked costs, one that is wrongly lit costing 1: dark spots show more than missing shade.
const DARK_SPOT: f32 = 1.25;
/// What it costs to take a distance e times the set's own, as a share of the rays: where no ray says anything, it stays. No
/// more than that: at twenty times this, 484 spheres err twice as much, since each has few rays.
const UNLIKE: f32 = 1e-6;
/// Radii that are tried, and how often each sphere is fitted to what the others leave.
const RADII: [f32; 7] = [1.0, 0.94, 0.88, 0.82, 0.76, 0.7, 0.64];
const SWEEPS: usize = 5;
/// A point from which spheres take much of its light shows as a spot: its lit rays cost up to so many times as much, by the
/// square of the share that it loses. Bunny, 64 spheres: of all points 0.53 % are dark by mistake without this, 0.37 % with
/// 8, 0.33 % with 30, where the mean error of V begins to grow.
const SPOT: f32 = 8.0;
/// How often that share is found anew.
const ROUNDS: usize = 3;

/// One ray from the surface past a sphere about unit radii: where along the ray the centre is, and the squared distance of the two.
struct Pass {
    ray: u32,
    along: f32,
    aside_sq: f32,
}

impl Pass {
    /// How far the ray leaves a ball about the centre; negative where it misses it or leaves it behind.
    fn exit(&self, radius: f32) -> f32 {
        let half_sq = radius * radius - self.aside_sq;
        if half_sq > 0.0 { self.along + half_sq.sqrt() } else { -1.0 }
    }
}

/// Fits to each sphere how its own object's receivers see it.
///
/// Rays leave points spread over the mesh; each is dark where it meets the mesh. Sphere by sphere, radius and
/// distance are chosen so that the fewest rays differ, given what the other spheres block: for each radius the best
/// distance is exact, by sorting the exits of the rays that no other sphere blocks. Starts from the set's one distance.
pub(crate) fn self_shadows(surface: &Surface, tree: &TriangleTree, spheres: &[Vec4]) -> Vec<SelfShadow> {
    let start = self_distance(surface, spheres);
    let rays = rays(surface, tree);
    // What each ray costs if it is wrong, less than zero if it is dark.
    let mut costs: Vec<f32> = rays.iter().map(|ray| if ray.2 { -1.0 } else { DARK_SPOT }).collect();
    let passes: Vec<Vec<Pass>> = spheres
        .par_iter()
        .map(|ball| {
            let pass = |(&(from, v, _), number): (&(Vec3, Vec3, bool), u32)| {
                let to = ball.truncate() - from;
                let along = to.dot(v);
                let aside_sq = (to - v * along).length_squared();
                let pass = Pass { ray: number, along, aside_sq };
                (pass.exit(ball.w) > 0.0).then_some(pass)
            };
            rays.iter().zip(0..).filter_map(pass).collect()
        })
        .collect();

    let mut found: Vec<(f32, f32)> = spheres.iter().map(|ball| (ball.w, start)).collect();
    let mut covers = vec![0_u32; rays.len()];
    for (passes, &(radius, distance)) in passes.iter().zip(&found) {
        passes.iter().filter(|p| p.exit(radius) > distance).for_each(|p| covers[p.ray as usize] += 1);
    }
    let unlike = UNLIKE * rays.len() as f32;
    for sweep in 0..ROUNDS * SWEEPS {
        if sweep > 0 && sweep % SWEEPS == 0 {
            weigh_spots(&rays, &covers, &mut costs);
        }
        for ((ball, passes), found) in spheres.iter().zip(&passes).zip(&mut found) {
            passes.iter().filter(|p| p.exit(found.0) > found.1).for_each(|p| covers[p.ray as usize] -= 1);
            let free: Vec<&Pass> = passes.iter().filter(|p| covers[p.ray as usize] == 0).collect();
            *found = best(&free, &costs, ball.w, start, unlike);
            passes.iter().filter(|p| p.exit(found.0) > found.1).for_each(|p| covers[p.ray as usize] += 1);
        }
    }
    let ratio = |(ball, (radius, distance)): (&Vec4, (f32, f32))| {
        if ball.w > 0.0 {
            SelfShadow { radius: (radius / ball.w).min(1.0), distance: distance / ball.w }
        } else {
            SelfShadow { radius: 1.0, distance: 0.0 }
        }
    };
    spheres.iter().zip(found).map(ratio).collect()
}

/// Makes the lit rays dear of points that lose much of their light. Never cheaper: so rounds settle.
fn weigh_spots(rays: &[(Vec3, Vec3, bool)], covers: &[u32], costs: &mut [f32]) {
    let mut first = 0;
    for rays in rays.chunk_by(|a, b| a.0 == b.0) {
        let covers = &covers[first..first + rays.len()];
        let lit = rays.iter().filter(|ray| !ray.2).count();
        let lost = rays.iter().zip(covers).filter(|(ray, covers)| !ray.2 && **covers > 0).count();
        let share = lost as f32 / lit.max(1) as f32;
        let cost = DARK_SPOT * (1.0 + (SPOT - 1.0) * share * share);
        for cost_of in costs[first..first + rays.len()].iter_mut().filter(|cost| **cost > 0.0) {
            *cost_of = cost_of.max(cost);
        }
        first += rays.len();
    }
}

/// The radius and distance that get the rays wrong that cost least.
fn best(free: &[&Pass], costs: &[f32], radius: f32, start: f32, unlike: f32) -> (f32, f32) {
    let (mut best, mut least) = ((radius, start), f32::INFINITY);
    for scale in RADII {
        let r = radius * scale;
        let mut exits: Vec<(f32, f32)> =
            free.iter().map(|p| (p.exit(r), costs[p.ray as usize])).filter(|e| e.0 > 0.0).collect();
        exits.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(b.1.total_cmp(&a.1)));
        // From blocking nothing to blocking all that leaves it farther than a tenth of the set's distance. Against that,
        // each dark ray that is blocked is one less wrong, each lit one more.
        let price = |distance: f32| if start > 0.0 { unlike * (distance / start).ln().abs() } else { 0.0 };
        let nothing = (2.0 * radius).max(start);
        let mut wrong = 0.0;
        let mut consider = |wrong: f32, distance: f32| {
            if wrong + price(distance) < least {
                (least, best) = (wrong + price(distance), (r, distance));
            }
        };
        consider(0.0, nothing);
        for (k, (exit, cost)) in exits.iter().enumerate() {
            let next = exits.get(k + 1).map_or(0.0, |e| e.0);
            let distance = 0.5 * (exit + next);
            if distance < 0.1 * start {
                break;
            }
            wrong += cost;
            consider(wrong, distance);
        }
    }
    best
}

/// Rays that leave the mesh: start, direction, and whether the mesh is in the way.
fn rays(surface: &Surface, tree: &TriangleTree) -> Vec<(Vec3, Vec3, bool)> {
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
    (0..POINTS).into_par_iter().flat_map_iter(of_point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::set::shapes;

    fn surface(triangles: &[[Vec3; 3]]) -> Surface {
        let positions: Vec<Vec3> = triangles.iter().flatten().copied().collect();
        let indices: Vec<[u32; 3]> = (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        Surface::new(&positions, &indices).expect("a mesh")
    }

    /// Share of rays that the spheres get wrong.
    fn wrong(rays: &[(Vec3, Vec3, bool)], spheres: &[(Vec4, f32)]) -> f32 {
        let blocked = |from: Vec3, v: Vec3| {
            spheres.iter().any(|(ball, distance)| {
                let to = ball.truncate() - from;
                let along = to.dot(v);
                let pass = Pass { ray: 0, along, aside_sq: (to - v * along).length_squared() };
                let exit = pass.exit(ball.w);
                exit > 0.0 && exit > *distance
            })
        };
        rays.iter().filter(|(from, v, dark)| blocked(*from, *v) != *dark).count() as f32 / rays.len() as f32
    }

    #[test]
    fn a_ball_that_bulges_out_does_not_blacken_its_mesh() {
        let surface = surface(&shapes::bumpy_ball(16));
        let tree = TriangleTree::new(&surface.triangles);
        let rays = rays(&surface, &tree);
        assert!(rays.len() > POINTS * DIRECTIONS / 3);
        let [lo, hi] = surface.unit_bounds();
        let ball = (0.5 * (lo + hi)).extend(0.55 * (hi - lo).max_element());
        let own = self_shadows(&surface, &tree, &[ball]);
        let fitted = ball.truncate().extend(ball.w * own[0].radius);
        let (before, after) = (wrong(&rays, &[(ball, 0.01)]), wrong(&rays, &[(fitted, ball.w * own[0].distance)]));
        let dark = rays.iter().filter(|r| r.2).count() as f32 / rays.len() as f32;
        println!("{before} wrong before, {after} after, {dark} dark; {own:?}");
        assert!(before > 0.5 && after <= dark);
    }

    #[test]
    fn what_stands_apart_still_shadows() {
        // Two balls side by side, exact: what one hides of the other stays hidden.
        let (positions, triangles) = shapes::ball(12);
        let part: Vec<[Vec3; 3]> = triangles.iter().map(|t| t.map(|i| positions[i as usize])).collect();
        let both: Vec<[Vec3; 3]> =
            part.iter().copied().chain(part.iter().map(|t| t.map(|p| p + Vec3::X * 2.6))).collect();
        let surface = surface(&both);
        let tree = TriangleTree::new(&surface.triangles);
        let scale = (1.0 / surface.diagonal) as f32;
        let at = |x: f32| ((Vec3::X * x - surface.center.as_vec3()) * scale).extend(scale);
        let spheres = [at(0.0), at(2.6)];
        let own = self_shadows(&surface, &tree, &spheres);
        let rays = rays(&surface, &tree);
        let fitted: Vec<(Vec4, f32)> =
            spheres.iter().zip(&own).map(|(b, o)| (b.truncate().extend(b.w * o.radius), b.w * o.distance)).collect();
        let dark = rays.iter().filter(|r| r.2).count() as f32 / rays.len() as f32;
        let missed = wrong(&rays, &fitted);
        println!("{dark} dark, {missed} wrong; {own:?}");
        assert!(missed < 0.35 * dark, "{missed} of {dark}");
    }
}
