//! The growth of the time with spheres, lights and the size of a light.

use crate::blob::blob;
use crate::measure::{How, Timing, frames};
use crate::scenes::{cube, diffuse, far_light, floor_scene, light, spiral_lights};
use crate::sets::add_spheres;
use cosine_lobes::render_cpu::{GBuffer, World};
use cosine_lobes::scene::{BlockerSet, Scene};
use glam::Vec3;

/// A series of scenes that differ in one number.
pub(crate) struct Curve {
    pub(crate) name: &'static str,
    pub(crate) note: &'static str,
    /// The meaning of the number.
    pub(crate) of: &'static str,
    make: fn(f32) -> (Scene, BlockerSet),
    values: Vec<f32>,
}

/// Its times.
pub(crate) struct Measured {
    pub(crate) curve: Curve,
    pub(crate) timings: Vec<Timing>,
}

pub(crate) fn all() -> Vec<Curve> {
    vec![
        Curve {
            name: "Spheres",
            note: "one blob of equal coverage over a floor (goal: 64 → 4096 spheres ≤ 4 × the time)",
            of: "spheres",
            make: |count| blob_scene(&blob(count as usize)),
            values: vec![64.0, 256.0, 1024.0, 4096.0],
        },
        Curve {
            name: "Fig. 20, lights",
            note: "a cube of 64 spheres; the paper: linear, 800 ms at 50 (end of its axis)",
            of: "lights",
            make: |count| cube(spiral_lights(count as usize)),
            values: vec![1.0, 4.0, 12.0, 25.0, 50.0],
        },
        Curve {
            name: "Fig. 17, area of the light",
            note: "a cube of 64 spheres, the light 20 units away; the paper: 450 ms at 0.5 to 1200 ms at 227 (its axes)",
            of: "area",
            make: |area| cube(vec![far_light(area)]),
            values: vec![0.5, 45.8, 91.1, 136.4, 181.7, 227.0],
        },
    ]
}

fn blob_scene(spheres: &[cosine_lobes::lobe_core::Sphere]) -> (Scene, BlockerSet) {
    let lights = vec![light(Vec3::new(1.0, 4.6, 0.5), 0.5)];
    let scene = floor_scene(Vec3::new(0.0, 4.0, 3.0), Vec3::ZERO, 24.0, diffuse(), lights);
    let mut blockers = BlockerSet::default();
    add_spheres(&mut blockers, 1, spheres);
    (scene, blockers)
}

pub(crate) fn measure(curve: Curve, repeats: usize) -> Result<Measured, String> {
    eprintln!("{}", curve.name);
    let one = |value: &f32| {
        let (scene, blockers) = (curve.make)(*value);
        let points = GBuffer::new(&World::new(&scene), 256, 256, 1).points;
        frames(&scene, &blockers, &points, How::default(), repeats).map(|(timing, _)| timing)
    };
    let timings = curve.values.iter().map(one).collect::<Result<_, _>>()?;
    Ok(Measured { curve, timings })
}

impl Measured {
    /// Each number with its time.
    pub(crate) fn points(&self) -> impl Iterator<Item = (f32, &Timing)> {
        self.curve.values.iter().copied().zip(&self.timings)
    }
}
