use glam::{Mat4, Quat, Vec3};
use lobe_core::{SelfShadow, Sphere};

use crate::shapes::{cube, sphere};
use crate::{BindError, BoundSet, BuildOptions, Carriers, SphereSet};

/// A tube along x from −2 to 2, radius 0.3, closed: 24 × 33 quads and two caps.
fn tube() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let (rings, sides) = (33_u32, 24_u32);
    let mut positions: Vec<Vec3> = (0..rings * sides)
        .map(|i| {
            let turn = (i % sides) as f32 / sides as f32 * core::f32::consts::TAU;
            let x = (i / sides) as f32 / (rings - 1) as f32 * 4.0 - 2.0;
            Vec3::new(x, 0.3 * turn.cos(), 0.3 * turn.sin())
        })
        .collect();
    let ends = [positions.len() as u32, positions.len() as u32 + 1];
    positions.extend([Vec3::new(-2.0, 0.0, 0.0), Vec3::new(2.0, 0.0, 0.0)]);
    let mut triangles = Vec::new();
    for i in 0..sides {
        let next = (i + 1) % sides;
        for ring in 0..rings - 1 {
            let at = |ring: u32, i: u32| ring * sides + i;
            triangles.push([at(ring, i), at(ring, next), at(ring + 1, i)]);
            triangles.push([at(ring, next), at(ring + 1, next), at(ring + 1, i)]);
        }
        triangles.push([ends[0], next, i]);
        triangles.push([ends[1], (rings - 1) * sides + i, (rings - 1) * sides + next]);
    }
    (positions, triangles)
}

struct Rig {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    joints: Vec<[u16; 4]>,
    weights: Vec<[f32; 4]>,
    targets: Vec<Vec<Vec3>>,
}

impl Rig {
    /// Joint 1 takes over from joint 0 between x = −0.3 and 0.3.
    fn new((positions, triangles): (Vec<Vec3>, Vec<[u32; 3]>)) -> Self {
        let second = |p: &Vec3| (p.x / 0.6 + 0.5).clamp(0.0, 1.0);
        let weights = positions.iter().map(|p| [1.0 - second(p), second(p), 0.0, 0.0]).collect();
        Self { joints: vec![[0, 1, 0, 0]; positions.len()], weights, positions, triangles, targets: Vec::new() }
    }

    fn bind(&self, set: &SphereSet, rest_joints: &[Mat4], rest_morph: &[f32]) -> Result<BoundSet, BindError> {
        let carriers =
            Carriers { joints: &self.joints, weights: &self.weights, targets: &self.targets, rest_joints, rest_morph };
        set.bind(&self.positions, &self.triangles, &carriers)
    }

    /// The deformed vertices by the definition.
    fn deform(&self, joints: &[Mat4], morph: &[f32]) -> Vec<Vec3> {
        let moved = |v: usize| {
            let point = self.targets.iter().zip(morph).fold(self.positions[v], |p, (target, m)| p + target[v] * *m);
            let parts = self.joints[v].iter().zip(self.weights[v]);
            parts.map(|(joint, weight)| joints[usize::from(*joint)].transform_point3(point) * weight).sum()
        };
        (0..self.positions.len()).map(moved).collect()
    }
}

fn built(rig: &Rig, count: usize) -> SphereSet {
    let options = BuildOptions { rounds: 1, ..BuildOptions::new(count) };
    SphereSet::build(&rig.positions, &rig.triangles, &options).expect("a mesh with area")
}

fn posed(bound: &BoundSet, joints: &[Mat4], morph: &[f32]) -> Vec<Sphere> {
    let mut out = Vec::new();
    bound.pose(joints, morph, &mut out, &mut Vec::new()).expect("joints enough");
    out
}

const STILL: [Mat4; 2] = [Mat4::IDENTITY; 2];

#[test]
fn rigid_motion_and_uniform_scale_are_exact() {
    let rig = Rig::new(tube());
    let set = built(&rig, 24);
    let bound = rig.bind(&set, &STILL, &[]).expect("a rig");
    let motion = Mat4::from_scale_rotation_translation(
        Vec3::splat(2.5),
        Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), 2.0),
        Vec3::new(3.0, -1.0, 7.0),
    );
    for (matrix, scale) in [(Mat4::IDENTITY, 1.0), (motion, 2.5)] {
        for (new, old) in posed(&bound, &[matrix; 2], &[]).iter().zip(&set.spheres) {
            // Three roundings of numbers up to 10.
            assert!(new.center.distance(matrix.transform_point3(old.center)) < 1e-5, "{new:?} {old:?}");
            assert!((new.radius - scale * old.radius).abs() < 1e-6 * scale, "{new:?} {old:?}");
        }
    }
}

/// In the rest pose an offset has its given value. Elsewhere it turns with the limb, and keeps its length where bones
/// shear it.
#[test]
fn near_spheres_turn_with_their_bones() {
    let mut rig = Rig::new(tube());
    let rest = Mat4::from_scale_rotation_translation(Vec3::splat(0.5), Quat::from_rotation_y(1.0), Vec3::Y);
    rig.positions = rig.deform(&[rest; 2], &[]);
    let mut set = built(&rig, 8);
    for (i, own) in set.self_shadows.iter_mut().enumerate() {
        *own = SelfShadow { offset: Vec3::new(0.1, 0.2, 0.01 * i as f32), radius: 0.7, distance: 0.2 };
    }
    let bound = rig.bind(&set, &[rest; 2], &[]).expect("a rig");
    let own = |matrix: Mat4| {
        let (mut spheres, mut own) = (Vec::new(), Vec::new());
        bound.pose(&[matrix * rest; 2], &[], &mut spheres, &mut own).expect("joints enough");
        assert_eq!(own.len(), spheres.len());
        own
    };
    let motion = Mat4::from_scale_rotation_translation(Vec3::splat(3.0), Quat::from_rotation_x(2.0), Vec3::X);
    for (matrix, turn) in [(Mat4::IDENTITY, Quat::IDENTITY), (motion, Quat::from_rotation_x(2.0))] {
        for (new, old) in own(matrix).iter().zip(&set.self_shadows) {
            assert!(new.offset.distance(turn * old.offset) < 1e-6, "{new:?} {old:?}");
            assert_eq!((new.radius, new.distance), (0.7, 0.2));
        }
    }
    for bad in [Mat4::from_scale(Vec3::new(9.0, 1.0, 0.1)), Mat4::ZERO, Mat4::NAN] {
        assert!(own(bad).iter().all(|own| own.offset.length() < 0.3), "{bad}");
    }
}

#[test]
fn a_bent_limb_keeps_its_spheres() {
    let rig = Rig::new(tube());
    let set = built(&rig, 24);
    let bound = rig.bind(&set, &STILL, &[]).expect("a rig");
    let straight = set.quality.silhouette_error;
    for angle in [0.5_f32, 1.2, -1.6] {
        let joints = [Mat4::IDENTITY, Mat4::from_rotation_z(angle)];
        let spheres = posed(&bound, &joints, &[]);
        let bent = rig.deform(&joints, &[]);
        // The surface around the bend pinches, as linear blending does: the spheres follow the pinched surface.
        let now = SphereSet::measure(&bent, &rig.triangles, &spheres).expect("a mesh with area").quality;
        assert!(now.silhouette_error < straight + 0.03, "{angle}: {straight} {now:?}");
        let rest = set.quality;
        assert!(now.hausdorff_outside < rest.hausdorff_outside + 0.01, "{angle}: {now:?} {rest:?}");
        assert!(now.p95_gap < rest.p95_gap + 0.01, "{angle}: {now:?} {rest:?}");
    }
}

#[test]
fn a_limb_on_a_trunk_does_not_cling_to_it() {
    // Two boxes with faces that touch, each carried by its own joint; spheres that reach half-way through stay between.
    let (trunk, faces) = cube();
    let mut rig = Rig::new((trunk.clone(), faces.clone()));
    rig.positions.extend(trunk.iter().map(|p| *p * Vec3::new(0.4, 1.0, 0.4) + Vec3::new(0.7, 0.0, 0.0)));
    rig.triangles.extend(faces.iter().map(|t| t.map(|i| i + 8)));
    rig.joints = (0..16).map(|v| [u16::from(v >= 8), 0, 0, 0]).collect();
    rig.weights = vec![[1.0, 0.0, 0.0, 0.0]; 16];
    let set = built(&rig, 40);
    let bound = rig.bind(&set, &STILL, &[]).expect("a rig");
    let away = Vec3::new(5.0, 0.0, 0.0);
    let spheres = posed(&bound, &[Mat4::IDENTITY, Mat4::from_translation(away)], &[]);
    let mut stretched = 0;
    for (new, old) in spheres.iter().zip(&set.spheres) {
        let limb = old.center.x > 0.5 + 0.5 * old.radius;
        let trunk = old.center.x < 0.5 - 0.5 * old.radius;
        let moved = (new.center - old.center).length() / 5.0;
        stretched += usize::from((limb && moved < 0.85) || (trunk && moved > 0.15));
    }
    assert!(stretched == 0, "{stretched} of 40 spheres lag behind");
}

#[test]
fn morph_targets_move_and_grow() {
    let mut rig = Rig::new(sphere(12));
    rig.joints = vec![[0; 4]; rig.positions.len()];
    rig.weights = vec![[1.0, 0.0, 0.0, 0.0]; rig.positions.len()];
    let lift = Vec3::new(0.0, 0.0, 0.7);
    rig.targets = vec![vec![lift; rig.positions.len()], rig.positions.iter().map(|p| *p * 0.5).collect()];
    let set = built(&rig, 1);
    let bound = rig.bind(&set, &STILL[..1], &[0.25, 0.0]).expect("a rig");
    let rest = set.spheres[0];
    let with = |morph: [f32; 2]| posed(&bound, &STILL[..1], &morph)[0];
    assert!(with([0.25, 0.0]).center.distance(rest.center) < 1e-5);
    assert!(with([1.25, 0.0]).center.distance(rest.center + lift) < 1e-5);
    assert!((with([1.25, 0.0]).radius - rest.radius).abs() < 1e-4);
    // The patch is the whole sphere, so its growth is known but for the 0.02 against patches that look one way.
    assert!((with([0.25, 1.0]).radius - 1.5 * rest.radius).abs() < 0.02, "{:?}", with([0.25, 1.0]));
    assert!(with([0.25, 1.0]).center.distance(rest.center) < 0.02);
    assert!(with([0.25, -100.0]).radius == 0.0);
}

#[test]
fn bound_where_the_rest_pose_is_not_the_bind_pose() {
    let mut rig = Rig::new(tube());
    let joints = [
        Mat4::from_scale_rotation_translation(Vec3::splat(0.5), Quat::from_rotation_y(1.0), Vec3::Y),
        Mat4::from_scale_rotation_translation(Vec3::splat(0.5), Quat::from_rotation_y(1.3), Vec3::Y),
    ];
    let bind_positions = rig.positions.clone();
    rig.positions = rig.deform(&joints, &[]);
    let set = built(&rig, 24);
    let bound = rig.bind(&set, &joints, &[]).expect("a rig");
    for (new, old) in posed(&bound, &joints, &[]).iter().zip(&set.spheres) {
        assert!(new.center.distance(old.center) < 1e-5 && (new.radius - old.radius).abs() < 1e-5, "{new:?} {old:?}");
    }
    // In the bind pose the set stands for the bind positions about as well as it did for the others.
    let back = posed(&bound, &STILL, &[]);
    let quality = SphereSet::measure(&bind_positions, &rig.triangles, &back).expect("a mesh with area").quality;
    assert!(quality.silhouette_error < set.quality.silhouette_error + 0.02, "{quality:?} {:?}", set.quality);
}

#[test]
fn degenerate_matrices_give_finite_spheres() {
    let rig = Rig::new(tube());
    let set = built(&rig, 8);
    let bound = rig.bind(&set, &STILL, &[]).expect("a rig");
    let flat = Mat4::from_scale(Vec3::new(1.0, 0.0, 1.0));
    let bad = [Mat4::ZERO, flat, Mat4::from_scale(Vec3::splat(1e38)), Mat4::NAN, Mat4::from_scale(Vec3::splat(-1.0))];
    for matrix in bad {
        for sphere in posed(&bound, &[matrix; 2], &[]) {
            assert!(
                sphere.center.is_finite() && sphere.radius.is_finite() && sphere.radius >= 0.0,
                "{matrix}: {sphere:?}"
            );
        }
    }
    assert!(posed(&bound, &[flat; 2], &[]).iter().all(|sphere| sphere.radius == 0.0));
    // Bound where everything has collapsed.
    let collapsed = rig.bind(&set, &[Mat4::ZERO; 2], &[]).expect("a rig");
    assert!(posed(&collapsed, &STILL, &[]).iter().all(|s| s.center.is_finite() && s.radius.is_finite()));
}

#[test]
fn faults_of_a_rig_are_named() {
    let rig = Rig::new(tube());
    let set = built(&rig, 4);
    let bound = rig.bind(&set, &STILL, &[]).expect("a rig");
    assert_eq!((bound.joints(), bound.targets()), (2, 0));
    let mut out = vec![Sphere::default(); 2];
    let missing = bound.pose(&STILL[..1], &[], &mut out, &mut Vec::new()).expect_err("a joint is missing");
    assert_eq!(missing.to_string(), "1 joints, but 2 are needed");
    assert_eq!(out.len(), 2);
    let mut bad = Rig::new(tube());
    bad.weights[7][1] = f32::NAN;
    assert_eq!(bad.bind(&set, &STILL, &[]), Err(BindError::BadWeight { vertex: 7 }));
    bad.weights[7] = [1.0, 0.5, 0.0, 0.0];
    bad.joints[7] = [0, 9, 0, 0];
    assert_eq!(bad.bind(&set, &STILL, &[]), Err(BindError::NoSuchJoint { vertex: 7, joint: 9, joints: 2 }));
    bad.joints.pop();
    assert!(matches!(bad.bind(&set, &STILL, &[]), Err(BindError::Missing { .. })));
}

#[test]
fn bones_are_stored_with_the_set() {
    let mut rig = Rig::new(tube());
    rig.targets = vec![rig.positions.iter().map(|p| *p * 0.1).collect()];
    let set = built(&rig, 6);
    let bound = rig.bind(&set, &STILL, &[0.0]).expect("a rig");
    let text = bound.to_json();
    assert_eq!(BoundSet::from_json(&text).expect("its own text"), bound);
    assert_eq!(SphereSet::from_json(&text).expect("its own text"), set);
    let refused = |text: &str| BoundSet::from_json(text).expect_err("a fault").to_string();
    assert!(refused(&set.to_json()).contains("no \"bones\""));
    let value: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(value["bones"]["joints"].as_array().map(Vec::len), Some(6));
    for (path, new, word) in [
        ("/bones/weights/0/0", serde_json::json!(3.0), "sum 1"),
        ("/bones/radii", serde_json::json!([1.0]), "each of its 6 spheres"),
        ("/bones/points/0/0", serde_json::json!(1e300), "finite"),
        ("/bones/offsets/0/0", serde_json::json!(1e300), "finite"),
        ("/bones/offsets", serde_json::json!([[1.0, 0.0, 0.0]]), "one row for each"),
    ] {
        let mut value = value.clone();
        *value.pointer_mut(path).expect("a key of the format") = new;
        let message = refused(&value.to_string());
        assert!(message.contains(word) && !message.contains('\n'), "{message}");
        // Also of who takes the spheres alone.
        assert_eq!(SphereSet::from_json(&value.to_string()).expect_err(word).to_string(), message);
    }
}
