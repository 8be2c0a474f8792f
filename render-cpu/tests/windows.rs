//! Windows of an image are shaded as the whole of it.

use glam::Vec3;
use render_cpu::{CpuShader, GBuffer, World, blockers};
use scene::{Frame, Shade};
use shading::Accuracy;
use std::ops::ControlFlow;
use test_scenes::floor_and_sphere;
use visibility_mask::MaskVisibility;
use visibility_spheres::SphereBlockers;

/// Windows that cut tiles hold the bits of the whole image, whatever groups of points they make.
#[test]
fn windows_make_up_the_picture() {
    let scene = floor_and_sphere();
    let world = World::new(&scene);
    let set = blockers(&scene, &mut |_, _| ControlFlow::Continue(())).expect("blockers");
    let blockers = SphereBlockers::new(&set.spheres, &set.objects, &set.self_distances);
    let mut shader = CpuShader::new(MaskVisibility::new(blockers.with_self_shadows(&set.self_shadows)));
    let frame = Frame::new(&scene.materials, &scene.lights, Accuracy::new(0.003));
    let mut shade = |g: &GBuffer| {
        let mut out = vec![Vec3::ZERO; g.len()];
        shader.shade(&g.points, &frame, &mut out).expect("room");
        g.resolve(&out, Vec3::splat(0.1))
    };
    let whole = shade(&GBuffer::new(&world, 90, 70, 2));
    for (columns, rows) in [(0..33, 0..70), (33..90, 0..21), (33..90, 21..22), (33..90, 22..70), (5..5, 3..9)] {
        let g = GBuffer::window(&world, 90, 70, 2, columns.clone(), rows.clone());
        let part = shade(&g);
        let cut = rows.flat_map(|y| columns.clone().map(move |x| y * 90 + x)).map(|i| whole[i as usize]);
        assert_eq!(part, cut.collect::<Vec<_>>());
    }
}
