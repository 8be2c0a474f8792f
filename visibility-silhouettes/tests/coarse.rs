//! Simplified forms of meshes: masks stay near the exact ones, and depend only on the receiver and its light.

use crate::common::{Rays, Soup, globe};
use glam::Vec3;
use lobe_core::{Cone, FlatShape, Lobe, Outline, Receiver, Sphere, cap_integral, light_integral};
use shading::{Accuracy, LightCoverage, LightExtent, LightId, LightVisibility, Shaft, Visibility};
use visibility_mask::MaskVisibility;
use visibility_silhouettes::{SilhouetteBlockers, SilhouetteMesh};

const LIGHT: Sphere = Sphere { center: Vec3::new(1.0, 6.0, 0.5), radius: 1.5 };

/// A lumpy body from two spheres, with 13 000 triangles.
fn body() -> Soup {
    let mut soup = globe(Vec3::Y * 2.0, 1.0, 48);
    soup.append(&globe(Vec3::new(0.5, 0.4, 0.0), 0.4, 24));
    soup.append(&globe(Vec3::new(-0.5, 0.4, 0.0), 0.4, 24));
    for p in &mut soup.positions {
        let q = *p * 5.0;
        *p += Vec3::new(q.y.sin(), q.z.sin(), q.x.sin()) * 0.06;
    }
    soup
}

/// Receivers on the ground, in groups of neighbours.
fn ground() -> Vec<Vec<Receiver>> {
    let at = |x: f32, z: f32| Receiver::on_surface(Vec3::new(x, -0.1, z), Vec3::Y, Vec3::Y);
    let group = |i: i32| {
        let (x, z) = ((i % 14) as f32 * 0.35 - 3.4, (i / 14) as f32 * 0.35 - 2.6);
        (0..4).map(|k| at(x + 0.04 * (k % 2) as f32, z + 0.04 * (k / 2) as f32)).collect()
    };
    (0..196).map(group).collect()
}

/// The visible fraction of the light for each receiver, in groups or each alone.
fn shares(blockers: SilhouetteBlockers<'_>, groups: &[Vec<Receiver>], tolerance: f32, alone: bool) -> Vec<f32> {
    let strategy = MaskVisibility::new(blockers);
    let mut scratch = strategy.scratch();
    let mut out = Vec::new();
    for group in groups {
        let center = group.iter().map(|at| at.position).sum::<Vec3>() / group.len() as f32;
        let radius = group.iter().map(|at| at.position.distance(center)).fold(0.0, f32::max) * 1.001;
        let parts = if alone { group.chunks(1) } else { group.chunks(group.len()) };
        for part in parts {
            let receivers =
                if alone { Sphere { center: part[0].position, radius: 0.0 } } else { Sphere { center, radius } };
            let shaft = Shaft::new(receivers, LIGHT, LightId(0));
            let mut visit = LightVisibility::enter(&strategy, &shaft, Accuracy::new(tolerance), &mut scratch);
            for at in part {
                let cone = Cone::of_sphere(at.position, LIGHT);
                let lobe = Lobe::new(at.normal, 1.0, Vec3::ONE);
                out.push(visit.visible_fraction(at, &cone, &lobe, cap_integral(at, lobe, &cone)).x);
            }
        }
    }
    out
}

#[test]
fn masks_stay_within_the_tolerance() {
    let soup = body();
    let exact = [SilhouetteMesh::new(0, &soup.positions, &soup.triangles)];
    let coarse = [SilhouetteMesh::with_coarse(0, &soup.positions, &soup.triangles)];
    let groups = ground();
    for tolerance in [0.01, 0.003] {
        let want = shares(SilhouetteBlockers::new(&exact, Rays(&soup)), &groups, tolerance, false);
        // A mesh with simplified forms is exact if no tolerance is set.
        let same = shares(SilhouetteBlockers::new(&coarse, Rays(&soup)), &groups, tolerance, false);
        assert_eq!(want, same);
        let blockers = || SilhouetteBlockers::new(&coarse, Rays(&soup)).with_tolerance(tolerance);
        let got = shares(blockers(), &groups, tolerance, false);
        assert_eq!(got, shares(blockers(), &groups, tolerance, true), "depends on the group");
        let partial = want.iter().filter(|v| (0.01..0.99).contains(*v)).count();
        let differences: Vec<f32> = want.iter().zip(&got).map(|(a, b)| (a - b).abs()).collect();
        let changed = differences.iter().filter(|d| **d > 0.0).count();
        let mean = differences.iter().sum::<f32>() / partial as f32;
        let most = differences.iter().copied().fold(0.0, f32::max);
        println!("tolerance {tolerance}: {changed} of {partial} changed, mean {mean}, largest {most}");
        assert!(changed > partial / 3, "only {changed} of {partial} masks are of simplified forms");
        assert!(mean < 0.25 * tolerance && most < 3.0 * tolerance, "mean {mean}, largest {most}");
    }
}

/// A mesh that was moved back and forth equals one that was built there.
#[test]
fn forms_are_refitted() {
    let soup = body();
    let mut moved = soup.clone();
    for p in &mut moved.positions {
        *p = Vec3::new(p.x * 1.2, p.y, p.z * 0.8) + Vec3::X * (0.2 * p.y);
    }
    let groups = ground();
    let mut kept = [SilhouetteMesh::with_coarse(0, &soup.positions, &soup.triangles)];
    let share = |meshes: &[SilhouetteMesh; 1], soup: &Soup| {
        shares(SilhouetteBlockers::new(meshes, Rays(soup)).with_tolerance(0.01), &groups, 0.01, false)
    };
    let first = share(&kept, &soup);
    assert!(kept[0].refit(&moved.positions));
    let exact = [SilhouetteMesh::new(0, &moved.positions, &moved.triangles)];
    let want = shares(SilhouetteBlockers::new(&exact, Rays(&moved)), &groups, 0.01, false);
    let most = share(&kept, &moved).iter().zip(&want).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(most < 0.03, "{most}");
    assert!(kept[0].refit(&soup.positions));
    assert_eq!(first, share(&kept, &soup));
}

/// Where a flat light or a sphere of light cuts a body with simplified forms, masks are those of the exact body: the outlines in which the light cuts
/// triangles do not continue simplified ones.
#[test]
fn lights_that_cut_a_body_see_its_exact_outlines() {
    let soup = body();
    let exact = [SilhouetteMesh::new(0, &soup.positions, &soup.triangles)];
    let coarse = [SilhouetteMesh::with_coarse(0, &soup.positions, &soup.triangles)];
    let center = Vec3::new(0.3, 2.2, 0.2);
    let corners = [(1, 1), (1, -1), (-1, -1), (-1, 1)].map(|(x, z)| center + 3.0 * Vec3::new(x as f32, 0.0, z as f32));
    let bounds = Sphere { center, radius: 4.3 };
    let panel = FlatShape::polygon(&corners, Vec3::NEG_Y, bounds, 1.0);
    let extent = LightExtent { sides: [3.0 * Vec3::X, 3.0 * Vec3::Z], margin: 0.04, is_beyond_all: false };
    let pierced = Sphere { center: Vec3::new(0.8, 2.6, 0.3), radius: 0.8 };
    let shares = |blockers: SilhouetteBlockers<'_>, is_flat: bool| {
        let strategy = MaskVisibility::new(blockers);
        let mut scratch = strategy.scratch();
        let mut out = Vec::new();
        for at in ground().iter().step_by(3).map(|group| &group[0]) {
            let receivers = Sphere { center: at.position, radius: 0.01 };
            let light = if is_flat { bounds } else { pierced };
            let shaft = Shaft::new(receivers, light, LightId(0)).with_extent(is_flat.then_some(extent));
            let mut visit = LightVisibility::enter(&strategy, &shaft, Accuracy::new(0.01), &mut scratch);
            let outline = is_flat.then(|| panel.outline(at.position)).flatten();
            let cone = outline.as_ref().map_or_else(|| Cone::of_sphere(at.position, light), Outline::cone);
            let lobe = Lobe::new(at.normal, 1.0, Vec3::ONE);
            out.push(match visit.coverage(at, &cone, outline.as_ref()) {
                LightCoverage::Lit => 1.0,
                LightCoverage::Dark => 0.0,
                LightCoverage::Partial(penumbra) => {
                    let all = light_integral(at, &lobe.into(), &cone, penumbra.outline);
                    visit.fraction(&penumbra, lobe, all).x
                }
            });
        }
        out
    };
    for is_flat in [true, false] {
        let want = shares(SilhouetteBlockers::new(&exact, Rays(&soup)), is_flat);
        let got = shares(SilhouetteBlockers::new(&coarse, Rays(&soup)).with_tolerance(0.01), is_flat);
        let partial = want.iter().filter(|v| (0.01..0.99).contains(*v)).count();
        assert!(partial > 20, "{partial}");
        assert_eq!(want, got, "{is_flat}");
    }
}
