//! Coverage and masks of shadow maps in WGSL against the same in Rust.

mod mesh;
mod pictures;

use self::mesh::{FLOOR, Mesh};
use crate::call::{call_with, trial};
use glam::{Vec2, Vec3};
use libtest_mimic::Trial;
use lobe_core::oracle::Random;
use lobe_core::wgsl::join;
use lobe_core::{Cone, Receiver, Sphere};
use render_gpu::Gpu;
use shading::gpu::GpuPages;
use shading::{Accuracy, Coverage, LightId, VisibilityQuery};
use visibility_mask::wgsl::{ROUND, header};
use visibility_mask::{Blockers as _, Fineness, MAX_DEPTH, Mask, UnitSquare};
use visibility_shadowmap::{PackedMaps, ShadowMapBlockers, wgsl};

pub(crate) fn trials(gpu: Option<&Gpu>) -> Vec<Trial> {
    vec![
        trial("maps_coverage", gpu, coverage),
        trial("maps_masks", gpu, masks),
        trial("maps_masks_of_windows", gpu, masks_of_windows),
        trial("maps_of_several_lights", gpu, several_lights),
        trial("maps_far_from_the_origin", gpu, far_from_the_origin),
        trial("maps_of_tiny_lights", gpu, tiny_lights),
        trial("maps_own_face", gpu, own_face),
        trial("maps_in_pages", gpu, pages),
        trial("maps_pictures", gpu, pictures::agree),
    ]
}

/// A scene under one light.
struct Case {
    name: &'static str,
    mesh: Mesh,
    light: Sphere,
    resolution: u32,
    layers: u32,
    depth: u32,
}

/// A light at a place that appears from the origin under a half-angle in degrees.
fn light(center: [f32; 3], half_angle: f32) -> Sphere {
    let center = Vec3::from(center);
    Sphere { center, radius: center.length() * half_angle.to_radians().sin() }
}

fn cases() -> Vec<Case> {
    let bumpy = || Mesh::bumpy(Vec3::new(0.0, 0.9, 0.0), 0.8).floor(0.0, 2.5);
    let fence = || Mesh::fence().floor(0.0, 2.0);
    let case = |name, mesh, light, resolution, layers, depth| Case { name, mesh, light, resolution, layers, depth };
    vec![
        case("sphere 0.5°, 1024²", bumpy(), light([1.5, 5.0, 0.8], 0.5), 1024, 3, 5),
        case("sphere 5°, 256²", bumpy(), light([1.5, 5.0, 0.8], 5.0), 256, 4, 5),
        case("sphere 15°, 128²", bumpy(), light([3.5, 2.0, 0.8], 15.0), 128, 3, 4),
        case("fence 1°, 512²", fence(), light([1.0, 3.0, 3.0], 1.0), 512, 3, 6),
        case("fence 6°, 256²", fence(), light([-1.0, 2.0, 4.0], 6.0), 256, 1, 3),
        case("room 128²", Mesh::room(), Sphere { center: Vec3::new(0.05, 0.1, -0.07), radius: 0.12 }, 128, 3, 5),
        case("room 512²", Mesh::room(), Sphere { center: Vec3::new(0.05, 0.1, -0.07), radius: 0.04 }, 512, 3, 5),
    ]
}

/// A query of a receiver and a light; for masks also the rotation and the window: its centre and half sides, in radii of the disc.
#[derive(Clone, Copy, Debug)]
struct Question {
    at: Receiver,
    light: Sphere,
    id: LightId,
    tolerance: f32,
    across: Vec3,
    window: [f32; 4],
}

/// The tolerance that gives a depth.
fn tolerance_for(depth: u32) -> f32 {
    let tolerance = [0.01, 0.003, 0.001][depth.clamp(4, 6) as usize - 4];
    assert_eq!(Accuracy::new(tolerance).depth, depth.clamp(4, 6));
    tolerance
}

fn questions(random: &mut Random, receivers: &[Receiver], light: Sphere, depth: u32, zoomed: bool) -> Vec<Question> {
    let tolerance = tolerance_for(depth);
    let question = |at: &Receiver| {
        let half = [0; 2].map(|_| if zoomed { random.between(0.1, 0.7) as f32 } else { 1.0 });
        let [x, y] = half.map(|half| random.between(-0.6, 0.6) as f32 * (1.0 - half));
        let window = [x, y, half[0], half[1]];
        Question { at: *at, light, id: LightId(0), tolerance, across: random.axis().as_vec3(), window }
    };
    receivers.iter().map(question).collect()
}

/// Numbers of a query for WGSL.
const INPUTS: usize = 23;

const FRAME: &str = "struct Frame { light: vec4f, cells: f32, number: u32 }
    var<private> frame: Frame;
    fn v(k: u32) -> vec3f { return vec3f(x(k), x(k + 1u), x(k + 2u)); }
    fn receiver() -> Receiver {
        frame = Frame(vec4f(v(10u), x(13u)), x(14u), u32(x(15u)));
        return Receiver(v(0u), u32(x(3u)), v(4u), 0u, v(7u), 0u, v(4u), 0u);
    }";

fn numbers(question: &Question) -> [f32; INPUTS] {
    let Question { at, light, id, tolerance, across, window } = question;
    let mut out = [0.0; INPUTS];
    let object = [at.object as f32];
    let rest = [light.radius, (1_u32 << Accuracy::new(*tolerance).depth) as f32, id.0 as f32];
    let parts: [&[f32]; 8] = [
        &at.position.to_array(),
        &object,
        &at.normal.to_array(),
        &at.face.to_array(),
        &light.center.to_array(),
        &rest,
        &across.to_array(),
        window,
    ];
    out.iter_mut().zip(parts.concat()).for_each(|(to, x)| *to = x);
    out
}

/// Splits the words into buffers, with their bindings.
fn bound(packed: &PackedMaps, pages: GpuPages) -> Vec<(u32, &[u32])> {
    let words = packed.words();
    let page = |k| pages.range(k, size_of_val(words) as u64);
    let words = |k| &words[page(k).start as usize / 4..page(k).end as usize / 4];
    (0..pages.count()).map(|k| (8 + k, words(k))).collect()
}

fn gpu_coverage(gpu: &Gpu, packed: &PackedMaps, questions: &[Question]) -> Vec<Coverage> {
    gpu_coverage_in(GpuPages::ONE, gpu, packed, questions)
}

fn gpu_coverage_in(pages: GpuPages, gpu: &Gpu, packed: &PackedMaps, questions: &[Question]) -> Vec<Coverage> {
    let words = pages.wgsl("maps", 8);
    let rows: Vec<f32> = questions.iter().flat_map(numbers).collect();
    let text = join(&[&wgsl::COVERAGE, &ROUND]) + FRAME + &words;
    let body = "let at = receiver();
        y(0u, f32(maps_coverage(0u, at, cone_of_sphere(at.position, frame.light))));";
    let got = call_with(gpu, &text, body, &rows, [INPUTS, 1], &bound(packed, pages));
    got.into_iter().map(|c| [Coverage::Lit, Coverage::Partial, Coverage::Dark][c as usize]).collect()
}

fn rust_coverage(blockers: &ShadowMapBlockers, questions: &[Question]) -> Vec<Coverage> {
    let mut scratch = blockers.scratch();
    let coverage = |q: &Question| {
        let cone = Cone::of_sphere(q.at.position, q.light);
        blockers.select(&VisibilityQuery::new(&q.at, q.id, &cone, Accuracy::new(q.tolerance)), &mut scratch)
    };
    questions.iter().map(coverage).collect()
}

/// The results of a mask: emitting and lit area in cells, and the lit cells of each row.
struct Seen {
    emitting: f32,
    lit: f32,
    cells: [u64; 1 << MAX_DEPTH],
}

fn gpu_masks(gpu: &Gpu, packed: &PackedMaps, questions: &[Question], depth: u32) -> Vec<Seen> {
    let side = 1 << depth;
    let mut rows = Vec::with_capacity(questions.len() * side * (INPUTS + 1));
    for question in questions {
        let numbers = numbers(question);
        for lane in 0..side {
            rows.extend(numbers);
            rows.push(lane as f32);
        }
    }
    let (header, words) = (header(depth, Fineness::FINE), GpuPages::ONE.wgsl("maps", 8));
    let text = join(&[&wgsl::SPLAT, &ROUND]) + FRAME + &words + &header;
    let body = "let at = receiver();
        let cone = cone_of_sphere(at.position, frame.light);
        var square = square_facing(cone, v(16u));
        square.center = square.disc * vec2f(x(19u), x(20u));
        square.half = square.disc * vec2f(x(21u), x(22u));
        let lane = u32(x(23u));
        let mask = mask_reset(square, lane, at.normal);
        maps_splat(lane, 0u, at, cone, mask);
        y(0u, f32(emitting.y - min(emitting.x, emitting.y)));
        y(1u, f32(row_count(lit)));
        for (var k = 0u; k < 4u; k++) {
            var cells = 0u;
            for (var i = 0u; i < 16u; i++) {
                let first = (16u * k + i) * (WIDTH / SIDE);
                let rest = row_without(lit, row_span(min(first, WIDTH), min(first + WIDTH / SIDE, WIDTH)));
                cells |= select(0u, 1u << i, row_count(rest) != row_count(lit));
            }
            y(2u + k, f32(cells));
        }";
    let got = call_with(gpu, &text, body, &rows, [INPUTS + 1, 6], &bound(packed, GpuPages::ONE));
    let cell = (256 >> depth) as f32;
    let seen = |rows: &[f32]| {
        let mut seen = Seen { emitting: 0.0, lit: 0.0, cells: [0; 1 << MAX_DEPTH] };
        for (row, cells) in rows.chunks_exact(6).zip(&mut seen.cells) {
            seen.emitting += row[0] / cell;
            seen.lit += row[1] / cell;
            *cells = (0..4).map(|k| (row[2 + k] as u64) << (16 * k)).sum();
        }
        seen
    };
    got.chunks_exact(6 * side).map(seen).collect()
}

fn rust_masks(blockers: &ShadowMapBlockers, questions: &[Question], depth: u32) -> Vec<Seen> {
    let (mut scratch, mut mask) = (blockers.scratch(), Mask::default());
    let seen = |q: &Question| {
        let cone = Cone::of_sphere(q.at.position, q.light);
        let query = VisibilityQuery::new(&q.at, q.id, &cone, Accuracy::new(q.tolerance));
        blockers.select(&query, &mut scratch);
        let mut square = UnitSquare::facing(&cone, q.across);
        square.center = square.disc * Vec2::new(q.window[0], q.window[1]);
        square.half = square.disc * Vec2::new(q.window[2], q.window[3]);
        mask.reset(&square, depth, q.at.normal);
        blockers.splat(&query, &mut scratch, &mut mask);
        let (emitting, lit) = mask.areas();
        let cells = core::array::from_fn(|j| if j < mask.side() { mask.lit_cells(j) } else { 0 });
        Seen { emitting, lit, cells }
    };
    questions.iter().map(seen).collect()
}

/// Checks that at most a fraction `most` of the queries gets another class.
fn compare_coverage(gpu: &Gpu, name: &str, blockers: &ShadowMapBlockers, questions: &[Question], most: f64) {
    let packed = blockers.pack();
    let (want, got) = (rust_coverage(blockers, questions), gpu_coverage(gpu, &packed, questions));
    let differ = want.iter().zip(&got).filter(|(want, got)| want != got).count();
    let count = |what| want.iter().filter(|w| **w == what).count();
    let (lit, partial, dark) = (count(Coverage::Lit), count(Coverage::Partial), count(Coverage::Dark));
    println!(
        "{name}: {} KiB, {lit} lit, {partial} partial, {dark} dark, {differ} differ",
        packed.words().len() * 4 / 1024
    );
    assert!(lit > 20 && partial > 20, "{name}: {lit} {partial} {dark}");
    assert!(differ as f64 <= most * questions.len() as f64, "{name}: {differ} of {} differ", questions.len());
}

/// Compares the masks of the receivers in class partial: mean difference of the visible fraction, and the largest.
fn compare_masks(
    gpu: &Gpu,
    name: &str,
    blockers: &ShadowMapBlockers,
    questions: &[Question],
    depth: u32,
    [mean, largest]: [f64; 2],
) {
    let packed = blockers.pack();
    let partial = rust_coverage(blockers, questions);
    let questions = questions.iter().zip(partial).filter(|(_, c)| *c == Coverage::Partial).map(|(q, _)| *q);
    let questions: Vec<Question> = questions.collect();
    // Mostly penumbrae, and some receivers that turn out wholly lit or dark.
    let (mut penumbrae, mut others) = (0, 0);
    let (questions, want): (Vec<Question>, Vec<Seen>) = questions
        .iter()
        .copied()
        .zip(rust_masks(blockers, &questions, depth))
        .filter(|(_, seen)| {
            let is_between = seen.lit > 0.0 && seen.lit < seen.emitting;
            let (count, most) = if is_between { (&mut penumbrae, 100) } else { (&mut others, 20) };
            *count += 1;
            *count <= most
        })
        .unzip();
    let got = gpu_masks(gpu, &packed, &questions, depth);
    let (mut sum, mut worst, mut place, mut cells, mut all, mut between) = (0.0_f64, 0.0_f64, 0, 0, 0, 0);
    for (k, (want, got)) in want.iter().zip(&got).enumerate() {
        // The ends of rows may differ by one sample.
        assert!((want.emitting - got.emitting).abs() <= 0.02 * want.emitting + 1.0, "{name}: {k}");
        let share = |seen: &Seen| f64::from(seen.lit / seen.emitting.max(1.0));
        between += usize::from(share(want) > 0.0 && share(want) < 1.0);
        let difference = (share(want) - share(got)).abs();
        sum += difference;
        if difference > worst {
            (worst, place) = (difference, k);
        }
        cells += want.cells.iter().zip(&got.cells).map(|(a, b)| (a ^ b).count_ones()).sum::<u32>();
        all += want.cells.iter().map(|a| a.count_ones()).sum::<u32>();
    }
    let count = want.len();
    println!(
        "{name}, depth {depth}: {count} masks, {between} in penumbrae, share differs by {:.1e} in the mean, {worst:.1e} at most \
         (receiver {place}: {} of {}, not {}), {cells} of {all} cells",
        sum / count as f64,
        got[place].lit,
        got[place].emitting,
        want[place].lit,
    );
    assert!(between >= 10, "{name}: {between} of {count}");
    assert!(sum <= mean * count as f64 && worst <= largest, "{name}: {} {worst}", sum / count as f64);
}

fn coverage(gpu: &Gpu) {
    for (k, case) in cases().into_iter().enumerate() {
        let mut random = Random::new(10 + k as u64);
        let blockers = ShadowMapBlockers::new(vec![case.mesh.map(case.light, case.resolution, case.layers)]);
        let receivers = case.mesh.receivers(&mut random, case.light, 1500);
        let questions = questions(&mut random, &receivers, case.light, case.depth, false);
        // Rounding decides whether a texel touches the light or the receiver's plane.
        compare_coverage(gpu, case.name, &blockers, &questions, 0.002);
    }
}

fn masks(gpu: &Gpu) {
    for (k, case) in cases().into_iter().enumerate() {
        let mut random = Random::new(20 + k as u64);
        let blockers = ShadowMapBlockers::new(vec![case.mesh.map(case.light, case.resolution, case.layers)]);
        let receivers = case.mesh.receivers(&mut random, case.light, 8000);
        let questions = questions(&mut random, &receivers, case.light, case.depth, false);
        compare_masks(gpu, case.name, &blockers, &questions, case.depth, [1e-4, 1e-2]);
    }
}

fn masks_of_windows(gpu: &Gpu) {
    for (k, case) in cases().into_iter().enumerate() {
        let mut random = Random::new(30 + k as u64);
        let blockers = ShadowMapBlockers::new(vec![case.mesh.map(case.light, case.resolution, case.layers)]);
        let receivers = case.mesh.receivers(&mut random, case.light, 8000);
        let questions = questions(&mut random, &receivers, case.light, case.depth, true);
        compare_masks(gpu, case.name, &blockers, &questions, case.depth, [2e-4, 2e-2]);
    }
}

fn several_lights(gpu: &Gpu) {
    let mesh = Mesh::bumpy(Vec3::new(0.0, 0.9, 0.0), 0.8).floor(0.0, 2.5);
    let lights = [[1.5, 5.0, 0.8], [-2.0, 3.0, 0.5], [0.5, 4.0, -3.0], [0.0, 6.0, 0.0]].map(|at| light(at, 4.0));
    let maps = [0, 1, 3].map(|k| (LightId(k as u32), mesh.map(lights[k], 128 << (k % 2), 3)));
    let blockers = ShadowMapBlockers::of_lights(maps);
    let mut all = Vec::new();
    for (id, light) in (0..).map(LightId).zip(lights) {
        let mut random = Random::new(40);
        let receivers = mesh.receivers(&mut random, light, 300);
        all.extend(questions(&mut random, &receivers, light, 5, false).into_iter().map(|q| Question { id, ..q }));
    }
    let unshadowed = &all[600..900];
    assert!(gpu_coverage(gpu, &blockers.pack(), unshadowed).iter().all(|c| *c == Coverage::Lit));
    compare_coverage(gpu, "several lights", &blockers, &all, 0.002);
    compare_masks(gpu, "several lights", &blockers, &all, 5, [1e-4, 1e-2]);
}

/// The result is the same to the bit, however many bindings hold the words.
fn pages(gpu: &Gpu) {
    let mesh = Mesh::bumpy(Vec3::new(0.0, 0.9, 0.0), 0.8).floor(0.0, 2.5);
    let light = light([1.5, 5.0, 0.8], 5.0);
    let blockers = ShadowMapBlockers::new(vec![mesh.map(light, 256, 4)]);
    let (packed, mut random) = (blockers.pack(), Random::new(45));
    let receivers = mesh.receivers(&mut random, light, 1500);
    let questions = questions(&mut random, &receivers, light, 5, false);
    let want = gpu_coverage(gpu, &packed, &questions);
    assert!([Coverage::Lit, Coverage::Partial].iter().all(|kind| want.iter().filter(|c| *c == kind).count() > 20));
    let bytes = size_of_val(packed.words()) as u64;
    for (most, count) in [(bytes - 4, 2), (bytes / 3, 4)] {
        let pages = GpuPages::of(bytes, most);
        assert!(pages.count() >= count, "{}", pages.count());
        assert!(gpu_coverage_in(pages, gpu, &packed, &questions) == want, "{} pages", pages.count());
    }
}

fn far_from_the_origin(gpu: &Gpu) {
    let by = Vec3::new(1e4, -3e3, 7e3);
    let mesh = Mesh::bumpy(Vec3::new(0.0, 0.9, 0.0), 0.8).floor(0.0, 2.5).moved(by);
    let near = light([1.5, 5.0, 0.8], 2.0);
    let light = Sphere { center: near.center + by, ..near };
    let blockers = ShadowMapBlockers::new(vec![mesh.map(light, 512, 3)]);
    let mut random = Random::new(50);
    let receivers = mesh.receivers(&mut random, light, 3000);
    let questions = questions(&mut random, &receivers, light, 5, false);
    compare_coverage(gpu, "moved by 1e4", &blockers, &questions, 0.005);
    compare_masks(gpu, "moved by 1e4", &blockers, &questions, 5, [1e-4, 1e-2]);
}

fn tiny_lights(gpu: &Gpu) {
    let mesh = Mesh::bumpy(Vec3::new(0.0, 0.9, 0.0), 0.8).floor(0.0, 2.5);
    let light = light([1.5, 5.0, 0.8], 0.1);
    let blockers = ShadowMapBlockers::new(vec![mesh.map(light, 1024, 3)]);
    let mut random = Random::new(60);
    let receivers = mesh.receivers(&mut random, light, 40_000);
    let questions = questions(&mut random, &receivers, light, 5, false);
    compare_coverage(gpu, "0.1°", &blockers, &questions, 0.005);
    // The light is 1/600 of its distance wide, and f32 resolves 1e-7 of the distance. Blockers as near to the light as its width
    // magnify this error of the visible fraction.
    compare_masks(gpu, "0.1°", &blockers, &questions, 5, [5e-4, 2e-2]);
}

fn own_face(gpu: &Gpu) {
    let mesh = Mesh::bumpy(Vec3::new(0.0, 0.9, 0.0), 0.8);
    let light = light([3.0, 3.0, 0.8], 6.0);
    let blockers = ShadowMapBlockers::new(vec![mesh.map(light, 256, 3)]).with_casters(vec![true, false]);
    let mut random = Random::new(70);
    // Receivers on the mesh itself: their shading normals face the light, their faces see a part of it or nothing.
    let mut receivers = mesh.receivers(&mut random, light, 4000);
    receivers.retain(|at| {
        let cone = Cone::of_sphere(at.position, light);
        at.face != at.normal && at.face.dot(cone.axis) < cone.sin_sq().sqrt()
    });
    let mut others = mesh.receivers(&mut random, light, 200);
    others.iter_mut().for_each(|at| at.object = FLOOR);
    let count = receivers.len();
    receivers.extend(others);
    let questions = questions(&mut random, &receivers, light, 5, false);
    let classes = rust_coverage(&blockers, &questions[..count]);
    assert!(classes.iter().filter(|c| **c == Coverage::Partial).count() > 20 && classes.contains(&Coverage::Dark));
    compare_coverage(gpu, "own face", &blockers, &questions, 0.002);
    compare_masks(gpu, "own face", &blockers, &questions, 5, [1e-4, 1e-2]);
    // The same mesh left to other blockers: its own receivers see all of the light; those on the floor see the same as before.
    let left = blockers.leaving(vec![true]);
    assert!(rust_coverage(&left, &questions[..count]).iter().all(|coverage| *coverage == Coverage::Lit));
    assert!(rust_coverage(&left, &questions[count..]).contains(&Coverage::Partial));
    compare_coverage(gpu, "left to others", &left, &questions, 0.002);
    compare_masks(gpu, "left to others", &left, &questions, 5, [1e-4, 1e-2]);
}
