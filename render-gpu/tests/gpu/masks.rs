//! Squares, edges, masks and their visible fractions in WGSL against the same in Rust.

use crate::call::{call, call_groups, trial};
use glam::Vec3;
use libtest_mimic::Trial;
use lobe_core::oracle::Random;
use lobe_core::wgsl::{SPECIAL, join};
use lobe_core::{Cone, Lobe, PackedLobe, Receiver};
use render_gpu::Gpu;
use shading::{Accuracy, Coverage, LightCoverage, LightId, LightVisibility, Visibility, VisibilityQuery};
use visibility_mask::{Blockers, Edges, Fineness, LookAgain, Mask, MaskVisibility, UnitSquare, hooks, wgsl};

pub(crate) fn trials(gpu: Option<&Gpu>) -> Vec<Trial> {
    vec![
        trial("squares", gpu, squares),
        trial("edges", gpu, edges),
        trial("fine_masks_and_shares", gpu, |gpu| masks(gpu, false)),
        trial("coarse_masks_and_shares", gpu, |gpu| masks(gpu, true)),
        trial("visibility_of_one_edge", gpu, visibility),
        trial("visibility_of_extremes", gpu, extremes),
    ]
}

/// Mean and largest of some differences.
#[derive(Clone, Copy, Debug, Default)]
struct Spread {
    count: usize,
    sum: f64,
    worst: f64,
}

impl Spread {
    fn add(&mut self, got: f32, want: f32) {
        let difference = f64::from((got - want).abs());
        assert!(difference.is_finite(), "{got}, not {want}");
        self.count += 1;
        self.sum += difference;
        self.worst = self.worst.max(difference);
    }

    fn check(&self, what: &str, mean: f64, worst: f64) {
        let found = self.sum / self.count.max(1) as f64;
        println!("{what}: {} values, mean {found:.1e}, worst {:.1e}", self.count, self.worst);
        assert!(self.count > 0 && found <= mean && self.worst <= worst, "{what}: mean {found:.1e}, {:.1e}", self.worst);
    }
}

/// A light, a receiver that sees at least its rim, and a lobe that covers at least a little of it.
struct Case {
    light: Cone,
    at: Receiver,
    lobe: Lobe,
}

impl Case {
    /// Every third lobe is Lambert's; every third light may be cut by the horizon.
    fn new(number: usize, random: &mut Random) -> Self {
        let theta = random.log_uniform(0.003, 1.2);
        let axis = random.axis();
        let quarter = core::f64::consts::FRAC_PI_2;
        let end = if number.is_multiple_of(4) { quarter + 0.7 * theta } else { (quarter - theta).max(0.0) };
        let tilt = random.between(0.0, end);
        let normal = random.axis_at(axis, tilt).as_vec3().normalize();
        let at = Receiver::on_surface(Vec3::ZERO, normal, normal);
        let light = Cone {
            axis: axis.as_vec3().normalize(),
            one_minus_cos: (2.0 * (0.5 * theta).sin().powi(2)) as f32,
            distance: 3.0,
        };
        let exponent = random.log_uniform(0.5, 1e5);
        let aside = random.between(0.0, (theta + 2.0 / f64::sqrt(exponent)).min(1.5));
        let glossy = Lobe::new(random.axis_at(axis, aside).as_vec3().normalize(), exponent as f32, Vec3::ONE);
        let lobe = match number % 3 {
            0 => Lobe::new(normal, 1.0, Vec3::ONE),
            1 => glossy,
            _ => glossy.times_cosine(),
        };
        Self { light, at, lobe }
    }

    /// Axis, 1 − cos θ and distance; normal; axis, exponent and cosine of the lobe.
    fn row(&self) -> [f32; 13] {
        let (a, n, f) = (self.light.axis, self.at.normal, self.lobe);
        let [e, d] = [self.light.one_minus_cos, self.light.distance];
        let kind = PackedLobe::from(f).kind;
        [a.x, a.y, a.z, e, d, n.x, n.y, n.z, f.axis.x, f.axis.y, f.axis.z, f.exponent, kind]
    }
}

/// Reads the row of [`Case::row`].
const CASE: &str = "
    let light = Cone(vec3f(x(0u), x(1u), x(2u)), x(3u), x(4u));
    var at: Receiver;
    at.normal = vec3f(x(5u), x(6u), x(7u));
    let lobe = Lobe(vec3f(x(8u), x(9u), x(10u)), x(11u), vec3f(1.0), x(12u));";

/// Directions agree to a few roundings, windows to as many relative to the light's disc.
fn squares(gpu: &Gpu) {
    let mut random = Random::new(71);
    let cases: Vec<_> = (0..4000).map(|number| Case::new(number, &mut random)).collect();
    let across: Vec<_> = (0..cases.len())
        .map(|number| if number % 50 == 0 { Vec3::ZERO } else { random.axis().as_vec3() * 3.0 })
        .collect();
    let rows: Vec<f32> = (cases.iter().zip(&across))
        .flat_map(|(case, across)| case.row().into_iter().chain([across.x, across.y, across.z]))
        .collect();
    let body = format!(
        "{CASE}
        let square = square_facing(light, vec3f(x(13u), x(14u), x(15u)));
        let window = square_zoomed(square_above(square, at.normal), lobe, at.normal, 3.6);
        let back = square_local(square, square_world(square, at.normal));
        for (var k = 0u; k < 3u; k++) {{
            y(k, square.right[k]);
            y(3u + k, square.up[k]);
            y(9u + k, back[k]);
        }}
        y(6u, window.center.x);
        y(7u, window.center.y);
        y(8u, window.half.x);
        y(12u, window.half.y);"
    );
    let got = call(gpu, &join(&[&wgsl::ROUND, &SPECIAL]), &body, &rows, 16, 13);
    let (mut turns, mut windows) = (Spread::default(), Spread::default());
    for ((case, across), got) in cases.iter().zip(&across).zip(got.chunks(13)) {
        let square = UnitSquare::facing(&case.light, *across);
        let window = square.above(case.at.normal).zoomed(&case.lobe, case.at.normal, 3.6);
        let back = square.local(square.world(case.at.normal));
        for k in 0..3 {
            turns.add(got[k], square.right[k]);
            turns.add(got[3 + k], square.up[k]);
            turns.add(got[9 + k], back[k]);
        }
        let UnitSquare { center, half, .. } = window;
        for (got, want) in got[6..9].iter().chain(&got[12..]).zip([center.x, center.y, half.x, half.y]) {
            windows.add(got / square.disc, want / square.disc);
        }
    }
    turns.check("turns", 1e-7, 3e-6);
    windows.check("windows", 1e-6, 1e-4);
}

/// Two circles and an edge; rounding decides if they nearly cancel.
fn edges(gpu: &Gpu) {
    let mut random = Random::new(72);
    let rows: Vec<[f32; 17]> = (0..4000)
        .map(|_| {
            let mut row = [0.0; 17];
            for v in row.chunks_mut(5).take(3) {
                let axis = random.axis().as_vec3();
                v[..3].copy_from_slice(&axis.to_array());
                v[3..].copy_from_slice(&[random.log_uniform(0.1, 10.0) as f32, random.log_uniform(0.1, 10.0) as f32]);
            }
            row[15..].copy_from_slice(&[random.uniform() as f32, random.uniform() as f32]);
            row
        })
        .collect();
    let body = "
        let basis = edges_frame(vec3f(x(0u), x(1u), x(2u)));
        var sum = EDGES_NOTHING + edges_add_circle(basis, vec3f(x(5u), x(6u), x(7u)) * x(8u), x(9u));
        sum += edges_add_circle(basis, vec3f(x(10u), x(11u), x(12u)) * x(13u), x(14u));
        let straight = edges_add(basis, vec3f(x(15u), x(16u), x(4u)), x(3u));
        let across = edges_across(basis, sum + straight.xy, straight.zw);
        y(0u, across.x);
        y(1u, across.y);
        y(2u, across.z);";
    let got = call(gpu, &join(&[&wgsl::EDGES]), body, rows.as_flattened(), 17, 3);
    let mut spread = Spread::default();
    for (row, got) in rows.iter().zip(got.chunks(3)) {
        let axis = Vec3::from_slice(row);
        let mut edges = Edges::new(&Cone { axis, one_minus_cos: 0.1, distance: 1.0 });
        edges.add_circle(Vec3::from_slice(&row[5..]) * row[8], row[9]);
        edges.add_circle(Vec3::from_slice(&row[10..]) * row[13], row[14]);
        edges.add(Vec3::new(row[15], row[16], row[4]), row[3]);
        let want = edges.across();
        for k in 0..3 {
            spread.add(got[k], want[k]);
        }
    }
    spread.check("edges", 1e-6, 1e-3);
}

/// All pieces of masks, without the kernel.
fn text(header: &str) -> String {
    join(&[&wgsl::ROUND, &wgsl::ALIKE]) + "const LOOKS_AGAIN = false;\nconst BLOCKERS_ARE_SEVERAL = false;\n" + header
}

/// Bits of a mask with spans along rows and shapes along heights, then the visible fraction. Positions of samples are rounded to
/// 2⁻¹⁶ of a sample at most: one bit in some ten thousand ends may differ.
fn masks(gpu: &Gpu, coarse: bool) {
    const HOOKS: &str = "
        struct Frame { look_again: u32 }
        var<private> frame: Frame;
        const NARROW_GRID = vec2u(1u);
        const IS_NARROW_FINER = false;
        fn blockers_edges(lane: u32, tile: u32, at: Receiver, light: Cone, window: Cone) -> vec4f { return vec4f(0.0); }
        fn blockers_splat(lane: u32, tile: u32, at: Receiver, light: Cone, mask: Mask) {}";
    const BODY: &str = "
        let square = UnitSquare(
            vec3f(x(13u), x(14u), x(15u)), vec3f(x(16u), x(17u), x(18u)), light.axis, vec2f(x(19u), x(20u)),
            vec2f(x(21u), x(29u)), x(22u),
        );
        let mask = mask_reset(square, lane, at.normal);
        // Edges through the window: one by spans, one by heights.
        mask_block_span(mask, lane, -1e30, x(23u) + x(24u) * mask_row_y(mask, lane));
        for (var k = 0u; k < 8u; k++) {
            let height = mask_row_y(mask, lane) + mask_cell(mask).y * row_height(k);
            mask_block_line(lane, k, mask_sample(mask, x(25u) + x(26u) * height), WIDTH);
        }
        // One more edge by heights, four samples at once.
        for (var first = 0u; first < 8u; first += 4u) {
            let height = mask_row_y(mask, lane) + mask_cell(mask).y * mask_heights(lane, first);
            let position = (x(27u) + x(28u) * height - mask.left) * mask.scale;
            mask_block_lines(first, vec4u(0u), row_indices(position));
        }
        if (lane < SIDE) {
            for (var k = 0u; k < WIDTH / 16u; k++) {
                let word = row_samples(lit, k / 2u);
                y(WIDTH / 16u * lane + k, f32((word >> (16u * (k & 1u))) & 0xffffu));
            }
        }
        let seen = fraction_of(fraction_sums(lane, mask, mask.square, at, lobe));
        if (lane == 0u) {
            y(WIDTH / 16u * SIDE, seen);
        }";
    // A coarse row has two words.
    let words = if coarse { 4 } else { 16 };
    let (mut bits, mut differing) = (0, 0);
    let mut forms = [Spread::default(); 4];
    for depth in 3..=6 {
        let mut random = Random::new(73 + u64::from(depth));
        let mut rows = Vec::new();
        let mut wants = Vec::new();
        for number in 0..800 {
            let case = Case::new(number, &mut random);
            let whole = UnitSquare::facing(&case.light, random.axis().as_vec3());
            let zooms = number % 5 > 1;
            let square =
                if zooms { whole.above(case.at.normal).zoomed(&case.lobe, case.at.normal, 3.6) } else { whole };
            let mut at = |center: f32| center + square.half.x * random.between(-1.0, 1.0) as f32;
            let ends = [0; 3].map(|_| at(square.center.x));
            let slopes = [0.7, 20.0, 20.0].map(|most| random.between(-most, most) as f32);
            let [a, b, c] = core::array::from_fn(|k| ends[k] - slopes[k] * square.center.y);
            rows.extend(case.row());
            rows.extend(square.right.to_array().into_iter().chain(square.up.to_array()));
            rows.extend([square.center.x, square.center.y, square.half.x, square.disc, a, slopes[0], b, slopes[1]]);
            rows.extend([c, slopes[2], square.half.y]);
            let mut mask = hooks::mask(&square, depth, coarse, case.at.normal);
            for j in 0..mask.side() {
                mask.block_span(j, f32::NEG_INFINITY, a + slopes[0] * mask.row_y(j));
                mask.block_area(j, |y| (b + slopes[1] * y, f32::INFINITY));
                mask.block_area(j, |y| (f32::NEG_INFINITY, c + slopes[2] * y));
            }
            wants.push((case, mask));
        }
        let fineness = Fineness { coarse, ..Fineness::FINE };
        let header = wgsl::header(depth, fineness) + HOOKS + wgsl::NO_MICROFACETS;
        let body = format!("{CASE}{BODY}");
        let side = 1 << depth;
        let got = call_groups(gpu, &text(&header), &body, &rows, [30, words * side + 1]);
        for ((case, mask), got) in wants.iter().zip(got.chunks(words * side + 1)) {
            let before = differing;
            for j in 0..side {
                let halves = hooks::row(mask, j).map(|word| [0, 16, 32, 48].map(|shift| word >> shift & 0xffff));
                for (got, want) in got[words * j..][..words].iter().zip(halves.as_flattened()) {
                    differing += (*got as u64 ^ want).count_ones();
                }
            }
            bits += (16 * words * side) as u32;
            if differing == before {
                let form = match (case.lobe.exponent == 1.0, mask.square().half.min_element() < mask.square().disc) {
                    (true, _) => usize::from(mask.square().disc > 0.2),
                    (false, zoomed) => 2 + usize::from(zoomed),
                };
                forms[form].add(got[words * side], hooks::fraction_of(mask, &case.at, &case.lobe));
            }
        }
    }
    println!("{differing} of {bits} bits differ");
    // One in a hundred bits is the end of a span.
    assert!(f64::from(differing) <= 1e-5 * f64::from(bits), "{differing} of {bits} bits differ");
    // The logarithm of a weight is e times that of a cosine near 1; its error is e·2⁻²⁴, and so is the difference. e is up to 1e5
    // in windows, less if the mask covers a whole light.
    let limits =
        [("Lambert, small light", 2e-6), ("Lambert", 2e-6), ("other, whole light", 2e-6), ("other, window", 2e-5)];
    for (form, (name, mean)) in forms.iter().zip(limits) {
        assert!(form.count > 300, "{name}: {} masks are alike", form.count);
        form.check(name, mean, 1e-3);
    }
}

/// Blocks the side of a plane through the receiver that its normal points to.
#[derive(Clone, Copy)]
struct Curtain(Vec3);

impl Blockers for Curtain {
    type Scratch = ();
    fn scratch(&self) {}
    fn select(&self, _: &VisibilityQuery<'_>, _: &mut ()) -> Coverage {
        Coverage::Partial
    }
    fn edges(&self, _: &VisibilityQuery<'_>, (): &(), edges: &mut Edges) {
        edges.add(self.0, 1.5);
    }
    fn splat(&self, _: &VisibilityQuery<'_>, _: &mut (), mask: &mut Mask) {
        let n = mask.square().local(self.0);
        for j in 0..mask.side() {
            let rest = n.y * mask.row_y(j) + n.z;
            if n.x > 0.0 {
                mask.block_span(j, -rest / n.x, f32::INFINITY);
            } else {
                mask.block_span(j, f32::NEG_INFINITY, -rest / n.x);
            }
        }
    }
}

/// Runs all of [`MaskVisibility`] for a curtain's edge before each case: differences of the visible fraction, and counts of lit,
/// partly lit and dark receivers.
fn compare_visibility(gpu: &Gpu, cases: &[(Case, Vec3)], depth: u32, tolerance: f32) -> (Spread, [u32; 3]) {
    const HOOKS: &str = "
        struct Frame { look_again: u32 }
        var<private> frame: Frame;
        fn curtain() -> vec3f { return vec3f(x(13u), x(14u), x(15u)); }
        fn blockers_edges(lane: u32, tile: u32, at: Receiver, light: Cone, window: Cone) -> vec4f {
            return select(vec4f(0.0), edges_add(edges_frame_of(window), curtain(), 1.5), lane == 5u);
        }
        fn blockers_splat(lane: u32, tile: u32, at: Receiver, light: Cone, mask: Mask) {
            let n = square_local(mask.square, curtain());
            let rest = n.y * mask_row_y(mask, lane) + n.z;
            if (n.x > 0.0) {
                mask_block_span(mask, lane, -rest / n.x, 1e30);
            } else {
                mask_block_span(mask, lane, -1e30, -rest / n.x);
            }
        }";
    let body = format!(
        "{CASE}
        _ = visible_fraction(lane, 0u, at, light, x(16u), true, lobe);
        let coverage = visibility_coverage();
        for (var k = 0u; k < 2u; k++) {{
            var own = lobe;
            if (k == 1u) {{
                own = Lobe(at.normal, 1.0, vec3f(1.0), 1.0);
            }}
            let seen = visible_fraction(lane, 0u, at, light, x(16u), false, own);
            if (lane == 0u) {{
                y(1u + k, seen);
            }}
        }}
        if (lane == 0u) {{
            y(0u, f32(coverage));
        }}"
    );
    let rows: Vec<f32> = cases
        .iter()
        .flat_map(|(case, edge)| case.row().into_iter().chain(edge.to_array()).chain([tolerance]))
        .collect();
    let header = wgsl::header_of_lobes(depth, Fineness::broad(tolerance), Fineness::narrow(tolerance), false) + HOOKS;
    let got = call_groups(gpu, &text(&header), &body, &rows, [17, 3]);
    let (mut spread, mut classes) = (Spread::default(), [0; 3]);
    for ((case, edge), got) in cases.iter().zip(got.chunks(3)) {
        let strategy = MaskVisibility::new(Curtain(*edge)).look_again(LookAgain::Never);
        let mut scratch = strategy.scratch();
        let mut visit = LightVisibility::alone(&strategy, LightId(0), Accuracy { tolerance, depth }, &mut scratch);
        let look = visit.coverage(&case.at, &case.light, None);
        let coverage = look.coverage();
        let class = match coverage {
            Coverage::Lit => 0_u8,
            Coverage::Partial => 1,
            Coverage::Dark => 2,
        };
        classes[usize::from(class)] += 1;
        assert_eq!(got[0], f32::from(class), "{coverage:?}");
        if let LightCoverage::Partial(seen) = &look {
            let fraction = visit.fraction(seen, case.lobe, 1.0).x;
            assert!((0.0..=1.0).contains(&got[1]), "{}", got[1]);
            if sees_light(&case.lobe, &case.light) {
                spread.add(got[1], fraction);
            }
        }
        // The mask of the whole light stays the same.
        assert!((0.0..=1.0).contains(&got[2]));
    }
    (spread, classes)
}

/// Whether a lobe is noticeable anywhere on a light: otherwise the weights of all samples underflow.
fn sees_light(lobe: &Lobe, light: &Cone) -> bool {
    let (axis, toward) = (lobe.axis.as_dvec3(), light.axis.as_dvec3());
    let off = axis.cross(toward).length().atan2(axis.dot(toward)) - f64::from(light.tan()).atan();
    let logarithm = f64::from(lobe.exponent) * off.clamp(0.0, core::f64::consts::FRAC_PI_2).cos().ln();
    // NaN comes from a mirror, whose axis is on the light.
    logarithm.is_nan() || logarithm > -60.0
}

/// An edge between a light's centre and a place beyond its rim.
fn edge_across(light: &Cone, random: &mut Random) -> Vec3 {
    let off = random.between(-1.1, 1.1) * f64::from(light.tan()).atan();
    random.axis_at(light.axis.as_dvec3(), core::f64::consts::FRAC_PI_2 + off).as_vec3()
}

fn visibility(gpu: &Gpu) {
    for (depth, tolerance) in [(3, 0.01), (4, 0.01), (5, 0.003), (6, 0.001)] {
        let mut random = Random::new(74 + u64::from(depth));
        let cases: Vec<_> = (0..600)
            .map(|number| {
                let case = Case::new(number, &mut random);
                let edge = edge_across(&case.light, &mut random);
                (case, edge)
            })
            .collect();
        let (spread, classes) = compare_visibility(gpu, &cases, depth, tolerance);
        assert!(classes.iter().all(|count| *count > 10), "{classes:?}");
        // A bit of the smallest masks is a thousandth of the light, and more of a lobe's window.
        spread.check(&format!("visibility at depth {depth}"), 1e-5, 1e-2);
    }
}

/// The smallest and the widest lights, the broadest and the narrowest lobes, mirrors among them, give numbers in [0, 1], and the
/// same as in Rust.
fn extremes(gpu: &Gpu) {
    let cases = extreme_cases(&[1e-20, 1e-12, 1e-7, 0.5, 0.9, 0.999_999, 1.0]);
    for depth in [5, 6] {
        let (spread, classes) = compare_visibility(gpu, &cases, depth, 0.001);
        assert!(classes[1] > 100, "{classes:?}");
        spread.check(&format!("extremes at depth {depth}"), 1e-6, 1e-3);
    }
}

/// Lights of these `1 − cos θ`, lobes of all exponents.
fn extreme_cases(lights: &[f32]) -> Vec<(Case, Vec3)> {
    let mut random = Random::new(80);
    let mut cases = Vec::new();
    for &one_minus_cos in lights {
        for exponent in [0.0, 1e-3, 3.0, 1e6, 1e9, f32::INFINITY] {
            for number in 0..12 {
                let mut case = Case::new(1 + number % 2, &mut random);
                case.light.one_minus_cos = one_minus_cos;
                case.lobe.exponent = exponent;
                if number % 3 == 0 {
                    case.lobe.axis = case.light.axis;
                }
                let edge = edge_across(&case.light, &mut random);
                cases.push((case, edge));
            }
        }
    }
    cases
}
