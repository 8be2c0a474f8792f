use crate::blockers_error::{BlockersError, BlockersProgress};
use crate::scene_spheres::{SceneSpheres, SphereSource};
use scene::{BlockerSet, Scene};

/// The blocker spheres of all objects, from their proxies, in a scene that stands still: [`SceneSpheres`] once.
///
/// # Errors
/// [`BlockersError`]; a build that `progress` breaks off is [`BuildError::Cancelled`](sphere_sets::BuildError::Cancelled).
pub fn blockers(scene: &Scene, progress: &mut BlockersProgress<'_>) -> Result<BlockerSet, BlockersError> {
    let mut set = BlockerSet::default();
    SceneSpheres::new(scene, None, |_| SphereSource::Proxy, progress)?.pose(scene, None, &mut set)?;
    Ok(set)
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::ops::ControlFlow;
    use glam::{Mat4, Quat, Vec3};
    use lobe_core::Sphere;
    use scene::{Mesh, Proxy, Shape};
    use sphere_sets::{BuildOptions, SphereSet};
    use test_scenes::floor_and_sphere;

    fn make(scene: &Scene) -> Result<BlockerSet, BlockersError> {
        blockers(scene, &mut |_, _| ControlFlow::Continue(()))
    }

    #[test]
    fn a_lamp_does_not_hide_its_light() {
        let mut scene = floor_and_sphere();
        let blocking = make(&scene).unwrap().spheres.len();
        scene.objects.push(scene::Object::spheres("lamp", vec![scene.lights[0].sphere().expect("a sphere")], 0));
        let set = make(&scene).unwrap();
        let light = scene.lights[0].sphere().expect("a sphere");
        let lamp = set.spheres[blocking];
        // It hides other lights from inside of its own.
        assert!(set.spheres.len() == blocking + 1 && lamp.center == light.center && lamp.radius < light.radius);
        assert!(lamp.radius > 0.99 * light.radius);
        scene.objects.push(scene::Object::spheres(
            "shell",
            vec![Sphere { radius: 2.0, ..scene.lights[0].sphere().expect("a sphere") }],
            0,
        ));
        let set = make(&scene).unwrap();
        assert_eq!((set.spheres.len(), set.objects.last()), (blocking + 2, Some(&3)));
    }

    #[test]
    fn every_kind_of_proxy() {
        let mut scene = floor_and_sphere();
        let set = make(&scene).unwrap();
        assert_eq!((set.spheres.len(), set.objects.as_slice(), set.self_distances.len()), (1, [1].as_slice(), 2));
        assert!(set.self_distances[1] > 0.0 && set.self_distances[1] < 1e-3);

        // A closed mesh: a tetrahedron.
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let triangles = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        scene.objects[0].shape = Shape::Mesh(Mesh { positions, triangles, ..Mesh::default() });
        scene.objects[0].proxy = Proxy::Count(4);
        let built = make(&scene).unwrap();
        assert_eq!(built.objects, [0, 0, 0, 0, 1]);
        assert!(built.self_distances[0] > 0.0);

        let folder = std::env::temp_dir().join(format!("lobes-blockers-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("set.json");
        scene.objects[0].proxy = Proxy::File { path: path.clone(), placement: Mat4::IDENTITY };
        assert!(matches!(make(&scene), Err(BlockersError::Read { .. })));
        std::fs::write(&path, "{}").unwrap();
        assert!(matches!(make(&scene), Err(BlockersError::Set { .. })));
        std::fs::remove_dir_all(&folder).unwrap();

        scene.objects[0].proxy = Proxy::Count(0);
        assert!(make(&scene).unwrap_err().to_string().contains("floor"));
    }

    #[test]
    fn a_set_goes_with_its_placed_mesh() {
        let folder = std::env::temp_dir().join(format!("lobes-placed-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
        write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let set = SphereSet::build(&positions, &triangles, &BuildOptions::draft(6)).unwrap();
        write("set.json", &set.to_json());
        let object = "[[objects]]\nmesh = \"m.obj\"\nproxy = { file = \"set.json\" }\nscale = 3\n\
                      rotate = { axis = [1, 2, 3], degrees = 40 }\ntranslate = [5, -1, 2]\n";
        let turn = Quat::from_axis_angle(Vec3::new(1.0, 2.0, 3.0).normalize(), 40_f32.to_radians());
        for keys in ["", "keys = [{ time = 0 }, { time = 1, translate = [5, 7, 2] }]\n"] {
            write("scene.toml", &format!("{object}{keys}"));
            let (mut scene, animation, _) = scene_files::load_animated(folder.join("scene.toml")).unwrap();
            let go = &mut |_: &str, _| ControlFlow::Continue(());
            let spheres = SceneSpheres::new(&scene, Some(&animation), |_| SphereSource::Proxy, go).unwrap();
            let mut out = BlockerSet::default();
            for time in if keys.is_empty() { vec![0.0] } else { vec![0.0, 0.5] } {
                animation.seek(time, &mut scene);
                spheres.pose(&scene, Some((&animation, time)), &mut out).unwrap();
                let there = Vec3::new(5.0, -1.0 + 8.0 * time, 2.0);
                for (own, placed) in set.spheres.iter().zip(&out.spheres) {
                    let want = turn * (3.0 * own.center) + there;
                    assert!(placed.center.distance(want) < 1e-5, "{time}: {} for {want}", placed.center);
                    assert!((placed.radius - 3.0 * own.radius).abs() < 1e-5, "{time}: {}", placed.radius);
                }
                assert_eq!((out.spheres.len(), out.self_shadows.len()), (6, 6));
                for (own, placed) in set.self_shadows.iter().zip(&out.self_shadows) {
                    assert!(placed.offset.distance(turn * own.offset) < 1e-5, "{time}: {placed:?} of {own:?}");
                    assert_eq!((placed.radius, placed.distance), (own.radius, own.distance));
                }
                assert!((out.self_distances[0] - 3.0 * set.self_distance).abs() < 1e-5);
            }
        }
        // The set of another mesh is none of a placed one either.
        write("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
        let scene = scene_files::load(folder.join("scene.toml")).unwrap();
        assert!(matches!(make(&scene), Err(BlockersError::Misfit { .. })));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
