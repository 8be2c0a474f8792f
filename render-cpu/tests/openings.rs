//! A closed room with one opening: each point sees a small part of a large light, and its radiance is right as a part of itself.

use brdf::{Brdf, Material, MetallicRoughness, ModifiedPhong};
use core::f64::consts::PI;
use glam::{DVec2, DVec3, UVec2, Vec3};
use lighting::{Environment, EnvironmentMap, FlatLight, Light, SphereLight, TubeLight};
use lobe_core::{NO_OBJECT, Receiver, Sphere};
use render_cpu::{CpuShader, GBuffer, SceneSilhouettes, SurfaceHits, World};
use scene::{Frame, Scene, Shade};
use shading::Accuracy;
use test_scenes::{Opening, ROOM, leaf, openings, room, room_with, with_door};
use visibility_mask::{MaskVisibility, Mixture};
use visibility_silhouettes::SilhouetteBlockers;
use visibility_spheres::SphereBlockers;

mod blades;

const LIGHT: DVec3 = DVec3::new(0.0, 0.3, -12.5);
/// Half a side of squares of light, and the radii of spheres: wide ones, and those that a room sees as 9° and 15° to each side; squares that fill most of a hemisphere.
const SQUARES: [f64; 5] = [11.0, 15.0, 2.0, 30.0, 60.0];
const SPHERES: [f64; 3] = [6.0, 3.4, 2.0];
/// Sides of the polygon that stands for the outline of the sphere.
const SIDES: u32 = 1024;

/// The part of a convex polygon, wound either way, for which a linear function is not negative.
fn clipped(polygon: &[DVec2], inside: impl Fn(DVec2) -> f64) -> Vec<DVec2> {
    let mut out = Vec::new();
    for (k, p) in polygon.iter().enumerate() {
        let q = polygon[(k + 1) % polygon.len()];
        let [at_p, at_q] = [inside(*p), inside(q)];
        if at_p >= 0.0 {
            out.push(*p);
        }
        if at_p * at_q < 0.0 {
            out.push(p.lerp(q, at_p / (at_p - at_q)));
        }
    }
    out
}

/// The common part of two convex polygons, the second of which is wound counterclockwise.
fn common(polygon: &[DVec2], other: &[DVec2]) -> Vec<DVec2> {
    (0..other.len()).fold(polygon.to_vec(), |rest, k| {
        let (p, q) = (other[k], other[(k + 1) % other.len()]);
        clipped(&rest, |at| (q - p).perp_dot(at - p))
    })
}

/// The convex hull of points, counterclockwise.
fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let half = |points: &mut dyn Iterator<Item = &DVec2>| {
        let mut out: Vec<DVec2> = Vec::new();
        for p in points {
            while let [.., a, b] = out[..]
                && (b - a).perp_dot(p - b) <= 0.0
            {
                out.pop();
            }
            out.push(*p);
        }
        out.pop();
        out
    };
    let mut out = half(&mut points.iter());
    out.extend(half(&mut points.iter().rev()));
    out
}

/// Points of which a light is the hull, as a receiver sees it.
type Seen = fn(DVec3) -> Vec<DVec3>;

/// The light and the blockers outside of the room.
struct Outside {
    openings: Vec<Opening>,
    light: Seen,
    /// Corners of a convex blocker beyond the opening.
    blocker: Vec<DVec3>,
    /// The centre and the radius of a sphere there instead.
    round: Option<(DVec3, f64)>,
}

/// The radiance of a white diffuse point by the formula for polygons (J. H. Lambert): the parts of openings before the light, less the parts of
/// these before the blocker, all of which are convex polygons in the openings' plane.
fn oracle(at: &Receiver, outside: &Outside) -> f64 {
    let (x, n) = (at.position.as_dvec3(), at.normal.as_dvec3());
    let z = f64::from(-ROOM.z);
    if x.z - z < 1e-4 {
        return 0.0;
    }
    let on_plane = |p: &DVec3| (x + (p - x) * ((z - x.z) / (p.z - x.z))).truncate();
    let polygon = |points: &[DVec3]| hull(points.iter().map(on_plane).collect());
    let flux = |polygon: &[DVec2]| {
        let to = |k: usize| (polygon[k % polygon.len()].extend(z) - x).normalize();
        let sides = (0..polygon.len()).map(|k| {
            let (p, q) = (to(k), to(k + 1));
            let across = p.cross(q);
            let sin = across.length();
            if sin > 0.0 { sin.atan2(p.dot(q)) * n.dot(across) / sin } else { 0.0 }
        });
        (sides.sum::<f64>() / (2.0 * PI)).abs()
    };
    let light = polygon(&(outside.light)(x));
    let through = |opening: &Opening| {
        let [left, right, low, high] = opening.map(f64::from);
        let corners = [[left, low], [right, low], [right, high], [left, high]].map(DVec2::from_array);
        let lit = common(&clipped(&corners, |p| n.dot(p.extend(z) - x)), &light);
        let round = outside.round.map(|(center, radius)| rim_seen(center, radius, x));
        let blocker = round.as_ref().unwrap_or(&outside.blocker);
        let hidden = if blocker.is_empty() { 0.0 } else { flux(&common(&lit, &polygon(blocker))) };
        flux(&lit) - hidden
    };
    outside.openings.iter().map(through).sum()
}

/// Mean and 99th percentile of the error of each point as a part of its own radiance, and the largest radiance that is not seen at all.
fn own_errors(scene: &Scene, outside: &Outside) -> [f64; 3] {
    errors_beside(scene, outside.round, |at| oracle(at, outside))
}

/// The same beside another formula, with a sphere outside of the room.
fn errors_beside(scene: &Scene, round: Option<(DVec3, f64)>, oracle: impl Fn(&Receiver) -> f64) -> [f64; 3] {
    let world = World::new(scene);
    let mut silhouettes = SceneSilhouettes::new(scene, |_| true);
    silhouettes.refit(scene);
    let silhouettes = SilhouetteBlockers::new(silhouettes.meshes(), SurfaceHits::new(&world, |_| true));
    let round = round.map(|(center, radius)| Sphere { center: center.as_vec3(), radius: radius as f32 });
    let blockers =
        Mixture::new(SphereBlockers::new(round.as_slice(), &vec![NO_OBJECT; round.iter().len()], &[]), silhouettes);
    let points = GBuffer::new(&world, scene.width, scene.height, 1).points;
    let mut out = vec![Vec3::ZERO; points.receivers.len()];
    let frame =
        Frame { materials: &scene.materials, lights: &scene.lights, accuracy: Accuracy::default(), threshold: 0.0 };
    CpuShader::new(MaskVisibility::new(blockers)).shade(&points, &frame, &mut out).expect("room");
    let truth: Vec<f64> = points.receivers.iter().map(oracle).collect();
    let white = truth.iter().copied().fold(0.0, f64::max);
    let bright = truth.iter().zip(&out).filter(|(truth, _)| **truth > 1e-3 * white);
    let mut errors: Vec<f64> = bright.map(|(truth, got)| (f64::from(got.x) / truth - 1.0).abs()).collect();
    errors.sort_unstable_by(f64::total_cmp);
    let dark = truth.iter().zip(&out).filter(|(_, got)| **got == Vec3::ZERO).map(|(truth, _)| truth / white);
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    [mean, errors[errors.len() * 99 / 100], dark.fold(0.0, f64::max)]
}

fn sphere(radius: f64) -> Light {
    SphereLight::new(Sphere { center: LIGHT.as_vec3(), radius: radius as f32 }, Vec3::ONE).into()
}

fn square(half: f64) -> Light {
    let [u, v] = [Vec3::X, Vec3::Y].map(|side| side * half as f32);
    FlatLight::rectangle(LIGHT.as_vec3(), u, v, Vec3::ONE).expect("a square").into()
}

fn square_seen<const HALF: usize>(_: DVec3) -> Vec<DVec3> {
    let half = SQUARES[HALF];
    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| LIGHT + half * DVec3::new(x, y, 0.0)).to_vec()
}

fn sphere_seen<const RADIUS: usize>(x: DVec3) -> Vec<DVec3> {
    rim_seen(LIGHT, SPHERES[RADIUS], x)
}

/// Points of the circle in which the cone from a receiver touches a sphere.
fn rim_seen(center: DVec3, radius: f64, x: DVec3) -> Vec<DVec3> {
    let to = center - x;
    let sin = radius / to.length();
    let cos = (1.0 - sin * sin).sqrt();
    let axis = to.normalize();
    let (u, v) = axis.any_orthonormal_pair();
    let point = |k: u32| {
        let (sin_k, cos_k) = (2.0 * PI * f64::from(k) / f64::from(SIDES)).sin_cos();
        x + to.length() * cos * (axis * cos + (u * cos_k + v * sin_k) * sin)
    };
    (0..SIDES).map(point).collect()
}

/// The parts of a uniform sky.
fn sky() -> Vec<Light> {
    let world = Sphere { center: Vec3::ZERO, radius: 20.0 };
    Environment::new(EnvironmentMap::uniform(Vec3::ONE), 2, world).lights().to_vec()
}

/// A sky behind all of an opening.
fn sky_seen(_: DVec3) -> Vec<DVec3> {
    const FAR: f64 = 1e4;
    let corners = [[-FAR, -FAR], [FAR, -FAR], [FAR, FAR], [-FAR, FAR]];
    corners.map(|[x, y]| DVec3::new(x, y, f64::from(-ROOM.z) - 1.0)).to_vec()
}

/// The lights outside, with their names and how they are seen.
fn lights() -> [(&'static str, Vec<Light>, Seen); 4] {
    [
        ("square", vec![square(SQUARES[0])], square_seen::<0>),
        ("large square", vec![square(SQUARES[1])], square_seen::<1>),
        ("sphere", vec![sphere(SPHERES[0])], sphere_seen::<0>),
        ("sky", sky(), sky_seen),
    ]
}

/// The errors of a scene by each light, which are to be at most some numbers in the mean and for 99 %.
fn check(name: &str, opening: Opening, blocker: &[DVec3], most: [[f64; 2]; 4]) {
    for ((light, emits, seen), [most, most_of_99]) in lights().into_iter().zip(most) {
        let outside = Outside { openings: vec![opening], light: seen, blocker: blocker.to_vec(), round: None };
        let mut scene = room(opening, sphere(SPHERES[0]));
        scene.lights = emits;
        let scene = if blocker.is_empty() { scene } else { with_door(scene, opening) };
        let [mean, p99, dark] = own_errors(&scene, &outside);
        println!("{name}, {light}: own error {mean:.5}, 99 % {p99:.4}, darkened {dark:.4}");
        assert!(mean < most && p99 <= most_of_99 && dark < 0.02, "{name}, {light}: {mean} {p99} {dark}");
    }
}

/// A gap between a door and its frame is narrower than the samples of a mask.
#[test]
fn rooms_behind_doors_ajar_are_lit() {
    let opening = [-0.45, 0.45, -1.5, 0.5];
    let [hinge, sides @ ..] = leaf(opening).map(|v| v.as_dvec3());
    let corner = |k: usize| (0..3).filter(|axis| k >> axis & 1 == 1).fold(hinge, |p, axis| p + sides[axis]);
    let blocker: Vec<DVec3> = (0..8).map(corner).collect();
    check("door", opening, &blocker, [[0.001, 0.005], [0.001, 0.005], [0.001, 0.005], [0.0005, 0.002]]);
}

#[test]
fn rooms_behind_openings_are_lit() {
    check("window", [-0.6, 0.6, -0.2, 0.8], &[], [[0.0006, 0.005], [0.0006, 0.005], [0.0006, 0.005], [0.0004, 0.002]]);
    check(
        "small window",
        [-0.2, 0.2, 0.1, 0.5],
        &[],
        [[0.0006, 0.005], [0.0006, 0.005], [0.0006, 0.005], [0.0004, 0.002]],
    );
    check("slit", [-0.3, -0.28, -1.2, 0.8], &[], [[0.0006, 0.005], [0.0006, 0.005], [0.0006, 0.005], [0.0004, 0.002]]);
}

/// Openings that neither rows nor columns of a mask cross.
#[test]
fn openings_between_all_lines_are_found() {
    let small = [-0.2, 0.2, 0.3, 0.7];
    let hole = [0.3, 0.38, -0.2, -0.12];
    const FEW: [f64; 2] = [0.004, 0.02];
    for (name, opening, emits, light, [most, most_of_99]) in [
        ("small window, square of 60 m", small, square(SQUARES[3]), square_seen::<3> as Seen, FEW),
        ("small window, square of 120 m", small, square(SQUARES[4]), square_seen::<4>, FEW),
        ("hole, square of 22 m", hole, square(SQUARES[0]), square_seen::<0>, FEW),
        ("hole, square of 60 m", hole, square(SQUARES[3]), square_seen::<3>, FEW),
        ("hole, sphere", hole, sphere(SPHERES[0]), sphere_seen::<0>, FEW),
    ] {
        let outside = Outside { openings: vec![opening], light, blocker: Vec::new(), round: None };
        let [mean, p99, dark] = own_errors(&room(opening, emits), &outside);
        println!("{name}: own error {mean:.5}, 99 % {p99:.4}, darkened {dark:.4}");
        assert!(mean < most && p99 < most_of_99 && dark < 1e-4, "{name}: {mean} {p99} {dark}");
    }
}

/// Holes of 3 cm, slits of 1 cm and panes, of which masks see some and miss others.
#[test]
fn all_of_many_openings_are_found() {
    let cases = [
        ("2 holes", openings([2, 1], [0.03, 0.03], [0.33, 0.0])),
        ("9 holes", openings([3, 3], [0.03, 0.03], [0.3, 0.27])),
        ("8 slits", openings([1, 8], [1.2, 0.01], [0.0, 0.11])),
        ("20 slits", openings([20, 1], [0.012, 0.9], [0.06, 0.0])),
        ("12 panes", openings([4, 3], [0.26, 0.3], [0.3, 0.34])),
    ];
    for (name, all) in cases {
        for (light, emits, seen) in lights() {
            let outside = Outside { openings: all.clone(), light: seen, blocker: Vec::new(), round: None };
            let mut scene = room_with(&all, sphere(SPHERES[0]));
            scene.lights = emits;
            let [mean, p99, dark] = own_errors(&scene, &outside);
            println!("{name}, {light}: own error {mean:.5}, 99 % {p99:.4}, darkened {dark:.4}");
            assert!(mean < 0.004 && p99 < 0.02 && dark < 1e-4, "{name}, {light}: {mean} {p99} {dark}");
        }
    }
}

/// A glow of 10° and a bright rectangle in a picture of the sky, of which each point sees a part through a window.
#[test]
fn pictures_behind_openings_are_seen() {
    let opening = [-0.6, 0.6, -0.2, 0.8];
    let [left, right, low, high] = opening.map(f64::from);
    let size = UVec2::new(256, 128);
    let blank = EnvironmentMap::new(size, vec![Vec3::ZERO; 256 * 128]).expect("a picture");
    let toward = Vec3::new(0.0, 0.34, -0.94);
    let glow = |d: Vec3| 0.5 + 60.0 * (-(d.angle_between(toward).to_degrees() / 10.0).powi(2)).exp();
    let cloud = |d: Vec3| if d.x.abs() < 0.3 * -d.z && (d.y - 0.35).abs() < 0.15 { 20.0 } else { 0.5 };
    for (name, most, radiance) in
        [("glow", [0.006, 0.03], &glow as &dyn Fn(Vec3) -> f32), ("cloud", [0.01, 0.2], &cloud)]
    {
        let texel = |k: u32| Vec3::splat(radiance(blank.direction((k % 256) as f32 + 0.5, (k / 256) as f32 + 0.5)));
        let map = EnvironmentMap::new(size, (0..size.x * size.y).map(texel).collect()).expect("a picture");
        let mut scene = room(opening, sphere(SPHERES[0]));
        (scene.width, scene.height) = (24, 16);
        let world = Sphere { center: Vec3::ZERO, radius: 20.0 };
        scene.lights = Environment::new(map.clone(), 2, world).lights().to_vec();
        let seen = |at: &Receiver| {
            const N: u32 = 200;
            let (x, n) = (at.position.as_dvec3(), at.normal.as_dvec3());
            let place = |k: u32, [from, to]: [f64; 2]| from + (to - from) * (f64::from(k) + 0.5) / f64::from(N);
            let of = |k: u32| {
                let to = DVec3::new(place(k % N, [left, right]), place(k / N, [low, high]), f64::from(-ROOM.z)) - x;
                let v = to.normalize();
                n.dot(v).max(0.0) * -v.z / to.length_squared() * f64::from(map.radiance(v.as_vec3()).x)
            };
            let sum: f64 = if x.z + f64::from(ROOM.z) < 1e-4 { 0.0 } else { (0..N * N).map(of).sum() };
            sum * (right - left) * (high - low) / (PI * f64::from(N * N))
        };
        let [mean, p99, _] = errors_beside(&scene, None, seen);
        println!("{name}: own error {mean:.5}, 99 % {p99:.4}");
        assert!(mean < most[0] && p99 < most[1], "{name}: {mean} {p99}");
    }
}

/// Spheres outside of a window, also such that are smaller than the samples of a mask are apart.
#[test]
fn spheres_before_openings_are_seen() {
    let opening = [-0.3, 0.3, 0.2, 0.8];
    for (x, y, z, radius) in [(0.1, 0.4, -3.2, 0.15), (0.0, 0.5, -3.6, 0.4), (0.2, 0.3, -2.75, 0.05)] {
        for (light, emits, seen) in lights() {
            let round = Some((DVec3::new(x, y, z), radius));
            let outside = Outside { openings: vec![opening], light: seen, blocker: Vec::new(), round };
            let mut scene = room(opening, sphere(SPHERES[0]));
            scene.lights = emits;
            let [mean, p99, _] = own_errors(&scene, &outside);
            println!("{radius} at {z}, {light}: own error {mean:.5}, 99 % {p99:.4}");
            assert!(mean < 0.004 && p99 < 0.02, "{radius} at {z}, {light}: {mean} {p99}");
        }
    }
}

/// A slit that shows some points the middle of lights that are long or wide.
#[test]
fn slits_before_near_lights_are_found() {
    const CENTER: DVec3 = DVec3::new(0.0, 0.5, -4.5);
    const HALVES: [DVec3; 2] = [DVec3::new(6.0, 0.5, 0.0), DVec3::new(6.0, 2.0, 0.0)];
    fn seen<const K: usize>(_: DVec3) -> Vec<DVec3> {
        let signs = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        signs.map(|[x, y]| CENTER + HALVES[K] * DVec3::new(x, y, 0.0)).to_vec()
    }
    let opening = [-0.02, 0.02, -1.3, 0.8];
    for (half, light) in HALVES.into_iter().zip([seen::<0> as Seen, seen::<1>]) {
        let [u, v] = [Vec3::X * half.x as f32, Vec3::Y * half.y as f32];
        let emits = FlatLight::rectangle(CENTER.as_vec3(), u, v, Vec3::ONE).expect("a rectangle");
        let outside = Outside { openings: vec![opening], light, blocker: Vec::new(), round: None };
        let [mean, p99, dark] = own_errors(&room(opening, emits.into()), &outside);
        println!("slit, {half}: own error {mean:.5}, 99 % {p99:.4}, darkened {dark:.4}");
        assert!(dark == 0.0 && mean < 0.004, "{half}: {dark} {mean}");
    }
}

/// Lights that are narrower than 17° to each side, whose masks miss a slit now and then.
#[test]
fn slits_before_narrow_lights_are_found() {
    let opening = [-0.3, -0.28, -1.2, 0.8];
    for (name, emits, light) in [
        ("sphere of 15°", sphere(SPHERES[1]), sphere_seen::<1> as Seen),
        ("sphere of 9°", sphere(SPHERES[2]), sphere_seen::<2>),
        ("square of 9°", square(SQUARES[2]), square_seen::<2>),
    ] {
        let outside = Outside { openings: vec![opening], light, blocker: Vec::new(), round: None };
        let [mean, p99, dark] = own_errors(&room(opening, emits), &outside);
        println!("slit, {name}: own error {mean:.5}, 99 % {p99:.4}, darkened {dark:.4}");
        assert!(mean < 0.006 && p99 < 0.02 && dark == 0.0, "{name}: {mean} {p99} {dark}");
    }
}

/// A tube crosses a slit at an angle: its two long sides, not its round ends, bound what is seen.
#[test]
fn tubes_behind_slits_are_seen() {
    const ENDS: [DVec3; 2] = [DVec3::new(-5.0, 1.5, -6.0), DVec3::new(4.0, -0.5, -7.0)];
    fn seen<const TENTHS: u32>(x: DVec3) -> Vec<DVec3> {
        ENDS.into_iter().flat_map(|end| rim_seen(end, 0.1 * f64::from(TENTHS), x)).collect()
    }
    let opening = [-0.02, 0.02, -1.3, 1.0];
    for (radius, light) in [(0.1, seen::<1> as Seen), (0.4, seen::<4>)] {
        let emits = TubeLight { ends: ENDS.map(|end| end.as_vec3()), radius, radiance: Vec3::ONE };
        let outside = Outside { openings: vec![opening], light, blocker: Vec::new(), round: None };
        let [mean, p99, dark] = own_errors(&room(opening, emits.into()), &outside);
        println!("slit, tube of {radius}: own error {mean:.5}, 99 % {p99:.4}, darkened {dark:.4}");
        assert!(mean < 0.003 && p99 < 0.03 && dark < 0.01, "{radius}: {mean} {p99} {dark}");
    }
}

/// Metals and glossy lobes see a window in the wall as it is, in its highlight and beside that: by points of the window.
#[test]
fn windows_are_seen_by_all_lobes() {
    const POINTS: [u32; 2] = [360, 300];
    let opening = [-0.6, 0.6, -0.2, 0.8];
    let [left, right, low, high] = opening.map(f64::from);
    let metal = |roughness| MetallicRoughness::new(Vec3::ONE, 1.0, roughness).expect("a metal").into();
    let glossy = |exponent| ModifiedPhong { kd: Vec3::splat(0.3), ks: Vec3::splat(0.4), exponent }.into();
    let materials: [(&str, Material); 4] = [
        ("metal of 0.2", metal(0.2)),
        ("metal of 0.5", metal(0.5)),
        ("modified Phong 40", glossy(40.0)),
        ("modified Phong 400", glossy(400.0)),
    ];
    for (name, material) in materials {
        for (light, emits) in [("square", square(SQUARES[4])), ("sphere", sphere(SPHERES[0]))] {
            let is_lit = |from: DVec3, v: DVec3| {
                let to = LIGHT - from;
                light == "square" || to.length_squared() - to.dot(v).powi(2) < SPHERES[0] * SPHERES[0]
            };
            let seen = |at: &Receiver| {
                let x = at.position.as_dvec3();
                let area = (right - left) * (high - low) / f64::from(POINTS[0] * POINTS[1]);
                let point = |k: u32| {
                    let [i, j] = [k % POINTS[0], k / POINTS[0]].map(|i| f64::from(i) + 0.5);
                    let (px, py) = (i / f64::from(POINTS[0]), j / f64::from(POINTS[1]));
                    let to = DVec3::new(left + px * (right - left), low + py * (high - low), f64::from(-ROOM.z)) - x;
                    let distance = to.length();
                    let v = to / distance;
                    let solid = area * -v.z / (distance * distance);
                    let cos = v.dot(at.normal.as_dvec3());
                    if cos <= 0.0 || solid <= 0.0 || !is_lit(x, v) {
                        return 0.0;
                    }
                    f64::from(material.eval(at, v.as_vec3()).x) * solid
                };
                (0..POINTS[0] * POINTS[1]).map(point).sum::<f64>()
            };
            let mut scene = room(opening, emits);
            scene.materials = vec![material.clone()];
            (scene.width, scene.height) = (18, 12);
            let [mean, p99, _] = errors_beside(&scene, None, seen);
            println!("{name}, {light}: own error {mean:.5}, 99 % {p99:.4}");
            assert!(mean < 0.002 && p99 < 0.01, "{name}, {light}: {mean} {p99}");
        }
    }
}
