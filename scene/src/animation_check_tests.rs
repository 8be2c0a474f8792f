use crate::motion::{
    Body, Bone, CameraKeys, CameraMover, Carrier, Clock, Deformer, FineLocal, Keyed, LightMover, LightPlace, Local,
    Mover, Origins, Placement, ProjectionKeys, Skeleton, Track, Turn,
};
use crate::{Animation, Mesh};
use glam::{DMat4, DVec3, Mat4, Vec3};

const CLOCK: Clock = Clock { first: 0.0, last: 1.0, repeats: false };

fn bone(parent: Option<usize>) -> Bone {
    let translation = Some(Track::constant(&[0.0; 3]));
    Bone {
        parent,
        local: Local::Parts { scale: Vec3::ONE, rotation: glam::Quat::IDENTITY, translation: Vec3::ZERO },
        fine: FineLocal::Matrix(DMat4::IDENTITY),
        rest: Mat4::IDENTITY,
        scale: None,
        rotation: None,
        translation,
        weights: Some(Track::constant(&[0.5])),
        rest_weights: vec![0.0],
    }
}

fn keyed() -> Keyed {
    Keyed {
        clock: CLOCK,
        scale: Track::constant(&[1.0; 3]),
        turn: Turn::About(Vec3::Y, Track::constant(&[0.0])),
        translation: Track::constant(&[0.0; 3]),
        origins: Origins::default(),
    }
}

fn camera() -> CameraKeys {
    let vector = |v: Vec3| Track::constant(&v.to_array());
    CameraKeys {
        clock: CLOCK,
        eye: vector(Vec3::Z),
        target: vector(Vec3::ZERO),
        up: vector(Vec3::Y),
        projection: ProjectionKeys::Perspective(Track::constant(&[0.6])),
    }
}

/// A mesh of two joints with one morph target, a light on a node, and a camera with keys.
fn animation() -> (Animation, Mesh) {
    let mesh = Mesh::quad(Vec3::ZERO, Vec3::X, Vec3::Z);
    let mut deformer = Deformer::rigid(&mesh);
    deformer.joints[1] = [1, 0, 0, 0];
    // Without a weight no joint needs to be there.
    deformer.joints[2] = [0, 9, 9, 9];
    deformer.targets = vec![vec![Vec3::Y; 4]];
    let proxy = vec![deformer.bind_sphere(
        lobe_core::Sphere { center: Vec3::ZERO, radius: 0.1 },
        &mesh.positions,
        &[Mat4::IDENTITY; 2],
    )];
    let carrier =
        Carrier { skeleton: 0, joints: vec![(Some(0), Mat4::IDENTITY), (Some(1), Mat4::IDENTITY)], morph: Some(1) };
    let skeleton = Skeleton {
        bones: vec![bone(None), bone(Some(0))],
        order: vec![0, 1],
        origin: DVec3::ZERO,
        is_fine: false,
        clock: CLOCK,
    };
    let body = Body::Mesh(Box::new(deformer), Some(carrier));
    let placement = LightPlace::Node { skeleton: 0, node: 1 };
    let animation = Animation {
        skeletons: vec![skeleton],
        movers: vec![None, Some(Mover { placement: Placement::Keys(Box::new(keyed())), body, proxy })],
        lights: vec![LightMover { first: 1, lights: Vec::new(), placement }],
        camera: Some(CameraMover::Keys(Box::new(camera()))),
        ..Animation::default()
    };
    (animation, mesh)
}

fn deformer(animation: &mut Animation) -> &mut Deformer {
    match animation.movers[1].as_mut().map(|mover| &mut mover.body) {
        Some(Body::Mesh(deformer, _)) => deformer,
        _ => panic!("it is a mesh"),
    }
}

fn carrier(animation: &mut Animation) -> &mut Carrier {
    match animation.movers[1].as_mut().map(|mover| &mut mover.body) {
        Some(Body::Mesh(_, Some(carrier))) => carrier,
        _ => panic!("it has a carrier"),
    }
}

/// A fault: the change that makes it, and the words that name it.
type Fault = (fn(&mut Animation), &'static str);

#[test]
fn each_fault_is_named() {
    let faults: &[Fault] = &[
        (|a| a.skeletons[0].order[1] = 7, "skeleton 0: there is no node 7 of 2"),
        (|a| a.skeletons[0].bones[1].parent = Some(2), "skeleton 0: there is no node 2 of 2"),
        (
            |a| a.skeletons[0].bones[1].translation = Some(Track::constant(&[0.0])),
            "node 1: a track has 1 numbers a key",
        ),
        (|a| a.skeletons[0].bones[0].rest_weights.clear(), "node 0: a track has 1 numbers a key: expected 0"),
        (|a| carrier(a).skeleton = 1, "object 1: there is no skeleton 1 of 1"),
        (|a| carrier(a).morph = Some(2), "object 1: there is no node 2 of 2"),
        (|a| carrier(a).joints.truncate(1), "object 1: there is no joint 1 of 1"),
        (|a| deformer(a).targets.clear(), "object 1: 1 morph weights for 0 targets"),
        (|a| deformer(a).targets[0].truncate(3), "object 1: 3 displacements for 4 vertices"),
        (|a| deformer(a).weights.truncate(3), "object 1: 3 lists of weights for 4 vertices"),
        (|a| deformer(a).normals = vec![Vec3::Y], "object 1: 1 normals for 4 vertices"),
        (|a| deformer(a).smooth = Some(vec![(4, false); 4]), "object 1: there is no group 4 of 4"),
        (|a| *deformer(a) = Deformer::default(), "1 morph weights for 0 targets"),
        (|a| a.lights[0].placement = LightPlace::Node { skeleton: 0, node: 2 }, "light 1: there is no node 2 of 2"),
        (
            |a| {
                a.camera = Some(CameraMover::Keys(Box::new(CameraKeys {
                    projection: ProjectionKeys::Orthographic(Track::constant(&[1.0; 2])),
                    ..camera()
                })))
            },
            "camera: a track has 2 numbers a key: expected 1",
        ),
        (
            |a| {
                let turn = Turn::Free(Track::constant(&[0.0; 3]));
                a.lights[0].placement = LightPlace::Keys(Placement::Keys(Box::new(Keyed { turn, ..keyed() })));
            },
            "light 1: a track has 3 numbers a key: expected 4",
        ),
    ];
    for (break_it, words) in faults {
        let (mut animation, _) = animation();
        break_it(&mut animation);
        let message = animation.validate().expect_err(words).to_string();
        assert!(message.contains(words), "{message}: expected {words}");
    }
}

#[test]
fn a_valid_animation_can_be_sought() {
    let (animation, mesh) = animation();
    animation.validate().unwrap();
    let mut scene = crate::builtin();
    scene.objects[1].shape = crate::Shape::Mesh(mesh);
    for time in [0.0, 0.5, f32::NAN, 9.0] {
        animation.seek(time, &mut scene);
        assert_eq!(animation.pose(1, time).joints.len(), 2);
    }
    // The second node's weight lifts all vertices by half a target.
    let crate::Shape::Mesh(mesh) = &scene.objects[1].shape else { panic!("it is a mesh") };
    assert!(mesh.positions.iter().all(|p| (p.y - 0.5).abs() < 1e-6), "{:?}", mesh.positions);
}
