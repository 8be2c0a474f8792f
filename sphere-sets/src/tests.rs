use glam::Vec3;
use lobe_core::{SelfShadow, Sphere};

use crate::shapes::{cube, scattered, sphere};
use crate::{BuildError, BuildOptions, SetQuality, SphereSet, Verdict, preview};

/// Options that are quick enough for many small builds.
fn few(count: usize) -> BuildOptions {
    BuildOptions { rounds: 1, ..BuildOptions::new(count) }
}

fn build(mesh: &(Vec<Vec3>, Vec<[u32; 3]>), options: &BuildOptions) -> SphereSet {
    SphereSet::build(&mesh.0, &mesh.1, options).expect("a mesh with area")
}

fn mapped(mesh: &(Vec<Vec3>, Vec<[u32; 3]>), map: impl Fn(Vec3) -> Vec3) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    (mesh.0.iter().map(|p| map(*p)).collect(), mesh.1.clone())
}

fn joined(parts: &[(Vec<Vec3>, Vec<[u32; 3]>)]) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut all = (Vec::new(), Vec::new());
    for (positions, triangles) in parts {
        let first = all.0.len() as u32;
        all.0.extend(positions);
        all.1.extend(triangles.iter().map(|t| t.map(|i| i + first)));
    }
    all
}

fn holds(set: &SphereSet, p: Vec3) -> bool {
    set.spheres.iter().any(|sphere| sphere.center.distance(p) <= sphere.radius)
}

#[test]
fn one_sphere_for_a_sphere_is_the_sphere() {
    let set = build(&sphere(16), &few(1));
    let [Sphere { center, radius }] = set.spheres[..] else { panic!("{} spheres", set.spheres.len()) };
    // The polyhedron lies between radii 1 and cos(edge/2) ≈ 0.996; a view's subpixel is 0.01 of the radius.
    assert!(center.length() < 0.004, "{center}");
    assert!((0.992..1.002).contains(&radius), "{radius}");
    assert!(set.quality.silhouette_error < 0.01, "{:?}", set.quality);
    assert!(set.quality.coverage > 0.985 && set.quality.protrusion_volume < 0.01, "{:?}", set.quality);
}

#[test]
fn quality_of_a_known_set_is_known() {
    // A sphere of radius 0.8 in one of radius 1: everything about it has a closed form. D = 2√3.
    let diagonal = 2.0 * 3.0_f32.sqrt();
    let (positions, triangles) = sphere(24);
    let measure = |center, radius| {
        SphereSet::measure(&positions, &triangles, &[Sphere { center, radius }]).expect("a mesh with area")
    };
    let inner = measure(Vec3::ZERO, 0.8);
    // 2¹⁷ low-discrepancy points: better than 1/√n = 0.003; the polyhedron's own volume is 0.4 % short.
    assert!((inner.quality.coverage - 0.512).abs() < 0.006, "{:?}", inner.quality);
    assert!((inner.quality.silhouette_error - 0.36).abs() < 0.005, "{:?}", inner.quality);
    assert!((inner.quality.p95_gap - 0.2 / diagonal).abs() < 1e-3, "{:?}", inner.quality);
    assert_eq!((inner.quality.hausdorff_outside, inner.quality.protrusion_volume), (0.0, 0.0));
    assert_eq!(inner.self_distance, 0.0);

    let outer = measure(Vec3::ZERO, 1.1);
    assert!((outer.quality.protrusion_volume - 0.331).abs() < 0.01, "{:?}", outer.quality);
    assert!((outer.quality.hausdorff_outside - 0.1 / diagonal).abs() < 2e-3, "{:?}", outer.quality);
    assert_eq!(outer.quality.coverage, 1.0);
    // τ = √(2·1.1·h) with the surface at depth 0.1 to 0.104.
    assert!((outer.self_distance - (2.2 * 0.102_f32).sqrt()).abs() < 0.01, "{}", outer.self_distance);
}

#[test]
fn a_cube_is_followed() {
    let set = build(&cube(), &few(32));
    assert_eq!(set.spheres.len(), 32);
    assert!(set.quality.silhouette_error < 0.06, "{:?}", set.quality);
    assert!(holds(&set, Vec3::ZERO));
    assert!(set.self_distance > 0.0 && set.self_distance < 0.5);
    let draft = build(&cube(), &BuildOptions::draft(32));
    assert!(draft.quality.silhouette_error > set.quality.silhouette_error, "{:?}", draft.quality);
}

/// Barycentric samples of all triangles, corners and edges among them: no code of the builder's.
fn surface_points(mesh: &(Vec<Vec3>, Vec<[u32; 3]>), n: u32) -> Vec<Vec3> {
    let steps = (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i as f32 / n as f32, j as f32 / n as f32)));
    let corners = |t: &[u32; 3]| t.map(|i| mesh.0[i as usize]);
    let each = |[a, b, c]: [Vec3; 3]| steps.clone().map(move |(u, v)| a + (b - a) * u + (c - a) * v);
    mesh.1.iter().flat_map(|t| each(corners(t))).collect()
}

#[test]
fn a_bounding_set_holds_every_point() {
    let options = |count| BuildOptions { bounding: true, ..few(count) };
    let two = joined(&[cube(), mapped(&cube(), |p| p * 0.3 + Vec3::new(2.0, 1.0, 0.0))]);
    let far = mapped(&cube(), |p| p * Vec3::new(3.0, 1.0, 0.2) + 1e4);
    let plate = mapped(&cube(), |p| p * Vec3::new(1.0, 1.0, 1e-3));
    let ellipsoid = mapped(&sphere(8), |p| p * Vec3::new(1.0, 0.5, 0.3));
    for (k, (mesh, count)) in [(ellipsoid, 24), (two, 16), (far, 12), (plate, 9)].into_iter().enumerate() {
        let set = build(&mesh, &options(count));
        assert!(set.spheres.len() <= count);
        // Against the one sphere that bounds the ellipsoid: (1/0.15 − 1) = 5.7.
        assert!(k != 0 || set.quality.protrusion_volume < 0.4, "{}", set.quality.protrusion_volume);
        for p in surface_points(&mesh, 40) {
            // The sample's own rounding.
            let gap = set
                .spheres
                .iter()
                .map(|sphere| sphere.center.distance(p) - sphere.radius)
                .fold(f32::INFINITY, f32::min);
            assert!(gap <= 2e-7 * p.abs().max_element(), "{p} is {gap} outside");
        }
    }
}

#[test]
fn a_sheet_has_no_bound() {
    let sheet = (vec![Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y], vec![[0, 1, 2], [0, 2, 3]]);
    let turned = mapped(&sheet, |p| glam::Quat::from_rotation_x(0.7) * p);
    for (positions, triangles) in [sheet, turned] {
        let options = BuildOptions { bounding: true, ..few(9) };
        assert_eq!(SphereSet::build(&positions, &triangles, &options), Err(BuildError::NoInside));
    }
}

#[test]
fn bad_sets_have_a_reason() {
    let quality = |silhouette_error| SetQuality { silhouette_error, ..SetQuality::default() };
    let bounding = BuildOptions { bounding: true, ..BuildOptions::new(64) };
    for (error, options, want) in [
        (0.1, BuildOptions::new(8), Verdict::Suits),
        (0.16, BuildOptions::new(64), Verdict::Unsuitable),
        // 0.3·(8/64)^0.66 = 0.08, 0.9·… = 0.23.
        (0.3, BuildOptions::new(8), Verdict::FewSpheres),
        (0.9, BuildOptions::new(8), Verdict::Unsuitable),
        (0.4, BuildOptions::draft(64), Verdict::Draft),
        (0.6, BuildOptions::draft(64), Verdict::Unsuitable),
        (0.3, bounding, Verdict::Bounding),
    ] {
        assert_eq!(quality(error).verdict(&options), want, "{error} {options:?}");
    }
    // The builder's verdict on a real sheet.
    let sheet = (vec![Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y], vec![[0, 1, 2], [0, 2, 3]]);
    let set = build(&sheet, &few(8));
    assert_eq!(set.quality.verdict(&few(8)), Verdict::Unsuitable, "{:?}", set.quality);
}

#[test]
fn more_spheres_are_better() {
    let errors = [4, 16, 64].map(|count| build(&cube(), &few(count)).quality.silhouette_error);
    assert!(errors[0] > 1.5 * errors[1] && errors[1] > 1.5 * errors[2], "{errors:?}");
}

#[test]
fn every_part_gets_spheres() {
    let small = mapped(&cube(), |p| p * 0.3 + Vec3::new(3.0, 0.0, 0.0));
    let mesh = joined(&[cube(), small]);
    let set = build(&mesh, &few(12));
    assert!(holds(&set, Vec3::ZERO) && holds(&set, Vec3::new(3.0, 0.0, 0.0)));
    assert!(!holds(&set, Vec3::new(1.6, 0.0, 0.0)));
    assert!(set.quality.silhouette_error < 0.15, "{:?}", set.quality);
}

/// Seat, back and four legs: slabs and thin parts get spheres, and the air under the seat none.
#[test]
fn a_chair_keeps_its_legs() {
    let part = |size: Vec3, at: Vec3| mapped(&cube(), |p| p * size + at);
    let legs = [(-0.23, -0.23), (-0.23, 0.23), (0.23, -0.23), (0.23, 0.23)];
    let mut parts: Vec<_> =
        legs.iter().map(|&(x, z)| part(Vec3::new(0.04, 0.42, 0.04), Vec3::new(x, 0.21, z))).collect();
    parts.push(part(Vec3::new(0.5, 0.04, 0.5), Vec3::new(0.0, 0.44, 0.0)));
    parts.push(part(Vec3::new(0.5, 0.5, 0.04), Vec3::new(0.0, 0.7, -0.23)));
    let set = build(&joined(&parts), &BuildOptions { rounds: 4, ..few(64) });
    for (x, z) in legs {
        let heights = (1..=40).map(|i| Vec3::new(x, 0.01 * i as f32, z));
        let held = heights.filter(|p| holds(&set, *p)).count();
        assert!(held >= 26, "{held} of 40 heights of the leg at {x}, {z}");
    }
    let under = (0..100).map(|i| scattered(i) * Vec3::new(0.3, 0.3, 0.3) + Vec3::new(0.0, 0.18, 0.0));
    assert_eq!(under.filter(|p| holds(&set, *p)).count(), 0);
    assert!(set.quality.silhouette_error < 0.15, "{:?}", set.quality);
}

#[test]
fn parts_smaller_than_a_voxel_are_found() {
    let speck = |at: Vec3| mapped(&cube(), |p| p * 0.004 + at);
    let corners = [Vec3::ZERO, Vec3::ONE, Vec3::X];
    let set = build(&joined(&corners.map(speck)), &few(6));
    for corner in corners {
        let nearest = set.spheres.iter().map(|sphere| sphere.center.distance(corner)).fold(f32::INFINITY, f32::min);
        assert!(nearest < 0.01, "{corner}: {nearest}");
    }
}

#[test]
fn winding_does_not_matter() {
    let mesh = sphere(8);
    let mesh = mapped(&mesh, |p| p * Vec3::new(1.0, 0.6, 0.4));
    let forward = build(&mesh, &few(6));
    let swap = |every: usize| {
        let turn = |(i, t): (usize, &[u32; 3])| if i % every == 0 { [t[1], t[0], t[2]] } else { *t };
        (mesh.0.clone(), mesh.1.iter().enumerate().map(turn).collect::<Vec<_>>())
    };
    for every in [1, 3] {
        assert_eq!(build(&swap(every), &few(6)), forward);
    }
}

#[test]
fn an_open_bowl_is_followed() {
    let (positions, triangles) = sphere(10);
    let lower = |t: &[u32; 3]| t.iter().all(|i| positions[*i as usize].y <= 1e-6);
    let bowl = (positions.clone(), triangles.iter().copied().filter(lower).collect::<Vec<_>>());
    assert_eq!(bowl.1.len() * 2, triangles.len());
    let set = build(&bowl, &BuildOptions { rounds: 8, ..few(24) });
    assert!(set.quality.silhouette_error < 0.08, "{:?}", set.quality);
    assert!(set.mesh_bounds[1].y < 0.01);
}

#[test]
fn a_sheet_without_volume_is_followed() {
    let sheet = (vec![Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y], vec![[0, 1, 2], [0, 2, 3]]);
    for mesh in [sheet.clone(), (sheet.0.clone(), vec![[0, 1, 2], [0, 2, 3], [0, 2, 1], [0, 3, 2]])] {
        let set = build(&mesh, &BuildOptions { rounds: 8, ..few(40) });
        assert!(set.quality.coverage > 0.7, "{:?}", set.quality);
        assert!(set.spheres.iter().all(|sphere| sphere.radius < 0.3));
    }
}

#[test]
fn any_soup_gives_a_set() {
    for seed in 0..3 {
        let corner = |i: usize| scattered(seed * 977 + i) * Vec3::new(1.0, 2.0, 0.5);
        let positions: Vec<Vec3> = (0..90).map(corner).collect();
        let triangles: Vec<[u32; 3]> = (0..60).map(|i| [i, (i * 7 + 3) % 90, (i * 13 + 11) % 90]).collect();
        let set = build(&(positions, triangles), &few(20));
        let finite = |sphere: &Sphere| sphere.center.is_finite() && sphere.radius.is_finite() && sphere.radius > 0.0;
        assert!(!set.spheres.is_empty() && set.spheres.iter().all(finite));
        assert!(set.quality.silhouette_error.is_finite() && set.quality.silhouette_error < 0.8, "{:?}", set.quality);
    }
}

#[test]
fn place_and_size_do_not_matter() {
    let shape = mapped(&sphere(8), |p| p * Vec3::new(1.0, 0.75, 0.5));
    let base = build(&shape, &few(6));
    for (scale, offset) in [(1e-4, Vec3::ZERO), (1e6, Vec3::ZERO), (1024.0, Vec3::new(1e5, -1e5, 1e5))] {
        let moved = build(&mapped(&shape, |p| p * scale + offset), &few(6));
        // Coordinates near 1e5 are rounded to 1/128, that is 1e-5 of the shape.
        assert!((moved.quality.silhouette_error - base.quality.silhouette_error).abs() < 0.01, "{:?}", moved.quality);
        assert!((moved.self_distance / scale - base.self_distance).abs() < 0.05 * base.self_distance);
    }
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| build(&cube(), &few(20)))
    };
    let one = on(1);
    assert_eq!(on(3), one);
    assert_eq!(build(&cube(), &few(20)), one);
    assert_ne!(build(&cube(), &BuildOptions { seed: 1, ..few(20) }).spheres, one.spheres);
}

#[test]
fn faults_of_the_mesh_are_named() {
    let refused = |positions: &[Vec3], triangles: &[[u32; 3]]| {
        SphereSet::build(positions, triangles, &few(4)).expect_err("a fault")
    };
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::NAN, Vec3::X * 2.0, Vec3::splat(f32::INFINITY)];
    assert_eq!(refused(&[], &[]), BuildError::EmptyMesh);
    assert_eq!(refused(&corners, &[]), BuildError::EmptyMesh);
    assert_eq!(refused(&corners, &[[0, 1, 3]]), BuildError::NonFiniteVertex { vertex: 3 });
    assert_eq!(refused(&corners, &[[0, 1, 5]]), BuildError::NonFiniteVertex { vertex: 5 });
    assert_eq!(
        refused(&corners, &[[0, 1, 2], [0, 1, 9]]),
        BuildError::VertexOutOfRange { triangle: 1, vertex: 9, vertices: 6 }
    );
    assert_eq!(refused(&corners, &[[0, 1, 4]]), BuildError::NoArea);
    assert_eq!(refused(&corners, &[[0, 0, 0], [1, 1, 2]]), BuildError::NoArea);
    assert_eq!(refused(&corners.map(|p| p * 1e-44), &[[0, 1, 2]]), BuildError::ExtentOutOfRange);
    let huge = [Vec3::splat(-3e38), Vec3::splat(3e38), Vec3::new(3e38, 0.0, 0.0)];
    assert_eq!(refused(&huge, &[[0, 1, 2]]), BuildError::ExtentOutOfRange);
    let none = SphereSet::build(&corners, &[[0, 1, 2]], &few(0));
    assert_eq!(none, Err(BuildError::NoSpheres));
    // A vertex that no triangle uses may be anything.
    assert!(SphereSet::build(&corners, &[[0, 1, 2]], &few(4)).is_ok());
}

#[test]
fn progress_rises_and_can_stop() {
    let (positions, triangles) = cube();
    let mut heard = Vec::new();
    let set = SphereSet::build_with_progress(&positions, &triangles, &few(8), &mut |done| {
        heard.push(done);
        core::ops::ControlFlow::Continue(())
    });
    assert!(set.is_ok());
    assert!(heard.len() >= 6 && heard.is_sorted() && heard.iter().all(|done| (0.0..=1.0).contains(done)), "{heard:?}");
    let stop = &mut |_| core::ops::ControlFlow::Break(());
    assert_eq!(SphereSet::build_with_progress(&positions, &triangles, &few(8), stop), Err(BuildError::Cancelled));
}

#[test]
fn the_preview_shows_where_mesh_and_set_differ() {
    let (positions, triangles) = cube();
    let sphere = Sphere { center: Vec3::new(0.5, 0.0, 0.0), radius: 0.5 };
    let set = SphereSet::measure(&positions, &triangles, &[sphere]).expect("a mesh with area");
    let picture = preview(&set, &positions, &triangles, 150).expect("a picture");
    // The first panel looks along −z: x from −0.5 to 1 over its width, with a margin of 1 % of D on either side.
    let scale = 150.0 / (1.5 + 0.02 * 3.0_f32.sqrt());
    let at = |x: f32, y: f32| {
        let pixel = |offset: f32| (12.0 + 75.0 + offset * scale) as u32;
        let color = picture.pixel(pixel(x - 0.25), pixel(-y)).expect("inside the picture");
        (color.red(), color.green(), color.blue(), color.alpha())
    };
    let (red, _, blue, alpha) = at(-0.4, 0.4);
    assert!(red > 200 && blue < 60 && alpha == 255, "mesh only");
    let (red, _, blue, _) = at(0.8, 0.0);
    assert!(red < 60 && blue > 200, "set only");
    let (red, green, blue, _) = at(0.25, 0.05);
    assert!(red.abs_diff(green) < 10 && red < 120 && blue < 130, "both");
    assert_eq!(at(0.9, 0.5), (255, 255, 255, 255), "neither");
}

#[test]
fn json_gives_the_same_set_back() {
    let set = build(&mapped(&cube(), |p| p * 0.1 + Vec3::splat(1.0 / 3.0)), &few(9));
    let text = set.to_json();
    assert_eq!(SphereSet::from_json(&text).expect("its own text"), set);
    let value: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(value["format"], "cosine-lobes sphere set");
    assert_eq!(value["version"], 1);
    assert_eq!(value["mesh"]["triangles"], 12);
    assert_eq!(value["spheres"].as_array().map(Vec::len), Some(9));
    assert_eq!(value["self_shadows"][0].as_array().map(Vec::len), Some(5));
    // Files from before near spheres had centres of their own.
    let mut old = value;
    old["self_shadows"] = vec![serde_json::json!([0.5, 0.25]); 9].into();
    let read = SphereSet::from_json(&old.to_string()).expect("what was written before").self_shadows;
    assert_eq!(read, [SelfShadow { radius: 0.5, ..SelfShadow::whole(0.25) }; 9]);
}

#[test]
fn a_set_for_another_mesh_is_told() {
    let mesh = cube();
    let set = build(&mesh, &BuildOptions::draft(2));
    assert_eq!(set.check_fits(&mesh.0, &mesh.1), Ok(()));
    let told = |mesh: &(Vec<Vec3>, Vec<[u32; 3]>)| set.check_fits(&mesh.0, &mesh.1).expect_err("a misfit").to_string();
    assert_eq!(told(&sphere(2)), "sphere set made for another mesh: it had 12 triangles, this one has 32");
    assert!(told(&mapped(&mesh, |p| p * 1.01)).contains("bounding box was (-0.5000, -0.5000, -0.5000)"));
    assert!(told(&mapped(&mesh, |p| p + Vec3::X)).contains("(1.5000, 0.5000, 0.5000)"));
    assert!(told(&mapped(&mesh, |p| p * f32::NAN)).contains("bounding box"));
    let mut stray = set.clone();
    stray.spheres[1].center.x = 3.0;
    let told = stray.check_fits(&mesh.0, &mesh.1).expect_err("a stray sphere").to_string();
    assert!(told.contains("sphere 1 is far outside"), "{told}");
}

#[test]
fn json_that_is_wrong_is_refused_in_one_line() {
    let good = build(&cube(), &few(2));
    let value: serde_json::Value = serde_json::from_str(&good.to_json()).expect("JSON");
    let with = |path: &str, new: serde_json::Value| {
        let mut value = value.clone();
        *value.pointer_mut(path).expect("a key of the format") = new;
        value.to_string()
    };
    let without = |key: &str| {
        let mut value = value.clone();
        value.as_object_mut().expect("an object").remove(key);
        value.to_string()
    };
    use serde_json::json;
    let cases = [
        (String::new(), "JSON"),
        ("[1, 2]".to_owned(), "format"),
        ("{\"spheres\": []}".to_owned(), "format"),
        (with("/format", json!("ply")), "format"),
        (with("/version", json!(2)), "version 2"),
        (with("/version", json!("1")), "version"),
        (with("/spheres/0/3", json!(-0.5)), "radius of sphere 0"),
        (with("/spheres/1/0", json!(null)), "centre of sphere 1"),
        (with("/spheres/1/3", json!(null)), "radius of sphere 1 is not a finite number"),
        (with("/spheres/1/3", json!(1e39)), "radius of sphere 1 is not a finite number"),
        (
            with("/spheres/1/3", json!("here")).replace("\"here\"", "Infinity"),
            "radius of sphere 1 is not a finite number",
        ),
        (with("/spheres/1/0", json!("here")).replace("\"here\"", "NaN"), "centre of sphere 1"),
        (with("/spheres/1/0", json!("here")).replace("\"here\"", "-Infinity"), "centre of sphere 1"),
        (with("/spheres/1/0", json!("1")), "sphere 1"),
        (with("/spheres/1/2", json!(1e39)), "centre of sphere 1"),
        (with("/spheres/0", json!([1.0, 2.0, 3.0])), "4"),
        (with("/spheres", json!([])), "no spheres"),
        (with("/self_distance", json!(-1.0)), "self_distance"),
        (with("/self_shadows/1", json!([0.5, 0.5, 0.5])), "self_shadow 1"),
        (with("/self_shadows/1", json!([0.0, 0.0, 0.6, 0.5, 0.5])), "reaches out"),
        (with("/self_shadows/1/3", json!(-0.5)), "radius of self_shadow 1"),
        (with("/self_shadows/1/4", json!(-0.5)), "distance of self_shadow 1"),
        (with("/self_shadows/1/0", json!(1e39)), "self_shadow 1"),
        (with("/quality/coverage", json!(true)), "boolean"),
        // Names of keys are quoted, even with control characters.
        (good.to_json().replacen("\"quality\"", "\"a\\nb\": 1, \"quality\"", 1), "unknown field"),
        (with("/quality/p95_gap", json!(-1.0)), "p95_gap"),
        (with("/mesh/bounds/0/0", json!(9.0)), "bounds"),
        (with("/mesh/triangles", json!(-1)), "-1"),
        (without("version"), "version"),
        (without("mesh"), "mesh"),
        (without("spheres"), "spheres"),
        (without("self_distance"), "self_distance"),
        (without("quality"), "quality"),
        (good.to_json().replace("\"self_distance\": ", "\"self_distance\": NaN, \"x\": "), "null"),
        (good.to_json().replacen("\"mesh\"", "\"colour\": 1, \"mesh\"", 1), "colour"),
    ];
    for (text, word) in cases {
        let message = SphereSet::from_json(&text).expect_err(word).to_string();
        assert!(message.contains(word) && !message.contains('\n'), "{word}: {message}");
    }
}
