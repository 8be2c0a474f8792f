//! Animated files of a shared collection, against an independent program.
//!
//! The collection lies beside the repository and is not part of it; where it is absent these tests are shown as ignored.

use glam::{DVec3, Vec3};
use scene::{Scene, Shape};
use std::path::Path;

const SHARED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/assets/gltf");

type Expected = (&'static str, usize, f32, [f32; 3], [f32; 3], [f32; 3]);

/// File, clip, time; smallest and largest corner and the mean of all vertices, vertex i weighted with i + 1 so that their
/// order counts. From an independent program in f64.
#[rustfmt::skip]
const EXPECTED: &[Expected] = &[
        ("SimpleSkin/SimpleSkin.gltf", 0, 0.7, [-1.118, 0.0, 0.0], [0.543108, 1.8993, 0.0], [-0.351771, 1.148, 0.0]),
        ("RiggedSimple.glb", 0, 1.3, [-1.0, -4.57508, -1.0], [2.40204, 4.32548, 1.0], [1.09023, 0.68647, -0.000911589]),
        ("RiggedFigure.glb", 0, 0.9, [-0.522675, -5.9435e-08, -0.12662], [0.516897, 1.46051, 0.207374], [0.001677, 0.606681, 0.0495592]),
        ("Fox.glb", 0, 1.9, [-11.595, -0.13087, -85.7419], [14.5033, 78.1073, 68.7335], [-0.27959, 27.6112, -2.87903]),
        ("Fox.glb", 1, 0.3, [-12.6409, -1.11315, -91.4482], [12.5445, 75.4747, 69.9818], [-0.547562, 29.4945, -1.68225]),
        ("Fox.glb", 2, 0.77, [-15.2871, -0.673002, -98.1684], [15.249, 71.4998, 66.6255], [-0.794529, 31.7269, -14.1888]),
        ("CesiumMan.glb", 0, 0.0, [-0.310509, -0.0106452, -0.446594], [0.194655, 1.44716, 0.449894], [-0.0525013, 1.0597, 0.043531]),
        ("CesiumMan.glb", 0, 1.234, [-0.235674, 0.00474011, -0.284007], [0.199149, 1.49151, 0.238311], [-0.0279578, 1.1032, 0.0414791]),
        ("BrainStem.glb", 0, 11.1, [-0.860787, 0.0266348, -0.456099], [0.850701, 1.8299, 0.387321], [0.00506967, 1.33908, 0.00108129]),
        ("InterpolationTest.glb", 2, 1.1, [-4.38678, -2.15946, -1.0], [4.34834, 7.95891, 1.00367], [-0.0601617, 4.6474, 0.037474]),
        ("InterpolationTest.glb", 4, 1.1, [-4.38678, -2.15946, -1.0], [4.70714, 7.95891, 1.00894], [-0.0611735, 4.64465, 0.036621]),
        ("InterpolationTest.glb", 7, 1.1, [-4.38678, -2.15946, -1.0], [4.34834, 9.81805, 1.00894], [-0.0597352, 5.0181, 0.036621]),
        ("InterpolationTest.glb", 3, 1.1, [-4.38678, -2.15946, -1.0], [4.34834, 7.95891, 1.00894], [-0.0603933, 4.64478, 0.036621]),
        ("InterpolationTest.glb", 0, 1.1, [-4.38678, -2.15946, -1.0], [4.34834, 7.95891, 1.00894], [-0.0597352, 4.64676, 0.036621]),
        ("AnimatedMorphCube.glb", 0, 1.7, [-1.0, -1.0, -1.0], [1.0, 1.0, -0.864082], [-0.12, 0.0799999, -0.946046]),
        ("AnimatedMorphCube-Quantized/AnimatedMorphCube.gltf", 0, 1.7, [-1.00002, -1.00002, -1.00001], [1.0, 1.0, -0.863398], [-0.0666773, 0.0533234, -0.947077]),
        ("AnimatedMorphSphere.glb", 0, 3.3, [-1.74524, -1.0, -2.38846], [1.74524, 1.0, 1.9129], [-0.126268, -0.0387807, 0.216075]),
        ("MorphStressTest.glb", 0, 4.4, [-2.0, -0.1, -0.5], [2.0, 0.675407, 0.5], [0.629625, 0.263166, -0.00212939]),
        ("MorphStressTest.glb", 1, 0.9, [-2.0, -0.1, -0.5], [2.0, 1.48726, 0.5], [0.629962, 0.448807, -0.00212939]),
        ("RecursiveSkeletons.glb", 0, 0.6, [-107.631, -0.598561, -33.7919], [50.5266, 125.1, 107.867], [-21.2353, 97.7776, -3.92485]),
        ("BoxAnimated.glb", 0, 2.2, [-0.5, -0.5, -0.584454], [0.5, 3.11178, 0.584454], [0.00847441, 0.262407, 0.00222834]),
        ("AnimatedTriangle.gltf", 0, 0.4, [-0.809017, -0.809017, 0.0], [0.0, 0.587785, 0.0], [-0.563565, -0.20858, 0.0]),
        ("generated/tentacle_skinned.glb", 0, 0.55, [-0.404378, 0.0, -0.27736], [0.27736, 2.94319, 0.27736], [-0.0402756, 1.9564, 0.000542185]),
        ("generated/tentacle_skinned.glb", 1, 0.55, [-0.27736, 0.0, -0.277693], [0.27736, 1.25721, 2.0171], [-1.06572e-05, 0.816583, 1.27814]),
        ("generated/tentacle_skinned.glb", 2, 0.8, [0.167168, 0.0, -0.332832], [0.832832, 2.4, 0.332832], [0.499987, 1.60308, 0.000650622]),
];

fn vertices(scene: &Scene) -> Vec<Vec3> {
    let meshes = scene.objects[1..].iter().flat_map(|o| match &o.shape {
        Shape::Mesh(mesh) => mesh.positions.clone(),
        _ => Vec::new(),
    });
    meshes.collect()
}

#[test]
#[cfg_attr(not(shared_assets), ignore = "needs ../shared/assets beside the repository")]
fn posed_vertices_are_where_another_program_puts_them() {
    for &(file, clip, time, min, max, mean) in EXPECTED {
        let (mut scene, animation, _) =
            scene_files::load_clip(Path::new(SHARED).join(file), &clip.to_string()).unwrap();
        animation.seek(time, &mut scene);
        scene.validate().unwrap();
        let points = vertices(&scene);
        let low = points.iter().fold(Vec3::INFINITY, |a, p| a.min(*p));
        let high = points.iter().fold(Vec3::NEG_INFINITY, |a, p| a.max(*p));
        let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
        for (i, p) in points.iter().enumerate() {
            sum += p.as_dvec3() * (i + 1) as f64;
            weights += (i + 1) as f64;
        }
        // Six digits are written here; f32 loses some more along a chain of joints.
        let size = (high - low).max_element();
        for (name, got, want) in [("min", low, min), ("max", high, max), ("mean", (sum / weights).as_vec3(), mean)] {
            let error = (got - Vec3::from_array(want)).abs().max_element();
            assert!(error < 1e-5 * size, "{file}, clip {clip}, {time} s: {name} is {got}, expected {want:?}");
        }
    }
}

#[test]
#[cfg_attr(not(shared_assets), ignore = "needs ../shared/assets beside the repository")]
fn every_animated_file_moves_and_stays_valid() {
    for (file, duration, clips) in [
        ("SimpleSkin/SimpleSkin.gltf", 5.5, 1),
        ("RiggedSimple.glb", 2.083, 1),
        ("RiggedFigure.glb", 1.25, 1),
        ("Fox.glb", 3.417, 3),
        ("CesiumMan.glb", 2.0, 1),
        ("CesiumMilkTruck.glb", 1.25, 1),
        ("BrainStem.glb", 34.88, 1),
        ("InterpolationTest.glb", 1.667, 9),
        ("AnimatedMorphCube.glb", 4.19, 1),
        ("AnimatedMorphCube-Quantized/AnimatedMorphCube.gltf", 4.19, 1),
        ("AnimatedMorphSphere.glb", 7.19, 1),
        ("MorphStressTest.glb", 9.375, 3),
        ("RecursiveSkeletons.glb", 2.0, 1),
        ("BoxAnimated.glb", 3.708, 1),
        ("AnimatedTriangle.gltf", 1.0, 1),
        ("SimpleMorph.gltf", 4.0, 1),
        ("generated/tentacle_skinned.glb", 2.0, 3),
    ] {
        let (mut scene, animation, warnings) = scene_files::load_animated(Path::new(SHARED).join(file)).unwrap();
        animation.validate().unwrap();
        println!("{file}: {} s, {:?}, {warnings:?}", animation.duration(), animation.clips());
        assert!((animation.duration() - duration).abs() < 0.02 && animation.clips().len() == clips, "{file}");
        let first = scene.clone();
        let mut moved = 0.0_f32;
        for i in 0..=12 {
            animation.seek(animation.duration() * i as f32 / 12.0, &mut scene);
            scene.validate().unwrap();
            for (p, q) in vertices(&scene).iter().zip(vertices(&first)) {
                moved = moved.max(p.distance(q));
            }
            // Applying rig and pose by hand gives the result of seeking: bind space through the first moment's matrices.
            if i == 5 {
                follow(&animation, &first, &scene, animation.duration() * 5.0 / 12.0);
            }
        }
        assert!(moved > 1e-2 * scene.objects[1].shape.bounds().radius(), "{file}: {moved}");
        animation.seek(0.0, &mut scene);
        assert_eq!(scene, first, "{file}");
    }
}

/// Carries the vertices of the first moment by rig and pose alone, in f64.
fn follow(animation: &scene::Animation, first: &Scene, now: &Scene, time: f32) {
    for (i, (a, b)) in first.objects.iter().zip(&now.objects).enumerate() {
        let (Some(rig), Shape::Mesh(a), Shape::Mesh(b)) = (animation.rig(i), &a.shape, &b.shape) else { continue };
        let (rest, pose) = (animation.pose(i, 0.0), animation.pose(i, time));
        let blend = |joints: &[glam::Mat4], v: usize| {
            let sum = (0..4).fold(glam::DMat4::ZERO, |m, k| {
                m + joints[usize::from(rig.joints[v][k])].as_dmat4() * f64::from(rig.weights[v][k])
            });
            assert!((rig.weights[v].iter().sum::<f32>() - 1.0).abs() < 1e-6);
            sum
        };
        let size = f64::from(now.objects[i].shape.bounds().radius()).max(1e-3);
        for v in 0..a.positions.len() {
            let before = blend(&rest.joints, v);
            if before.determinant().abs() < 1e-12 {
                continue;
            }
            let mut p = before.inverse().transform_point3(a.positions[v].as_dvec3());
            for (k, target) in rig.targets.iter().enumerate() {
                p += target[v].as_dvec3() * f64::from(pose.morph[k] - rest.morph[k]);
            }
            let got = blend(&pose.joints, v).transform_point3(p);
            assert!(got.distance(b.positions[v].as_dvec3()) < 1e-4 * size, "{i}, {v}: {got} {}", b.positions[v]);
        }
    }
}
