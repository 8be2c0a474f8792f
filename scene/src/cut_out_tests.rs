//! Surfaces that alpha cuts.

use crate::cut_out::{AlphaBounds, CutOut};
use crate::{Encoding, Mesh, Texture, TextureMap, Wrap};
use core::f64::consts::PI;
use glam::{Vec2, Vec3};
use std::collections::HashSet;

/// As many as are looked at of a small mesh.
const MOST_TRIANGLES: usize = 1 << 20;

/// A disc of alpha 1 with a soft edge in the middle of an image.
fn disc(n: u32, radius: f32) -> TextureMap {
    let texel = |i: u32| {
        let (x, y) = ((i % n) as f32 + 0.5 - 0.5 * n as f32, (i / n) as f32 + 0.5 - 0.5 * n as f32);
        let alpha = (radius * n as f32 - x.hypot(y) + 0.5).clamp(0.0, 1.0);
        [255, 255, 255, (alpha * 255.0).round() as u8]
    };
    TextureMap::new(Texture::new("disc", [n, n], (0..n * n).map(texel).collect(), Encoding::Srgb))
}

fn cut_by(by: &CutOut, mesh: &mut Mesh, alphas: &[f32]) -> bool {
    let bounds = by.map.as_ref().map(|map| AlphaBounds::new(&map.texture));
    by.cut(mesh, alphas, bounds.as_ref(), MOST_TRIANGLES)
}

fn cut(map: TextureMap, mesh: &Mesh) -> Mesh {
    let mut mesh = mesh.clone();
    assert!(cut_by(&CutOut { map: Some(map), factor: 1.0, limit: 0.5 }, &mut mesh, &[]));
    mesh.validate().expect("a mesh");
    mesh
}

#[test]
fn what_is_left_has_the_area_of_what_is_opaque() {
    let quad = Mesh::quad(Vec3::ZERO, Vec3::X, Vec3::Y);
    for (n, radius, tolerance) in [(16, 0.4, 0.02), (64, 0.3, 0.002), (256, 0.45, 2e-4), (37, 0.35, 0.005)] {
        let left = cut(disc(n, radius), &quad);
        let want = 4.0 * PI * f64::from(radius).powi(2);
        println!("{n}: area {:.5} of {want:.5}, {} triangles", left.area(), left.triangles.len());
        assert!((left.area() / want - 1.0).abs() < tolerance, "{n}: {} {want}", left.area());
        // One for three texels of a small circle, for seven of a large one.
        assert!(left.triangles.len() < 10 + n as usize / 2, "{n}: {}", left.triangles.len());
        // Nothing outside, and coordinates that go with the places.
        for (p, uv) in left.positions.iter().zip(&left.uv_sets[0]) {
            assert!((Vec2::new(p.x, -p.y) * 0.5 + 0.5 - *uv).length() < 1e-5);
        }
        let used = left.triangles.iter().flatten().map(|i| left.positions[*i as usize].length());
        assert!(used.fold(0.0, f32::max) < 2.0 * radius + 1.5 / n as f32);
    }
}

#[test]
fn images_that_repeat_are_cut_as_often() {
    let quad = Mesh::quad(Vec3::ZERO, Vec3::X, Vec3::Y);
    for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
        let mut map = disc(32, 0.4);
        map.wrap = [wrap; 2];
        map.transform = glam::Affine2::from_scale_angle_translation(Vec2::splat(3.0), 0.0, Vec2::new(-1.0, 0.0));
        let discs = if wrap == Wrap::Clamp { 1.0 } else { 9.0 };
        let want = discs * 4.0 / 9.0 * PI * 0.16;
        let area = cut(map, &quad).area();
        assert!((area / want - 1.0).abs() < 0.01, "{wrap:?}: {area} {want}");
    }
}

#[test]
fn whole_and_empty_images_leave_all_and_nothing() {
    let quad = Mesh::quad(Vec3::ZERO, Vec3::X, Vec3::Y);
    let flat = |alpha| TextureMap::new(Texture::new("flat", [8, 8], vec![[0, 0, 0, alpha]; 64], Encoding::Srgb));
    let mut all = quad.clone();
    cut_by(&CutOut { map: Some(flat(255)), factor: 1.0, limit: 0.5 }, &mut all, &[]);
    assert!((all.area() - 4.0).abs() < 1e-6);
    for (map, factor) in [(Some(flat(0)), 1.0), (Some(flat(255)), 0.3), (None, 0.3)] {
        let mut none = quad.clone();
        cut_by(&CutOut { map, factor, limit: 0.5 }, &mut none, &[]);
        assert!(none.triangles.is_empty());
    }
}

#[test]
fn hostile_coordinates_end() {
    let mut quad = Mesh::quad(Vec3::ZERO, Vec3::X, Vec3::Y);
    for uv in [f32::NAN, f32::INFINITY, 1e30, -1e9, 1e-30] {
        quad.uv_sets[0][2] = Vec2::new(uv, 0.3);
        let mut mesh = quad.clone();
        cut_by(&CutOut { map: Some(disc(16, 0.4)), factor: 1.0, limit: 0.5 }, &mut mesh, &[]);
        assert!(mesh.triangles.len() <= 2 * MOST_TRIANGLES, "{uv}: {}", mesh.triangles.len());
        assert!(mesh.positions.iter().all(|p| p.is_finite()));
    }
}

#[test]
fn the_alpha_of_vertices_cuts_with_and_without_an_image() {
    // From 0 on the left to 1 on the right: the line of 0.3 is straight.
    let quad = Mesh::quad(Vec3::ZERO, Vec3::X, Vec3::Y);
    let alphas: Vec<f32> = quad.positions.iter().map(|p| 0.5 + 0.5 * p.x).collect();
    let mut plain = quad.clone();
    assert!(cut_by(&CutOut { map: None, factor: 1.0, limit: 0.3 }, &mut plain, &alphas));
    assert!((plain.area() - 4.0 * 0.7).abs() < 1e-5, "{}", plain.area());
    // An image of alpha 0.6 everywhere moves the line: 0.6·a = 0.3 at a half.
    let flat = Texture::new("flat", [8, 8], vec![[0, 0, 0, 153]; 64], Encoding::Srgb);
    let mut shown = quad;
    assert!(cut_by(&CutOut { map: Some(TextureMap::new(flat)), factor: 1.0, limit: 0.3 }, &mut shown, &alphas));
    assert!((shown.area() - 2.0).abs() < 0.02, "{}", shown.area());
}

#[test]
fn alphas_at_the_limit_are_kept() {
    let quad = Mesh::quad(Vec3::ZERO, Vec3::X, Vec3::Y);
    let flat = |alpha| TextureMap::new(Texture::new("flat", [4, 4], vec![[0, 0, 0, alpha]; 16], Encoding::Srgb));
    for (map, factor, alpha, limit, area) in [
        (Some(flat(255)), 1.0, 1.0, 1.0, 4.0),
        (Some(flat(51)), 1.0, 1.0, 0.2, 4.0),
        (None, 0.7, 0.6, 0.42, 4.0),
        (None, 0.7, 0.6, 0.43, 0.0),
        (Some(flat(255)), 1.0, 1.0, 1.5, 0.0),
        (Some(flat(0)), 0.0, 0.0, 0.0, 4.0),
    ] {
        let mut mesh = quad.clone();
        assert!(cut_by(&CutOut { map, factor, limit }, &mut mesh, &[alpha; 4]));
        assert!((mesh.area() - area).abs() < 1e-6, "{factor} {alpha} {limit}: {}", mesh.area());
    }
}

/// Edges of one triangle only.
fn rims(mesh: &Mesh) -> Vec<(u32, u32)> {
    let edges = || mesh.triangles.iter().flat_map(|[a, b, c]| [(*a, *b), (*b, *c), (*c, *a)]);
    let all: HashSet<_> = edges().collect();
    edges().filter(|(p, q)| !all.contains(&(*q, *p))).collect()
}

/// An image of this alpha at the middles of texels, in units of the image.
fn image(n: u32, alpha: impl Fn(f32, f32) -> f32) -> TextureMap {
    let at = |i: u32| (i as f32 + 0.5) / n as f32;
    let texel = |i: u32| [255, 255, 255, (alpha(at(i % n), at(i / n)).clamp(0.0, 1.0) * 255.0).round() as u8];
    TextureMap::new(Texture::new("image", [n, n], (0..n * n).map(texel).collect(), Encoding::Srgb))
}

/// Alpha between the texels.
fn alpha(map: &TextureMap, uv: Vec2) -> f32 {
    map.texture.sample(uv, [Vec2::ZERO; 2], map.wrap, false)[3]
}

/// How large a part of an image is opaque.
fn opaque(map: &TextureMap) -> f64 {
    let n = 2048;
    let at = |i: u32| (i as f32 + 0.5) / n as f32;
    let is_opaque = |k: &u32| alpha(map, Vec2::new(at(k % n), at(k / n))) >= 0.5;
    (0..n * n).filter(is_opaque).count() as f64 / f64::from(n * n)
}

#[test]
fn triangles_that_meet_keep_meeting() {
    // A grid of lace over a mesh of many triangles, in a mirrored image as well: rims are along alpha's line or the mesh's border alone.
    let wave = |x: f32, f: f32| (core::f32::consts::TAU * f * x).sin();
    let mut map = image(96, |x, y| 0.5 + 2.0 * (wave(x, 3.0) * wave(y, 3.0) + 0.25));
    let part = opaque(&map);
    let n = 5_usize;
    for mirror in [1.0_f32, -1.0] {
        map.transform = glam::Affine2::from_scale(Vec2::new(mirror, 1.0));
        map.wrap = [Wrap::Mirror; 2];
        let vertices =
            || (0..(n + 1) * (n + 1)).map(|i| Vec2::new((i % (n + 1)) as f32, (i / (n + 1)) as f32) / n as f32);
        let mut mesh = Mesh { positions: vertices().map(|v| v.extend(0.0)).collect(), ..Mesh::default() };
        mesh.uv_sets = vec![vertices().collect()];
        for cell in 0..n * n {
            let a = ((cell / n) * (n + 1) + cell % n) as u32;
            let b = a + n as u32 + 1;
            mesh.triangles.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
        }
        let left = cut(map.clone(), &mesh);
        println!("{} triangles, area {:.5} of {part:.5}", left.triangles.len(), left.area());
        assert!((left.area() / part - 1.0).abs() < 1e-3);
        assert!(left.triangles.iter().all(|t| left.face_cross(*t).z > 0.0));
        for (p, q) in rims(&left) {
            let [p, q] = [p, q].map(|i| left.positions[i as usize]);
            let is_on_border = (0..2).any(|k| p[k] == q[k] && (p[k] == 0.0 || p[k] == 1.0));
            let is_on_line = |p: Vec3| (alpha(&map, Vec2::new(mirror * p.x, p.y)) - 0.5).abs() < 0.1;
            assert!(is_on_border || is_on_line(p) && is_on_line(q), "{p} {q}");
        }
    }
}

#[test]
fn straight_outlines_need_few_triangles() {
    // A window with mullions: four panes, cut away.
    let pane = |x: f32| (0.1..0.45).contains(&x) || (0.55..0.9).contains(&x);
    let map = image(200, |x, y| if pane(x) && pane(y) { 0.0 } else { 1.0 });
    let left = cut(map, &Mesh::quad(Vec3::ZERO, Vec3::X, Vec3::Y));
    println!("{} triangles, area {}", left.triangles.len(), left.area());
    assert!((left.area() - 4.0 * (1.0 - 4.0 * 0.35 * 0.35)).abs() < 2e-3);
    assert!(left.triangles.len() < 100, "{}", left.triangles.len());
}

#[test]
fn noise_is_cut_as_it_is() {
    // No two texels alike: outlines with corners in every texel, islands and holes.
    let mut state = 1_u32;
    let texels = (0..128 * 128).map(|_| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        [255, 255, 255, (state >> 24) as u8]
    });
    let map = TextureMap::new(Texture::new("noise", [128, 128], texels.collect(), Encoding::Srgb));
    let part = opaque(&map);
    let left = cut(map, &Mesh::quad(Vec3::ZERO, Vec3::X, Vec3::Y));
    println!("{} triangles, area {:.5} of {:.5}", left.triangles.len(), left.area(), 4.0 * part);
    assert!((left.area() / (4.0 * part) - 1.0).abs() < 0.01);
}

/// Columns and rows of one texel, whose edges meet the triangles' common side: cut away, or left alone.
#[test]
fn lines_of_one_texel_are_cut_through() {
    for n in [4, 5, 8] {
        for (k, is_column) in (0..n).flat_map(|k| [(k, true), (k, false)]) {
            let texel = |i: u32, inside: bool| {
                let place = if is_column { i % n } else { i / n };
                [255, 255, 255, if (place == k) == inside { 255 } else { 0 }]
            };
            for (is_pixelated, inside) in [(false, false), (false, true), (true, false), (true, true)] {
                let texels = (0..n * n).map(|i| texel(i, inside)).collect();
                let mut map = TextureMap::new(Texture::new("line", [n; 2], texels, Encoding::Srgb));
                (map.is_pixelated, map.wrap) = (is_pixelated, [Wrap::Clamp; 2]);
                let left = cut(map, &Mesh::quad(Vec3::ZERO, Vec3::X, Vec3::Y));
                let line = 4.0 / f64::from(n);
                let want = if inside { line } else { 4.0 - line };
                assert!(
                    (left.area() - want).abs() < 1e-2 * line,
                    "{n} {k} {is_column} {inside}: {} {want}",
                    left.area()
                );
            }
        }
    }
}

/// An island and a hole of one texel: a square, or, where texels are blended, what bilinear alpha leaves of it.
#[test]
fn single_texels_have_their_area() {
    for (is_pixelated, want, tolerance) in [(true, 1.0, 0.08), (false, 4.0 * (0.5 - 0.5 * 2.0_f64.ln()), 0.03)] {
        for inside in [true, false] {
            let texel = |i: u32| [255, 255, 255, if (i == 3 * 8 + 4) == inside { 255 } else { 0 }];
            let mut map = TextureMap::new(Texture::new("dot", [8; 2], (0..64).map(texel).collect(), Encoding::Srgb));
            map.is_pixelated = is_pixelated;
            let left = cut(map, &Mesh::quad(Vec3::ZERO, Vec3::X, Vec3::Y)).area() * 16.0;
            let dot = if inside { left } else { 64.0 - left };
            println!("{is_pixelated} {inside}: {dot} of {want}");
            assert!((dot - want).abs() < tolerance, "{is_pixelated} {inside}: {dot} {want}");
        }
    }
}

/// A checker that repeats until cells would have to be as large as its squares: as much as there is, or all, but not nothing.
#[test]
fn patterns_that_repeat_too_often_stay_opaque() {
    let map = image(64, |x, y| f32::from(u8::from((8.0 * x) as u32 % 2 == (8.0 * y) as u32 % 2)));
    for times in [5.0_f32, 20.0, 100.0, 400.0] {
        let mut map = map.clone();
        map.transform = glam::Affine2::from_scale(Vec2::splat(times));
        let mut mesh = Mesh::quad(Vec3::ZERO, Vec3::X, Vec3::Y);
        let is_cut = cut_by(&CutOut { map: Some(map), factor: 1.0, limit: 0.5 }, &mut mesh, &[]);
        println!("{times}: {is_cut}, {} triangles, area {}", mesh.triangles.len(), mesh.area());
        assert!(is_cut || times > 50.0, "{times}");
        assert!((mesh.area() - if is_cut { 2.0 } else { 4.0 }).abs() < 0.1, "{times}: {}", mesh.area());
    }
}
