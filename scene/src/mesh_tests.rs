use crate::Mesh;
use core::f32::consts::FRAC_1_SQRT_2;
use glam::{Mat4, Quat, Vec3};

/// The cube of half side 1, with eight vertices and no normals.
fn cube() -> Mesh {
    let corner = |i: u32| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32) * 2.0 - 1.0;
    let faces = [[0_u32, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { positions: (0..8).map(corner).collect(), triangles, ..Mesh::default() }
}

#[test]
fn smooth_normals_are_weighted_by_angle_not_by_triangle_count() {
    // Each face of the cube is cut into two triangles: weights by area or by count would lean toward the faces that
    // have two triangles at a corner; by angle the corner's normal is its diagonal.
    let mut mesh = cube();
    mesh.smooth_normals();
    for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
        assert!((*n - p.normalize()).length() < 1e-6, "{p} {n}");
    }
}

#[test]
fn seams_are_smoothed_over_and_cancelling_normals_stay_finite() {
    // The same corner as two vertices, at a seam.
    let mut mesh = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, -Vec3::ZERO, Vec3::Y, Vec3::Z],
        normals: Vec::new(),
        triangles: vec![[0, 1, 2], [3, 4, 5]],
        ..Mesh::default()
    };
    mesh.smooth_normals();
    assert_eq!(mesh.normals[0], mesh.normals[3]);
    assert!((mesh.normals[2] - Vec3::new(FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2)).length() < 1e-6);
    // Two triangles back to back.
    mesh.positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y];
    mesh.triangles = vec![[0, 1, 2], [0, 2, 1]];
    mesh.smooth_normals();
    assert!(mesh.normals.iter().all(|n| (n.z.abs() - 1.0).abs() < 1e-6), "{:?}", mesh.normals);
    mesh.validate().unwrap();
}

#[test]
fn transforms_keep_normals_perpendicular_and_outward() {
    let matrices = [
        Mat4::from_scale_rotation_translation(Vec3::new(1.0, 3.0, 0.2), Quat::from_rotation_x(0.7), Vec3::ONE),
        Mat4::from_scale(Vec3::new(-1.0, 2.0, 1.0)),
        Mat4::from_cols_array(&[1., 0., 0., 0., 0.5, 1., 0., 0., 0., 0.3, 1., 0., 0., 0., 0., 1.]),
    ];
    for matrix in matrices {
        let mut mesh = Mesh::cuboid(Vec3::ZERO, Vec3::ONE);
        // Face normals at split corners.
        mesh.normals = mesh
            .triangles
            .chunks(2)
            .flat_map(|t| {
                let [a, b, c] = t[0].map(|i| mesh.positions[i as usize]);
                [(b - a).cross(c - a).normalize(); 4]
            })
            .collect();
        mesh.transform(&matrix);
        mesh.validate().unwrap();
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
            let face = (b - a).cross(c - a).normalize();
            assert!(face.dot(mesh.normals[t[0] as usize]) > 0.9999, "{matrix}");
        }
        let p = |i: u32| mesh.positions[i as usize].as_dvec3();
        let volume: f64 = mesh.triangles.iter().map(|&[a, b, c]| p(a).dot(p(b).cross(p(c))) / 6.0).sum();
        assert!((volume - f64::from(matrix.determinant().abs())).abs() < 1e-5);
    }
}

#[test]
fn a_singular_transform_gives_finite_normals() {
    let mut mesh = cube();
    mesh.smooth_normals();
    for scale in [Vec3::new(1.0, 0.0, 1.0), Vec3::new(1.0, 0.0, 0.0), Vec3::ZERO] {
        let mut flat = mesh.clone();
        flat.transform(&Mat4::from_scale(scale));
        assert!(flat.normals.iter().all(|n| n.is_finite() && (n.length() - 1.0).abs() < 1e-5), "{scale}");
    }
}

#[test]
fn validation_names_the_fault() {
    let good = Mesh { positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y], triangles: vec![[0, 1, 2]], ..Mesh::default() };
    good.validate().unwrap();
    let fault = |change: &dyn Fn(&mut Mesh)| {
        let mut mesh = good.clone();
        change(&mut mesh);
        mesh.validate().unwrap_err().to_string()
    };
    assert!(fault(&|m| m.triangles.clear()).contains("no triangles"));
    assert!(fault(&|m| m.triangles[0][2] = 3).contains("vertex 3 of 3"));
    assert!(fault(&|m| m.positions[1].y = f32::NAN).contains("vertex 1"));
    assert!(fault(&|m| m.normals.push(Vec3::X)).contains("1 normals for 3"));
    assert!(fault(&|m| m.normals = vec![Vec3::X, Vec3::X, Vec3::ZERO]).contains("normal 2"));
}

/// In any orientation, with shared vertices or not; in a mesh that moves only with shared vertices.
#[test]
fn triangles_in_one_place_are_one() {
    let cube = cube();
    assert_eq!(cube.triangles.len(), 12);
    let count = cube.positions.len() as u32;
    let mut many = cube.clone();
    many.positions.extend(cube.positions.clone());
    many.triangles.extend(cube.triangles.iter().map(|t| t.map(|i| i + count)));
    many.triangles.extend(cube.triangles.iter().map(|&[a, b, c]| [b, a, c]));
    many.triangles.extend(cube.triangles.iter().map(|&[a, b, c]| [c, a, b]));
    let mut moving = many.clone();
    assert_eq!(many.remove_doubles(false), 36);
    assert_eq!(many.triangles, cube.triangles);
    assert_eq!(moving.remove_doubles(true), 24);
    assert_eq!(moving.triangles[..12], cube.triangles);
    assert!(moving.triangles[12..].iter().flatten().all(|i| *i >= count));
}

/// Triangles among few vertices, of which many lie in one place: the first in each place stays, in the order that they had.
#[test]
fn the_first_triangle_in_each_place_stays() {
    let mut state = 1_u32;
    let mut number = |below: u32| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) % below
    };
    let positions: Vec<Vec3> = (0..40).map(|_| Vec3::new(number(5) as f32 - 2.0, 0.0, number(4) as f32)).collect();
    let triangles: Vec<[u32; 3]> = (0..3000).map(|_| [number(40), number(40), number(40)]).collect();
    let mesh = Mesh { positions, triangles, ..Mesh::default() };
    for moves in [false, true] {
        let mut seen = std::collections::HashSet::new();
        let mut wanted = mesh.triangles.clone();
        wanted.retain(|t| {
            let mut key = t.map(|i| if moves { Vec3::X * i as f32 } else { mesh.positions[i as usize] });
            key.sort_by(|a, b| a.to_array().partial_cmp(&b.to_array()).expect("numbers"));
            seen.insert(key.map(|p| p.to_array().map(|x| (x + 0.0).to_bits())))
        });
        let mut own = mesh.clone();
        assert_eq!(own.remove_doubles(moves), mesh.triangles.len() - wanted.len());
        assert!(own.triangles == wanted && wanted.len() < 3000);
    }
}
