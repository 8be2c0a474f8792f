//! The kernels of poses and texture writers without a GPU: they validate, and their constants are the same as in Rust.

use crate::constant;
use crate::validated::module;
use glam::{Mat4, Vec3};
use lobe_core::wgsl::join;
use render_gpu::wgsl::{DISPLAY, RESOLVE, TEXTURE_WRITER};
use sphere_sets::{BuildOptions, Carriers, SphereRig, SphereRigPart, SphereSet};
use visibility_spheres::SphereBlockers;

const BUFFERS: &str = "@group(0) @binding(6) var<storage, read_write> spheres: array<BlockerSphere>;
    @group(0) @binding(12) var<storage, read> rig: array<u32>;
    @group(0) @binding(13) var<storage, read> bones: array<f32>;";

#[test]
fn a_rig_has_the_words_that_its_kernel_reads() {
    let pose = module(&(join(&[&sphere_sets::wgsl::POSE]) + BUFFERS));
    let entry = &pose.entry_points[0];
    assert_eq!((entry.name.as_str(), entry.workgroup_size), ("pose_spheres", [64, 1, 1]));
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let set = SphereSet::build(&corners, &triangles, &BuildOptions::new(3)).unwrap();
    for targets in [vec![], vec![corners.to_vec(); 2]] {
        let carriers = Carriers {
            joints: &[[0; 4]; 4],
            weights: &[[1.0, 0.0, 0.0, 0.0]; 4],
            targets: &targets,
            rest_joints: &[Mat4::IDENTITY],
            rest_morph: &[0.0; 2],
        };
        let bound = set.bind(&corners, &triangles, &carriers).unwrap();
        let spheres = &bound.rest().spheres;
        let blockers = SphereBlockers::new(spheres, &vec![0; spheres.len()], &[]);
        let rig = SphereRig::new(&blockers, &[SphereRigPart { first: 0, set: &bound }]).unwrap();
        let [rig_words, morph_words] = ["RIG_WORDS", "MORPH_WORDS"].map(|name| constant(&pose, name) as usize);
        let each = rig_words + targets.len() * morph_words;
        assert_eq!(rig.words().len(), 1 + spheres.len() * each);
        assert_eq!(rig.spheres() as usize, spheres.len());
        // One sphere too few.
        assert!(SphereRig::new(&blockers, &[SphereRigPart { first: 1, set: &bound }]).is_err());
    }
}

#[test]
fn a_texture_writer_of_either_format_validates() {
    for format in ["rgba16float", "rgba32float"] {
        let binding = format!("@group(0) @binding(10) var target_texture: texture_storage_2d<{format}, write>;");
        let writer = module(&(join(&[&TEXTURE_WRITER]) + &binding));
        assert_eq!(writer.entry_points[0].workgroup_size, [render_gpu::TILE, render_gpu::TILE, 1]);
    }
}

#[test]
fn pixels_and_displays_validate() {
    let binding = "@group(0) @binding(10) var target_texture: texture_storage_2d<rgba32float, write>;";
    for text in [join(&[&RESOLVE]) + binding, join(&[&DISPLAY])] {
        assert_eq!(module(&text).entry_points[0].workgroup_size, [render_gpu::TILE, render_gpu::TILE, 1]);
    }
}
