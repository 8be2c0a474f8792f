//! Silhouettes replace shadow maps for objects that a map does not show and for receivers in the map.

use super::*;
use cosine_lobes::read_exr;

/// A floor, a wall whose plane goes through the light or near to its centre, and a block away from it.
const WALL: &str = r#"
[image]
width = 64
height = 36
[camera]
eye = [6.0, 5.0, 8.0]
target = [0.5, 0.5, 0.0]
fov = 40.0
[[objects]]
name = "floor"
plane = { point = [0.0, 0.0, 0.0], normal = [0.0, 1.0, 0.0], size = 40.0 }
[[objects]]
name = "wall"
quad = { center = [OFF, 1.5, 0.0], u = [0.0, 1.5, 0.0], v = [0.0, 0.0, 2.0] }
visibility = "STRATEGY"
[[objects]]
name = "block"
box = { center = [-2.5, 0.5, 0.0], size = [0.7, 1.0, 0.7] }
visibility = "STRATEGY"
[[lights]]
kind = "sphere"
center = [0.0, 5.0, 0.0]
radius = 1.0
radiance = 20.0
"#;

/// Mean and largest difference of two pictures over the brightest value.
fn apart(folder: &Path, a: &str, b: &str) -> [f32; 2] {
    let [a, b] = [a, b].map(|name| read_exr(&folder.join(name)).unwrap());
    let peak = a.pixels().iter().map(|p| p.max_element()).fold(0.0, f32::max);
    assert!(peak > 0.0);
    let each: Vec<f32> = a.pixels().iter().zip(b.pixels()).map(|(a, b)| (*a - *b).abs().max_element() / peak).collect();
    [each.iter().sum::<f32>() / each.len() as f32, each.iter().copied().fold(0.0, f32::max)]
}

/// Once 10 % of the light too much in the penumbra of the wall in the light's plane, which had no shadow at all, and up to 75 %
/// along the foot of the one beside it.
#[test]
fn walls_in_the_planes_of_the_light_have_their_shadows() {
    let folder = folder();
    let folder = folder.path();
    for off in ["0.0", "0.5", "-0.3"] {
        for strategy in ["shadow-map", "silhouettes"] {
            let scene = WALL.replace("OFF", off).replace("STRATEGY", strategy);
            fs::write(folder.join(format!("{strategy}.toml")), scene).unwrap();
            succeed(folder, &["render", &format!("{strategy}.toml"), "-q", "-o", &format!("{strategy}.exr")]);
        }
        let [mean, largest] = apart(folder, "silhouettes.exr", "shadow-map.exr");
        assert!(mean < 3e-5 && largest < 0.02, "{off}: {mean} {largest}");
    }
}

/// As a light moves past a wall, the wall is in the map, by silhouettes, and in the map again.
#[test]
fn what_maps_show_changes_with_the_light() {
    let folder = folder();
    let folder = folder.path();
    let keys = "keys = [{ time = 0, translate = [-3.0, 0.0, 0.0] }, { time = 1, translate = [3.0, 0.0, 0.0] }]\n";
    for strategy in ["shadow-map", "silhouettes"] {
        let scene = format!("{}{keys}", WALL.replace("OFF", "0.0").replace("STRATEGY", strategy));
        fs::write(folder.join(format!("{strategy}.toml")), format!("[animation]\nfps = 4\n{scene}")).unwrap();
        succeed(
            folder,
            // Along the foot of the wall, where outlines have points of their own, maps are less exact.
            &[
                "render",
                &format!("{strategy}.toml"),
                "--frames=0..5",
                "--samples=1",
                "-q",
                "-o",
                &format!("{strategy}.exr"),
            ],
        );
    }
    for frame in 0..5 {
        let [mean, largest] =
            apart(folder, &format!("silhouettes.{frame:04}.exr"), &format!("shadow-map.{frame:04}.exr"));
        assert!(mean < 1e-3 && largest < 0.1, "{frame}: {mean} {largest}");
        // One frame alone is as in the sequence.
        succeed(
            folder,
            &["render", "shadow-map.toml", "--frame", &frame.to_string(), "--samples=1", "-q", "-o", "one.exr"],
        );
        assert_eq!(apart(folder, "one.exr", &format!("shadow-map.{frame:04}.exr")), [0.0; 2]);
    }
}

/// A star of rays around a sphere, as an OBJ: spikes shadow each other and the sphere between them.
fn star() -> String {
    let (columns, rows) = (24, 12);
    let mut text = String::new();
    for j in 0..=rows {
        for i in 0..columns {
            let (turn, rise) =
                (std::f32::consts::TAU * i as f32 / columns as f32, std::f32::consts::PI * j as f32 / rows as f32);
            let radius = if (i + j) % 2 == 0 { 0.9 } else { 0.6 };
            let (x, y, z) = (turn.cos() * rise.sin(), rise.cos(), turn.sin() * rise.sin());
            text += &format!("v {} {} {}\n", radius * x, 1.0 + radius * y, radius * z);
        }
    }
    for j in 0..rows {
        for i in 0..columns {
            let at = |i: usize, j: usize| j * columns + i % columns + 1;
            text += &format!("f {} {} {}\n", at(i, j), at(i + 1, j), at(i + 1, j + 1));
            text += &format!("f {} {} {}\n", at(i, j), at(i + 1, j + 1), at(i, j + 1));
        }
    }
    text
}

/// Receivers on a mesh in a map use silhouettes: with the map alone 99 % of a bunny's penumbra were within 13 % of the light,
/// in dots and fringes. Receivers on the floor below use the map.
#[test]
fn meshes_that_shadow_themselves() {
    let folder = folder();
    let folder = folder.path();
    fs::write(folder.join("star.obj"), star()).unwrap();
    let scene = SCENE.replace("sphere = { center = [0.0, 1.0, 0.0], radius = 0.6 }", "mesh = \"star.obj\"");
    fs::write(folder.join("star.toml"), scene).unwrap();
    for strategy in ["shadow-map", "silhouettes"] {
        let output = format!("{strategy}.exr");
        succeed(folder, &["render", "star.toml", "--size", "96x64", "--visibility", strategy, "-q", "-o", &output]);
    }
    let [mean, largest] = apart(folder, "silhouettes.exr", "shadow-map.exr");
    assert!(mean < 1e-4 && largest < 0.01, "{mean} {largest}");
}
