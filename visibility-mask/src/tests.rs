//! Masks, windows and node moments against brute force in f64.

use crate::moments::{Discs, Moments, Part, Pyramid, block};
use crate::row::{self, WIDTH};
use crate::*;
use core::f64::consts::PI;
use fearless_simd::{Level, dispatch};
use glam::{DVec3, Vec2, Vec3};
use lobe_core::oracle::Random;
use lobe_core::{Cone, Lobe};

fn cone(half_angle: f64, axis: Vec3) -> Cone {
    Cone { axis, one_minus_cos: (2.0 * (0.5 * half_angle).sin().powi(2)) as f32, distance: f32::INFINITY }
}

fn mask(square: &UnitSquare, depth: u32, normal: Vec3) -> Mask {
    let mut mask = Mask::default();
    mask.reset(square, depth, normal);
    mask
}

/// The emitting part of a row, in cells, from the definition.
fn emission(mask: &Mask, j: usize, normal: Vec3) -> Option<(f64, f64)> {
    let square = mask.square();
    let y = f64::from(mask.row_y(j));
    let n = square.local(normal).as_dvec3();
    let half_sq = f64::from(square.disc).powi(2) - y * y;
    if half_sq <= 0.0 {
        return None;
    }
    let (mut from, mut to) = (-half_sq.sqrt(), half_sq.sqrt());
    let rest = n.y * y + n.z;
    if n.x > 0.0 {
        from = from.max(-rest / n.x);
    } else if n.x < 0.0 {
        to = to.min(-rest / n.x);
    } else if rest <= 0.0 {
        return None;
    }
    let cells = |x: f64| {
        ((x - f64::from(square.center.x) + f64::from(square.half.x)) / f64::from(mask.cell().x))
            .clamp(0.0, mask.side() as f64)
    };
    let (from, to) = (cells(from), cells(to));
    (from < to).then_some((from, to))
}

/// Rounding errors of f32, in cells: plane coordinates are differences, and a horizon along the rows is ill-conditioned.
fn rounding(mask: &Mask, normal: Vec3) -> f64 {
    let square = mask.square();
    let n = square.local(normal);
    let plane = 4e-7 * square.center.abs().max_element() + 3e-7 * (1.0 + square.disc) / n.x.abs().max(1e-9);
    f64::from(plane / mask.cell().x)
}

/// Length of `[from, to]` outside of all spans.
fn open_length((from, to): (f64, f64), spans: &[(f64, f64)]) -> f64 {
    let mut sorted: Vec<_> = spans.iter().filter(|s| s.0 < s.1).map(|s| (s.0.max(from), s.1.min(to))).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut end, mut open) = (from, 0.0);
    for (a, b) in sorted {
        if b > a {
            open += (a - end).max(0.0);
            end = f64::max(end, b);
        }
    }
    open + (to - end).max(0.0)
}

/// Lit cells of one row.
fn lit_row(mask: &Mask, j: usize) -> f64 {
    f64::from(row::count(&mask.lit(j))) * sample(mask)
}

/// A sample in cells.
fn sample(mask: &Mask) -> f64 {
    mask.side() as f64 / WIDTH as f64
}

/// A plane coordinate in cells from the window's left edge.
fn in_cells(mask: &Mask, x: f32) -> f64 {
    (f64::from(x) - f64::from(mask.square().center.x) + f64::from(mask.square().half.x)) / f64::from(mask.cell().x)
}

fn random_window(random: &mut Random) -> (UnitSquare, Vec3) {
    let theta = random.log_uniform(1e-4, 1.4);
    let axis = random.axis();
    let beta = if random.bits().is_multiple_of(2) { 0.3 } else { 0.5 * PI - random.between(-theta, theta) };
    let normal = random.axis_at(axis, beta).as_vec3().normalize();
    let mut square = UnitSquare::facing(&cone(theta, axis.as_vec3().normalize()), random.axis().as_vec3());
    if random.bits().is_multiple_of(3) {
        square.half *= Vec2::new(random.log_uniform(0.01, 1.0) as f32, random.log_uniform(0.01, 1.0) as f32);
        let room = square.disc - square.half;
        square.center = Vec2::new(random.between(-1.0, 1.0) as f32, random.between(-1.0, 1.0) as f32) * room;
    }
    (square, normal)
}

#[test]
fn emission_is_the_disc_above_the_horizon() {
    let mut random = Random::new(1);
    for _ in 0..2000 {
        let (square, normal) = random_window(&mut random);
        let mask = mask(&square, 1 + (random.bits() % 6) as u32, normal);
        for j in 0..mask.side() {
            let want = emission(&mask, j, normal).map_or(0.0, |(a, b)| b - a);
            let slack = 1.001 * sample(&mask) + rounding(&mask, normal);
            assert!((lit_row(&mask, j) - want).abs() < slack, "row {j}: {} {want} {square:?}", lit_row(&mask, j));
        }
    }
}

#[test]
fn emitting_area_is_the_discs() {
    for depth in 4..=6 {
        for theta in [1e-4, 0.02, 0.4, 1.0, 1.4] {
            let square = UnitSquare::facing(&cone(theta, Vec3::Z), Vec3::X);
            let cells = (1_u32 << depth) as f64;
            // Rows sample the disc's height: half-integer midpoint rule of a half-ellipse, error ∝ N^(-3/2).
            // Along the rows 256 samples, shifted from row to row.
            let rule = 0.6 * cells.powf(-1.5) + 0.5 / WIDTH as f64;
            let whole = f64::from(mask(&square, depth, Vec3::Z).areas().0) / (cells * cells);
            assert!((whole / (0.25 * PI) - 1.0).abs() < rule, "θ {theta} depth {depth}: {whole}");
            // The horizon through the centre, across the rows and along them.
            for normal in [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y] {
                let half = f64::from(mask(&square, depth, normal).areas().0) / (cells * cells);
                assert!((half / (0.125 * PI) - 1.0).abs() < rule, "θ {theta} depth {depth} {normal}: {half}");
            }
            assert_eq!(mask(&square, depth, Vec3::NEG_Z).areas().0, 0.0);
        }
    }
}

#[test]
fn lit_is_emitting_without_the_union_of_spans() {
    let mut random = Random::new(2);
    let mut worst = 0.0_f64;
    for case in 0..4000 {
        let (square, normal) = random_window(&mut random);
        let depth = 1 + (random.bits() % 6) as u32;
        let mut mask = mask(&square, depth, normal);
        let j = (random.bits() % mask.side() as u64) as usize;
        let (low, high) = (square.center.x - square.half.x, square.center.x + square.half.x);
        let cell = mask.cell().x;
        let mut spans: Vec<(f32, f32)> = Vec::new();
        for _ in 0..random.bits() % 6 {
            let a = random.between(f64::from(low - 0.2 * square.half.x), f64::from(high)) as f32;
            let b = a + cell * random.log_uniform(0.001, 40.0) as f32;
            spans.push((a, b));
        }
        match case % 7 {
            0 => spans.push((f32::NEG_INFINITY, low + 0.37 * square.half.x)),
            1 => spans.push((low + 1.37 * square.half.x, f32::INFINITY)),
            2 => spans.extend(spans.last().map(|s| (s.1, s.1 + 3.0 * cell))),
            3 => spans.push((low, low + 3.0 * cell)),
            4 => spans.push((f32::NAN, high)),
            5 => spans.push((high, low)),
            _ => spans.push((low, f32::NAN)),
        }
        for s in &spans {
            mask.block_span(j, s.0, s.1);
        }
        let valid: Vec<_> =
            spans.iter().filter(|s| s.0 < s.1).map(|s| (in_cells(&mask, s.0), in_cells(&mask, s.1))).collect();
        let want = emission(&mask, j, normal).map_or(0.0, |e| open_length(e, &valid));
        let error = (lit_row(&mask, j) - want).abs();
        // Half a sample at either end of a span and of the emitting part.
        let slack = (valid.len() as f64 + 1.001) * sample(&mask) + rounding(&mask, normal);
        worst = worst.max(error);
        assert!(error < slack, "case {case}: {error} {spans:?} {square:?}");
        // Blocking more never opens a sample; all other rows stay the same.
        let before = lit_row(&mask, j);
        mask.block_span(j, low, low + 1.3 * cell);
        assert!(lit_row(&mask, j) <= before);
        mask.block_span(j, f32::NEG_INFINITY, f32::INFINITY);
        assert_eq!(lit_row(&mask, j), 0.0);
    }
    println!("worst row error {worst:.4} cells");
}

#[test]
fn spans_fuse_as_their_union_in_any_order() {
    let mut random = Random::new(4);
    for _ in 0..3000 {
        let (square, normal) = random_window(&mut random);
        let mut spans: Vec<_> = (0..6)
            .map(|_| {
                let a = square.center.x + random.between(-1.1, 1.0) as f32 * square.half.x;
                (a, a + random.log_uniform(0.001, 2.0) as f32 * square.half.x)
            })
            .collect();
        let fill = |spans: &[(f32, f32)]| {
            let mut mask = mask(&square, 5, normal);
            spans.iter().for_each(|s| mask.block_span(7, s.0, s.1));
            mask.lit(7)
        };
        let first = fill(&spans);
        spans.reverse();
        assert_eq!(first, fill(&spans));
        spans.swap(0, 3);
        // Blocking twice equals blocking once.
        spans.push(spans[1]);
        assert_eq!(first, fill(&spans));
    }
}

/// The position of an edge across many rows is known to a small part of a sample, since the rows' samples are shifted.
#[test]
fn shifted_samples_add_up() {
    let square = UnitSquare { half: Vec2::ONE, disc: 100.0, ..UnitSquare::default() };
    for depth in 4..=6 {
        let mut worst = 0.0_f64;
        for k in 0..500 {
            let edge = -0.5 + 0.001_37 * k as f32;
            let mut mask = mask(&square, depth, Vec3::Z);
            let side = mask.side();
            (0..side).for_each(|j| mask.block_span(j, -2.0, edge));
            let want = f64::from(1.0 - edge) * 0.5;
            let lit = f64::from(mask.areas().1) / (side * side) as f64;
            worst = worst.max((lit - want).abs() * WIDTH as f64);
        }
        // The golden section's discrepancy: about 1/N.
        println!("depth {depth}: {worst:.4} samples");
        assert!(worst < 1.6 / f64::from(1u32 << depth), "depth {depth}: {worst}");
    }
}

#[test]
fn what_is_dark_is_found_by_rows_and_by_bounds() {
    let mut random = Random::new(29);
    for case in 0..400 {
        let mut mask = Mask::default();
        mask.set_coarse(case % 2 == 0);
        mask.reset(&UnitSquare::facing(&cone(0.1, Vec3::Y), Vec3::X), 3 + case % 4, Vec3::Y);
        let most = [0.01, 1.0, 1.9, 2.1][(case / 4 % 4) as usize] * f64::from(mask.square().half.x);
        for j in 0..mask.side() {
            let from = random.between(-1.0, 0.3) * f64::from(mask.square().half.x);
            mask.block_span(j, from as f32, (from + most) as f32);
            if random.uniform() < 0.5 {
                mask.block_span(j, f32::NEG_INFINITY, f32::INFINITY);
            }
        }
        let width = mask.width() as u32;
        let lit = |j: usize, k: u32| mask.lit(j).0[k as usize / 64] >> (k % 64) & 1 != 0;
        let rows: Vec<usize> = (0..mask.side()).filter(|j| (0..width).any(|k| lit(*j, k))).collect();
        let samples: Vec<u32> = (0..width).filter(|k| rows.iter().any(|j| lit(*j, *k))).collect();
        dispatch!(Level::new(), simd => {
            let bounds = mask.lit_bounds(simd);
            assert_eq!(bounds.is_empty(), rows.is_empty(), "case {case}");
            assert_eq!(mask.is_dark(), rows.is_empty(), "case {case}");
            if let (Some(first), Some(last), [left, .., right]) = (rows.first(), rows.last(), &samples[..]) {
                let want = LitBounds { rows: [*first as u32, *last as u32 + 1], samples: [*left, right + 1] };
                assert_eq!(bounds, want, "case {case}");
            }
            for _ in 0..20 {
                let [a, b] = [0, 0].map(|_| (random.uniform() * f64::from(width + 1)) as u32);
                let (from, to) = (a.min(b), a.max(b));
                let dark = |j: usize| (from..to).all(|k| !lit(j, k));
                let base = (random.uniform() * (mask.side() / 8) as f64) as usize * 8;
                let bits = mask.rows_lit_between(simd, base, from, to);
                assert!((0..8).all(|k| dark(base + k) == (bits >> k & 1 == 0)), "case {case}");
            }
        });
    }
}

/// An edge along a row blocks as many samples as the part of the row that it covers, to an eighth; two edges in one row from either
/// side combine correctly.
#[test]
fn edges_along_a_row_are_taken_by_area() {
    let square = UnitSquare { half: Vec2::ONE, disc: 100.0, ..UnitSquare::default() };
    let lit = |below: f32, above: f32, right: f32| {
        let mut mask = mask(&square, 5, Vec3::Z);
        let (y, cell) = (mask.row_y(9), mask.cell().y);
        let height = |share: f32| y + (share - 0.5) * cell;
        mask.block_area(9, |y| if y < height(below) { (-2.0, 2.0) } else { (0.0, 0.0) });
        mask.block_area(9, |y| if y > height(above) { (-2.0, right) } else { (f32::NAN, 0.0) });
        lit_row(&mask, 9) / 32.0
    };
    for k in 0..=100 {
        let below = k as f32 / 100.0;
        assert!((lit(below, 1.0, 2.0) - f64::from(1.0 - below)).abs() < 0.0626);
        assert!((lit(below, 0.5, 2.0) - f64::from(0.5 - below).max(0.0)).abs() < 0.0626);
        let quarter = f64::from(1.0 - below) - 0.25 * f64::from(0.5_f32.min(1.0 - below));
        assert!((lit(below, 0.5, -0.5) - quarter).abs() < 0.07, "{below}");
    }
}

/// Exact moments of the samples as rectangles as high as a row, around the square's axis.
fn moments_of(mask: &Mask, part: Part, x0: usize, y0: usize, size: usize) -> [f64; 4] {
    let (square, cell) = (mask.square(), mask.cell().as_dvec2());
    let width = WIDTH / mask.side();
    let wide = cell.x / width as f64;
    let mut m = [0.0; 4];
    for j in y0..y0 + size {
        let row = match part {
            Part::Emitting => row::span(mask.emitting(j).0, mask.emitting(j).1),
            Part::Lit => mask.lit(j),
        };
        for k in (x0 * width..(x0 + size) * width).filter(|k| row.0[k / 64] >> (k % 64) & 1 == 1) {
            const N: usize = 4;
            for v in 0..N {
                let left = f64::from(square.center.x) - f64::from(square.half.x);
                let x = left + wide * (k as f64 + 0.5);
                let y = f64::from(mask.row_y(j)) + cell.y * ((v as f64 + 0.5) / N as f64 - 0.5);
                let s = x * x + y * y;
                let area = cell.y * wide / N as f64;
                let q = (1.0 + s).sqrt().recip();
                let omega = area * q * q * q;
                m[0] += omega;
                m[1] += omega * q * x;
                m[2] += omega * q * y;
                m[3] += omega * s * q * q / (1.0 + q);
            }
        }
    }
    m
}

fn spread_of(m: [f64; 4]) -> f64 {
    let z = m[0] - m[3];
    let aside = m[1] * m[1] + m[2] * m[2];
    ((2.0 * m[0] - m[3]) * m[3] - aside) / (m[0] * (m[0] + (aside + z * z).sqrt()))
}

fn compare(got: Moments, want: [f64; 4], cell: f32) -> Option<[f64; 3]> {
    if want[0] <= 0.0 {
        assert!(got.omega <= 0.0);
        return None;
    }
    let lobe = got.lobe(cell);
    let mean = DVec3::new(want[1], want[2], want[0] - want[3]);
    let spread = spread_of(want).max(f64::from(cell).powi(2) / 24.0);
    let axis = lobe.axis.as_dvec3().normalize();
    Some([
        (f64::from(got.omega) / want[0] - 1.0).abs(),
        // Error of the mean direction in standard deviations of the node.
        (axis - mean.normalize()).length() / (2.0 * spread).sqrt(),
        (f64::from(lobe.spread) / spread - 1.0).abs(),
    ])
}

#[test]
fn node_moments_are_those_of_the_cells() {
    let mut random = Random::new(5);
    let mut discs = Discs::default();
    for degrees in [0.01, 1.0, 25.0, 60.0, 85.0_f64] {
        for zoom in [1.0_f32, 0.2, 0.01] {
            let (mut worst, mut root) = ([0.0_f64; 3], [0.0_f64; 3]);
            for case in 0..12 {
                let axis = random.axis();
                let normal =
                    if case % 3 == 0 { random.axis_at(axis, (90.0 - 0.5 * degrees).to_radians()) } else { axis };
                let mut square = UnitSquare::facing(
                    &cone(degrees.to_radians(), axis.as_vec3().normalize()),
                    random.axis().as_vec3(),
                );
                square.half *= zoom;
                square.center = Vec2::from_angle(case as f32) * (square.disc - square.half) * 0.6;
                let depth = 4 + case % 3;
                let mut mask = mask(&square, depth, normal.as_vec3().normalize());
                for j in 0..mask.side() {
                    let a = square.center.x + square.half.x * (random.between(-1.0, 0.0) as f32);
                    mask.block_span(j, a, a + square.half.x * random.uniform() as f32);
                }
                let (mut emitting, mut lit) = (Pyramid::default(), Pyramid::default());
                emitting.build_emitting(&mask, &mut discs);
                lit.build_lit(&mask, &emitting);
                for (part, pyramid) in [(Part::Emitting, &emitting), (Part::Lit, &lit)] {
                    for level in 0..=depth as usize {
                        let size = mask.side() >> level;
                        for y in 0..1 << level {
                            for x in 0..1 << level {
                                let got = pyramid
                                    .get(level, x, y)
                                    .unwrap_or_else(|| block(&mask, part, x * size, y * size, size));
                                let want = moments_of(&mask, part, x * size, y * size, size);
                                let Some(errors) = compare(got, want, mask.cell().min_element()) else { continue };
                                for k in 0..3 {
                                    worst[k] = worst[k].max(errors[k]);
                                    if level == 0 {
                                        root[k] = root[k].max(errors[k]);
                                    }
                                }
                            }
                        }
                    }
                }
            }
            println!(
                "{degrees:5}° zoom {zoom}: solid angle {:.1e}, axis {:.1e} widths, 1−R {:.1e}; root {:.1e} {:.1e} {:.1e}",
                worst[0], worst[1], worst[2], root[0], root[1], root[2]
            );
        }
    }
}

#[test]
fn windows_are_finite_for_all_lobes() {
    let mut random = Random::new(6);
    for case in 0..20_000 {
        let axis = random.axis();
        let theta = [0.0, 1e-9, 1e-4, 0.3, 1.2, 0.5 * PI][case % 6];
        let across = [Vec3::ZERO, axis.as_vec3(), -axis.as_vec3(), random.axis().as_vec3() * 1e-12][case % 4];
        let square = UnitSquare::facing(&cone(theta, axis.as_vec3().normalize()), across);
        assert!((square.right.length() - 1.0).abs() < 1e-5 && square.right.dot(square.axis).abs() < 1e-5);
        assert!((square.right.cross(square.up) - square.axis).length() < 1e-5);
        let lobe_axis = [axis, -axis, random.axis(), random.axis_near(axis)][case % 4].as_vec3().normalize();
        let e = [0.0, 1e-6, 1.0, 1e3, 1e7, f32::INFINITY][(random.bits() % 6) as usize];
        let normal = [axis, -axis, random.axis()][case % 3].as_vec3().normalize();
        let zoomed = square.above(normal).zoomed(&Lobe::with_flux(lobe_axis, e, Vec3::ONE), normal, 3.5);
        assert!(zoomed.half.min_element() > 0.0 || square.disc == 0.0, "empty window for e {e}: {zoomed:?}");
        assert!(zoomed.center.is_finite() && zoomed.half.is_finite());
        assert!((zoomed.center.abs() + zoomed.half).max_element() <= 1.0001 * square.disc, "{zoomed:?}");
    }
}
