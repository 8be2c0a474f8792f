//! A scene with meshes, an exact sphere and two lights, written in many ways that must all look the same.

use glam::{DMat3, DVec3};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

const ASSETS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/assets");

/// A change that must not change the picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Change {
    pub(crate) name: &'static str,
    /// Size of everything.
    pub(crate) scale: f64,
    pub(crate) moved: DVec3,
    /// Degrees about an axis that is no axis of anything.
    pub(crate) turned: f64,
    /// The picture is mirrored as well.
    pub(crate) mirrored: bool,
    /// Objects, lights and triangles in another order.
    pub(crate) permuted: bool,
    /// Each light twice, with half the radiance.
    pub(crate) split: bool,
    /// Each blocker twice.
    pub(crate) doubled: bool,
}

const NONE: Change = Change {
    name: "none",
    scale: 1.0,
    moved: DVec3::ZERO,
    turned: 0.0,
    mirrored: false,
    permuted: false,
    split: false,
    doubled: false,
};

pub(crate) const CHANGES: [Change; 16] = [
    NONE,
    Change { name: "scale 1e-6", scale: 1e-6, ..NONE },
    Change { name: "scale 1e-3", scale: 1e-3, ..NONE },
    Change { name: "scale 1e3", scale: 1e3, ..NONE },
    Change { name: "scale 1e6", scale: 1e6, ..NONE },
    Change { name: "move 1", moved: DVec3::new(1.0, -0.3, 0.7), ..NONE },
    Change { name: "move 1e3", moved: DVec3::new(1e3, -300.0, 700.0), ..NONE },
    Change { name: "move 1e5", moved: DVec3::new(-1e5, 1e5, 3e4), ..NONE },
    Change { name: "move 1e6", moved: DVec3::new(1e6, 3e5, -7e5), ..NONE },
    Change { name: "rotate 137°", turned: 137.0, ..NONE },
    Change { name: "rotate 0.01°", turned: 0.01, ..NONE },
    Change { name: "mirror", mirrored: true, ..NONE },
    Change { name: "permute", permuted: true, ..NONE },
    Change { name: "split lights", split: true, ..NONE },
    Change { name: "double blockers", doubled: true, ..NONE },
    Change {
        name: "all of them",
        scale: 1e-3,
        moved: DVec3::new(1e3, 300.0, -700.0),
        turned: 71.0,
        mirrored: true,
        permuted: true,
        split: true,
        ..NONE
    },
];

impl Change {
    fn linear(&self) -> DMat3 {
        let axis = DVec3::new(0.48, 0.6, 0.64).normalize();
        let mirror = if self.mirrored { DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)) } else { DMat3::IDENTITY };
        DMat3::from_axis_angle(axis, self.turned.to_radians()) * mirror
    }

    fn point(&self, p: DVec3) -> String {
        let p = self.scale * (self.linear() * p) + self.moved;
        format!("[{:?}, {:?}, {:?}]", p.x, p.y, p.z)
    }

    fn vector(&self, v: DVec3) -> String {
        let v = self.scale * (self.linear() * v);
        format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z)
    }

    fn matrix(&self, size: f64, degrees: f64, to: DVec3) -> String {
        let linear = self.linear() * DMat3::from_rotation_y(degrees.to_radians()) * (size * self.scale);
        let moved = self.scale * (self.linear() * to) + self.moved;
        let row = |k: usize| {
            let r = linear.row(k);
            format!("[{:?}, {:?}, {:?}, {:?}]", r.x, r.y, r.z, moved[k])
        };
        format!("[{}, {}, {}, [0, 0, 0, 1]]", row(0), row(1), row(2))
    }

    /// The text of the scene file, in whose folder meshes with other orders of triangles are written.
    pub(crate) fn scene(&self, folder: &Path) -> String {
        let v = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let mesh = |name: &str, size: f64, degrees: f64, to: DVec3, proxy: &str| {
            let file = if self.permuted { permuted(folder, name) } else { format!("{ASSETS}/{name}.obj") };
            format!(
                "[[objects]]\nname = \"{name}\"\nmesh = \"{file}\"\nnormals = \"smooth\"\nmaterial = \"skin\"\n\
                 matrix = {}\nproxy = {{ explicit = {proxy} }}\n",
                self.matrix(size, degrees, to)
            )
        };
        let mut blockers = vec![
            mesh(
                "spot",
                0.7,
                200.0,
                v(-0.6, 0.52, 0.0),
                "[[0, 0.1, 0.2, 0.45], [0, 0.5, -0.5, 0.28], [0, -0.3, 0.5, 0.3], [0.1, -0.4, -0.2, 0.25]]",
            ),
            mesh("moebius", 0.5, 30.0, v(0.9, 0.6, 0.2), "[[0.9, 0, 0, 0.3], [-0.9, 0, 0, 0.3], [0, 0, 0.9, 0.3]]"),
            format!(
                "[[objects]]\nname = \"ball\"\nsphere = {{ center = {}, radius = {:?} }}\nmaterial = \"skin\"\n",
                self.point(v(0.2, 0.25, 0.9)),
                0.25 * self.scale
            ),
        ];
        if self.doubled {
            blockers.extend(blockers.clone());
        }
        blockers.push(format!(
            "[[objects]]\nname = \"floor\"\nquad = {{ center = {}, u = {}, v = {} }}\nmaterial = \"floor\"\n",
            self.point(DVec3::ZERO),
            self.vector(v(0.0, 0.0, 30.0)),
            self.vector(v(30.0, 0.0, 0.0))
        ));
        let light = |center: DVec3, radius: f64, radiance: f64| {
            let (count, radiance) = if self.split { (2, 0.5 * radiance) } else { (1, radiance) };
            format!(
                "[[lights]]\nkind = \"sphere\"\ncenter = {}\nradius = {:?}\nradiance = {radiance:?}\n",
                self.point(center),
                radius * self.scale
            )
            .repeat(count)
        };
        let mut lights = [light(v(-3.0, 5.0, 3.2), 0.638, 100.0), light(v(3.0, 4.0, 2.2), 0.2, 300.0)];
        if self.permuted {
            blockers.reverse();
            lights.reverse();
        }
        format!(
            "[image]\nwidth = 64\nheight = 36\n[camera]\neye = {}\ntarget = {}\nup = {}\nfov = 27\n\
             [materials.floor]\nmodel = \"modified-phong\"\nkd = 0.36\nks = 0.25\nexponent = 80\n\
             [materials.skin]\nmodel = \"modified-phong\"\nkd = 0.5\nks = 0.1\nexponent = 30\n{}{}",
            self.point(v(1.2, 3.2, 5.4)),
            self.point(v(0.1, 0.6, 0.15)),
            self.vector(DVec3::Y / self.scale),
            blockers.concat(),
            lights.concat()
        )
    }
}

/// A mesh with its triangles in another order; the name of its file.
fn permuted(folder: &Path, name: &str) -> String {
    let text = fs::read_to_string(format!("{ASSETS}/{name}.obj")).unwrap();
    let (faces, rest): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| line.starts_with("f "));
    let mut out = rest.join("\n");
    // A step that is prime to the count visits all.
    let step = (faces.len() / 3..).find(|s| gcd(*s, faces.len()) == 1).unwrap();
    for k in 0..faces.len() {
        write!(out, "\n{}", faces[k * step % faces.len()]).unwrap();
    }
    let file = format!("{name}.obj");
    fs::write(folder.join(&file), out + "\n").unwrap();
    file
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}
