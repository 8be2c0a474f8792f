//! The work follows the mask, not the map.

mod common;

use common::{Mesh, receiver, share};
use glam::Vec3;
use lobe_core::Sphere;
use visibility_mask::Blockers;
use visibility_shadowmap::{MapOptions, ShadowMapBlockers};

const LIGHT: Sphere = Sphere { center: Vec3::new(0.0, 5.0, 0.0), radius: 0.5 };

/// Nodes and quadrilaterals for points of a floor in penumbra: between 1 % and 99 % of the light's disc are visible.
fn work(mesh: &Mesh, resolution: u32) -> [f64; 2] {
    let blockers = ShadowMapBlockers::new(vec![mesh.map(LIGHT, &MapOptions { resolution, ..MapOptions::default() })]);
    let (mut sums, mut points) = ((0, 0), 0.0);
    for k in 0..400_u16 {
        let at = |k: u16| f32::from(k) / 10.0 - 0.95;
        let (mut scratch, at) = (blockers.scratch(), receiver(Vec3::new(at(k % 20), 0.0, at(k / 20)), Vec3::Y));
        if (0.01..0.99).contains(&share(&blockers, &mut scratch, &at, LIGHT)) {
            let (nodes, quads) = scratch.counts();
            sums = (sums.0 + nodes, sums.1 + quads);
            points += 1.0;
        }
    }
    assert!(points > 50.0);
    [sums.0 as f64 / points, sums.1 as f64 / points]
}

#[test]
fn a_finer_map_is_no_more_work() {
    // Spheres with outlines and depth steps, in front of each other and of a block, seen from the light.
    let mut mesh = Mesh::default().cuboid(Vec3::new(-0.5, 0.4, -0.5), Vec3::new(0.5, 0.6, 0.5));
    for (x, y, z) in [(-0.3, 1.0, 0.1), (0.2, 1.2, 0.3), (0.1, 1.1, -0.3), (-0.2, 1.3, -0.1)] {
        mesh = mesh.sphere(Vec3::new(x, y, z), 0.25, 24);
    }
    let work = [512, 1024, 2048].map(|resolution| work(&mesh, resolution));
    println!("nodes, quadrilaterals: {work:.0?}");
    for [nodes, quads] in &work[1..] {
        assert!(*nodes < 1.5 * work[0][0] && *quads < 2.0 * work[0][1], "{work:?}");
    }
}
